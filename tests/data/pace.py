"""How fast cells of a configuration move at most, times a factor: a study as CONTRIBUTING says to add one."""

from typing import Annotated

import numpy as np
from pydantic import Field

from stickslip.config.grid import build_grid
from stickslip.config.sections import BOOLEAN, StudySection, of_row
from stickslip.config.studies import Study
from stickslip.dataset.build import grid_coordinates, study_dataset
from stickslip.engine import compute_range, joined
from stickslip.plots import plot_map
from stickslip.vocabulary.parameter import Parameter, Variable, table


class Pace(StudySection):
    """How fast cells move."""

    key = "pace"
    rows = table(Parameter("factor", "1", "what speeds are multiplied by", key, default=1.0, above=0))
    factor: float = of_row(rows["factor"])
    squared: Annotated[bool, BOOLEAN] = Field(False, description="whether speeds are squared")


class PaceStudy(Study):
    section, subject, title = Pace, "pace", "Pace"
    variables = table(Variable("pace", "m s-1", "largest slip speed, times a factor"))
    name, counted, columns = "pace", "cells", {"pace": np.dtype(np.float64)}
    about, examples = "The largest slip speed.", ("my.yaml --factor 2",)

    def __init__(self, cells, section, options):
        self.cells, self.pace, self.options = cells, section, options
        self.dims, self.shape = cells.dims, cells.shape

    @classmethod
    def of(cls, given, section, options):
        return cls(build_grid(given), section, options)

    def compute(self, items, stop, moved=None):
        computed = compute_range(self.cells, items.start, items.stop, self.options, stop, moved)
        speed = computed["slip_speed_max"] * self.pace.factor
        return {"pace": speed**2 if self.pace.squared else speed}

    def dataset(self, parts, attributes):
        coordinates = grid_coordinates(self.cells)
        return study_dataset("pace", self.variables, joined(parts), self.dims, self.shape, coordinates, attributes)

    @classmethod
    def report(cls, ds):
        yield f"fastest  {float(ds['pace'].max()):.6g} m/s"

    @classmethod
    def figure(cls, ds, variable, select, title, look, state):
        return plot_map(ds, "pace", title="a figure of its own")
