"""Signals of records: columns of time, speed, displacement, friction and load, as people call them."""

import math
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from stickslip.errors import ConfigError, QuantityError
from stickslip.vocabulary import units
from stickslip.vocabulary.display_units import is_column_unit
from stickslip.vocabulary.parameter import Parameter
from stickslip.vocabulary.quantities import PARAMETERS, listed
from stickslip_materials.fit.columns import HeadedTable, factor, stated
from stickslip_materials.fit.headings import turns
from stickslip_materials.fit.uncertainty import Floats

_UNITS = {
    "time": "s", "begin": "s", "end": "s", "speed": "m s-1", "force": "N", "load": "N", "mu": "1",
    "friction_force": "N", "kinetic": "1", "displacement": "m",
}  # fmt: skip
_GIVEN = {
    "load": PARAMETERS["normal_load"],
    "speed": PARAMETERS["belt_speed"],
    "radius": Parameter("radius", "m", "radius of the track", "points", above=0),
}
_SAME = 0.01  # by which two loads or radii that are the same may differ


class Signals:
    """The columns of a record by their kinds, in SI, and what was taken for what.

    example : of a line that names the columns. block : its name, of several. Its methods raise ConfigError for what is
    missing, not in its unit, or open.
    """

    def __init__(self, table: HeadedTable, example: str) -> None:
        self._table, self._example, self.block = table, example, table.table.block
        self.taken: dict[str, str] = {}

    @classmethod
    def of_file(cls, path: Path, example: str, kinds: tuple[str, ...], *, several: bool = False) -> "list[Signals]":
        """The record in a file, or in each block of it where it may have several. kinds : of columns there may be."""
        tables = HeadedTable.read(path, example, lambda heads: sum(h.kind in kinds for h in heads) > 1, kinds,
                                  several=several)  # fmt: skip
        return [cls(table, example) for table in tables]

    def __contains__(self, kind: str) -> bool:
        return self._table.pick(kind) is not None

    def read(self, kind: str, name: str = "") -> Floats:
        """The column of a kind, or of this name, in SI."""
        if (i := self._table.pick(kind, name)) is None:
            headings = listed([repr(head.text) for head in self._table.headings], "and")
            hint = f"for instance '{self._example}'" + "; --plan names a table of steps" * (kind == "speed")
            raise self.error(f"no column of {kind} among {headings}", hint)
        head = self._table.headings[i]
        try:
            if kind != "rotation":
                times = factor(kind, head.unit, _UNITS[kind], percent=True, needed=True)
            elif (times := turns(head.unit) or 0.0) == 0.0:
                raise QuantityError("the unit of a speed of rotation in brackets", "for instance 'rotation [rpm]'")
        except QuantityError as error:
            raise self._table.refused(i, error.expected, error.hint) from None
        self.taken[kind] = head.shown
        values = self._table.values({kind: (i, times)})[kind]
        if kind in ("mu", "kinetic"):
            self._table.check_friction(i, float(np.abs(values).max()))
        return -values if kind == "load" and np.median(values) < 0.0 else values  # some instruments count it negative

    def given(self, name: str, option: float | None) -> float:
        """The load, radius or speed of a line above the heading, or else of an option; NaN for none."""
        row, table = _GIVEN[name], self._table.table
        lines, is_speed = [*((remark,) for remark in table.remarks), *table.above], name == "speed"
        hint = "write its unit there, or name the column: --speed-column" if is_speed else None
        above = stated(table, name, row, lines, only_numbers=is_speed, hint=hint)
        if above and option is not None and not math.isclose(above[0], option, rel_tol=_SAME):
            message = f"line {above[1]} gives the {name} {above[0]:g}, and --{name} {option:g} (SI)"
            raise self.error(message, "leave one out")
        value, where = (above[0], f"line {above[1]}") if above else (option, f"--{name}")
        if value is None:
            return math.nan
        self.taken[name] = f"{value:g} {units.spelled(row.units)} ({where})"
        return value

    def speed(self, radius: float | None, name: str = "") -> Floats:
        """The slip speed, m/s."""
        is_rotation = name and self._table.headings[self._table.pick("speed", name) or 0].kind == "rotation"
        if not is_rotation and (name or "speed" in self or "rotation" not in self):
            above = math.nan if name or "speed" in self else self.given("speed", None)
            return self.read("speed", name) if math.isnan(above) else np.full(self.read("time").shape, above)
        rotation, track = self.read("rotation", name), self.given("radius", radius)
        if math.isnan(track):
            raise self.error("the speed is one of rotation", "give the radius of the track: --radius '20 mm'")
        return track * rotation

    def friction(self, loads: Floats, inside: NDArray[np.bool_], name: str = "") -> Floats:
        """The friction coefficient: a column of it, or one of its force over the load, which must be known inside."""
        kinds = ("mu", "kinetic", "friction_force", "force")
        kind = "mu" if name else next((kind for kind in kinds if kind in self), "mu")
        i = self._table.pick(kind, name)
        head = None if i is None else self._table.headings[i]
        if head is None or not (head.is_force() or head.kind == "force" or name and is_column_unit(head.unit, "N")):
            return self.read(kind, name)
        force = self.read("friction_force", head.text)
        if not (loads[inside] > 0).all():
            hint = "give --load, or a column of the load, with all values above 0"
            raise self.error("friction is a force, and the load is not known or not above 0", hint)
        return np.divide(force, loads, out=np.zeros_like(force), where=loads > 0)

    def describe(self, load: float | None = None, radius: float | None = None) -> str:
        """What was taken for what, and what was left out, of a load or radius that somebody gave as well."""
        over = " over the load" if "friction_force" in self.taken else ""
        words = dict.fromkeys(("friction_force", "mu", "kinetic"), f"friction{over}")
        parts = [", ".join(f"{text} is {words.get(kind, kind)}" for kind, text in self.taken.items())]
        for name, value in (("load", load), ("radius", radius)):
            if value is not None and not self.taken.get(name, "").endswith(")"):
                parts.append(f"--{name} is not used")
        others = [head.shown for head in self._table.headings if head.shown not in self.taken.values() and head.text]
        return "; ".join([*parts, f"not used: {', '.join(others)}"] if others else parts)

    def error(self, message: str, hint: str | None = None) -> ConfigError:
        """That the table as a whole will not do."""
        return self._table.error(message, hint, at_heading=False)
