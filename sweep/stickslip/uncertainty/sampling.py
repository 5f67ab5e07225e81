"""Draws computed: items of a run are the draws of every cell of the axes; any range is computed by itself."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from math import prod
from typing import Any

import numpy as np
import xarray as xr

from stickslip.config.model import Config
from stickslip.config.options import options_of
from stickslip.dataset.studies import uncertain_dataset
from stickslip.engine import Options, Results, StopFlag, blank_results, columns
from stickslip.study import Finished, Moved, Study
from stickslip.uncertainty.design import Design
from stickslip.uncertainty.inputs import Inputs
from stickslip.uncertainty.reduction import STATES, Asked, reduced
from stickslip.uncertainty.told import told
from stickslip.vocabulary.cells import Cells


class SampleStudy(Study):
    """The draws of a configuration; what is kept of each is the regime, and the metrics asked for."""

    name, counted = "sample", "draws"

    def __init__(self, config: Config, options: Options) -> None:
        self.inputs = Inputs(config)
        said, grid = self.inputs.uncertain, self.inputs.grid
        self.design = Design(len(said.names), said.draws, said.scramblings, said.seed, bool(said.indices))
        self.dims, self.shape = (*grid.dims, "draw"), (*grid.shape, self.design.per_cell)
        self.options, kept = options, columns(options)
        self.columns: Mapping[str, np.dtype[Any]] = {name: kept[name] for name in ("regime", *said.metrics)}

    @property
    def size(self) -> int:
        """Number of draws, of all cells together."""
        return prod(self.shape)

    def cells(self, start: int, stop: int) -> Cells:
        """The parameters of draws."""
        place = self.design.place(start, stop)
        return self.inputs.cells(place.cell, self.design.normals(place))[0]

    def compute(self, items: range, stop: StopFlag, moved: Moved | None = None) -> Finished:
        """The results of draws."""
        place = self.design.place(items.start, items.stop)
        found = self.inputs.compute(place.cell, self.design.normals(place), self.options, stop, moved)
        return Finished({name: found.results[name] for name in self.columns}, found.complete)

    def blank(self, items: range) -> Results:
        """Draws that are "not computed", which the bounds of probabilities carry like others that are not decided."""
        blank = blank_results(len(items), self.options)
        return {name: blank[name] for name in self.columns}

    def dataset(self, parts: Sequence[Results], attributes: Mapping[str, Any]) -> xr.Dataset:
        """Probabilities of the regimes, moments of the metrics and Sobol indices over the axes."""
        said, grid = self.inputs.uncertain, self.inputs.grid
        found = reduced(parts, grid.size, self.design, Asked(said.metrics, said.quantiles))
        undecided = float(found["undecided"].mean())
        attributes = dict(attributes) | told(said, undecided)
        return uncertain_dataset(grid, STATES, said.names, said.quantiles, found, attributes)


def sample_study(config: Config) -> SampleStudy:
    """The draws that a configuration asks for."""
    return SampleStudy(config, options_of(config))
