"""Long tables of numbers as people's programs write them: commas or semicolons, decimal points or decimal commas.

Columns separated by commas have decimal points. Columns separated by semicolons or tabulators have either, the same in
the whole file; a file that mixes them is refused, because "1,234" might then mean thousands. Lines that are empty or
start with # hold no numbers; what such remarks say is kept.
"""

from __future__ import annotations

import math
import re
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from stickslip.csv_file import read_text
from stickslip.problems import ConfigError, Place, Problem

_SEPARATORS = {";": "semicolons", "\t": "tabulators", ",": "commas"}
_DECIMAL_COMMA = re.compile(r"[-+]?\d*,\d+(?:[eE][-+]?\d{1,3})?", re.ASCII)
_DECIMAL_POINT = re.compile(r"[-+]?\d*\.\d+(?:[eE][-+]?\d{1,3})?", re.ASCII)
_NUMBER = re.compile(r"[-+]?(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d{1,3})?", re.ASCII)
_MOST_PROBLEMS = 20  # a file in the wrong format is wrong in every line


@dataclass(frozen=True)
class Cell:
    """What stands in one cell, and where its line has it, from 1."""

    text: str
    place: Place


@dataclass(frozen=True)
class Table:
    """A file in parts, no number read yet.

    remarks : what stands behind the # of comment lines. heading : the cells of the first other line.
    lines : the rest, each with its number. separator : one of comma, semicolon and tabulator.
    """

    name: str
    remarks: tuple[Cell, ...]
    heading: tuple[Cell, ...]
    lines: tuple[tuple[int, str], ...]
    separator: str


def read_table(path: Path) -> Table:
    """The parts of a file. Raises ConfigError if it cannot be read or holds no table."""
    name = str(path)
    numbered = [(number, line) for number, line in enumerate(read_text(path).splitlines(), 1) if line.strip()]
    remarks = tuple(_remark(number, line) for number, line in numbered if _is_remark(line))
    rows = [(number, line) for number, line in numbered if not _is_remark(line)]
    if not rows:
        hint = "the first line says, for instance, 'time [ms], force [N], acceleration [m/s2]'"
        raise ConfigError(name, [Problem((), "no line names the columns", hint=hint)])
    (number, line), *rest = rows
    separator = next((mark for mark in _SEPARATORS if mark in line), ",")
    if not rest:
        raise ConfigError(name, [Problem((), "no samples, only the names of columns", Place(number, 1))])
    heading = (Cell(c.text.strip('"').strip(), c.place) for c in _cells(number, line, separator))
    return Table(name, remarks, tuple(heading), tuple(rest), separator)


def numbers(table: Table, wanted: Sequence[int]) -> dict[int, NDArray[np.float64]]:
    """The columns at the positions `wanted`, as they stand there. Raises ConfigError naming line and column."""
    width = len(table.heading)
    rows = [line.split(table.separator) for _, line in table.lines]
    comma = table.separator != "," and _has_decimal_commas(rows, wanted)
    found = {}
    try:
        if any(len(row) != width for row in rows):
            raise ValueError
        for column in wanted:
            texts = [row[column] for row in rows]
            if comma:
                if any("." in text for text in texts):
                    raise ValueError
                texts = [text.replace(",", ".") for text in texts]
            # float() also takes "1_0", "nan" and digits of other scripts
            if any("_" in text or not text.isascii() for text in texts):
                raise ValueError
            found[column] = np.array([float(text) for text in texts])
            if not np.isfinite(found[column]).all():
                raise ValueError
    except ValueError:
        raise ConfigError(table.name, _problems(table, wanted, comma)) from None
    return found


def line_of(table: Table, row: int) -> int:
    """Number of the line that holds sample `row`."""
    return table.lines[row][0]


# --- the text ---------------------------------------------------------------------------------------------------------


def _is_remark(line: str) -> bool:
    return line.lstrip().startswith("#")


def _remark(number: int, line: str) -> Cell:
    text = line.lstrip().lstrip("#")
    return Cell(text.strip(), Place(number, len(line) - len(text.lstrip()) + 1))


def _cells(number: int, line: str, separator: str) -> tuple[Cell, ...]:
    """The cells of a line, without the spaces around them."""
    found, begin = [], 0
    for part in line.split(separator):
        start = begin + len(part) - len(part.lstrip()) + 1
        found.append(Cell(part.strip(), Place(number, start)))
        begin += len(part) + 1
    return tuple(found)


# --- what is wrong ----------------------------------------------------------------------------------------------------


def _has_decimal_commas(rows: Sequence[Sequence[str]], wanted: Sequence[int]) -> bool:
    return any("," in row[column] for row in rows for column in wanted if column < len(row))


def _problems(table: Table, wanted: Sequence[int], comma: bool) -> list[Problem]:
    """Everything that keeps the table from being numbers, up to a limit."""
    problems: list[Problem] = []
    for number, line in table.lines:
        if len(problems) >= _MOST_PROBLEMS:
            break
        cells = _cells(number, line, table.separator)
        if len(cells) != len(table.heading):
            problems.append(_wrong_count(table, cells))
            continue
        for column in wanted:
            if (problem := _not_a_number(cells[column], comma, table.heading[column].text)) is not None:
                problems.append(problem)
    return problems


def _not_a_number(cell: Cell, comma: bool, heading: str) -> Problem | None:
    """What is wrong with a cell, None if it is a finite number."""
    text = cell.text
    if comma and _DECIMAL_POINT.fullmatch(text):
        hint = "the file mixes decimal commas and decimal points: write one of them throughout"
    elif comma and "." in text:
        hint = "leave out the points between thousands"
    elif _NUMBER.fullmatch(text.replace(",", ".") if comma else text) and math.isfinite(float(text.replace(",", "."))):
        return None
    elif text.lower() in ("", "nan", "na", "n/a", "-"):
        hint = "a signal has no gaps: leave the whole line out"
    elif re.fullmatch(r"\[?[^\d\s]+\d?\]?", text) and len(text) < 12:
        hint = "units stand in brackets behind the names of the columns, 'time [ms]'"
    else:
        hint = ""
    got = f"got {text!r}" if text else "empty"
    return Problem((heading,), f"{got}, expected a number", cell.place, hint or None)


def _wrong_count(table: Table, cells: Sequence[Cell]) -> Problem:
    """A line with too few or too many cells; twice as many are decimal commas."""
    wanted = len(table.heading)
    hint = None
    if table.separator == "," and len(cells) > wanted:
        hint = "commas separate these columns, so write decimal points; or separate the columns with semicolons"
    elif table.separator == "," and any(";" in cell.text or "\t" in cell.text for cell in cells):
        hint = "the line that names the columns has commas; use the same separator throughout"
    message = (
        f"got {len(cells)} value{'s' * (len(cells) != 1)}, expected {wanted}, one for each column "
        f"({_SEPARATORS[table.separator]} separate them)"
    )
    return Problem((), message, cells[min(wanted, len(cells) - 1)].place, hint)
