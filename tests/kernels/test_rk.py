"""The Runge-Kutta pair: its orders by Butcher's conditions, the step against SciPy, rules of quadrature."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from helpers.slip_step import W0, Y0, end_of_step, exact, lanes
from stickslip_kernels import layout as at
from stickslip_kernels.contacts.stribeck import runge_kutta
from stickslip_kernels.contacts.stribeck.laws import LAWS
from stickslip_kernels.contacts.stribeck.runge_kutta import (
    ERROR_WEIGHTS,
    GROW_MOST,
    MATRIX,
    NODES,
    SHRINK_MOST,
    step_factor,
)  # fmt: skip
from stickslip_kernels.dense import gauss

LAW = "rational"
TAG = LAWS[LAW]
A = np.array(MATRIX)
C = np.array(NODES)
AC, AC2, AC3 = A @ C, A @ C**2, A @ C**3
# Elementary differentials and 1/density of the rooted trees up to order 5 (Hairer, Norsett & Wanner I, II.2).
TREES = {
    1: [(np.ones(7), 1)],
    2: [(C, 1 / 2)],
    3: [(C**2, 1 / 3), (AC, 1 / 6)],
    4: [(C**3, 1 / 4), (C * AC, 1 / 8), (AC2, 1 / 12), (A @ AC, 1 / 24)],
    5: [
        (C**4, 1 / 5), (C**2 * AC, 1 / 10), (AC**2, 1 / 20), (C * AC2, 1 / 15), (C * (A @ AC), 1 / 30),
        (AC3, 1 / 20), (A @ (C * AC), 1 / 40), (A @ AC2, 1 / 60), (A @ A @ AC, 1 / 120),
    ],
}  # fmt: skip


def test_the_pair_has_the_orders_five_and_four():
    def defect(weights, order):
        return max(abs(weights @ tree - density) for tree, density in TREES[order])

    weights, error = A[-1], np.array(ERROR_WEIGHTS)
    assert max(defect(weights, order) for order in (1, 2, 3, 4, 5)) < 1e-14
    assert max(defect(weights - error, order) for order in (1, 2, 3, 4)) < 1e-13 and defect(weights - error, 5) > 1e-4


@pytest.mark.parametrize("points", [1, 2, 5, 10])
def test_a_rule_of_quadrature_integrates_every_polynomial_it_is_exact_for(points):
    nodes, weights = map(np.array, gauss(points))
    for degree in range(2 * points):
        assert weights @ nodes**degree == pytest.approx(1.0 / (degree + 1), rel=1e-14)


def steps(t, n):
    """n equal steps to time t: y, w and the friction work."""
    y, w, work = Y0, W0, 0.0
    for _ in range(n):
        s = lanes(LAW, y, w, step=t / n)
        runge_kutta.try_step(TAG, s, 1e-6)
        y, w, _, done = end_of_step(s)
        work += done
    return y, w, work


def test_the_error_falls_with_the_fifth_power_of_the_step():
    y, w, _, work = exact(5.0, LAW)
    errors = np.array([np.linalg.norm(np.subtract(steps(5.0, n), (y, w, work))) for n in (60, 120, 240)])
    np.testing.assert_allclose(np.log2(errors[:-1] / errors[1:]), 5.0, atol=0.25)
    y, w, _, work = exact(2.0, LAW)
    assert steps(2.0, 400) == pytest.approx((y, w, work), rel=1e-12)


def test_between_its_ends_a_step_is_hardly_more_wrong_than_at_its_end():
    s = lanes(LAW, step=0.8)
    assert s[at.JERK] == pytest.approx((exact(1e-4, LAW)[2] - s[at.DW]) / 1e-4, rel=1e-3)
    runge_kutta.try_step(TAG, s, 1e-6)
    _, w, dw, _ = end_of_step(s)
    polynomial = np.polynomial.Polynomial(s[at.SERIES :: at.WIDTH][: at.ORDER + 1])
    ends = polynomial(0.8), polynomial.deriv()(0.8), polynomial.deriv(2)(0.8)
    assert ends == pytest.approx((w, dw, s[at.JERK_NEW]))
    inside = [abs(polynomial(t) - exact(t, LAW)[1]) for t in np.linspace(0.1, 0.7, 7)]
    assert 1e-8 < abs(w - exact(0.8, LAW)[1]) and max(inside) < 1.1 * abs(w - exact(0.8, LAW)[1])


@given(st.floats(0.0, 1e10) | st.just(np.nan), st.floats(-50.0, 50.0))
def test_the_step_changes_within_limits_and_shrinks_after_a_rejection(error2, last_log):
    assert SHRINK_MOST <= step_factor(error2, last_log)[0] <= (GROW_MOST if error2 <= 1.0 else 0.9)
