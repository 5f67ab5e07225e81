"""The planes of a configuration over two parameters: which axes they replace, and from where to where they go."""

from __future__ import annotations

from collections.abc import Iterator, Mapping

from stickslip.config.lines import Between, Line, line_along
from stickslip.config.model import Config, Group, Range
from stickslip.config.rules import Finding, Space, findings
from stickslip.errors import ArgumentError

Plane = dict[str, Line]  # by parameter, y and x


def plane_along(config: Config, axes: tuple[str, str] | None, between: Mapping[str, Between]) -> Plane:
    """The plane over two parameters, y and x; the last two axes unless named. Raises TypeError or ArgumentError."""
    names = two_parameters(_last_two(config) if axes is None else axes, between)
    plane = {}
    for name in names:
        try:
            plane[name] = line_along(config, name, between.get(name))
        except ArgumentError as error:
            raise ArgumentError("axes" if error.key == "along" else error.key, error.what) from None
    return plane


def two_parameters(axes: tuple[str, str], between: Mapping[str, Between]) -> tuple[str, str]:
    """Both names, once they are two; every range belongs to one of them. Raises ArgumentError."""
    if isinstance(axes, str) or len(axes) != 2 or axes[0] == axes[1]:
        raise ArgumentError("axes", f"got {axes!r}, expected the names of two different parameters, (y, x)")
    for name in between:
        if name not in axes:
            raise ArgumentError("between", f"got a range for {name!r}, expected {axes[0]} or {axes[1]}")
    return axes[0], axes[1]


def broken_in_plane(config: Config, plane: Plane) -> Iterator[Finding]:
    """What must hold between quantities and does not, somewhere in a plane."""
    replaced = [line.axis for line in plane.values()]
    others = tuple(axis for axis in config.axes if not any(axis is one for one in replaced))
    searched = [
        Range.model_construct(name=name, spacing="linear", start=line.between[0], stop=line.between[1], num=2)
        for name, line in plane.items()
    ]
    fixed = {name: value for name, value in config.fixed().items() if name not in plane}
    for found in findings(Space(fixed, (*others, *searched), law=config.friction.law)):
        of_plane = found.path[:1] == ("axes",) and found.path[1] in plane
        yield found._replace(path=("contours", "between", found.path[1]) if of_plane else found.path)


def _last_two(config: Config) -> tuple[str, str]:
    names = [axis.name for axis in config.axes[-2:] if not isinstance(axis, Group)]
    if len(names) < 2:
        raise ArgumentError("axes", "missing; the last two axes of the configuration are not two single parameters")
    return names[0], names[1]
