"""Values that are legal and implausible in SI: a unit was probably forgotten, or another one was meant.

A friction curve in mm/s read as one in m/s is no error: the map is computed, and shows no stick-slip anywhere. So
implausible values are asked about: numbers without a unit readily, a value with its unit only beyond what any contact
does. How large single values may be is in the tables of parameters (`Parameter.plausible`); `_RELATIONS` holds what
several come to together. Dimensionless studies, in which mass, stiffness and load are of order one, are not questioned.
"""

from __future__ import annotations

import math
import sys
import warnings
from collections.abc import Collection, Iterator, Mapping
from functools import reduce
from operator import getitem
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from stickslip.config.checks import varied_paths
from stickslip.config.model import Config
from stickslip.config.yaml import Document
from stickslip.errors import Path, Problem, UnitWarning
from stickslip.vocabulary import units
from stickslip.vocabulary.display_units import LIKELY
from stickslip.vocabulary.models import BREAKAWAY, model_of, model_with
from stickslip.vocabulary.parameter import FRICTION
from stickslip.vocabulary.quantities import QUANTITIES

_FARTHEST = 1.0  # m, static deflection of a spring that holds a sliding contact
_FAR = 0.2  # m, the same in the middle of the grid, where the numbers had no unit ...
_NEAR = 0.01  # m, ... and in its stiffest cell
_FREQUENCIES = 0.1, 50e3  # Hz; a hanging garden gate, an ultrasonic motor
_HEAVY = 1000.0  # kg; from here on it may be a fault of the earth, whose springs are long and slow
# A belt this many times faster than the speed over which friction falls never reaches the drop, whatever the spring.
_FASTER = 30.0
_SLOW = 1.0  # m/s; up to here any ratio may be meant, since curves that fall at once are common
_OVERDAMPED = 10.0  # of critical damping
_IMPOSSIBLE = 5.0  # a friction coefficient from here on is a share in %, or a force; the limit in a study of ratios
_ORDER_ONE = 0.2, 5.0  # mass and load of a dimensionless study ...
_FRICTION_OF_RATIOS = 0.8  # ... and its friction coefficient, as in the article; few dry contacts have more
_FAR_OFF = 10.0  # times: as near a value that replaces another one is expected
_ENDS = 1e-6  # relative, of what is copied from a screen
_BARE_HINT = "numbers without a unit are in SI; write the unit, as in '20 mm/s' (`stickslip help units`)"
_WRITTEN_HINT = "it is computed as it is written (`stickslip help units`)"
_FRICTION = FRICTION[-1]


class Span(NamedTuple):
    """The smallest and the largest number of something over the grid."""

    least: float
    most: float

    def text(self, unit: str = "", digits: int = 3) -> str:
        """`1 to 500 m/s`."""
        ends = dict.fromkeys(f"{end:.{digits}g}" for end in self)
        return f"{' to '.join(ends)} {unit}".rstrip()


Bare = Mapping[str, Span]  # by quantity, the smallest and the largest of the numbers that were written without a unit


class Doubt(NamedTuple):
    """An implausible value: as it was understood, in SI, why it is suspicious, and what was probably meant."""

    name: str
    value: str
    reason: str = ""
    meant: str | None = None
    written: str = ""  # the numbers without a unit

    @property
    def question(self) -> str:
        """The question to whoever wrote the value."""
        understood = f"{self.written} understood as {self.value}" if self.written else f"got {self.value}"
        return f"{understood}{self.reason}" + (f"; did you mean {self.meant}?" if self.meant else "; is that meant?")


# --- questions --------------------------------------------------------------------------------------------------------


def warn_of_units(document: Document, config: Config) -> None:
    """Warn of the values in a document that are implausible in SI, at the line outside of this package."""
    if text := unit_question(document, config):
        _warn(text)


def unit_question(document: Document, config: Config) -> str | None:
    """The question about the values of a document, `config` being what was read from it; None if all are plausible."""
    data, bare = document.data, _bare_numbers(document.data)
    problems = []
    for doubt in _doubts(config, bare, bare.keys()):
        path = _path(data, doubt.name)
        if path[0] == "axes" or doubt.name in (data.get(path[0]) or {}):  # a fitted curve has its own warning
            place = document.keys.get(path) or document.values.get(path)
            problems.append(Problem(path, doubt.question, place))
    if not problems:
        return None
    asked = {str(problem.path[-1]) for problem in problems}
    lines = [problem.text(document.name) for problem in sorted(problems, key=lambda problem: problem.place or (0, 0))]
    if not asked & bare.keys():
        return "\n".join([*lines, f"  hint: {_WRITTEN_HINT}"])
    others = [f"{name} {numbers.text(_unit(name), 6)}" for name, numbers in bare.items() if name not in asked]
    lines += [f"  also without a unit: {', '.join(others)}"] if others else []
    return "\n".join([*lines, f"  hint: {_BARE_HINT}"])


def warn_of_cell(source: str, given: Mapping[str, Any], recipe: Config | None, made: Config) -> None:
    """Warn of the numbers without a unit that pick a cell and are implausible, at the line outside of this package.

    source : the option that gave them. given : by quantity. recipe : what the cell was picked out of, `made` the cell.
    """
    plain: dict[str, Any] = {}
    lines = []
    for name, value in given.items():
        if name not in QUANTITIES or not isinstance(value, float):
            continue
        if recipe is not None and (question := _against(recipe, name, value)):
            lines.append(Problem((name,), question).text(source))
        else:
            plain.setdefault(QUANTITIES[name].section, {})[name] = value
    lines += [f"  hint: {_BARE_HINT}"] if lines else []
    if text := unit_question(Document(source, plain), made):
        lines.append(text)
    if lines:
        _warn("\n".join(lines))


def misread(value: float, least: float, most: float, name: str, unit: str | None) -> tuple[str, str] | None:
    """The number as read in SI, and as likely meant, if it lies in a range (in SI) only when it has `unit`."""
    declared = QUANTITIES[name].units if name in QUANTITIES else "1"
    if unit is None or declared == "1" or not value or least <= abs(value) <= most:
        return None
    if not least * (1.0 - _ENDS) <= abs(value) * units.factor(unit, declared) <= most * (1.0 + _ENDS):
        return None
    return f"{value:g} is read as {value:g} {units.spelled(declared)}", f"did you mean {value:g} {unit}?"


def one_regime_question(config: Config, regime: str) -> str | None:
    """The question about a map whose cells all have the same regime; None if every value is plausible."""
    doubts = _doubts(config, _bare_numbers(config.resolved()), config.fixed().keys())
    values = [f"{doubt.name} {doubt.value}{doubt.reason}" for doubt in doubts]
    return f"every cell is {regime}; is that what was wanted, with {', '.join(values)}?" if values else None


def friction_question_of_cells(cells: Mapping[str, NDArray[np.float64]]) -> str | None:
    """The question about the largest friction coefficient at break-away among cells, if no contact has it.

    Cells of ratios, of which two of mass, stiffness and load are 1, are not questioned.
    """
    start = model_with(cells).static_of(cells)
    if not (start > _FRICTION).any():
        return None
    ones = sum((cells[name] == 1.0).astype(np.int8) for name in ("mass", "stiffness", "normal_load"))
    odd = start[(start > _FRICTION) & (ones < 2)]
    return _friction_question(float(odd.max()), BREAKAWAY) if odd.size else None


def friction_question_of_fit(breakaway: float, measured: ArrayLike | None) -> str | None:
    """The question about a fitted curve whose friction is implausible, at its points or at break-away."""
    most = 0.0 if measured is None else float(np.max(measured))
    if most > _FRICTION:
        return _friction_question(most, "measured friction")
    follows = " It follows from the fit, not from a point."
    return f"{_friction_question(breakaway, BREAKAWAY)}{follows}" if breakaway > _FRICTION else None


def _friction_question(value: float, what: str) -> str:
    share = f"is that {value / 100:.3g}, which is a share in %?" if value > _IMPOSSIBLE else "is that meant?"
    return f"{what} = {value:.3g} is more than the friction coefficient of most contacts ({_FRICTION:g}); {share}"


def _warn(text: str) -> None:
    frame, depth = sys._getframe(1), 2  # of `warnings.warn`, which counts this function
    while frame.f_back is not None and frame.f_globals.get("__name__", "").startswith("stickslip."):
        frame, depth = frame.f_back, depth + 1
    warnings.warn(text, UnitWarning, stacklevel=depth)


def _against(recipe: Config, name: str, value: float) -> str | None:
    """The question about a number that is no value of its axis, or far from the one it replaces, in SI."""
    old, unit = span(recipe, name), recipe.written_in.get(name)
    if old is None or unit is None:
        return None
    text = Span(*(end / units.factor(unit, QUANTITIES[name].units) for end in old)).text(unit)
    is_fixed = name in recipe.fixed()
    low, high = (old.least / _FAR_OFF, old.most * _FAR_OFF) if is_fixed else old
    if (doubt := misread(value, low, high, name, unit)) is None:
        return None
    return f"{doubt[0]}, {f'where {text} is written' if is_fixed else f'outside of the axis {text}'}; {doubt[1]}"


# --- numbers without a unit -------------------------------------------------------------------------------------------


def _bare_numbers(data: Any) -> Bare:
    """The numbers without a unit in the plain data of a configuration that is right; zero is zero in any unit."""
    given = {
        name: value
        for section in dict.fromkeys(quantity.section for quantity in QUANTITIES.values())
        for name, value in (data.get(section) or {}).items()
    }
    given |= {str(path[-1]): reduce(getitem, path, data) for path in varied_paths(data.get("axes") or {})}
    bare = {}
    for name, value in given.items():
        if isinstance(value, dict):
            value = value["values"] if "values" in value else [value.get("start"), value.get("stop")]
        parts = value if isinstance(value, list) else [value]
        numbers = [float(part) for part in parts if isinstance(part, int | float) and part]
        if numbers and name in QUANTITIES and QUANTITIES[name].units != "1":
            bare[name] = Span(min(numbers), max(numbers))
    return bare


def _path(data: Any, name: str) -> Path:
    """The position at which a quantity is given."""
    varied = [path for path in varied_paths(data.get("axes") or {}) if path[-1] == name]
    return varied[0] if varied else (QUANTITIES[name].section, name)


# --- what a configuration comes to ------------------------------------------------------------------------------------


def span(config: Config, name: str) -> Span | None:
    """Magnitudes of a quantity, fixed or along an axis; None if it is not given, or uncertain, or a word."""
    fixed = config.fixed().get(name)
    axes = [m.points() for axis in config.axes for m in axis.members if m.name == name]
    points = np.abs(axes[0] if fixed is None and axes else np.array([np.nan if fixed is None else fixed]))
    numbers = points[~np.isnan(points)]
    return Span(float(numbers.min()), float(numbers.max())) if numbers.size else None


def _spans(config: Config, *names: str) -> list[Span] | None:
    """The magnitudes of several quantities; None unless all have some."""
    spans = [found for name in names if (found := span(config, name)) is not None]
    return spans if len(spans) == len(names) else None


def natural_frequency(config: Config) -> Span | None:
    """sqrt(k/m)/(2 pi), Hz."""
    if (spans := _spans(config, "stiffness", "mass")) is None:
        return None
    return Span(*(math.sqrt(k / m) / (2.0 * math.pi) for k, m in zip(spans[0], reversed(spans[1]), strict=True)))


def static_deflection(config: Config) -> Span | None:
    """Friction at break-away N/k, m: how far the belt drags the mass before it breaks away."""
    spans, start = _spans(config, "normal_load", "stiffness"), _start(config)
    if spans is None or start is None:
        return None
    load, stiffness = spans
    return Span(start.least * load.least / stiffness.most, start.most * load.most / stiffness.least)


def _start(config: Config) -> Span | None:
    """Friction at break-away, by either form of the curve."""
    if (start := span(config, BREAKAWAY)) is not None:
        return start
    spans = _spans(config, *model_of(config.friction.law).levels)
    return Span(*(sum(ends) for ends in zip(*spans, strict=True))) if spans else None


def _is_of_ratios(config: Config) -> bool:
    """True for a study of ratios: two of mass, stiffness and load are 1, or all is of order one."""
    fixed = config.fixed()
    if sum(fixed.get(name) == 1.0 for name in ("mass", "stiffness", "normal_load")) >= 2:
        return True
    start, spans, (low, high) = _start(config), _spans(config, "mass", "normal_load"), _ORDER_ONE
    of_order_one = spans is not None and all(low <= one.least <= high for one in spans)
    return of_order_one and start is not None and start.most >= _FRICTION_OF_RATIOS


# --- doubts -----------------------------------------------------------------------------------------------------------


def _doubts(config: Config, bare: Bare, may_lack: Collection[str]) -> list[Doubt]:
    """The first doubt about each quantity that is implausible.

    may_lack : those of `bare` whose unit may have been forgotten where several are implausible together.
    """
    of_ratios = _is_of_ratios(config)
    related = {name: numbers for name, numbers in bare.items() if name in may_lack}
    relations = _RELATIONS if of_ratios else (*_RELATIONS, *_OF_MACHINES)
    doubts = [*_single_values(config, bare, _IMPOSSIBLE if of_ratios else _FRICTION),
              *(doubt for relation in relations for doubt in relation(config, related))]  # fmt: skip
    return list({doubt.name: doubt for doubt in reversed(doubts)}.values())[::-1]


def _single_values(config: Config, bare: Bare, most_friction: float) -> Iterator[Doubt]:
    coefficients = False
    for name, row in QUANTITIES.items():
        magnitudes, numbers = span(config, name), bare.get(name)
        if row.plausible is None:
            continue
        if row.units == "1":
            if magnitudes is not None and magnitudes.most > most_friction:
                share = Span(magnitudes.least / 100.0, magnitudes.most / 100.0).text()
                meant = f"{share}, which is a share in %" if magnitudes.most > _IMPOSSIBLE else None
                yield Doubt(name, magnitudes.text(), ", a friction coefficient", meant)
                coefficients = True
        elif numbers is not None and max(map(abs, numbers)) > row.plausible[0]:
            yield _doubt(config, bare, name)
        elif magnitudes is not None and magnitudes.most > row.plausible[1]:
            upto, most = "up to " if magnitudes.least < magnitudes.most else "", f"{magnitudes.most:.3g}"
            yield Doubt(name, f"{upto}{most} {_unit(name)}", "", f"{most} {LIKELY[row.units]}")
    start = _start(config)
    if not coefficients and start is not None and start.most > most_friction:
        levels = model_of(config.friction.law).levels
        yield Doubt(levels[-1], f"{BREAKAWAY} = {' + '.join(levels)} = {start.text()}", ", a friction coefficient")


def _fast_belt(config: Config, bare: Bare) -> Iterator[Doubt]:
    curve = model_of(config.friction.law).curve
    spans = _spans(config, "belt_speed", curve.decay) if curve else None
    if (
        curve
        and spans is not None
        and "belt_speed" in bare
        and (belt := spans[0]).least > max(_SLOW, _FASTER * spans[1].most)
    ):
        more = " and more" if belt.most > belt.least else ""
        yield _doubt(config, bare, "belt_speed", f", {belt.least / spans[1].most:.0f} times {curve.decay}{more}")


def _overdamped(config: Config, bare: Bare) -> Iterator[Doubt]:
    spans = _spans(config, "damping", "stiffness", "mass")
    if spans is None or "damping" not in bare:
        return
    damping, stiffness, mass = spans
    ratio = damping.least / (2.0 * math.sqrt(stiffness.most * mass.most))
    if ratio > _OVERDAMPED:
        reason = f", {ratio:.3g} times critical damping, under which nothing oscillates"
        yield _doubt(config, bare, "damping", reason)


def _steep_slope(config: Config, bare: Bare) -> Iterator[Doubt]:
    curve = model_of(config.friction.law).curve
    spans = _spans(config, curve.slope, "belt_speed") if curve else None
    if curve and spans is not None and curve.slope in bare and (adds := spans[0].least * spans[1].least) > _IMPOSSIBLE:
        reason = f", which adds {adds:.3g} to the friction coefficient at the speed of the belt"
        yield _doubt(config, bare, curve.slope, reason)


def _long_spring(config: Config, bare: Bare) -> Iterator[Doubt]:
    deflection, spans = static_deflection(config), _spans(config, "mass", "normal_load")
    if deflection is None or spans is None or spans[0].least > _HEAVY:
        return
    middle = math.sqrt(deflection.least * deflection.most)  # geometric, for grids over decades
    may_lack = "stiffness" in bare or "normal_load" in bare
    if deflection.least > _FARTHEST or (may_lack and middle > _FAR and deflection.least > _NEAR):
        load, far = spans[1].text("N"), deflection.text("m")
        reason = f": under {load} the belt drags the mass {far} far before it breaks away"
        yield _doubt(config, bare, "stiffness", reason)


def _odd_frequency(config: Config, bare: Bare) -> Iterator[Doubt]:
    """A natural frequency that no machine has; of mass and stiffness the one without unit is asked about."""
    frequency, mass = natural_frequency(config), span(config, "mass")
    if frequency is None or mass is None or mass.least > _HEAVY:
        return
    lowest, highest = _FREQUENCIES
    name = "mass" if "mass" in bare and "stiffness" not in bare else "stiffness"
    reason = f": the natural frequency is {frequency.text('Hz')}"
    if frequency.most < lowest:
        heavy = mass.least >= 10.0 and "mass" in bare
        yield _doubt(config, bare, "mass" if heavy else name, reason)
    elif frequency.least > highest:
        yield _doubt(config, bare, name, reason)._replace(meant=None)


_RELATIONS = (_fast_belt, _overdamped, _steep_slope)
_OF_MACHINES = (_long_spring, _odd_frequency)  # which studies of ratios are not asked about


def _doubt(config: Config, bare: Bare, name: str, reason: str = "") -> Doubt:
    """The doubt about a quantity, with the unit that was likely meant."""
    numbers, digits = (bare[name], 6) if name in bare else (span(config, name), 3)
    assert numbers is not None
    likely = LIKELY.get(QUANTITIES[name].units)
    meant, written = likely and numbers.text(likely, digits), numbers.text("", digits) if name in bare else ""
    return Doubt(name, numbers.text(_unit(name), digits), reason, meant, written)


def _unit(name: str) -> str:
    return units.spelled(QUANTITIES[name].units)
