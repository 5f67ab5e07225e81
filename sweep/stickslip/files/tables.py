"""The reader of all CSV files that people hand in: measured points, and records of a rig, which are long.

Columns separated by commas have decimal points; those separated by semicolons or tabs have either, the same in all of
the file: one that mixes them is refused, because "1,234" might mean thousands. Empty lines and those that begin with #
hold no numbers; such remarks are kept, as are lines above the heading. A first line `sep=;` names the separator.

Records have ten million lines: what lies below their beginning stays bytes, of which `texts.py` reads blocks of plain
numbers by pandas; any other block, and all that is wrong, is read line by line.
"""

import csv
import math
import re
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass, replace
from itertools import chain, islice, pairwise
from pathlib import Path
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from stickslip.errors import ConfigError, Place, Problem
from stickslip.files import layout
from stickslip.files.texts import (
    as_written,
    blocks,
    check_columns,
    check_points,
    halves,
    is_workbook,
    plain_numbers,
    read_sheets,
    read_text,
)  # fmt: skip

_SEPARATOR_LINE = re.compile(r'"?sep=([;,\t])"?', re.IGNORECASE)
MOST_PROBLEMS = 20  # a file in the wrong format is wrong in every line


class TextCell(NamedTuple):
    """The content of one cell, and its column in the line, from 1."""

    text: str
    place: Place


@dataclass(frozen=True)
class TextTable:
    """A file in parts, no number read yet.

    remarks : the text after the # of comment lines. heading : the cells of the first other line.
    lines : the rest, each with its number. separator : one of comma, semicolon and tab. above : lines before the
    heading that are no remarks, cell by cell.
    left_out : rows of means, extremes and the like, by label and line. title : of the sheet of a workbook.
    rest, begins : of a long file, what follows `lines` as bytes, and the number of its first line.
    block : of several in a file, what the first line above the names calls it, or its number.
    """

    name: str
    remarks: tuple[TextCell, ...]
    heading: tuple[TextCell, ...]
    lines: tuple[tuple[int, str], ...]
    separator: str
    above: tuple[tuple[TextCell, ...], ...] = ()
    rest: bytes = b""
    begins: int = 0
    left_out: tuple[TextCell, ...] = ()
    block: str = ""


def sheets_with_tables(path: Path, is_heading: Callable[[Sequence[str]], bool]) -> list[str]:
    """The visible sheets of a workbook in which such a line stands over numbers; all, where there is none."""
    texts = read_sheets(path)
    good = [title for title, text in texts.items() if _holds_table(text, is_heading)]
    return good or [*texts]


def sheets_without(path: Path, titles: Sequence[str]) -> list[str]:
    """The other visible sheets of a workbook that hold something; none of any other file."""
    return [title for title in read_sheets(path) if title not in titles] if is_workbook(path) else []


def _holds_table(text: str, is_heading: Callable[[Sequence[str]], bool]) -> bool:
    lines = [line for line in text.splitlines() if line.strip(" ;") and not layout.is_remark(line)]
    at, mark = layout.heading_at(lines[: layout.MOST_ABOVE], ";", is_heading) if lines else (0, ";")
    return bool(lines) and is_heading(layout.plain_cells(lines[at], mark))


def read_table(
    path: Path, example: str, rows_are: str = "samples", is_heading: Callable[[Sequence[str]], bool] | None = None,
    sheet: str | None = None,
) -> TextTable:  # fmt: skip
    """The parts of a file. Raises ConfigError if it cannot be read, holds no table, or one below another.

    example : of the line that names the columns. rows_are : what the other lines are, for messages. is_heading :
    whether cells may be the names of the columns; the first such line over numbers is, else the first of several cells.
    sheet : of a workbook; without it the only one that holds a table.
    """
    return read_blocks(path, example, rows_are, is_heading, sheet, several=False)[0]


def read_blocks(
    path: Path, example: str, rows_are: str = "samples", is_heading: Callable[[Sequence[str]], bool] | None = None,
    sheet: str | None = None, *, several: bool = True,
) -> list[TextTable]:  # fmt: skip
    """The tables of a file in which the names of the columns come again, as instruments write a step each. Lines above
    the first that others do not have, of a title or the load, are those of all. See `read_table`.

    several : whether there may be more than one.
    """
    name = str(path)
    if is_workbook(path):
        titles = sheets_with_tables(path, is_heading or (lambda texts: len(texts) > 1)) if sheet is None else [sheet]
        if len(titles) > 1:
            raise ConfigError.of(name, f"got tables in the sheets {', '.join(map(repr, titles))}, expected one",
                                 "save the sheet that is meant as CSV")  # fmt: skip
        text, below = read_sheets(path)[titles[0]], b""
    else:
        text, below = layout.separated(*read_text(path))
    table = _table(name, text, below, (example, rows_are), is_heading)
    names = [cell.text for cell in table.heading]
    tables = [_table(name, *halves(block), (example, rows_are), names.__eq__, begins, table.separator)
              for begins, block in _blocks(text, below, table)]  # fmt: skip
    if tables and not several:
        message = "the names of the columns come again: one table behind another, as of a step each"
        place = tables[1].heading[0].place._replace(column=1)
        raise ConfigError.of(name, message, "save each as a file, or leave one heading", place=place)
    return _with_top(tables) if tables else [table]


def _blocks(text: str, below: bytes, table: TextTable) -> Iterator[tuple[int, bytes]]:
    """The parts of a file from the lines above each heading to those above the next, and the number of their first."""
    lines = text.splitlines(keepends=True)
    number = table.heading[0].place.line
    line = lines[number - 1].strip()
    if layout.is_remark(line) or line not in "".join(lines[number:]) and line.encode() not in below:
        return
    data, end = text.encode() + below, len("".join(lines[:number]).encode())
    cuts, again = [0], re.compile(rb"^[^\S\n]*" + re.escape(line.encode()) + rb"[^\S\n]*$", re.MULTILINE)
    for found in again.finditer(data, end):
        start = found.start()
        while start > end:
            before = data.rfind(b"\n", 0, start - 1) + 1
            if layout.is_row(data[before:start].decode(), table.separator):
                break
            start = before
        cuts.append(start)
        end = found.end()
    begins = 1
    for start, end in pairwise([*cuts, len(data)]):
        yield begins, data[start:end]
        begins += data.count(b"\n", start, end)


def _with_top(tables: Sequence[TextTable]) -> list[TextTable]:
    """Blocks with names, and with the lines above the first that others have no counterpart of: they tell of all."""
    remarks = [[cell for cell in t.remarks if cell.place.line < t.heading[0].place.line] for t in tables]
    own, own_remarks = min(len(t.above) for t in tables[1:]), min(map(len, remarks[1:]))
    top, top_remarks = tables[0].above[: -own or None], tuple(remarks[0][: -own_remarks or None])
    names = [" ".join(cell.text for cell in t.above[-own]) if 0 < own <= len(t.above) else "" for t in tables]
    names = names if len({*names}) == len(names) else [f"step {i}" for i in range(1, len(names) + 1)]
    others = [replace(t, above=top + t.above, remarks=top_remarks + t.remarks) for t in tables[1:]]
    return [replace(table, block=name) for table, name in zip([tables[0], *others], names, strict=True)]


def _table(
    name: str, text: str, below: bytes, words: tuple[str, str], is_heading: Callable[[Sequence[str]], bool] | None,
    begins: int = 1, separator: str = "",
) -> TextTable:  # fmt: skip
    """The parts of a text, whose first line has the number `begins`. words : `example` and `rows_are`."""
    example, rows_are = words
    numbered = [(number, line) for number, line in layout.whole_lines(text, begins) if line.strip(" ;,\t")]
    declared = _SEPARATOR_LINE.fullmatch(numbered[0][1]) if numbered else None
    numbered = numbered[1:] if declared else numbered
    remarks = tuple(_remark(number, line) for number, line in numbered if layout.is_remark(line))
    rows = [(number, line) for number, line in numbered if not layout.is_remark(line)]
    if not rows:
        hint = f"the first line that is not a comment says, for instance, '{example}'"
        raise ConfigError.of(name, "no line names the columns", hint)
    marks = declared[1] if declared else separator
    at, separator = layout.heading_at([line for _, line in rows[: layout.MOST_ABOVE]], marks, is_heading)
    (number, line), rest = rows[at], rows[at + 1 :]
    first = layout.plain_cells(line, separator)
    if all(map(layout.is_number, first)):  # NumPy writes the names as a remark
        above = (cell for cell in remarks if cell.place.line < number)
        named = [cell for cell in above if len(layout.plain_cells(cell.text, separator)) == len(first) > 1]
        if named:
            (line, (number, *_)), rest = named[-1], rows[at:]
            remarks = tuple(cell for cell in remarks if cell is not named[-1])
    heading = _cells(name, number, line, separator)
    while len(heading) > 1 and not heading[-1].text:
        heading = heading[:-1]
    lines = tuple(layout.rows_within(rest, separator, len(heading)))
    summaries = [(number, label) for number, line in lines if (label := layout.summary(line, separator))]
    lines = tuple(row for row in lines if row[0] not in dict(summaries))
    if not lines and not below:
        raise ConfigError.of(name, f"no {rows_are}, only the names of columns", place=Place(number, 1))
    check_columns(name, number, len(heading))
    begins += len(text.splitlines())
    remarks += tuple(_remarks(below, begins))
    lines_above = tuple(  # need not be proper CSV
        tuple(TextCell(text, Place(number, 1)) for text in layout.plain_cells(line, separator))
        for number, line in rows[:at]
    )
    left_out = tuple(TextCell(label, Place(number, 1)) for number, label in summaries)
    return TextTable(name, remarks, heading, lines, separator, lines_above, below, begins, left_out)


def numbers(
    table: TextTable, columns: Sequence[int], progress: Callable[[int, int], None] | None = None
) -> dict[int, NDArray[np.float64]]:
    """The columns at the positions `columns`, unconverted. Raises ConfigError naming line and column.

    progress : called with how many bytes of a long table are read, and how many there are.
    """
    for comma in (False, True) if table.separator != "," else (False,):
        parts = []
        for done, values in _parts_of(table, columns, comma):
            if values is None:
                break
            parts.append(values)
            if progress is not None and table.rest:
                progress(done, len(table.rest))
        else:
            return dict(zip(columns, np.concatenate(parts, axis=1), strict=True))
    rows = (_texts(table, number, line) for number, line in (_lines(table) if b"," in table.rest else table.lines))
    raise ConfigError(table.name, _problems(table, columns, has_decimal_commas(table, rows, columns)))


def _parts_of(
    table: TextTable, columns: Sequence[int], comma: bool
) -> Iterator[tuple[int, NDArray[np.float64] | None]]:
    """The columns part by part, (columns, lines), each with the bytes read by then; None where some are no numbers."""
    yield 0, _numbers(table, table.lines, columns, comma)
    done = 0
    for begins, block in blocks(table.rest, table.begins):
        array = plain_numbers(block, table.separator, len(table.heading), columns, comma)
        done += len(block)
        yield done, _numbers(table, [*_rows(table, block, begins)], columns, comma) if array is None else array


def _numbers(
    table: TextTable, lines: Sequence[tuple[int, str]], columns: Sequence[int], comma: bool
) -> NDArray[np.float64] | None:
    """The columns of some lines, (columns, lines); None if they are not all numbers. Raises ConfigError for no CSV."""
    rows = [_texts(table, number, line) for number, line in lines]
    if any(len(row) != len(table.heading) for row in rows):
        return None
    texts = [[row[column].strip() for row in rows] for column in columns]
    if comma and any("." in text for column in texts for text in column):
        return None
    texts = [[text.replace(",", ".") if comma else text for text in column] for column in texts]
    if not all(layout.NUMBER.fullmatch(text) for column in texts for text in column):
        return None
    array = np.array([[float(text) for text in column] for column in texts]).reshape(len(columns), len(rows))
    return array if np.isfinite(array).all() else None


def first_cells(table: TextTable) -> tuple[TextCell, ...]:
    """The cells of the first line below the heading. Raises ConfigError where it is not CSV."""
    return _cells(table.name, *table.lines[0], table.separator)


def cells(table: TextTable) -> Iterator[tuple[TextCell, ...]]:
    """The cells below the heading, line by line, as texts. Raises ConfigError where a line is not CSV, and for more
    lines than points are fitted."""
    check_points(table.name, len(table.lines) + table.rest.count(b"\n"))
    for number, line in _lines(table):
        yield _cells(table.name, number, line, table.separator)


def _lines(table: TextTable) -> Iterator[tuple[int, str]]:
    """All lines below the heading that hold something, each with its number."""
    yield from table.lines
    for begins, block in blocks(table.rest, table.begins):
        yield from _rows(table, block, begins)


def _rows(table: TextTable, block: bytes, begins: int) -> Iterator[tuple[int, str]]:
    """Those of a block."""
    every = enumerate(block.decode().split("\n"), begins)
    rows = ((number, line) for number, line in every if line.strip() and not layout.is_remark(line))
    return layout.rows_within(rows, table.separator, len(table.heading))


def _texts(table: TextTable, number: int, line: str) -> list[str]:
    """The cells of a line, quickly: records have a million lines."""
    if '"' not in line:
        return line.split(table.separator)
    return [cell.text for cell in _cells(table.name, number, line, table.separator)]


def line_of(table: TextTable, row: int) -> int:
    """Number of the line that holds sample `row`."""
    return next(islice(_lines(table), row, None))[0]


# --- the text ---------------------------------------------------------------------------------------------------------


def _remarks(rest: bytes, begins: int) -> Iterator[TextCell]:
    """The remarks in what follows the beginning of a file."""
    start, mark = 0, rest.find(b"#")
    while mark >= 0:
        line = rest.rfind(b"\n", start, mark) + 1 or start
        begins, start = begins + rest.count(b"\n", start, line), line
        end = rest.find(b"\n", mark) % (len(rest) + 1)
        if not rest[start:mark].strip():
            yield _remark(begins, rest[start:end].decode())
        mark = rest.find(b"#", end)


def _remark(number: int, line: str) -> TextCell:
    text = line.lstrip().lstrip("#%")
    return TextCell(text.strip(), Place(number, len(line) - len(text.lstrip()) + 1))


def _cells(name: str, number: int, line: str, separator: str) -> tuple[TextCell, ...]:
    """The cells of a line, without quotation marks and the spaces around them. Raises ConfigError."""
    parts = list(layout.cells_of(line, separator))
    texts = [line[begin:end].strip() for begin, end in parts]
    if '"' in line:
        try:
            (read,) = csv.reader([line], delimiter=separator, strict=True, skipinitialspace=True)
        except (csv.Error, ValueError) as error:
            raise ConfigError.of(name, f"not CSV: {error}", place=Place(number, 1)) from None
        if len(read) != len(parts):
            place = Place(number, line.index('"') + 1)
            raise ConfigError.of(name, "not CSV: a quotation mark inside a cell", place=place)
        texts = [text.strip() for text in read]
    texts = [as_written(text) for text in texts]
    starts = [begin + len(line[begin:end]) - len(line[begin:end].lstrip()) + 1 for begin, end in parts]
    return tuple(TextCell(text, Place(number, start)) for text, start in zip(texts, starts, strict=True))


# --- what is wrong ----------------------------------------------------------------------------------------------------


def has_decimal_commas(table: TextTable, rows: Iterable[Sequence[str]], columns: Sequence[int]) -> bool:
    """Tell whether numbers are written with commas in the columns `columns` of the cells in `rows`."""
    return table.separator != "," and any("," in row[column] for row in rows for column in columns if column < len(row))


def _problems(table: TextTable, columns: Sequence[int], comma: bool) -> list[Problem]:
    """Everything that keeps the table from being numbers, up to a limit."""
    problems: list[Problem] = []
    unread = (
        _rows(table, block, begins)
        for begins, block in blocks(table.rest, table.begins)
        if plain_numbers(block, table.separator, len(table.heading), columns, comma) is None
    )
    for number, line in chain(table.lines, chain.from_iterable(unread)):
        if len(problems) >= MOST_PROBLEMS:
            break
        row = _cells(table.name, number, line, table.separator)
        if len(row) != len(table.heading):
            problems.append(wrong_count(table, row))
            continue
        for column in columns:
            if (problem := _not_a_number(row[column], comma, table.heading[column].text)) is not None:
                problems.append(problem)
    return problems


def _not_a_number(cell: TextCell, comma: bool, heading: str) -> Problem | None:
    """The problem of a cell, None if it is a finite number."""
    text = cell.text
    is_number = layout.NUMBER.fullmatch(text.replace(",", ".") if comma else text)
    if hint := layout.mixed_marks(text, comma):
        pass
    elif is_number and math.isfinite(float(text.replace(",", "."))):
        return None
    elif text.lower() in ("", "nan", "na", "n/a", "-"):
        hint = "a signal has no gaps: leave the whole line out"
    elif re.fullmatch(r"\[?[^\d\s]+\d?\]?", text) and len(text) < 12:
        hint = "units go in brackets after the names of the columns, 'time [ms]'"
    got = f"got {text!r}" if text else "empty"
    return Problem((heading,), f"{got}, expected a number", cell.place, hint or None)


def wrong_count(table: TextTable, cells: Sequence[TextCell]) -> Problem:
    """A line with too few or too many cells; twice as many are decimal commas."""
    columns = len(table.heading)
    hint = None
    if table.separator == "," and len(cells) > columns:
        hint = "commas separate these columns, so write decimal points, not commas"
        hint += "; or separate the columns with semicolons"
    elif table.separator == "," and any(";" in cell.text or "\t" in cell.text for cell in cells):
        hint = "the line that names the columns has commas; use the same separator throughout"
    message = (
        f"got {len(cells)} value{'s' * (len(cells) != 1)}, expected {columns}, one for each column "
        f"({layout.SEPARATORS[table.separator]} separate them)"
    )
    return Problem((), message, cells[min(columns, len(cells) - 1)].place, hint)
