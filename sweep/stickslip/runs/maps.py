"""The map of a configuration as a study: its items are the cells of the grid."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from stickslip.config.grid import build_grid
from stickslip.config.model import Config
from stickslip.config.studies import Finished, Moved, Study
from stickslip.dataset.build import map_dataset
from stickslip.engine import Options, Results, StopFlag, blank_results, columns, compute_range, kernels_for
from stickslip.studies.study import joined


class MapStudy(Study):
    """Every cell of the grid of a configuration."""

    name, counted, is_array = "map", "cells", True

    def __init__(self, config: Config, options: Options) -> None:
        self.grid = build_grid(config)
        self.dims, self.shape = self.grid.dims, self.grid.shape
        self.options, self.columns = options, columns(options)

    @property
    def kernels(self) -> tuple[str, ...]:
        """By the cells, of which some may have kernels of their own."""
        return kernels_for(self.grid, self.options)

    def compute(self, items: range, stop: StopFlag, moved: Moved | None = None) -> Finished:
        """The numbers of an undivided run, bit for bit."""
        computed = compute_range(self.grid, items.start, items.stop, self.options, stop, moved)
        return Finished(computed.results, computed.complete)

    def compute_some(
        self, items: range, chosen: NDArray[np.bool_], stop: StopFlag, moved: Moved | None = None
    ) -> Finished:
        """Those cells of a range that `chosen` marks, one flag per cell."""
        cells = self.grid.pick(items.start + np.flatnonzero(chosen))
        computed = compute_range(cells, 0, cells.size, self.options, stop, moved)
        return Finished(computed.results, computed.complete)

    def blank(self, items: range) -> Results:
        """Cells that are "not computed"."""
        return blank_results(len(items), self.options)

    def dataset(self, parts: Sequence[Results], attributes: Mapping[str, Any]) -> xr.Dataset:
        """The map, in memory."""
        return map_dataset(self.grid, joined(parts), attributes)
