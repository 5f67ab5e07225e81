"""Places of results and of working stores: a path of this machine, or a URL that fsspec opens.

A working store is a folder: it holds bytes under names, each written whole or not at all, and safe from a power failure
once `write` returns. Whatever the system complains about comes out as a StoreError with path, reason and remedy; a name
that is not there as FileNotFoundError.
"""

from __future__ import annotations

import errno
import os
import shutil
import uuid
from collections.abc import Callable, Iterator
from concurrent.futures import ThreadPoolExecutor
from contextlib import contextmanager, suppress
from pathlib import Path, PurePosixPath
from typing import Any
from urllib.parse import unquote, urlsplit

from stickslip.errors import StoreError, reason

ROOT = "zarr.json"  # what makes a place a Zarr store
SEAL = "header_sha256"  # attribute of a file of ours: the digest of what it says of itself
TEMPORARY = ".tmp"  # suffix of what is not written yet
UNCACHED = {"use_listings_cache": False}  # of fsspec: other machines write there, too
Move = Callable[[Path, Path], None]
Check = Callable[[], None]
_SPACE = (errno.ENOSPC, errno.EDQUOT, errno.EFBIG) if hasattr(errno, "EDQUOT") else (errno.ENOSPC, errno.EFBIG)
_ACCESS = (errno.EACCES, errno.EPERM, errno.EROFS, errno.ENOTDIR, errno.ENAMETOOLONG)


class Url(str):
    """The URL of a Zarr store, without a slash at its end, with what is asked of a `Path` that is a result.

    Services that keep objects write each whole or not at all. Raises StoreError for what they refuse.
    """

    @property
    def name(self) -> str:
        """The part after the last slash."""
        return self.rpartition("/")[2]

    @property
    def suffix(self) -> str:
        """`.zarr`, for one."""
        return PurePosixPath(self.name).suffix

    def exists(self) -> bool:
        """Tell whether a store is there, and whole: the root of one of ours lists its arrays at last."""
        service, root = self._opened()
        try:
            with explained(self, "read"):
                text = service.cat_file(f"{root}/{ROOT}")
        except FileNotFoundError:
            return False
        return bool(text) and (b"consolidated_metadata" in text or SEAL.encode() not in text)

    def keys(self) -> dict[str, int]:
        """All objects, `regime/c/0/1` for one, and their bytes."""
        service, root = self._opened()
        with explained(self, "read"), suppress(FileNotFoundError):
            objects = service.find(root, detail=True)
            return {path.removeprefix(root).lstrip("/"): int(objects[path]["size"] or 0) for path in objects}
        return {}

    def put(self, key: str, data: bytes) -> None:
        """Write an object; make no bucket: that may be misspelt."""
        service, root = self._opened()
        path = f"{root}/{key}"
        with explained(self, "written", answers=()):
            try:
                service.pipe_file(path, data)
            except FileNotFoundError:
                bucket = path[: path.find("/", 1)]
                if service.exists(bucket):
                    raise
                hint = "make the bucket first, or correct its name"
                raise StoreError(f"{self}: cannot be written (there is no {bucket!r})", hint=hint) from None

    def remove(self, *keys: str) -> None:
        """Remove objects, and all below these keys; those that are there."""
        service, root = self._opened()
        with explained(self, "removed"), suppress(FileNotFoundError):
            service.rm([f"{root}/{key}" for key in keys], recursive=True)

    def _opened(self) -> tuple[Any, str]:
        """The file system of fsspec, and the path there."""
        import fsspec

        with explained(self, "opened", answers=()):  # an unknown kind of URL, a package that is not installed, ...
            service, root = fsspec.core.url_to_fs(self, **UNCACHED)
        return service, root.rstrip("/")


Location = Path | Url


def location(place: str | os.PathLike[str]) -> Location:
    """The place that a text names; `~` is the folder of its user."""
    if isinstance(place, Path | Url):
        return place
    text = os.fspath(place)
    if text.startswith(("file://", "local://")):
        return Path(unquote(urlsplit(text).path))
    return Url(text.rstrip("/")) if "://" in text else Path(os.path.expanduser(text))


# --- folders ----------------------------------------------------------------------------------------------------------


class Folder:
    """A folder of this machine, or of a file system mounted on it. absolute : the place as other processes find it."""

    def __init__(self, path: Path) -> None:
        self.path, self.where, self.absolute = path, str(path), str(path.absolute())

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

    def _place(self, name: str, data: bytes, move: Move) -> None:
        temporary = self.path / f".{name}.{uuid.uuid4().hex}{TEMPORARY}"
        with explained(str(self.path / name), "written"):
            self._make()
            with placed(temporary, self.path / name, move):
                temporary.write_bytes(data)

    def _make(self) -> None:
        if self.path.is_dir():
            return
        try:
            self.path.mkdir(parents=True)
        except FileExistsError:
            if not self.path.is_dir():  # made by another process meanwhile
                raise NotADirectoryError(errno.ENOTDIR, "a file exists there already") from None
        except FileNotFoundError as error:  # /proc, for one; this must not pass for an answer
            raise OSError(errno.EPERM, error.strerror or "no such folder") from None
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


def folder_at(place: str | os.PathLike[str]) -> Folder:
    """The folder at a path; nothing is created. Raises StoreError for a URL."""
    where = location(place)
    if isinstance(where, Url):
        raise StoreError(f"{where}: a working store has to be on a file system", hint="name a folder with {store}")
    return Folder(where)


# --- on the disk ------------------------------------------------------------------------------------------------------


@contextmanager
def placed(temporary: Path, target: Path, move: Move = os.replace, check: Check | None = None) -> Iterator[None]:
    """Whatever is written to `temporary` inside `with` goes to `target` at its end; after an error it is removed.

    check : called right before that; what it raises is such an error.
    """
    try:
        yield
        _flush_all(temporary)
        if check:
            check()
        move(temporary, target)
        flush(target.parent)
    except BaseException:
        remove(temporary)
        raise


def flush(path: Path) -> None:
    """Have the operating system put a file, or the names in a folder, on the disk."""
    is_folder = path.is_dir()
    try:
        descriptor = os.open(path, os.O_RDONLY if is_folder else os.O_RDWR)  # Windows flushes only what may be written
    except OSError:
        if is_folder:  # and does not open folders
            return
        raise
    try:
        os.fsync(descriptor)
    finally:
        os.close(descriptor)


def _flush_all(path: Path) -> None:
    """Put a file, or every file below a folder, on the disk, several at a time: each waits for the disk."""
    if not path.is_dir():
        return flush(path)
    with ThreadPoolExecutor(8) as pool:
        for _ in pool.map(flush, [Path(parent) / name for parent, _, names in os.walk(path) for name in names]):
            pass


def remove(path: Path) -> None:
    """Remove a file or a folder, if it is there."""
    if path.is_dir():
        shutil.rmtree(path, ignore_errors=True)
    with suppress(OSError):
        path.unlink()


@contextmanager
def explained(
    where: str, action: str, answers: tuple[type[OSError], ...] = (FileNotFoundError, FileExistsError)
) -> Iterator[None]:
    """Errors of the system as StoreError, with the reason and a remedy, but for those that are answers."""
    try:
        yield
    except Exception as error:  # fsspec lets through whatever the library of a service raises
        if isinstance(error, (StoreError, *answers)):
            raise
        number, hint = getattr(error, "errno", None), ""
        if number in _SPACE:
            hint = "\nhint: free some space, then do the same again; what is finished is kept"
        elif number in _ACCESS:
            hint = "\nhint: choose another folder for the output, or for the store"
        raise StoreError(f"{where}: cannot be {action} ({reason(error)}){hint}") from error
