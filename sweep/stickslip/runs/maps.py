"""The map of a configuration as a study: its items are the cells of the grid."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import Any

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from stickslip.config.grid import Grid, build_grid
from stickslip.config.model import Config
from stickslip.dataset.build import map_dataset
from stickslip.engine import Options, Results, StopFlag, blank_results, columns, compute_range, kernels_for
from stickslip.study import Finished, Moved, Study, joined
from stickslip.vocabulary.cells import Cells


class MapStudy(Study):
    """Every cell of the grid of a configuration."""

    name, counted, is_array = "map", "cells", True

    def __init__(self, config: Config, options: Options) -> None:
        self.grid: Grid = build_grid(config)
        self.dims, self.shape = self.grid.dims, self.grid.shape
        self.options, self.columns = options, columns(options)

    @property
    def kernels(self) -> tuple[str, ...]:
        """By the exponents of the cells, of which some have kernels of their own."""
        varied = [c.values for c in self.grid.coords if c.name == "delta"]
        return kernels_for(self.options.law, np.unique(varied).tolist() if varied else [self.grid.fixed["delta"]])

    def compute(self, items: range, stop: StopFlag, moved: Moved | None = None) -> Finished:
        """The numbers of an undivided run, bit for bit."""
        found = compute_range(self.grid.cells, items.start, items.stop, self.options, stop, moved)
        return Finished(found.results, found.complete)

    def compute_some(
        self, items: range, wanted: NDArray[np.bool_], stop: StopFlag, moved: Moved | None = None
    ) -> Finished:
        """Those cells of a range that `wanted` marks, one flag per cell."""
        places = np.flatnonzero(wanted)
        found = compute_range(_chosen(self.grid, items, places), 0, places.size, self.options, stop, moved)
        return Finished(found.results, found.complete)

    def blank(self, items: range) -> Results:
        """Cells that are "not computed"."""
        return blank_results(len(items), self.options)

    def dataset(self, parts: Sequence[Results], attributes: Mapping[str, Any]) -> xr.Dataset:
        """The map, in memory."""
        return map_dataset(self.grid, joined(parts), attributes)


def _chosen(grid: Grid, cells: range, new: NDArray[np.intp]) -> Callable[[int, int], Cells]:
    """The parameters of those cells of a range that are at the places `new`, as if they were all there is."""

    def parameters(start: int, stop: int) -> Cells:
        if start >= stop:
            return grid.cells(0, 0)
        first, last = int(new[start]), int(new[stop - 1]) + 1
        around = grid.cells(cells.start + first, cells.start + last)
        return {name: values[new[start:stop] - first] for name, values in around.items()}

    return parameters
