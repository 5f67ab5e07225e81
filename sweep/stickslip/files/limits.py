"""How large a table of people may be: what is beyond is refused before it costs memory or minutes."""

from __future__ import annotations

import stat
from pathlib import Path

from stickslip.errors import ConfigError, Place, Problem, reason

LARGEST_TEXT = 1_000_000_000  # bytes; a record of 1e7 samples of four signals has 4e8, and takes three times as much
LARGEST_WORKBOOK = 64_000_000  # bytes as a file; a full sheet of 1,048,576 rows of four numbers has 40e6
LARGEST_UNPACKED = 256_000_000  # bytes of all parts of a workbook; such a sheet has 160e6
MOST_PACKED = 200  # how many times smaller parts may be packed; those of sheets are 5 to 20 times, of bombs 1,000
LONGEST_LINE = 100_000  # bytes
MOST_COLUMNS = 1_000  # a sheet of Excel may have 16,384, a table of materials or signals some ten
MOST_POINTS = 100_000  # lines of a table of points, which are fitted one by one; a record is averaged to points


def check_file(path: Path, largest: int) -> None:
    """Raises ConfigError for what is no file, or a larger one; what cannot be looked at is left to its reader."""
    try:
        known = path.stat()
    except (OSError, ValueError):
        return
    if not stat.S_ISREG(known.st_mode) and not stat.S_ISDIR(
        known.st_mode
    ):  # a pipe waits for ever, a device never ends
        raise _refused(path, "this is a pipe or a device, expected a file", "write what comes out of it to a file")
    if known.st_size > largest and stat.S_ISREG(known.st_mode):
        hint = "cut the record, or leave out columns"
        raise _refused(path, f"{known.st_size / 1e6:,.0f} MB, expected at most {largest / 1e6:,.0f} MB", hint)


def check_lines(path: Path, data: bytes) -> None:
    """Raises ConfigError at the first line that is longer than any of a table."""
    begins = 0
    while len(data) - begins > LONGEST_LINE:
        end = data.rfind(b"\n", begins, begins + LONGEST_LINE + 1)
        if end < 0:
            line = data.count(b"\n", 0, begins) + 1
            message = f"a line of more than {LONGEST_LINE:,} characters, expected one line for each row of the table"
            raise _refused(path, message, "save the table as CSV", Place(line, 1))
        begins = end + 1


def check_columns(path: Path, line: int, columns: int) -> None:
    """Raises ConfigError for more columns than a table may have."""
    if columns > MOST_COLUMNS:
        message = f"{columns:,} columns, expected at most {MOST_COLUMNS:,}"
        raise _refused(path, message, "leave out the columns that are no measurement", Place(line, 1))


def check_points(name: str, rows: int) -> None:
    """Raises ConfigError for more points than are fitted."""
    if rows > MOST_POINTS:
        message = f"more than {MOST_POINTS:,} points, expected fewer"
        raise _refused(Path(name), message, "`stickslip points` averages the steps of a record to points")


def check_parts(path: Path) -> None:
    """Raises ConfigError for a workbook whose parts would not fit, as its own table of contents tells."""
    from zipfile import BadZipFile, ZipFile

    check_file(path, LARGEST_WORKBOOK)
    try:
        with ZipFile(path) as archive:
            unpacked, packed = (sum(getattr(one, of) for one in archive.infolist()) for of in _SIZES)
    except (OSError, BadZipFile, NotImplementedError) as error:
        message, hint = f"this is an Excel workbook that cannot be read ({reason(error)})", "save the sheet as CSV"
        raise _refused(path, message, hint) from None
    if unpacked > LARGEST_UNPACKED or unpacked > max(MOST_PACKED * packed, 10_000_000):
        message = f"a workbook of {unpacked / 1e6:,.0f} MB, packed into {packed / 1e6:,.2f} MB"
        limits = f"at most {LARGEST_UNPACKED / 1e6:,.0f} MB, packed to no less than a {MOST_PACKED}th"
        raise _refused(path, f"{message}, expected {limits}", "save the sheet as CSV")


_SIZES = ("file_size", "compress_size")


def _refused(path: Path, message: str, hint: str, place: Place | None = None) -> ConfigError:
    return ConfigError(str(path), [Problem((), message, place, hint)])
