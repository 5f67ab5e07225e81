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

from collections.abc import Sequence
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from stickslip.errors import ConfigError, Problem, QuantityError
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
    wrong_count,
)
from stickslip.fit.headings import Heading, heading, meant
from stickslip.fit.roles import GAPS, MU, Role, Search, Wanted, example, is_unit_of, titled
from stickslip.vocabulary import units
from stickslip.vocabulary.parameter import Parameter
from stickslip.vocabulary.settings import AGEING_COLUMNS, CURVE_COLUMNS

_SMALLEST, _LARGEST = 1e-15, 1e15  # in SI; measurements are not beyond, and squares must stay finite


class Columns(dict[str, NDArray[np.float64]]):
    """Columns by name, in SI, row by row.

    assumed : those that were read in SI for want of a unit. units : in which the others were written, by name.
    read : headings they came from, by name. ignored : headings of columns that were left out.
    """

    assumed: tuple[Parameter, ...] = ()
    units: dict[str, str] = {}
    read: dict[str, str] = {}
    ignored: tuple[str, ...] = ()

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
    table = read_table(path, example(CURVE_COLUMNS), "points")
    found = {meant(heading(cell.text, ("speed", "time")).name, ("speed", "time")) for cell in table.heading}
    return AGEING_COLUMNS if "time" in found and "speed" not in found else CURVE_COLUMNS


def read_materials(path: str | Path, columns: Sequence[Parameter], wanted: Wanted | None = None) -> dict[str, Columns]:
    """The points of every material of a table, by name; that of a single unnamed one is empty.

    As `read_points`. Raises ConfigError.
    """
    wanted = wanted or Wanted()
    table = read_table(Path(path), example(columns), "points")
    headings, rows = _headings(table, columns)
    roles, group = Search(table, headings, rows, columns, wanted).roles()
    used = {role.position for role in roles} | ({group} if group is not None else set())
    found = _Numbers(table, rows, roles, group).materials()
    for name, points in found.items():
        points.assumed = tuple(r.column for r in roles if r.column.units != "1" and not r.unit)
        points.units = {r.column.name: r.unit for r in roles if r.unit}
        points.read = {r.column.name: headings[r.position].text for r in roles if r.label in ("", name)}
        points.ignored = tuple(h.text for i, h in enumerate(headings) if i not in used and h.text)
    return found


def _headings(table: Table, columns: Sequence[Parameter]) -> tuple[list[Heading], list[tuple[Cell, ...]]]:
    """The headings, and the lines below them; a first line of units belongs to the former."""
    known = [column.name for column in columns]
    found = [heading(cell.text, known) for cell in table.heading]
    rows = list(cells(table))
    texts = [cell.text.strip("[]() ") for cell in rows[0]]
    if len(texts) != len(found) or len(rows) < 2 or any(NUMBER.fullmatch(t.replace(",", ".")) for t in texts):
        return found, rows
    for i, one in enumerate(found):
        row = next((c for c in columns if c.name == meant(one.name, known)), None)
        if row is not None and row.units != "1" and not one.unit and is_unit_of(texts[i], row):
            named = [Heading(h.text, h.name, h.unit or text) for h, text in zip(found, texts, strict=True)]
            return named, rows[1:]
    return found, rows


# --- the numbers ------------------------------------------------------------------------------------------------------


class _Numbers:
    """Reads the numbers of the columns that have a role."""

    def __init__(self, table: Table, rows: list[tuple[Cell, ...]], roles: list[Role], group: int | None) -> None:
        self._table, self._rows, self._roles, self._group = table, rows, roles, group
        texts = [[cell.text for cell in row] for row in rows]
        self._comma = has_decimal_commas(table, texts, [role.position for role in roles])
        self._problems: list[Problem] = []

    def materials(self) -> dict[str, Columns]:
        """The points by material. Raises ConfigError with everything that is wrong."""
        shared = [role for role in self._roles if role.column.name != MU]
        each = [[*shared, role] for role in self._roles if role.column.name == MU] or [shared]
        found: dict[str, dict[str, list[float]]] = {}
        for row in self._rows:
            if len(self._problems) >= MOST_PROBLEMS:
                break
            if len(row) != len(self._table.heading):
                self._problems.append(wrong_count(self._table, row))
                continue
            known = {role.position: self._number(role, row[role.position]) for role in shared}
            for roles in each:
                last = roles[-1]
                if last.label and row[last.position].text.lower() in GAPS:
                    continue  # of a wide table, whose materials need not be measured at the same speeds
                if last.position not in known:
                    known[last.position] = self._number(last, row[last.position])
                name = last.label if self._group is None else row[self._group].text
                points = found.setdefault(name, {role.column.name: [] for role in roles})
                for role in roles:
                    points[role.column.name].append(known[role.position])
        if self._problems:
            raise ConfigError(self._table.name, self._problems)
        order = list(dict.fromkeys(role.column.name for role in self._roles))
        return {name: Columns({column: np.array(one[column]) for column in order}) for name, one in found.items()}

    def _number(self, role: Role, cell: Cell) -> float:
        """One number in SI; what is wrong with it becomes a problem."""
        try:
            return _number(cell.text, role.unit, role.column, self._comma)
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
    value = units.si_value(f"{plain} {unit}", column.units) if unit else units.si_value(float(plain), column.units)
    if not column.allows(value):
        raise QuantityError(column.expected)
    if value and not _SMALLEST <= value <= _LARGEST:
        raise QuantityError(f"0 or a number from {_SMALLEST:g} to {_LARGEST:g} in SI")
    return value
