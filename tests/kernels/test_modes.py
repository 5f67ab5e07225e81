"""The state machine against SciPy, event by event, and against closed forms."""

import numpy as np
import pytest

from helpers.data import rows
from helpers.kernel_runs import ARTICLE, NAN, block_of, cell, outcome, run
from helpers.nightly import few
from helpers.scipy_oscillator import Oscillator
from stickslip_kernels import layout as at

# Every one of these was chosen for what happens in it; the modes it passes through are part of the test.
CASES, OF_LAWS = (rows("kernels.yaml")["test_modes"][name] for name in ("CASES", "OF_LAWS"))
HORIZON = 25.0


@pytest.mark.parametrize("name", few([*CASES, *OF_LAWS], CASES))
def test_motion_is_that_of_scipy(name):
    """To its tolerance over several cycles; each break-away starts afresh, so errors hardly add up."""
    case, modes = CASES[name] if name in CASES else (OF_LAWS[name], "stick rise")
    expected = Oscillator(horizon=HORIZON, **case)
    passed, modes = [mode for _, mode, _, _ in expected.phases], {*modes.split()}
    assert {*passed} == modes if name in CASES else {*passed} >= modes, "the case is not what its name says"
    for rtol in (1e-6, 1e-9, 1e-10):
        found = outcome(**case, horizon=HORIZON, rtol=rtol, until=at.UNTIL_HORIZON)
        assert found.status == at.HORIZON_REACHED
        within = max(100 * rtol, 2e-7 if name in CASES else 5e-7)
        assert (found.xi_end, found.eta_end) == pytest.approx((expected.xi, expected.eta), abs=within)
    assert found.sticks == passed.count("stick")


@pytest.mark.parametrize("name", CASES)
def test_everything_turns_round_with_the_direction(name):
    case, _ = CASES[name]
    flipped = case | {key: -case[key] for key in ("belt", "xi", "eta") if key in case}
    there, back = (outcome(**c, horizon=HORIZON, until=at.UNTIL_HORIZON).values for c in (case, flipped))
    mirrored = there.copy()
    for row in (at.RESTICK_XI, at.XI_END, at.ETA_END, at.XI_SETTLED):
        mirrored[row] *= -1.0
    for high, low in ((at.XI_MAX, at.XI_MIN), (at.CYCLE_XI_MAX, at.CYCLE_XI_MIN)):
        mirrored[[high, low]] = -there[[low, high]]
    np.testing.assert_array_equal(back, mirrored)


def test_break_away_leaves_the_mass_slipping_forwards():
    """Speed and acceleration vanish together there; a sign lost to rounding would send the mass backwards."""
    belts = np.geomspace(1e-6, 10.0, 500)
    results = run(block_of(*map(cell, belts)))
    assert (results[at.SPEED_MAX] > 0.0).all() and np.isin(results[at.REGIME], [at.STICK_SLIP, at.DAMPED]).all()
    np.testing.assert_allclose(results[at.BREAKAWAY_TIME], 1.3 / belts, rtol=1e-15)


@pytest.mark.parametrize("start", [{"xi": 0.5, "eta": -1e-12}, {"xi": 0.5 + 0.3, "eta": 0.0}])
def test_a_grazing_touch_is_not_a_stick_phase(start):
    """Undamped flat friction started so that the slip speed just reaches zero: one tangent touch in every turn."""
    assert outcome(0.3, (0.5, 0.0, 0.0, 1.0), **start, horizon=60.0, until=at.UNTIL_HORIZON).sticks == 0


def test_hysteresis_without_a_minimum_is_the_plain_curve():
    """The curve falls only below its minimum; a rising one has none, so mu_stop changes nothing."""
    rising = (0.5, 0.2, 0.0, 1.0)
    plain, stopped = (outcome(0.2, rising, mu_stop=m, horizon=30.0, until=at.UNTIL_HORIZON).values for m in (NAN, 0.4))
    np.testing.assert_array_equal(plain, stopped)


# --- events ---


CURVES = {"plain": {}, "hysteretic": {"mu_stop": 1.15}, "damped": {"gamma": 0.1}, "backwards": {"belt": -0.25}}


@pytest.mark.parametrize("case", CURVES.values(), ids=CURVES)
def test_error_of_the_restick_time_falls_with_the_tolerance(case):
    """Events are located to the order of the method: no worse than the steps around them."""
    case = {"belt": 0.25} | case
    exact = outcome(**case, rtol=1e-12)
    for rtol in (1e-5, 1e-7, 1e-9):
        found = outcome(**case, rtol=rtol)
        assert abs(found.restick_time - exact.restick_time) < rtol * (exact.restick_time - exact.breakaway_time)
        assert abs(found.restick_xi - exact.restick_xi) < 10 * rtol


@pytest.mark.parametrize("curve", [ARTICLE, (1.0, 0.3, 0.0, 1.0)])
def test_a_re_stick_that_dips_below_zero_and_returns_within_a_step_is_seen(curve):
    """Steps may be coarse: a slip speed that grazes zero from above must neither be passed nor invented."""
    cells = block_of(*(cell(b, curve, xi=curve[0], eta=0.0, horizon=40.0) for b in np.linspace(0.3, 0.9, 61)))
    coarse, fine = (run(cells, rtol, until=at.UNTIL_HORIZON)[at.STICKS] for rtol in (1e-4, 1e-9))
    np.testing.assert_array_equal(coarse, fine)


def test_the_reversal_point_is_where_the_slip_speed_turns_or_passes_the_minimum():
    """A fast slip turns at the minimum of the curve; a slow one before it, at its last peak of slip speed."""
    a1, a2, a3, a4 = ARTICLE
    w_min = a4 * np.log(a3 / (a2 * a4))
    minimum = a1 + a2 * w_min + a3 * np.exp(-w_min / a4)
    fast = outcome(0.2, mu_stop=1.15)
    assert fast.speed_max > w_min
    assert fast.mu_reversal == pytest.approx(minimum, rel=1e-12)
    slow = outcome(0.03, (1.0, 0.05, 0.3, 0.4), mu_stop=1.2)
    w = slow.speed_max
    assert slow.regime == at.STICK_SLIP
    assert slow.mu_reversal == pytest.approx(1.0 + 0.05 * w + 0.3 * np.exp(-w / 0.4), rel=1e-6)
