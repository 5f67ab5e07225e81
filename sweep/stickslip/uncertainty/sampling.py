"""Draws computed: items of a run are the draws of every cell of the axes; any range is computed by itself."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np

from stickslip.config.model import Config
from stickslip.engine import Computed, Options, StopFlag, columns
from stickslip.uncertainty.design import Design
from stickslip.uncertainty.inputs import Inputs


@dataclass(frozen=True)
class Sample:
    """The draws of a configuration, and what is kept of each: the regime, and the metrics asked for."""

    config: Config
    options: Options

    @cached_property
    def inputs(self) -> Inputs:
        """The cells behind them."""
        return Inputs(self.config)

    @cached_property
    def design(self) -> Design:
        """Which draw an item is."""
        said = self.inputs.uncertain
        return Design(len(said.names), said.draws, said.scramblings, said.seed, bool(said.indices))

    @property
    def size(self) -> int:
        """Number of items."""
        return self.inputs.grid.size * self.design.per_cell

    @property
    def columns(self) -> dict[str, np.dtype[Any]]:
        """What is kept of an item: names and types."""
        kept = columns(self.options)
        return {name: kept[name] for name in ("regime", *self.inputs.uncertain.metrics)}

    def compute(self, items: range, stop: StopFlag, moved: Callable[[int], None] | None = None) -> Computed:
        """The results of items, by the calling thread."""
        place = self.design.place(items.start, items.stop)
        found = self.inputs.compute(place.cell, self.design.normals(place), self.options, stop, moved)
        return Computed({name: found.results[name] for name in self.columns}, found.done)
