"""Attractors of cells: the regimes they reach, the share that settles, the unstable cycle, critical disturbances."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from stickslip.basins.box import Box, Sampling
from stickslip.basins.exact import exact_results
from stickslip.basins.sampled import critical_disturbances, sampled_shares
from stickslip.basins.starts import Work, decided, from_sliding, settled, steady_state, unloaded
from stickslip.engine import Options, Results, StopFlag
from stickslip.vocabulary.cells import Cells, Parameters, taken
from stickslip.vocabulary.flags import FLAGS, REGIMES, SHARE_METHODS
from stickslip.vocabulary.results import ATTRACTOR_VARIABLES

Floats = NDArray[np.float64]

COLUMNS: dict[str, np.dtype[Any]] = {
    name: np.dtype(np.int8 if name in FLAGS or name == "coexisting" else np.float64) for name in ATTRACTOR_VARIABLES
}
TOGETHER = 256  # cells that are held with their samples


def find_attractors(
    cells: Cells,
    items: range,
    box: Box,
    sampling: Sampling,
    options: Options,
    stop: StopFlag,
    moved: Callable[[int], None] | None = None,
) -> Results:
    """By names of `ATTRACTOR_VARIABLES`, of the cells with these numbers; in this thread.

    The numbers do not depend on how cells are cut into items. moved : called with motions computed, now and then.
    Raises StoppedError once `stop` is raised.
    """
    work = Work(replace(options, early_stop=True), stop, moved)
    found = [{name: np.zeros(0) for name in COLUMNS}]
    for first in range(items.start, items.stop, TOGETHER):
        last = min(first + TOGETHER, items.stop)
        found.append(_attractors(cells[first:last], box, sampling, work))
    return {name: np.concatenate([part[name] for part in found]).astype(kind) for name, kind in COLUMNS.items()}


def _attractors(cells: Parameters, box: Box, sampling: Sampling, work: Work) -> Results:
    """The same of cells that are held together."""
    n, steady = cells["mass"].size, steady_state(cells, work.options)
    found: Results = {name: np.full(n, np.nan) for name in COLUMNS}
    start = work.results(cells, *unloaded(cells))
    stick, sliding = start["regime"], from_sliding(cells, steady, work)
    found["damping_ratio"] = start["damping_ratio"]
    found["regime_from_stick"], found["regime_from_sliding"] = stick, sliding
    reached = np.arange(len(REGIMES)) == stick[:, np.newaxis]
    reached |= np.arange(len(REGIMES)) == sliding[:, np.newaxis]
    exact, known = exact_results(cells, stick, box, work)
    found |= known
    for name in ("settling_share_low", "settling_share_high"):
        found[name] = np.where(exact, found["settling_share"], np.nan)
    found["share_error"] = np.where(exact, 0.0, np.nan)
    found["share_method"] = np.where(exact, SHARE_METHODS.index("exact"), SHARE_METHODS.index("sampled"))
    rest = np.flatnonzero(~exact)
    if rest.size:
        some = taken(cells, rest)
        reached[rest] |= _sample(some, steady[rest], sliding[rest], rest, box, sampling, work, found)
    _settle_exactly(found, exact, reached)
    for kind in ("shock", "shift"):
        ways = found[f"critical_{kind}_along"], found[f"critical_{kind}_against"]
        found[f"critical_{kind}"] = np.minimum(*ways)
    found["coexisting"] = reached[:, 1:] @ 2.0 ** np.arange(len(REGIMES) - 1)  # a cell not computed reaches nothing
    return found


def _sample(
    cells: Parameters, steady: Floats, sliding: NDArray[np.int8], where: NDArray[np.intp], box: Box, sampling: Sampling,
    work: Work, found: Results,
) -> NDArray[np.bool_]:  # fmt: skip
    """Fill in what sampling tells of some cells; the regimes their starting states reached."""
    shares = sampled_shares(cells, box, sampling, work)
    found["settling_share"][where], found["share_error"][where] = shares.share, shares.error
    found["settling_share_low"][where], found["settling_share_high"][where] = shares.low, shares.high
    slides = settled(sliding)
    for name, values in critical_disturbances(taken(cells, slides), steady[slides], work).items():
        found[f"critical_{name}"][where] = np.where(decided(sliding), 0.0, np.nan)
        found[f"critical_{name}"][where[slides]] = values
    return shares.reached


def _settle_exactly(found: Results, exact: NDArray[np.bool_], reached: NDArray[np.bool_]) -> None:
    """Where some states settle for certain, the regime is one that settles, though no motion was started there."""
    ends = [REGIMES.index("damped"), REGIMES.index("creep")]
    unseen = exact & (found["settling_share"] > 0) & ~reached[:, ends].any(axis=1)
    reached[unseen & (found["damping_ratio"] < 1), ends[0]] = True
    reached[unseen & (found["damping_ratio"] >= 1), ends[1]] = True
