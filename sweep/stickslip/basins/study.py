"""Attractors as something a run computes: cells in a row, labelled in the end."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
import xarray as xr

from stickslip.basins import cycle, exact, sampled
from stickslip.basins.box import Box, Sampling
from stickslip.basins.find import COLUMNS, TOGETHER, find_attractors
from stickslip.basins.plain import slips_on_curve
from stickslip.basins.starts import DISTURBANCE
from stickslip.config.checks import STATES_IN_BOX, state_axes
from stickslip.config.grid import build_grid
from stickslip.config.model import Config
from stickslip.config.options import options_of
from stickslip.config.studies import Attractors
from stickslip.dataset.attractors import attractor_dataset
from stickslip.dataset.build import grid_coordinates
from stickslip.dataset.given import GivenCells
from stickslip.engine import Options, Results, StopFlag
from stickslip.errors import ArgumentError, StoppedError
from stickslip.study import Finished, Moved, Study, joined
from stickslip.vocabulary import units
from stickslip.vocabulary.cells import Cells
from stickslip.vocabulary.flags import SHARE_METHODS
from stickslip.vocabulary.quantities import PARAMETERS
from stickslip.vocabulary.settings import RANDOMISATIONS

_STATE = ("displacement", "velocity")  # of a start, which the box replaces
_PROBED = 64  # cells that tell what the others may take
_EXACT_COST, _SEARCH_COST = 40, 300  # cells that the cycle takes, and the search for critical disturbances


@dataclass(frozen=True, eq=False)
class Asked:
    """The cells whose attractors are asked for: their dimensions, coordinates, and the cells from start to stop."""

    dims: tuple[str, ...]
    shape: tuple[int, ...]
    coordinates: Mapping[str, xr.Variable]
    cells: Callable[[int, int], Cells]


def asked_of_cells(cells: GivenCells) -> Asked:
    """Cells, complete and checked; what they say of the starting state is left out."""
    coordinates = {name: c for name, c in cells.coordinates().items() if name not in _STATE}
    return Asked(cells.dims, cells.shape, coordinates, cells.part)


def asked_of_config(config: Config) -> Asked:
    """The grid of a configuration. Raises ArgumentError where an axis is a starting state, or the belt has a drive."""
    if config.drive is not None:
        raise ArgumentError("config", "the configuration has a drive: cells of a rig have no attractors")
    for path in state_axes(config):
        raise ArgumentError(str(path[-1]), STATES_IN_BOX)
    grid = build_grid(config)
    coordinates = {name: c for name, c in grid_coordinates(grid).items() if name not in _STATE}
    return Asked(grid.dims, grid.shape, coordinates, grid.cells)


class AttractorStudy(Study):
    """The attractors of cells."""

    name, counted, weight = "attractor set", "cells", 4096 // TOGETHER
    columns = COLUMNS

    def __init__(self, asked: Asked, box: Box, sampling: Sampling, options: Options) -> None:
        self._asked, self._box, self._sampling = asked, box, sampling
        self.dims, self.shape = asked.dims, asked.shape
        self.options = replace(options, early_stop=True)
        size = int(np.prod(asked.shape))
        known = slips_on_curve(asked.cells(0, min(size, _PROBED)), options.law)
        share = float(known.mean()) if known.size else 1.0
        self.cells_each = _EXACT_COST + int((1.0 - share) * (sampling.samples + _SEARCH_COST))

    def compute(self, items: range, stop: StopFlag, moved: Moved | None = None) -> Finished:
        """The attractors of a range of cells."""
        try:
            found = find_attractors(self._asked.cells, items, self._box, self._sampling, self.options, stop, moved)
        except StoppedError:
            return Finished({}, False)
        return Finished(found)

    def blank(self, items: range) -> Results:
        """Cells that are "not computed"."""
        size = len(items)
        return {
            name: np.full(size, np.nan) if kind == np.float64 else np.zeros(size, kind)
            for name, kind in COLUMNS.items()
        }

    def dataset(self, parts: Sequence[Results], attributes: Mapping[str, Any]) -> xr.Dataset:
        """The attractors with the dimensions of the cells."""
        whole, asked = joined(parts), self._asked
        told = dict(attributes) | _told(whole, self._box, self._sampling, self.options)
        return attractor_dataset(asked.dims, asked.shape, asked.coordinates, whole, told)


def attractor_study(config: Config, asked: Attractors) -> AttractorStudy:
    """The attractors that a section of a configuration asks for. Raises ArgumentError."""
    box, sampling = Box(asked.displacement, asked.velocity), Sampling(asked.samples, asked.seed)
    return AttractorStudy(asked_of_config(config), box, sampling, options_of(config))


def _told(found: Results, box: Box, sampling: Sampling, options: Options) -> dict[str, str | float]:
    """What was asked, how it was found, and how good it is, as global attributes."""
    scan = sampled.SCAN
    counts = {name: int((found["share_method"] == code).sum()) for code, name in enumerate(SHARE_METHODS)}
    bounds = int((found["settling_share_high"] > found["settling_share_low"]).sum())
    result = f"{counts['exact']} cells exact, {counts['sampled']} sampled"
    if bounds:
        result += f"; {bounds} with undecided starting states"
    return {
        "box_displacement": _range("displacement", box.displacement),
        "box_velocity": _range("velocity", box.velocity),
        "attractors_found": result,
        "attractors_start": f"steady sliding: {DISTURBANCE:g} of the belt speed from it",
        "share_exact": f"by theorems of the plane; the unstable cycle at rtol {cycle.RTOL:g}, known to {cycle.CLOSED:g}"
        f" of the belt speed, its area to {exact.AREA_ERROR:g}",
        "share_sampled": f"{RANDOMISATIONS} randomisations of {sampling.points} scrambled Sobol points, seed "
        f"{sampling.seed}; the error is that of their mean, or of one point in {sampling.samples} where all agree",
        "disturbances_sampled": f"{scan.points} places from {scan.low:g} to {scan.high:g} times "
        f"belt speed plus load mu_start/sqrt(k m), then halved to {sampled.TOLERANCE:g}",
        "attractors_rtol": options.rtol,
    }


def _range(name: str, ends: tuple[float, float]) -> str:
    return f"{ends[0]!r} to {ends[1]!r} {units.spelled(PARAMETERS[name].units)}"
