"""The cells of a configuration: its grid."""

from __future__ import annotations

import math

from stickslip.config.model import Axis, Config, Group, Range, Values
from stickslip.vocabulary import units
from stickslip.vocabulary.cells import Cells, Coordinate, Floats
from stickslip.vocabulary.models import MODELS
from stickslip.vocabulary.parameter import Parameter
from stickslip.vocabulary.quantities import DRIVE, MEASURED, PARAMETERS, QUANTITIES
from stickslip.vocabulary.results import VARIABLES

_OF_CURVE = "_of_curve"


def build_grid(config: Config) -> Cells:
    """The cells of a configuration; nothing in them is as long as the grid."""
    fixed = config.fixed()
    coords: list[Coordinate] = []
    along: dict[str, tuple[int, Floats]] = {}
    for number, axis in enumerate(config.axes):
        coordinates = _coordinates(axis)
        coords += coordinates
        varying = axis.members if isinstance(axis, Group) else (axis,)
        along |= {member.name: (number, c.values) for member, c in zip(varying, coordinates, strict=True)}
    measured = {name: fixed.pop(name) for name in MEASURED if name in fixed}
    for model in MODELS:
        whole = model.completed({**fixed, **measured})
        if measured and all(name in whole for name in model.needed):
            fixed |= {name: float(whole[name]) for name in model.replaced}
            measured = {}
    return Cells(
        dims=tuple(_dimension(axis) for axis in config.axes),
        shape=tuple(axis.size for axis in config.axes),
        fixed={name: fixed[name] for name in (*PARAMETERS, *DRIVE) if name in fixed},
        along=along,
        measured=measured,
        coords=tuple(coords),
        written_in=config.written_in,
    )


def _dimension(axis: Axis) -> str:
    """Name of the dimension of an axis: that of its quantity, if its values can be an index of numbers."""
    if isinstance(axis, Group):
        return axis.name
    return f"{axis.name}_case" if _has_words(axis) else _coordinate_name(axis.name)


def _has_words(axis: Range | Values) -> bool:
    return isinstance(axis, Values) and any(map(math.isnan, axis.values))


def _coordinate_name(name: str) -> str:
    """Name of a quantity in a dataset, where a result may have the plain name (as it occurred)."""
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
