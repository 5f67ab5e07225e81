"""Folders that hold a working store: on this machine, or behind any URL that fsspec opens.

A name is written whole or not at all, and survives a power failure once `write` returns. Whatever the system complains
about comes out as a StoreError with path, reason and remedy; a name that is not there as FileNotFoundError.
"""

from __future__ import annotations

import errno
import os
import uuid
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import Any, Protocol
from urllib.parse import unquote, urlsplit

from stickslip.errors import StoreError
from stickslip.files.atomic import flush, placed

TEMPORARY = ".tmp"
_SPACE = (errno.ENOSPC, errno.EDQUOT, errno.EFBIG) if hasattr(errno, "EDQUOT") else (errno.ENOSPC, errno.EFBIG)
_ACCESS = (errno.EACCES, errno.EPERM, errno.EROFS, errno.ENOTDIR, errno.ENAMETOOLONG)


class Folder(Protocol):
    """Named bytes in one place. `where` is that place, for messages and for opening it again."""

    where: str

    @property
    def absolute(self) -> str:
        """The place as other processes find it."""

    def names(self) -> list[str]:
        """Names that exist; none where there is no folder."""

    def read(self, name: str) -> bytes:
        """What is written under a name. Raises FileNotFoundError."""

    def write(self, name: str, data: bytes) -> None:
        """Write, replacing what was there at once; make the folder if need be."""

    def create(self, name: str, data: bytes) -> None:
        """Write under a name that is free. Raises FileExistsError."""

    def remove(self, name: str) -> None:
        """Remove a name, if it is there."""

    def vanish(self) -> None:
        """Remove the folder itself, if it is empty."""

    def size(self) -> int:
        """Bytes of all names together."""


def folder_at(place: str | os.PathLike[str]) -> Folder:
    """The folder at a path or URL; nothing is created. Raises StoreError for a URL that cannot be opened."""
    text = os.fspath(place)
    if text.startswith("file://"):
        return LocalFolder(Path(unquote(urlsplit(text).path)))
    return RemoteFolder(text) if "://" in text else LocalFolder(Path(text))


@contextmanager
def _explained(where: str, action: str) -> Iterator[None]:
    """Errors of the system as StoreError. The two that are answers pass."""
    try:
        yield
    except (FileNotFoundError, FileExistsError, StoreError):
        raise
    except Exception as error:  # fsspec lets through whatever the library of a service raises
        raise failure(where, action, error) from error


def failure(where: str, action: str, error: BaseException) -> StoreError:
    """What could not be done to a place, why, and what helps."""
    number = getattr(error, "errno", None)
    reason = getattr(error, "strerror", None) or str(error).partition("\n")[0] or type(error).__name__
    hint = ""
    if number in _SPACE:
        hint = "\nhint: free some space, then give the same command again; what is finished is kept"
    elif number in _ACCESS:
        hint = "\nhint: choose another folder with --output or --store"
    return StoreError(f"{where}: cannot be {action} ({reason}){hint}")


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
        with _explained(self.where, "read"):
            try:
                return sorted(os.listdir(self.path))
            except FileNotFoundError:
                return []

    def read(self, name: str) -> bytes:
        """What is written under a name."""
        with _explained(str(self.path / name), "read"):
            return (self.path / name).read_bytes()

    def write(self, name: str, data: bytes) -> None:
        """Write to a temporary name, flush, rename, flush the folder."""
        self._place(name, data, os.replace)

    def create(self, name: str, data: bytes) -> None:
        """As `write`, by a link, which never replaces."""
        self._place(name, data, _link)

    def remove(self, name: str) -> None:
        """Remove a name."""
        with _explained(str(self.path / name), "removed"), suppress(FileNotFoundError):
            os.unlink(self.path / name)

    def vanish(self) -> None:
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
        with _explained(str(self.path / name), "written"):
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


class RemoteFolder:
    """A folder behind a URL. Services that keep objects write each whole or not at all, which is all that is needed."""

    def __init__(self, url: str) -> None:
        self.where = url.rstrip("/")
        self._fs, self._root = _file_system(self.where)

    @property
    def absolute(self) -> str:
        """The URL."""
        return self.where

    def names(self) -> list[str]:
        """Names that exist."""
        with _explained(self.where, "read"):
            self._fs.invalidate_cache(self._root)  # other machines write here too
            try:
                found = self._fs.ls(self._root, detail=False)
            except FileNotFoundError:
                return []
            return sorted(path.rstrip("/").rpartition("/")[2] for path in found)

    def read(self, name: str) -> bytes:
        """What is written under a name."""
        with _explained(f"{self.where}/{name}", "read"):
            return bytes(self._fs.cat_file(self._path(name)))

    def write(self, name: str, data: bytes) -> None:
        """Write an object."""
        with _explained(f"{self.where}/{name}", "written"):
            self._fs.makedirs(self._root, exist_ok=True)
            self._fs.pipe_file(self._path(name), data)

    def create(self, name: str, data: bytes) -> None:
        """Write an object under a free name; services that cannot refuse are asked beforehand."""
        with _explained(f"{self.where}/{name}", "written"):
            self._fs.makedirs(self._root, exist_ok=True)
            if self._fs.exists(self._path(name)):
                raise FileExistsError(name)
            try:
                self._fs.pipe_file(self._path(name), data, mode="create")
            except (TypeError, NotImplementedError):
                self._fs.pipe_file(self._path(name), data)

    def remove(self, name: str) -> None:
        """Remove an object."""
        with _explained(f"{self.where}/{name}", "removed"), suppress(FileNotFoundError):
            self._fs.rm_file(self._path(name))

    def vanish(self) -> None:
        """Remove the folder, where the service has folders."""
        with suppress(Exception):
            self._fs.rmdir(self._root)

    def size(self) -> int:
        """Bytes of all objects."""
        with _explained(self.where, "read"), suppress(FileNotFoundError):
            return sum(int(found["size"] or 0) for found in self._fs.ls(self._root, detail=True))
        return 0

    def _path(self, name: str) -> str:
        return f"{self._root}/{name}"


def _file_system(url: str) -> tuple[Any, str]:
    """The file system behind a URL, and the path in it."""
    import fsspec

    try:
        fs, root = fsspec.core.url_to_fs(url)
    except ImportError as error:
        kind = url.partition("://")[0]
        known = "pip install 'stickslip[s3]'" if kind in ("s3", "s3a") else str(error)
        raise StoreError(f"{url}: needs an optional package\nhint: {known}") from error
    except Exception as error:  # an unknown kind of URL, missing credentials, ...
        raise failure(url, "opened", error) from error
    return fs, root.rstrip("/")
