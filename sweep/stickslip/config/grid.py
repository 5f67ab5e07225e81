"""The grid of a configuration: dimensions, coordinates, and the parameters of any range of cells.

Cells are numbered with the last dimension running fastest. Nothing here is as long as the grid: the parameters of cells
are computed for the range that is asked for.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from stickslip.config.model import Axis, Config, Group, Range, Values
from stickslip.vocabulary import units
from stickslip.vocabulary.curve import Coefficients, coefficients
from stickslip.vocabulary.parameter import Parameter
from stickslip.vocabulary.quantities import DRIVE, MEASURED, PARAMETERS, QUANTITIES
from stickslip.vocabulary.results import VARIABLES

Floats = NDArray[np.float64]
_OF_CURVE = "_of_curve"


@dataclass(frozen=True, eq=False)
class Coordinate:
    """One quantity along one dimension.

    values : in SI, one per point; NaN where the quantity is absent. spacing : "linear", "log" or "values" (a list).
    labels : names of the points; with them the dimension is indexed by names, not by values.
    """

    name: str
    dim: str
    values: Floats
    units: str
    long_name: str
    spacing: str
    labels: tuple[str, ...] | None = None


@dataclass(frozen=True, eq=False)
class _Column:
    """What a quantity is along one dimension."""

    dimension: int
    values: Floats


@dataclass(frozen=True, eq=False)
class Grid:
    """All cells of a configuration.

    dims, shape : names and lengths of the dimensions, outermost first. No dimensions: one cell.
    coords : quantities that vary; several may share a dimension.
    fixed : parameters that are equal in all cells, by names of `PARAMETERS`, in SI, NaN for absent ones. The
        coefficients a1 to a3 are in neither where the curve is given by what is measured and that varies.
    written_in : by quantity, the unit in which the configuration has it, and in which results are shown.
    """

    dims: tuple[str, ...]
    shape: tuple[int, ...]
    coords: tuple[Coordinate, ...]
    fixed: dict[str, float]
    written_in: dict[str, str]
    _measured: dict[str, float]  # quantities of MEASURED that do not vary while others of the curve do
    _columns: dict[str, _Column]

    @property
    def size(self) -> int:
        """Number of cells."""
        return math.prod(self.shape)

    def cells(self, start: int, stop: int) -> dict[str, Floats]:
        """The parameters of the cells from `start` up to, not including, `stop`.

        Every name of `PARAMETERS`, of a rig those of `DRIVE` too, in SI, each an array of length stop - start that
        belongs to the caller. Raises IndexError for cells outside the grid.
        """
        return parameters_of(self.quantities(start, stop))

    def quantities(self, start: int, stop: int) -> dict[str, Floats]:
        """The same as they are given, before a1 to a3 follow from what is measured of the curve."""
        if not 0 <= start <= stop <= self.size:
            raise IndexError(f"cells {start} to {stop} of a grid of {self.size}")
        return self.quantities_at(np.arange(start, stop, dtype=np.int64))

    def at(self, cells: NDArray[np.int64]) -> dict[str, Floats]:
        """The parameters of the cells of these numbers, in any order."""
        return parameters_of(self.quantities_at(cells))

    def quantities_at(self, cells: NDArray[np.int64]) -> dict[str, Floats]:
        """The same as they are given."""
        points = np.unravel_index(cells, self.shape) if self.shape else ()
        known = {name: np.full(cells.size, value) for name, value in (self.fixed | self._measured).items()}
        return known | {name: column.values[points[column.dimension]] for name, column in self._columns.items()}


def parameters_of(quantities: Mapping[str, Floats]) -> dict[str, Floats]:
    """The parameters of cells whose quantities these are: a1 to a3 follow from what is measured, where it is given."""
    known = dict(quantities)
    if "mu_start" in known:
        known |= _curve(known)._asdict()
    return {name: known[name] for name in (*PARAMETERS, *DRIVE) if name in known}


def build_grid(config: Config) -> Grid:
    """The grid of a configuration."""
    fixed = config.fixed()
    coords: list[Coordinate] = []
    columns: dict[str, _Column] = {}
    for number, axis in enumerate(config.axes):
        along = _coordinates(axis)
        coords += along
        members = axis.members if isinstance(axis, Group) else (axis,)
        columns |= {m.name: _Column(number, c.values) for m, c in zip(members, along, strict=True)}
    measured = {name: fixed.pop(name) for name in MEASURED if name in fixed}
    if len(measured) == len(MEASURED) and "a4" in fixed:
        fixed |= {name: float(value) for name, value in _curve(measured | fixed)._asdict().items()}
        measured = {}
    return Grid(
        dims=tuple(_dimension(axis) for axis in config.axes),
        shape=tuple(axis.size for axis in config.axes),
        coords=tuple(coords),
        fixed={name: fixed[name] for name in (*PARAMETERS, *DRIVE) if name in fixed},
        written_in=config.written_in,
        _measured=measured,
        _columns=columns,
    )


def _curve(known: Mapping[str, Floats] | Mapping[str, float]) -> Coefficients:
    return coefficients(known["mu_start"], known["mu_reversal"], known["v_reversal"], known["a4"])


def _dimension(axis: Axis) -> str:
    """Name of the dimension of an axis: that of its quantity, if its values can be an index of numbers."""
    if isinstance(axis, Group):
        return axis.name
    return f"{axis.name}_case" if _has_words(axis) else _coordinate_name(axis.name)


def _has_words(axis: Range | Values) -> bool:
    return isinstance(axis, Values) and any(map(math.isnan, axis.values))


def _coordinate_name(name: str) -> str:
    """Name of a quantity in a dataset, where a result may have the plain name (mu_reversal as it occurred)."""
    return name + _OF_CURVE if name in VARIABLES else name


def quantity_of(coordinate: str) -> str:
    """The quantity behind the name of a coordinate: the opposite of `_coordinate_name`."""
    return coordinate.removesuffix(_OF_CURVE)


def _coordinates(axis: Axis) -> list[Coordinate]:
    """The coordinates along the dimension of an axis."""
    dim = _dimension(axis)
    if isinstance(axis, Group):
        return [_coordinate(member, dim, "values", axis.labels) for member in axis.members]
    if isinstance(axis, Range):
        return [_coordinate(axis, dim, axis.spacing, None)]
    declared = QUANTITIES[axis.name]
    labels = tuple(_label(value, declared) for value in axis.values) if _has_words(axis) else None
    return [_coordinate(axis, dim, "values", labels)]


def _coordinate(axis: Range | Values, dim: str, spacing: str, labels: tuple[str, ...] | None) -> Coordinate:
    declared = QUANTITIES[axis.name]
    name = _coordinate_name(axis.name)
    return Coordinate(name, dim, axis.points(), declared.units, declared.long_name, spacing, labels)


def _label(value: float, declared: Parameter) -> str:
    """A value as the name of a point."""
    written = declared.written(value)
    return written if isinstance(written, str) else f"{written!r} {units.spelled(declared.units)}".rstrip()
