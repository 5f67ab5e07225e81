"""The motion inside a step, a polynomial: its values, its roots, and its extremes."""

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st
from numba import njit
from scipy.optimize import minimize_scalar

from helpers.nightly import few
from helpers.slip_step import LANE, exact, holding, lanes, numbers, polynomials
from stickslip_kernels import layout as at
from stickslip_kernels.contacts.stribeck import taylor
from stickslip_kernels.contacts.stribeck.equations import extreme_slope, state_at
from stickslip_kernels.contacts.stribeck.laws import LAWS
from stickslip_kernels.dense import horner, integral_by_ends, rise_and_work, speed, work_by_ends
from stickslip_kernels.roots import FOR_A_VALUE, TO_ROUNDING, arrival, crossing, extreme_speed, sign_before


@njit
def extreme_slope_of(law, s, h, at_end):
    return extreme_slope(law, s, LANE, h, at_end)


def crossing_of(coefficients, order, level, end):
    s = holding(coefficients)
    return crossing(s, LANE, order, level, end, speed(s, LANE, end), TO_ROUNDING)


def is_root(f, t, level, within):
    around = [f(max(t - 1e-7, 0.0)) - level, f(min(t + 1e-7, 1.0)) - level]
    return 0.0 <= t <= 1.0 and (abs(f(t) - level) < within or around[0] * around[1] <= 0.0)


@given(polynomials, st.floats(0.0, 1.0))
def test_values_are_those_of_the_polynomial_and_its_derivatives(p, t):
    f = np.polynomial.Polynomial(p)
    w = [f(t), *(f.deriv(n)(t) for n in (1, 2, 3, 4))]
    assert speed(holding(p), LANE, t) == pytest.approx(w[:4], abs=1e-9)
    expected = [*w[:2], w[2] / 2, w[3] / 6, f.integ(1)(t), f.integ(2)(t), w[4] / 24]
    assert horner(holding(p), LANE, t) == pytest.approx(expected, abs=1e-9)


@given(st.lists(st.floats(-2.0, 2.0), min_size=6, max_size=6), st.floats(0.1, 2.0))
def test_the_integral_from_both_ends_is_exact_for_polynomials_of_degree_five(p, h):
    f = np.polynomial.Polynomial(p)
    ends = [f.deriv(n)(t) if n else f(t) for n in range(3) for t in (0.0, h)]
    assert integral_by_ends(h, *ends) == pytest.approx(f.integ()(h), abs=1e-9)


@pytest.mark.parametrize("gamma", [0.0, 0.05, 1.0])
def test_state_and_friction_work_inside_a_step_are_those_of_scipy(gamma):
    s = lanes(gamma=gamma)
    taylor.try_step(LAWS["stribeck"], s, 1e-10)
    for t in np.array([0.0, 0.3, 1.0]) * s[at.TAKEN]:
        y, *rest = exact(t, gamma=gamma)
        assert state_at(LAWS["stribeck"], s, LANE, t) == pytest.approx((y, *rest), rel=1e-9, abs=1e-12)
        assert rise_and_work(s, LANE, t)[1] == pytest.approx(y - exact(0.0, gamma=gamma)[0], abs=1e-10)
    assert work_by_ends(s, LANE, t) == pytest.approx(rest[-1], rel=1e-7)


@given(polynomials, st.integers(0, 2), numbers)
def test_a_crossing_is_a_root_before_which_the_sign_does_not_change_for_good(p, order, level):
    f = np.polynomial.Polynomial(p).deriv(order) if order else np.polynomial.Polynomial(p)
    assume(sign_before(holding(p), LANE, order, level) * (f(1.0) - level) < -1e-3)
    assert is_root(f, crossing_of(p, order, level, 1.0), level, 1e-10)


@pytest.mark.parametrize("root", [5e-6, 5e-8, 1e-3, 0.3])
def test_a_crossing_close_to_the_zero_one_stands_on_is_found_as_exactly_as_any(root):
    """Hypothesis found 1.04e-5 for 5e-6: the tolerance counted from the length of the step."""
    p = np.polynomial.Polynomial([0.0, -root, 1.0]).integ(2).coef
    assert crossing_of(p, 2, 0.0, 1.0) == pytest.approx(root, rel=1e-9)


@pytest.mark.parametrize(("coefficients", "end", "root", "within"), [
    *(([0.36 - gap**2, -1.2, 1.0], 0.6 + 0.3 * gap, 0.6 - gap, 1e-3 * gap) for gap in (1e-2, 1e-4, 1e-6)),  # re-sticks
    ([0.08, -0.6, 1.0], 0.3, 0.2, 1e-14),  # the far end is the lowest point, where Newton's method fails
    ([1.0, 0.0, 1.0], 0.7, 0.7, 0.0),  # no change of sign: the end
])  # fmt: skip
def test_a_crossing_just_before_the_motion_turns_back_is_found_as_exactly_as_any(coefficients, end, root, within):
    assert crossing_of(coefficients, 0, 0.0, end) == pytest.approx(root, abs=within)


@given(st.floats(0.1, 0.9), st.integers(1, 2))
def test_the_zero_one_stands_on_is_not_the_crossing(where, multiplicity):
    """Every break-away starts on w = 0, and on w' = 0 too where static friction ends on the curve."""
    p = np.polynomial.Polynomial.fromroots([0.0] * multiplicity + [where])
    assert crossing_of(p.coef, 0, 0.0, 1.0) == pytest.approx(where, abs=1e-12)


@given(polynomials, numbers)
def test_an_arrival_is_a_crossing_with_what_went_on_till_then(p, level):
    f, s = np.polynomial.Polynomial(p), holding(p)
    s[at.B + LANE] = 0.7
    assume(sign_before(s, LANE, 0, level) * (f(1.0) - level) < -1e-3)
    t, rise, work = arrival(s, LANE, level, 1.0, speed(s, LANE, 1.0))
    assert is_root(f, t, level, 1e-9)
    assert rise == pytest.approx(0.7 * t - f.integ()(t), abs=1e-9)
    assert work == pytest.approx(rise_and_work(s, LANE, t)[2], abs=1e-9)


def test_an_arrival_is_never_where_the_step_starts():
    """After stick, w = 0 at the start as well."""
    s = holding([0.0, 0.5, -1.0])
    t, rise, _ = arrival(s, LANE, 0.0, 1.0, speed(s, LANE, 1.0))
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
    found = extreme_slope_of(LAWS[law], s, h, (w_end, dw_end, s[at.JERK_NEW], 0.0))
    high = minimize_scalar(lambda t: -exact(t, law, y, w, rate=rate)[2], bounds=(0.0, h), options={"xatol": 1e-9 * h})
    assert found == pytest.approx(-high.fun, rel=1e-9)
