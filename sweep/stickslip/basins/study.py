"""Attractors as something a run computes: cells in a row, labelled in the end."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Any

import numpy as np
import xarray as xr

from stickslip.basins import cycle, exact, sampled
from stickslip.basins.box import Box, Sampling
from stickslip.basins.find import COLUMNS, TOGETHER, find_attractors
from stickslip.basins.plain import slips_on_curve
from stickslip.basins.starts import DISTURBANCE
from stickslip.borders.lines import CellsOrConfig
from stickslip.config.grid import build_grid
from stickslip.config.model import Config
from stickslip.config.states import STATES_IN_BOX, state_axes
from stickslip.config.studies import Attractors
from stickslip.dataset.attractors import attractor_dataset
from stickslip.dataset.build import grid_coordinates
from stickslip.dataset.given import given_cells
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


class AttractorStudy(Study):
    """The attractors of cells."""

    name, counted, weight = "attractor set", "cells", 4096 // TOGETHER
    columns = COLUMNS

    def __init__(self, cells: Cells, box: Box, sampling: Sampling, options: Options) -> None:
        self._cells, self._box, self._sampling = cells, box, sampling
        self.dims, self.shape = cells.dims, cells.shape
        self.options = replace(options, early_stop=True)
        known = slips_on_curve(cells[: min(cells.size, _PROBED)], options)
        share = float(known.mean()) if known.size else 1.0
        self.cells_each = _EXACT_COST + int((1.0 - share) * (sampling.samples + _SEARCH_COST))

    def compute(self, items: range, stop: StopFlag, moved: Moved | None = None) -> Finished:
        """The attractors of a range of cells."""
        try:
            return Finished(find_attractors(self._cells, items, self._box, self._sampling, self.options, stop, moved))
        except StoppedError:
            return Finished({}, False)

    def blank(self, items: range) -> Results:
        """Cells that are "not computed"."""
        size = len(items)
        return {
            name: np.full(size, np.nan) if kind == np.float64 else np.zeros(size, kind)
            for name, kind in COLUMNS.items()
        }

    def dataset(self, parts: Sequence[Results], attributes: Mapping[str, Any]) -> xr.Dataset:
        """The attractors with the dimensions of the cells."""
        whole = joined(parts)
        coordinates = {name: c for name, c in grid_coordinates(self._cells).items() if name not in _STATE}
        attributes = dict(attributes) | _attributes(whole, self._box, self._sampling, self.options)
        return attractor_dataset(self.dims, self.shape, coordinates, whole, attributes)


def attractor_study(given: CellsOrConfig, section: Attractors, options: Options) -> AttractorStudy:
    """The attractors that a section of a configuration asks for; what is said of the state at the start is left out.

    Raises ArgumentError where an axis is a starting state, or the belt has a drive.
    """
    box, sampling = Box(section.displacement, section.velocity), Sampling(section.samples, section.seed)
    if not isinstance(given, Config):
        return AttractorStudy(given_cells(given, options.law), box, sampling, options)
    if given.drive is not None:
        raise ArgumentError("config", "the configuration has a drive: cells of a rig have no attractors")
    for path in state_axes(given):
        raise ArgumentError(str(path[-1]), STATES_IN_BOX)
    return AttractorStudy(build_grid(given), box, sampling, options)


def _attributes(found: Results, box: Box, sampling: Sampling, options: Options) -> dict[str, str | float]:
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
