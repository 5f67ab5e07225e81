"""Cells of which one or two parameters are left open, and the ranges in which borders are searched along these."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from itertools import product
from typing import Any

import numpy as np
import xarray as xr

from stickslip.config.checks import (
    Between,
    Line,
    broken_rules,
    checked_range,
    line_along,
    plane_along,
    two_parameters,
)
from stickslip.config.grid import build_grid
from stickslip.config.model import Config
from stickslip.dataset.build import given_cells
from stickslip.engine import Options
from stickslip.errors import ArgumentError
from stickslip.studies.borders.search import Floats, Integers, Scan
from stickslip.vocabulary.cells import Cells
from stickslip.vocabulary.models import model_of
from stickslip.vocabulary.quantities import PARAMETERS, SEARCHABLE
from stickslip.vocabulary.suggest import listed, suggest

CellsOrConfig = Mapping[str, Any] | xr.Dataset | Config


@dataclass(frozen=True)
class Side(Scan):
    """A parameter that is left open, in SI; `points` on its range are looked at first, or are a grid.

    written_in : the unit in which it is shown.
    """

    name: str = ""
    written_in: str | None = None

    def at(self, point: Integers, share: Floats) -> Floats:
        """Values a `share` (0 to 1) of the way from grid points to the next ones, by ratio on log spacing."""
        here, there = self.places[point], self.places[np.minimum(point + 1, self.points - 1)]
        if self.spacing == "log":
            return np.asarray(here * (there / here) ** share)
        return np.asarray(here + share * (there - here))


def lines_along(
    given: CellsOrConfig, along: str, between: Between | None, points: int, options: Options
) -> tuple[Cells, Side]:
    """Lines of cells along a parameter, whatever the cells say of it; without a range, over that of its axis.

    Raises TypeError or ValueError for what cannot be searched.
    """
    if along not in SEARCHABLE:
        near = suggest(str(along), SEARCHABLE)
        hint = f"; did you mean {near!r}?" if near else f"; known are {', '.join(SEARCHABLE)}"
        raise TypeError(f"along: {along!r} is not a parameter of a cell{hint}")
    if isinstance(given, Config):
        cells, (side,) = _of_config(given, {along: line_along(given, along, between)}, points)
    else:
        cells, (side,) = _of_cells(given, {along: between}, points, options)
    return cells, side


def plane_over(
    given: CellsOrConfig,
    axes: tuple[str, str] | None,
    between: Mapping[str, Between],
    points: int,
    options: Options,
) -> tuple[Cells, Side, Side]:
    """Planes of cells over two parameters (y, x), by default the last two axes of a configuration; and both.

    Raises TypeError or ValueError for what cannot be searched.
    """
    if isinstance(given, Config):
        cells, (y, x) = _of_config(given, plane_along(given, axes, between), points)
    elif axes is None:
        raise ValueError("axes: missing; cells need the names of the two parameters that vary, (y, x)")
    else:
        names = two_parameters(axes, between)
        cells, (y, x) = _of_cells(given, {name: between.get(name) for name in names}, points, options)
    return cells, y, x


def _of_config(config: Config, lines: dict[str, Line], points: int) -> tuple[Cells, list[Side]]:
    for rule in broken_rules(config, lines):
        got = rule.got or "values"
        raise ArgumentError(str(rule.path[-1]), f"got {got} for which no cell is possible, expected {rule.expected}")
    sides = [
        _side(name, line.between, points, line.spacing, config.written_in.get(name)) for name, line in lines.items()
    ]
    return build_grid(config.without(*lines)), sides


def _of_cells(
    given: Mapping[str, Any] | xr.Dataset, ranges: Mapping[str, Between | None], points: int, options: Options
) -> tuple[Cells, list[Side]]:
    """Cells are checked at the corners of the ranges: bounds that hold there hold between, since they are linear."""
    sides = []
    for name, between in ranges.items():
        if name not in PARAMETERS and name in SEARCHABLE:
            others = listed(model_of(options.law).replaced, "and")
            raise ValueError(f"along: {name} is measured of a curve; cells have {others} instead")
        if between is None:
            raise ValueError(f"between: missing; cells need a range of {name} to search, (low, high)")
        if name in PARAMETERS:  # others are refused with the cells
            between = checked_range(name, between)
        sides.append(_side(name, between, points))
    for corner in product(*((side.high, side.low) for side in sides)):
        values = dict(zip(ranges, corner, strict=True))
        if isinstance(given, xr.Dataset):
            complete: Any = given.drop_vars(list(ranges), errors="ignore").assign(values)
        else:
            complete = {**given, **values}
        cells = given_cells(complete, options)
    return cells.without(*ranges), sides


def _side(name: str, between: Between, points: int, spacing: str | None = None, written_in: str | None = None) -> Side:
    return Side(*between, points, spacing or Scan.over(*between, 2).spacing, name, written_in)
