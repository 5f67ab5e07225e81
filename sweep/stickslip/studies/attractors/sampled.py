"""Cells whose phase plane is not known: starting states are drawn, and critical disturbances searched for."""

from dataclasses import dataclass

import numpy as np
import scipy  # type: ignore[import-untyped]
from numpy.typing import NDArray

from stickslip.engine import Scales
from stickslip.studies.attractors.section import RANDOMISATIONS, Attractors
from stickslip.studies.attractors.starts import Motions, decided, settled
from stickslip.studies.borders.search import Looked, Scan, search_lines
from stickslip.vocabulary.cells import Parameters, taken
from stickslip.vocabulary.flags import REGIMES
from stickslip.vocabulary.models import model_with

Floats = NDArray[np.float64]
Integers = NDArray[np.int64]

SCAN = Scan(1e-4, 10.0, 48, "log")  # of a disturbance over the scale of the cell, see `disturbance_scale`
TOLERANCE = 1e-6
_TOGETHER = 2**16  # motions that are held at once
_LOST, _SETTLES = 0, 1


@dataclass(frozen=True)
class Shares:
    """Of some cells: the share of starting states that settle with its standard error, its bounds, regimes met.

    reached : (cells, regimes), whether any starting state reached the regime.
    """

    share: Floats
    error: Floats
    low: Floats
    high: Floats
    reached: NDArray[np.bool_]


def starting_states(box: Attractors) -> Floats:
    """Scrambled Sobol points in the box: (randomisations, points, 2), the same for every cell."""
    seeds = np.random.SeedSequence(box.seed).spawn(RANDOMISATIONS)
    sobol = (scipy.stats.qmc.Sobol(2, scramble=True, rng=np.random.default_rng(seed)) for seed in seeds)
    unit = [points.random(box.points) for points in sobol]
    low, high = zip(box.displacement, box.velocity, strict=True)
    return np.asarray(scipy.stats.qmc.scale(np.concatenate(unit), low, high)).reshape(RANDOMISATIONS, box.points, 2)


def sampled_shares(cells: Parameters, box: Attractors, work: Motions) -> Shares:
    """The shares of the box that settle, from states drawn in it.

    The randomisations are independent and each is unbiased, so that their scatter gives the standard error of their
    mean; that of independent points (the binomial one) would be too large several times, since Sobol points fill the
    box evenly. Where all agree the error is that of one state in all of them.
    """
    states, each = starting_states(box).reshape(-1, 2), box.samples
    total = cells["mass"].size * each
    parts = []
    for first in range(0, total, _TOGETHER):
        cell, state = divmod(np.arange(first, min(first + _TOGETHER, total)), each)
        parts.append(work.regimes(taken(cells, cell), states[state, 0], states[state, 1]))
    regimes = np.concatenate(parts).reshape(-1, RANDOMISATIONS, box.points)
    ends, known = settled(regimes), decided(regimes)
    with np.errstate(invalid="ignore"):
        share = ends.sum(axis=(1, 2)) / known.sum(axis=(1, 2))
        parts = ends.sum(axis=2) / known.sum(axis=2)
    error = np.maximum(parts.std(axis=1, ddof=1) / np.sqrt(RANDOMISATIONS), 1.0 / (each + 2))
    low, high = ends.mean(axis=(1, 2)), (ends | ~known).mean(axis=(1, 2))
    reached = np.stack([(regimes == code).any(axis=(1, 2)) for code in range(len(REGIMES))], axis=1)
    return Shares(share, error, low, high, reached)


def disturbance_scale(cells: Parameters) -> Floats:
    """A speed (m/s) to measure disturbances by: that of the belt, and that to which friction deflects the spring."""
    by = Scales(cells)
    return np.asarray(np.abs(cells["belt_speed"]) + by.load * model_with(cells).start_of(cells) / by.impedance)


def critical_disturbances(cells: Parameters, steady: Floats, work: Motions) -> dict[str, Floats]:
    """The smallest disturbances of steady sliding after which it does not come back, of a scan narrowed by halving.

    Returns arrays by name: shock_along, shock_against (m/s), shift_along, shift_against (m), along and against the
    motion of the belt; 0 where the smallest of the scan is enough, inf where the largest is not, NaN where undecided
    states come before.
    """
    speed, sign = disturbance_scale(cells), np.sign(cells["belt_speed"])
    length, none = speed * Scales(cells).time, np.zeros(steady.size)
    smallest = {}
    for way, turn in (("along", sign), ("against", -sign)):
        smallest[f"shock_{way}"] = speed * _first_lost(cells, steady, none, turn * speed, work)
        smallest[f"shift_{way}"] = length * _first_lost(cells, steady, turn * length, none, work)
    return smallest


def _first_lost(cells: Parameters, steady: Floats, shift: Floats, shock: Floats, work: Motions) -> Floats:
    """Return how many times a disturbance of displacement and velocity is enough, per cell."""

    def looked(line: Integers, place: Floats) -> Looked:
        x, v = steady[line] + place * shift[line], place * shock[line]
        regimes = work.regimes(taken(cells, line), x, v)
        return Looked(np.where(settled(regimes), _SETTLES, _LOST).astype(np.int8), decided(regimes))

    lines = steady.size
    brackets, _ = search_lines(lines, SCAN, TOLERANCE, looked)
    start = looked(np.arange(lines), np.full(lines, SCAN.low))
    lost = np.where(start.labels == _SETTLES, np.inf, 0.0)
    lost[~start.decided] = np.nan
    for bracket in brackets[::-1]:  # the lowest of a line comes last
        line = bracket["line"]
        if bracket["below"] == _SETTLES and lost[line] != 0.0:
            wide = bracket["high"] - bracket["low"] > 1.5 * TOLERANCE * bracket["high"]
            lost[line] = np.nan if wide else 0.5 * (bracket["low"] + bracket["high"])
    return lost
