"""The text of CSV files that people hand in: measured points, records of a rig."""

from __future__ import annotations

from pathlib import Path

from .problems import ConfigError, Problem


def read_text(path: Path) -> str:
    """What a file says, as UTF-8 with or without a byte order mark. Raises ConfigError if it cannot be read so."""
    try:
        return path.read_bytes().decode("utf-8-sig")
    except FileNotFoundError:
        raise ConfigError(str(path), [Problem((), "no such file")]) from None
    except IsADirectoryError:
        raise ConfigError(str(path), [Problem((), "this is a folder, expected a CSV file")]) from None
    except OSError as error:
        raise ConfigError(str(path), [Problem((), f"cannot be read: {error.strerror or error}")]) from None
    except UnicodeDecodeError as error:
        message = f"byte 0x{error.object[error.start]:02x} is not UTF-8 text"
        raise ConfigError(str(path), [Problem((), message, hint="save the file as CSV in UTF-8")]) from None
