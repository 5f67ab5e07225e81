"""Probabilities where inputs scatter, as studies: the draws of every cell of the axes, and subset simulations of each.

Subset simulation finds small probabilities in standard normal space, a factor of ten at a time. A limit-state function
g(u) is below 0 where the event happens. A level is the g below which a tenth of the samples lie; Markov chains started
from these fill the part of space below it, and give the next level, until it is below 0. A probability of 1e-6 takes
six levels instead of 1e8 samples.

Source: Au and Beck (2001), Probabilistic Engineering Mechanics 16, 263-277. The step of the chains is the adaptive
conditional sampling of Papaioannou, Betz, Zwirglmaier and Straub (2015), same journal 41, 89-103, and samples that
start a chain are not counted again: with the modified Metropolis step a single lucky sample multiplied from level to
level, and in one dimension the estimates scattered three times as much (a plane at 4.75 from 39,000 evaluations: 50 %
against 16 %).
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from math import prod
from typing import TYPE_CHECKING, Any

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from stickslip.config.model import Config
from stickslip.config.studies import Moved, ReportTable, Study
from stickslip.config.uncertain import Subset, Uncertain
from stickslip.dataset.build import NO_FILL, grid_coordinates, study_dataset, text_index
from stickslip.engine import Options, Results, StopFlag, columns, joined
from stickslip.studies.draws import STATES, Design, Inputs, reduced
from stickslip.studies.lines import decided
from stickslip.studies.search import Floats
from stickslip.vocabulary.cells import Parameters
from stickslip.vocabulary.models import model_of
from stickslip.vocabulary.parameter import Variable, table
from stickslip.vocabulary.quantities import REGIMES, SEARCHABLE, flag_label
from stickslip.vocabulary.quantities import VARIABLES as CELL_VARIABLES

if TYPE_CHECKING:
    from matplotlib.figure import Figure

_TENTH = 10  # one of so many samples starts the next level
_TAKEN = 0.44  # share of steps that are to be taken: chains then forget fastest, as Papaioannou et al. found as well
_MOST_LEVELS = 16  # 1e-16 is beyond what normal deviates from uniform numbers of 53 bits should be asked
_LEVELS = 6  # about as many as are simulated, for estimates of time


@dataclass(frozen=True)
class Rare:
    """Outcome of one simulation.

    probability : of g < 0; 0 where `_MOST_LEVELS` did not meet it, NaN where g was level before that: nothing then
    tells which way to go. evaluations : of g. unknown : share of them that were NaN, taken as not below any level.
    """

    probability: float
    levels: int
    evaluations: int
    unknown: float


def subset_simulation(
    limit_state: Callable[[Floats], Floats], dimensions: int, samples: int, rng: np.random.Generator
) -> Rare:
    """The probability that `limit_state` is below 0.

    limit_state : of independent standard normal deviates (n, dimensions), (n,). samples : of each level, a multiple
    of 10. One simulation tells nothing of its own error: repeat it with other numbers.
    """
    unknown = 0

    def evaluate(u: Floats) -> Floats:
        nonlocal unknown
        values = np.asarray(limit_state(u), np.float64)
        unknown += int(np.isnan(values).sum())
        return np.where(np.isnan(values), np.inf, values)

    u = rng.standard_normal((samples, dimensions))
    g, starts = evaluate(u), samples // _TENTH
    chance, level, reach, levels = 1.0, np.inf, 1.0, 0
    while True:
        order = np.argsort(g, kind="stable")
        next_level = 0.5 * (g[order[starts - 1]] + g[order[starts]])
        if next_level <= 0 or not next_level < level or levels == _MOST_LEVELS:
            break
        level, chance, levels = next_level, chance / _TENTH, levels + 1
        u, g, reach = _below(evaluate, level, u[order[:starts]], g[order[:starts]], reach, rng)
    probability, evaluations = chance * float(np.mean(g < 0)), samples * (1 + levels)
    lost = probability == 0 and next_level > 0 and levels < _MOST_LEVELS
    return Rare(np.nan if lost else probability, levels, evaluations, unknown / evaluations)


def _below(
    evaluate: Callable[[Floats], Floats], level: float, u: Floats, g: Floats, reach: float, rng: np.random.Generator
) -> tuple[Floats, Floats, float]:
    """Samples below a level: ten steps of a chain from each of those given; and the reach of a step.

    reach : standard deviation of a step; what remains of the sample is sqrt(1 - reach^2) of it, so that a step keeps
    the normal distribution. The further out, the thinner is what lies below a level: it adapts to how many are taken.
    """
    all_u, all_g = [], []
    for _ in range(_TENTH):
        tried = np.sqrt(1.0 - reach**2) * u + reach * rng.standard_normal(u.shape)
        moved = evaluate(tried)
        taken = moved <= level
        u, g = np.where(taken[:, None], tried, u), np.where(taken, moved, g)
        reach = min(reach * float(np.exp(taken.mean() - _TAKEN)), 1.0)
        all_u.append(u)
        all_g.append(g)
    return np.concatenate(all_u), np.concatenate(all_g), reach


def limit_of(regime: NDArray[Any], margin: Floats) -> Floats:
    """The limit-state function from regimes and margins, which lead to stick-slip; NaN where the regime is not known.

    Its sign is made that of the regime, which is what is asked for. A motion without a margin, since nothing breaks
    away, is as far from stick-slip as can be.
    """
    sticks = regime == REGIMES.index("stick_slip")
    least = np.finfo(np.float64).tiny
    away = np.where(np.isnan(margin), np.inf, np.maximum(margin, least))
    signed = np.where(sticks, np.fmin(margin, -least), away)
    return np.asarray(np.where(~decided(regime), np.nan, signed))


# --- studies ----------------------------------------------------------------------------------------------------------


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


def _dataset(
    inputs: Inputs, states: Sequence[str], quantiles: Sequence[float], results: Mapping[str, NDArray[Any]],
    attributes: Mapping[str, Any],
) -> xr.Dataset:  # fmt: skip
    """Probabilities of regimes, the spread of metrics and Sobol indices, with what was done as attributes.

    results : by names of `VARIABLES`, and of metrics (``mean_period``, ``quantile_period_error``, ...).
    """
    uncertain, rows = inputs.uncertain, {name: _declared(name) for name in results}
    coordinates = grid_coordinates(inputs.grid) | {"state": text_index("state", states, "regime")}
    used = {dim for row in rows.values() for dim in row.dims}
    if "quantity" in used:
        coordinates["quantity"] = text_index("quantity", uncertain.names, "uncertain quantity")
    if "quantile" in used:
        about = {"units": "1", "long_name": "share of the draws below the quantile"}
        coordinates["quantile"] = xr.Variable("quantile", np.asarray(quantiles, np.float64), about, NO_FILL)
    attributes = {**attributes, "uncertain_method": uncertain.method_in_words}
    return study_dataset("uncertain", rows, results, inputs.grid.dims, inputs.grid.shape, coordinates, attributes)


class RareStudy(Study):
    """The subset simulations of a configuration."""

    section, variables = Uncertain, VARIABLES
    name, counted = "sample", "simulations"
    columns: Mapping[str, np.dtype[Any]] = {
        "probability": np.dtype(np.float64), "unknown": np.dtype(np.float64),
        "levels": np.dtype(np.int32), "evaluations": np.dtype(np.int32),
    }  # fmt: skip

    def __init__(self, config: Config, subset: Subset, options: Options) -> None:
        self.inputs, self.subset = Inputs(config), subset
        self.model = model_of(options.law)
        self.options = replace(options, variables=("regime", self.model.guide))
        grid = self.inputs.grid
        self.dims, self.shape = (*grid.dims, "repetition"), (*grid.shape, subset.repetitions)
        self.cells_each = self.weight = _LEVELS * subset.samples

    def compute(self, items: range, stop: StopFlag, moved: Moved | None = None) -> Results:
        """The results of simulations."""
        results = self.blank(items)
        quantities = len(self.inputs.uncertain.names)
        for place, item in enumerate(items):
            cell, repetition = divmod(item, self.subset.repetitions)
            # The same numbers in every cell, so that cells differ by what they are and not by luck.
            rng = np.random.default_rng([self.subset.seed, repetition])
            outcome = subset_simulation(self._limit_state(cell, stop, moved), quantities, self.subset.samples, rng)
            for name in results:
                results[name][place] = getattr(outcome, name)
        return results

    def _limit_state(self, cell: int, stop: StopFlag, moved: Moved | None) -> Callable[[Floats], Floats]:
        """The margin of a cell of the axes as a function of independent standard normal deviates (n, quantities)."""

        def margin(normals: Floats) -> Floats:
            results = self.inputs.compute(np.full(len(normals), cell), normals, self.options, stop, moved)
            guide = results[self.model.guide]
            return limit_of(results["regime"], -guide if self.model.growth else guide)

        return margin

    def dataset(self, parts: Sequence[Results], attributes: Mapping[str, Any]) -> xr.Dataset:
        """The probability of stick-slip over the axes."""
        grid, count = self.inputs.grid, self.subset.repetitions
        whole = {name: values.reshape(grid.size, count) for name, values in joined(parts).items()}
        probability, unknown = whole["probability"], whole["unknown"].mean(1)
        results = {
            "probability": probability.mean(1, keepdims=True),
            "probability_error": probability.std(1, ddof=1, keepdims=True) / np.sqrt(count),
            "undecided": unknown,
            "levels": whole["levels"].max(1).astype(np.float64),
            "evaluations": whole["evaluations"].sum(1, dtype=np.float64),
        }
        return _dataset(self.inputs, ("stick_slip",), (), results, attributes)


class SampleStudy(Study):
    """The draws of a configuration; what is kept of each is the regime, and the metrics asked for."""

    section, variables = Uncertain, VARIABLES
    subject = caption = "probability"
    name, counted = "sample", "draws"

    def __init__(self, config: Config, options: Options) -> None:
        self.inputs = Inputs(config)
        uncertain, grid = self.inputs.uncertain, self.inputs.grid
        how = uncertain.draws, uncertain.scramblings, uncertain.seed, bool(uncertain.indices)
        self.design = Design(len(uncertain.names), *how)
        self.dims, self.shape = (*grid.dims, "draw"), (*grid.shape, self.design.per_cell)
        self.options = replace(options, variables=("regime", *uncertain.metrics))
        types = columns(self.options)
        self.columns: Mapping[str, np.dtype[Any]] = {name: types[name] for name in ("regime", *uncertain.metrics)}

    @classmethod
    def of(cls, given: Config, section: Uncertain, options: Options) -> Study:
        """The draws of a configuration, or its subset simulations."""
        return cls(given, options) if section.subset is None else RareStudy(given, section.subset, options)

    @classmethod
    def explain(cls, section: Uncertain, config: Config) -> Iterator[tuple[str, str, str]]:
        """The quantities with their distributions, and how they are drawn."""
        for name, scatter in section.quantities.items():
            yield name, "uncertain", scatter.text(SEARCHABLE[name].units)
        yield "sampling", "subset simulation" if section.subset else "Sobol points", section.method_in_words

    @classmethod
    def own_dims(cls) -> set[str]:
        """Those of probabilities and indices, and that of quantiles."""
        return super().own_dims() | {"quantile"}

    @classmethod
    def report(cls, ds: xr.Dataset) -> Iterator[str | ReportTable]:
        """The probability of each regime (of many cells its range), which quantity decides, what is not known."""
        dims = [str(dim) for dim in ds["probability"].dims if dim != "state"]
        rows = []
        for name in ds["state"].values:
            regime = ds.sel(state=name)
            value, error = regime["probability"], regime["probability_error"]
            if "levels" in ds or float(regime["probability_high"].max()) > 0:
                numbers = (value, error) if not dims else (value.min(), value.max(), error.max())
                rows.append([flag_label(str(name)), *(f"{float(number):.4g}" for number in numbers)])
        headings = ("probability", "standard error") if not dims else ("from", "to", "largest error")
        yield ReportTable("", ("regime",), headings, rows)
        if not dims and "sobol_total" in ds:
            known = ds["state"].values[ds["sobol_total"].notnull().any("quantity").values]
            places = [(str(name), str(quantity)) for name in known for quantity in ds["quantity"].values]
            rows = [
                [flag_label(name), quantity, *(f"{float(ds[key].sel(state=name, quantity=quantity)):.2f}"
                                               for key in ("sobol_first", "sobol_total"))]
                for name, quantity in places
            ]  # fmt: skip
            yield ReportTable("", ("regime", "quantity"), ("first-order index", "total"), rows)
        if (undecided := float(ds["undecided"].mean())) > 0:
            yield f"bounds   probability_low and probability_high allow for {undecided:.3g} of the draws, undecided"
        yield f"method   {ds.attrs['uncertain_method']}"

    @classmethod
    def is_drawn(cls, ds: xr.Dataset) -> bool:
        """True but for the probability of one rare event."""
        return "levels" not in ds or ds["probability"].ndim > 1

    @classmethod
    def figure(
        cls, ds: xr.Dataset, variable: str | None, select: Mapping[str, Any], title: str | None, look: Any, state: str
    ) -> Figure | None:
        """The probability of a state; metrics are maps."""
        from stickslip.dataset.selection import selected
        from stickslip.plots.lines import plot_probability

        if variable not in (None, "regime"):
            return None
        places = dict(select)
        state = places.pop("state", state)
        return plot_probability(selected(ds, places)[0], state, title=title, look=look)

    @property
    def size(self) -> int:
        """Number of draws, of all cells together."""
        return prod(self.shape)

    def __getitem__(self, part: slice) -> Parameters:
        """The parameters of a range of draws."""
        place = self.design.place(part.start, part.stop)
        return self.inputs.cells(place.cell, self.design.normals(place))[0]

    def compute(self, items: range, stop: StopFlag, moved: Moved | None = None) -> Results:
        """The results of draws."""
        place = self.design.place(items.start, items.stop)
        results = self.inputs.compute(place.cell, self.design.normals(place), self.options, stop, moved)
        return {name: results[name] for name in self.columns}

    def dataset(self, parts: Sequence[Results], attributes: Mapping[str, Any]) -> xr.Dataset:
        """Probabilities of the regimes, moments of the metrics and Sobol indices over the axes."""
        uncertain, grid = self.inputs.uncertain, self.inputs.grid
        results = reduced(parts, grid.size, self.design, uncertain.metrics, uncertain.quantiles)
        return _dataset(self.inputs, STATES, uncertain.quantiles, results, attributes)
