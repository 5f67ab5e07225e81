"""Cells whose phase plane is not known: starting states are drawn, and critical disturbances searched for."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.stats import qmc  # type: ignore[import-untyped]

from stickslip.basins.box import Box, Sampling
from stickslip.basins.starts import Work, decided, settled
from stickslip.borders.search import Scan, search_lines
from stickslip.vocabulary.cells import Cells
from stickslip.vocabulary.flags import REGIMES
from stickslip.vocabulary.settings import RANDOMISATIONS

Floats = NDArray[np.float64]

SCAN = Scan(1e-4, 10.0, 48, "log")  # of a disturbance over the scale of the cell, see `disturbance_scale`
TOLERANCE = 1e-6
_UNSETTLED, _SETTLES = 0, 1


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


def starting_states(box: Box, sampling: Sampling) -> Floats:
    """Scrambled Sobol points in the box: (randomisations, points, 2), the same for every cell."""
    seeds = np.random.SeedSequence(sampling.seed).spawn(RANDOMISATIONS)
    unit = [qmc.Sobol(2, scramble=True, rng=np.random.default_rng(seed)).random(sampling.points) for seed in seeds]
    low, high = zip(box.displacement, box.velocity, strict=True)
    return np.asarray(qmc.scale(np.concatenate(unit), low, high)).reshape(RANDOMISATIONS, sampling.points, 2)


def sampled_shares(cells: Cells, box: Box, sampling: Sampling, work: Work) -> Shares:
    """The shares of the box that settle, from states drawn in it.

    The randomisations are independent and each is unbiased, so that their scatter gives the standard error of their
    mean; that of independent points (the binomial one) would be too large several times, since Sobol points fill the
    box evenly. Where all agree the error is that of one state in all of them.
    """
    states = starting_states(box, sampling)
    n, each = cells["mass"].size, states.shape[0] * states.shape[1]
    flat = states.reshape(each, 2)
    many = {name: np.repeat(values, each) for name, values in cells.items()}
    regimes = work.regimes(many, np.tile(flat[:, 0], n), np.tile(flat[:, 1], n)).reshape(n, RANDOMISATIONS, -1)
    ends, known = settled(regimes), decided(regimes)
    with np.errstate(invalid="ignore"):
        share = ends.sum(axis=(1, 2)) / known.sum(axis=(1, 2))
        parts = ends.sum(axis=2) / known.sum(axis=2)
    error = np.maximum(parts.std(axis=1, ddof=1) / np.sqrt(RANDOMISATIONS), 1.0 / (each + 2))
    low, high = ends.mean(axis=(1, 2)), (ends | ~known).mean(axis=(1, 2))
    reached = np.stack([(regimes == code).any(axis=(1, 2)) for code in range(len(REGIMES))], axis=1)
    return Shares(share, error, low, high, reached)


def disturbance_scale(cells: Cells) -> Floats:
    """A speed (m/s) to measure disturbances by: that of the belt, and that to which friction deflects the spring."""
    impedance = np.sqrt(cells["stiffness"] * cells["mass"])
    return np.abs(cells["belt_speed"]) + cells["normal_load"] * (cells["a1"] + cells["a3"]) / impedance


def critical_disturbances(cells: Cells, steady: Floats, work: Work) -> dict[str, Floats]:
    """The smallest disturbances of steady sliding after which it does not come back, of a scan narrowed by halving.

    Returns arrays by name: shock_along, shock_against (m/s), shift_along, shift_against (m), along and against the
    motion of the belt; 0 where the smallest of the scan is enough, inf where the largest is not, NaN where undecided
    states come before.
    """
    n = steady.size
    speed, sign = disturbance_scale(cells), np.sign(cells["belt_speed"])
    length = speed * np.sqrt(cells["mass"] / cells["stiffness"])
    found = {}
    for name, turn in (("along", sign), ("against", -sign)):
        for kind, unit in (("shock", speed * turn), ("shift", length * turn)):

            def labels(
                line: NDArray[np.int64], place: Floats, unit: Floats = unit, kind: str = kind
            ) -> tuple[NDArray[np.int8], NDArray[np.bool_]]:
                some = {key: values[line] for key, values in cells.items()}
                change = place * unit[line]
                x, v = (change, np.zeros(line.size)) if kind == "shift" else (np.zeros(line.size), change)
                regimes = work.regimes(some, steady[line] + x, v)
                known = decided(regimes)
                return np.where(settled(regimes), _SETTLES, _UNSETTLED).astype(np.int8), known

            found[f"{kind}_{name}"] = _first(n, labels) * np.abs(unit)
    return found


def _first(lines: int, labels) -> Floats:  # type: ignore[no-untyped-def]
    """The place on each line where settling first ends."""
    ends = np.repeat(np.arange(lines), 2), np.tile([SCAN.low, SCAN.high], lines)
    brackets, _ = search_lines(lines, SCAN, TOLERANCE, labels)
    first, known = (part.reshape(lines, 2)[:, 0] for part in labels(*ends))
    found = np.where(first == _SETTLES, np.inf, 0.0)
    found[~known] = np.nan
    for bracket in brackets[::-1]:  # the lowest of a line comes last
        line = bracket["line"]
        if bracket["below"] == _SETTLES and found[line] != 0.0:
            wide = bracket["high"] - bracket["low"] > 1.5 * TOLERANCE * bracket["high"]
            found[line] = np.nan if wide else 0.5 * (bracket["low"] + bracket["high"])
    return found
