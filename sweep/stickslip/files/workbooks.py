"""The first sheet of a workbook of Excel, row by row, so that a stray cell costs nothing."""

from __future__ import annotations

import csv
from collections.abc import Iterator
from importlib import import_module
from io import StringIO
from pathlib import Path
from typing import Any

from stickslip.errors import ConfigError, Problem, reason
from stickslip.files.limits import check_columns, check_parts

_NO_NUMBER = ("#DIV/0!", "#N/A", "#NAME?", "#NULL!", "#NUM!", "#REF!", "#VALUE!")  # what formulas end in


def first_sheet(path: Path) -> str:
    """The first sheet as text, columns separated by semicolons, a line for each row. Raises ConfigError."""
    check_parts(path)
    text = StringIO()
    writer = csv.writer(text, delimiter=";", lineterminator="\n")
    try:
        openpyxl = import_module("openpyxl")  # of the extra "excel"
        book = openpyxl.load_workbook(path, read_only=True, data_only=True, keep_links=False)
        try:
            for cells in _rows(path, book.worksheets[0]):
                writer.writerow(cells)
        finally:
            book.close()
    except ConfigError:
        raise
    except ImportError:
        message = "this is an Excel workbook, which needs openpyxl"
        hint = 'pip install "stickslip[excel]", or save the sheet as CSV'
        raise ConfigError(str(path), [Problem((), message, hint=hint)]) from None
    except Exception as error:  # a damaged archive can make these libraries raise whatever there is
        message, hint = f"this is an Excel workbook that cannot be read ({reason(error)})", "save the sheet as CSV"
        raise ConfigError(str(path), [Problem((), message, hint=hint)]) from None
    return text.getvalue()


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
