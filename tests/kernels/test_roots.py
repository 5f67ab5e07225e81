"""Roots inside a step: any, and by the short way."""

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st
from scipy.optimize import minimize_scalar

from helpers.nightly import few
from helpers.slip_step import LANE, exact, holding, lanes, numbers, polynomials
from stickslip_kernels import layout as at
from stickslip_kernels.contacts.stribeck import taylor
from stickslip_kernels.contacts.stribeck.extreme_slope import extreme_slope
from stickslip_kernels.contacts.stribeck.laws import LAWS
from stickslip_kernels.dense import rise_and_work, speed
from stickslip_kernels.roots import (
    FOR_A_VALUE,
    TO_ROUNDING,
    arrival,
    crossing,
    extreme_speed,
    inverse_cubic,
    sign_before,
)

LAW = LAWS["stribeck"]


@given(polynomials, st.integers(0, 2), numbers)
def test_a_crossing_is_a_root_before_which_the_sign_does_not_change_for_good(p, order, level):
    f = np.polynomial.Polynomial(p).deriv(order) if order else np.polynomial.Polynomial(p)
    s = holding(p)
    assume(sign_before(s, LANE, order, level) * (f(1.0) - level) < -1e-3)
    t = crossing(s, LANE, order, level, 1.0, speed(s, LANE, 1.0), TO_ROUNDING)
    assert 0.0 <= t <= 1.0
    around = [f(max(t - 1e-7, 0.0)) - level, f(min(t + 1e-7, 1.0)) - level]
    assert abs(f(t) - level) < 1e-10 or around[0] * around[1] <= 0.0


@pytest.mark.parametrize("root", [5e-6, 5e-8, 1e-3, 0.3])
def test_a_crossing_close_to_the_zero_one_stands_on_is_found_as_exactly_as_any(root):
    """Hypothesis found 1.04e-5 for 5e-6: the tolerance counted from the length of the step."""
    f = np.polynomial.Polynomial([0.0, -root, 1.0]).integ(2)
    s = holding(f.coef)
    found = crossing(s, LANE, 2, 0.0, 1.0, speed(s, LANE, 1.0), TO_ROUNDING)
    assert found == pytest.approx(root, rel=1e-9)


@pytest.mark.parametrize("gap", [1e-2, 1e-4, 1e-6])
def test_a_crossing_just_before_the_motion_turns_back_is_found_as_exactly_as_any(gap):
    """A slip that just re-sticks: w passes zero at 0.6 - gap and would again at 0.6 + gap."""
    s = holding([0.36 - gap**2, -1.2, 1.0])
    found = crossing(s, LANE, 0, 0.0, 0.6 + 0.3 * gap, speed(s, LANE, 0.6 + 0.3 * gap), TO_ROUNDING)
    assert found == pytest.approx(0.6 - gap, abs=1e-3 * gap)


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


@given(polynomials, numbers)
def test_an_arrival_is_a_crossing_with_what_went_on_till_then(p, level):
    f, s = np.polynomial.Polynomial(p), holding(p)
    s[at.B + LANE] = 0.7
    side = 1.0 if f(1.0) > level else -1.0
    assume(sign_before(s, LANE, 0, level) * (f(1.0) - level) < -1e-3)
    t, rise, work = arrival(s, LANE, level, side, 1.0, speed(s, LANE, 1.0))
    assert 0.0 <= t <= 1.0
    around = [f(max(t - 1e-7, 0.0)) - level, f(min(t + 1e-7, 1.0)) - level]
    assert abs(f(t) - level) < 1e-9 or around[0] * around[1] <= 0.0
    assert rise == pytest.approx(0.7 * t - f.integ()(t), abs=1e-9)
    assert work == pytest.approx(rise_and_work(s, LANE, t)[2], abs=1e-9)


def test_an_arrival_is_never_where_the_step_starts():
    """After stick, w = 0 at the start as well."""
    s = holding([0.0, 0.5, -1.0])
    t, rise, _ = arrival(s, LANE, 0.0, -1.0, 1.0, speed(s, LANE, 1.0))
    assert (t, rise) == pytest.approx((0.5, -0.5 * 0.25 * 0.5 + 0.125 / 3), abs=1e-13)


@given(polynomials)
def test_extreme_speeds_are_those_at_roots_of_the_derivative(p):
    f, s = np.polynomial.Polynomial(p), holding(p)
    g = f.deriv()
    assume(g(0.0) * g(1.0) < -1e-3)
    roots = g.roots()
    values = f(roots[(abs(roots.imag) < 1e-6) & (roots.real > -1e-6) & (roots.real < 1.0 + 1e-6)].real)
    found = extreme_speed(s, LANE, 1.0, speed(s, LANE, 1.0), FOR_A_VALUE)[1]
    assert min(abs(values - found)) < 1e-5 * (1.0 + max(abs(values)))


@pytest.mark.parametrize("law", few(["stribeck", "rational", "gaussian"], 1))
@pytest.mark.parametrize(("rate", "y", "w"), [(3.0, 0.4, 0.4), (3e3, 0.6, 1e-3), (3e4, 0.3, 1e-4)])
def test_the_largest_slope_is_that_of_the_motion_however_steep_the_curve(law, rate, y, w):
    """Above a steep fall of friction, its tail bends w' where it no longer moves w."""
    step = np.inf
    for _ in range(60):
        s = lanes(law, y, w, rate=rate, step=step)
        taylor.try_step(LAWS[law], s, 1e-9)
        step = s[at.STEP]
        h, y_end, w_end, dw_end = s[at.TAKEN], s[at.Y_NEW], s[at.W_NEW], s[at.DW_NEW]
        if s[at.GOOD] and s[at.JERK] > 0.0 > s[at.JERK_NEW]:
            break
        if s[at.GOOD]:
            y, w = y_end, w_end
    else:
        pytest.fail("no step met the extremum")
    found = extreme_slope(LAWS[law], s, 0, h, (w_end, dw_end, s[at.JERK_NEW], 0.0))
    high = minimize_scalar(lambda t: -exact(t, law, y, w, rate=rate)[2], bounds=(0.0, h), options={"xatol": 1e-9 * h})
    assert found == pytest.approx(-high.fun, rel=1e-9)


def test_extreme_values_of_a_step_are_as_good_as_the_step():
    s = lanes(y=0.16, w=0.6)  # a little before a peak of the slip speed
    taylor.try_step(LAW, s, 1e-10)
    end = s[at.TAKEN]
    at_end = speed(s, 0, end)
    assert s[at.DW] > 0.0 > s[at.DW_NEW]
    fine = speed(s, 0, crossing(s, 0, 1, 0.0, end, at_end, TO_ROUNDING))[0]
    rough = speed(s, 0, crossing(s, 0, 1, 0.0, end, at_end, FOR_A_VALUE))[0]
    assert rough == pytest.approx(fine, rel=1e-12) and fine > s[at.W] > s[at.W_NEW]
    assert extreme_speed(s, 0, end, at_end, FOR_A_VALUE)[1] == pytest.approx(fine, rel=1e-12)
    when, value = extreme_speed(s, 0, end, at_end, TO_ROUNDING)
    assert when == pytest.approx(crossing(s, 0, 1, 0.0, end, at_end, TO_ROUNDING), rel=1e-14)
    assert value == pytest.approx(fine, rel=1e-15)
    s = lanes(y=0.4, w=0.4)  # a little before the acceleration peaks
    taylor.try_step(LAW, s, 1e-10)
    end = s[at.TAKEN]
    at_end = speed(s, 0, end)
    assert s[at.JERK] > 0.0 > s[at.JERK_NEW]
    fine = speed(s, 0, crossing(s, 0, 2, 0.0, end, at_end, TO_ROUNDING))[1]
    assert fine > s[at.DW]
    assert extreme_slope(LAW, s, 0, end, at_end) == pytest.approx(fine, rel=1e-11)


@given(st.floats(0.05, 0.95), st.floats(0.2, 2.0))
def test_the_first_guess_is_exact_for_a_cubic_of_t_over_f(root, bend):
    """t(f) = root + f + bend f^3 is monotone; f runs from -1 to 1 less what the ends ask for."""

    def time(f):
        return f + bend * f**3

    f0, f1 = -root, 1.0 - root
    t0, end = time(f0), time(f1) - time(f0)
    slopes = [1.0 / (1.0 + 3.0 * bend * f * f) for f in (f0, f1)]
    assert inverse_cubic(f0, slopes[0], f1, slopes[1], end) == pytest.approx(-t0, rel=1e-12)


def test_no_guess_where_the_slopes_differ_in_sign():
    assert not 0.0 < inverse_cubic(1.0, 1.0, -1.0, -1.0, 1.0) <= 1.0
