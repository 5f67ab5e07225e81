"""Values that are legal and implausible in SI: a unit was probably forgotten, or another one was meant.

A friction curve in mm/s read as one in m/s is no error: the map is computed, and shows no stick-slip anywhere. So
implausible values are asked about: numbers without a unit readily, a value with its unit only beyond what any contact
does. Dimensionless studies, in which mass, stiffness and load are of order one, are not questioned.
"""

from __future__ import annotations

import math
import sys
import warnings
from collections.abc import Iterator, Mapping
from functools import reduce
from operator import getitem
from typing import Any, NamedTuple

from stickslip.config.kinds import varied_paths
from stickslip.config.model import Config
from stickslip.config.plausible import Doubt, Span, doubts, span
from stickslip.config.yaml import Document
from stickslip.errors import Path, Problem, UnitWarning
from stickslip.vocabulary import units
from stickslip.vocabulary.quantities import QUANTITIES

# The largest magnitudes, in SI, that are taken as given. Sliding contacts reach 30 m/s in brakes; friction falls
# within millimetres per second, and within a metre per second at most; oscillators that stick and slip weigh up to a
# machine table, and their specimens and strokes are shorter than a metre.
_LARGEST = {
    "mass": 50.0, "belt_speed": 30.0, "velocity": 30.0, "a4": 1.0, "v_reversal": 1.0, "displacement": 10.0,
    "stroke": 1.0,
}  # fmt: skip
_SMALLER = {"kg": "g", "m": "mm", "m s-1": "mm/s"}  # what people write, by what is read
_FAR_OFF = 10.0  # times: as near a value that replaces another one is expected
_ENDS = 1e-6  # relative, of what is copied from a screen
_CLOSING = "numbers without a unit are in SI; write the unit, as in '20 mm/s' (`stickslip help units`)"
_CLOSING_WRITTEN = "it is computed as it is written (`stickslip help units`)"


class _Bare(NamedTuple):
    """The numbers that were written without a unit for one quantity: where, the smallest and the largest."""

    name: str
    path: Path
    least: float
    most: float

    def text(self, unit: str | None = None) -> str:
        """`1 to 500 m/s`."""
        ends = dict.fromkeys((f"{self.least:g}", f"{self.most:g}"))
        return f"{' to '.join(ends)} {unit or ''}".rstrip()

    @property
    def is_large(self) -> bool:
        """Whether one of them is larger than what is taken as given."""
        return max(abs(self.least), abs(self.most)) > _LARGEST.get(self.name, math.inf)


def ask(document: Document, config: Config) -> None:
    """Warn of the values in a document that are implausible in SI, at the line outside of this package."""
    if asked := question(document, config):
        warnings.warn(asked, UnitWarning, stacklevel=_frames_of_ours() + 1)


def _frames_of_ours() -> int:
    """How many calls lead from the code of somebody else to the caller of this function, that included."""
    frame, count = sys._getframe(1), 0
    while frame.f_back is not None and frame.f_globals.get("__name__", "").startswith("stickslip."):
        frame, count = frame.f_back, count + 1
    return count


def question(document: Document, config: Config) -> str | None:
    """What to ask about the values of a document, `config` being what was read from it; None if all are plausible."""
    bare = list(_bare(document.data))
    asked = {found.name: _understood(found) for found in bare if found.is_large}
    by_name = {found.name: found for found in bare}
    for doubt in doubts(config, by_name.keys()):
        if doubt.name not in asked and _is_given(document.data, doubt.name):  # a fitted curve has its own warning
            found = by_name.get(doubt.name) if doubt.reason else None  # else it is what has a unit that is too large
            asked[doubt.name] = _doubted(doubt, found)
    if not asked:
        return None
    problems = sorted((_problem(document, name, text) for name, text in asked.items()), key=lambda p: p.place or (0, 0))
    lines = [problem.text(document.name) for problem in problems]
    others = [f"{b.name} {b.text(units.spelled(QUANTITIES[b.name].units))}" for b in bare if b.name not in asked]
    if not by_name.keys() & asked.keys():
        return "\n".join([*lines, f"  hint: {_CLOSING_WRITTEN}"])
    if others:
        lines.append(f"  also without a unit: {', '.join(others)}")
    return "\n".join([*lines, f"  hint: {_CLOSING}"])


def ask_of_settings(source: str, given: Mapping[str, Any], recipe: Config | None, made: Config) -> None:
    """Warn whoever called the caller of the caller of the numbers without a unit that pick a cell and are implausible.

    source : the option that gave them. given : by quantity. recipe : what the cell was picked out of, `made` the cell.
    """
    bare = {name: value for name, value in given.items() if name in QUANTITIES and isinstance(value, float)}
    plain: dict[str, Any] = {}
    asked = []
    for name, value in bare.items():
        if recipe is not None and (doubt := _against(recipe, name, value)):
            asked.append(Problem((name,), doubt).text(source))
        else:
            plain.setdefault(QUANTITIES[name].section, {})[name] = value
    lines = [f"{line}\n  hint: {_CLOSING}" for line in ["\n".join(asked)] if line]
    if other := question(Document(source, plain), made):
        lines.append(other)
    if lines:
        warnings.warn("\n".join(lines), UnitWarning, stacklevel=4)


def _against(recipe: Config, name: str, value: float) -> str | None:
    """What is asked about a number that is no value of its axis, or far from the one it replaces, in SI."""
    found, unit = span(recipe, name), recipe.written_in.get(name)
    if found is None or unit is None:
        return None
    told = Span(*(end / units.factor(unit, QUANTITIES[name].units) for end in found)).text(unit)
    if name in recipe.fixed():
        doubt = misread(value, found.least / _FAR_OFF, found.most * _FAR_OFF, name, unit)
        return doubt and f"{doubt[0]}, where {told} is written; {doubt[1]}"
    doubt = misread(value, found.least, found.most, name, unit)
    return doubt and f"{doubt[0]}, outside of the axis {told}; {doubt[1]}"


def misread(value: float, least: float, most: float, name: str, unit: str | None) -> tuple[str, str] | None:
    """How a number is read in SI, and what was likely meant, if it lies in a range (in SI) only when it has `unit`."""
    declared = QUANTITIES[name].units if name in QUANTITIES else "1"
    if unit is None or declared == "1" or not value or least <= abs(value) <= most:
        return None
    if not least * (1.0 - _ENDS) <= abs(value) * units.factor(unit, declared) <= most * (1.0 + _ENDS):
        return None
    return f"{value:g} is read as {value:g} {units.spelled(declared)}", f"did you mean {value:g} {unit}?"


def remark(config: Config, regime: str) -> str | None:
    """What to say of a map whose cells all have the same regime, if something about it is implausible."""
    document = Document("", config.resolved())
    large = [found for found in _bare(document.data) if found.is_large]
    said = [f"{found.name} {found.text(units.spelled(QUANTITIES[found.name].units))}" for found in large]
    names = [found.name for found in large]
    said += [f"{doubt.name} {doubt.value}{doubt.reason}" for doubt in doubts(config, config.fixed().keys())
             if doubt.name not in names]  # fmt: skip
    if not said:
        return None
    return f"every cell is {regime}; is that what was wanted, with {', '.join(said)}?"


def _understood(found: _Bare) -> str:
    """What is asked about numbers that are too large by themselves."""
    declared = QUANTITIES[found.name].units
    understood = f"{found.text()} understood as {found.text(units.spelled(declared))}"
    return f"{understood}; did you mean {found.text(_SMALLER[declared])}?"


def _doubted(doubt: Doubt, bare: _Bare | None) -> str:
    """What is asked about values that are implausible together, or although they have units."""
    if bare is None:
        understood = f"got {doubt.value}"
    else:
        understood = f"{bare.text()} understood as {bare.text(units.spelled(QUANTITIES[bare.name].units))}"
    meant = doubt.meant
    if bare is not None and meant is not None and doubt.unit is not None:
        meant = bare.text(doubt.unit)
    return f"{understood}{doubt.reason}" + (f"; did you mean {meant}?" if meant else "; is that meant?")


def _problem(document: Document, name: str, text: str) -> Problem:
    """The question, where the quantity is given."""
    path = _path(document.data, name)
    return Problem(path, text, document.keys.get(path) or document.values.get(path))


def _is_given(data: Any, name: str) -> bool:
    """Whether a quantity is in the document."""
    path = _path(data, name)
    return path[0] == "axes" or name in (data.get(path[0]) or {})


def _path(data: Any, name: str) -> Path:
    """Where a quantity is given."""
    axes = data.get("axes") or {}
    varied = [path for path in varied_paths(axes) if path[-1] == name]
    return varied[0] if varied else (QUANTITIES[name].section, name)


def _bare(data: Any) -> Iterator[_Bare]:
    """What is given without a unit in the plain data of a configuration that is right."""
    for section in dict.fromkeys(quantity.section for quantity in QUANTITIES.values()):
        for name, value in (data.get(section) or {}).items():
            if name in QUANTITIES:
                yield from _of_quantity(name, (section, name), value)
    axes = data.get("axes") or {}
    for path in varied_paths(axes):
        yield from _of_quantity(str(path[-1]), path, reduce(getitem, path, data))


def _of_quantity(name: str, path: Path, value: Any) -> Iterator[_Bare]:
    """The numbers without unit among a value, a list, or the ends of a range; zero is zero in any unit."""
    if isinstance(value, dict):
        value = value["values"] if "values" in value else [value.get("start"), value.get("stop")]
    numbers = [float(v) for v in (value if isinstance(value, list) else [value]) if isinstance(v, int | float) and v]
    if numbers and QUANTITIES[name].units != "1":
        yield _Bare(name, path, min(numbers), max(numbers))
