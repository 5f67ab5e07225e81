"""What can be changed of a cell besides the plane of the map, and how far."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, replace
from math import isnan, sqrt

import numpy as np

from stickslip.config.model import Axis, Group, Range, Values
from stickslip.explore.readable import Unit, unit_for
from stickslip.explore.subject import Subject
from stickslip.vocabulary.quantities import QUANTITIES

_FACTOR = 10.0  # how far a slider reaches either way where ratios count
_DIGITS = 4
_RARE = ("displacement", "velocity", "contact_time", "ageing_rate", "ageing_time", "delta")


@dataclass(frozen=True)
class Knob:
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
        """Whether it can be switched off."""
        return QUANTITIES[self.name].may_be_absent

    @property
    def unit(self) -> Unit:
        """The unit that suits the whole range: that of its middle."""
        middle = sqrt(self.low * self.high) if self.is_log else max(abs(self.low), abs(self.high)) / 2.0
        return unit_for(QUANTITIES[self.name].units, middle, self.written)

    def place(self, value: float) -> float:
        """Where on a scale from low to high, even in what counts, a value lies."""
        return float(np.log10(value)) if self.is_log else value

    def value(self, place: float) -> float:
        """The value at such a place, to a few digits, as a person would write it."""
        return rounded(10.0**place if self.is_log else place)


@dataclass(frozen=True)
class Picker:
    """An axis of listed points that is no side of the map: their names, and the one that is seen."""

    name: str
    labels: tuple[str, ...]


def rounded(value: float) -> float:
    """A value to a few digits."""
    return float(f"{value:.{_DIGITS}g}")


def is_listed(axis: Axis) -> bool:
    """Whether the points of an axis lie side by side under their names, and not along a scale."""
    return not isinstance(axis, Range)


def picker_of(axis: Values | Group) -> Picker:
    """The choice among the points of an axis."""
    if isinstance(axis, Group):
        return Picker(axis.name, axis.labels or tuple(map(str, range(axis.size))))
    row = QUANTITIES[axis.name]
    unit = unit_for(row.units, axis.points())
    return Picker(axis.name, tuple(str(row.written(v)) if isnan(v) else unit.text(v) for v in axis.values))


def labels_of(subject: Subject, axis: Axis) -> tuple[str, ...]:
    """The points of an axis in words."""
    if not isinstance(axis, Range):
        return picker_of(axis).labels
    unit = unit_for(QUANTITIES[axis.name].units, axis.points(), subject.written_in.get(axis.name))
    return tuple(map(unit.text, axis.points()))


def knobs_of(subject: Subject, plane: tuple[str, str]) -> Iterator[Knob]:
    """The sliders beside a map over two axes or quantities: those of people's everyday first."""
    for knob in _knobs(subject, plane):
        yield replace(knob, written=subject.written_in.get(knob.name))


def _knobs(subject: Subject, plane: tuple[str, str]) -> Iterator[Knob]:
    """The same, in customary units."""
    typical = typical_cell(subject)
    ranges = [axis for axis in subject.axes.values() if isinstance(axis, Range)]
    along = {axis.name: axis for axis in ranges if axis.name not in plane}
    names = [name for name in QUANTITIES if name in subject.fixed or name in along]
    law = subject.config.friction.law
    wanted = [name for name in names if name not in plane and (name != "delta" or law == "stribeck_delta")]
    for name in sorted(wanted, key=lambda name: name in _RARE):
        rare = name in _RARE and name not in along
        if name in along:
            axis = along[name]
            yield Knob(name, middle(axis), axis.start, axis.stop, axis.spacing == "log", middle(axis), rare)
        else:
            yield _knob(name, subject.fixed[name], typical, rare)


def _knob(name: str, value: float, typical: Mapping[str, float], rare: bool) -> Knob:
    """The slider of a quantity that is fixed."""
    if name in _BETWEEN:
        low, high, otherwise = _BETWEEN[name](typical)
        if not isnan(value):
            low, high = min(low, value), max(high, 2.0 * value if value > high else high)
        return Knob(name, value, low, high, False, value if not isnan(value) else otherwise, rare)
    if _counts_by_ratio(name) and value > 0:
        return Knob(name, value, value / _FACTOR, value * _FACTOR, True, value, rare)
    high = _FACTOR / 2.0 * abs(value) or 1.0
    return Knob(name, value, min(0.0, -high if value < 0 else 0.0), high, False, value, rare)


def _counts_by_ratio(name: str) -> bool:
    row = QUANTITIES[name]
    return row.above == 0.0 or name == "belt_speed"


def typical_cell(subject: Subject) -> dict[str, float]:
    """A cell in the middle of the configuration, as it is given."""
    found = dict(subject.fixed)
    for axis in subject.axes.values():
        found |= {member.name: middle(member) for member in axis.members}
    if "mu_start" not in found:
        found["mu_start"] = found["a1"] + found["a3"]
    return found


def middle(axis: Range | Values) -> float:
    """The point in the middle of an axis; of a list with words, a number."""
    points = axis.points()
    numbers = points[~np.isnan(points)]
    return float(numbers[len(numbers) // 2]) if numbers.size else float("nan")


Ends = tuple[float, float, float]  # of a slider, and what it shows where the quantity is absent


def _damping(cell: Mapping[str, float]) -> Ends:
    """Up to half of what would be critical without friction."""
    return 0.0, rounded(sqrt(cell["stiffness"] * cell["mass"])), 0.0


def _mu_stop(cell: Mapping[str, float]) -> Ends:
    return 0.0, cell["mu_start"], rounded(0.8 * cell["mu_start"])


def _mu_static(cell: Mapping[str, float]) -> Ends:
    return cell["mu_start"], rounded(2.0 * cell["mu_start"]), rounded(1.1 * cell["mu_start"])


def _slope(cell: Mapping[str, float]) -> Ends:
    """Up to what doubles friction at the speed of the belt."""
    most = 3.0 * abs(cell.get("a2", 0.0))
    return 0.0, rounded(most or cell["mu_start"] / max(abs(cell["belt_speed"]), 1e-3)), 0.0


def _friction(cell: Mapping[str, float]) -> Ends:
    return 0.0, rounded(2.0 * cell["mu_start"]), 0.0


def _displacement(cell: Mapping[str, float]) -> Ends:
    most = rounded(2.0 * cell["mu_start"] * cell["normal_load"] / cell["stiffness"])
    return -most, most, 0.0


def _velocity(cell: Mapping[str, float]) -> Ends:
    most = rounded(2.0 * abs(cell["belt_speed"])) or 1.0
    return -most, most, 0.0


_BETWEEN: dict[str, Callable[[Mapping[str, float]], Ends]] = {
    "damping": _damping,
    "a1": _friction,
    "a2": _slope,
    "a3": _friction,
    "mu_start": _friction,
    "mu_reversal": lambda cell: (0.0, cell["mu_start"], 0.0),
    "mu_stop": _mu_stop,
    "mu_static": _mu_static,
    "ageing_rate": lambda cell: (0.0, rounded(0.1 * cell["mu_start"]), 0.0),
    "contact_time": lambda _: (0.0, 1000.0, 0.0),
    "displacement": _displacement,
    "velocity": _velocity,
    "delta": lambda _: (1.0, 4.0, 1.0),
}
