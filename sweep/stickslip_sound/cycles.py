"""States on the cycles of cells, from which one period of them is sampled.

A cycle with a stick phase begins a little before its break-away: there the mass moves with the belt, and the load on
the contact says where it is. One without begins at the largest displacement along the belt, at rest, where friction
lies on the curve whatever came before. Both follow from what the kernels say of a cell. A contact with memory has a
state that no start can set: it is followed from its start until a period repeats, and sampled from there on.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from stickslip.engine import Options, Results, Scales, sampled
from stickslip.vocabulary.cells import Parameters, taken
from stickslip.vocabulary.flags import REGIMES, STATUSES

Floats = NDArray[np.float64]

RTOL = 1e-9  # of the motion, so that its errors are not heard beside it
LEAD = 0.02  # s of sticking before a break-away, at most
_PERIODIC = REGIMES.index("stick_slip"), REGIMES.index("sustained")
_REACHED = STATUSES.index("horizon_reached")
_FIRST, _DOUBLINGS = 8.0, 10  # periods that are waited for the cycle, and how often as many again
_ALIKE = 1e-6  # of their ranges: displacements and velocities a period apart, on the cycle
_PLACES = 1024  # of a period, which show where it slips
_STUCK, _QUIET = 1e-2, 1e-3  # of the belt speed, and of the fastest slip: what slips less is not heard
_PAUSE = 4  # places at least, of a stick phase
_CLOSER = 3  # looks, each at what slipped in the one before


@dataclass(frozen=True)
class StartedCycles:
    """Cells that have a cycle, started on it.

    which : their numbers among those asked for. cells : they, with start states on the cycle. period : s.
    moving : s, how long it is from the start until the mass sticks again; the period where it never does.
    begin : s after the start state, where that is not on the cycle.
    """

    which: NDArray[np.intp]
    cells: Parameters
    period: Floats
    moving: Floats
    begin: Floats


def cycles_of(cells: Parameters, results: Results, options: Options, lead: float = LEAD) -> StartedCycles:
    """The cycles of cells whose results are known; lead : s of sticking before the break-away, at most."""
    which = np.flatnonzero(np.isin(results["regime"], _PERIODIC) & (results["period"] > 0.0))
    own, results = taken(cells, which), taken(results, which)
    if "mu_breakaway" not in results:
        return _followed(which, own, results, options)
    sticks = results["regime"] == _PERIODIC[0]
    period, sticking = results["period"], np.where(sticks, results["stick_fraction"] * results["period"], 0.0)
    belt, ahead = own["belt_speed"], np.minimum(0.5 * sticking, lead)
    forward = belt > 0.0
    force = np.where(forward, results["cycle_force_max"], results["cycle_force_min"])
    load = np.where(forward, 1.0, -1.0) * results["mu_breakaway"] * Scales(own).load
    force = np.where(sticks, load - own["damping"] * belt - own["stiffness"] * belt * ahead, force)
    start = {
        "displacement": force / own["stiffness"],
        "velocity": np.where(sticks, np.nan, 0.0),
        "contact_time": np.where(sticks, sticking - ahead, 0.0),
    }
    moving = np.where(sticks, ahead + period - sticking, period)
    return StartedCycles(which, own | start, period, moving, np.zeros(which.size))


def _followed(which: NDArray[np.intp], cells: Parameters, results: Results, options: Options) -> StartedCycles:
    """Cycles that are followed until a period repeats; those that never do are left out."""
    period, begin, moving = results["period"], np.full(which.size, np.nan), np.array(results["period"])
    waiting, wait = np.arange(which.size), _FIRST
    for _ in range(_DOUBLINGS):
        if not waiting.size:
            break
        periods, counts = period[waiting], np.full(waiting.size, _PLACES + 1)
        motions, ends, status = sampled(taken(cells, waiting), periods / _PLACES, counts, options, wait * periods)
        apart = np.array([abs(x[-1] - x[0]) / np.ptp(x) for x in motions])
        apart = np.maximum(apart, np.abs(ends[:, 1] - ends[:, 0]) / (2.0 * results["velocity_amplitude"][waiting]))
        repeats = (status == _REACHED) & (apart < _ALIKE)
        begin[waiting[repeats]] = wait * period[waiting[repeats]]
        waiting, wait = waiting[~repeats], 2.0 * wait
    known = np.flatnonzero(np.isfinite(begin))
    for i in known:
        begin[i], moving[i] = _slip(taken(cells, slice(i, i + 1)), begin[i], period[i], options)
    return StartedCycles(which[known], taken(cells, known), period[known], moving[known], begin[known])


def _slip(cell: Parameters, begin: float, window: float, options: Options) -> tuple[float, float]:
    """From when on a cell slips in a period from `begin` on, and for how long, all its slips; the rest is silence."""
    for _ in range(_CLOSER):
        step = window / _PLACES
        (x,), *_ = sampled(cell, np.array([step]), np.array([_PLACES + 1]), options, begin)
        slipped = np.abs(np.diff(x) - cell["belt_speed"] * step)
        moves = np.flatnonzero(slipped > max(_STUCK * abs(float(cell["belt_speed"][0])) * step, _QUIET * slipped.max()))
        gaps = np.diff(np.append(moves, moves[:1] + _PLACES))  # the longest stick phase is what is left out
        longest = int(np.argmax(gaps))
        if gaps[longest] < _PAUSE:
            break
        begin += (int(moves[(longest + 1) % moves.size]) - 1) * step
        window = (_PLACES - int(gaps[longest]) + 3) * step
    return begin, window
