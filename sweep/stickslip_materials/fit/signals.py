"""Signals of records: columns of time, speed, displacement, friction and load, as people call them."""

import math
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from stickslip.errors import ConfigError, QuantityError
from stickslip.vocabulary import units
from stickslip.vocabulary.column_units import is_column_unit
from stickslip.vocabulary.parameter import Parameter
from stickslip.vocabulary.quantities import PARAMETERS
from stickslip.vocabulary.suggest import listed
from stickslip_materials.fit.columns import HeadedTable, factor, stated
from stickslip_materials.fit.headings import turns
from stickslip_materials.fit.uncertainty import Floats

_UNITS = {
    "time": "s", "begin": "s", "end": "s", "speed": "m s-1", "force": "N", "load": "N", "mu": "1",
    "friction_force": "N", "kinetic": "1", "displacement": "m",
}  # fmt: skip
_RADIUS = Parameter("radius", "m", "radius of the track", "points", above=0)
_SAME = 0.01  # by which two loads or radii that are the same may differ


class Signals:
    """The columns of a record by their kinds, in SI, and what was taken for what.

    example : of a line that names the columns. kinds : of columns there may be. Its methods raise ConfigError for what
    is missing, not in its unit, or open.
    """

    def __init__(self, path: Path, example: str, kinds: tuple[str, ...]) -> None:
        self._example = example
        self._table = HeadedTable.read(path, example, lambda ones: sum(one.kind in kinds for one in ones) > 1, kinds)
        self.taken: dict[str, str] = {}

    def __contains__(self, kind: str) -> bool:
        return self._table.pick(kind) is not None

    def read(self, kind: str, name: str = "") -> Floats:
        """The column of a kind, or of this name, in SI."""
        if (i := self._table.pick(kind, name)) is None:
            headings = listed([repr(one.text) for one in self._table.headings], "and")
            hint = f"for instance '{self._example}'" + "; --plan names a table of steps" * (kind == "speed")
            raise self.error(f"no column of {kind} among {headings}", hint)
        one = self._table.headings[i]
        try:
            times = (
                turns(one.unit)
                if kind == "rotation"
                else factor(kind, one.unit, _UNITS[kind], percent=True, needed=True)
            )
        except QuantityError as error:
            raise self._table.refused(i, error.expected, error.hint) from None
        if times is None:
            raise self._table.refused(i, "the unit of a speed of rotation in brackets", "for instance 'rotation [rpm]'")
        self.taken[kind] = one.shown
        values = self._table.values({kind: (i, times)})[kind]
        if kind in ("mu", "kinetic"):
            self._table.check_friction(i, float(np.abs(values).max()))
        return values

    def given(self, name: str, option: float | None) -> float:
        """The load or radius of a line above the heading, or else of an option; NaN for none."""
        row = {"load": PARAMETERS["normal_load"], "radius": _RADIUS}[name]
        lines = [*((remark,) for remark in self._table.table.remarks), *self._table.table.above]
        above = stated(self._table.table, name, row, lines)
        if above and option is not None and not math.isclose(above[0], option, rel_tol=_SAME):
            raise self.error(
                f"line {above[1]} gives the {name} {above[0]:g}, and --{name} {option:g} (SI)", "leave one out"
            )
        value = above[0] if above else option
        if value is not None:
            where = f"line {above[1]}" if above else f"--{name}"
            self.taken[name] = f"{value:g} {units.spelled(row.units)} ({where})"
        return math.nan if value is None else value

    def speed(self, radius: float | None, name: str = "") -> Floats:
        """The slip speed, m/s."""
        is_rotation = name and self._table.headings[self._table.pick("speed", name) or 0].kind == "rotation"
        if not is_rotation and (name or "speed" in self or "rotation" not in self):
            return self.read("speed", name)
        rotation, track = self.read("rotation", name), self.given("radius", radius)
        if math.isnan(track):
            raise self.error("the speed is one of rotation", "give the radius of the track: --radius '20 mm'")
        return track * rotation

    def friction(self, loads: Floats, inside: NDArray[np.bool_], name: str = "") -> Floats:
        """The friction coefficient: a column of it, or one of its force over the load, which must be known inside."""
        kinds = ("mu", "kinetic", "friction_force", "force")
        i = self._table.pick("friction", name) if name else None
        kind = next((one for one in kinds if one in self), "mu")
        if i is None:
            i = self._table.pick(kind)
        one = None if i is None else self._table.headings[i]
        is_force = one is not None and (one.is_force() or one.kind == "force" or name and is_column_unit(one.unit, "N"))
        if one is None or not is_force:
            return self.read(kind if not name else "mu", name)
        force = self.read("friction_force", one.text)
        if not (loads[inside] > 0).all():
            hint = "give --load, or a column of the load, with all values above 0"
            raise self.error("friction is a force, and the load is not known or not above 0", hint)
        return np.divide(force, loads, out=np.zeros_like(force), where=loads > 0)

    def describe(self, load: float | None = None, radius: float | None = None) -> str:
        """What was taken for what, and what was left out, of a load or radius that somebody gave as well."""
        columns = {"load": (load, "a column tells the load"), "radius": (radius, "no speed is one of rotation")}
        unused = [f"--{name} is not used, since {reason}" for name, (value, reason) in columns.items()
                  if value is not None and not self.taken.get(name, "").endswith(")")]  # fmt: skip
        over = " over the load" if "friction_force" in self.taken else ""
        parts = [f"{text} is {'friction' + over if kind in ('friction_force', 'mu', 'kinetic') else kind}"
                 for kind, text in self.taken.items()]  # fmt: skip
        others = [one.shown for one in self._table.headings if one.shown not in self.taken.values() and one.text]
        left = [f"not used: {', '.join(others)}"] if others else []
        return "; ".join([", ".join(parts), *unused, *left])

    def error(self, message: str, hint: str | None = None) -> ConfigError:
        """That the table as a whole will not do."""
        return self._table.error(message, hint, at_heading=False)
