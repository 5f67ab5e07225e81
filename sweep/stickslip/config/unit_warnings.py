"""Values that are legal and implausible in SI: a unit was probably forgotten, or another one was meant.

A friction curve in mm/s read as one in m/s is no error: the map is computed, and shows no stick-slip anywhere. So
implausible values are asked about: numbers without a unit readily, a value with its unit only beyond what any contact
does. How large single values may be is in the tables of parameters (`Parameter.plausible`); `_RELATIONS` and `_machine`
hold what several come to together. Dimensionless studies, in which mass, stiffness and load are of order one, are not
questioned.
"""

from __future__ import annotations

import math
import sys
import warnings
from collections.abc import Callable, Collection, Iterator, Mapping
from contextlib import suppress
from dataclasses import dataclass
from functools import reduce
from itertools import product
from operator import add, getitem
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from stickslip.config.checks import varied_paths
from stickslip.config.model import Config
from stickslip.config.yaml import Document
from stickslip.errors import Problem, UnitWarning
from stickslip.vocabulary import units
from stickslip.vocabulary.cell_values import scales_of
from stickslip.vocabulary.display_units import LIKELY
from stickslip.vocabulary.models import BREAKAWAY, model_of, model_with
from stickslip.vocabulary.parameter import FRICTION
from stickslip.vocabulary.quantities import OSCILLATOR, QUANTITIES
from stickslip.vocabulary.scales import Scales

_FARTHEST = 1.0  # m, static deflection of a spring that holds a sliding contact
_FAR = 0.2  # m, the same in the middle of the grid, where the numbers had no unit ...
_NEAR = 0.01  # m, ... and in its stiffest cell
_FREQUENCIES = 0.1, 50e3  # Hz; a hanging garden gate, an ultrasonic motor
_HEAVY = 1000.0  # kg; from here on it may be a fault of the earth, whose springs are long and slow
_SLOW = 1.0  # m/s; up to here a belt may be any times faster than a4, since curves that fall at once are common
_IMPOSSIBLE = 5.0  # a friction coefficient from here on is a share in %, or a force; the limit in a study of ratios
_ORDER_ONE = 0.2, 5.0  # mass and load of a dimensionless study ...
_FRICTION_OF_RATIOS = 0.8  # ... and its friction coefficient, as in the article; few dry contacts have more
_FAR_OFF = 10.0  # times: as near a value that replaces another one is expected
_ENDS = 1e-6  # relative, of what is copied from a screen
_BARE_HINT = "numbers without a unit are in SI; write the unit, as in '20 mm/s' (`stickslip help units`)"
_WRITTEN_HINT = "it is computed as it is written (`stickslip help units`)"
_FRICTION = FRICTION[-1]


@dataclass(frozen=True)
class Span:
    """The smallest and the largest of some numbers; sums, products and quotients are those of spans above zero."""

    least: float
    most: float

    def __add__(self, other: Span) -> Span:
        return Span(self.least + other.least, self.most + other.most)

    def __mul__(self, other: Span) -> Span:
        return Span(self.least * other.least, self.most * other.most)

    def __truediv__(self, other: Span) -> Span:
        return Span(self.least / other.most, self.most / other.least)

    def scaled(self, factor: float) -> Span:
        """The numbers times a factor."""
        return Span(self.least * factor, self.most * factor)

    def text(self, unit: str = "", digits: int = 3) -> str:
        """`1 to 500 m/s`."""
        ends = dict.fromkeys(f"{end:.{digits}g}" for end in (self.least, self.most))
        return f"{' to '.join(ends)} {unit}".rstrip()


Spans = Mapping[str, Span]


def _by_scales(spans: Spans, value: Callable[[Scales], NDArray[np.float64]]) -> Span:
    """What follows from the scales of a cell, in the corners of the spans. Raises KeyError."""
    oscillator = dict.fromkeys(("mass", "stiffness", *(name for name in spans if name in OSCILLATOR)))
    corners = product(*((spans[name].least, spans[name].most) for name in oscillator))
    values = value(scales_of(dict(zip(oscillator, np.transpose([*corners]), strict=True))))
    return Span(float(values.min()), float(values.max()))


# What several quantities come to, by name. `friction` is that at break-away, `slope` and `decay` are of the curve.
_DERIVED: dict[str, Callable[[Spans], Span]] = {
    "natural frequency": lambda q: _by_scales(q, lambda by: by.natural_frequency),
    "static deflection": lambda q: q["friction"] * q["normal_load"] / q["stiffness"],
    "speeds": lambda q: q["belt_speed"] / q["decay"],
    "damping ratio": lambda q: q["damping"] / _by_scales(q, lambda by: by.critical_damping),
    "rise": lambda q: q["slope"] * q["belt_speed"],
}
# Of a number without a unit: what it comes to with others, from where on that is implausible, and why.
_RELATIONS = (
    # A belt so many times faster than the speed over which friction falls never reaches the drop, whatever the spring.
    ("belt_speed", "speeds", 30.0, ", {:.0f} times {decay}"),
    ("damping", "damping ratio", 10.0, ", {:.3g} times critical damping, under which nothing oscillates"),
    ("slope", "rise", _IMPOSSIBLE, ", which adds {:.3g} to the friction coefficient at the speed of the belt"),
)


class Doubt(NamedTuple):
    """An implausible value: as it was understood, in SI, why it is suspicious, and what was probably meant.

    written : the numbers without a unit, if there are some.
    """

    name: str
    value: str
    reason: str = ""
    meant: str | None = None
    written: str = ""

    @property
    def question(self) -> str:
        """The question to whoever wrote the value."""
        understood = f"{self.written} understood as {self.value}" if self.written else f"got {self.value}"
        return f"{understood}{self.reason}; " + (f"did you mean {self.meant}?" if self.meant else "is that meant?")


# --- questions --------------------------------------------------------------------------------------------------------


def warn_of_units(document: Document, config: Config) -> None:
    """Warn of the values in a document that are implausible in SI, at the line outside of this package."""
    if text := unit_question(document, config):
        _warn(text)


def unit_question(document: Document, config: Config) -> str | None:
    """The question about the values of a document, `config` being what was read from it; None if all are plausible."""
    data, bare = document.data, _bare_numbers(document.data)
    varied = {path[-1]: path for path in reversed(varied_paths(data.get("axes") or {}))}
    problems = []
    for doubt in _doubts(config, bare, bare.keys()):
        path = varied.get(doubt.name, (QUANTITIES[doubt.name].section, doubt.name))
        if path[0] == "axes" or doubt.name in (data.get(path[0]) or {}):  # a fitted curve has its own warning
            place = document.keys.get(path) or document.values.get(path)
            problems.append(Problem(path, doubt.question, place))
    if not problems:
        return None
    names = {problem.path[-1] for problem in problems}
    lines = [problem.text(document.name) for problem in sorted(problems, key=lambda problem: problem.place or (0, 0))]
    if not names & bare.keys():
        return "\n".join([*lines, f"  hint: {_WRITTEN_HINT}"])
    others = [f"{name} {numbers.text(_unit(name), 6)}" for name, numbers in bare.items() if name not in names]
    lines += [f"  also without a unit: {', '.join(others)}"] if others else []
    return "\n".join([*lines, f"  hint: {_BARE_HINT}"])


def warn_of_cell(source: str, given: Mapping[str, Any], recipe: Config | None, made: Config) -> None:
    """Warn of the numbers without a unit that pick a cell and are implausible, at the line outside of this package.

    source : the option that gave them. given : by quantity. recipe : what the cell was picked out of, `made` the cell.
    """
    spans = magnitudes(recipe) if recipe else {}
    plain: dict[str, Any] = {}
    lines = []
    for name, value in given.items():
        if name not in QUANTITIES or not isinstance(value, float):
            continue
        if recipe is not None and name in spans and (question := _against(recipe, spans[name], name, value)):
            lines.append(Problem((name,), question).text(source))
        else:
            plain.setdefault(QUANTITIES[name].section, {})[name] = value
    lines += [f"  hint: {_BARE_HINT}"] if lines else []
    if text := unit_question(Document(source, plain), made):
        lines.append(text)
    if lines:
        _warn("\n".join(lines))


def _against(recipe: Config, old: Span, name: str, value: float) -> str | None:
    """The question about a number that is no value of its axis, or far from the one it replaces, in SI."""
    if (unit := recipe.written_in.get(name)) is None:
        return None
    text = old.scaled(1.0 / units.factor(unit, QUANTITIES[name].units)).text(unit)
    is_fixed = name in recipe.fixed()
    low, high = (old.least / _FAR_OFF, old.most * _FAR_OFF) if is_fixed else (old.least, old.most)
    if (doubt := misread(value, low, high, name, unit)) is None:
        return None
    return f"{doubt[0]}, {f'where {text} is written' if is_fixed else f'outside of the axis {text}'}; {doubt[1]}"


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
    model = model_with(cells)
    start = model.static_of(cells)
    if not (start > _FRICTION).any():
        return None
    ones = sum((cells[name] == 1.0).astype(np.int8) for name in ("mass", "stiffness", "normal_load"))
    odd = start[(start > _FRICTION) & (ones < 2)]
    what = model.levels[0] if len(model.levels) == 1 else BREAKAWAY
    return _friction_question(float(odd.max()), what) if odd.size else None


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


# --- what a configuration comes to ------------------------------------------------------------------------------------


def magnitudes(config: Config) -> dict[str, Span]:
    """Magnitudes of the quantities, fixed or along axes, and of what follows from them (`_DERIVED`), by name.

    Words and uncertain quantities have none.
    """
    points = {member.name: member.points() for axis in config.axes for member in axis.members}
    points |= {name: np.array([value]) for name, value in config.fixed().items()}
    numbers = {name: np.abs(values[~np.isnan(values)]) for name, values in points.items()}
    spans = {name: Span(float(sizes.min()), float(sizes.max())) for name, sizes in numbers.items() if sizes.size}
    model = model_of(config.friction.law)
    spans |= {role: spans[name] for role, name in _roles(config).items() if name in spans}
    if BREAKAWAY in spans or all(name in spans for name in model.levels):
        spans["friction"] = spans.get(BREAKAWAY) or reduce(add, (spans[name] for name in model.levels))
    for name, formula in _DERIVED.items():
        with suppress(KeyError):  # a quantity that is not known
            spans[name] = formula(spans)
    return spans


def _roles(config: Config) -> dict[str, str]:
    """The names of the slope and the decay speed of the friction curve, if there is one."""
    curve = model_of(config.friction.law).curve
    return {"slope": curve.slope, "decay": curve.decay} if curve else {}


def _bare_numbers(data: Any) -> dict[str, Span]:
    """The numbers without a unit in the plain data of a configuration that is right; zero is zero in any unit."""
    sections = dict.fromkeys(row.section for row in QUANTITIES.values())
    given = {name: value for section in sections for name, value in (data.get(section) or {}).items()}
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


# --- doubts -----------------------------------------------------------------------------------------------------------


def _doubts(config: Config, bare: Spans, may_lack: Collection[str]) -> list[Doubt]:
    """The first doubt about each quantity that is implausible.

    bare : by quantity, the numbers that were written without a unit. may_lack : those of them whose unit may have been
    forgotten where several are implausible together.
    """
    spans, fixed = magnitudes(config), config.fixed()
    related = {name: numbers for name, numbers in bare.items() if name in may_lack}
    low, high = _ORDER_ONE
    of_ratios = sum(fixed.get(name) == 1.0 for name in ("mass", "stiffness", "normal_load")) >= 2 or (
        "friction" in spans and spans["friction"].most >= _FRICTION_OF_RATIOS
        and all(name in spans and low <= spans[name].least <= high for name in ("mass", "normal_load"))
    )  # fmt: skip
    doubts = [*_single_values(config, spans, bare, _IMPOSSIBLE if of_ratios else _FRICTION)]
    roles = _roles(config)
    for role, derived, limit, reason in _RELATIONS:
        name = roles.get(role, role)
        if name in related and derived in spans and (least := spans[derived].least) > limit:
            if name != "belt_speed" or spans[name].least > _SLOW:
                more = " and more" if name == "belt_speed" and spans[name].least < spans[name].most else ""
                doubts.append(_doubt(spans, related, name, reason.format(least, **roles) + more))
    if not of_ratios:
        doubts += _machine(spans, related)
    first: dict[str, Doubt] = {}
    for doubt in doubts:
        first.setdefault(doubt.name, doubt)
    return list(first.values())


def _single_values(config: Config, spans: Spans, bare: Spans, most_friction: float) -> Iterator[Doubt]:
    coefficients = False
    for name, row in QUANTITIES.items():
        if row.plausible is None or name not in spans:
            continue
        span, (most_bare, most) = spans[name], row.plausible
        if row.units == "1":
            if span.most > most_friction:
                share = f"{span.scaled(0.01).text()}, which is a share in %" if span.most > _IMPOSSIBLE else None
                yield Doubt(name, span.text(), ", a friction coefficient", share)
                coefficients = True
        elif name in bare and max(abs(bare[name].least), abs(bare[name].most)) > most_bare:
            yield _doubt(spans, bare, name)
        elif span.most > most:
            upto, largest = "up to " if span.least < span.most else "", f"{span.most:.3g}"
            yield Doubt(name, f"{upto}{largest} {_unit(name)}", "", f"{largest} {LIKELY[row.units]}")
    start, levels = spans.get("friction"), model_of(config.friction.law).levels
    if not coefficients and start is not None and start.most > most_friction:
        yield Doubt(levels[-1], f"{BREAKAWAY} = {' + '.join(levels)} = {start.text()}", ", a friction coefficient")


def _machine(spans: Spans, bare: Spans) -> Iterator[Doubt]:
    """Doubts about springs that are too long, and natural frequencies that no machine has; earthquakes have both."""
    if "mass" not in spans or spans["mass"].least > _HEAVY:
        return
    if deflection := spans.get("static deflection"):
        middle = math.sqrt(deflection.least * deflection.most)  # geometric, for grids over decades
        may_lack = "stiffness" in bare or "normal_load" in bare
        if deflection.least > _FARTHEST or (may_lack and middle > _FAR and deflection.least > _NEAR):
            load, far = spans["normal_load"].text("N"), deflection.text("m")
            yield _doubt(spans, bare, "stiffness", f": under {load} the belt drags the mass {far} far before it breaks "
                         "away")  # fmt: skip
    if frequency := spans.get("natural frequency"):
        lowest, highest = _FREQUENCIES  # of mass and stiffness the one without unit is asked about
        name = "mass" if "mass" in bare and "stiffness" not in bare else "stiffness"
        reason = f": the natural frequency is {frequency.text('Hz')}"
        if frequency.most < lowest:
            heavy = spans["mass"].least >= 10.0 and "mass" in bare
            yield _doubt(spans, bare, "mass" if heavy else name, reason)
        elif frequency.least > highest:
            yield _doubt(spans, bare, name, reason)._replace(meant=None)


def _doubt(spans: Spans, bare: Spans, name: str, reason: str = "") -> Doubt:
    """The doubt about a quantity, with the unit that was likely meant."""
    numbers, digits = (bare[name], 6) if name in bare else (spans[name], 3)
    likely = LIKELY.get(QUANTITIES[name].units)
    meant, written = likely and numbers.text(likely, digits), numbers.text("", digits) if name in bare else ""
    return Doubt(name, numbers.text(_unit(name), digits), reason, meant, written)


def _unit(name: str) -> str:
    return units.spelled(QUANTITIES[name].units)
