"""The motion inside a step."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from helpers.slip_step import LANE, exact, holding, lanes, polynomials
from stickslip_kernels import layout as at
from stickslip_kernels.contacts.stribeck import taylor
from stickslip_kernels.contacts.stribeck.equations import state_at
from stickslip_kernels.contacts.stribeck.laws import LAWS
from stickslip_kernels.dense import horner, integral_by_ends, rise_and_work, speed, work_by_ends


@given(polynomials, st.floats(0.0, 1.0))
def test_speed_is_the_polynomial_and_its_derivatives(p, t):
    f = np.polynomial.Polynomial(p)
    expected = [f(t), *(f.deriv(n)(t) for n in (1, 2, 3))]
    assert speed(holding(p), LANE, t) == pytest.approx(expected, abs=1e-9)
    integrals = [f.integ(n)(t) for n in (1, 2)]
    assert horner(holding(p), LANE, t) == pytest.approx(
        [*expected[:2], expected[2] / 2, expected[3] / 6, *integrals, f.deriv(4)(t) / 24], abs=1e-9
    )


@pytest.mark.parametrize("gamma", [0.0, 0.05, 1.0])
@pytest.mark.parametrize("share", [0.0, 0.3, 1.0])
def test_state_inside_a_step_is_that_of_scipy(gamma, share):
    s = lanes(gamma=gamma)
    taylor.try_step(LAWS["stribeck"], s, 1e-10)
    t = share * s[at.TAKEN]
    y, w, dw, work = exact(t, gamma=gamma)
    assert state_at(LAWS["stribeck"], s, LANE, t) == pytest.approx((y, w, dw, work), rel=1e-9, abs=1e-12)
    assert rise_and_work(s, LANE, t)[1] == pytest.approx(y - exact(0.0, gamma=gamma)[0], abs=1e-10)


@given(st.lists(st.floats(-2.0, 2.0), min_size=6, max_size=6), st.floats(0.1, 2.0))
def test_the_integral_from_both_ends_is_exact_for_polynomials_of_degree_five(p, h):
    f = np.polynomial.Polynomial(p)
    ends = [f.deriv(n)(t) if n else f(t) for n in range(3) for t in (0.0, h)]
    assert integral_by_ends(h, *ends) == pytest.approx(f.integ()(h), abs=1e-9)


@pytest.mark.parametrize("gamma", [0.0, 0.05, 1.0])
def test_friction_work_from_both_ends_is_that_of_scipy(gamma):
    s = lanes(gamma=gamma)
    taylor.try_step(LAWS["stribeck"], s, 1e-10)
    assert work_by_ends(s, LANE, s[at.TAKEN + LANE]) == pytest.approx(exact(s[at.TAKEN], gamma=gamma)[3], rel=1e-7)
