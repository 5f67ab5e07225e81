"""On a belt at constant speed a rig is a cell of a map: the same motion by the other state machine."""

import numpy as np
import pytest

from helpers.kernel_runs import block_of, cell
from helpers.kernel_runs import run as run_cells
from helpers.nightly import few
from helpers.rig_runs import NO_STOPS, drive_of, run
from stickslip_kernels import layout as at
from stickslip_kernels.contacts.stribeck.laws import LAWS

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
    found, _ = run(cells, drives, rtol=RTOL, law=law, stops=NO_STOPS)
    assert (found[at.RIG_STATUS] == at.HORIZON_REACHED).all()
    assert (tight[at.STATUS] == at.HORIZON_REACHED).all()
    # A touch that just sticks or just does not: the map itself answers otherwise at another tolerance.
    sure = np.abs(tight[at.XI_END] - loose[at.XI_END]) < 1e-5
    assert sure.sum() >= 0.95 * sure.size
    for row, same in PAIRS:
        np.testing.assert_allclose(found[row, sure], tight[same, sure], atol=1e-10, rtol=1e-10)
    assert (found[at.RIG_STICKS] > 1.0).sum() >= 5
