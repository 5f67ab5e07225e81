"""Tables whose headings are written by people: which column is which, its unit, and what lines above them tell; signals
of records: columns of time, speed, displacement, friction and load.

Measured points, records in steps, records of a rig and pairs of features are all read by it.
"""

import math
import re
import warnings
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from stickslip.errors import ConfigError, Place, Problem, QuantityError, UnitWarning
from stickslip.files.layout import NUMBER, is_number
from stickslip.files.tables import (
    TextCell,
    TextTable,
    first_cells,
    numbers,
    read_blocks,
    read_table,
    sheets_with_tables,
)  # fmt: skip
from stickslip.files.texts import is_workbook
from stickslip.vocabulary import units
from stickslip.vocabulary.display_units import column_unit, is_column_unit
from stickslip.vocabulary.parameter import Parameter
from stickslip.vocabulary.quantities import PARAMETERS, listed
from stickslip_materials.fit.headings import Heading, are_units, below, heading, turns
from stickslip_materials.fit.uncertainty import Floats
from stickslip_materials.fit.words import PERCENT, POINTS, PURE

MOST_FRICTION = 2.0  # of a column whose heading says nothing; more is rather a percentage, or something else
MOST_EVER = 5.0  # rubber, and clean metals in vacuum, reach it
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


class HeadedTable:
    """A table whose headings are understood.

    table : without a line of units below the names. headings : of its columns, with these units. kinds, names : of
    columns there may be, as for `heading`.
    """

    def __init__(self, table: TextTable, kinds: tuple[str, ...] = POINTS, names: tuple[str, ...] = ()) -> None:
        headings = [heading(cell.text, kinds, names) for cell in table.heading]
        first = [cell.text for cell in first_cells(table)] if len(table.lines) > 1 else []
        is_row = len(first) != len(headings) or any(map(is_number, first))
        joined = None if is_row else below(headings, first, kinds)
        self.headings, self.table = joined or headings, replace(table, lines=table.lines[joined is not None :])

    @classmethod
    def read(
        cls, path: Path, example: str, are_headings: Callable[[list[Heading]], bool], kinds: tuple[str, ...] = POINTS,
        names: tuple[str, ...] = (), *, several: bool = False,
    ) -> "list[HeadedTable]":  # fmt: skip
        """The table in a file, below the first line of headings over numbers. Raises ConfigError.

        are_headings : whether these may be the headings of the table; units alone never are. several : whether the file
        may hold several, each below the same headings.
        """
        tables = read_blocks(path, example, is_heading=_recognizer(are_headings, kinds, names), several=several)
        return [cls(table, kinds, names) for table in tables]

    @classmethod
    def read_sheets(
        cls, path: Path, example: str, are_headings: Callable[[list[Heading]], bool], rows_are: str
    ) -> dict[str, "HeadedTable"]:
        """The table of a file, or of each sheet of a workbook with such headings, by title. Raises ConfigError.

        Where no line has headings that are known, the names of columns stand over the numbers.
        """
        is_heading = _recognizer(are_headings)
        by_words = _recognizer(lambda headings: not any(head.text and are_units([head.text]) for head in headings))
        tables = {}
        for title in sheets_with_tables(path, is_heading) if is_workbook(path) else [None]:
            table = read_table(path, example, rows_are, is_heading, title)
            if not is_heading([cell.text for cell in table.heading]):
                table = read_table(path, example, rows_are, by_words, title)
            tables[title or ""] = cls(table)
        return tables

    def pick(self, kind: str, name: str = "") -> int | None:
        """The column of a kind, or of that name: plainly called so before longer names, actual before set values.

        None where there is none. Raises ConfigError where several may be meant.
        """
        columns = [i for i, head in enumerate(self.headings) if (head.is_called(name) if name else head.kind == kind)]
        if not columns and name:
            names = listed([repr(head.text) for head in self.headings])
            raise self.error(f"no column is called {name!r}, expected {names}")
        for is_nearer in (Heading.has_own_unit, lambda head: not head.label, lambda head: not head.is_set()):
            columns = [i for i in columns if is_nearer(self.headings[i])] or columns
        if len(columns) > 1:
            option = f"--{kind if kind in ('speed', 'time') else 'friction'}-column"
            first = self.headings[columns[0]].text
            hint = f"remove one of the two columns, or name the one to take: {option} '{first}'"
            raise self.refused(columns[1], "it once", hint)
        return columns[0] if columns else None

    def check_friction(self, i: int, largest: float) -> None:
        """Raises ConfigError for a column that may be a force, or a percentage, as well as a coefficient.

        largest : of its numbers, as coefficients.
        """
        head = self.headings[i]
        is_open = not head.unit and head.may_be_force() and head.kind != "friction_force"
        if is_open and (any(other.kind == "load" for other in self.headings) or load_above(self.table) is not None):
            expected = "a unit: force or coefficient? There is a load to divide a force by"
            raise self.refused(i, expected, f"write '{head.name} [N]' for a force, '{head.name} [-]' for a coefficient")
        if largest > (MOST_EVER if head.unit in PURE[1:] else MOST_FRICTION):
            hint = "numbers in percent need the unit, 'COF [%]'; plain ones above 2 as well, 'COF [-]'"
            message = f"got {head.text!r} up to {largest:.4g}, expected friction coefficients"
            place = self.table.heading[i].place
            raise ConfigError.of(self.table.name, message, hint, place=place, path=("mu",))

    def find(
        self, name_of: Callable[[Heading], str | None], factor_of: Callable[[str, Heading], float], twice: str
    ) -> dict[str, tuple[int, float]]:
        """The columns by name: the position of each, and the factor from its numbers to SI.

        name_of : None for a column that is not used. factor_of : raises QuantityError. twice : the remedy where a name
        occurs twice. Raises ConfigError with everything that is wrong.
        """
        columns: dict[str, tuple[int, float]] = {}
        problems = []
        for i, column in enumerate(self.headings):
            try:
                if (name := name_of(column)) is not None:
                    other = self.headings[columns[name][0]] if name in columns else None
                    if other and other.is_set() == column.is_set():
                        raise QuantityError("it once", twice)
                    if other is None or other.is_set():  # actual values before set ones
                        columns[name] = i, factor_of(name, column)
            except QuantityError as error:
                problems.append(self._problem(i, error.expected, error.hint))
        if problems:
            raise ConfigError(self.table.name, problems)
        return columns

    def values(
        self, columns: Mapping[str, tuple[int, float]], progress: Callable[[int, int], None] | None = None
    ) -> dict[str, Floats]:
        """The numbers of columns that were found, in SI, by name. Raises ConfigError naming line and column."""
        read = numbers(self.table, [i for i, _ in columns.values()], progress)
        return {name: read[i] * factor for name, (i, factor) in columns.items()}

    def error(self, message: str, hint: str | None = None, *, at_heading: bool = True) -> ConfigError:
        """An error at the line of the heading, or about the table as a whole."""
        place = Place(self.table.heading[0].place.line, 1) if at_heading else None
        return ConfigError.of(self.table.name, message, hint, place=place)

    def refused(self, i: int, expected: str, hint: str | None = None) -> ConfigError:
        """An error at the heading of a column."""
        return ConfigError(self.table.name, [self._problem(i, expected, hint)])

    def _problem(self, i: int, expected: str, hint: str | None) -> Problem:
        cell = self.table.heading[i]
        return Problem((), f"got {cell.text!r}, expected {expected}", cell.place, hint)


def _recognizer(
    are_headings: Callable[[list[Heading]], bool], kinds: tuple[str, ...] = POINTS, names: tuple[str, ...] = ()
) -> Callable[[Sequence[str]], bool]:
    return lambda texts: not are_units(texts) and are_headings([heading(text, kinds, names) for text in texts])


def factor(name: str, unit: str, si: str, *, percent: bool = False, needed: bool = False) -> float:
    """The factor from a unit that a heading gives to SI; no unit is SI, unless it is needed. Raises QuantityError.

    percent : whether a pure number may be one. Warns of grams that are forces.
    """
    if si == "N" and unit == "g":
        warnings.warn(f"{name!r} in g is read in grams-force, 9.80665 mN each", UnitWarning, stacklevel=2)
    if si == "1":
        if percent and unit in PERCENT:
            return 0.01
        if unit not in PURE:
            raise QuantityError("no unit", f"{name} is a pure number")
        return 1.0
    if needed and not unit:
        raise QuantityError("its unit in brackets", f"for instance '{name} [{units.spelled(si)}]'")
    return units.si_value(f"1 {column_unit(unit, si)}", si) if unit else 1.0


def example(columns: Sequence[Parameter]) -> str:
    """A line that names the columns there must be."""
    return ", ".join(titled(column) for column in columns if column.default is None)


def titled(column: Parameter) -> str:
    """The name of a column with a unit that people use: ``speed [mm/s]``."""
    return f"{column.name} [{units.example(column.units).split(' ', 1)[1]}]" if column.units != "1" else column.name


# --- what lines above the heading tell --------------------------------------------------------------------------------


def load_above(table: TextTable) -> tuple[float, int] | None:
    """The load (N) that a remark or a line above the heading gives, `Prüflast;15;N`, and that line; None if none does.

    Raises ConfigError where several say different loads, or one says it in a way nobody understands.
    """
    return stated(table, "load", PARAMETERS["normal_load"], [*((remark,) for remark in table.remarks), *table.above])


def stated(
    table: TextTable, kind: str, row: Parameter, lines: Iterable[Sequence[TextCell]], only_numbers: bool = False,
    hint: str | None = None,
) -> tuple[float, int] | None:  # fmt: skip
    """A quantity that lines give as `Name;15;N` or `Name: 15 N`, in SI, and the line of the first; None if none does.

    kind : of heading that its name is. only_numbers : leave out what is none, such as "varied". Raises ConfigError.
    """
    known: list[tuple[float, int]] = []
    for line in lines:
        words = [cell.text for cell in line if cell.text]
        if len(words) > 1:
            name, value = words[0], " ".join(words[1:]).strip()
        else:
            name, _, value = (part.strip() for part in "".join(words).replace("=", ":").partition(":"))
        title = heading(name.strip(" :="), (kind,))
        if title.kind != kind or title.label and only_numbers or not value or only_numbers and not value[0].isdigit():
            continue
        try:
            if re.match(r"[1-9]\d{0,2}[.,]\d{3}(?!\d)", value):  # 1.500 N may be 1500 N
                raise QuantityError(row.expected)
            number, _, unit = value.replace(",", ".").partition(" ")
            si = row.read(f"{number} {column_unit(unit.strip(' []()') or title.unit, row.units)}")
        except QuantityError:
            message = f"got {' '.join(words)!r}, expected a {kind} such as '{units.example(row.units)}'"
            raise ConfigError.of(table.name, message, hint, place=line[0].place) from None
        known.append((si, line[0].place.line))
    if len({si for si, _ in known}) > 1:
        values = listed([f"{si:g} {units.spelled(row.units)}" for si, _ in known], "and")
        raise ConfigError.of(table.name, f"got the {kind}s {values}, expected one", place=Place(known[1][1], 1))
    return known[0] if known else None


def newtons(load: float | str) -> float:
    """A load that people give, in N: a number, or a text with a unit. Raises ConfigError."""
    try:
        return PARAMETERS["normal_load"].read(float(load) if NUMBER.fullmatch(str(load)) else load)
    except QuantityError as error:
        raise ConfigError.of("--load", f"got {load!r}, expected {error.expected}", error.hint) from None


# --- records ----------------------------------------------------------------------------------------------------------


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
