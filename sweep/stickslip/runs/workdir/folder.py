"""Folders that hold a working store: on this machine, or behind any URL that fsspec opens.

A name is written whole or not at all, and survives a power failure once `write` returns. Whatever the system complains
about comes out as a StoreError with path, reason and remedy; a name that is not there as FileNotFoundError.
"""

from __future__ import annotations

import errno
import os
import uuid
from collections.abc import Callable
from contextlib import suppress
from pathlib import Path
from typing import Protocol

from stickslip.files.locations import explained, location
from stickslip.files.targets import flush, placed

TEMPORARY = ".tmp"


class Folder(Protocol):
    """Named bytes in one place. `where` is that place, for messages and for opening it again."""

    where: str

    @property
    def absolute(self) -> str:
        """The place as other processes find it."""

    def names(self) -> list[str]:
        """Names that exist; none where there is no folder."""

    def read(self, name: str) -> bytes:
        """The bytes under a name. Raises FileNotFoundError."""

    def write(self, name: str, data: bytes) -> None:
        """Write, replacing what was there at once; make the folder if need be."""

    def create(self, name: str, data: bytes) -> None:
        """Write under a name that is free. Raises FileExistsError."""

    def remove(self, name: str) -> None:
        """Remove a name, if it is there."""

    def rmdir(self) -> None:
        """Remove the folder itself, if it is empty."""

    def size(self) -> int:
        """Bytes of all names together."""


def folder_at(place: str | os.PathLike[str]) -> Folder:
    """The folder at a path or URL; nothing is created. Raises StoreError for a URL that cannot be opened."""
    where = location(place)
    return LocalFolder(where) if isinstance(where, Path) else where.folder()


class LocalFolder:
    """A folder of this machine, or of a file system mounted on it."""

    def __init__(self, path: Path) -> None:
        self.path, self.where = path, str(path)

    @property
    def absolute(self) -> str:
        """The whole path."""
        return str(self.path.absolute())

    def names(self) -> list[str]:
        """Names that exist."""
        with explained(self.where, "read"):
            try:
                return sorted(os.listdir(self.path))
            except FileNotFoundError:
                return []

    def read(self, name: str) -> bytes:
        """The bytes under a name."""
        with explained(str(self.path / name), "read"):
            return (self.path / name).read_bytes()

    def write(self, name: str, data: bytes) -> None:
        """Write to a temporary name, flush, rename, flush the folder."""
        self._place(name, data, os.replace)

    def create(self, name: str, data: bytes) -> None:
        """As `write`, by a link, which never replaces."""
        self._place(name, data, _link)

    def remove(self, name: str) -> None:
        """Remove a name."""
        with explained(str(self.path / name), "removed"), suppress(FileNotFoundError):
            os.unlink(self.path / name)

    def rmdir(self) -> None:
        """Remove the folder."""
        with suppress(OSError):
            self.path.rmdir()

    def size(self) -> int:
        """Bytes of all names."""
        total = 0
        for name in self.names():
            with suppress(OSError):  # it may be renamed or removed just now
                total += os.stat(self.path / name).st_size
        return total

    def _place(self, name: str, data: bytes, move: Callable[[Path, Path], None]) -> None:
        temporary = self.path / f".{name}.{uuid.uuid4().hex}{TEMPORARY}"
        with explained(str(self.path / name), "written"):
            self._make()
            with placed(temporary, self.path / name, move):
                temporary.write_bytes(data)

    def _make(self) -> None:
        try:
            self.path.mkdir()
        except FileExistsError:
            if not self.path.is_dir():
                raise NotADirectoryError(errno.ENOTDIR, "a file exists there already") from None
        except FileNotFoundError:
            try:
                self.path.mkdir(parents=True, exist_ok=True)
            except FileNotFoundError as error:  # /proc, for one; this must not pass for an answer
                raise OSError(errno.EPERM, error.strerror or "no such folder") from None
        else:
            flush(self.path.absolute().parent)


def _link(temporary: Path, name: Path) -> None:
    """Give a file a name that is free. Raises FileExistsError."""
    try:
        os.link(temporary, name)
    except FileExistsError:
        raise
    except OSError:  # a file system without links: the name is taken first, its content follows at once
        os.close(os.open(name, os.O_CREAT | os.O_EXCL))
        os.replace(temporary, name)
    else:
        os.unlink(temporary)
