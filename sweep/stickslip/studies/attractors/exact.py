"""The share that settles and the critical disturbances of cells whose phase plane is known, exactly.

For a phase portrait, the unstable cycle of a single cell as a closed line.
"""

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from stickslip.engine import Options, Results, stop_flag
from stickslip.studies.attractors import plain
from stickslip.studies.attractors.area import area_in_box, largest, velocities_at_rest_point
from stickslip.studies.attractors.cycle import SAMPLES, find_cycles, sampled_motion
from stickslip.studies.attractors.section import Attractors
from stickslip.studies.attractors.starts import Motions, Regimes, settled
from stickslip.vocabulary.cells import Parameters, taken
from stickslip.vocabulary.flags import REGIMES

Floats = NDArray[np.float64]
Flags = NDArray[np.bool_]

MOST_SAMPLES = 2**15 + 1  # of an unstable cycle
AREA_ERROR, _LEAST = 1e-6, 1e-3  # of the area, or of this share of the box, as half as many samples show it
_CYCLES = [REGIMES.index(name) for name in ("stick_slip", "sustained")]
_DISTURBANCES = [f"critical_{kind}_{way}" for kind in ("shock", "shift") for way in ("along", "against")]
_MEASURED = ("settling_share", "unstable_amplitude", "unstable_velocity_amplitude", "unstable_period", *_DISTURBANCES)


class Verdicts(NamedTuple):
    """Verdicts of the theorems of `plain.py` on some cells: their masks, empty where they say nothing.

    nowhere : nothing settles. everywhere : all states do. inside : those inside the unstable cycle do.
    """

    nowhere: Flags
    everywhere: Flags
    inside: Flags


def verdicts(cells: Parameters, stick: Regimes, work: Motions) -> Verdicts:
    """Return which theorem holds. stick : the regime reached from sticking."""
    known = plain.slips_on_curve(cells, work.options)
    if not known.any():
        return Verdicts(known, known, known)
    stable = plain.damping(cells) > 0
    everywhere = known & stable & plain.sticks_on_curve(cells) & settled(stick)
    far = taken(cells, everywhere)
    everywhere[everywhere] = settled(work.regimes(far, plain.beyond_all_cycles(far), np.zeros(far["mass"].size)))
    return Verdicts(known & ~stable, everywhere, known & stable & np.isin(stick, _CYCLES))


def exact_results(cells: Parameters, stick: Regimes, box: Attractors, work: Motions) -> tuple[Flags, Results]:
    """Of which cells the share is exact, and their results, by names of the variables of attractors; NaN elsewhere."""
    results: Results = {name: np.full(stick.size, np.nan) for name in _MEASURED}
    nowhere, everywhere, inside = verdicts(cells, stick, work)
    for mask, share, disturbance in ((nowhere, 0.0, 0.0), (everywhere, 1.0, np.inf)):
        results["settling_share"][mask] = share
        for name in _DISTURBANCES:
            results[name][mask] = disturbance
    if inside.any():
        for name, values in _inside_cycles(taken(cells, inside), box, work).items():
            results[name][inside] = values
    return np.isfinite(results["settling_share"]), results


def _inside_cycles(cells: Parameters, box: Attractors, work: Motions) -> Results:
    """Of cells with an unstable cycle, all of it; NaN where it was not found, or its numbers contradict each other."""
    ahead = plain.forward(cells)
    cycles, back = find_cycles(ahead, work), plain.backwards(ahead)
    results: Results = {name: np.full(cycles.period.size, np.nan) for name in _MEASURED}
    left, samples = np.flatnonzero(cycles.closes), SAMPLES
    while left.size and samples <= MOST_SAMPLES:
        part = taken(back, left)
        motion = sampled_motion(part, cycles.reach[left], cycles.period[left], samples, work.options)
        x = motion["displacement"] - plain.steady_displacement(part)[:, np.newaxis]
        v, a, ends = motion["velocity"], motion["acceleration"], _mirrored_box(taken(cells, left), box)
        area, coarse = (area_in_box(x[:, ::step], v[:, ::step], a[:, ::step], cycles.period[left], *ends)
                        for step in (1, 2))  # fmt: skip
        done = np.abs(area - coarse) <= AREA_ERROR * np.maximum(area, _LEAST * box.area)
        measures = _measures(x, v, a)
        measures |= {"settling_share": area / box.area, "unstable_period": cycles.period[left]}
        known = done & np.isfinite(list(measures.values())).all(axis=0)
        known &= area <= 4.0 * measures["unstable_amplitude"] * measures["unstable_velocity_amplitude"]
        for name, values in measures.items():
            results[name][left[known]] = values[known]
        left, samples = left[~done], 4 * (samples - 1) + 1
    return results


def _mirrored_box(cells: Parameters, box: Attractors) -> tuple[Floats, Floats, Floats, Floats]:
    """The box in the plane of the motion backwards in time: displacements from steady sliding, of the other sign.

    Where the belt goes the other way the whole plane is mirrored.
    """
    ahead, steady = cells["belt_speed"] > 0, np.abs(plain.steady_displacement(cells))
    (left, right), (low, high) = box.displacement, box.velocity
    near, far = np.where(ahead, left, -right), np.where(ahead, right, -left)
    slow, fast = np.where(ahead, low, -high), np.where(ahead, high, -low)
    return steady - far, steady - near, slow, fast


def _measures(x: Floats, v: Floats, a: Floats) -> Results:
    """Return what is read off cycles that run backwards in time, where displacements have the other sign."""
    above, below = velocities_at_rest_point(x, v, a)
    right, left, fastest, slowest = largest(x), -largest(-x), largest(v), -largest(-v)
    return {
        "unstable_amplitude": 0.5 * (right - left),
        "unstable_velocity_amplitude": 0.5 * (fastest - slowest),
        "critical_shock_along": above,
        "critical_shock_against": -below,
        "critical_shift_along": -left,
        "critical_shift_against": right,
    }


@dataclass(frozen=True, eq=False)
class Loop:
    """An unstable cycle: displacements (m) and velocities (m/s) of one round, its end being its start; period in s."""

    displacement: Floats
    velocity: Floats
    period: float

    @property
    def velocity_amplitude(self) -> float:
        """Half the range of the velocity (m/s)."""
        return float(np.ptp(self.velocity) / 2.0)


def unstable_cycle(cell: Parameters, regime: int, options: Options, samples: int = 257) -> Loop | None:
    """The unstable cycle of a cell, where the theorems of `plain.py` say that there is one; None elsewhere.

    cell : arrays of length 1. regime : the one it reaches from sticking. On a hysteretic or ageing contact, and under
    other laws than stribeck, nothing is known.
    """
    work = Motions(options, stop_flag())
    with np.errstate(invalid="ignore"):
        if not verdicts(cell, np.array([regime], np.int8), work).inside[0]:
            return None
    ahead = plain.forward(cell)
    cycles, back = find_cycles(ahead, work), plain.backwards(ahead)
    if not cycles.closes[0]:
        return None
    motion = sampled_motion(back, cycles.reach, cycles.period, samples, options)
    turn = float(np.sign(cell["belt_speed"][0]))
    beyond = motion["displacement"][0] - plain.steady_displacement(back)[0]  # backwards in time its sign is changed
    displacement = plain.steady_displacement(ahead)[0] - beyond
    return Loop(turn * displacement, turn * motion["velocity"][0], float(cycles.period[0]))
