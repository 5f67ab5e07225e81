"""Closed-form slip along a line of friction, against high precision and SciPy."""

import math

import mpmath
import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st
from scipy.integrate import quad

from stickslip_kernels.contacts.stribeck import hysteresis_line

states = st.tuples(st.floats(-2.0, 2.0), st.floats(-2.0, -1e-3))
drags = st.one_of(
    st.floats(-3.0, 3.0), st.floats(3.0, 1e6), st.sampled_from([2.0, -2.0, 0.0, 2.0 + 1e-12, 2.0 - 1e-12])
)


def exact_motion(q, v, drag, t):
    """q and v by the matrix exponential with 50 digits."""
    with mpmath.workdps(50):
        half = mpmath.mpf(drag) / 2
        root = mpmath.sqrt(mpmath.mpc(half * half - 1)) or mpmath.mpf("1e-30")
        slow, fast = -half + root, -half - root
        second = (v - slow * q) / (fast - slow)
        first = q - second
        grow, fall = mpmath.exp(slow * t), mpmath.exp(fast * t)
        return float((first * grow + second * fall).real), float((first * slow * grow + second * fast * fall).real)


@given(states, drags, st.floats(0.0, 20.0))
def test_motion_is_the_linear_oscillator(state, drag, t):
    q, v = state
    expected = exact_motion(q, v, drag, t)
    size = (abs(q) + abs(v)) * math.exp(max(-drag, 0.0) * t)
    assert hysteresis_line.oscillation(q, v, drag, t) == pytest.approx(
        expected, rel=1e-10, abs=1e-12 * size * (1 + abs(drag))
    )


@given(states, drags)
def test_turn_time_is_the_first_zero_of_the_acceleration(state, drag):
    q, v = state
    t = hysteresis_line.turn_time(q, v, drag)
    until = t if t < math.inf else 50.0
    assume(max(-drag, 0.0) * until < 500.0)  # else the motion has left the range of doubles by then
    times = np.linspace(0.0, until, 400)[1:-1]
    scale = 1e-9 * (abs(q) + abs(v)) * math.exp(max(-drag, 0.0) * until)
    assert all(hysteresis_line.oscillation(q, v, drag, s)[1] <= scale for s in times)
    if t < math.inf:
        assert abs(hysteresis_line.oscillation(q, v, drag, t)[1]) <= max(scale, 1e-9 * abs(v))


@given(states, drags, st.floats(0.05, 0.95))
def test_level_time_is_where_the_level_is(state, drag, share):
    q, v = state
    turn = hysteresis_line.turn_time(q, v, drag)
    assume(max(-drag, 0.0) * turn < 500.0)  # else the motion has left the range of doubles by then
    lowest = hysteresis_line.oscillation(q, v, drag, turn)[0]
    assume(q - lowest > 1e-6 * (abs(q) + 1e-3))
    level = lowest + share * (q - lowest)
    t = hysteresis_line.level_time(q, v, drag, level, turn)
    assert 0.0 < t < turn
    assert hysteresis_line.oscillation(q, v, drag, t)[0] == pytest.approx(level, abs=1e-12 * (abs(q) + abs(lowest)))


@given(st.floats(0.01, 3.0), drags, st.floats(0.05, 0.95), st.sampled_from([0.0, -1e-12, -1e-6]))
def test_level_time_from_a_peak(q, drag, share, v):
    """Each fall begins where the slip speed is highest: no slope to go by."""
    turn = hysteresis_line.turn_time(q, v, drag)
    assume(turn < math.inf)
    lowest = hysteresis_line.oscillation(q, v, drag, turn)[0]
    assume(q - lowest > 1e-6 * q)
    level = lowest + share * (q - lowest)
    t = hysteresis_line.level_time(q, v, drag, level, turn)
    assert 0.0 < t < turn
    assert hysteresis_line.oscillation(q, v, drag, t)[0] == pytest.approx(level, abs=1e-12 * (abs(q) + abs(lowest)))


@given(states, st.floats(-1.9, 5.0), st.floats(0.01, 3.0))
def test_square_integral_is_the_integral(state, drag, t):
    q, v = state
    expected = quad(lambda s: hysteresis_line.oscillation(q, v, drag, s)[0] ** 2, 0.0, t, epsabs=1e-13, epsrel=1e-12)[0]
    assert hysteresis_line.square_integral(q, v, drag, t) == pytest.approx(expected, rel=1e-7, abs=1e-9)
