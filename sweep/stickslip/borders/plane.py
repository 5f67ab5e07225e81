"""Planes of cells: two parameters over a fine grid, everything else as in a list of cells or a configuration."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from functools import cached_property
from math import prod
from typing import Any

import numpy as np
import xarray as xr

from stickslip.borders.lines import Lines, lines_of_cells
from stickslip.borders.search import Floats, Integers, Scan
from stickslip.config.checks import Between, broken_rules, plane_along, two_parameters
from stickslip.config.grid import build_grid, parameters_of
from stickslip.config.model import Config
from stickslip.dataset.build import grid_coordinates
from stickslip.errors import ArgumentError
from stickslip.vocabulary.cells import Cells, as_cells
from stickslip.vocabulary.quantities import PARAMETERS

Ranges = Mapping[str, Between]


@dataclass(frozen=True)
class Side:
    """One of the two parameters: its range in SI, `spacing` "linear" or "log", and how many grid points it has.

    written_in : the unit in which it is shown.
    """

    name: str
    low: float
    high: float
    spacing: str
    points: int
    written_in: str | None = None

    @cached_property
    def places(self) -> Floats:
        """The grid points, ascending: those an axis of a configuration with as many points has."""
        return Scan(self.low, self.high, self.points, self.spacing).places

    def at(self, point: Integers, share: Floats) -> Floats:
        """Values a `share` (0 to 1) of the way from grid points to the next ones, by ratio on log spacing."""
        here, there = self.places[point], self.places[np.minimum(point + 1, self.points - 1)]
        if self.spacing == "log":
            return np.asarray(here * (there / here) ** share)
        return np.asarray(here + share * (there - here))


@dataclass(frozen=True, eq=False)
class Plane:
    """Panels of cells over two parameters, `x` and `y`.

    dims, shape, coordinates : of the panels, one per combination of whatever else varies. others : their other
    quantities, each of length `size`. complete : the cells from all quantities.
    """

    x: Side
    y: Side
    dims: tuple[str, ...]
    shape: tuple[int, ...]
    coordinates: Mapping[str, xr.Variable]
    others: Cells
    complete: Callable[[Cells], Cells] = lambda cells: cells  # noqa: E731

    @property
    def size(self) -> int:
        """How many panels."""
        return prod(self.shape)

    def cells(self, panel: Integers, x: Floats, y: Floats) -> Callable[[int, int], Cells]:
        """Cells at these values of both parameters, as the engine asks for them."""

        def some(start: int, stop: int) -> Cells:
            taken = {name: values[panel[start:stop]] for name, values in self.others.items()}
            return self.complete(taken | {self.x.name: x[start:stop], self.y.name: y[start:stop]})

        return some

    def part(self, panels: range) -> Plane:
        """Some of its panels, in a row."""
        others = {name: values[panels.start : panels.stop] for name, values in self.others.items()}
        return replace(self, dims=("panel",), shape=(len(panels),), coordinates={}, others=others)

    def check(self) -> None:
        """Raise ValueError if a cell is impossible: bounds are linear, so the corners of the plane tell."""
        corners = [(x, y) for x in (self.x.low, self.x.high) for y in (self.y.low, self.y.high)]
        for x, y in corners:
            as_cells(self.others | {self.x.name: np.array([x]), self.y.name: np.array([y])})


def plane_of_cells(
    cells: Mapping[str, Any] | xr.Dataset, axes: tuple[str, str] | None, between: Ranges, points: int
) -> Plane:
    """The plane over `axes` (y, x) through each of some cells. Raises TypeError or ValueError for bad input."""
    if axes is None:
        raise ValueError("axes: missing; cells need the names of the two parameters that vary, (y, x)")
    y, x = two_parameters(axes, between)
    if y not in between:
        raise ValueError(f"between: missing; cells need a range of {y} to search, (low, high)")
    given = {name: values for name, values in _plain(cells, y).items() if name not in (x, y)}
    across = lines_of_cells(given | {y: between[y][0]}, x, between.get(x))
    plain = {name: values for name, values in across.others(0, across.size).items() if name != y}
    along = lines_of_cells(plain | {x: across.between[0]}, y, between[y])
    return _plane(across, along, points)


def plane_of_config(config: Config, axes: tuple[str, str] | None, between: Ranges, points: int) -> Plane:
    """The plane over `axes` (y, x), by default the last two of the configuration, whose other axes are the panels.

    Raises TypeError or ValueError for what the configuration cannot give.
    """
    found = plane_along(config, axes, between)
    for broken in broken_rules(config, found):
        got = broken.got or "values"
        raise ArgumentError(
            str(broken.path[-1]), f"got {got} for which no cell is possible, expected {broken.expected}"
        )
    grid, written_in = build_grid(config.without(*found)), config.written_in
    y, x = (
        Side(name, *line.between, line.spacing or Scan.over(*line.between, 2).spacing, points, written_in.get(name))
        for name, line in found.items()
    )
    others, coordinates = grid.quantities(0, grid.size), grid_coordinates(grid)
    return Plane(x, y, grid.dims, grid.shape, coordinates, others, parameters_of)


def _plain(cells: Mapping[str, Any] | xr.Dataset, without: str) -> dict[str, Any]:
    """What cells say of parameters."""
    if not isinstance(cells, xr.Dataset):
        return dict(cells)
    kept = cells.drop_vars(without, errors="ignore")
    return {str(name): kept[name] for name in kept.variables if name in PARAMETERS}


def _plane(across: Lines, along: Lines, points: int) -> Plane:
    """A plane from lines along x, and along y in what is left."""
    y, x = _side(along, points), _side(across, points)
    others = {name: values for name, values in along.others(0, along.size).items() if name != x.name}
    coordinates = {name: one for name, one in across.coordinates.items() if name != y.name}
    plane = Plane(x, y, across.dims, across.shape, coordinates, others)
    plane.check()
    return plane


def _side(lines: Lines, points: int) -> Side:
    low, high = lines.between
    return Side(lines.along, low, high, lines.spacing or Scan.over(low, high, 2).spacing, points)
