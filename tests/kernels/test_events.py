"""Events are located to the order of the method: no worse than the steps around them."""

import numpy as np
import pytest

from helpers.kernel_runs import ARTICLE, outcome
from stickslip_kernels import layout as at

CURVES = {"plain": {}, "hysteretic": {"mu_stop": 1.15}, "damped": {"gamma": 0.1}, "backwards": {"belt": -0.25}}


@pytest.mark.parametrize("case", CURVES.values(), ids=CURVES)
def test_error_of_the_restick_time_falls_with_the_tolerance(case):
    given = {"belt": 0.25} | case
    exact = outcome(**given, rtol=1e-12)
    tolerances = np.array([1e-5, 1e-7, 1e-9])
    found = [outcome(**given, rtol=rtol) for rtol in tolerances]
    slip_time = exact.restick_time - exact.breakaway_time
    times = np.abs([f.restick_time - exact.restick_time for f in found]) / slip_time
    places = np.abs([f.restick_xi - exact.restick_xi for f in found])
    assert (times < tolerances).all()
    assert (places < 10 * tolerances).all()


@pytest.mark.parametrize("curve", [ARTICLE, (1.0, 0.3, 0.0, 1.0)])
def test_a_re_stick_that_dips_below_zero_and_returns_within_a_step_is_seen(curve):
    """Steps may be coarse: a slip speed that grazes zero from above must neither be passed nor invented."""
    coarse, fine = (
        [
            outcome(b, curve, xi=curve[0], eta=0.0, rtol=rtol, horizon=40.0, until=at.UNTIL_HORIZON)
            for b in np.linspace(0.3, 0.9, 61)
        ]
        for rtol in (1e-4, 1e-9)
    )
    assert [c.sticks for c in coarse] == [f.sticks for f in fine]


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
