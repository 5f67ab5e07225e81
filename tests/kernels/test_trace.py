"""Samples of a trajectory: the stepping of maps, looked at in between."""

import numpy as np
import pytest

from helpers.kernel_runs import Outcome, block_of, cell, run
from helpers.scipy_oscillator import Oscillator
from stickslip_kernels import layout as at
from stickslip_kernels.laws import LAWS
from stickslip_kernels.trace import sample


def trajectory(column, times, rtol=1e-9):
    log = np.zeros((20_000, at.LOG_COLUMNS))
    results = run(block_of(column), rtol=rtol, early_stop=False, log=log)
    assert log[0, 0] < len(log)
    samples = np.empty((at.SAMPLE_ROWS, times.size))
    sample(LAWS["stribeck"], log, column, times, samples)
    return samples, Outcome(results[:, 0])


CASES = {
    "plain": {"belt": 0.2},
    "backwards": {"belt": -0.2},
    "thrown": {"belt": 0.1, "xi": -3.0, "eta": -0.5, "gamma": 0.05},
    "hysteretic": {"belt": 0.2, "mu_stop": 1.1},
    "holding": {"belt": 0.3, "mu_stop": 1.0, "xi": 0.9, "eta": 0.05},
}


@pytest.mark.parametrize("case", CASES.values(), ids=CASES)
def test_samples_obey_the_equation_of_motion_and_the_friction_law(case):
    times = np.linspace(0.0, 25.0, 3001)
    column = cell(**case, horizon=25.0)
    samples, _ = trajectory(column, times)
    xi, relative, acceleration, friction, mode = samples
    eta = column[at.BELT] - relative
    np.testing.assert_allclose(acceleration + column[at.GAMMA] * eta + xi, friction, atol=1e-14)
    w = np.abs(relative)
    a1, a2, a3, a4 = column[[at.A1, at.A2, at.A3, at.A4]]
    on_curve = np.isin(mode, [at.RISE, at.FAST])
    np.testing.assert_allclose(np.abs(friction)[on_curve], (a1 + a2 * w + a3 * np.exp(-w / a4))[on_curve], rtol=1e-13)
    slips = mode != at.STICK
    assert (relative[~slips] == 0.0).all()
    assert (np.sign(relative) == np.sign(friction))[slips & (w > 1e-9)].all()
    assert (np.abs(friction)[~slips] <= a1 + a3 + 1e-12).all()
    assert (acceleration[np.isin(mode, [at.STICK, at.HOLD])] == 0.0).all()


@pytest.mark.parametrize("case", CASES.values(), ids=CASES)
@pytest.mark.parametrize("moment", [3.3, 9.1, 18.7])
def test_samples_between_steps_are_the_motion_of_scipy(case, moment):
    samples, _ = trajectory(cell(**case, horizon=25.0), np.array([moment]))
    expected = Oscillator(horizon=moment, **case)
    assert samples[at.SAMPLE_XI, 0] == pytest.approx(expected.xi, abs=1e-7)
    assert samples[at.SAMPLE_RELATIVE, 0] == pytest.approx(case["belt"] - expected.eta, abs=1e-7)


def test_samples_do_not_depend_on_how_many_there_are():
    column = cell(0.2, mu_stop=1.1, horizon=25.0)
    many, _ = trajectory(column, np.linspace(0.0, 25.0, 1001))
    few, _ = trajectory(column, np.linspace(0.0, 25.0, 11))
    np.testing.assert_array_equal(few, many[:, ::100])


def test_the_last_sample_is_the_state_a_map_reports():
    samples, outcome = trajectory(cell(0.2, mu_stop=1.1, horizon=20.0), np.array([0.0, 20.0]))
    assert samples[at.SAMPLE_XI, -1] == pytest.approx(outcome.xi_end, abs=1e-14)
    assert 0.2 - samples[at.SAMPLE_RELATIVE, -1] == pytest.approx(outcome.eta_end, abs=1e-14)


def test_a_log_changes_no_result():
    column = cell(0.2, mu_stop=1.1, horizon=20.0)
    _, logged = trajectory(column, np.array([0.0]), rtol=1e-6)
    np.testing.assert_array_equal(logged.values, run(block_of(column), early_stop=False)[:, 0])


def test_a_full_log_counts_on_so_that_the_caller_knows_how_much_it_takes():
    column, small, large = cell(0.2, horizon=60.0), np.zeros((5, at.LOG_COLUMNS)), np.zeros((9999, at.LOG_COLUMNS))
    for log in (small, large):
        run(block_of(column), early_stop=False, log=log)
    assert small[0, 0] == large[0, 0] > 5


def test_friction_heat_of_a_cycle_is_the_work_of_the_belt():
    """Over a closed cycle, undamped, all of the belt's work is heat: belt * integral of the spring force."""
    found = trajectory(cell(0.2, horizon=100.0), np.array([0.0]))[1]
    times = np.linspace(found.breakaway_time, found.breakaway_time + found.period, 20_001)
    samples, _ = trajectory(cell(0.2, horizon=100.0), times)
    assert found.cycle_heat == pytest.approx(0.2 * np.trapezoid(samples[at.SAMPLE_XI], times), rel=1e-7)


def test_what_enters_a_cycle_leaves_it_as_friction_and_damping_heat():
    """Belt work = friction heat + damper heat, the state being the same at both ends: with a damper this time."""
    belt, gamma = 0.2, 0.06
    found = trajectory(cell(belt, gamma=gamma, horizon=100.0), np.array([0.0]))[1]
    times = np.linspace(found.breakaway_time, found.breakaway_time + found.period, 20_001)
    xi, relative, *_ = trajectory(cell(belt, gamma=gamma, horizon=100.0), times)[0]
    eta = belt - relative
    # Friction jumps at re-stick, so its sum is taken from the other forces: the acceleration has no part in a cycle.
    belt_work, damper_heat = (np.trapezoid(power, times) for power in (belt * (xi + gamma * eta), gamma * eta**2))
    assert found.cycle_heat == pytest.approx(belt_work - damper_heat, rel=1e-7)
