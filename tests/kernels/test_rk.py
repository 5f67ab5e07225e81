"""The step against SciPy at tight tolerance, and its order."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.integrate import solve_ivp

from stickslip_kernels.exponential import rough_log2
from stickslip_kernels.laws import LAWS
from stickslip_kernels.rk import (
    GROW_MOST,
    SHRINK_MOST,
    friction_power,
    rk_step,
    slip_acceleration,
    slip_jerk,
    step_factor,
)

B, GAMMA, OFFSET, SLOPE, DROP, RATE = 0.4, 0.05, 1.0, 0.1, 0.3, 3.0
LAW = (B, GAMMA, OFFSET, SLOPE, DROP, RATE, 1.0)
TAG = LAWS["stribeck"]
Y0, W0 = 0.4, 0.3


def slip(_, state):
    """u' = b - w, w' = u + gamma u' - mu(w) written out, and the friction work."""
    u, w, _ = state
    mu = OFFSET + SLOPE * w + DROP * np.exp(-RATE * w)
    return [B - w, u + GAMMA * (B - w) - mu, mu * w]


def exact(t):
    start = [Y0 - GAMMA * B + OFFSET, W0, 0.0]
    u, w, work = solve_ivp(slip, (0.0, t), start, "DOP853", rtol=1e-13, atol=1e-14).y[:, -1]
    return u + GAMMA * B - OFFSET, w, work


def steps(t, n):
    """n equal steps to time t."""
    y, w, work = Y0, W0, 0.0
    k = slip_acceleration(TAG, y, w, GAMMA + SLOPE, DROP, RATE, 1.0)
    for _ in range(n):
        y, w, k, done = rk_step(TAG, t / n, y, w, k, *LAW)
        work += done
    return y, w, work


def test_error_falls_with_the_fifth_power_of_the_step():
    errors = [np.linalg.norm(np.subtract(steps(5.0, n), exact(5.0))) for n in (40, 80, 160)]
    orders = np.log2(np.divide(errors[:-1], errors[1:]))
    assert orders == pytest.approx(5.0, abs=0.25)


def test_many_steps_reach_the_answer_of_scipy():
    assert steps(2.0, 400) == pytest.approx(exact(2.0), rel=1e-12)


def test_jerk_is_the_derivative_of_the_acceleration():
    k = slip_acceleration(TAG, Y0, W0, GAMMA + SLOPE, DROP, RATE, 1.0)
    jerk = slip_jerk(TAG, Y0, W0, k, B, GAMMA + SLOPE, DROP, RATE, 1.0)
    h = 1e-5
    forward, backward = (rk_step(TAG, s, Y0, W0, k, *LAW)[2] for s in (h, -h))
    assert jerk == pytest.approx((forward - backward) / (2 * h), rel=1e-8)


def test_power_is_the_friction_coefficient_times_the_slip_speed():
    k = slip_acceleration(TAG, Y0, W0, GAMMA + SLOPE, DROP, RATE, 1.0)
    mu = OFFSET + SLOPE * W0 + DROP * np.exp(-RATE * W0)
    assert friction_power(Y0, W0, k, GAMMA, OFFSET) == pytest.approx(mu * W0, rel=1e-14)


@given(st.floats(0.0, 1e10), st.floats(-50.0, 50.0))
def test_the_step_changes_within_limits_and_shrinks_after_a_rejection(error2, last_log):
    factor, log = step_factor(error2, last_log)
    assert SHRINK_MOST <= factor <= (GROW_MOST if error2 <= 1.0 else 0.9)
    assert log == rough_log2(max(error2, 1e-16))


def test_after_a_step_that_is_not_a_number_the_next_is_smallest():
    assert step_factor(float("nan"), 0.0)[0] == SHRINK_MOST


def test_the_step_follows_the_error_to_the_power_one_fifth_in_steady_state():
    """Twice the same error e: PI control gives 0.9 e^-(alpha - beta), alpha - beta = 0.2 - 1.75 * 0.08."""
    error = 1e-3
    log = step_factor(error**2, 0.0)[1]
    assert step_factor(error**2, log)[0] == pytest.approx(0.9 * error ** -(0.2 - 1.75 * 0.08), rel=0.01)
