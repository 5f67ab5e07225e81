"""Draws computed: items of a run are the draws of every cell of the axes; any range is computed by itself."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from math import prod
from typing import TYPE_CHECKING, Any

import numpy as np
import xarray as xr

from stickslip.config.model import Config
from stickslip.config.studies import Moved, Study, Table
from stickslip.config.uncertain import Uncertain
from stickslip.engine import Options, Results, StopFlag, columns
from stickslip.studies.uncertainty.design import Design
from stickslip.studies.uncertainty.inputs import VARIABLES, Inputs
from stickslip.studies.uncertainty.reduction import STATES, Summary, reduced
from stickslip.studies.uncertainty.subset import RareStudy
from stickslip.vocabulary.cells import Parameters
from stickslip.vocabulary.flags import flag_label

if TYPE_CHECKING:
    from matplotlib.figure import Figure


class SampleStudy(Study):
    """The draws of a configuration; what is kept of each is the regime, and the metrics asked for."""

    section, variables = Uncertain, VARIABLES
    subject = caption = "probability"
    name, counted = "sample", "draws"

    def __init__(self, config: Config, options: Options) -> None:
        self.inputs = Inputs(config)
        uncertain, grid = self.inputs.uncertain, self.inputs.grid
        self.design = Design(
            len(uncertain.names), uncertain.draws, uncertain.scramblings, uncertain.seed, bool(uncertain.indices)
        )
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
            yield name, "uncertain", scatter.in_words(name)
        if section.correlation is not None:
            yield "correlation", "of uncertain quantities", section.correlation_in_words
        yield "sampling", "subset simulation" if section.subset else "Sobol points", section.method_in_words

    @classmethod
    def own_dims(cls) -> set[str]:
        """Those of probabilities and indices, and that of quantiles."""
        return super().own_dims() | {"quantile"}

    @classmethod
    def report(cls, ds: xr.Dataset) -> Iterator[str | Table]:
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
        yield Table("", ("regime",), headings, rows)
        if not dims and "sobol_total" in ds:
            known = ds["state"].values[ds["sobol_total"].notnull().any("quantity").values]
            places = [(str(name), str(quantity)) for name in known for quantity in ds["quantity"].values]
            rows = [
                [flag_label(name), quantity, *(f"{float(ds[key].sel(state=name, quantity=quantity)):.2f}"
                                               for key in ("sobol_first", "sobol_total"))]
                for name, quantity in places
            ]  # fmt: skip
            yield Table("", ("regime", "quantity"), ("first-order index", "total"), rows)
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
        from stickslip.plots.uncertainty import plot_probability

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
        results = reduced(parts, grid.size, self.design, Summary(uncertain.metrics, uncertain.quantiles))
        return self.inputs.dataset(STATES, uncertain.quantiles, results, attributes)
