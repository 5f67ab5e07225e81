"""Which cells lie on a line: all parameters but one, from a list of cells or from a configuration."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from math import prod
from typing import Any

import xarray as xr

from stickslip.config.checks import Between, broken_rules, checked_range, line_along
from stickslip.config.grid import build_grid, parameters_of
from stickslip.config.model import Config
from stickslip.dataset.build import grid_coordinates
from stickslip.dataset.given import given_cells
from stickslip.errors import ArgumentError
from stickslip.vocabulary.cells import Cells
from stickslip.vocabulary.quantities import PARAMETERS, SEARCHABLE
from stickslip.vocabulary.suggest import suggest


@dataclass(frozen=True, eq=False)
class Lines:
    """Lines of cells along one parameter.

    along : the parameter. between : its range, in SI. spacing : of the axis it is taken from, None for none.
    dims, shape, coordinates : of the lines. others : the other quantities of the lines from start to stop.
    complete : the cells from all quantities, `along` among them. written_in : the unit in which `along` is shown.
    """

    along: str
    between: Between
    spacing: str | None
    dims: tuple[str, ...]
    shape: tuple[int, ...]
    coordinates: Mapping[str, xr.Variable]
    others: Callable[[int, int], Cells]
    complete: Callable[[Cells], Cells] = lambda cells: cells  # noqa: E731
    written_in: str | None = None

    @property
    def size(self) -> int:
        """How many lines."""
        return prod(self.shape)


def lines_of_cells(
    cells: Mapping[str, Any] | xr.Dataset, along: str, between: Between | None, law: str = "stribeck"
) -> Lines:
    """Lines through cells as `evaluate` takes them; what they say of `along` itself is left out.

    Raises TypeError or ValueError for bad input.
    """
    _check_name(along)
    if along not in PARAMETERS:
        raise ValueError(f"along: {along} is measured of a curve; cells have a1, a2 and a3 instead")
    if between is None:
        raise ValueError(f"between: missing; cells need a range of {along} to search, (low, high)")
    between = checked_range(along, between)

    def at(end: float) -> Mapping[str, Any] | xr.Dataset:
        if isinstance(cells, xr.Dataset):
            return cells.drop_vars(along, errors="ignore").assign({along: end})
        return {**cells, along: end}

    full = given_cells(at(between[0]), law)
    given_cells(at(between[1]), law)  # bounds that hold at both ends hold between: they are linear
    del full.cells[along]
    return Lines(along, between, None, full.dims, full.shape, full.coordinates(), full.part)


def lines_of_config(config: Config, along: str, between: Between | None) -> Lines:
    """Lines through the grid of a configuration without the axis of `along`, whose range is searched by default.

    Raises TypeError or ValueError for what the configuration cannot give.
    """
    _check_name(along)
    line = line_along(config, along, between)
    _, between, spacing = line
    for broken in broken_rules(config, {along: line}):
        got = broken.got or "values"
        raise ArgumentError(
            str(broken.path[-1]), f"got {got} for which no cell is possible, expected {broken.expected}"
        )
    grid = build_grid(config.without(along))
    return Lines(
        along, between, spacing, grid.dims, grid.shape, grid_coordinates(grid), grid.quantities, parameters_of,
        config.written_in.get(along),
    )  # fmt: skip


def _check_name(along: str) -> None:
    if along not in SEARCHABLE:
        near = suggest(str(along), SEARCHABLE)
        hint = f"; did you mean {near!r}?" if near else f"; known are {', '.join(SEARCHABLE)}"
        raise TypeError(f"along: {along!r} is not a parameter of a cell{hint}")
