"""Friction laws that people register: against SciPy, against ours, and what is refused."""

import math
import pickle
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

import stickslip
from helpers import own_shapes, scipy_oscillator
from helpers.scipy_oscillator import Oscillator
from stickslip.config.reader import make_config
from stickslip.engine import Options, will_compile
from stickslip.engine.dispatch import friction_at_belt_speed
from stickslip.errors import ConfigError, ExtrapolationWarning
from stickslip.vocabulary.cells import as_cells
from stickslip.vocabulary.models import laws_with, own_law
from stickslip.vocabulary.results import REGIMES

TESTS = Path(__file__).parents[1]
CURVE = (0.3, 0.1, 0.2, 0.05)
UNIT = {"mass": 1.0, "stiffness": 1.0, "normal_load": 1.0}
CELL = UNIT | dict(zip(("a1", "a2", "a3", "a4"), CURVE, strict=True))
ENTRY = """
system: {mass: 1, stiffness: 1, normal_load: 1}
friction: {law: LAW, a1: 0.3, a2: 0.1, a3: 0.2, a4: 0.05}
axes: {belt_speed: [0.02, 0.1, 0.6]}
"""
SHAPES = {
    "lorentzian": (own_shapes.shape, own_shapes.slope), "bell": (own_shapes.bell, own_shapes.bell_slope),
    "falling": (own_shapes.falling, own_shapes.falling_slope), "hilly": (own_shapes.hilly, own_shapes.hilly_slope),
    "rising": (own_shapes.rising, own_shapes.rising_slope), "wavy": (own_shapes.wavy, own_shapes.wavy_slope),
}  # fmt: skip


def registered(name):
    return stickslip.register_law(f"own_{name}", *SHAPES[name])


@pytest.fixture(scope="module")
def lorentzian():
    return registered("lorentzian")


@pytest.fixture(scope="module")
def bell():
    """The law `gaussian` of the program, as people would register it."""
    return registered("bell")


@pytest.mark.parametrize(
    ("name", "belt", "decay"),
    [
        *(("lorentzian", belt, 0.05) for belt in (0.004, 0.1, 0.7)),
        *(("falling", belt, 1e-3) for belt in (0.004, 0.1)),  # steep
        *(("hilly", belt, 0.05) for belt in (0.02, 0.25)),
        ("wavy", 0.05, 0.05),
        ("rising", 0.1, 0.05),
    ],
)
def test_the_motion_under_a_registered_law_is_that_of_scipy(name, belt, decay, monkeypatch):
    law, curve = registered(name), (*CURVE[:3], decay)
    monkeypatch.setitem(scipy_oscillator.SHAPES, law, np.vectorize(lambda z, delta: SHAPES[name][0](max(z, 0.0))))
    horizon = 15.0 + 0.6 / belt
    exact = Oscillator(belt, horizon, curve, gamma=0.02, law=law)
    cell = CELL | {"belt_speed": belt, "damping": 0.02, "a4": decay}
    for rtol in (1e-6, 1e-9):
        ds = stickslip.evaluate(cell, law=law, horizon=horizon, early_stop=False, rtol=rtol)
        end = float(ds["displacement_end"][0]), float(ds["velocity_end"][0])
        assert end == pytest.approx((exact.xi, exact.eta), abs=10 * rtol + 1e-10)
        assert ds["sticks"][0] == sum(mode == "stick" for _, mode, _, _ in exact.phases)


@pytest.mark.parametrize("name", SHAPES)
def test_the_table_has_the_shape_and_its_slope(name):
    shape, slope = SHAPES[name]
    law, z = registered(name), np.random.default_rng(2).permutation(np.geomspace(1e-7, 9e3, 3000))
    cells = UNIT | {"a1": 0.0, "a2": 0.0, "a3": 1.0, "a4": 1.0, "belt_speed": z, "damping": 2.0}
    exact = np.array([[shape(place), slope(place)] for place in z])
    friction = friction_at_belt_speed(as_cells(cells, law), Options(law=law))
    np.testing.assert_allclose(friction, exact[:, 0], rtol=0.0, atol=1e-9 * exact[:, 0].max())
    ratio = stickslip.evaluate(cells, law=law, max_steps=1)["damping_ratio"].values
    np.testing.assert_allclose(2.0 * (ratio - 1.0), exact[:, 1], rtol=0.0, atol=1e-8 * np.abs(exact[:, 1]).max())


def test_nothing_is_compiled_for_a_further_law(lorentzian):
    stickslip.evaluate(CELL | {"belt_speed": 0.1}, law=lorentzian)
    stickslip.simulate(CELL | {"belt_speed": 0.1}, law=lorentzian, duration=1.0)
    law = stickslip.register_law("own_further", lambda z: math.exp(-2.0 * z), lambda z: -2.0 * math.exp(-2.0 * z))
    assert not will_compile(law) and not will_compile(law, signals=True)


def test_a_law_registered_again_is_another_one():
    cell = CELL | {"belt_speed": 0.1, "a4": [0.05, 0.1]}
    periods = []
    for rate in (1.0, 2.0):
        law = stickslip.register_law(
            "own_again", lambda z, r=rate: math.exp(-r * z), lambda z, r=rate: -r * math.exp(-r * z)
        )
        periods.append(stickslip.evaluate(cell, law=law)["period"].values)
    assert periods[0][0] == pytest.approx(periods[1][1], rel=1e-6)
    assert periods[0][0] != pytest.approx(periods[1][0], rel=1e-3)


def test_beyond_the_table_friction_stays_and_a_warning_says_so(lorentzian):
    with pytest.warns(ExtrapolationWarning, match="at 1 m/s: beyond"):
        stickslip.evaluate(CELL | {"a4": 1e-4, "belt_speed": 2.0}, law=lorentzian)


def decades(random, n):
    """Cells over decades, very weakly and very strongly damped ones among them."""
    return {
        "mass": 10.0 ** random.uniform(-1, 1, n), "stiffness": 10.0 ** random.uniform(-1, 3, n), "normal_load": 1.0,
        "damping": 10.0 ** random.uniform(-5, 2, n), "belt_speed": 0.05 * 10.0 ** random.uniform(-2, 1.5, n), "a1": 0.3,
        "a2": random.uniform(0, 0.2, n) * random.integers(0, 2, n), "a3": random.uniform(0, 0.3, n), "a4": 0.05,
    }  # fmt: skip


@pytest.mark.slow
def test_a_law_of_ours_registered_gives_the_same_map_over_decades(bell):
    cells = decades(np.random.default_rng(6), 500)
    own, ours = stickslip.evaluate(cells, law=bell), stickslip.evaluate(cells | {"delta": 2.0}, law="stribeck_delta")
    known = own["regime"].values != REGIMES.index("unresolved")
    assert known.mean() > 0.99
    np.testing.assert_array_equal(own["regime"].values[known], ours["regime"].values[known])
    for name in ("period", "spring_force_max", "slip_speed_max", "settling_time", "acceleration_max"):
        both = np.isfinite(own[name].values) & np.isfinite(ours[name].values)
        assert both.sum() > 50
        np.testing.assert_allclose(own[name].values[both], ours[name].values[both], rtol=2e-5, err_msg=name)


@pytest.mark.slow
@pytest.mark.parametrize("gamma", [0.02, 5.0])
def test_the_border_at_the_end_of_stick_slip_is_that_of_our_law(bell, gamma):
    """Where loops grow or shrink too slowly to be followed."""
    damper = 0.2 / 0.05 * -own_shapes.bell_slope(1.2)  # that of the fall at 60 mm/s
    cell = CELL | {"a2": 0.0, "damping": damper, "stiffness": (damper / gamma) ** 2}
    (own, ours) = (
        stickslip.border(cell | more, "belt_speed", (0.03, 0.5), 1e-7, law=law, scan=12)
        for law, more in ((bell, {}), ("stribeck_delta", {"delta": 2.0}))
    )
    first = [float(np.ravel(ds["border"].values)[0]) for ds in (own, ours)]
    assert int(np.ravel(ours["regime_below"].values)[0]) == REGIMES.index("stick_slip")
    assert first[0] == pytest.approx(first[1], rel=1e-6)


def test_small_motions_grow_where_the_damper_is_weaker_than_the_fall_that_was_registered(lorentzian):
    z = np.array([0.3, 0.8, 2.0])
    critical = -np.array([0.1 + 0.2 / 0.05 * own_shapes.slope(place) for place in z])
    steady = 0.3 + 0.1 * 0.05 * z + 0.2 * np.array([own_shapes.shape(place) for place in z])
    cell = CELL | {"belt_speed": 0.05 * z, "displacement": steady * (1.0 + 1e-6), "velocity": 0.0}
    regimes = [
        stickslip.evaluate(cell | {"damping": critical * share}, law=lorentzian)["regime"] for share in (0.98, 1.001)
    ]
    assert set(regimes[0].values) <= {REGIMES.index("stick_slip"), REGIMES.index("sustained")}
    assert set(regimes[1].values) == {REGIMES.index("damped")}


def test_a_registered_law_has_no_exponent(lorentzian):
    assert lorentzian not in laws_with("delta")
    friction = {"law": "own_lorentzian", "a1": 1, "a2": 0, "a3": 1, "a4": 1, "delta": 2}
    with pytest.raises(ConfigError, match="got delta with the law own_lorentzian"):
        make_config({"system": UNIT | {"belt_speed": 0.1}, "friction": friction})


def test_a_configuration_names_a_registered_law(lorentzian):
    text = ENTRY.replace("LAW", "own_lorentzian")
    ds = stickslip.run(stickslip.config.reader.parse_config(text))
    same = stickslip.evaluate(CELL | {"belt_speed": [0.02, 0.1, 0.6]}, law=lorentzian)
    np.testing.assert_array_equal(ds["period"], same["period"])
    with pytest.raises(ConfigError, match="expected .*own_lorentzian"):
        stickslip.config.reader.parse_config(text.replace("own_lorentzian", "own_lorentz"))


@pytest.mark.parametrize(
    ("shape", "slope", "message"),
    [
        (lambda z: math.exp(-z), lambda z: -2 * math.exp(-z), r"slope\(.* is -1.99.*, and the shape rises by -0.99"),
        (lambda z: math.exp(-z), lambda z: math.exp(-z), "and the shape rises by -0.99"),
        (lambda z: math.exp(-z), lambda z: -1.0001 * math.exp(-z), "and the shape rises by"),
        (lambda z: math.exp(-z), lambda z: -math.exp(-z) * (1.01 if z > 5 else 1), r"near z = [56].*rises by"),
        (lambda z: 0.5 + 0.5 * math.exp(-z), lambda z: -0.5 * math.exp(-z) - 1e-4, "is -0.5000.* rises by -0.4999"),
        (lambda z: 2 * math.exp(-z), lambda z: -2 * math.exp(-z), r"shape\(0\) is 2, expected 1"),
        (lambda z: math.cos(z), lambda z: -math.sin(z), "expected at least 0"),
        (lambda z: 1 / (1 + math.sqrt(z)), lambda z: -0.5 / math.sqrt(z), r"slope\(0\) fails"),
        (lambda z: math.exp(z), lambda z: math.exp(z), "fails: math range error"),
        (lambda z: math.exp(-z) if z < 5 else math.nan, lambda z: -math.exp(-z), "is nan, expected a finite"),
        (lambda z: math.exp(-z), lambda z: math.inf if z == 0 else -math.exp(-z), r"slope\(0\) is inf"),
        (lambda z: math.exp(-z) + (z > 2), lambda z: -math.exp(-z), "no smooth curve near z = 2:"),
        (lambda z: max(1 - z, 0.2), lambda z: -1.0 if z < 0.8 else 0.0, "no smooth curve near z = 0.8:"),
        (lambda z: math.exp(-(z**1.2)), lambda z: -1.2 * z**0.2 * math.exp(-(z**1.2)), "no smooth curve near z = 0:"),
        (lambda z: 1 + 0.1 * math.sin(20 * z), lambda z: 2 * math.cos(20 * z), "no smooth curve near z"),
        (lambda z, delta: math.exp(-z), lambda z, delta: -math.exp(-z), "missing 1 required positional argument"),
        (lambda z: None, lambda z: -math.exp(-z), r"shape\(0\) fails: float"),
    ],
)  # fmt: skip
def test_what_is_no_law_is_refused(shape, slope, message):
    with pytest.raises(ValueError, match=message):
        stickslip.register_law("own_wrong", shape, slope)
    assert own_law("own_wrong") is None


@pytest.mark.parametrize("name", ["stribeck", "lugre_own", "table_1", "Own", "own law", "", 3, "../own"])
def test_names_that_others_have_are_refused(name):
    with pytest.raises(ValueError, match="expected a word in small letters that is no law yet"):
        stickslip.register_law(name, own_shapes.shape, own_shapes.slope)


def test_a_law_without_a_slope_is_refused():
    with pytest.raises(TypeError, match="got slope=None"):
        stickslip.register_law("own_wrong", own_shapes.shape, None)


@pytest.mark.parametrize("prefix", ["", pytest.param("lugre_", marks=pytest.mark.slow)])
def test_a_process_that_gets_the_options_computes_with_the_law(prefix):
    """Functions that no module has: only the table goes there."""
    law = stickslip.register_law("own_lambdas", lambda z: math.exp(-z), lambda z: -math.exp(-z))
    cell = CELL | {"belt_speed": 0.1} | ({"contact_stiffness": 1e3} if prefix else {})
    options = stickslip.Options(law=f"{prefix}{law}")
    script = (
        "import sys, pickle, stickslip; options, cell = pickle.loads(sys.stdin.buffer.read()); "
        "print(float(stickslip.evaluate(cell, options=options)['period'][0]))"
    )
    sent = pickle.dumps((options, cell))
    done = subprocess.run([sys.executable, "-c", script], input=sent, capture_output=True, check=True)
    assert float(done.stdout) == float(stickslip.evaluate(cell, options=options)["period"][0])


def test_an_installed_package_brings_a_law(lorentzian, tmp_path):
    """Which the command line knows as well."""
    folder = tmp_path / "brought-1.0.dist-info"
    folder.mkdir()
    (folder / "METADATA").write_text("Metadata-Version: 2.1\nName: brought\nVersion: 1.0\n", encoding="utf-8")
    (folder / "entry_points.txt").write_text(
        "[stickslip.laws]\nown_lorentzian = helpers.own_shapes\n", encoding="utf-8"
    )
    (tmp_path / "map.yaml").write_text(ENTRY.replace("LAW", "own_lorentzian"), encoding="utf-8")
    command = [sys.executable, "-c", f"import sys; sys.path[:0] = [{str(tmp_path)!r}, {str(TESTS)!r}]; "
               "from stickslip.__main__ import main; main()"]  # fmt: skip
    run = [*command, "run", str(tmp_path / "map.yaml"), "-o", str(tmp_path / "map.nc")]
    subprocess.run(run, check=True, capture_output=True)
    found = stickslip.open(tmp_path / "map.nc")
    same = stickslip.evaluate(CELL | {"belt_speed": [0.02, 0.1, 0.6]}, law=lorentzian)
    np.testing.assert_array_equal(found["period"], same["period"])
    wrong = tmp_path / "wrong.yaml"
    wrong.write_text(ENTRY.replace("LAW", "own_lorentz"), encoding="utf-8")
    done = subprocess.run([*command, "validate", str(wrong)], capture_output=True, text=True)
    assert done.returncode and "friction.law" in done.stderr + done.stdout


@pytest.mark.slow
def test_workers_get_a_law_that_was_registered_here(lorentzian, tmp_path):
    config = make_config({
        "system": UNIT, "axes": {"belt_speed": {"start": 0.02, "stop": 0.6, "num": 40}},
        "friction": {"law": "own_lorentzian", "a1": 0.3, "a2": 0.1, "a3": 0.2, "a4": 0.05},
    })  # fmt: skip
    there = stickslip.run(config, tmp_path / "there.nc", dask="local")
    np.testing.assert_array_equal(there["period"], stickslip.run(config)["period"])
