"""What is seen: two sides of a map, everything else at a value, and the configuration that says exactly that."""

from __future__ import annotations

from collections.abc import Mapping
from copy import deepcopy
from dataclasses import dataclass, replace
from math import isnan
from typing import Any

from stickslip.config.model import Config, Range
from stickslip.config.reader import make_config
from stickslip.config.select import point_text, value_text
from stickslip.errors import ConfigError, Problem
from stickslip.explore.knobs import Knob, is_listed, knobs_of
from stickslip.explore.subject import Subject
from stickslip.vocabulary.quantities import QUANTITIES

Sides = tuple[int, int]  # most points along y and x
COARSE: Sides = (30, 40)
FULL: Sides = (300, 400)  # as many as a map on the screen has pixels, about
_POINTS = 160  # of a side that is no axis of the configuration
_ALSO = ("belt_speed", "stiffness", "damping", "mass", "normal_load")  # as sides of maps of fewer than two axes


@dataclass(frozen=True)
class View:
    """A map over `y` and `x`, axes of the configuration or other quantities.

    values : of quantities that were changed, in SI, NaN for absent ones. points : positions along listed axes that are
    no sides, by name; those left out are at their first point. variable : what is drawn.
    """

    y: str
    x: str
    values: Mapping[str, float]
    points: Mapping[str, int]
    variable: str = "regime"

    @property
    def plane(self) -> tuple[str, str]:
        """Both sides."""
        return self.y, self.x


def first_view(subject: Subject) -> View:
    """What is seen first: the last two axes, as in plots; with fewer, over quantities people ask about."""
    names = [name for name, axis in subject.axes.items() if axis.size > 1]
    also = [name for name in sides(subject) if name not in names]
    chosen = [*(name for name in _ALSO if name in also), *also]
    y, x = [*chosen[: max(0, 2 - len(names))][::-1], *names][-2:]
    return View(y, x, {}, {})


def sides(subject: Subject) -> list[str]:
    """What can be a side of the map: the axes, and what has a slider with a range of its own."""
    axes = [name for name, axis in subject.axes.items() if axis.size > 1]
    knobs = [knob for knob in knobs_of(subject, ("", "")) if knob.name not in axes and not isnan(knob.start)]
    return [*axes, *(knob.name for knob in knobs if not knob.rare)]


def with_plane(subject: Subject, view: View, y: str, x: str) -> View:
    """The view over other sides; of what becomes a side the value is forgotten, and a side is no side of itself."""
    if y == x:
        y, x = (view.x, x) if x != view.x else (y, view.y)
    kept = {name: value for name, value in view.values.items() if name not in (y, x)}
    points = {name: i for name, i in view.points.items() if name not in (y, x)}
    return replace(view, y=y, x=x, values=kept, points=points)


def config_of(subject: Subject, view: View, most: Sides = FULL) -> Config:
    """The configuration of a view, its axes of at most so many points. Raises ConfigError for what is not possible."""
    data = _data(subject, view)
    data["axes"] = {name: _axis(subject, name, n) for name, n in zip(view.plane, most, strict=True)}
    return make_config(data, "this view").shown_in(subject.written_in)


def cell_config(subject: Subject, view: View, at: Mapping[str, float | int]) -> Config:
    """The configuration of one cell of a view: at a value of each side, or at a position where its points are listed.

    Raises ConfigError.
    """
    data = _data(subject, view)
    for name in view.plane:
        _settle(subject, data, name, at[name])
    return make_config(data, "this cell")


def _data(subject: Subject, view: View) -> dict[str, Any]:
    """The configuration as plain data without axes, its sides left open."""
    data = deepcopy(subject.plain)
    data["axes"] = {}
    for name, axis in subject.axes.items():
        if name in view.plane:
            continue
        if is_listed(axis):
            _settle(subject, data, name, view.points.get(name, 0))
        elif name not in view.values:
            _settle(subject, data, name, start_value(subject, view, name))
    for name, value in view.values.items():
        if name not in view.plane:
            _settle(subject, data, name, value)
    for name in view.plane:
        if name in QUANTITIES:
            data[QUANTITIES[name].section].pop(name, None)
    return data


def _settle(subject: Subject, data: dict[str, Any], name: str, value: float | int) -> None:
    """Give an axis or a quantity its value, or its point."""
    axis = subject.axes.get(name)
    if axis is not None and is_listed(axis):
        for member in axis.members:
            row = QUANTITIES[member.name]
            data[row.section][member.name] = row.written(float(member.points()[int(value)]))
        return
    row = QUANTITIES[name]
    data[row.section][name] = row.written(float(value))


def _axis(subject: Subject, name: str, most: int) -> dict[str, Any]:
    """A side as plain data, of at most so many points."""
    axis = subject.axes.get(name)
    if axis is None:
        knob = knob_of(subject, name)
        spacing = "log" if knob.is_log else "linear"
        return {"start": knob.low, "stop": knob.high, "num": min(_POINTS, most), "spacing": spacing}
    plain = axis.resolved()
    if isinstance(axis, Range):
        return plain | {"num": min(axis.num, most)}
    if axis.size > FULL[0]:
        found = f"{axis.size} listed points; at most {FULL[0]} fit on a side of the map"
        raise ConfigError(subject.source, [Problem(("axes", name), found, hint="give the axis start, stop and num")])
    return plain


def knob_of(subject: Subject, name: str) -> Knob:
    """The slider a quantity would have. Raises KeyError."""
    return {knob.name: knob for knob in knobs_of(subject, ("", ""))}[name]


def start_value(subject: Subject, view: View, name: str) -> float:
    """What a quantity is where nobody changed it."""
    if name in subject.fixed:
        return subject.fixed[name]
    return knob_of(subject, name).start


def is_as_opened(subject: Subject, view: View) -> bool:
    """Whether a view shows what the file says, over two axes of its own."""
    return not view.values and all(name in subject.axes for name in view.plane)


def settings(subject: Subject, view: View, at: Mapping[str, float | int], digits: int | None = None) -> list[str]:
    """One cell of a view as NAME=VALUE, as the command line takes it: all that varies, and what was changed.

    digits : of numbers; None for all of them, so that it is that cell to the last bit.
    """

    def told(name: str, value: float) -> str:
        return value_text(name, value if digits is None or isnan(value) else float(f"{value:.{digits}g}"))

    found = {}
    for name, axis in subject.axes.items():
        if is_listed(axis):
            found[name] = point_text(axis, int(at.get(name, view.points.get(name, 0))))
        else:
            value = view.values.get(name, start_value(subject, view, name))
            found[name] = told(name, float(at.get(name, value)))
    changed = {**subject.assumed, **view.values, **{name: float(at[name]) for name in view.plane}}
    found |= {name: told(name, value) for name, value in changed.items() if name not in found}
    return [f"{name}={text}" for name, text in found.items()]
