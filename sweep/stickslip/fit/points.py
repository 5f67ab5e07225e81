"""Measured points from CSV files.

    # felt on PC-ABS, 10 N
    speed [mm/s], mu
    0.5, 0.61
    1,   0.58

The first line that is not a comment names the columns, in any order, with their units in brackets; without a unit a
column is in SI, or in the unit the caller names. Numbers have decimal points, columns are separated by commas, empty
lines and those with # are skipped.
"""

from __future__ import annotations

import re
from collections.abc import Sequence
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from stickslip.errors import ConfigError, Place, Problem, QuantityError
from stickslip.files.tables import DECIMAL_COMMA, MOST_PROBLEMS, NUMBER, Table, cells, read_table, wrong_count
from stickslip.vocabulary import units
from stickslip.vocabulary.parameter import Parameter
from stickslip.vocabulary.words import listed, nearest

_HEADING = re.compile(r"([^\[\]()]*?)\s*(?:\[([^\[\]]*)\]|\(([^()]*)\))?")
_SMALLEST, _LARGEST = 1e-15, 1e15  # in SI; measurements are not beyond, and squares must stay finite
_PURE = ("", "1", "-")  # how people write "no unit"


class Columns(dict[str, NDArray[np.float64]]):
    """Columns by name, in SI, row by row. assumed : those that were read in SI for want of a unit."""

    assumed: tuple[Parameter, ...] = ()

    def caution(self) -> str:
        """What was assumed, in words; empty if nothing was."""
        told = []
        for column in self.assumed:
            unit, values = units.spelled(column.units), self[column.name]
            told.append(
                f"The header gives no unit of {column.name}, so the numbers were read in {unit} ({values.min():.4g} to "
                f"{values.max():.4g} {unit}): write '{_titled(column)}', or the unit they have."
            )
        return " ".join(told)


def read_points(path: str | Path, columns: Sequence[Parameter], unit: str | None = None) -> Columns:
    """The columns of a CSV file by name, in SI, row by row.

    columns : those allowed in the file, CURVE_COLUMNS or AGEING_COLUMNS; one whose default is not None may be missing,
        and then is missing in the result.
    unit : of the column that has one, speed or time, where the header does not name it; None takes SI.
    Raises ConfigError with everything that is wrong, by line and column.
    """
    table = read_table(Path(path), _example(columns), "points", ",")
    asked = _heading(table, columns, unit or "")
    problems: list[Problem] = []
    found: dict[str, list[float]] = {column.name: [] for column, _ in asked}
    for row in cells(table):
        if len(problems) >= MOST_PROBLEMS:
            break
        if len(row) != len(asked):
            problems.append(wrong_count(table, row))
            continue
        for (column, unit), (text, place) in zip(asked, row, strict=True):
            try:
                found[column.name].append(_number(text, unit, column))
            except QuantityError as error:
                message = f"got {text!r}, expected {error.expected}" if text else f"empty, expected {error.expected}"
                problems.append(Problem((column.name,), message, place, error.hint))
    if problems:
        raise ConfigError(table.name, problems)
    read = Columns({column: np.array(values) for column, values in found.items()})
    read.assumed = tuple(column for column, unit in asked if column.units != "1" and not unit)
    return read


# --- the names of the columns -----------------------------------------------------------------------------------------


def _heading(table: Table, columns: Sequence[Parameter], otherwise: str) -> list[tuple[Parameter, str]]:
    """What each column of the file is, and its unit as written; `otherwise` that of one that has none."""
    known = {column.name: column for column in columns}
    found: dict[str, tuple[Parameter, str]] = {}
    problems = []
    for text, place in table.heading:
        try:
            column, unit = _column(text, known, otherwise)
            if column.name in found:
                raise QuantityError("it once", "remove one of the two columns")
            found[column.name] = (column, unit)
        except QuantityError as error:
            problems.append(Problem((), f"got {text!r}, expected {error.expected}", place, error.hint))
    missing = [c for c in columns if c.default is None and c.name not in found]
    if missing and not problems:
        lacking = listed([f"{c.name} ({c.long_name})" for c in missing], "and")
        hint = f"the first line that is not a comment says, for instance, '{_example(columns)}'"
        problems = [Problem((), f"no column is called {lacking}", Place(table.heading[0].place.line, 1), hint)]
    if problems:
        raise ConfigError(table.name, problems)
    return list(found.values())


def _column(text: str, known: dict[str, Parameter], otherwise: str) -> tuple[Parameter, str]:
    """One name with its unit. Raises QuantityError."""
    if re.search(r"[;\t]", text):
        raise QuantityError("columns separated by commas", "save the file with commas and decimal points")
    match = _HEADING.fullmatch(text)
    word = "" if match is None else match[1].strip().lower()
    if match is None or word not in known:
        near = nearest(word, known)
        names = listed([c.name for c in known.values()])
        remedy = f"did you mean {near!r}?" if near else "the first line names the columns; remarks start with #"
        raise QuantityError(f"{names}, with the unit in brackets", remedy)
    column, unit = known[word], str(match[2] or match[3] or "").strip()
    if column.units == "1":
        if unit not in _PURE:
            raise QuantityError("no unit", f"{column.name} is a pure number")
        return column, ""
    if unit := unit or otherwise:
        try:
            units.si_value(f"1 {unit}", column.units)
        except QuantityError as error:
            hint = f"{unit} is a unit of {error.found}" if error.found else error.hint
            raise QuantityError(f"the unit of {units.kind(column.units)}", hint) from None
    return column, unit


def _example(columns: Sequence[Parameter]) -> str:
    return ", ".join(_titled(column) for column in columns if column.default is None)


def _titled(column: Parameter) -> str:
    """The name of a column with a unit that people use: ``speed [mm/s]``."""
    return f"{column.name} [{units.example(column.units).split(' ', 1)[1]}]" if column.units != "1" else column.name


# --- the numbers ------------------------------------------------------------------------------------------------------


def _number(text: str, unit: str, column: Parameter) -> float:
    """One number in SI. Raises QuantityError."""
    if not NUMBER.fullmatch(text):
        hint = None
        if DECIMAL_COMMA.fullmatch(text):
            hint = f"write a decimal point, not a comma: {text.replace(',', '.')}"
        elif text.lower() in ("", "nan", "na", "n/a", "-"):
            hint = "leave out points that were not measured"
        raise QuantityError("a number", hint)
    value = units.si_value(f"{text} {unit}", column.units) if unit else units.si_value(float(text), column.units)
    if not column.allows(value):
        raise QuantityError(column.expected)
    if value and not _SMALLEST <= value <= _LARGEST:
        raise QuantityError(f"0 or a number from {_SMALLEST:g} to {_LARGEST:g} in SI")
    return value
