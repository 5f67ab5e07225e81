"""The cells behind draws: what the configuration fixes or varies, and what it leaves to chance."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from stickslip.config.grid import build_grid
from stickslip.config.model import Config
from stickslip.config.studies import Moved
from stickslip.config.uncertain import Uncertain
from stickslip.dataset.build import NO_FILL, grid_coordinates, study_dataset, text_index
from stickslip.engine import Options, Results, StopFlag, blank_results, compute_range
from stickslip.vocabulary.cells import Cells, Parameters, impossible, taken
from stickslip.vocabulary.flags import REGIMES
from stickslip.vocabulary.models import model_of
from stickslip.vocabulary.parameter import Variable, table
from stickslip.vocabulary.quantities import MEASURED
from stickslip.vocabulary.results import VARIABLES as CELL_VARIABLES

Floats = NDArray[np.float64]

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

    def cells(self, numbers: NDArray[np.int64], normals: Floats) -> tuple[Parameters, NDArray[np.bool_]]:
        """Parameters of cells of the axes, their uncertain ones drawn; and which of the draws an oscillator can have.

        numbers : of cells of the axes, (n,). normals : independent standard normal deviates, (n, quantities).
        Others (friction below 0, mu_stop above its start, ...) are `failed`; a configuration with more than one in some
        thousand of them is refused when it is read.
        """
        return drawn_cells(self.grid, numbers, self.uncertain.values(normals), self.config.friction.law)

    def compute(
        self, numbers: NDArray[np.int64], normals: Floats, options: Options, stop: StopFlag, moved: Moved | None = None
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
        quantities = (f"{name}: {scatter.in_words(name)}" for name, scatter in uncertain.quantities.items())
        attributes = dict(attributes) | {
            "uncertain_method": uncertain.method_in_words, "uncertain_quantities": "; ".join(quantities),
        }  # fmt: skip
        return study_dataset("uncertain", rows, results, self.grid.dims, self.grid.shape, coordinates, attributes)


def drawn_cells(
    grid: Cells, numbers: NDArray[np.int64], drawn: Parameters, law: str
) -> tuple[Parameters, NDArray[np.bool_]]:
    """Parameters of the cells of these numbers, drawn quantities in place of their own; and which are possible."""
    cells = grid.take(numbers, **drawn)
    model = model_of(law)
    wrong, curve = impossible(cells, model.rules.get(law, ())), model.curve
    if curve and MEASURED.keys() & drawn.keys():
        wrong |= ~(cells[curve.drop] > 0)  # its minimum is not below its start
    return cells, ~wrong


def computed_where(
    cells: Parameters, possible: NDArray[np.bool_], options: Options, stop: StopFlag, moved: Moved | None = None
) -> Results:
    """The results of cells, by the calling thread; those of impossible ones are `failed`. Raises StoppedError."""
    chosen = Cells.of(taken(cells, possible))
    computed = compute_range(chosen, 0, chosen.size, options, stop, moved)
    results = blank_results(possible.size, options)
    results["regime"][:] = REGIMES.index("failed")
    for name, values in results.items():
        values[possible] = computed[name]
    return results
