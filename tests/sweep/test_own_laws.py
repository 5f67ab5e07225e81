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
from stickslip.errors import ConfigError
from stickslip.vocabulary.code_digest import code_digest
from stickslip.vocabulary.flags import REGIMES
from stickslip.vocabulary.models import laws_with, own_law

TESTS = Path(__file__).parents[1]
CURVE = (0.3, 0.1, 0.2, 0.05)
UNIT = {"mass": 1.0, "stiffness": 1.0, "normal_load": 1.0}
CELL = UNIT | dict(zip(("a1", "a2", "a3", "a4"), CURVE, strict=True))
YAML = "friction: {law: own_lorentzian, a1: 0.3, a2: 0.1, a3: 0.2, a4: 50 mm/s}"
ENTRY = """
system: {mass: 1, stiffness: 1, normal_load: 1}
friction: {law: LAW, a1: 0.3, a2: 0.1, a3: 0.2, a4: 0.05}
axes: {belt_speed: [0.02, 0.1, 0.6]}
"""


@pytest.fixture(scope="module")
def lorentzian():
    return stickslip.register_law("own_lorentzian", own_shapes.shape, own_shapes.slope)


@pytest.fixture(scope="module")
def stretched():
    return stickslip.register_law("own_stretched", own_shapes.stretched, own_shapes.stretched_slope)


@pytest.fixture(scope="module")
def expanded():
    return stickslip.register_law("own_expanded", own_shapes.shape, own_shapes.slope, own_shapes.recurrence)


@pytest.fixture(scope="module")
def bell():
    """The law `gaussian` of the program, as people would register it."""
    return stickslip.register_law("own_bell", own_shapes.bell, own_shapes.bell_slope, own_shapes.bell_recurrence)


@pytest.mark.slow
@pytest.mark.parametrize("belt", [0.004, 0.1, 0.7])
@pytest.mark.parametrize("law", ["lorentzian", "expanded"])
def test_the_motion_under_a_registered_law_is_that_of_scipy(law, belt, monkeypatch, request):
    lorentzian = request.getfixturevalue(law)
    monkeypatch.setitem(scipy_oscillator.SHAPES, lorentzian, lambda z, delta: 1.0 / (1.0 + z * z))
    horizon = 15.0 + 0.6 / belt
    exact = Oscillator(belt, horizon, CURVE, gamma=0.02, law=lorentzian)
    for rtol in (1e-6, 1e-9):
        found = stickslip.evaluate(
            CELL | {"belt_speed": belt, "damping": 0.02},
            law=lorentzian,
            horizon=horizon,
            early_stop=False,
            rtol=rtol,
        )
        end = float(found["displacement_end"][0]), float(found["velocity_end"][0])
        assert end == pytest.approx((exact.xi, exact.eta), abs=10 * rtol + 1e-10)
        assert found["sticks"][0] == sum(mode == "stick" for _, mode, _, _ in exact.phases)


@pytest.mark.slow
@pytest.mark.parametrize("delta", [1.0, 1.7, 3.0])
def test_our_law_written_again_gives_the_same_map(stretched, delta):
    random, n = np.random.default_rng(4), 400
    cells = {
        "mass": 10.0 ** random.uniform(-1, 1, n), "stiffness": 10.0 ** random.uniform(-1, 2, n), "normal_load": 1.0,
        "damping": 10.0 ** random.uniform(-3, 0, n), "belt_speed": 10.0 ** random.uniform(-2.5, 0.5, n),
        "a1": 0.3, "a2": random.uniform(0, 0.2, n), "a3": random.uniform(0, 0.3, n), "a4": 0.05, "delta": delta,
    }  # fmt: skip
    own, ours = (stickslip.evaluate(cells, law=law, rtol=1e-8) for law in (stretched, "stribeck_delta"))
    np.testing.assert_array_equal(own["regime"], ours["regime"])
    for name in ("period", "spring_force_max", "restick_displacement", "settling_time", "damping_ratio"):
        known = np.isfinite(own[name].values)  # a law that takes more steps gives up following some to the end
        assert known.sum() > 20
        assert (known != np.isfinite(ours[name].values)).sum() <= 2 * (name == "settling_time")
        np.testing.assert_allclose(own[name][known], ours[name][known], rtol=2e-6, atol=1e-9, err_msg=name)


def decades(random, n):
    """Cells over decades, very weakly and very strongly damped ones among them."""
    return {
        "mass": 10.0 ** random.uniform(-1, 1, n), "stiffness": 10.0 ** random.uniform(-1, 3, n), "normal_load": 1.0,
        "damping": 10.0 ** random.uniform(-5, 2, n), "belt_speed": 0.05 * 10.0 ** random.uniform(-2, 1.5, n), "a1": 0.3,
        "a2": random.uniform(0, 0.2, n) * random.integers(0, 2, n), "a3": random.uniform(0, 0.3, n), "a4": 0.05,
    }  # fmt: skip


@pytest.mark.slow
@pytest.mark.parametrize("with_recurrence", [True, False])
def test_a_law_of_ours_registered_gives_the_same_map_over_decades(bell, stretched, with_recurrence):
    cells, delta = decades(np.random.default_rng(6), 500), {"delta": 2.0}
    law = (bell, {}) if with_recurrence else (stretched, delta)
    own, ours = (stickslip.evaluate(cells | more, law=name) for name, more in (law, ("stribeck_delta", delta)))
    known = own["regime"].values != REGIMES.index("unresolved")
    assert known.mean() > (0.999 if with_recurrence else 0.99)
    np.testing.assert_array_equal(own["regime"].values[known], ours["regime"].values[known])
    for name in ("period", "spring_force_max", "slip_speed_max", "settling_time", "acceleration_max"):
        both = np.isfinite(own[name].values) & np.isfinite(ours[name].values)
        assert both.sum() > 50
        np.testing.assert_allclose(own[name].values[both], ours[name].values[both], rtol=2e-5, err_msg=name)


@pytest.mark.slow
def test_a_recurrence_takes_a_fraction_of_the_steps(lorentzian, expanded):
    cells = decades(np.random.default_rng(7), 300) | {"damping": 0.02, "stiffness": 1.0}
    steps = [float(stickslip.evaluate(cells, law=law)["steps"].mean()) for law in (lorentzian, expanded)]
    assert steps[1] < 0.35 * steps[0]


@pytest.mark.slow
@pytest.mark.parametrize("with_recurrence", [True, False])
@pytest.mark.parametrize("gamma", [0.02, 5.0])
def test_the_border_at_the_end_of_stick_slip_is_that_of_our_law(bell, stretched, gamma, with_recurrence):
    """Where loops grow or shrink too slowly to be followed."""
    delta = {"delta": 2.0}
    damper = 0.2 / 0.05 * -own_shapes.bell_slope(1.2, 2.0)  # that of the fall at 60 mm/s
    cell = CELL | {"a2": 0.0, "damping": damper, "stiffness": (damper / gamma) ** 2}
    (own, ours) = (
        stickslip.border(cell | more, "belt_speed", (0.03, 0.5), 1e-7, law=law, scan=12)
        for law, more in ((bell, {}) if with_recurrence else (stretched, delta), ("stribeck_delta", delta))
    )
    first = [float(np.ravel(found["border"].values)[0]) for found in (own, ours)]
    assert int(np.ravel(ours["regime_below"].values)[0]) == REGIMES.index("stick_slip")
    assert first[0] == pytest.approx(first[1], rel=1e-6)


@pytest.mark.slow
def test_small_motions_grow_where_the_damper_is_weaker_than_the_fall_that_was_registered(expanded):
    z = np.array([0.3, 0.8, 2.0])
    critical = -np.array([0.1 + 0.2 / 0.05 * own_shapes.slope(one, 1.0) for one in z])
    steady = 0.3 + 0.1 * 0.05 * z + 0.2 * np.array([own_shapes.shape(one, 1.0) for one in z])
    cell = CELL | {"belt_speed": 0.05 * z, "displacement": steady * (1.0 + 1e-6), "velocity": 0.0}
    regimes = [
        stickslip.evaluate(cell | {"damping": critical * share}, law=expanded)["regime"] for share in (0.98, 1.001)
    ]
    assert set(regimes[0].values) <= {REGIMES.index("stick_slip"), REGIMES.index("sustained")}
    assert set(regimes[1].values) == {REGIMES.index("damped")}


def test_only_a_law_that_depends_on_it_has_the_exponent(lorentzian, stretched):
    assert stretched in laws_with("delta")
    assert lorentzian not in laws_with("delta")
    friction = {"law": "own_lorentzian", "a1": 1, "a2": 0, "a3": 1, "a4": 1, "delta": 2}
    with pytest.raises(ConfigError, match="got delta with the law own_lorentzian"):
        make_config({"system": UNIT | {"belt_speed": 0.1}, "friction": friction})


@pytest.mark.slow
def test_a_configuration_names_a_registered_law(expanded):
    text = ENTRY.replace("LAW", "own_expanded")
    found = stickslip.run(stickslip.config.reader.parse_config(text))
    same = stickslip.evaluate(CELL | {"belt_speed": [0.02, 0.1, 0.6]}, law=expanded)
    np.testing.assert_array_equal(found["period"], same["period"])
    with pytest.raises(ConfigError, match="expected .*own_expanded"):
        stickslip.config.reader.parse_config(text.replace("own_expanded", "own_expand"))


@pytest.mark.parametrize(
    ("shape", "slope", "message"),
    [
        (lambda z, d: math.exp(-z), lambda z, d: -2 * math.exp(-z), "is -2, and the shape rises by -0.999"),
        (lambda z, d: math.exp(-z), lambda z, d: math.exp(-z), "and the shape rises by -0.999"),
        (lambda z, d: 2 * math.exp(-z), lambda z, d: -2 * math.exp(-z), r"shape\(0, 1\) is 2, expected 1"),
        (lambda z, d: math.cos(z), lambda z, d: -math.sin(z), "expected at least 0"),
        (lambda z, d: 1 / (1 + math.sqrt(z)), lambda z, d: -0.5 / math.sqrt(z), r"slope\(0, 1\) fails"),
        (lambda z, d: math.exp(z), lambda z, d: math.exp(z), "fails: math range error"),
        (lambda z, d: math.exp(-z) if z < 5 else math.nan, lambda z, d: -math.exp(-z), "is nan, expected a finite"),
        (lambda z, d: math.exp(-z) + (z > 2), lambda z, d: -math.exp(-z), "and the shape rises by"),
        (lambda z, d: math.exp(-z), lambda z, d: -math.exp(-z) * (1.01 if z > 5 else 1), r"slope\(5.0.*shape rises"),
        (lambda z, d: math.exp(-z), lambda z, d: math.inf if z == 0 else -math.exp(-z), r"slope\(0, 1\) is inf"),
        (lambda z, d: math.nan if 2 < z < 2.05 else math.exp(-z), lambda z, d: -math.exp(-z), r"shape\(2.0.*is nan"),
        (lambda z, d: 0.5 + 0.5 * math.exp(-z) - 1e-4 * z, lambda z, d: -0.5 * math.exp(-z) - 1e-4, "is -0.5, "),
        (lambda z, d: math.exp(-z) * (1 if d < 4 else 2), lambda z, d: -math.exp(-z), r"shape\(0, 5\) is 2"),
        (lambda z: math.exp(-z), lambda z: -math.exp(-z), "takes 1 positional argument but 2 were given"),
        (lambda z, d: None, lambda z, d: -math.exp(-z), r"shape\(0, 1\) fails: float"),
    ],
)  # fmt: skip
def test_what_is_no_law_is_refused(shape, slope, message):
    with pytest.raises(ValueError, match=message):
        stickslip.register_law("own_wrong", shape, slope)
    assert own_law("own_wrong") is None


@pytest.mark.parametrize(
    ("recurrence", "message"),
    [
        *((lambda n, z, s, d, e, wrong=k: -s[n] * (1.0 + (n == wrong)), "the series of the rec") for k in (1, 3, 6)),
        (lambda n, z, s, d: -s[n], r"recurrence\(1, ...\) fails from z = 0.02 on: .* takes 4 positional"),
        (lambda n, z, s, d, e: -d[n], "tuple index out of range"),
        (lambda n, z, s, d, e: math.nan, "gives the slope nan"),
        (own_shapes.bell_recurrence, "the series of the recurrence"),
    ],
)  # fmt: skip
def test_a_recurrence_of_another_slope_is_refused(recurrence, message):
    with pytest.raises(ValueError, match=message):
        stickslip.register_law("own_wrong", lambda z, d: math.exp(-z), lambda z, d: -math.exp(-z), recurrence)
    assert own_law("own_wrong") is None


@pytest.mark.parametrize("name", ["stribeck", "lugre_own", "table_1", "Own", "own law", "", 3, "../own"])
def test_names_that_others_have_are_refused(name):
    with pytest.raises(ValueError, match="expected a word in small letters that is no law yet"):
        stickslip.register_law(name, own_shapes.shape, own_shapes.slope)


def test_a_law_without_a_slope_is_refused():
    with pytest.raises(TypeError, match="got slope=None"):
        stickslip.register_law("own_wrong", own_shapes.shape, None)


@pytest.mark.slow
def test_what_numba_cannot_compile_is_said():
    def shape(z, delta):
        return float(f"{math.exp(-z):.17g}")

    law = stickslip.register_law("own_text", shape, lambda z, delta: -math.exp(-z))
    with pytest.raises(ValueError, match="law own_text: Numba cannot compile it"):
        stickslip.evaluate(CELL | {"belt_speed": 0.1}, law=law)


def test_an_edited_law_has_kernels_of_another_name(monkeypatch):
    """Whatever the code refers to: another constant, a helper, a global number, an array, a closure."""
    digests = {code_digest(own_shapes.with_helper)}
    assert code_digest(own_shapes.with_helper) in digests
    monkeypatch.setattr(own_shapes, "CENTRE", 2.0)
    digests.add(code_digest(own_shapes.with_helper))
    monkeypatch.setattr(own_shapes, "squared", lambda z: z * z * 1.5)
    digests.add(code_digest(own_shapes.with_helper))
    for factor in (1.0, 1, 2.0, np.array([1.0]), np.array([2.0]), (1.0, 2.0)):
        digests.add(code_digest(lambda z, delta: z * factor))  # noqa: B023
    digests.add(code_digest(lambda z, delta: own_shapes.squared(z)))
    monkeypatch.setattr(own_shapes, "squared", lambda z: z * z * 2.5)
    digests.add(code_digest(lambda z, delta: own_shapes.squared(z)))
    digests.add(code_digest(lambda z, delta: z + 1.0))
    digests.add(code_digest(lambda z, delta: z + 2.0))
    assert len(digests) == 13


def test_a_law_that_refers_to_what_has_no_digest_is_refused():
    table = {"a": 1.0}
    with pytest.raises(ValueError, match="it refers to .*, expected numbers, arrays, modules and functions"):
        stickslip.register_law("own_wrong", lambda z, d: math.exp(-z) * table["a"], lambda z, d: -math.exp(-z))


def test_the_digest_does_not_depend_on_the_process():
    script = f"import sys; sys.path.insert(0, {str(TESTS)!r}); from helpers import own_shapes as o\n"
    script += (
        "from stickslip.vocabulary.code_digest import code_digest; print(code_digest(o.shape, o.slope, o.stretched))"
    )
    seen = {
        subprocess.run([sys.executable, "-c", script], capture_output=True, text=True, check=True).stdout.strip()
        for _ in range(2)
    }
    assert seen == {code_digest(own_shapes.shape, own_shapes.slope, own_shapes.stretched)}


@pytest.mark.parametrize("law", ["own_lorentzian", "lugre_own_lorentzian"])
def test_a_process_that_gets_the_options_knows_the_law(lorentzian, law):
    options = stickslip.Options(law=law)
    script = (
        f"import sys, pickle; sys.path.insert(0, {str(TESTS)!r}); from stickslip.vocabulary.own_laws import is_law\n"
    )
    script += (
        "assert not is_law('own_lorentzian'); pickle.loads(sys.stdin.buffer.read()); assert is_law('own_lorentzian')"
    )
    subprocess.run([sys.executable, "-c", script], input=pickle.dumps(options), check=True)


@pytest.mark.slow
def test_options_carry_functions_that_no_module_has():
    """Behind bristles, with a recurrence, into a process that computes with them."""
    law = stickslip.register_law(
        "own_lambdas", lambda z, d: math.exp(-z), lambda z, d: -math.exp(-z), lambda n, z, s, d, delta: -s[n]
    )
    options, cell = stickslip.Options(law=f"lugre_{law}"), CELL | {"belt_speed": 0.1, "contact_stiffness": 1e3}
    script = (
        "import sys, pickle, stickslip; options, cell = pickle.loads(sys.stdin.buffer.read()); "
        "print(float(stickslip.evaluate(cell, options=options)['period'][0]))"
    )
    sent = pickle.dumps((options, cell))
    done = subprocess.run([sys.executable, "-c", script], input=sent, capture_output=True, check=True)
    assert float(done.stdout) == float(stickslip.evaluate(cell, options=options)["period"][0])


@pytest.mark.slow
def test_an_installed_package_brings_a_law(expanded, tmp_path):
    """With its recurrence, of which the command line knows as well."""
    folder = tmp_path / "brought-1.0.dist-info"
    folder.mkdir()
    (folder / "METADATA").write_text("Metadata-Version: 2.1\nName: brought\nVersion: 1.0\n", encoding="utf-8")
    (folder / "entry_points.txt").write_text("[stickslip.laws]\nown_expanded = helpers.own_shapes\n", encoding="utf-8")
    (tmp_path / "map.yaml").write_text(ENTRY.replace("LAW", "own_expanded"), encoding="utf-8")
    command = [sys.executable, "-c", f"import sys; sys.path[:0] = [{str(tmp_path)!r}, {str(TESTS)!r}]; "
               "from stickslip.__main__ import main; main()"]  # fmt: skip
    run = [*command, "run", str(tmp_path / "map.yaml"), "-o", str(tmp_path / "map.nc")]
    subprocess.run(run, check=True, capture_output=True)
    found = stickslip.open(tmp_path / "map.nc")
    same = stickslip.evaluate(CELL | {"belt_speed": [0.02, 0.1, 0.6]}, law=expanded)
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
