"""Measured points from tables: CSV files of people, of their instruments and of Excel (`files/tables.py`).

    # felt on PC-ABS, 10 N            speed [mm/s]; grease A; grease B
    speed [mm/s], mu                  0,5;          0,141;    0,120
    0.5, 0.61                         1;            0,132;
    1,   0.58

The first line that is not a comment names the columns, in any order, with their units in brackets (or in a line of
their own below); without a unit a column is in SI, or in the unit the caller names. `headings.py` knows what columns
are called. A table without a column of that name is wide: every other column of plain numbers is a material, named by
its heading, and may have gaps. A column called material, lubricant or sample tells materials apart row by row.
"""

from __future__ import annotations

import warnings
from collections.abc import Collection, Sequence
from contextlib import suppress
from decimal import Decimal
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from stickslip.errors import ConfigError, Problem, QuantityError, UnitWarning
from stickslip.files.tables import (
    DECIMAL_COMMA,
    MOST_PROBLEMS,
    NUMBER,
    Cell,
    Table,
    cells,
    has_decimal_commas,
    mixed_marks,
    read_table,
    thousands,
    wrong_count,
)
from stickslip.fit.headings import POINTS, PURE, Heading, heading, with_units_below
from stickslip.fit.loads import load_above, newtons
from stickslip.fit.roles import GAPS, MOST_FRICTION, MU, WHOLE, Role, Search, Wanted, example, titled
from stickslip.vocabulary import units
from stickslip.vocabulary.column_units import is_column_unit
from stickslip.vocabulary.parameter import Parameter
from stickslip.vocabulary.settings import AGEING_COLUMNS, CURVE_COLUMNS

_FORCE = Parameter("friction_force", "N", "friction force", "points", at_least=0)
_LOAD = Parameter("load", "N", "normal load", "points", above=0)
_MOST_EVER = 5.0  # rubber, and clean metals in vacuum, reach it
_SAME_LOAD = 0.01  # share by which two loads that are the same may differ
_SMALLEST, _LARGEST = 1e-15, 1e15  # in SI; measurements are not beyond, and squares must stay finite


class Columns(dict[str, NDArray[np.float64]]):
    """Columns by name, in SI, row by row.

    assumed : those that were read in SI for want of a unit. units : in which the others were written, by name.
    read : headings they came from, by name. ignored : headings of columns that were left out. notes : what else was
    done with columns. above : numbers of the first and the last line above the heading that were left out.
    """

    assumed: tuple[Parameter, ...] = ()
    units: dict[str, str] = {}
    read: dict[str, str] = {}
    ignored: tuple[str, ...] = ()
    notes: tuple[str, ...] = ()
    above: tuple[int, int] | None = None

    def caution(self) -> str:
        """What was assumed, in words; empty if nothing was."""
        told = []
        for column in self.assumed:
            unit, values = units.spelled(column.units), self[column.name]
            told.append(
                f"The header gives no unit of {column.name}, so the numbers were read in {unit} ({values.min():.4g} to "
                f"{values.max():.4g} {unit}): write '{titled(column)}', or the unit they have."
            )
        return " ".join(told)


def read_points(path: str | Path, columns: Sequence[Parameter], unit: str | None = None) -> Columns:
    """The columns of a CSV file by name, in SI, row by row.

    columns : those of the file, such as CURVE_COLUMNS or AGEING_COLUMNS; one whose default is not None may be missing,
        and then is missing in the result.
    unit : of the column that has one, speed or time, where the header does not name it; None takes SI.
    Raises ConfigError with everything that is wrong, by line and column, and for a table of several materials.
    """
    return only(Path(path), read_materials(path, columns, Wanted(unit or "")))


def only(path: Path, materials: dict[str, Columns]) -> Columns:
    """The points of a table of one material. Raises ConfigError for one of several."""
    if len(materials) > 1:
        message = f"got {len(materials)} materials ({', '.join(materials)}), expected one"
        raise ConfigError(str(path), [Problem((), message, hint="name the column to take, or compare them")])
    return next(iter(materials.values()))


def kind_of(path: Path, wanted: Wanted) -> tuple[Parameter, ...]:
    """Whether a table holds points of a curve or of ageing: CURVE_COLUMNS or AGEING_COLUMNS. Raises ConfigError."""
    if wanted.speed or wanted.time:
        return CURVE_COLUMNS if wanted.speed else AGEING_COLUMNS
    either = ("speed", "time", MU)
    table = _table(path, CURVE_COLUMNS, either, wanted)
    found = [heading(cell.text) for cell in table.heading]
    has_speed = any(one.kind == "speed" or is_column_unit(one.unit, "m s-1") for one in found)
    return AGEING_COLUMNS if not has_speed and any(one.kind == "time" for one in found) else CURVE_COLUMNS


def read_materials(path: str | Path, columns: Sequence[Parameter], wanted: Wanted | None = None) -> dict[str, Columns]:
    """The points of every material of a table, by name; that of a single unnamed one is empty.

    As `read_points`. Raises ConfigError.
    """
    wanted = wanted or Wanted()
    names = tuple(column.name for column in columns)
    table = _table(Path(path), columns, names, wanted)
    others = () if MU in names else names
    headings, has_units = with_units_below(
        table, [heading(cell.text, POINTS if not others else (), others) for cell in table.heading],
        {column.name: column.units for column in columns if others and column.units != "1"},
    )  # fmt: skip
    rows = list(cells(table))[has_units:]
    roles, group, notes = Search(table, headings, rows, columns, wanted).roles()
    used = {role.position for role in roles} | ({group} if group is not None else set())
    used |= {role.load[0] for role in roles if isinstance(role.load, tuple)}
    found = _Numbers(table, rows, roles, group).materials()
    _ask_about_load(table, wanted)
    for role in roles:
        _check_friction(table, headings[role.position], role, found)
    if missing := [role for role in roles if role.column.units != "1" and not role.unit]:
        _check_units_above(table, missing[0])
    for name, points in found.items():
        own = [role for role in roles if role.label in ("", name) or group is not None]
        points.assumed = tuple(r.column for r in roles if r.column.units != "1" and not r.unit)
        points.units = {r.column.name: r.unit for r in roles if r.column.units != "1" and r.unit}
        points.read = {r.column.name: headings[r.position].text for r in own}
        points.ignored = tuple(h.text for i, h in enumerate(headings) if i not in used and h.text)
        points.notes = notes
        points.above = (table.above[0][0].place.line, table.above[-1][0].place.line) if table.above else None
    return found


def _table(path: Path, columns: Sequence[Parameter], names: Collection[str], wanted: Wanted) -> Table:
    """The parts of a file; where no line has headings that are known, the names of columns stand over the numbers.

    Raises ConfigError.
    """
    table = read_table(path, example(columns), "points", lambda cells: _may_be_headings(cells, names, wanted))
    if _may_be_headings([cell.text for cell in table.heading], names, wanted):
        return table
    return read_table(path, example(columns), "points", _are_words)


def _are_words(cells: Sequence[str]) -> bool:
    """Whether none of the cells is a number or a unit, as in a line of units below the names."""
    plain = (cell.replace(",", ".").strip("[]() ") for cell in cells)
    return not any(NUMBER.fullmatch(cell) or cell in PURE[1:] or is_column_unit(cell) for cell in plain)


def _may_be_headings(cells: Sequence[str], names: Collection[str], wanted: Wanted) -> bool:
    """Whether cells name the columns of a table: one of speed or time beside another that may be friction."""
    if MU not in names:
        return {one.kind for cell in cells if (one := heading(cell, (), tuple(names))).kind} >= set(names)
    found = [heading(cell) for cell in cells]
    steps = {i for i, one in enumerate(found) if one.kind in ("speed", "time") and one.kind in names}
    steps |= {i for i, one in enumerate(found) for word in (wanted.speed, wanted.time) if word and one.is_called(word)}
    kinds = ("", MU, "kinetic", "static", "friction_force")
    return bool(steps) and any(i not in steps and one.text and one.kind in kinds or
                               any(map(one.is_called, wanted.friction)) for i, one in enumerate(found))  # fmt: skip


def _check_units_above(table: Table, role: Role) -> None:
    """Raises ConfigError where a line above the heading holds a unit that the heading lacks."""
    for line in table.above:
        for cell in line:
            if is_column_unit(cell.text, role.column.units):
                message = f"got the unit {cell.text!r} above the heading, expected it behind {role.column.name}"
                hint = f"write '{role.column.name} [{cell.text}]', or say --unit {cell.text}"
                raise ConfigError(table.name, [Problem((), message, cell.place, hint)])


def _ask_about_load(table: Table, wanted: Wanted) -> None:
    """Warns where a line above the heading gives another load than the caller."""
    with suppress(ConfigError):  # several loads, of which this may be one
        if wanted.load is not None and (above := load_above(table)) is not None:
            own, given = above[0], newtons(wanted.load)
            if abs(own - given) > _SAME_LOAD * given:
                asked = f"measured with {own:g} N, and the load given is {given:g} N: is that meant?"
                warnings.warn(f"{table.name}:{above[1]}: {asked}", UnitWarning, stacklevel=2)


def _check_friction(table: Table, one: Heading, role: Role, found: dict[str, Columns]) -> None:
    """Raises ConfigError where numbers are too large for friction coefficients, as those in percent are."""
    if role.column.name != MU:
        return
    most = max((float(points[MU].max()) for name, points in found.items() if role.label in ("", name)), default=0.0)
    if most <= (MOST_FRICTION if one.unit == "" or role.unit else _MOST_EVER):
        return
    message = f"got {one.text!r} up to {most:.4g}, expected friction coefficients"
    hint = "numbers in percent need the unit, 'COF [%]'; plain ones above 2 as well, 'COF [-]'"
    raise ConfigError(table.name, [Problem((MU,), message, table.heading[role.position].place, hint)])


# --- the numbers ------------------------------------------------------------------------------------------------------


class _Numbers:
    """Reads the numbers of the columns that have a role."""

    def __init__(self, table: Table, rows: list[tuple[Cell, ...]], roles: list[Role], group: int | None) -> None:
        self._table, self._rows, self._roles, self._group = table, rows, roles, group
        texts = [[cell.text for cell in row] for row in rows]
        used = [*(role.position for role in roles), *(role.load[0] for role in roles if isinstance(role.load, tuple))]
        self._comma = has_decimal_commas(table, texts, used)
        self._thousands = {i for i in used if thousands([row[i] for row in texts if i < len(row)], self._comma)}
        self._problems: list[Problem] = []

    def materials(self) -> dict[str, Columns]:
        """The points by material. Raises ConfigError with everything that is wrong."""
        shared = [role for role in self._roles if role.column.name not in (MU, "sigma")]
        sigmas = {role.label: role for role in self._roles if role.column.name == "sigma"}
        frictions = [role for role in self._roles if role.column.name == MU]
        each = [[*shared, role, *([sigmas[role.label]] if role.label in sigmas else [])] for role in frictions]
        each = each or [self._roles]
        found: dict[str, dict[str, list[float]]] = {}
        for row in self._rows:
            if len(self._problems) >= MOST_PROBLEMS:
                break
            if len(row) != len(self._table.heading):
                self._problems.append(wrong_count(self._table, row))
                continue
            known = {role.position: self._number(role, row) for role in shared}
            for roles in each:
                own = next((role for role in roles if role.column.name == MU), None)
                if own is not None and own.label and row[own.position].text.lower() in GAPS:
                    continue  # of a wide table, whose materials need not be measured at the same speeds
                group = "" if self._group is None else row[self._group].text
                group = whole[1] if (whole := WHOLE.fullmatch(group)) else group
                name = " ".join(filter(None, (group, own.label if own else "")))
                points = found.setdefault(name, {role.column.name: [] for role in roles})
                for role in roles:
                    if role.position not in known:
                        known[role.position] = self._number(role, row)
                    points[role.column.name].append(known[role.position])
        if self._problems:
            raise ConfigError(self._table.name, self._problems)
        return {name: Columns({column: np.array(one[column]) for column in one}) for name, one in found.items()}

    def _number(self, role: Role, row: Sequence[Cell]) -> float:
        """One number in SI; what is wrong with it becomes a problem."""
        cell = row[role.position]
        try:
            if role.position in self._thousands:
                raise QuantityError("a number without separators of thousands", f"write {cell.text!r} as '1234.5'")
            if role.load is None:
                return _number(cell.text, role.unit, role.column, self._comma)
            force = _number(cell.text, role.unit, _FORCE, self._comma)
            if isinstance(role.load, float):
                return force / role.load
            cell = row[role.load[0]]
            load = _number(cell.text, role.load[1], _LOAD, self._comma)
            return force / load
        except QuantityError as error:
            got = f"got {cell.text!r}, expected" if cell.text else "empty, expected"
            self._problems.append(Problem((role.column.name,), f"{got} {error.expected}", cell.place, error.hint))
            return 0.0


def _number(text: str, unit: str, column: Parameter, comma: bool) -> float:
    """One number in SI; comma : whether the file has decimal commas. Raises QuantityError."""
    plain = text.replace(",", ".") if comma else text
    if not NUMBER.fullmatch(plain) or mixed_marks(text, comma):
        hint = mixed_marks(text, comma) or None
        if DECIMAL_COMMA.fullmatch(text):
            hint = f"write a decimal point, not a comma: {text.replace(',', '.')}"
        elif text.lower() in GAPS:
            hint = "leave out points that were not measured"
        raise QuantityError("a number", hint)
    if unit == "%":
        value = float(Decimal(plain) / 100)
    else:
        value = units.si_value(f"{plain} {unit}", column.units) if unit else units.si_value(float(plain), column.units)
    if not column.allows(value):
        raise QuantityError(column.expected)
    if value and not _SMALLEST <= value <= _LARGEST:
        raise QuantityError(f"0 or a number from {_SMALLEST:g} to {_LARGEST:g} in SI")
    return value
