"""Samples of a cell on a steady belt: the stepping of maps, looked at in between."""

import numpy as np
import pytest

from helpers.kernel_runs import cell, outcome
from helpers.rig_runs import run
from helpers.scipy_oscillator import Oscillator
from stickslip_kernels import layout as at


def trajectory(column, n, rtol=1e-9):
    """Samples (SIGNAL_ROWS, n), evenly spaced from 0 to the horizon, and the results."""
    belt = np.array([[column[at.HORIZON], column[at.BELT], 0.0]])
    results, signals = run([column], [belt], n, rtol=rtol)
    assert results[at.RIG_STATUS, 0] == at.HORIZON_REACHED
    return signals[0], results[:, 0]


CASES = {
    "plain": {"belt": 0.2},
    "backwards": {"belt": -0.2},
    "thrown": {"belt": 0.1, "xi": -3.0, "eta": -0.5, "gamma": 0.05},
    "hysteretic": {"belt": 0.2, "mu_stop": 1.1},
    "holding": {"belt": 0.3, "mu_stop": 1.0, "xi": 0.9, "eta": 0.05},
}


@pytest.mark.parametrize("case", CASES.values(), ids=CASES)
def test_samples_obey_the_equation_of_motion_and_the_friction_law(case):
    column = cell(**case, horizon=25.0)
    xi, eta, friction, mode = trajectory(column, 3001)[0]
    relative = column[at.BELT] - eta
    w = np.abs(relative)
    a1, a2, a3, a4 = column[[at.A1, at.A2, at.A3, at.A4]]
    on_curve = np.isin(mode, [at.RISE, at.FAST])
    np.testing.assert_allclose(np.abs(friction)[on_curve], (a1 + a2 * w + a3 * np.exp(-w / a4))[on_curve], rtol=1e-13)
    slips = mode != at.STICK
    assert (relative[~slips] == 0.0).all()
    assert (np.sign(relative) == np.sign(friction))[slips & (w > 1e-9)].all()
    assert (np.abs(friction)[~slips] <= a1 + a3 + 1e-12).all()
    still = np.isin(mode, [at.STICK, at.HOLD])
    np.testing.assert_allclose((column[at.GAMMA] * eta + xi)[still], friction[still], atol=1e-14)


@pytest.mark.parametrize("case", CASES.values(), ids=CASES)
@pytest.mark.parametrize("moment", [3.3, 9.1, 18.7])
def test_samples_between_steps_are_the_motion_of_scipy(case, moment):
    samples, _ = trajectory(cell(**case, horizon=2.0 * moment), 3)
    expected = Oscillator(horizon=moment, **case)
    assert samples[at.SIGNAL_XI, 1] == pytest.approx(expected.xi, abs=1e-7)
    assert samples[at.SIGNAL_ETA, 1] == pytest.approx(expected.eta, abs=1e-7)


def test_samples_do_not_depend_on_how_many_there_are():
    column = cell(0.2, mu_stop=1.1, horizon=25.0)
    many, few = trajectory(column, 1001)[0], trajectory(column, 11)[0]
    np.testing.assert_allclose(few, many[:, ::100], atol=1e-13)


@pytest.mark.parametrize("case", CASES.values(), ids=CASES)
def test_the_last_sample_is_the_state_a_map_reports(case):
    samples, found = trajectory(cell(**case, horizon=20.0), 2)
    mapped = outcome(**case, horizon=20.0, rtol=1e-9, until=at.UNTIL_HORIZON)
    assert samples[at.SIGNAL_XI, -1] == pytest.approx(mapped.xi_end, abs=1e-12)
    assert samples[at.SIGNAL_ETA, -1] == pytest.approx(mapped.eta_end, abs=1e-12)
    assert found[at.RIG_STEPS] == mapped.steps


def one_cycle(belt, gamma=0.0):
    """A cell, and its motion from the first break-away to the second: times and samples."""
    found = outcome(belt, gamma=gamma, rtol=1e-9)
    end = found.breakaway_time + found.period
    column, times = cell(belt, gamma=gamma, horizon=end), np.linspace(found.breakaway_time, end, 20_001)
    belts = np.array([[end, belt, 0.0]])
    return found, times, run([column], [belts], times.size, start=found.breakaway_time, rtol=1e-9)[1][0]


def test_friction_heat_of_a_cycle_is_the_work_of_the_belt():
    """Over a closed cycle, undamped, all of the belt's work is heat: belt * integral of the spring force."""
    found, times, samples = one_cycle(0.2)
    assert found.cycle_heat == pytest.approx(0.2 * np.trapezoid(samples[at.SIGNAL_XI], times), rel=1e-7)


def test_what_enters_a_cycle_leaves_it_as_friction_and_damping_heat():
    """Belt work = friction heat + damper heat, the state being the same at both ends: with a damper this time."""
    belt, gamma = 0.2, 0.06
    found, times, (xi, eta, *_) = one_cycle(belt, gamma)
    # Friction jumps at re-stick, so its sum is taken from the other forces: the acceleration has no part in a cycle.
    belt_work, damper_heat = (np.trapezoid(power, times) for power in (belt * (xi + gamma * eta), gamma * eta**2))
    assert found.cycle_heat == pytest.approx(belt_work - damper_heat, rel=1e-7)
