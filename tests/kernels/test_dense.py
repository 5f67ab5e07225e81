"""The motion inside a step, and the roots found there."""

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st

from slip_step import exact, lanes
from stickslip_kernels import layout as at
from stickslip_kernels import taylor
from stickslip_kernels.dense import FOR_A_VALUE, TO_ROUNDING, crossing, rise_and_work, sign_before, speed, state_at
from stickslip_kernels.laws import LAWS

numbers = st.floats(-3.0, 3.0).map(lambda x: round(x, 6))
polynomials = st.lists(numbers, min_size=3, max_size=at.ORDER + 1)
LANE = 5


def holding(coefficients):
    """A buffer whose lane 5 moves along this polynomial of w."""
    s = np.zeros(at.LANE_NUMBERS)
    s[at.SERIES + LANE :: at.WIDTH][: len(coefficients)] = coefficients
    return s


@given(polynomials, st.floats(0.0, 1.0))
def test_speed_is_the_polynomial_and_its_derivatives(p, t):
    f = np.polynomial.Polynomial(p)
    expected = [f(t), *(f.deriv(n)(t) for n in (1, 2, 3))]
    assert speed(holding(p), LANE, t) == pytest.approx(expected, abs=1e-9)


@pytest.mark.parametrize("gamma", [0.0, 0.05, 1.0])
@pytest.mark.parametrize("share", [0.0, 0.3, 1.0])
def test_state_inside_a_step_is_that_of_scipy(gamma, share):
    s = lanes(gamma=gamma)
    taylor.try_step(s, 1e-10)
    t = share * s[at.TAKEN]
    y, w, dw, work = exact(t, gamma=gamma)
    assert state_at(LAWS["stribeck"], s, LANE, t) == pytest.approx((y, w, dw, work), rel=1e-9, abs=1e-12)
    assert rise_and_work(s, LANE, t)[1] == pytest.approx(y - exact(0.0, gamma=gamma)[0], abs=1e-10)


@given(polynomials, st.integers(0, 2), numbers)
def test_a_crossing_is_a_root_before_which_the_sign_does_not_change_for_good(p, order, level):
    f = np.polynomial.Polynomial(p).deriv(order) if order else np.polynomial.Polynomial(p)
    s = holding(p)
    assume(sign_before(s, LANE, order, level) * (f(1.0) - level) < -1e-3)
    t = crossing(s, LANE, order, level, 1.0, speed(s, LANE, 1.0), TO_ROUNDING)
    assert 0.0 <= t <= 1.0
    around = [f(max(t - 1e-7, 0.0)) - level, f(min(t + 1e-7, 1.0)) - level]
    assert abs(f(t) - level) < 1e-10 or around[0] * around[1] <= 0.0


def test_without_a_change_of_sign_the_end_returns():
    s = holding([1.0, 0.0, 1.0])
    assert crossing(s, LANE, 0, 0.0, 0.7, speed(s, LANE, 0.7), TO_ROUNDING) == 0.7


@given(st.floats(0.1, 0.9), st.integers(1, 2))
def test_the_zero_one_stands_on_is_not_the_crossing(where, multiplicity):
    """Every break-away starts on w = 0, and on w' = 0 too where static friction ends on the curve."""
    p = np.polynomial.Polynomial.fromroots([0.0] * multiplicity + [where])
    s = holding(p.coef)
    found = crossing(s, LANE, 0, 0.0, 1.0, speed(s, LANE, 1.0), TO_ROUNDING)
    assert found == pytest.approx(where, abs=1e-12)


def test_the_far_end_may_be_an_extremum_where_newton_fails():
    """A slip that dips below zero: the end of the search is its lowest point."""
    s = holding([0.08, -0.6, 1.0])  # zero at 0.2 and 0.4, lowest at 0.3
    found = crossing(s, LANE, 0, 0.0, 0.3, speed(s, LANE, 0.3), TO_ROUNDING)
    assert found == pytest.approx(0.2, abs=1e-14)


def test_a_value_at_an_extremum_needs_less():
    s = lanes(y=0.16, w=0.6)  # a little before a peak of the slip speed
    taylor.try_step(s, 1e-10)
    assert s[at.DW] > 0.0 > s[at.DW_NEW]
    rough, fine = (
        speed(s, 0, crossing(s, 0, 1, 0.0, s[at.TAKEN], speed(s, 0, s[at.TAKEN]), resolved))[0]
        for resolved in (FOR_A_VALUE, TO_ROUNDING)
    )
    assert rough == pytest.approx(fine, rel=1e-12) and fine > s[at.W] > s[at.W_NEW]
