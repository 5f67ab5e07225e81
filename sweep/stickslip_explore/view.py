"""What is explored, a configuration or a map that was computed from one; and what is seen of it: two sides,
everything else at a value or on a slider."""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property, reduce
from math import inf, isnan, log10, sqrt
from operator import getitem
from pathlib import Path
from typing import Any

import numpy as np
import xarray as xr

from stickslip.config.grid import options_of, point_text, quantity_of, recipe_of
from stickslip.config.model import Axis, Config, Group, Range
from stickslip.config.reader import load_config
from stickslip.config.sections import OUTPUT_SUFFIXES, Output
from stickslip.config.studies import study_class
from stickslip.config.yaml import Setting
from stickslip.engine import Options
from stickslip.errors import ConfigError, Problem
from stickslip.files import reading
from stickslip.files.locations import location
from stickslip.studies.lines import broken_rules
from stickslip.vocabulary.cells import as_cells, parameters_of, scales_of
from stickslip.vocabulary.display_units import Unit, quantity, unit_for, units_shown
from stickslip.vocabulary.models import Model, laws_with, model_of
from stickslip.vocabulary.parameter import FRICTION
from stickslip.vocabulary.quantities import QUANTITIES

Ends = tuple[float, float, float]  # of a slider, and what it shows where the quantity is absent
Sides = tuple[int, int]  # most points along y and x
At = Mapping[str, float | int]  # a value of each side, or a position where its points are listed
COARSE: Sides = (30, 40)
FULL: Sides = (300, 400)  # as many as a map on the screen has pixels, about
_POINTS = 160  # of a side that is no axis of the configuration
_ALSO = ("belt_speed", "stiffness", "damping", "mass", "normal_load")  # as sides of maps of fewer than two axes
_FACTOR = 10.0  # how far a slider reaches either way where ratios count
_DIGITS = 4
_RARE = ("displacement", "velocity", "contact_time", "ageing_rate", "ageing_time", "delta")


@dataclass(frozen=True, eq=False)
class Source:
    """A configuration of a map, and the map if it was computed.

    name : of the file, as it was given. notes : what is left out of it, for people. computed : the dataset of a result.
    assumed : values of what the file says no value of.
    """

    name: str
    config: Config
    notes: tuple[str, ...] = ()
    computed: xr.Dataset | None = None
    assumed: Mapping[str, float] = field(default_factory=dict)

    @cached_property
    def written_in(self) -> Mapping[str, str]:
        """By quantity, the unit in which it was written, of a result that its file shows it in."""
        of_file = {} if self.computed is None else units_shown(self.computed)
        return self.config.written_in | {quantity_of(name): unit for name, unit in of_file.items()}

    @cached_property
    def axes(self) -> Mapping[str, Axis]:
        """The axes of the configuration by name."""
        return {axis.name: axis for axis in self.config.axes}

    @cached_property
    def fixed(self) -> dict[str, float]:
        """The quantities that do not vary, in SI; NaN for words."""
        fixed = self.config.fixed()
        return {name: fixed[name] for name in QUANTITIES if name in fixed}

    @cached_property
    def typical(self) -> dict[str, float]:
        """Values of all quantities, in SI: what does not vary, and the middles of the axes, of lists without words."""
        numbers = {row.name: row.points()[~np.isnan(row.points())] for axis in self.config.axes for row in axis.members}
        return self.fixed | {name: float(v[v.size // 2]) if v.size else np.nan for name, v in numbers.items()}

    @cached_property
    def options(self) -> Options:
        """Options of the integration: until the regime is decided."""
        return replace(options_of(self.config), early_stop=True)


def open_source(path: str | Path, settings: Sequence[Setting] = ()) -> Source:
    """The source in a file, YAML or a result, with settings of a command line. Raises ConfigError, StoreError."""
    name, where = str(path), location(path)
    if where.suffix.lower() not in OUTPUT_SUFFIXES:
        return _of_config(name, load_config(path, settings))
    ds = reading.look_into(where)
    if "direction" in ds.dims:
        raise ConfigError.of(name, "a ramp, up and down, and no map", f"`stickslip plot {name}` draws it")
    recipe = recipe_of(ds, name, settings)
    if not isinstance(recipe, Config):
        raise ConfigError.of(name, "cells that were computed one by one, and no map", "a map has axes: `stickslip run`")
    source = _of_config(name, recipe)
    if recipe.uncertain is not None or settings:  # its cells are draws, or those of another configuration
        return source
    return replace(source, computed=ds)


def _of_config(file: str, config: Config) -> Source:
    """The map behind a configuration; studies of it are left out."""
    if not config.has_cells:
        raise ConfigError.of(file, "got a test rig, whose cells have no regime", f"stickslip rig {file}")
    notes, medians = [], dict[str, float]()
    if (uncertain := config.uncertain) is not None:
        drawn = uncertain.values(np.zeros((1, len(uncertain.names))))
        medians = {name: float(drawn[name][0]) for name in uncertain.names}
        if config.study is not None and (seen := study_class(config.study.key).conditions(config.study)):
            along = {member.name for axis in config.axes for member in axis.members}  # which hold where both are given
            config = config.at(**{name: value for name, value in seen.items() if name not in along})
            medians = {name: value for name, value in medians.items() if name not in along}
        config = config.at(**medians)
        words = (f"{name} {quantity(value, QUANTITIES[name].units)}" for name, value in medians.items())
        notes.append(f"what is uncertain has its median here: {', '.join(words)}")
    if config.study is not None:
        notes.append(f"not shown here: what the section {config.study.key} asks for")
    return Source(file, config.plain_map(), tuple(notes), assumed=medians)


# --- the view ---------------------------------------------------------------------------------------------------------


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


def first_view(source: Source) -> View:
    """The view of a source that is just opened: its last two axes; with fewer, quantities people ask about."""
    names = [name for name, axis in source.axes.items() if axis.size > 1]
    also = [name for name in sides(source) if name not in names]
    chosen = [*(name for name in _ALSO if name in also), *also]
    y, x = [*chosen[: max(0, 2 - len(names))][::-1], *names][-2:]
    return View(y, x, {}, {})


def sides(source: Source) -> list[str]:
    """The possible sides of the map: the axes, and what has a slider with a range of its own."""
    axes = [name for name, axis in source.axes.items() if axis.size > 1]
    others = [slider.name for slider in sliders_of(source) if not isnan(slider.start) and not slider.rare]
    return [*axes, *(name for name in others if name not in axes)]


def with_plane(view: View, y: str, x: str) -> View:
    """The view over other sides; of what becomes a side the value is forgotten, and a side is no side of itself."""
    if y == x:
        y, x = (view.x, x) if x != view.x else (y, view.y)
    values = {name: value for name, value in view.values.items() if name not in (y, x)}
    points = {name: i for name, i in view.points.items() if name not in (y, x)}
    return replace(view, y=y, x=x, values=values, points=points)


# --- its configuration, its cells -------------------------------------------------------------------------------------


def config_of(source: Source, view: View, most: Sides = FULL) -> Config:
    """The configuration of a view, its axes of at most so many points. Raises ConfigError for what is not possible."""
    fixed = source.config.at(**_quantities(source, _chosen(source, view, {})))
    axes = tuple(_side(source, name, n) for name, n in zip(view.plane, most, strict=True))
    no_files = Output.model_construct(file=None, plot=None)
    config = fixed.without(*(name for name in view.plane if name in QUANTITIES))
    config = config.model_copy(update={"axes": axes, "output": no_files})
    if broken := [*broken_rules(config, {})]:
        plain: Any = config.resolved()
        got = [rule.got or reduce(getitem, rule.path, plain) for rule in broken]
        raise ConfigError("this view", [
            Problem(rule.path, f"got {value}, expected {rule.expected}", hint=rule.hint)
            for rule, value in zip(broken, got, strict=True)
        ])  # fmt: skip
    return config.shown_in(source.written_in)


def cell_of_view(source: Source, view: View, at: At) -> dict[str, float]:
    """The parameters of one cell of a view, in SI. Raises ConfigError for what is not possible."""
    quantities = source.fixed | _quantities(source, _chosen(source, view, at))
    cell = parameters_of({name: np.array([value]) for name, value in quantities.items()})
    try:
        cells = as_cells({name: values.item() for name, values in cell.items()}, source.options.law)
    except ValueError as error:
        raise ConfigError.of("this cell", str(error)) from None
    return {name: values.item() for name, values in cells.items()}


def settings(source: Source, view: View, at: At) -> list[str]:
    """One cell of a view as NAME=VALUE, as the command line takes it to the last bit: all that varies, and what was
    changed."""
    return [
        f"{name}={point_text(source.axes[name], int(value))}" if is_listed(source.axes.get(name))
        else f"{name}={QUANTITIES[name].setting(value)}"
        for name, value in _chosen(source, view, at).items()
    ]  # fmt: skip


def _chosen(source: Source, view: View, at: At) -> dict[str, float | int]:
    """By axis or quantity its value, or the position of its point: of all that varies, and of what was changed.

    at : of both sides; without it they are left out.
    """
    chosen: dict[str, float | int] = {
        name: view.points.get(name, 0) if is_listed(axis) else source.typical[name]
        for name, axis in source.axes.items()
    }
    chosen |= {**source.assumed, **view.values, **at}
    return {name: value for name, value in chosen.items() if name in at or name not in view.plane}


def _quantities(source: Source, chosen: At) -> dict[str, float]:
    """The values of what is chosen, of a point of listed values those of all that varies along them."""
    values: dict[str, float] = {}
    for name, value in chosen.items():
        if is_listed(source.axes.get(name)):
            values |= {member.name: float(member.points()[int(value)]) for member in source.axes[name].members}
        else:
            values[name] = float(value)
    return values


def _side(source: Source, name: str, most: int) -> Axis:
    """The axis along a side, of at most so many points."""
    axis = source.axes.get(name)
    if axis is None:
        slider = {slider.name: slider for slider in sliders_of(source)}[name]
        spacing, num = "log" if slider.is_log else "linear", min(_POINTS, most)
        return Range(name=name, spacing=spacing, start=slider.low, stop=slider.high, num=num)
    if isinstance(axis, Range):
        return axis.model_copy(update={"num": min(axis.num, most)})
    if axis.size > FULL[0]:
        message = f"{axis.size} listed points; at most {FULL[0]} fit on a side of the map"
        raise ConfigError.of(source.name, message, "give the axis start, stop and num", path=("axes", name))
    return axis


# --- listed axes ------------------------------------------------------------------------------------------------------


def is_listed(axis: Axis | None) -> bool:
    """True if it is an axis whose points lie side by side under their names, and not along a scale."""
    return axis is not None and not isinstance(axis, Range)


def labels_of(source: Source, axis: Axis) -> tuple[str, ...]:
    """The points of an axis in words."""
    if isinstance(axis, Group):
        return axis.labels or tuple(map(str, range(axis.size)))
    row, points = QUANTITIES[axis.name], axis.points()
    unit = unit_for(row.units, points, source.written_in.get(axis.name) if isinstance(axis, Range) else None)
    return tuple(str(row.written(value)) if isnan(value) else unit.text(value, _DIGITS) for value in points)


# --- sliders ----------------------------------------------------------------------------------------------------------


@dataclass(frozen=True)
class SliderRange:
    """A quantity of all cells of a view: its value, and the range of its slider, in SI.

    start : the value; NaN where the quantity is absent. otherwise : what a slider shows until it is switched on.
    is_log : whether ratios count. rare : whether it is seldom changed. written : the unit of the configuration.
    """

    name: str
    start: float
    low: float
    high: float
    is_log: bool
    otherwise: float
    rare: bool
    written: str | None = None

    @property
    def may_be_absent(self) -> bool:
        """True if it can be switched off."""
        return QUANTITIES[self.name].may_be_absent

    @property
    def unit(self) -> Unit:
        """The unit that suits the whole range: that of its middle."""
        centre = sqrt(self.low * self.high) if self.is_log else max(abs(self.low), abs(self.high)) / 2.0
        return unit_for(QUANTITIES[self.name].units, centre, self.written)

    def place(self, value: float) -> float:
        """The place of a value on the scale of the slider, in its unit."""
        return log10(value / self.unit.size) if self.is_log else float(self.unit.of(value))

    def value(self, place: float) -> float:
        """The value at such a place, to a few digits, as a person would write it."""
        return float(self.unit.to_si(_rounded(10.0**place if self.is_log else place)))


def sliders_of(source: Source, without: tuple[str, ...] = ()) -> Iterator[SliderRange]:
    """The sliders beside a map, those of people's everyday first. without : the sides of the map."""
    ranges = {name: axis for name, axis in source.axes.items() if isinstance(axis, Range)}
    names = [name for name in QUANTITIES if (name in source.fixed or name in ranges) and name not in without]
    law = source.config.friction.law
    names = [name for name in names if law in laws_with(name)]
    ends = _ends(source.typical, model_of(law))
    for name in sorted(names, key=lambda name: name in _RARE):
        value, written = source.typical[name], source.written_in.get(name)
        if axis := ranges.get(name):
            yield SliderRange(name, value, axis.start, axis.stop, axis.spacing == "log", value, False, written)
        else:
            yield SliderRange(name, value, *_range(name, value, ends.get(name)), name in _RARE, written)


def _range(name: str, value: float, ends: Ends | None) -> tuple[float, float, bool, float]:
    """Of the slider of a fixed quantity: its ends, whether ratios count, and what it shows until it is switched on."""
    if ends:
        low, high, otherwise = ends
        if isnan(value):
            return low, high, False, otherwise
        return min(low, value), max(high, 2.0 * value if value > high else high), False, value
    if (QUANTITIES[name].above == 0.0 or name == "belt_speed") and value > 0:
        return value / _FACTOR, value * _FACTOR, True, value
    high = min(_FACTOR / 2.0 * abs(value) or 1.0, inf if (most := QUANTITIES[name].at_most) is None else most)
    return min(QUANTITIES[name].at_least or 0.0, -high if value < 0 else value), high, False, value


def _ends(cell: Mapping[str, float], model: Model) -> dict[str, Ends]:
    """Ends of sliders that follow from other quantities, and what they show where the quantity is absent."""
    belt, start = abs(cell["belt_speed"]) or 1.0, _rounded(float(model.start_of(model.completed(cell)))) or 1.0
    shift = _rounded(2.0 * start * cell["normal_load"] / cell["stiffness"])
    friction = [name for name, row in {**model.parameters, **model.measured}.items() if row.plausible == FRICTION]
    absent = [name for name, row in model.parameters.items() if row.may_be_absent and row.units == "m s-1"]
    return {
        "damping": (0.0, _rounded(float(scales_of(cell).impedance)), 0.0),  # half of critical without friction
        "contact_time": (0.0, 1000.0, 0.0),
        "displacement": (-shift, shift, 0.0),
        "velocity": (_rounded(-2.0 * belt), _rounded(2.0 * belt), 0.0),
        **dict.fromkeys(friction, (0.0, _rounded(2.0 * start), start)),
        **dict.fromkeys(absent, (_rounded(0.1 * belt), _rounded(100.0 * belt), 10.0 * belt)),
    }


def _rounded(value: float) -> float:
    return float(f"{value:.{_DIGITS}g}")
