"""Numbers without a unit that are implausible in SI.

A friction curve in mm/s read as one in m/s is no error: the map is computed, and shows no stick-slip anywhere. So
implausible values are asked about. A value with its unit is never questioned, and neither are numbers of order one, as
in dimensionless studies.
"""

from __future__ import annotations

import math
import warnings
from collections.abc import Iterator
from functools import reduce
from operator import getitem
from typing import Any, NamedTuple

from stickslip.config.kinds import varied_paths
from stickslip.config.model import Config
from stickslip.config.rules import members
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
# A belt this many times faster than the speed over which friction falls never reaches the drop, whatever the spring.
_FASTER = 30.0
_SLOW = 1.0  # m/s; up to here any ratio may be meant, since curves that fall at once are common


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
    def size(self) -> tuple[float, float]:
        """The smallest and the largest magnitude."""
        ends = abs(self.least), abs(self.most)
        return (0.0 if self.least < 0 < self.most else min(ends)), max(ends)


def ask(document: Document, config: Config) -> None:
    """Warn whoever called the caller of the numbers in a document that are implausible in SI."""
    if asked := question(document, config):
        warnings.warn(asked, UnitWarning, stacklevel=3)


def question(document: Document, config: Config) -> str | None:
    """What to ask about the numbers of a document, `config` being what was read from it; None if all are plausible."""
    bare = list(_bare(document.data))
    asked = {found: reason for found in bare if (reason := _reason(found, config)) is not None}
    if not asked:
        return None
    lines = []
    for found, reason in asked.items():
        declared = QUANTITIES[found.name].units
        understood = f"{found.text()} understood as {found.text(units.spelled(declared))}{reason}"
        problem = Problem(found.path, f"{understood}; did you mean {found.text(_SMALLER[declared])}?",
                          document.keys.get(found.path))  # fmt: skip
        lines.append(problem.text(document.name))
    if others := [f"{b.name} {b.text(units.spelled(QUANTITIES[b.name].units))}" for b in bare if b not in asked]:
        lines.append(f"  also without a unit: {', '.join(others)}")
    return "\n".join([*lines, "  hint: numbers without a unit are in SI; a value with its unit is never questioned"])


def _reason(found: _Bare, config: Config) -> str | None:
    """Why numbers are implausible, in words, or "" where that is obvious; None if they are plausible."""
    least, most = found.size
    if most > _LARGEST.get(found.name, math.inf):
        return ""
    fall = _largest(config, "a4")
    if found.name == "belt_speed" and least > max(_SLOW, _FASTER * fall):
        return f", {least / fall:.0f} times a4{' and more' if most > least else ''}"
    return None


def _largest(config: Config, name: str) -> float:
    """The largest value of a quantity, fixed or along an axis."""
    fixed = config.fixed().get(name)
    if fixed is not None:
        return float(fixed)
    varied = (member for axis in config.axes for member in members(axis) if member.name == name)
    return max((float(member.points().max()) for member in varied), default=math.inf)


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
