"""One cell out of a configuration: its axes, and whatever else one likes, at chosen values."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

from . import units
from .config import make_config
from .grid import build_grid
from .models import Axis, Config, Group, Range
from .problems import ConfigError, Problem, listed, nearest
from .quantities import HORIZON_UNITS, QUANTITIES

_SOURCE = "--at"


def cell_at(config: Config, settings: Iterable[str]) -> dict[str, float]:
    """Parameters of one cell, in SI, by names of `PARAMETERS`.

    settings : texts like ``stiffness=5 N/mm``, ``velocity=sticking`` or, for quantities that vary together,
        ``lubricant=grease`` (a label, or a position counted from 0). Every axis needs one, other quantities may have
        one.
    Raises ConfigError.
    """
    data = config.resolved()
    axes = {axis.name: axis for axis in config.axes}
    for name, value in map(_split, settings):
        if isinstance(axis := axes.get(name), Group):
            for member, at_point in _point(axis, value).items():
                data[QUANTITIES[member].section][member] = at_point
        else:
            _check_name(name, axes)
            data[QUANTITIES[name].section][name] = _number_or_text(value)
        axes.pop(name, None)
        data["axes"].pop(name, None)
    if axes:
        raise ConfigError(_SOURCE, [_missing(axis) for axis in axes.values()])
    cells = build_grid(make_config(data, _SOURCE)).cells(0, 1)
    return {name: float(values[0]) for name, values in cells.items()}


def seconds(text: str) -> float:
    """A time on the command line: a number of seconds, or a text with a unit. Raises ConfigError."""
    try:
        time = units.si_value(_number_or_text(text), HORIZON_UNITS)
    except units.QuantityError as error:
        raise ConfigError("--duration", [Problem((), f"got {text!r}, {error}")]) from None
    if time <= 0:
        raise ConfigError("--duration", [Problem((), f"got {text!r}, expected a time above 0 s")])
    return time


def _split(setting: str) -> tuple[str, str]:
    name, equals, value = setting.partition("=")
    if not equals:
        raise ConfigError(_SOURCE, [Problem((), f"got {setting!r}, expected NAME=VALUE")])
    return name.strip(), value.strip()


def _number_or_text(value: str) -> float | str:
    try:
        return float(value)
    except ValueError:
        return value


def _check_name(name: str, axes: Iterable[str]) -> None:
    known = [*axes, *(quantity for quantity in QUANTITIES if quantity not in axes)]
    if name not in known:
        near = nearest(name, known)
        hint = f"did you mean {near}?" if near else None
        raise ConfigError(_SOURCE, [Problem((name,), f"unknown quantity, expected {listed(known)}", hint=hint)])


def _point(group: Group, value: str) -> dict[str, Any]:
    """The quantities of a group at one of its points."""
    labels = group.labels or ()
    if value in labels:
        position = labels.index(value)
    elif value.isdecimal() and int(value) < group.size:
        position = int(value)
    else:
        expected = listed([*labels, f"a position from 0 to {group.size - 1}"])
        raise ConfigError(_SOURCE, [Problem((group.name,), f"got {value!r}, expected {expected}")])
    return {member.name: member.values[position] for member in group.members}


def _missing(axis: Axis) -> Problem:
    if isinstance(axis, Group):
        return Problem((axis.name,), "missing, expected one of the points of the group", hint=f"--at {axis.name}=0")
    example = axis.start if isinstance(axis, Range) else axis.values[0]
    return Problem((axis.name,), "missing, expected a value for this axis", hint=f"--at {axis.name}={example}")
