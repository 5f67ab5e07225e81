"""Closed-form slip along a line of friction, on steady belts and on such that accelerate: high precision and SciPy."""

import math

import mpmath
import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st
from scipy.integrate import quad

from stickslip_kernels.contacts.stribeck import hysteresis
from stickslip_kernels.contacts.stribeck.hysteresis import LONGEST, end_within, motion, response
from stickslip_kernels.roots import LEVEL_REACHED, NO_EVENT, TURNED

states = st.tuples(st.floats(-2.0, 2.0), st.floats(-2.0, -1e-3))
peaks = st.tuples(st.floats(0.01, 3.0), st.sampled_from([0.0, -1e-12, -1e-6]))  # no slope to go by, as a fall begins
drags = st.one_of(
    st.floats(-3.0, 3.0), st.floats(3.0, 1e6), st.sampled_from([2.0, -2.0, 0.0, 2.0 + 1e-12, 2.0 - 1e-12])
)
steeper = st.one_of(st.floats(-4.0, 4.0), st.floats(1.0, 12.0).map(lambda x: 10.0**x))
times = st.floats(-10.0, math.log10(LONGEST)).map(lambda x: 10.0**x)


@settings(max_examples=200)
@given(steeper, times)
def test_response_is_the_difference_of_two_exponentials(drag, t):
    with mpmath.workdps(80):
        half, t_ = mpmath.mpf(drag) / 2, mpmath.mpf(t)
        root = mpmath.sqrt(half**2 - 1) if abs(drag) != 2.0 else mpmath.mpf(10) ** -30
        a, b = -half + root, -half - root
        parts = (
            lambda x: x * mpmath.exp(x * t_), lambda x: mpmath.exp(x * t_), lambda x: mpmath.expm1(x * t_) / x,
            lambda x: (mpmath.expm1(x * t_) - x * t_) / x**2,
        )  # fmt: skip
        exact = [float(mpmath.re((f(a) - f(b)) / (a - b))) for f in parts]
    found = response(drag, t)
    assert found[0] == pytest.approx(exact[0], rel=1e-12, abs=1e-15)
    assert found[1:] == pytest.approx(exact[1:], rel=1e-12)


@given(states, drags, st.floats(0.0, 20.0))
def test_motion_on_a_steady_belt_is_the_linear_oscillator(state, drag, t):
    """By the matrix exponential with 50 digits."""
    q, v = state
    with mpmath.workdps(50):
        half = mpmath.mpf(drag) / 2
        root = mpmath.sqrt(mpmath.mpc(half * half - 1)) or mpmath.mpf("1e-30")
        slow, fast = -half + root, -half - root
        second = (v - slow * q) / (fast - slow)
        grow, fall = (q - second) * mpmath.exp(slow * t), second * mpmath.exp(fast * t)
        expected = float((grow + fall).real), float((slow * grow + fast * fall).real)
    size = (abs(q) + abs(v)) * math.exp(max(-drag, 0.0) * t)
    found = hysteresis.oscillation(q, v, drag, t)
    assert found == pytest.approx(expected, rel=1e-10, abs=1e-12 * size * (1 + abs(drag)))


@given(states, drags)
def test_turn_time_is_the_first_zero_of_the_acceleration(state, drag):
    q, v = state
    t = hysteresis.turn_time(q, v, drag)
    until = t if t < math.inf else 50.0
    assume(max(-drag, 0.0) * until < 500.0)  # else the motion has left the range of doubles by then
    scale = 1e-9 * (abs(q) + abs(v)) * math.exp(max(-drag, 0.0) * until)
    assert all(hysteresis.oscillation(q, v, drag, s)[1] <= scale for s in np.linspace(0.0, until, 400)[1:-1])
    if t < math.inf:
        assert abs(hysteresis.oscillation(q, v, drag, t)[1]) <= max(scale, 1e-9 * abs(v))


@given(states | peaks, drags, st.floats(0.05, 0.95))
def test_level_time_is_where_the_level_is(state, drag, share):
    q, v = state
    turn = hysteresis.turn_time(q, v, drag)
    assume(max(-drag, 0.0) * turn < 500.0 and (turn < math.inf or v < -1e-3))
    lowest = hysteresis.oscillation(q, v, drag, turn)[0]
    assume(q - lowest > 1e-6 * (abs(q) + 1e-3))
    level = lowest + share * (q - lowest)
    t = hysteresis.level_time(q, v, drag, level, turn)
    assert 0.0 < t < turn
    assert hysteresis.oscillation(q, v, drag, t)[0] == pytest.approx(level, abs=1e-12 * (abs(q) + abs(lowest)))


@given(states, st.floats(-1.9, 5.0), st.floats(0.01, 3.0))
def test_square_integral_is_the_integral(state, drag, t):
    q, v = state
    expected = quad(lambda s: hysteresis.oscillation(q, v, drag, s)[0] ** 2, 0.0, t, epsabs=1e-13, epsrel=1e-12)[0]
    assert hysteresis.square_integral(q, v, drag, t) == pytest.approx(expected, rel=1e-7, abs=1e-9)


# --- on a belt that accelerates ---------------------------------------------------------------------------------------


@given(steeper, st.floats(0.001, 2.0), st.floats(-1.0, 1.0), st.floats(-1.0, 1.0), st.floats(-1.0, 1.0), times)
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
    looked = np.linspace(0.0, h, 1001)[1:]
    there = np.array([motion(*case, x) for x in looked])[looked < t - 1e-9]
    assert (there[:, 0] > 0.0).all() and (there[:, 1] <= 1e-12).all()
    if kind == NO_EVENT:
        assert t == h
    else:
        assert motion(*case, t)[{LEVEL_REACHED: 0, TURNED: 1}[kind]] == pytest.approx(0.0, abs=1e-13)


@pytest.mark.parametrize("drag", [1e3, 1e6, 1e9])
def test_on_a_steep_line_the_slip_follows_the_load(drag):
    """Quasi-steady: w is the distance of the load from mu_stop over the slope, and turns as soon as the load rises."""
    gap, drop, belt = 0.37, 0.03, 0.2
    w, t, v, h, kind = gap / drag, 0.0, -drop, 0.5 / drag, NO_EVENT
    while kind == NO_EVENT:
        kind, step = end_within(w, v, belt - w, 0.0, drag, h)
        w, v, _, _ = motion(w, v, belt - w, 0.0, drag, step)
        t, h = t + step, 2.0 * h
    assert kind == TURNED
    assert w == pytest.approx((gap - drop + belt * t) / drag, rel=1e-5)
    assert t < 50.0 / drag
