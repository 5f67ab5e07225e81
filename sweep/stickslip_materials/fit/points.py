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

import re
from collections.abc import Mapping, Sequence
from decimal import Decimal
from pathlib import Path
from typing import TypeVar

import numpy as np
from numpy.typing import NDArray

from stickslip.errors import ConfigError, Problem, QuantityError
from stickslip.files import layout, tables
from stickslip.vocabulary import units
from stickslip.vocabulary.display_units import is_column_unit
from stickslip.vocabulary.parameter import Parameter
from stickslip.vocabulary.quantities import AGEING_COLUMNS, CURVE_COLUMNS, listed
from stickslip_materials.fit.columns import HeadedTable, example, titled
from stickslip_materials.fit.headings import Heading, heading
from stickslip_materials.fit.roles import GAPS, MU, WHOLE, PointsTable, Role, Wanted
from stickslip_materials.fit.turns import branch_of, course, directions
from stickslip_materials.fit.words import WAITING, plain

Content = TypeVar("Content")
_SMALLEST, _LARGEST = 1e-15, 1e15  # in SI; measurements are not beyond, and squares must stay finite
_RECORD = 8  # steps of time, of which most are alike in a record
_COURSE = re.compile(r"cycl|zykl|loop|schleife|run|lauf|repe|wiederh|pass|sweep|ramp|step|schritt|\bn[or]\b|index")
_CONDITION = 1.25  # ratio of friction by which two conditions are told from scatter


class Columns(dict[str, NDArray[np.float64]]):
    """Columns by name, in SI, row by row.

    assumed : those that were read in SI for want of a unit. units : in which the others were written, by name.
    read : headings they came from, by name. ignored : headings of columns that were left out. notes : what else was
    done with columns. above : numbers of the first and the last line above the heading that were left out. lines : of
    the file, row by row. are_synthetic : whether a remark of the file says that nobody measured them.
    """

    assumed: tuple[Parameter, ...] = ()
    units: dict[str, str] = {}
    read: dict[str, str] = {}
    ignored: tuple[str, ...] = ()
    notes: tuple[str, ...] = ()
    above: tuple[int, int] | None = None
    lines: tuple[int, ...] = ()
    are_synthetic: bool = False

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
    """As `read_materials`, the points of one material. Raises ConfigError for a table of several.

    unit : of the speeds or times, where the header does not name it; None takes SI.
    """
    return only(path, read_materials(path, columns, Wanted(unit or "")))


def only(path: str | Path, materials: Mapping[str, Content]) -> Content:
    """What there is of the material of a table of one. Raises ConfigError for one of several."""
    if len(materials) > 1:
        message = f"got {len(materials)} materials ({', '.join(materials)}), expected one"
        raise ConfigError.of(path, message, "name the column to take, or compare them")
    return next(iter(materials.values()))


def read_materials(
    path: str | Path, columns: Sequence[Parameter] | None = None, wanted: Wanted | None = None
) -> dict[str, Columns]:
    """The points of every material of a CSV or .xlsx file, by name; the name of a single unnamed one is empty.

    columns : CURVE_COLUMNS or AGEING_COLUMNS, None takes what the file has; sigma may be missing. wanted : which
    columns to take, and in which units, where the headings do not say. Of a workbook all sheets with such headings are
    read. Raises ConfigError with everything that is wrong, by line and column.
    """
    path, wanted = Path(path), wanted or Wanted()
    if columns is None:
        columns = AGEING_COLUMNS if wanted.time and not wanted.speed else CURVE_COLUMNS
        if not wanted.time and not wanted.speed:
            headings = next(iter(_tables(path, columns, ("speed", "time"), wanted).values())).headings
            has_speed = any(column.kind == "speed" or is_column_unit(column.unit, "m s-1") for column in headings)
            if not has_speed and any(column.kind == "time" for column in headings):
                columns = AGEING_COLUMNS
    sheets, materials = _tables(path, columns, (columns[0].name,), wanted), dict[str, Columns]()
    others = [repr(title) for title in tables.sheets_without(path, [*sheets])]
    for title, headed in sheets.items():
        for name, points in _materials(headed, columns, wanted).items():
            points.notes += (f"sheets not read: {', '.join(others)}",) if others else ()
            materials[" ".join(filter(None, (title if len(sheets) > 1 else "", name)))] = points
    return materials


def _tables(path: Path, columns: Sequence[Parameter], over: tuple[str, ...], wanted: Wanted) -> dict[str, HeadedTable]:
    """The table of a file, or of each sheet of a workbook with such headings, by title.

    over : speed, time, or both, of which the table has one beside a column that may be friction. Raises ConfigError.
    """
    kinds = ("", MU, "kinetic", "static", "friction_force")

    def are_headings(headings: Sequence[Heading]) -> bool:
        named = [word for word in (wanted.speed, wanted.time) if word]
        steps = [h for h in headings if h.kind in (*over, "rotation") or any(map(h.is_called, named))]
        frictions = [h for h in headings if any(map(h.is_called, wanted.friction))
                     or h not in steps and h.text and h.kind in kinds]  # fmt: skip
        return bool(steps and frictions)

    return HeadedTable.read_sheets(path, example(columns), are_headings, "points")


def _materials(headed: HeadedTable, columns: Sequence[Parameter], wanted: Wanted) -> dict[str, Columns]:
    """The points of every material of one table."""
    table = PointsTable(headed, columns, wanted)
    materials, along = _read(table), table.along
    for role in table.frictions:
        own = [float(points[MU].max()) for name, points in materials.items() if role.label in ("", name)]
        headed.check_friction(role.position, max(own, default=0.0) if role.load is None else 0.0)
    if columns is AGEING_COLUMNS and not wanted.time:
        _check_waiting(table, materials)
    if not along.unit:
        _check_units_above(table)
    if len(materials) == 1:
        _check_conditions(table, *materials.values())
    if left_out := headed.table.left_out:
        summaries = listed([f"{cell.text!r} (line {cell.place.line})" for cell in left_out], "and")
        table.notes.append(f"left out, since they are no measurements: {summaries}")
    unused = [i for i in range(len(headed.headings)) if i not in (*table.used, table.group)]
    above = [line[0].place.line for line in headed.table.above]
    for name, points in materials.items():
        own_roles = [role for role in table.roles if role.label in ("", name) or table.group is not None]
        points.notes, points.assumed = tuple(table.notes), () if along.unit else (along.row,)
        points.units = {along.name: along.unit} if along.unit else {}
        points.read = {role.name: headed.headings[role.position].text for role in own_roles}
        points.ignored = tuple(headed.headings[i].text for i in unused if headed.headings[i].text)
        points.above = (above[0], above[-1]) if above else None
        points.are_synthetic = any("synthetic" in remark.text.casefold() for remark in headed.table.remarks)
        if "speed" in points:
            _direct(points, table)
    return _branches_joined(materials)


# --- the numbers ------------------------------------------------------------------------------------------------------


def _read(table: PointsTable) -> dict[str, Columns]:
    """The points by material. Raises ConfigError with everything that is wrong."""
    import pandas as pd

    whole = table.headed.table
    problems = [tables.wrong_count(whole, row) for row in table.rows if len(row) != len(whole.heading)]
    comma = tables.has_decimal_commas(whole, table.texts.tolist(), table.used)

    def values(role: Role, inside: NDArray[np.bool_]) -> NDArray[np.float64]:
        """The numbers of some rows in SI, NaN in others."""
        column = [row[role.position] for row in table.complete]
        are_thousands = layout.thousands([cell.text for cell in column], comma)
        read = np.full(len(column), np.nan)
        for k in np.flatnonzero(inside):
            text, place = column[k]
            try:
                read[k] = _number(text, role.unit, role.row, comma, are_thousands)
            except QuantityError as error:
                got = f"got {text!r}, expected" if text else "empty, expected"
                problems.append(Problem((role.name,), f"{got} {error.expected}", place, error.hint))
        load = role.load
        return read if load is None else read / (values(load, inside) if isinstance(load, Role) else load)

    groups = [""] * len(table.complete) if table.group is None else [row[table.group].text for row in table.complete]
    groups = [match[1] if (match := WHOLE.fullmatch(group)) else group for group in groups]
    # materials of a wide table need not be measured at the same speeds
    rows = [~table.gaps[:, role.position] | (not role.label) for role in table.frictions]
    along, parts = values(table.along, np.any(rows, axis=0)), []
    for role, inside in zip(table.frictions, rows, strict=True):
        own = {
            deviation.name: values(deviation, inside) for deviation in table.deviations if deviation.label == role.label
        }
        names = [" ".join(filter(None, (group, role.label))) for group in groups]
        parts.append(pd.DataFrame({"": names, table.along.name: along, MU: values(role, inside), **own})[inside])
    if problems:
        problems = sorted(problems, key=lambda problem: problem.place or ())
        raise ConfigError(whole.name, problems[: tables.MOST_PROBLEMS])
    materials = {}
    for name, part in pd.concat(parts).sort_index(kind="stable").groupby("", sort=False):
        numbers = part.drop(columns="").dropna(axis=1)
        materials[str(name)] = Columns({str(key): numbers[key].to_numpy() for key in numbers})
        materials[str(name)].lines = tuple(table.complete[i][0].place.line for i in part.index)
    return materials


def _number(text: str, unit: str, column: Parameter, comma: bool, are_thousands: bool) -> float:
    """One number in SI; comma : whether the file has decimal commas. Raises QuantityError."""
    if are_thousands:
        raise QuantityError("a number without separators of thousands", f"write {text!r} as '1234.5'")
    pointed, mixed = text.replace(",", ".") if comma else text, layout.mixed_marks(text, comma) or None
    if not layout.NUMBER.fullmatch(pointed) or mixed:
        hint = "leave out points that were not measured" if text.lower() in GAPS else mixed
        if layout.DECIMAL_COMMA.fullmatch(text):
            hint = f"write a decimal point, not a comma: {text.replace(',', '.')}"
        raise QuantityError("a number", hint)
    if unit == "%":
        value = float(Decimal(pointed) / 100)
    else:
        value = units.si_value(f"{pointed} {unit}" if unit else float(pointed), column.units)
    if not column.allows(value):
        raise QuantityError(column.expected)
    if value and not _SMALLEST <= value <= _LARGEST:
        raise QuantityError(f"0 or a number from {_SMALLEST:g} to {_LARGEST:g} in SI")
    return value


# --- sweeps up and down -----------------------------------------------------------------------------------------------


def _direct(points: Columns, table: PointsTable) -> None:
    """Add the way of a sweep that a column of directions says, or else the order of the points."""
    heads = table.headed.headings
    places = [i for i, head in enumerate(heads) if head.kind == "direction" and not head.label]
    if len(places) == 1:
        at = np.searchsorted([row[0].place.line for row in table.complete], points.lines)
        if (way := directions(table.texts[at, places[0]].tolist(), points["speed"])).any():
            text = heads[places[0]].text
            points["direction"], points.read["direction"] = way, text
            points.ignored = tuple(other for other in points.ignored if other != text)
    if "direction" not in points and (turned := course(points["speed"])) is not None:
        points["direction"] = turned


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


# --- tables that are not the points they were taken for ---------------------------------------------------------------


def _check_waiting(table: PointsTable, materials: dict[str, Columns]) -> None:
    """Raises ConfigError for friction over the time of a record, which is no time at rest."""
    heads = table.headed.headings
    if WAITING.search(plain(heads[table.along.position].name)) or heads[table.frictions[0].position].kind == "static":
        return
    for points in materials.values():
        steps = np.diff(points["time"])
        usual = np.median(steps) if steps.size >= _RECORD else 0.0
        if points["time"].min() <= 0 or (usual > 0 and np.mean(np.abs(steps - usual) < 0.2 * usual) > 0.7):
            hint = "`stickslip points RECORD --plan PLAN` averages a record; call times at rest 'hold time [s]'"
            raise table.headed.refused(table.along.position, "hold times; this looks like a record over time", hint)


def _check_units_above(table: PointsTable) -> None:
    """Raises ConfigError where a line above the heading holds a unit that the heading lacks."""
    row = table.along.row
    for cell in (cell for line in table.headed.table.above for cell in line if is_column_unit(cell.text, row.units)):
        message = f"got the unit {cell.text!r} above the heading, expected it behind {row.name}"
        hint = f"write '{row.name} [{cell.text}]', or say --unit {cell.text}"
        raise ConfigError.of(table.headed.table.name, message, hint, place=cell.place)


def _check_conditions(table: PointsTable, points: Columns) -> None:
    """Raises ConfigError where a column that is not used tells parts of very different friction at one speed."""
    along, mu = (points[name] for name in (*points,)[:2])
    for i, head in enumerate(table.headed.headings if mu.size == len(table.texts) else ()):  # no gaps
        texts = table.texts[:, i]
        values = list(dict.fromkeys(texts))
        is_course = head.kind in ("sigma", "spread", "time", "direction") or _COURSE.search(plain(head.name))
        if i in (*table.used, table.group) or is_course or not 1 < len(values) <= mu.size / 3:
            continue
        order = np.argsort(along, kind="stable")
        x, y, parts = along[order], mu[order], texts[order]
        first, others = parts == values[0], (parts != values[0]) & (y > 0)
        shared = others & (x >= x[first].min()) & (x <= x[first].max())
        ratios = np.interp(x[shared], x[first], y[first]) / y[shared]
        if ratios.size > 2 and (ratios.min() > _CONDITION or ratios.max() < 1 / _CONDITION):
            times = float(np.median(np.maximum(ratios, 1 / ratios)))
            expected = f"one of {listed(values, 'and')}: friction at one speed differs by a factor of {times:.2g}"
            raise table.headed.refused(i, expected, "keep the rows of one, or call the column 'material'")
