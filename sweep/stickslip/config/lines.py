"""The lines of a configuration along one parameter: which axis they replace, and from where to where they go."""

from __future__ import annotations

from collections.abc import Iterator
from typing import NamedTuple

import numpy as np

from stickslip.config.model import Axis, Config, Group, Range
from stickslip.config.rules import Finding, Space, findings, members
from stickslip.errors import ArgumentError, QuantityError
from stickslip.vocabulary.quantities import MEASURED, QUANTITIES, REPLACED
from stickslip.vocabulary.words import listed

Between = tuple[float, float]
Ends = tuple[float | str, float | str]  # in SI, or texts with units


class Line(NamedTuple):
    """axis : of the parameter, None if it is fixed. spacing : of that axis where its range is searched, else None."""

    axis: Axis | None
    between: Between
    spacing: str | None


def line_along(config: Config, along: str, between: Between | None) -> Line:
    """The lines along a parameter; without a range, over that of its axis. Raises ArgumentError."""
    if config.drive is not None:
        raise ArgumentError("along", "the configuration has a drive: cells of a rig have no regime to search for")
    if config.uncertain is not None:
        what = "the configuration has uncertain quantities, and a border is that of known ones; leave uncertain out"
        raise ArgumentError("along", what)
    names = {member.name for axis in config.axes for member in members(axis)} | set(config.fixed())
    forms = ((REPLACED, tuple(MEASURED)), (tuple(MEASURED), REPLACED))
    for own_form, other in forms:
        if along in own_form and names & set(other):
            what = f"{along} follows from {listed(other, 'and')} in this configuration; "
            raise ArgumentError(
                "along", what + f"give the curve by {listed((*own_form, 'a4'), 'and')} to search along it"
            )
    for axis in config.axes:
        if isinstance(axis, Group) and any(member.name == along for member in axis.members):
            raise ArgumentError("along", f"{along} varies together with others in the axis {axis.name}")
    own = next((axis for axis in config.axes if not isinstance(axis, Group) and axis.name == along), None)
    spacing = own.spacing if isinstance(own, Range) and between is None else None
    if between is None:
        if own is None:
            raise ArgumentError("between", f"missing; {along} is no axis of the configuration, so it needs a range")
        points = own.points()
        numbers = points[~np.isnan(points)]
        between = (float(numbers.min()), float(numbers.max())) if numbers.size else (np.nan, np.nan)
    return Line(own, checked_range(along, between), spacing)


def in_si(along: str, between: Ends) -> Between:
    """Both ends with texts read, as numbers in SI; whatever is no text is left to `checked_range`.

    Raises ArgumentError.
    """
    if along not in QUANTITIES or not isinstance(between, tuple | list):
        return between  # type: ignore[return-value]
    try:
        return tuple(QUANTITIES[along].read(end) if isinstance(end, str) else end for end in between)  # type: ignore[return-value]
    except QuantityError as error:
        raise ArgumentError("between", f"got {between!r} for {along}, {error}") from None


def checked_range(along: str, between: Between) -> Between:
    """Both ends as numbers, in order and within the bounds of the parameter. Raises TypeError or ArgumentError."""
    try:
        low, high = (float(end) for end in between)
    except (TypeError, ValueError):
        raise TypeError(f"between: got {between!r}, expected two numbers (low, high)") from None
    row = QUANTITIES[along]
    for word, end in (("lower", low), ("upper", high)):
        if not (np.isfinite(end) and row.allows(end)):
            expected = row.expected.removesuffix(row.otherwise)
            raise ArgumentError("between", f"got {end:g} as {word} end of {along}, expected {expected}")
    if not low < high:
        hint = "; swap the ends" if low > high else ""
        what = f"got {low:g} to {high:g}, expected the lower end first and the upper above it{hint}"
        raise ArgumentError("between", what)
    return low, high


def broken_rules(config: Config, along: str, line: Line) -> Iterator[Finding]:
    """What must hold between quantities and does not, somewhere on a line."""
    low, high = line.between
    others = tuple(axis for axis in config.axes if axis is not line.axis)
    searched = Range.model_construct(name=along, spacing="linear", start=low, stop=high, num=2)
    fixed = {name: value for name, value in config.fixed().items() if name != along}
    for found in findings(Space(fixed, (*others, searched), law=config.friction.law)):
        path = ("border", "between") if found.path[:2] == ("axes", along) else found.path
        yield found._replace(path=path)
