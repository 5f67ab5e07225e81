"""The Runge-Kutta step against SciPy at tight tolerance, its order, and its step sizes."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from helpers.slip_step import GAMMA, SLOPE, W0, Y0, end_of_step, exact, lanes
from stickslip_kernels import layout as at
from stickslip_kernels.contacts.stribeck import runge_kutta
from stickslip_kernels.contacts.stribeck.laws import LAWS
from stickslip_kernels.contacts.stribeck.runge_kutta import GROW_MOST, SHRINK_MOST, step_factor
from stickslip_kernels.exponential import rough_log2

LAW = "rational"
TAG = LAWS[LAW]
DRAG = GAMMA + SLOPE


def steps(t, n):
    """n equal steps to time t: y, w and the friction work."""
    y, w, work = Y0, W0, 0.0
    for _ in range(n):
        s = lanes(LAW, y, w, step=t / n)
        runge_kutta.try_step(TAG, s, 1e-6)
        y, w, _, done = end_of_step(s)
        work += done
    return y, w, work


def expected(t):
    y, w, _, work = exact(t, LAW)
    return y, w, work


def test_error_falls_with_the_fifth_power_of_the_step():
    errors = [np.linalg.norm(np.subtract(steps(5.0, n), expected(5.0))) for n in (60, 120, 240)]
    orders = np.log2(np.divide(errors[:-1], errors[1:]))
    assert orders == pytest.approx(5.0, abs=0.25)


def test_many_steps_reach_the_answer_of_scipy():
    assert steps(2.0, 400) == pytest.approx(expected(2.0), rel=1e-12)


def one_step(h):
    """Slip speed and its two derivatives at the end of a step, and the polynomial of the slip speed within it."""
    s = lanes(LAW, step=h)
    runge_kutta.try_step(TAG, s, 1e-6)
    _, w, dw, _ = end_of_step(s)
    return (w, dw, s[at.JERK_NEW]), np.polynomial.Polynomial(s[at.SERIES :: at.WIDTH][: at.ORDER + 1])


def test_the_polynomial_of_a_step_ends_where_the_step_ends():
    ends, polynomial = one_step(0.8)
    assert [polynomial(0.8), polynomial.deriv()(0.8), polynomial.deriv(2)(0.8)] == pytest.approx(ends)


def test_between_its_ends_a_step_is_hardly_more_wrong_than_at_its_end():
    (w, *_), polynomial = one_step(0.8)
    end_error = abs(w - exact(0.8, LAW)[1])
    inside = [abs(polynomial(t) - exact(t, LAW)[1]) for t in np.linspace(0.1, 0.7, 7)]
    assert 1e-8 < end_error and max(inside) < 1.1 * end_error


def test_jerk_is_the_derivative_of_the_acceleration():
    s, h = lanes(LAW), 1e-4
    assert s[at.JERK] == pytest.approx((exact(h, LAW)[2] - s[at.DW]) / h, rel=1e-3)


@given(st.floats(0.0, 1e10), st.floats(-50.0, 50.0))
def test_the_step_changes_within_limits_and_shrinks_after_a_rejection(error2, last_log):
    assert SHRINK_MOST <= step_factor(error2, last_log)[0] <= (GROW_MOST if error2 <= 1.0 else 0.9)


@given(st.floats(0.0, 1e10), st.floats(-50.0, 50.0))
def test_the_next_call_is_told_the_logarithm_of_this_error(error2, last_log):
    assert step_factor(error2, last_log)[1] == rough_log2(max(error2, 1e-16))


def test_after_a_step_that_is_not_a_number_the_next_is_smallest():
    assert step_factor(float("nan"), 0.0)[0] == SHRINK_MOST


def test_after_twice_the_same_error_both_powers_of_pi_control_act_on_it():
    """0.9 e^-(alpha - beta) with alpha - beta = 0.2 - 1.75 * 0.08."""
    error = 1e-3
    log = step_factor(error**2, 0.0)[1]
    assert step_factor(error**2, log)[0] == pytest.approx(0.9 * error ** -(0.2 - 1.75 * 0.08), rel=0.01)
