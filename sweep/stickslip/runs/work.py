"""What a block is computed from: a configuration and a block number in, arrays out, whoever calls."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property
from math import inf

import numpy as np
from numpy.typing import NDArray

from stickslip.config.grid import Grid, build_grid
from stickslip.config.model import Config
from stickslip.engine import Computed, Options, Results, StopFlag, blank_results, compute_range, stop_flag
from stickslip.runs.blocks import Blocks, blocks_of
from stickslip.runs.reuse import KnownCells
from stickslip.vocabulary.cells import Cells


def options_of(config: Config) -> Options:
    """How a configuration wants to be integrated."""
    solver, execution = config.solver, config.execution
    return Options(
        law=config.friction.law,
        rtol=solver.rtol,
        horizon=inf if solver.horizon is None else solver.horizon,
        max_steps=solver.max_steps,
        early_stop=solver.early_stop,
        threads=execution.threads,
        block=execution.block,
    )


@dataclass(frozen=True)
class Block:
    """The results of a block, and how many of its cells were taken over from an older result.

    complete : False if computing was stopped on the way; such a block is thrown away.
    """

    results: Results
    reused: int
    complete: bool


@dataclass(frozen=True)
class Work:
    """The blocks of a configuration; `known` are cells that an older result holds."""

    config: Config
    known: KnownCells | None = None

    @cached_property
    def grid(self) -> Grid:
        """Its cells."""
        return build_grid(self.config)

    @cached_property
    def options(self) -> Options:
        """How they are integrated."""
        return options_of(self.config)

    @cached_property
    def blocks(self) -> Blocks:
        """How they are cut."""
        return blocks_of(self.grid.size)

    def compute(self, number: int, stop: StopFlag | None = None, moved: Callable[[int], None] | None = None) -> Block:
        """A block by the calling thread: the numbers of an undivided run, bit for bit.

        stop, moved : as for `engine.compute_range`.
        """
        cells, stop = self.blocks.cells(number), stop_flag() if stop is None else stop
        old = self.known_cells(number)
        if old is None:
            found = compute_range(self.grid.cells, cells.start, cells.stop, self.options, stop, moved)
            return Block(found.results, 0, found.complete)
        found = self.compute_some(number, ~old[0], stop, moved)
        if moved:
            moved(int(old[0].sum()))
        return Block(self.joined(old, found.results), int(old[0].sum()), found.complete)

    def compute_some(
        self,
        number: int,
        wanted: NDArray[np.bool_],
        stop: StopFlag | None = None,
        moved: Callable[[int], None] | None = None,
    ) -> Computed:
        """Those cells of a block that `wanted` marks, one flag per cell."""
        places = np.flatnonzero(wanted)
        parameters = _chosen(self.grid, self.blocks.cells(number), places)
        return compute_range(parameters, 0, places.size, self.options, stop_flag() if stop is None else stop, moved)

    def known_cells(self, number: int) -> tuple[NDArray[np.bool_], Results] | None:
        """Which cells of a block an older result holds, and their results; None if it holds none."""
        return self.known.cells(self.blocks.cells(number)) if self.known else None

    def joined(self, known: tuple[NDArray[np.bool_], Results], computed: Results) -> Results:
        """The results of a block of which some cells were known, and the others were computed."""
        have, values = known
        results = blank_results(have.size, self.options)
        for name, column in results.items():
            column[have], column[~have] = values[name], computed[name]
        return results

    def known_only(self, number: int) -> Results:
        """The results of a block as far as an older result holds them; other cells are "not computed"."""
        results = blank_results(len(self.blocks.cells(number)), self.options)
        if old := self.known_cells(number):
            have, values = old
            for name, column in results.items():
                column[have] = values[name]
        return results


def _chosen(grid: Grid, cells: range, new: np.ndarray) -> Callable[[int, int], Cells]:
    """The parameters of those cells of a block that are at the places `new`, as if they were all there is."""

    def parameters(start: int, stop: int) -> Cells:
        if start >= stop:
            return grid.cells(0, 0)
        first, last = int(new[start]), int(new[stop - 1]) + 1
        around = grid.cells(cells.start + first, cells.start + last)
        return {name: values[new[start:stop] - first] for name, values in around.items()}

    return parameters
