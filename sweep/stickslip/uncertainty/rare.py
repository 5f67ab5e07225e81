"""Subset simulations computed: items of a run are the repetitions of every cell of the axes."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import Any

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from stickslip.config.model import Config
from stickslip.config.options import options_of
from stickslip.config.uncertain import Subset
from stickslip.dataset.uncertainty import uncertain_dataset
from stickslip.engine import Options, Results, StopFlag
from stickslip.errors import StoppedError
from stickslip.study import Finished, Moved, Study, joined
from stickslip.uncertainty.inputs import Inputs
from stickslip.uncertainty.subset import subset_simulation
from stickslip.uncertainty.told import told
from stickslip.vocabulary.flags import REGIMES

Floats = NDArray[np.float64]

STATES = ("stick_slip",)
MARGIN = "restick_margin"  # a speed, below 0 in stick-slip: the limit-state function
UNKNOWN = [REGIMES.index(name) for name in ("not_computed", "unresolved", "failed")]
_LEVELS = 6  # about as many as are simulated, for estimates of time


class RareStudy(Study):
    """The subset simulations of a configuration."""

    name, counted = "sample", "simulations"
    columns: Mapping[str, np.dtype[Any]] = {
        "probability": np.dtype(np.float64), "unknown": np.dtype(np.float64),
        "levels": np.dtype(np.int32), "evaluations": np.dtype(np.int32),
    }  # fmt: skip

    def __init__(self, config: Config, subset: Subset, options: Options) -> None:
        self.inputs, self.subset, self.options = Inputs(config), subset, options
        grid = self.inputs.grid
        self.dims, self.shape = (*grid.dims, "repetition"), (*grid.shape, subset.repetitions)
        self.cells_each = self.weight = _LEVELS * subset.samples

    def compute(self, items: range, stop: StopFlag, moved: Moved | None = None) -> Finished:
        """The results of simulations."""
        results = self.blank(items)
        quantities = len(self.inputs.uncertain.names)
        for place, item in enumerate(items):
            cell, repetition = divmod(item, self.subset.repetitions)
            # The same numbers in every cell, so that cells differ by what they are and not by luck.
            rng = np.random.default_rng([self.subset.seed, repetition])
            try:
                found = subset_simulation(self._limit_state(cell, stop, moved), quantities, self.subset.samples, rng)
            except StoppedError:
                return Finished({}, False)
            for name in results:
                results[name][place] = getattr(found, name)
        return Finished(results)

    def _limit_state(self, cell: int, stop: StopFlag, moved: Moved | None) -> Callable[[Floats], Floats]:
        """The margin of a cell of the axes as a function of independent standard normal deviates (n, quantities)."""

        def margin(normals: Floats) -> Floats:
            found = self.inputs.compute(np.full(len(normals), cell), normals, self.options, stop, moved)
            if not found.complete:
                raise StoppedError
            return limit_of(found.results)

        return margin

    def blank(self, items: range) -> Results:
        """Simulations that are not computed: without a probability."""
        blank: Results = {name: np.zeros(len(items), kind) for name, kind in self.columns.items()}
        blank["probability"][:] = np.nan
        return blank

    def dataset(self, parts: Sequence[Results], attributes: Mapping[str, Any]) -> xr.Dataset:
        """The probability of stick-slip over the axes."""
        grid, count = self.inputs.grid, self.subset.repetitions
        whole = {name: values.reshape(grid.size, count) for name, values in joined(parts).items()}
        probability, unknown = whole["probability"], whole["unknown"].mean(1)
        found = {
            "probability": probability.mean(1, keepdims=True),
            "probability_error": probability.std(1, ddof=1, keepdims=True) / np.sqrt(count),
            "undecided": unknown,
            "levels": whole["levels"].max(1).astype(np.float64),
            "evaluations": whole["evaluations"].sum(1, dtype=np.float64),
        }
        said = self.inputs.uncertain
        return uncertain_dataset(
            grid, STATES, said.names, (), found, dict(attributes) | told(said, float(unknown.mean()))
        )


def rare_study(config: Config, subset: Subset) -> RareStudy:
    """The subset simulations that a configuration asks for."""
    return RareStudy(config, subset, options_of(config))


def limit_of(results: Results) -> Floats:
    """The limit-state function from results of cells: the margin, NaN where the regime is not known.

    Its sign is made that of the regime, which is what is asked for. A motion without a break-away has no margin, and is
    as far from stick-slip as can be.
    """
    margin, regime = results[MARGIN], results["regime"]
    sticks = regime == REGIMES.index("stick_slip")
    away = np.where(np.isnan(margin), np.inf, np.maximum(margin, 0.0))
    signed = np.where(sticks, np.fmin(margin, -np.finfo(np.float64).tiny), away)
    return np.asarray(np.where(np.isin(regime, UNKNOWN), np.nan, signed))
