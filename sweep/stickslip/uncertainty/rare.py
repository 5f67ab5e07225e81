"""Subset simulations computed: items of a run are the repetitions of every cell of the axes."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from stickslip.config.model import Config
from stickslip.config.scatter import Subset
from stickslip.engine import Computed, Options, Results, StopFlag
from stickslip.uncertainty.inputs import Inputs
from stickslip.uncertainty.subset import subset_simulation
from stickslip.vocabulary.flags import REGIMES

Floats = NDArray[np.float64]

STATES = ("stick_slip",)
MARGIN = "restick_margin"  # a speed, below 0 in stick-slip: the limit-state function
_COLUMNS = {
    "regime": np.int8,
    "probability": np.float64,
    "levels": np.int32,
    "evaluations": np.int32,
    "unknown": np.float64,
}


class _StoppedError(Exception):
    """The run was stopped on the way."""


@dataclass(frozen=True)
class RareSample:
    """The subset simulations of a configuration."""

    config: Config
    options: Options

    @cached_property
    def inputs(self) -> Inputs:
        """The cells behind them."""
        return Inputs(self.config)

    @property
    def subset(self) -> Subset:
        """How they are simulated."""
        found = self.inputs.uncertain.subset
        if found is None:
            raise ValueError("this configuration asks for no subset simulation")
        return found

    @property
    def size(self) -> int:
        """Number of items."""
        return self.inputs.grid.size * self.subset.repetitions

    @property
    def columns(self) -> dict[str, np.dtype[Any]]:
        """What is kept of an item: names and types."""
        return {name: np.dtype(kind) for name, kind in _COLUMNS.items()}

    def compute(self, items: range, stop: StopFlag, moved: Callable[[int], None] | None = None) -> Computed:
        """The results of items, by the calling thread."""
        results: Results = {name: np.zeros(len(items), kind) for name, kind in _COLUMNS.items()}
        for place, item in enumerate(items):
            cell, repetition = divmod(item, self.subset.repetitions)
            # The same numbers in every cell, so that cells differ by what they are and not by luck.
            rng = np.random.default_rng([self.subset.seed, repetition])
            try:
                found = subset_simulation(self.limit_state(cell, stop), len(self.inputs.uncertain.names),
                                          self.subset.samples, rng)  # fmt: skip
            except _StoppedError:
                return Computed(results, place)
            for name in ("probability", "levels", "evaluations", "unknown"):
                results[name][place] = getattr(found, name)
            results["regime"][place] = 1  # anything but "not computed"
            if moved:
                moved(1)
        return Computed(results, len(items))

    def limit_state(self, cell: int, stop: StopFlag) -> Callable[[Floats], Floats]:
        """The margin of a cell of the axes as a function of independent standard normal deviates (n, quantities)."""

        def margin(normals: Floats) -> Floats:
            found = self.inputs.compute(np.full(len(normals), cell), normals, self.options, stop)
            if not found.complete:
                raise _StoppedError
            return limit_of(found.results)

        return margin


def limit_of(results: Results) -> Floats:
    """The limit-state function from results of cells: the margin, NaN where the regime is not known.

    Its sign is made that of the regime, which is what is asked for. A cell that never breaks away has no slip and no
    margin, and is as far from stick-slip as can be.
    """
    margin, regime = results[MARGIN], results["regime"]
    sticks = regime == REGIMES.index("stick_slip")
    margin = np.where(regime == REGIMES.index("stuck"), np.inf, margin)
    return np.where(np.isin(regime, [REGIMES.index(name) for name in ("not_computed", "unresolved", "failed")]), np.nan,
                    np.where(sticks, np.fmin(margin, -np.finfo(float).tiny), np.fmax(margin, 0.0)))  # fmt: skip


def reduced(blocks: Iterable[Results], cells: int, repetitions: int) -> dict[str, Floats]:
    """What the repetitions of each cell say together, by name, the first dimension that of the cells."""
    columns: dict[str, list[NDArray[Any]]] = {}
    for block in blocks:
        for name, values in block.items():
            columns.setdefault(name, []).append(values)
    all_of = {name: np.concatenate(values).reshape(cells, repetitions) for name, values in columns.items()}
    probability = np.where(all_of["regime"] > 0, all_of["probability"], np.nan)
    return {
        "probability": probability.mean(1, keepdims=True),
        "probability_error": probability.std(1, ddof=1, keepdims=True) / np.sqrt(repetitions),
        "undecided": all_of["unknown"].mean(1),
        "levels": all_of["levels"].max(1).astype(np.float64),
        "evaluations": all_of["evaluations"].sum(1, dtype=np.float64),
    }
