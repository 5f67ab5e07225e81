"""The source of blocks: a configuration and a block number in, arrays out, whoever calls; and the map as a study."""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from math import prod
from typing import Any

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from stickslip.config.grid import build_grid, map_options_of, options_of
from stickslip.config.model import Config
from stickslip.config.studies import Moved, Study, study_class
from stickslip.dataset.build import map_dataset
from stickslip.engine import Options, Results, StopFlag, columns, compute_range, kernels_for, stop_flag
from stickslip.files.filters import NETCDF, PLAIN
from stickslip.files.locations import Location
from stickslip.runs.blocks import Blocks, blocks_of
from stickslip.runs.known_cells import KnownCells
from stickslip.studies.study import joined
from stickslip.vocabulary.cells import Cells


def study_of(config: Config) -> Study:
    """Return what a configuration asks for: a map of every cell, unless it has the section of a study."""
    section = config.study or config.uncertain
    if section is None:
        return MapStudy(config, map_options_of(config))
    return study_class(section.key).of(config, section, options_of(config))


@dataclass(frozen=True)
class Block:
    """The results of a block, and how many of its items were taken over from an older result."""

    results: Results
    reused: int


@dataclass(frozen=True)
class Work:
    """The blocks of a configuration.

    known : cells that an older map holds. cut : the blocks, where a store that was begun has others than a new one.
    grid : of a map whose older cells have values that differ by rounding from those of the configuration.
    """

    config: Config
    known: KnownCells | None = None
    cut: Blocks | None = None
    grid: Cells | None = None

    @cached_property
    def study(self) -> Study:
        """Return what is computed."""
        study = study_of(self.config)
        return study if self.grid is None else MapStudy(self.config, study.options, self.grid)

    @property
    def options(self) -> Options:
        """Return how cells are integrated."""
        return self.study.options

    @cached_property
    def size(self) -> int:
        """Return how many items there are."""
        return prod(self.study.shape)

    @cached_property
    def blocks(self) -> Blocks:
        """Return how they are cut."""
        study = self.study
        return self.cut or blocks_of(study.shape if study.is_array else (self.size,), study.weight)

    def packing(self, output: Location | None) -> str:
        """The packing of blocks: as chunks of the file, if they are to be these; of a netCDF file if none is named."""
        of_netcdf = output is None or output.suffix == ".nc"
        return NETCDF if self.study.is_array and of_netcdf else PLAIN

    def compute(self, number: int, stop: StopFlag | None = None, moved: Moved | None = None) -> Block:
        """A block by the calling thread: the numbers of an undivided run, bit for bit.

        stop, moved : as for `Study.compute`.
        """
        items, stop = self.blocks.cells(number), stop_flag() if stop is None else stop
        known = self.known_cells(number)
        if known is None:
            return Block(self.study.compute(items, stop, moved), 0)
        assert isinstance(self.study, MapStudy)
        have, values = known
        computed = self.study.compute_chosen(items, ~have, stop, moved)
        if moved:
            moved(int(have.sum()))
        results = self.study.blank(items)
        for name, column in results.items():
            column[have], column[~have] = values[name], computed[name]
        return Block(results, int(have.sum()))

    def known_cells(self, number: int) -> tuple[NDArray[np.bool_], Results] | None:
        """Return which cells of a block an older map holds, and their results; None if it holds none."""
        return self.known.cells(self.blocks.cells(number)) if self.known else None

    def known_only(self, number: int) -> Results:
        """The results of a block as far as an older map holds them; other items are "not computed"."""
        results = self.study.blank(self.blocks.cells(number))
        if known := self.known_cells(number):
            have, values = known
            for name, column in results.items():
                column[have] = values[name]
        return results

    def fits(self, number: int, types: Mapping[str, np.dtype[Any]], sizes: Collection[int]) -> bool:
        """Return whether columns of these types and sizes are those of a block of this study."""
        size = None if self.study.ragged else len(self.blocks.cells(number))
        wanted = {name: dtype.newbyteorder("<") for name, dtype in self.study.columns.items()}
        return types == wanted and all(size in (None, cells) for cells in sizes)


# --- the map as a study: its items are the cells of the grid ----------------------------------------------------------


class MapStudy(Study):
    """Every cell of the grid of a configuration."""

    name, counted, is_array = "map", "cells", True

    def __init__(self, config: Config, options: Options, grid: Cells | None = None) -> None:
        self.grid = build_grid(config) if grid is None else grid
        self.dims, self.shape = self.grid.dims, self.grid.shape
        self.options, self.columns = options, columns(options)

    @property
    def kernels(self) -> tuple[str, ...]:
        """By the cells, of which some may have kernels of their own."""
        return kernels_for(self.grid, self.options)

    def compute(self, items: range, stop: StopFlag, moved: Moved | None = None) -> Results:
        """The numbers of an undivided run, bit for bit."""
        return compute_range(self.grid, items.start, items.stop, self.options, stop, moved)

    def compute_chosen(
        self, items: range, chosen: NDArray[np.bool_], stop: StopFlag, moved: Moved | None = None
    ) -> Results:
        """Those cells of a range that `chosen` marks, one flag per cell."""
        cells = self.grid.pick(items.start + np.flatnonzero(chosen))
        return compute_range(cells, 0, cells.size, self.options, stop, moved)

    def dataset(self, parts: Sequence[Results], attributes: Mapping[str, Any]) -> xr.Dataset:
        """The map, in memory."""
        return map_dataset(self.grid, joined(parts), attributes)
