"""The text of tables that people hand in, whatever wrote it."""

from __future__ import annotations

import codecs
from pathlib import Path

from stickslip.errors import ConfigError, Problem
from stickslip.files.limits import LARGEST_TEXT, check_file, check_lines
from stickslip.files.mistaken import TABLES_HERE, names_in, no_table
from stickslip.files.workbooks import first_sheet

_ZIP = b"PK\3\4"  # how a workbook begins
_UTF16 = (codecs.BOM_UTF16_LE, codecs.BOM_UTF16_BE)
_BEGINNING = 1 << 20  # bytes, in which remarks and the heading lie; twice as much is read line by line


def read_text(path: Path) -> tuple[str, bytes]:
    """What a file says: its beginning, and the rest as UTF-8 with a line feed after each line; a short one has no rest.

    The file is UTF-8 or UTF-16 as its byte order mark tells, else UTF-8, else Windows-1252 or Latin-1; of a workbook
    of Excel it is the first sheet, as CSV. Raises ConfigError if it cannot be read, or is no text.
    """
    check_file(path, LARGEST_TEXT)
    if _is_workbook(path):
        return first_sheet(path), b""
    if mistaken := no_table(path):
        what = f"this is {mistaken.what}, expected a CSV file"
        raise ConfigError(str(path), [Problem((), what, hint=mistaken.hint)])
    try:
        return _halves(path, path.read_bytes())
    except FileNotFoundError:
        here = names_in(path.parent, TABLES_HERE)
        hint = f"{path.parent if path.parent != Path() else 'this folder'} holds {', '.join(here)}" if here else None
        raise ConfigError(str(path), [Problem((), "no such file", hint=hint)]) from None
    except OSError as error:
        raise ConfigError(str(path), [Problem((), f"cannot be read: {error.strerror or error}")]) from None
    except UnicodeError:
        message = "this is no text, expected a CSV file"
        raise ConfigError(str(path), [Problem((), message, hint="save the table as CSV")]) from None


def _is_workbook(path: Path) -> bool:
    """Whether this is a file of Excel, by its name and by how it begins."""
    try:
        with path.open("rb") as file:
            return path.suffix.lower() == ".xlsx" and file.read(len(_ZIP)) == _ZIP
    except OSError:  # which whoever reads it will explain
        return False


def _halves(path: Path, data: bytes) -> tuple[str, bytes]:
    """The beginning of a text and the rest. Raises ConfigError for a line without end, UnicodeError for no text."""
    if data.startswith(_ZIP) or (b"\0" in data and not data.startswith(_UTF16)):
        raise UnicodeError
    if not data.isascii():
        data = _decoded(data).encode()
    if b"\r" in data:
        data = data.replace(b"\r\n", b"\n").replace(b"\r", b"\n")
    check_lines(path, data)
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
