"""The closed form of slip along a line, on a belt that accelerates."""

import math

import mpmath
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from stickslip_kernels.contacts.stribeck.hysteresis_line import LONGEST, end_within, motion, response
from stickslip_kernels.events import LEVEL_REACHED, NO_EVENT, TURNED

DRAGS = st.one_of(st.floats(-4.0, 4.0), st.floats(1.0, 12.0).map(lambda x: 10.0**x))
TIMES = st.floats(-10.0, math.log10(LONGEST)).map(lambda x: 10.0**x)


@settings(max_examples=200)
@given(DRAGS, TIMES)
def test_response_is_the_difference_of_two_exponentials(drag, t):
    with mpmath.workdps(80):
        half, t_ = mpmath.mpf(drag) / 2, mpmath.mpf(t)
        root = mpmath.sqrt(half**2 - 1) if abs(drag) != 2.0 else mpmath.mpf(10) ** -30
        a, b = -half + root, -half - root
        exact = [
            (f(a) - f(b)) / (a - b)
            for f in (
                lambda x: x * mpmath.exp(x * t_),
                lambda x: mpmath.exp(x * t_),
                lambda x: mpmath.expm1(x * t_) / x,
                lambda x: (mpmath.expm1(x * t_) - x * t_) / x**2,
            )
        ]
        exact = [float(mpmath.re(x)) for x in exact]
    found = response(drag, t)
    assert found[0] == pytest.approx(exact[0], rel=1e-12, abs=1e-15)
    assert found[1:] == pytest.approx(exact[1:], rel=1e-12)


@given(DRAGS, st.floats(0.001, 2.0), st.floats(-1.0, 1.0), st.floats(-1.0, 1.0), st.floats(-1.0, 1.0), TIMES)
def test_motion_obeys_its_equation(drag, w, v, push, alpha, t):
    w1, v1, jerk, snap = motion(w, v, push, alpha, drag, t)
    size = (1.0 + abs(drag)) ** 2
    assert jerk + drag * v1 + w1 == pytest.approx(push + w + alpha * t, abs=1e-12 * size)
    assert snap + drag * jerk + v1 == pytest.approx(alpha, abs=1e-12 * size * size)


@settings(max_examples=300)
@given(
    st.floats(-0.5, 3.0), st.floats(0.01, 1.0), st.floats(0.0, 2.0), st.floats(-1.0, 1.0), st.floats(-1.0, 1.0),
    st.floats(0.01, LONGEST),
)  # fmt: skip
def test_a_fall_ends_at_the_first_zero_of_speed_or_slope(drag, w, slowing, push, alpha, h):
    case = (w, -slowing, push, alpha, drag)
    kind, t = end_within(*case, h)
    times = np.linspace(0.0, h, 1001)[1:]
    there = np.array([motion(*case, x) for x in times])
    before = times < t - 1e-9
    assert (there[before, 0] > 0.0).all()
    assert (there[before, 1] <= 1e-12).all()
    at_end = motion(*case, t)
    if kind == NO_EVENT:
        assert t == h
    else:
        assert at_end[{LEVEL_REACHED: 0, TURNED: 1}[kind]] == pytest.approx(0.0, abs=1e-13)


@pytest.mark.parametrize("drag", [1e3, 1e6, 1e9])
def test_on_a_steep_line_the_slip_follows_the_load(drag):
    """Quasi-steady: w is the distance of the load from mu_stop over the slope, and turns as soon as the load rises."""
    gap, drop, belt = 0.37, 0.03, 0.2
    w, t = gap / drag, 0.0
    v, h = -drop, 0.5 / drag
    kind = NO_EVENT
    while kind == NO_EVENT:
        kind, step = end_within(w, v, belt - w, 0.0, drag, h)
        w, v, _, _ = motion(w, v, belt - w, 0.0, drag, step)
        t, h = t + step, 2.0 * h
    assert kind == TURNED
    assert w == pytest.approx((gap - drop + belt * t) / drag, rel=1e-5)
    assert t < 50.0 / drag
