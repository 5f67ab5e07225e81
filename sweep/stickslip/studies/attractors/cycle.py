"""The unstable cycle of the plain curve: found backwards in time, where it attracts, and sampled over one period."""

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from stickslip.engine import Options, Scales, flows
from stickslip.studies.attractors.plain import backwards, start_on_cycle, steady_displacement
from stickslip.studies.attractors.starts import Motions
from stickslip.vocabulary.cells import Parameters, taken
from stickslip.vocabulary.flags import REGIMES, STATUSES

Floats = NDArray[np.float64]
Flags = NDArray[np.bool_]

RTOL = 1e-11  # of the cycle, whatever that of the map is
CLOSED = 1e-8  # how well the cycle must be known, over the displacement in a radian at the speed of the belt
SAMPLES = 513  # of a cycle
_STARTS = (1.0, 0.3, 0.03)  # of the guess
_PATIENCE = 20_000  # steps
_CORRECTIONS = 12
_COLLAPSED = 0.2  # of where the iteration began: what is smaller is on the way to steady sliding
_DISTURBANCE = 1e-5  # of the amplitude, for the slope of the return map
_SLIP_CYCLE = STATUSES.index("slip_cycle")


@dataclass(frozen=True)
class UnstableCycles:
    """The unstable cycles of some cells, backwards in time.

    closes : whether there is one, that closes. reach : how far its largest displacement is from steady sliding (m).
    period : s.
    """

    closes: Flags
    reach: Floats
    period: Floats


def find_cycles(cells: Parameters, work: Motions) -> UnstableCycles:
    """The unstable cycles of cells that have one by the theorems of `plain.py`; their belts move in positive direction.

    Newton's method on the return map of the motion backwards in time, from one largest displacement to the next: from
    a guess, which is good where friction is weak, and else from where that motion tends to. By itself it would tend to
    the cycle anyway, but too slowly to wait for where the damping is weak. There is only one cycle to be found.
    """
    back = backwards(cells)
    natural = 2.0 * np.pi * Scales(back).time
    cycles = _corrected(back, start_on_cycle(cells), natural, work.options)
    rest = ~cycles.closes
    if rest.any():
        part = taken(back, rest)
        late = _corrected(part, *_approached(part, start_on_cycle(taken(cells, rest)), work), work.options)
        cycles.closes[rest], cycles.reach[rest], cycles.period[rest] = late.closes, late.reach, late.period
    return cycles


def _approached(back: Parameters, guess: Floats, work: Motions) -> tuple[Floats, Floats]:
    """Return where the motions backwards in time tend to, reach and period; NaN where that does not become clear.

    Those that start outside the cycle may leave w > 0, where they mean nothing.
    """
    centre = steady_displacement(back)
    reach, period = np.full_like(guess, np.nan), np.full_like(guess, np.nan)
    patient = replace(work.options, rtol=RTOL, horizon=np.inf, max_steps=_PATIENCE)
    for share in _STARTS:
        left = np.flatnonzero(np.isnan(reach))
        if not left.size:
            break
        start = centre[left] + share * guess[left], np.zeros(left.size)
        done = replace(work, options=patient).results(taken(back, left), *start)
        cycle = (done["regime"] == REGIMES.index("sustained")) & (done["status"] == _SLIP_CYCLE)
        at = left[cycle]
        reach[at] = done["cycle_force_max"][cycle] / back["stiffness"][at] - centre[at]
        period[at] = done["period"][cycle]
    return reach, period


def _corrected(back: Parameters, reach: Floats, period: Floats, options: Options) -> UnstableCycles:
    """Newton's method on the return map; a cycle that does not close in the end is none, nor is steady sliding.

    A guess that is far off may lead to the second return, or to a later one: the period is the time of the first.
    """
    reach, period = reach.copy(), period.copy()
    scale = np.abs(back["belt_speed"]) * Scales(back).time
    closes = np.isfinite(reach) & (reach > 0)
    least, defect = _COLLAPSED * reach, np.full(reach.size, np.inf)
    left = np.flatnonzero(closes)
    for _ in range(_CORRECTIONS):
        if not left.size:
            break
        most = 0.5 * reach[left]
        change, time = _correction(taken(back, left), reach[left], period[left], options)
        good = np.isfinite(change) & (time > 0)
        left, change = left[good], np.clip(change, -most, most)[good]
        reach[left] += change
        period[left] = time[good]
        defect[left] = np.abs(change) / scale[left]
        left = left[defect[left] > 0.01 * CLOSED]
    with np.errstate(invalid="ignore"):
        closes &= (defect <= CLOSED) & (reach > least)
    near = np.flatnonzero(closes)
    if near.size:
        velocity = sampled_motion(taken(back, near), reach[near], period[near], SAMPLES, options)["velocity"]
        returns = ((velocity[:, 1:] > 0) & (velocity[:, :-1] <= 0)).sum(axis=1)
        slips = velocity.max(axis=1) < back["belt_speed"][near]  # what reaches w = 0 does not
        closes[near] = (returns > 0) & slips
        period[near] /= np.maximum(returns, 1)
    return UnstableCycles(closes, reach, period)


def _correction(back: Parameters, reach: Floats, period: Floats, options: Options) -> tuple[Floats, Floats]:
    """The step of Newton's method, the slope being that to a motion close by; and the time of the return."""
    n = reach.size
    both = taken(back, np.tile(np.arange(n), 2))
    beside = reach * (1.0 + _DISTURBANCE)
    returned, time = _return(both, np.concatenate([reach, beside]), np.tile(period, 2), options)
    with np.errstate(divide="ignore", invalid="ignore"):
        slope = (returned[n:] - returned[:n]) / (beside - reach)
        return (returned[:n] - reach) / (1.0 - slope), time[:n]


def _return(back: Parameters, reach: Floats, period: Floats, options: Options) -> tuple[Floats, Floats]:
    """The next largest displacement after one at `reach`, near `period`, and when it comes."""
    motion = sampled_motion(back, reach, period, 2, options)
    x, v, a = motion["displacement"][:, -1], motion["velocity"][:, -1], motion["acceleration"][:, -1]
    with np.errstate(divide="ignore", invalid="ignore"):
        late = v / a  # v changes linearly as long as this is short, and Newton's method makes it so
        return x - steady_displacement(back) - 0.5 * v * late, period - late


def sampled_motion(
    back: Parameters, reach: Floats, period: Floats, samples: int, options: Options
) -> dict[str, Floats]:
    """Motions from rest at `reach` beyond steady sliding, over `period`; both ends included."""
    start = {"displacement": steady_displacement(back) + reach, "velocity": np.zeros(reach.size)}
    return flows(back | start, period, samples, replace(options, rtol=RTOL))
