"""The recipes of CONTRIBUTING, followed in a copy of the tree: a row and a file, and all rooms know the new thing."""

import os
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

pytestmark = pytest.mark.slow  # each in processes of its own; by day test_extensions.py has a study of another tree
ROOT = Path(__file__).resolve().parents[1]
CELL = "dict(mass=1.0, stiffness=2.0, normal_load=3.0, belt_speed=0.1, a1=1.0, a2=0.1, a3=0.3, a4=0.1)"
CONFIG = (
    "dict(system=dict(mass=1, stiffness=2, normal_load=3, belt_speed=0.1), friction=dict(a1=1, a2=0.1, a3=0.3, a4=0.1))"
)


PACE = (ROOT / "tests/data/pace.py").read_text(encoding="utf-8")
STUDY_ROW = (
    "STUDIES: dict[str, StudyEntry] = {",
    '\n    "pace": StudyEntry("stickslip.studies.pace:PaceStudy", "Find how fast cells move."),',
)


class Copy:
    """A copy of the packages, to be changed and run."""

    def __init__(self, folder, packages):
        self._folder = folder
        for package in packages:
            shutil.copytree(ROOT / package, folder / package, ignore=shutil.ignore_patterns("__pycache__"))
        roots = [folder / name if name in packages else ROOT / name for name in ("sweep", "kernels")]
        self._environment = os.environ | {"PYTHONPATH": os.pathsep.join(map(str, roots))}

    def insert(self, file, after, text):
        """Put `text` behind the one place of a file where `after` stands."""
        path = self._folder / file
        before = path.read_text(encoding="utf-8")
        assert before.count(after) == 1, f"{file}: {after!r} stands there {before.count(after)} times"
        path.write_text(before.replace(after, after + text), encoding="utf-8")

    def write(self, file, text):
        (self._folder / file).write_text(text, encoding="utf-8")

    def run(self, code):
        done = subprocess.run([sys.executable, "-c", code], env=self._environment, capture_output=True, text=True)
        assert done.returncode == 0, done.stderr


@pytest.fixture
def copy(tmp_path):
    return Copy(tmp_path, ["sweep"])


def test_a_unit_a_metric_and_a_law_are_a_row_each(copy):
    """And a conversion: how far the belt moves in a cycle."""
    copy.insert("sweep/stickslip/vocabulary/units.py", "\n_KINDS = {", '\n    "Pa": ("a pressure", "2 bar"),')
    row = '\n    Variable("belt_travel", "m", "travel of the belt in a cycle"),'
    copy.insert("sweep/stickslip/vocabulary/quantities.py", "\nVARIABLES: dict[str, Variable] = table(", row)
    conversion = '\n    "belt_travel": lambda rows, by: rows[layout.PERIOD] * by.time * by.cells["belt_speed"],'
    copy.insert("sweep/stickslip/engine/dispatch.py", "the models have the rest", conversion)
    copy.insert("sweep/stickslip/vocabulary/models/stribeck.py", 'with a2 = 0",', '\n    "halving": "1/(1 + w/a4)",')
    copy.run(f"""
import numpy as np
import stickslip
from stickslip.config.reader import make_config
from stickslip.config.describe import json_schema
from stickslip.errors import QuantityError
from stickslip.vocabulary import units
assert units.si_value("2 bar", "Pa") == 2e5 and units.expected("Pa") == "a pressure such as '2 bar' or a number in Pa"
try:
    units.si_value("1 mm", "Pa")
except QuantityError as error:
    assert error.kind == "length"
found = stickslip.evaluate({CELL})
assert found["belt_travel"].attrs["units"] == "m"
np.testing.assert_allclose(found["belt_travel"], 0.1 * found["period"], rtol=1e-15)
assert stickslip.run(make_config({CONFIG} | dict(axes=dict(damping=[0, 1]))))["belt_travel"].shape == (2,)
assert make_config({CONFIG.replace("friction=dict(", "friction=dict(law='halving', ")}).friction.law == "halving"
assert "halving" in json_schema()["properties"]["friction"]["properties"]["law"]["anyOf"][0]["enum"]
""")


def test_a_new_parameter_is_one_row_and_its_conversion(copy):
    """The share of the load that the contact carries: half of it is half the load."""
    row = '\n    Parameter("share", "1", "share of the load", "system", default=1.0, above=0, at_most=1),'
    copy.insert("sweep/stickslip/vocabulary/quantities.py", "_BODY = table(", row)
    copy.insert("sweep/stickslip/vocabulary/models/model.py", 'self.load = cells["normal_load"]', ' * cells["share"]')
    copy.run(f"""
import numpy as np
import stickslip
from stickslip.config.grid import build_grid
from stickslip.config.reader import make_config
from stickslip.config.describe import json_schema
from stickslip.errors import ConfigError
data = {CONFIG}
assert build_grid(make_config(data)).fixed["share"] == 1.0
data["system"]["share"] = 2
try:
    make_config(data)
except ConfigError as error:
    assert "system.share: got 2, expected a number above 0 and of at most 1" in str(error), error
del data["system"]["share"]
config = make_config(data | dict(axes=dict(share=[0.5, 1])))
assert make_config(config.resolved()) == config
schema = json_schema()["properties"]["system"]["properties"]["share"]
assert (schema["maximum"], schema["default"], schema["description"]) == (1, 1.0, "share of the load")
found = stickslip.run(config)
assert found["share"].attrs["long_name"] == "share of the load" and found.sizes == dict(share=2)
half, same = stickslip.evaluate({CELL} | dict(share=0.5)), stickslip.evaluate({CELL} | dict(normal_load=1.5))
for name in ("period", "spring_force_max"):
    np.testing.assert_array_equal(half[name], same[name])
    np.testing.assert_array_equal(half[name], found[name][:1])
""")
    copy.run(f"""
import numpy as np
import stickslip
from stickslip.engine import compute_rigs, Options, Sampling, stop_flag
from stickslip.vocabulary.cells import as_cells
damped, box = dict({CELL}, damping=0.05, belt_speed=0.4), dict(displacement=(0.0, 3.0), velocity=(-1.0, 1.0))
drive = [np.array([[5.0, 0.0, 0.1], [5.0, 0.5, 0.0]])]
calls = dict(
    simulate=lambda load: stickslip.simulate(duration=20.0, samples=50, **({CELL} | load)),
    border=lambda load: stickslip.border({CELL} | load, "belt_speed", (0.01, 2.0)),
    attractors=lambda load: stickslip.attractors(damped | load, box),
    ramp=lambda load: stickslip.ramp(damped | load, "belt_speed", (0.1, 1.0), 6),
)
for call, compute in calls.items():
    half, same = compute(dict(share=0.5)), compute(dict(normal_load=1.5))
    for name in same.data_vars:
        np.testing.assert_array_equal(half[name], same[name], err_msg=call + " " + name)
half, same = (compute_rigs(as_cells({CELL} | load), drive, Sampling(10.0, np.zeros(1)), Options(), stop_flag())
              for load in (dict(share=0.5), dict(normal_load=1.5)))
for one, other in ((half.results, same.results), (half.signals[0], same.signals[0])):
    for name in other:
        np.testing.assert_array_equal(one[name], other[name], err_msg="rig " + name)
""")


def test_a_new_study_is_a_file_and_its_row(copy, tmp_path):
    """It is read, computed, resumed, told, drawn and put on a page, and has a command, an entry in the schema and in
    the help."""
    copy.write("sweep/stickslip/studies/pace.py", PACE)
    copy.insert("sweep/stickslip/vocabulary/quantities.py", *STUDY_ROW)
    (tmp_path / "pace.yaml").write_text(
        "system: {mass: 1, stiffness: 2, normal_load: 3}\nfriction: {a1: 1, a2: 0.1, a3: 0.3, a4: 0.1}\n"
        "axes:\n  belt_speed: {start: 0.1, stop: 0.5, num: 9}\n  damping: {start: 0, stop: 0.5, num: 7}\n"
    )
    copy.run(f"""
import os
import numpy as np
from click.testing import CliRunner
import stickslip
from stickslip import plots
from stickslip.cli import main
from stickslip.config.reader import load_config, make_config
from stickslip.config.describe import json_schema
from stickslip.errors import ConfigError
from stickslip.plots.pages import pictures_of, result_page
from stickslip.runs import work
os.chdir({str(tmp_path)!r})
def told(*words):
    done = CliRunner().invoke(main, words)
    assert done.exit_code == 0, (words, done.output, done.exception)
    return done.output
assert json_schema()["properties"]["pace"]["properties"]["factor"]["exclusiveMinimum"] == 0
assert "--squared" in (shown := told("pace", "--help")) and "its numbers (factor)" in " ".join(shown.split())
assert "pace" in told("--help")
assert "fastest" in told("pace", "pace.yaml", "--set", "pace.factor=3", "-o", "pace.nc", "--plot", "pace.png")
fast = stickslip.open("pace.nc")
assert fast.attrs["result"] == plots.kind_of(fast) == "pace" and os.path.getsize("pace.png") > 1000
plain = make_config(load_config("pace.yaml").resolved() | dict(pace=dict(factor=3.0)))
assert plain.study.factor == 3.0 and make_config(plain.resolved()) == plain
np.testing.assert_array_equal(stickslip.run(plain)["pace"], fast["pace"])
work._FEWEST = 8  # cells a block
stickslip.run_shard(plain, "1/2", "store")
assert np.isnan(stickslip.collect("store", "half.nc")["pace"]).any()
stickslip.run_shard(plain, "2/2", "store")
np.testing.assert_array_equal(stickslip.collect("store", "half.nc")["pace"], fast["pace"])
assert "fastest" in told("inspect", "pace.nc") and "plot " in told("plot", "pace.nc", "-o", "again.png")
assert fast.stickslip.plot().axes
assert "largest slip speed, times a factor" in result_page(fast, pictures_of(fast))
try:
    make_config(plain.resolved() | dict(pace=dict(factor=0)))
except ConfigError as error:
    assert "pace.factor: got 0, expected a number above 0" in str(error), error
""")


@pytest.mark.slow
def test_a_law_with_a_shape_of_its_own_is_a_file_and_its_row(tmp_path):
    """The Lorentzian of tests/data/lorentzian.py; its slip is held against SciPy."""
    copy = Copy(tmp_path, ["sweep", "kernels"])
    contact = "kernels/stickslip_kernels/contacts/stribeck"
    shutil.copy(ROOT / "tests/data/lorentzian.py", tmp_path / contact)
    copy.insert(f"{contact}/__init__.py", 'law of a table\n"""\n', "\nfrom . import lorentzian\n")
    row = '\n    "lorentzian": "1/(1 + (w/a4)^2), the law of Hess and Soom (1990)",'
    copy.insert("sweep/stickslip/vocabulary/models/stribeck.py", 'with a2 = 0",', row)
    copy.run("""
import stickslip
pair = {"mass": 1.0, "stiffness": 1.0, "normal_load": 1.0, "a1": 0.2, "a2": 0.02, "a3": 0.1, "a4": 0.1}
found = stickslip.evaluate(pair | {"belt_speed": [0.02, 0.1, 2.0]}, law="lorentzian")
import numpy as np
from scipy.integrate import solve_ivp
from scipy.optimize import brentq
assert found["regime"].values.tolist() == [1, 1, 2], found["regime"].values
for belt, breakaway, restick in zip([0.02, 0.1], found["breakaway_time"].values, found["restick_time"].values):
    def slip(t, y):
        w = max(belt - y[1], 0.0)
        return y[1], 0.2 + 0.02 * w + 0.1 / (1 + (w / 0.1) ** 2) - y[0]
    stops = lambda t, y: belt - y[1] if t > 1.0 else 1.0
    stops.terminal, stops.direction = True, -1
    motion = solve_ivp(slip, (0, 50), (0.3 + 1e-9, belt), method="DOP853", rtol=1e-12, atol=1e-14, events=stops)
    np.testing.assert_allclose(restick - breakaway, motion.t_events[0][0], rtol=1e-5)
z = brentq(lambda z: 0.02 - 2 * z / (1 + z * z) ** 2, 3.0**-0.5, 50)  # where the curve is lowest
near = stickslip.evaluate(pair | dict(belt_speed=[0.099 * z, 0.101 * z]), law="lorentzian")["damping_ratio"].values
assert near[0] < 0 < near[1]
""")


def test_a_contact_with_an_inner_state_is_a_file_of_the_kernels_and_one_of_its_model(tmp_path):
    """Dahl's, whose motion is held against SciPy."""
    copy = Copy(tmp_path, ["sweep", "kernels"])
    contacts, models = tmp_path / "kernels/stickslip_kernels/contacts", tmp_path / "sweep/stickslip/vocabulary/models"
    shutil.copy(ROOT / "tests/data/dahl/contact.py", contacts / "dahl.py")
    shutil.copy(ROOT / "tests/data/dahl/model.py", models / "dahl.py")
    copy.insert("kernels/stickslip_kernels/objects.py", "CONTACTS = {", '"dahl": "dahl", ')
    copy.insert("sweep/stickslip/vocabulary/models/__init__.py", "= (STRIBECK,", " DAHL,")
    copy.insert(
        "sweep/stickslip/vocabulary/models/__init__.py", "OF_ANY_SHAPE, STRIBECK\n",
        "from stickslip.vocabulary.models.dahl import DAHL\n",
    )  # fmt: skip
    copy.run("""
import numpy as np
import stickslip
from scipy.integrate import solve_ivp
from stickslip.config.reader import make_config
cell = dict(mass=2.0, stiffness=50.0, damping=1.0, normal_load=10.0, belt_speed=0.1)
contact = dict(friction_limit=0.4, contact_stiffness=800.0)
found = stickslip.evaluate(cell | contact | dict(damping=[1.0, 25.0]), law="dahl")
assert found["regime"].values.tolist() == [2, 3], found
np.testing.assert_allclose(found["settled_displacement"], 0.4 * 10 / 50)
assert "tendency" not in found and "a1" not in found.coords
def motion(t, state):
    x, v, z = state
    w = 0.1 - v
    return v, (z * 10 - 50 * x - 1.0 * v) / 2, 80 * w * (1 - z / 0.4 * np.sign(w))
times = np.linspace(0, 4, 81)
exact = solve_ivp(motion, (0, 4), (0, 0.1, 0), "DOP853", times, rtol=1e-11, atol=1e-13).y
trace = stickslip.simulate(duration=4.0, samples=81, law="dahl", **cell, **contact)
for name, values in zip(("displacement", "velocity", "friction_coefficient"), exact):
    np.testing.assert_allclose(trace[name], values, atol=2e-5 * np.abs(values).max(), err_msg=name)
system = {name: value for name, value in cell.items() if name != "stiffness"}
config = make_config(dict(system=system, friction=dict(law="dahl") | contact, axes=dict(stiffness=[20.0, 50.0, 90.0])))
assert make_config(config.resolved()) == config and "a1" not in config.fixed()
result = stickslip.run(config)
np.testing.assert_allclose(result["settled_displacement"], 4.0 / result["stiffness"])
assert result["regime"].values.tolist() == [2, 2, 2] and result["friction_limit"] == 0.4
assert stickslip.border(cell | contact, "damping", (0.1, 40.0), law="dahl")["regime_below"].values.ravel()[0] == 2
from stickslip.config.grid import build_grid
from stickslip.engine import compute_rigs, kernels_for, Options, Sampling, stop_flag
from stickslip.vocabulary.cells import as_cells
options = Options(law="dahl")
assert kernels_for(build_grid(config), options) == ("dahl",)
drive = [np.array([[0.5, 0.0, 0.2], [2.0, 0.1, 0.0], [1.0, 0.1, -0.2]])]
rigs = compute_rigs(as_cells(cell | contact, "dahl"), drive, Sampling(50.0, np.zeros(1)), options, stop_flag())
assert abs(rigs.results["energy_error"][0]) < 1e-9 and rigs.results["friction_heat"][0] > 0.0
""")
