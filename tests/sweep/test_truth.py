"""What was once answered wrongly without a word: friction that is not defined, or negative; extremes; close verdicts.

Answers come from SciPy (DOP853, rtol 1e-12, short steps), event by event, or from borders found at rtol 1e-12.
"""

from math import exp, inf

import numpy as np
import pytest
from scipy.integrate import solve_ivp

import stickslip
from helpers.nightly import few
from stickslip.config.reader import as_config
from stickslip.errors import ConfigError
from stickslip.vocabulary.results import REGIMES, STATUSES

UNIT = {"mass": 1.0, "stiffness": 1.0, "normal_load": 1.0}
ARTICLE = {"a1": 1.0, "a2": 0.1, "a3": 0.3, "a4": 0.1}


def evaluate(law="stribeck", rtol=1e-6, **cell):
    """What the engine says of one cell (m = k = N = 1 unless given), by name, with the words of its flags."""
    ds = stickslip.evaluate(UNIT | cell, law=law, rtol=rtol).isel(cell=0)
    found = {name: ds[name].item() for name in ds.data_vars}
    return found | {"regime": REGIMES[found["regime"]], "status": STATUSES[found["status"]]}


# --- hysteresis of curves that fall, and of those that have no minimum ------------------------------------------------

FALLING = {"belt_speed": 0.1, "a1": 1.0, "a2": -0.05, "a4": 0.1, "mu_stop": 0.5, "velocity": -0.5}


def test_hysteresis_does_not_end_where_a3_falls_below_zero():
    found = [evaluate(a3=a3, **FALLING) for a3 in (-1e-3, -1e-12, 0.0, 1e-12)]
    assert {one["regime"] for one in found} == {"creep"}
    assert np.ptp([one["settled_displacement"] for one in found[1:]]) < 1e-9
    assert all(one["mu_reversal"] > 0.9 for one in found)  # the line was followed
    cells = {name: value for name, value in FALLING.items() if name != "a3"} | UNIT
    assert stickslip.border(cells, "a3", (-1e-3, 1e-3), scan=8, progress=False).sizes["crossing"] == 0


@pytest.mark.parametrize(
    ("law", "curve"),
    [
        ("stribeck", {"a2": -0.05, "a3": -0.3, "a4": 0.1}),
        pytest.param("rational", {"a2": -0.05, "a3": -0.3, "a4": 0.1}, marks=pytest.mark.slow),
        pytest.param("cubic", {"a2": 0.1, "a3": -0.3, "a4": 1.0}, marks=pytest.mark.slow),
    ],
)
def test_hysteresis_of_a_curve_that_rises_and_falls_without_end_is_refused(law, curve):
    cell = UNIT | curve | {"a1": 1.0, "belt_speed": 0.1, "mu_stop": 0.5}
    with pytest.raises(ValueError, match=r"mu_stop\[0\]: got 0.5, expected none with a2 = .*minimum"):
        stickslip.evaluate(cell, law=law)
    with pytest.raises(ValueError, match="minimum"):
        stickslip.border(cell, "belt_speed", (0.1, 1.0), law=law, progress=False)
    with pytest.raises(ValueError, match="minimum"):
        stickslip.simulate(duration=1.0, law=law, **cell)
    assert evaluate(law, **{name: value for name, value in cell.items() if name != "mu_stop"})["status"] != "not_run"
    sections = {
        "system": {"mass": 1.0, "stiffness": 1.0, "normal_load": 1.0},
        "friction": {"law": law, "a1": 1.0, "a3": curve["a3"], "a4": curve["a4"], "mu_stop": 0.5},
        "axes": {"belt_speed": [0.1, 0.2], "a2": [curve["a2"], 5.0]},
    }
    with pytest.raises(ConfigError, match="mu_stop"):
        as_config(sections)


@pytest.mark.slow
def test_an_inner_minimum_ends_the_falling_branch():
    """Gaussian strengthening on a line that falls: a minimum, then a maximum, then a fall without end."""
    curve = {"a1": 1.0, "a2": -0.05, "a3": -0.3, "a4": 0.1, "delta": 2.0}
    w = np.linspace(0.0, 0.05, 500_001)
    v_min = w[np.argmin(1.0 - 0.05 * w - 0.3 * np.exp(-((w / 0.1) ** 2)))]
    assert 0.0 < v_min < 0.05
    found = evaluate("stribeck_delta", belt_speed=0.001, mu_stop=0.3, velocity=-0.5, **curve)
    assert found["mu_reversal"] == pytest.approx(1.0 - 0.05 * v_min - 0.3 * exp(-((v_min / 0.1) ** 2)), rel=1e-6)


# --- friction at every speed that is visited --------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("law", "cell"),
    [
        pytest.param(
            "cubic",
            {"belt_speed": 0.8, "damping": 0.3, "a1": 0.05, "a2": -0.2, "a3": 0.5, "a4": 1.0},
            marks=pytest.mark.slow,
        ),
        ("stribeck", {"belt_speed": 0.05, "a1": 0.5, "a2": -0.05, "a3": 0.3, "a4": 0.1, "velocity": -11.0}),
        ("stribeck", {"belt_speed": 0.05, "a1": 0.5, "a2": -0.05, "a3": 0.3, "a4": 0.1, "velocity": -14.0}),
    ],
)
def test_negative_friction_is_seen_inside_the_range_of_speeds_and_at_the_start(law, cell):
    found = evaluate(law, **cell)
    assert (found["regime"], found["status"]) == ("failed", "negative_friction")


def test_speeds_that_are_not_visited_do_not_count():
    """The same curves, negative only beyond what the motion reaches, or below it: it starts at w = 2."""
    cell = {"belt_speed": 0.05, "a1": 0.5, "a2": -0.05, "a3": 0.3, "a4": 0.1, "velocity": -5.0}
    assert evaluate(**cell)["regime"] == "stick_slip"


@pytest.mark.slow
def test_speeds_below_those_that_are_visited_do_not_count():
    above = {"belt_speed": 2.0, "damping": 3.0, "a1": 0.05, "a2": -0.2, "a3": 0.5, "a4": 1.0, "displacement": 1.0}
    assert evaluate("cubic", velocity=0.0, **above)["regime"] == "creep"


# --- extremes of the whole motion -------------------------------------------------------------------------------------


def extremes(cell, static):
    """Largest slip speed, acceleration and spring force of a motion that slips, sticks, breaks away and settles."""
    b, (a1, a2, a3, a4) = cell["belt_speed"], (cell[name] for name in ("a1", "a2", "a3", "a4"))
    state, t, sticks = np.array([0.0, cell["velocity"]]), 0.0, False
    speed, acceleration, force = 0.0, 0.0, -inf

    def rate(_, s):
        w = b - s[1]
        return s[1], np.sign(w) * (a1 + a2 * abs(w) + a3 * np.exp(-abs(w) / a4)) - s[0]

    def stops(_, s):
        return b - s[1]

    stops.terminal, stops.direction = True, 0.0
    while t < 150.0:
        if sticks:
            state, t, sticks = np.array([static, b]), t + (static - state[0]) / b, False
        if state[1] == b:  # off standstill, the way the spring pulls
            state[1] -= 1e-12 * np.sign(state[0])
        run = solve_ivp(rate, (t, 150.0), state, "DOP853", rtol=1e-12, atol=1e-13, max_step=0.01, events=stops)
        speed = max(speed, np.abs(b - run.y[1]).max())
        acceleration = max(acceleration, max(abs(rate(0.0, s)[1]) for s in run.y.T))
        force, t, state = max(force, run.y[0].max()), run.t[-1], run.y[:, -1].copy()
        if run.status == 1:
            state[1], sticks = b, abs(state[0]) <= static
    return speed, acceleration, force


def test_maxima_count_what_is_before_the_first_break_away():
    cell = ARTICLE | {"belt_speed": 0.9, "velocity": -6.0}
    found, known = evaluate(mu_static=1.5, **cell), extremes(cell, 1.5)
    assert found["regime"] == "damped"
    names = ("slip_speed_max", "acceleration_max", "spring_force_max")
    assert [found[name] for name in names] == pytest.approx(known, rel=1e-5)
    assert known == pytest.approx((6.9, 5.89, 2.52), rel=1e-3)


# --- friction work where there is next to no friction -----------------------------------------------------------------

SLIPPERY = {
    "mass": 0.0027, "stiffness": 2.236e6, "normal_load": 513.4, "belt_speed": 0.1921, "a1": 0.0, "a2": 0.0,
    "a3": 0.0668, "a4": 0.001645, "mu_static": 0.0755,
}  # fmt: skip


@pytest.mark.parametrize("rtol", [1e-4, 1e-6])
def test_friction_work_is_as_exact_as_the_tolerance_where_friction_vanishes_at_speed(rtol):
    assert evaluate(rtol=rtol, **SLIPPERY)["energy_per_cycle"] == pytest.approx(2.919808e-8, rel=rtol)


# --- verdicts that hang on less than the error ------------------------------------------------------------------------

CLOSE = {  # cells, and the belt speed at which stick-slip ends, at rtol 1e-12
    "grazing": ({"a1": 1.0, "a2": 0.1, "a3": 0.3, "a4": 0.1}, None),
    "amplified": ({"a1": 0.2658431915798469, "a2": 0.004640776525650655, "a3": 0.9208443686190952,
                   "a4": 0.08946067272131879, "damping": 0.40853750489067137}, 0.5829914728693983),
    "riding": ({"a1": 0.15567887634073674, "a2": 0.5777179147225574, "a3": 0.2539871565622128,
                "a4": 0.0038832978017659873, "damping": 0.0010291245333374581, "mu_static": 0.5243285905809485},
               0.09907218056041572),
    "lingering": ({"a1": 0.2916173754778053, "a2": 0.04237499233602654, "a3": 0.6268611081527508,
                   "a4": 0.01809593664317672, "damping": 0.0026671025669013065, "velocity": -0.2799668103311457},
                  0.45463666390663854),
}  # fmt: skip


@pytest.mark.parametrize("name", CLOSE)
def test_beside_an_exact_border_the_verdict_is_right_at_the_default_tolerance(name):
    curve, border = CLOSE[name]
    if border is None:
        found = stickslip.border(UNIT | curve, "belt_speed", (0.3, 1.5), 1e-13, rtol=1e-12, scan=16, progress=False)
        border = found["border"].item()
    offsets = np.array([-1e-4, -1e-6, -1e-8, 1e-8, 1e-6, 1e-4])
    ds = stickslip.evaluate(UNIT | curve | {"belt_speed": border * (1.0 + offsets)})
    assert [REGIMES[code] for code in ds["regime"].values] == ["stick_slip"] * 3 + ["damped"] * 3


@pytest.mark.parametrize("law", few(["stribeck", "cubic", "rational"], 1))
@pytest.mark.parametrize(("belt_speed", "a1"), [(0.002, 0.6), (0.00615, 0.4), (0.1, 1.0)])
def test_ringing_without_any_drag_is_no_stick_slip_however_closely_it_is_looked_at(law, belt_speed, a1):
    """It grazes standstill in every loop: what sticks there in a tighter run is rounding."""
    cell = {"mass": 1.0, "stiffness": 1.0, "normal_load": 1.0, "belt_speed": belt_speed, "a1": a1, "a2": 0.0, "a3": 0.0,
            "a4": 0.1}  # fmt: skip
    for rtol in (1e-6, 1e-9):
        ds = stickslip.evaluate(cell, rtol, law=law)
        assert ds.stickslip.mask("sustained").all()


# --- no drag at all ---------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("early_stop", [True, False])
@pytest.mark.parametrize("rtol", [1e-6, 1e-9])
def test_friction_that_is_the_same_at_any_speed_never_sticks_again_without_a_damper(rtol, early_stop):
    """From break-away the slip is a circle that touches standstill: 1 to 20 % of such cells were stick-slip once."""
    draw, n = np.random.default_rng(1), 300
    cells = {
        "mass": 10 ** draw.uniform(-2, 2, n),
        "stiffness": 10 ** draw.uniform(0, 5, n),
        "a1": draw.uniform(0.05, 2, n),
    }
    impedance = np.sqrt(cells["mass"] * cells["stiffness"])
    cells |= {
        "belt_speed": 10 ** draw.uniform(-3, 1, n),
        "a1": draw.uniform(0.05, 2, n),
        "a2": 0.0,
        "a3": 0.0,
        "a4": 0.1,
    }
    cells["normal_load"] = 10 ** draw.uniform(-2, 4, n) * impedance * cells["belt_speed"]
    horizon = None if early_stop else 200.0 / np.sqrt(100.0)
    ds = stickslip.evaluate(cells, rtol=rtol, early_stop=early_stop, horizon=horizon)
    assert {REGIMES[code] for code in np.unique(ds["regime"])} <= {"sustained", "unresolved"}
    assert early_stop is False or (ds["regime"] == REGIMES.index("sustained")).all()


@pytest.mark.slow
def test_the_largest_acceleration_between_two_turns_of_it_within_a_step_counts():
    cell = {"belt_speed": 0.16, "a1": 0.1, "a2": 3e-4, "a3": 2e-3, "a4": 0.151, "displacement": -2.0, "velocity": -0.22}
    assert evaluate("cubic", **cell)["acceleration_max"] == pytest.approx(2.1115438470893, rel=1e-9)
