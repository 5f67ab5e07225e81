"""The text of tables that people hand in, whatever wrote it: text files, sheets of workbooks of Excel.

What is too large is refused before it costs memory or minutes. Texts that a spreadsheet would run as formulas when it
opens a table are made inert, and read back: what counts as such is the list of OWASP on CSV injection, a text that
begins with = + - @, also in their wide forms, or with a tab or the end of a line. A program that splits at another
separator sees the text behind it as a cell as well.

Long tables come in blocks of lines, of which plain ones, numbers and separators alone, are read by pandas. Whatever
might be read otherwise than line by line is not: quotation marks, remarks, empty lines, other characters than ASCII,
lines of another number of cells. Numbers are the nearest doubles, as Python reads them.
"""

import codecs
import csv
import re
import stat
import warnings
from collections.abc import Iterator, Sequence
from functools import lru_cache
from importlib import import_module
from io import BytesIO, StringIO
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from stickslip.errors import ConfigError, Place, reason
from stickslip.files.locations import TABLES, wrong_file_type

LARGEST_TEXT = 1_000_000_000  # bytes; a record of 1e7 samples of four signals has 4e8, and takes three times as much
LARGEST_WORKBOOK = 64_000_000  # bytes as a file; a full sheet of 1,048,576 rows of four numbers has 40e6
LONGEST_LINE = 100_000  # bytes
MOST_COLUMNS = 1_000  # a sheet of Excel may have 16,384, a table of materials or signals some ten
MOST_POINTS = 100_000  # lines of a table of points, which are fitted one by one; a record is averaged to points
_BLOCK = 8 << 20  # bytes, more than the longest line has
_DIGITS = b"0123456789+-.,;eE \t\n"
_LETTERS = bytes(set(range(32, 127)) - set(b'"#'))
_LINE, _COMMA_MARK = ord("\n"), ","
_ZIP = b"PK\3\4"  # how a workbook begins
_UTF16 = (codecs.BOM_UTF16_LE, codecs.BOM_UTF16_BE)
_BEGINNING = 1 << 20  # bytes, in which remarks and the heading lie; twice as much is read line by line
_NO_NUMBER = ("#DIV/0!", "#N/A", "#NAME?", "#NULL!", "#NUM!", "#REF!", "#VALUE!")  # what formulas end in
_STARTS = r"[ ]*[=+\-@＝＋－＠\t\r\n]"  # noqa: RUF001 (the wide forms)
_LIVE = re.compile(rf"^(?='*{_STARTS})|(?<=[;,\t])(?='*[ ]*[=@])")
_INERT = re.compile(rf"^'(?='*{_STARTS})|(?<=[;,\t])'(?='*[ ]*[=@])")


def read_text(path: Path) -> tuple[str, bytes]:
    """The beginning of a file, and its rest as UTF-8 with a line feed after each line; a short one has no rest.

    The file is UTF-8 or UTF-16 as its byte order mark tells, else UTF-8, else Windows-1252 or Latin-1. Raises
    ConfigError if it cannot be read, or is no text.
    """
    check_file(path, LARGEST_TEXT)
    if kind := wrong_file_type(path, TABLES):
        raise ConfigError.of(path, f"this is {kind[0]}, expected a CSV file", kind[1])
    try:
        return _plain(path, path.read_bytes())
    except FileNotFoundError:
        raise ConfigError.of(path, "no such file") from None
    except OSError as error:
        raise ConfigError.of(path, f"cannot be read: {error.strerror or error}") from None
    except UnicodeError:
        raise ConfigError.of(path, "this is no text, expected a CSV file", "save the table as CSV") from None


def is_workbook(path: Path) -> bool:
    """Recognize a file of Excel, by its name and by how it begins."""
    if path.suffix.lower() != ".xlsx":  # of which a pipe would wait to be opened
        return False
    try:
        with path.open("rb") as file:
            return file.read(len(_ZIP)) == _ZIP
    except OSError:  # which whoever reads it will explain
        return False


def _plain(path: Path, data: bytes) -> tuple[str, bytes]:
    """A text in two halves. Raises ConfigError for a line without end, UnicodeError for no text."""
    if data.startswith(_ZIP) or (b"\0" in data and not data.startswith(_UTF16)):
        raise UnicodeError
    if not data.isascii():
        data = _decoded(data).encode()
    if b"\r" in data:
        data = data.replace(b"\r\n", b"\n").replace(b"\r", b"\n")
    check_lines(path, data)
    return halves(data)


def halves(data: bytes) -> tuple[str, bytes]:
    """The beginning of UTF-8 and its rest, in whole lines; what is short has no rest."""
    cut = len(data) if len(data) <= 2 * _BEGINNING else data.rfind(b"\n", 0, _BEGINNING) + 1
    return data[:cut].decode(), data[cut:]


def _decoded(data: bytes) -> str:
    """Bytes as text. Raises UnicodeError for what is none."""
    if data.startswith(_UTF16):  # Excel's "Unicode text"
        return data.decode("utf-16")
    for encoding in ("utf-8-sig", "cp1252"):
        try:
            return data.decode(encoding)
        except UnicodeDecodeError:
            pass
    return data.decode("latin-1")  # which knows every byte


# --- blocks -----------------------------------------------------------------------------------------------------------


def blocks(rest: bytes, begins: int) -> Iterator[tuple[int, bytes]]:
    """A text in blocks of whole lines, each with the number of its first one; `begins` is that of the text."""
    start = 0
    while start < len(rest):
        end = len(rest) if len(rest) - start <= _BLOCK else rest.rfind(b"\n", start, start + _BLOCK) + 1
        yield begins, (block := rest[start:end])
        begins, start = begins + block.count(b"\n"), end


def plain_numbers(
    block: bytes, separator: str, width: int, columns: Sequence[int], comma: bool
) -> NDArray[np.float64] | None:
    """The columns at the positions `columns` of a block, (columns, lines); None if it is not plain, or no numbers.

    comma : whether they have decimal commas.
    """
    other = block.translate(None, _DIGITS)
    if other.translate(None, _LETTERS) or not _has_cells(block, separator, width):
        return None
    import pandas as pd

    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", DeprecationWarning)  # pandas 3 reads so without being told to
            frame = pd.read_csv(
                BytesIO(block), sep=separator, header=None, names=range(width), usecols=sorted(set(columns)),
                index_col=False, dtype=np.float64, na_filter=False, decimal=_COMMA_MARK if comma else ".",
                skip_blank_lines=False, engine="c", float_precision="round_trip",
            )  # fmt: skip
    except ValueError:  # also those of pandas
        return None
    array = np.stack([frame[column].to_numpy() for column in columns])
    if not np.isfinite(array).all():
        return None
    is_logical = other and ((array == 0) | (array == 1)).all(axis=1).any()  # pandas takes a column of "true" as ones
    return None if is_logical else array


def _has_cells(block: bytes, separator: str, width: int) -> bool:
    """Tell whether every line has so many cells."""
    text = np.frombuffer(block, np.uint8)
    ends = np.flatnonzero(text == _LINE)
    if not ends.size or ends[-1] != text.size - 1:
        ends = np.append(ends, text.size)
    before = np.searchsorted(np.flatnonzero(text == ord(separator)), ends)
    return bool((np.diff(before, prepend=0) == width - 1).all()) and (width > 1 or bool((np.diff(ends) > 1).all()))


# --- workbooks --------------------------------------------------------------------------------------------------------


def read_sheets(path: Path) -> dict[str, str]:
    """The visible sheets that hold something, by title, as text: columns separated by semicolons, a line for each row.

    Raises ConfigError.
    """
    known = path.stat()
    return _read_sheets(path, known.st_mtime_ns, known.st_size)


@lru_cache(maxsize=4)
def _read_sheets(path: Path, *_: int) -> dict[str, str]:
    check_file(path, LARGEST_WORKBOOK)
    sheets = {}
    try:
        openpyxl = import_module("openpyxl")  # of the extra "excel"
        book = openpyxl.load_workbook(path, read_only=True, data_only=True, keep_links=False)
        try:
            for sheet in book.worksheets:
                text = StringIO()
                if sheet.sheet_state == "visible":
                    csv.writer(text, delimiter=";", lineterminator="\n").writerows(_rows(path, sheet))
                if text.getvalue().strip(";\n"):
                    sheets[sheet.title] = text.getvalue()
        finally:
            book.close()
    except ConfigError:
        raise
    except ImportError:
        hint = 'pip install "stickslip[excel]", or save the sheet as CSV'
        raise ConfigError.of(path, "this is an Excel workbook, which needs openpyxl", hint) from None
    except Exception as error:  # a damaged archive can make these libraries raise whatever there is
        raise _damaged_workbook(path, error) from None
    return sheets or {"": ""}


def _rows(path: Path, sheet: Any) -> Iterator[list[Any]]:
    """The cells of each row up to its last that holds something. Raises ConfigError for too many of them."""
    sheet.reset_dimensions()  # which a file may tell wrongly
    for number, row in enumerate(sheet.iter_rows(values_only=True), 1):
        width = next((i for i in range(len(row), 0, -1) if row[i - 1] not in (None, "")), 0)
        check_columns(path, number, width)
        yield [_written(value) for value in row[:width]]


def _written(value: Any) -> Any:
    """A cell as CSV has it: whole numbers without a point, gaps where a formula has no value."""
    if isinstance(value, float) and value.is_integer() and abs(value) < 1e15:
        return int(value)
    return "nan" if value in _NO_NUMBER else value


# --- limits -----------------------------------------------------------------------------------------------------------


def check_file(path: Path, largest: int) -> None:
    """Raises ConfigError for what is no file, or a larger one; what cannot be looked at is left to its reader."""
    try:
        known = path.stat()
    except (OSError, ValueError):
        return
    is_file = stat.S_ISREG(known.st_mode)
    if not is_file and not stat.S_ISDIR(known.st_mode):  # a pipe waits for ever, a device never ends
        raise ConfigError.of(path, "this is a pipe or a device, expected a file", "write its output to a file")
    if known.st_size > largest and is_file:
        hint = "cut the record, or leave out columns"
        raise ConfigError.of(path, f"{known.st_size / 1e6:,.0f} MB, expected at most {largest / 1e6:,.0f} MB", hint)


def check_lines(path: Path, data: bytes) -> None:
    """Raises ConfigError at the first line that is longer than any of a table."""
    begins = 0
    while len(data) - begins > LONGEST_LINE:
        end = data.rfind(b"\n", begins, begins + LONGEST_LINE + 1)
        if end < 0:
            line = data.count(b"\n", 0, begins) + 1
            message = f"a line of more than {LONGEST_LINE:,} characters, expected one line for each row of the table"
            raise ConfigError.of(path, message, "save the table as CSV", place=Place(line, 1))
        begins = end + 1


def check_columns(path: Path | str, line: int, columns: int) -> None:
    """Raises ConfigError for more columns than a table may have."""
    if columns > MOST_COLUMNS:
        message = f"{columns:,} columns, expected at most {MOST_COLUMNS:,}"
        raise ConfigError.of(path, message, "leave out the columns that are no measurement", place=Place(line, 1))


def check_points(name: str, rows: int) -> None:
    """Raises ConfigError for more points than are fitted."""
    if rows > MOST_POINTS:
        message = f"more than {MOST_POINTS:,} points, expected fewer"
        raise ConfigError.of(name, message, "`stickslip points` averages the steps of a record to points")


def _damaged_workbook(path: Path, error: Exception) -> ConfigError:
    return ConfigError.of(path, f"an Excel workbook that cannot be read ({reason(error)})", "save the sheet as CSV")


# --- formulas ---------------------------------------------------------------------------------------------------------


def is_live(text: str) -> bool:
    """Tell whether a spreadsheet may take a text for a formula. A number is a number."""
    return bool(_LIVE.search(text)) and not _is_number(text)


def inert(text: str) -> str:
    """The text as a cell of CSV that is no formula: with an apostrophe in front, which Excel shows and `as_written`
    takes away."""
    return _LIVE.sub("'", text) if is_live(text) else text


def as_written(text: str) -> str:
    """The text that `inert` was given."""
    return _INERT.sub("", text) if "'" in text else text


def _is_number(text: str) -> bool:
    try:
        float(text.replace(",", "."))
    except ValueError:
        return False
    return text == text.strip()
