"""A rig on a belt at constant speed is a cell of a map: the same motion by the other machine, looked at in between."""

import numpy as np
import pytest

from helpers.kernel_runs import block_of, cell, outcome
from helpers.kernel_runs import run as run_cells
from helpers.nightly import few
from helpers.rig_runs import drive_of, run
from helpers.scipy_oscillator import Oscillator
from stickslip_kernels import layout as at
from stickslip_kernels.contacts.stribeck.laws import LAWS


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


@pytest.mark.parametrize("case", CASES.values(), ids=CASES)
def test_the_last_sample_is_the_state_a_map_reports(case):
    samples, found = trajectory(cell(**case, horizon=20.0), 2)
    np.testing.assert_allclose(samples, trajectory(cell(**case, horizon=20.0), 1001)[0][:, ::1000], atol=1e-13)
    mapped = outcome(**case, horizon=20.0, rtol=1e-9, until=at.UNTIL_HORIZON)
    assert samples[at.SIGNAL_XI, -1] == pytest.approx(mapped.xi_end, abs=1e-12)
    assert samples[at.SIGNAL_ETA, -1] == pytest.approx(mapped.eta_end, abs=1e-12)
    assert found[at.RIG_STEPS] == mapped.steps


HORIZON, RTOL = 40.0, 1e-10
PAIRS = (
    (at.RIG_XI_END, at.XI_END), (at.RIG_ETA_END, at.ETA_END), (at.RIG_STICKS, at.STICKS),
    (at.RIG_STICK_TIME, at.STICK_TIME), (at.RIG_BREAKAWAY_TIME, at.BREAKAWAY_TIME),
)  # fmt: skip


def contacts(law, hysteretic, n):
    """Contacts that begin within static friction: beyond it a rig counts a first stick phase, of no duration."""
    random = np.random.default_rng(17)
    for _ in range(n):
        a1, a3, a4 = random.uniform(0.3, 1.0), random.uniform(0.1, 0.5), random.uniform(0.1, 1.0)
        belt = random.choice([-1.0, 1.0]) * 10.0 ** random.uniform(-1.5, -0.2)
        case = {
            "belt": belt, "curve": (a1, random.uniform(0.01, 0.1), a3, a4), "gamma": random.choice([0.0, 0.02, 0.3]),
            "xi": random.uniform(-0.25, 0.25), "delta": random.choice([1.5, 2.0]) if law == "stribeck_delta" else 1.0,
        }  # fmt: skip
        if hysteretic:
            case["mu_stop"] = a1 * random.uniform(0.5, 1.0)
        if random.random() < 0.5:
            case |= {"mu_static": a1 + a3 + random.uniform(0.0, 0.1), "ageing": random.choice([0.0, 0.02])}
            case |= {"ageing_time": random.uniform(0.1, 2.0), "contact": random.choice([0.0, 3.0])}
        yield case


@pytest.mark.parametrize("hysteretic", [False, True], ids=["plain", "hysteretic"])
@pytest.mark.parametrize("law", few(LAWS, 1))
def test_one_segment_at_constant_speed_is_the_map(law, hysteretic):
    cells = [cell(horizon=HORIZON, **case) for case in contacts(law, hysteretic, 150)]
    tight, loose = (run_cells(block_of(*cells), rtol, until=at.UNTIL_HORIZON, law=law) for rtol in (RTOL, 100 * RTOL))
    drives = [drive_of((HORIZON, 0.0), start=column[at.BELT]) for column in cells]
    found, _ = run(cells, drives, rtol=RTOL, law=law)
    assert (found[at.RIG_STATUS] == at.HORIZON_REACHED).all()
    assert (tight[at.STATUS] == at.HORIZON_REACHED).all()
    # A touch that just sticks or just does not: the map itself answers otherwise at another tolerance.
    sure = np.abs(tight[at.XI_END] - loose[at.XI_END]) < 1e-5
    assert sure.sum() >= 0.95 * sure.size
    for row, same in PAIRS:
        np.testing.assert_allclose(found[row, sure], tight[same, sure], atol=1e-10, rtol=1e-10)
    assert (found[at.RIG_STICKS] > 1.0).sum() >= 5
