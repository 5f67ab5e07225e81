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

from collections.abc import Mapping, Sequence
from decimal import Decimal
from pathlib import Path
from typing import TypeVar

import numpy as np
from numpy.typing import NDArray

from stickslip.errors import ConfigError, Problem, QuantityError
from stickslip.files import layout, tables
from stickslip.files.layout import NUMBER
from stickslip.files.tables import Cell, Table
from stickslip.files.texts import is_workbook
from stickslip.vocabulary import units
from stickslip.vocabulary.display_units import is_column_unit
from stickslip.vocabulary.parameter import Parameter
from stickslip.vocabulary.quantities import AGEING_COLUMNS, CURVE_COLUMNS
from stickslip.vocabulary.suggest import listed
from stickslip_materials.fit.checks import check_conditions, check_record, check_units_above, check_waiting
from stickslip_materials.fit.columns import HeadedTable, example, titled
from stickslip_materials.fit.headings import Heading, are_units, heading
from stickslip_materials.fit.roles import GAPS, MU, WHOLE, ColumnSearch, Role, Roles, Wanted
from stickslip_materials.fit.turns import branch_of, course, directions

Content = TypeVar("Content")
_FORCE = Parameter("friction_force", "N", "friction force", "points", at_least=0)
_LOAD = Parameter("load", "N", "normal load", "points", above=0)
_SMALLEST, _LARGEST = 1e-15, 1e15  # in SI; measurements are not beyond, and squares must stay finite


class Columns(dict[str, NDArray[np.float64]]):
    """Columns by name, in SI, row by row.

    assumed : those that were read in SI for want of a unit. units : in which the others were written, by name.
    read : headings they came from, by name. ignored : headings of columns that were left out. notes : what else was
    done with columns. above : numbers of the first and the last line above the heading that were left out. lines : of
    the file, row by row.
    """

    assumed: tuple[Parameter, ...] = ()
    units: dict[str, str] = {}
    read: dict[str, str] = {}
    ignored: tuple[str, ...] = ()
    notes: tuple[str, ...] = ()
    above: tuple[int, int] | None = None
    lines: tuple[int, ...] = ()

    def caution(self) -> str:
        """A sentence on each unit that was assumed; empty if none was."""
        sentences = []
        for column in self.assumed:
            unit, values = units.spelled(column.units), self[column.name]
            sentences.append(
                f"The header gives no unit of {column.name}, so the numbers were read in {unit} ({values.min():.4g} to "
                f"{values.max():.4g} {unit}): write '{titled(column)}', or the unit they have."
            )
        return " ".join(sentences)


def read_points(path: str | Path, columns: Sequence[Parameter], unit: str | None = None) -> Columns:
    """The columns of a CSV or .xlsx file with the points of one material by name, in SI, row by row.

    columns : CURVE_COLUMNS or AGEING_COLUMNS; that of sigma may be missing, and then is missing in the result. unit :
    of the speeds or times, where the header does not name it; None takes SI. Raises ConfigError with everything that is
    wrong, by line and column, and for a table of several materials.
    """
    return only(Path(path), read_materials(path, columns, Wanted(unit or "")))


def only(path: str | Path, materials: Mapping[str, Content]) -> Content:
    """What there is of the material of a table of one. Raises ConfigError for one of several."""
    if len(materials) > 1:
        message = f"got {len(materials)} materials ({', '.join(materials)}), expected one"
        raise ConfigError.of(path, message, "name the column to take, or compare them")
    return next(iter(materials.values()))


def kind_of(path: Path, wanted: Wanted) -> tuple[Parameter, ...]:
    """The kind of points in a table: CURVE_COLUMNS or AGEING_COLUMNS. Raises ConfigError."""
    if wanted.speed or wanted.time:
        return CURVE_COLUMNS if wanted.speed else AGEING_COLUMNS
    (_, table), *_ = _tables(path, CURVE_COLUMNS, ("speed", "time"), wanted)
    headings = HeadedTable(table).headings
    has_speed = any(column.kind == "speed" or is_column_unit(column.unit, "m s-1") for column in headings)
    return AGEING_COLUMNS if not has_speed and any(column.kind == "time" for column in headings) else CURVE_COLUMNS


def read_materials(path: str | Path, columns: Sequence[Parameter], wanted: Wanted | None = None) -> dict[str, Columns]:
    """The points of every material of a table, by name, in its order; the name of a single unnamed one is empty.

    path, columns : as for `read_points`. wanted : which columns to take, and in which units, where the headings do not
    say. Raises ConfigError with everything that is wrong, by line and column.
    """
    wanted = wanted or Wanted()
    read: dict[str, Columns] = {}
    sheets = _tables(Path(path), columns, (columns[0].name,), wanted)
    for title, table in sheets:
        for name, points in _materials(HeadedTable(table), columns, wanted).items():
            read[" ".join(filter(None, (title if len(sheets) > 1 else "", name)))] = points
            if others := tables.sheets_without(Path(path), [title for title, _ in sheets]):
                points.notes += (f"sheets not read: {', '.join(map(repr, others))}",)
    return read


def _materials(headed: HeadedTable, columns: Sequence[Parameter], wanted: Wanted) -> dict[str, Columns]:
    """The points of every material of one table."""
    table, headings, rows = headed.table, headed.headings, list(tables.cells(headed.table))
    if not wanted.speed and not wanted.time:
        check_record(headed, rows)
    roles, group, notes = taken = ColumnSearch(headed, rows, columns, wanted).roles()
    materials = _PointsReader(table, rows, taken).materials()
    for role in (role for role in roles if role.column.name == MU):
        own = [float(points[MU].max()) for name, points in materials.items() if role.label in ("", name)]
        headed.check_friction(role.position, max(own, default=0.0) if role.load is None else 0.0)
    if columns is AGEING_COLUMNS and not wanted.time:
        check_waiting(headed, roles, materials)
    physical = [role for role in roles if role.column.units != "1"]
    if assumed := tuple(role.column for role in physical if not role.unit):
        check_units_above(table, assumed[0])
    used = {group, *(i for role in roles for i in role.positions)}
    if len(materials) == 1:
        check_conditions(headed, rows, used, *materials.values())
    if table.left_out:
        summaries = listed([f"{cell.text!r} (line {cell.place.line})" for cell in table.left_out], "and")
        notes = (*notes, f"left out, since they are no measurements: {summaries}")
    for name, points in materials.items():
        own_roles = (role for role in roles if role.label in ("", name) or group is not None)
        points.assumed, points.notes = assumed, notes
        points.units = {role.column.name: role.unit for role in physical if role.unit}
        points.read = {role.column.name: headings[role.position].text for role in own_roles}
        points.ignored = tuple(head.text for i, head in enumerate(headings) if i not in used and head.text)
        points.above = (table.above[0][0].place.line, table.above[-1][0].place.line) if table.above else None
        if "speed" in points:
            _direct(points, headings, {row[0].place.line: row for row in rows})
    return _branches_joined(materials)


def _direct(points: Columns, headings: list[Heading], rows: Mapping[int, tuple[Cell, ...]]) -> None:
    """Put points into the order of a column of time, and add what one of directions says."""
    of_kind = {kind: [i for i, head in enumerate(headings) if head.kind == kind and not head.label]
               for kind in ("time", "direction")}  # fmt: skip
    for kind, (i, *_) in ((kind, places) for kind, places in of_kind.items() if len(places) == 1):
        texts = [rows[line][i].text for line in points.lines]
        if kind == "direction":
            if (direction := directions(texts, points["speed"])).any():
                points["direction"], points.read[kind] = direction, headings[i].text
        elif all(NUMBER.fullmatch(text.replace(",", ".")) for text in texts):
            time = np.array([float(text.replace(",", ".")) for text in texts])
            if np.unique(time).size == time.size and (np.diff(time) < 0).any():
                order = np.argsort(time)
                points.update({name: values[order] for name, values in points.items()})
                points.lines = tuple(points.lines[k] for k in order)
                points.notes += (f"points are in the order of {headings[i].text!r}",)
        points.ignored = tuple(text for text in points.ignored if text != points.read.get(kind))
    if "direction" not in points and (way := course(points["speed"])) is not None:
        points["direction"] = way


def _branches_joined(materials: dict[str, Columns]) -> dict[str, Columns]:
    """The materials of a wide table, those of one name but for `up` and `down` being branches of a sweep."""
    joined: dict[str, Columns] = {}
    parts = {name: branch_of(name) for name in materials}
    for name, points in materials.items():
        base, sign = parts[name]
        pair = [materials[key] for way in (1.0, -1.0) for key, part in parts.items() if part == (base, way)]
        if not sign or len(pair) != 2 or "speed" not in points:
            joined[name] = points
        elif (base := "" if heading(base).kind == MU else base) not in joined:
            up, down = pair
            both = Columns({key: np.concatenate([up[key], down[key]]) for key in up if key in down})
            both["direction"] = np.repeat([1.0, -1.0], [up["speed"].size, down["speed"].size])
            both.__dict__.update(up.__dict__)
            both.lines, both.notes = up.lines + down.lines, (*up.notes, f"{down.read[MU]!r} is the way down")
            joined[base] = both
    return joined


def _tables(
    path: Path, columns: Sequence[Parameter], along: tuple[str, ...], wanted: Wanted
) -> list[tuple[str, Table]]:
    """The parts of a file, or of each sheet of a workbook with such headings, by title where there are several.

    Where no line has headings that are known, the names of columns stand over the numbers.

    along : speed, time, or both, of which the table has one beside a column that may be friction. Raises ConfigError.
    """

    def may_be_headings(texts: Sequence[str]) -> bool:
        headings = [heading(text) for text in texts]
        named = [word for word in (wanted.speed, wanted.time) if word]
        over, kinds = (*along, "rotation"), ("", MU, "kinetic", "static", "friction_force")
        steps = [head.kind in over or any(map(head.is_called, named)) for head in headings]
        frictions = [
            any(map(head.is_called, wanted.friction)) or not is_step and head.text and head.kind in kinds
            for head, is_step in zip(headings, steps, strict=True)
        ]
        return not are_units(texts) and any(steps) and any(frictions)

    def are_words(texts: Sequence[str]) -> bool:
        return not any(are_units([text]) for text in texts if text)

    def read(sheet: str | None = None) -> Table:
        table = tables.read_table(path, example(columns), "points", may_be_headings, sheet)
        if may_be_headings([cell.text for cell in table.heading]):
            return table
        return tables.read_table(path, example(columns), "points", are_words, sheet)

    if not is_workbook(path):
        return [("", read())]
    titles = tables.sheets_with_tables(path, may_be_headings)
    return [(title, read(title)) for title in titles]


# --- the numbers ------------------------------------------------------------------------------------------------------


class _PointsReader:
    """Reads the numbers of the columns that have a role, and collects what is wrong with them."""

    def __init__(self, table: Table, rows: list[tuple[Cell, ...]], roles: Roles) -> None:
        self._table, self._rows, self._roles, self._group = table, rows, roles.roles, roles.group
        texts = [[cell.text for cell in row] for row in rows]
        used = [i for role in roles.roles for i in role.positions]
        self._comma = tables.has_decimal_commas(table, texts, used)
        self._thousands = {i for i in used if layout.thousands([row[i] for row in texts if i < len(row)], self._comma)}
        self._problems: list[Problem] = []

    def materials(self) -> dict[str, Columns]:
        """The points by material. Raises ConfigError with everything that is wrong."""
        along, *others = self._roles
        sigmas = {role.label: role for role in others if role.column.name != MU}
        values: dict[str, dict[str, list[float]]] = {}
        lines: dict[str, list[int]] = {}
        for row in self._rows:
            if len(self._problems) >= tables.MOST_PROBLEMS:
                break
            if len(row) != len(self._table.heading):
                self._problems.append(tables.wrong_count(self._table, row))
                continue
            group = "" if self._group is None else row[self._group].text
            group = whole[1] if (whole := WHOLE.fullmatch(group)) else group
            place = self._number(along, row)
            for mu in (role for role in others if role.column.name == MU):
                if mu.label and row[mu.position].text.lower() in GAPS:
                    continue  # of a wide table, whose materials need not be measured at the same speeds
                name = " ".join(filter(None, (group, mu.label)))
                points = values.setdefault(name, {})
                points.setdefault(along.column.name, []).append(place)
                for role in (mu, *([sigmas[mu.label]] if mu.label in sigmas else [])):
                    points.setdefault(role.column.name, []).append(self._number(role, row))
                lines.setdefault(name, []).append(row[along.position].place.line)
        if self._problems:
            raise ConfigError(self._table.name, self._problems)
        read = {name: Columns({key: np.array(column) for key, column in points.items()})
                for name, points in values.items()}  # fmt: skip
        for name, columns in read.items():
            columns.lines = tuple(lines[name])
        return read

    def _number(self, role: Role, row: Sequence[Cell]) -> float:
        """One number in SI; what is wrong with it becomes a problem."""
        cell = row[role.position]
        try:
            if role.position in self._thousands:
                raise QuantityError("a number without separators of thousands", f"write {cell.text!r} as '1234.5'")
            value = _number(cell.text, role.unit, role.column if role.load is None else _FORCE, self._comma)
            if not isinstance(role.load, tuple):
                return value if role.load is None else value / role.load
            cell = row[role.load[0]]
            return value / _number(cell.text, role.load[1], _LOAD, self._comma)
        except QuantityError as error:
            got = f"got {cell.text!r}, expected" if cell.text else "empty, expected"
            self._problems.append(Problem((role.column.name,), f"{got} {error.expected}", cell.place, error.hint))
            return 0.0


def _number(text: str, unit: str, column: Parameter, comma: bool) -> float:
    """One number in SI; comma : whether the file has decimal commas. Raises QuantityError."""
    plain = text.replace(",", ".") if comma else text
    if not NUMBER.fullmatch(plain) or layout.mixed_marks(text, comma):
        hint = layout.mixed_marks(text, comma) or None
        if layout.DECIMAL_COMMA.fullmatch(text):
            hint = f"write a decimal point, not a comma: {text.replace(',', '.')}"
        elif text.lower() in GAPS:
            hint = "leave out points that were not measured"
        raise QuantityError("a number", hint)
    if unit == "%":
        value = float(Decimal(plain) / 100)
    else:
        value = units.si_value(f"{plain} {unit}" if unit else float(plain), column.units)
    if not column.allows(value):
        raise QuantityError(column.expected)
    if value and not _SMALLEST <= value <= _LARGEST:
        raise QuantityError(f"0 or a number from {_SMALLEST:g} to {_LARGEST:g} in SI")
    return value
