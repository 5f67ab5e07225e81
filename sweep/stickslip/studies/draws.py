"""Draws of what is uncertain, and the cells behind them.

An item is a draw by cell, scrambling, matrix and number, in that order, the last running fastest: scrambled Sobol
points, none of which depends on which others are asked for. So a block of a run makes its own points wherever it lies,
and a hundred million of them are never in memory together.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property, lru_cache
from typing import Any, NamedTuple

import numpy as np
import scipy  # type: ignore[import-untyped]
import xarray as xr
from numpy.typing import NDArray

from stickslip.config.grid import build_grid
from stickslip.config.model import Config
from stickslip.config.studies import Moved
from stickslip.config.uncertain import Uncertain
from stickslip.dataset.build import NO_FILL, grid_coordinates, study_dataset, text_index
from stickslip.engine import Options, Results, StopFlag, blank_results, compute_range
from stickslip.studies.search import Flags, Floats, Integers
from stickslip.vocabulary.cells import Cells, Parameters, impossible, taken
from stickslip.vocabulary.models import model_of
from stickslip.vocabulary.parameter import Variable, table
from stickslip.vocabulary.quantities import MEASURED
from stickslip.vocabulary.results import REGIMES
from stickslip.vocabulary.results import VARIABLES as CELL_VARIABLES

BITS = 30  # of a coordinate, as SciPy has them
_AT_ONCE = 2**16  # points of a scrambling that are made together; many, since SciPy walks to the first of them
_IN_MEMORY = 2**21  # points


class SobolPoints:
    """Independent scramblings of the first `count` Sobol points in the unit cube; count : a power of two.

    Scrambling: a random matrix and a digital shift (Matousek).
    """

    def __init__(self, dimensions: int, count: int, seed: int) -> None:
        self._dimensions, self._together = dimensions, min(count, _AT_ONCE)
        self._seed = seed
        self._part = lru_cache(_IN_MEMORY // self._together)(self._part_of)

    def at(self, scrambling: Integers, number: Integers) -> Floats:
        """Points by scrambling and number (both (n,)), as (n, dimensions), strictly between 0 and 1.

        A point is the middle of its interval of 2^-30: SciPy gives the lower end, which may be 0.
        """
        points = np.empty((number.size, self._dimensions))
        places = np.stack([scrambling, number // self._together])
        for scrambled, part in np.unique(places, axis=1).T.tolist():
            here = (places[0] == scrambled) & (places[1] == part)
            points[here] = self._part(scrambled, part)[number[here] % self._together]
        return points + 0.5 * 2.0**-BITS

    def _part_of(self, scrambling: int, part: int) -> Floats:
        """Points of a scrambling that are made together."""
        # A new one every time: SciPy spawns another from it, which it remembers.
        seed = np.random.SeedSequence(self._seed, spawn_key=(scrambling,))
        engine = scipy.stats.qmc.Sobol(self._dimensions, scramble=True, bits=BITS, seed=np.random.default_rng(seed))
        if part:  # SciPy takes 0 points for more than none
            engine.fast_forward(part * self._together)
        return np.asarray(engine.random(self._together), np.float64)


class DrawPlace(NamedTuple):
    """Places of items: four rows of numbers. matrix : 0 is A, 1 is B, 2 + i is A with the column i of B."""

    cell: Integers
    scrambling: Integers
    matrix: Integers
    number: Integers


@dataclass(frozen=True)
class Design:
    """The draws of every cell, the same in all of them, so that cells differ by what they are and not by luck.

    quantities : how many are uncertain. draws : per scrambling and matrix, a power of two.
    indices : whether the matrices of Saltelli (2010) are drawn, quantities + 2 of them, or one alone.
    """

    quantities: int
    draws: int
    scramblings: int
    seed: int
    indices: bool

    @property
    def matrices(self) -> int:
        """Matrices of draws per scrambling."""
        return self.quantities + 2 if self.indices else 1

    @property
    def plain(self) -> int:
        """Matrices that are independent draws, from which probabilities are counted: A, and B if there is one."""
        return 2 if self.indices else 1

    @property
    def unit(self) -> int:
        """Draws of one cell in one scrambling."""
        return self.matrices * self.draws

    @property
    def per_cell(self) -> int:
        """Draws of one cell."""
        return self.scramblings * self.unit

    @cached_property
    def points(self) -> SobolPoints:
        """In the unit cube; the columns of B after those of A."""
        return SobolPoints(self.plain * self.quantities, self.draws, self.seed)

    def place(self, start: int, stop: int) -> DrawPlace:
        """Return where the items from `start` to `stop` stand."""
        shape = (-(-stop // self.per_cell) or 1, self.scramblings, self.matrices, self.draws)
        return DrawPlace(*np.unravel_index(np.arange(start, stop, dtype=np.int64), shape))

    def normals(self, place: DrawPlace) -> Floats:
        """Independent standard normal deviates of items, (n, quantities)."""
        points, matrix, d = self.points.at(place.scrambling, place.number), place.matrix[:, None], self.quantities
        drawn = points[:, :d]
        if self.indices:
            drawn = np.where((matrix == 1) | (matrix == 2 + np.arange(d)), points[:, d:], drawn)
        return np.asarray(scipy.special.ndtri(drawn))


_STATE, _QUANTITY = ("state",), ("state", "quantity")
_ERROR = "standard error: scatter over independent scramblings"
VARIABLES = table(
    Variable("probability", "1", "probability of a regime",
             comment="share of the draws whose regime is known", dims=_STATE),
    Variable("probability_error", "1", "standard error of the probability of a regime",
             comment=f"{_ERROR}; at least that of one draw", dims=_STATE),
    Variable("probability_low", "1", "lower bound of the probability of a regime",
             comment="no draw that is unresolved or failed has the regime; without the standard error", dims=_STATE),
    Variable("probability_high", "1", "upper bound of the probability of a regime",
             comment="all draws that are unresolved or failed have the regime; without the standard error",
             dims=_STATE),
    Variable("undecided", "1", "share of draws that are unresolved or failed"),
    Variable("sobol_first", "1", "first-order Sobol index of being in a regime",
             comment="share of the variance of the indicator that a quantity explains by itself", dims=_QUANTITY),
    Variable("sobol_first_error", "1", "standard error of the first-order Sobol index",
             comment=f"{_ERROR}; and what undecided draws could change", dims=_QUANTITY),
    Variable("sobol_total", "1", "total Sobol index of being in a regime",
             comment="share of the variance of the indicator that would remain if all other quantities were known",
             dims=_QUANTITY),
    Variable("sobol_total_error", "1", "standard error of the total Sobol index",
             comment=f"{_ERROR}; and what undecided draws could change", dims=_QUANTITY),
    Variable("levels", "1", "levels of the subset simulation, the most of all repetitions"),
    Variable("evaluations", "1", "cells computed by all subset simulations of a cell"),
)  # fmt: skip
# What is told of a metric, as a name and a long name to put its own behind.
STATISTICS = {
    "mean": "mean", "mean_error": "standard error of the mean", "quantile": "quantile",
    "quantile_error": "standard error of the quantile", "count": "draws that have",
}  # fmt: skip


def _declared(name: str) -> Variable:
    """The declaration of a result of draws; that of a statistic is made of the metric's."""
    if name in VARIABLES:
        return VARIABLES[name]
    statistic, _, metric = name.removesuffix("_error").partition("_")
    kind = f"{statistic}_error" if name.endswith("_error") else statistic
    row = CELL_VARIABLES[metric]
    units, comment = ("1", "") if statistic == "count" else (row.units, "among the draws that have it")
    dims = ("quantile",) if statistic == "quantile" else ()
    return Variable(name, units, f"{STATISTICS[kind]}: {row.long_name}", comment=comment, dims=dims)


@dataclass(frozen=True)
class Inputs:
    """Cells of a configuration with uncertain quantities."""

    config: Config

    @property
    def uncertain(self) -> Uncertain:
        """The quantities that scatter."""
        if self.config.uncertain is None:
            raise ValueError("this configuration has no section uncertain")
        return self.config.uncertain

    @cached_property
    def grid(self) -> Cells:
        """The cells of its axes, without what is uncertain."""
        return build_grid(self.config)

    def cells(self, numbers: Integers, normals: Floats) -> tuple[Parameters, Flags]:
        """Parameters of cells of the axes, their uncertain ones drawn; and which of the draws an oscillator can have.

        numbers : of cells of the axes, (n,). normals : independent standard normal deviates, (n, quantities).
        Others (friction below 0, mu_stop above its start, ...) are `failed`; a configuration with more than one in some
        thousand of them is refused when it is read.
        """
        return drawn_cells(self.grid, numbers, self.uncertain.values(normals), Options(self.config.friction.law))

    def compute(
        self, numbers: Integers, normals: Floats, options: Options, stop: StopFlag, moved: Moved | None = None
    ) -> Results:
        """Their results, by the calling thread. Raises StoppedError."""
        return computed_where(*self.cells(numbers, normals), options, stop, moved)

    def dataset(
        self, states: Sequence[str], quantiles: Sequence[float], results: Mapping[str, NDArray[Any]],
        attributes: Mapping[str, Any],
    ) -> xr.Dataset:  # fmt: skip
        """Probabilities of regimes, the spread of metrics and Sobol indices, with what was done as attributes.

        results : by names of `VARIABLES`, and of metrics (``mean_period``, ``quantile_period_error``, ...).
        """
        uncertain, rows = self.uncertain, {name: _declared(name) for name in results}
        coordinates = grid_coordinates(self.grid) | {"state": text_index("state", states, "regime")}
        used = {dim for row in rows.values() for dim in row.dims}
        if "quantity" in used:
            coordinates["quantity"] = text_index("quantity", uncertain.names, "uncertain quantity")
        if "quantile" in used:
            about = {"units": "1", "long_name": "share of the draws below the quantile"}
            coordinates["quantile"] = xr.Variable("quantile", np.asarray(quantiles, np.float64), about, NO_FILL)
        attributes = {**attributes, "uncertain_method": uncertain.method_in_words}
        return study_dataset("uncertain", rows, results, self.grid.dims, self.grid.shape, coordinates, attributes)


def drawn_cells(grid: Cells, numbers: Integers, drawn: Parameters, options: Options) -> tuple[Parameters, Flags]:
    """Parameters of the cells of these numbers, drawn quantities in place of their own; and which are possible."""
    cells = grid.take(numbers, **drawn)
    model = model_of(options.law)
    wrong, curve = impossible(cells, model.rules.get(options.law, ())), model.curve
    if curve and MEASURED.keys() & drawn.keys():
        wrong |= ~(cells[curve.drop] > 0)  # its minimum is not below its start
    return cells, ~wrong


def computed_where(
    cells: Parameters, possible: Flags, options: Options, stop: StopFlag, moved: Moved | None = None
) -> Results:
    """The results of cells, by the calling thread; those of impossible ones are `failed`. Raises StoppedError."""
    chosen = Cells.of(taken(cells, possible))
    computed = compute_range(chosen, 0, chosen.size, options, stop, moved)
    results = blank_results(possible.size, options)
    results["regime"][:] = REGIMES.index("failed")
    for name, values in results.items():
        values[possible] = computed[name]
    return results
