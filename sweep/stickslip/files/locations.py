"""Places of results and of working stores: a path of this machine, or a URL that fsspec opens.

A folder holds bytes under names, each written whole or not at all, and safe from a power failure once `write` returns.
Whatever the system complains about comes out as a StoreError with path, reason and remedy; a name that is not there as
FileNotFoundError.
"""

from __future__ import annotations

import errno
import os
import shutil
import uuid
from collections.abc import Callable, Collection, Iterator
from concurrent.futures import ThreadPoolExecutor
from contextlib import contextmanager, suppress
from dataclasses import dataclass
from pathlib import Path, PurePosixPath
from typing import Any
from urllib.parse import unquote, urlsplit

from stickslip.errors import StoreError

ROOT = "zarr.json"  # what makes a place a Zarr store
TEMPORARY = ".tmp"  # suffix of what is not written yet
Move = Callable[[Path, Path], None]
Check = Callable[[], None]
_SPACE = (errno.ENOSPC, errno.EDQUOT, errno.EFBIG) if hasattr(errno, "EDQUOT") else (errno.ENOSPC, errno.EFBIG)
_ACCESS = (errno.EACCES, errno.EPERM, errno.EROFS, errno.ENOTDIR, errno.ENAMETOOLONG)


@dataclass(frozen=True)
class Url(os.PathLike[str]):
    """A Zarr store behind a URL, with what is asked of a `Path` that is a result. text : without a slash at its end."""

    text: str

    def __str__(self) -> str:
        return self.text

    def __fspath__(self) -> str:
        return self.text

    @property
    def name(self) -> str:
        """The part after the last slash."""
        return self.text.rpartition("/")[2]

    @property
    def suffix(self) -> str:
        """`.zarr`, for one."""
        return PurePosixPath(self.name).suffix

    def with_name(self, name: str) -> Url:
        """A place in the same folder, of another name."""
        return Url(f"{self.text.rpartition('/')[0]}/{name}")

    def with_suffix(self, suffix: str) -> Url:
        """A place of the same name but for the suffix."""
        return self.with_name(self.stem + suffix)

    @property
    def stem(self) -> str:
        """The name without its suffix."""
        return self.name.removesuffix(self.suffix)

    def exists(self) -> bool:
        """Tell whether a store is there, and whole: what it says of itself is written last."""
        return self.folder().has(ROOT)

    def folder(self) -> RemoteFolder:
        """The place for reading and writing. Raises StoreError if it cannot be opened."""
        return RemoteFolder(self.text)


Location = Path | Url


def location(place: str | os.PathLike[str]) -> Location:
    """The place that a text names; `~` is the folder of its user."""
    if isinstance(place, Path | Url):
        return place
    text = os.fspath(place)
    if text.startswith("file://"):
        return Path(unquote(urlsplit(text).path))
    return Url(text.rstrip("/")) if "://" in text else Path(os.path.expanduser(text))


# --- folders ----------------------------------------------------------------------------------------------------------


class LocalFolder:
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
        import fsspec

        self.where = self.absolute = url.rstrip("/")
        try:
            self._fs, root = fsspec.core.url_to_fs(self.where)
        except ImportError as error:
            kind = url.partition("://")[0]
            known = "pip install 'stickslip[s3]'" if kind in ("s3", "s3a") else str(error)
            raise StoreError(f"{self.where}: needs an optional package\nhint: {known}") from error
        except Exception as error:  # an unknown kind of URL, missing credentials, ...
            raise failure(self.where, "opened", error) from error
        self._root = root.rstrip("/")

    def names(self) -> list[str]:
        """Names that exist."""
        with explained(self.where, "read"):
            self._fs.invalidate_cache(self._root)  # other machines write here too
            try:
                paths = self._fs.ls(self._root, detail=False)
            except FileNotFoundError:
                return []
            return sorted(path.rstrip("/").rpartition("/")[2] for path in paths)

    def keys(self) -> list[str]:
        """Names that exist, and what is in folders: `regime/c/0/1`."""
        return sorted(path.removeprefix(self._root).lstrip("/") for path in self._objects())

    def has(self, name: str) -> bool:
        """Tell whether a name exists."""
        try:
            self.read(name)
        except FileNotFoundError:
            return False
        return True

    def read(self, name: str) -> bytes:
        """The bytes under a name."""
        with explained(f"{self.where}/{name}", "read"):
            return bytes(self._fs.cat_file(self._path(name)))

    def write(self, name: str, data: bytes) -> None:
        """Write an object."""
        self._put(name, lambda path: self._fs.pipe_file(path, data))

    def create(self, name: str, data: bytes) -> None:
        """Write an object under a free name; services that cannot refuse are asked beforehand."""

        def put(path: str) -> None:
            if self._fs.exists(path):
                raise FileExistsError(name)
            try:
                self._fs.pipe_file(path, data, mode="create")
            except (TypeError, NotImplementedError):
                self._fs.pipe_file(path, data)

        self._put(name, put)

    def copy(self, keys: Collection[str], to: RemoteFolder) -> None:
        """Copy objects to another folder of the same service, which moves the bytes itself. Raises StoreError."""
        pairs = [self._path(key) for key in keys], [to._path(key) for key in keys]
        try:
            with explained(to.where, "written"):
                self._fs.copy(*pairs, on_error="raise")
        except FileNotFoundError as error:
            raise failure(to.where, "written", error) from error

    def remove(self, *names: str) -> None:
        """Remove objects, those that are there."""
        with explained(f"{self.where}/{names[0]}", "removed"), suppress(FileNotFoundError):
            self._fs.rm([self._path(name) for name in names])

    def rmdir(self) -> None:
        """Remove the folder, where the service has folders."""
        with suppress(Exception):
            self._fs.rmdir(self._root)

    def size(self) -> int:
        """Bytes of all objects."""
        return sum(int(about["size"] or 0) for about in self._objects().values())

    def _objects(self) -> dict[str, dict[str, Any]]:
        """All objects by their paths, and what the service says of each."""
        with explained(self.where, "read"), suppress(FileNotFoundError):
            self._fs.invalidate_cache(self._root)
            return dict(self._fs.find(self._root, detail=True))
        return {}

    def _put(self, name: str, put: Callable[[str], None]) -> None:
        """Write an object; make its folder if need be, but no bucket: that may be misspelt."""
        path = self._path(name)
        with explained(f"{self.where}/{name}", "written"):
            try:
                return put(path)
            except FileNotFoundError:
                first = path[: path.find("/", 1)]
                if not self._fs.exists(first):
                    reason = f"there is no {first!r})\nhint: make the bucket first, or correct its name"
                    raise StoreError(f"{self.where}: cannot be written ({reason}") from None
            self._fs.makedirs(path.rpartition("/")[0], exist_ok=True)
            try:
                put(path)
            except FileNotFoundError as error:
                raise failure(self.where, "written", error) from error

    def _path(self, name: str) -> str:
        return f"{self._root}/{name}"


Folder = LocalFolder | RemoteFolder


def folder_at(place: str | os.PathLike[str]) -> Folder:
    """The folder at a path or URL; nothing is created. Raises StoreError for a URL that cannot be opened."""
    where = location(place)
    return LocalFolder(where) if isinstance(where, Path) else where.folder()


# --- on the disk ------------------------------------------------------------------------------------------------------


@contextmanager
def placed(
    temporary: Path, target: Path, move: Move = os.replace, check: Check | None = None, keep: bool = False
) -> Iterator[None]:
    """Whatever is written to `temporary` inside `with` goes to `target` at its end; after an error it is removed.

    check : called right before that; what it raises is such an error. keep : it is not removed.
    """
    try:
        yield
        _flush_all(temporary)
        if check:
            check()
        move(temporary, target)
        flush(target.parent)
    except BaseException:
        if not keep:
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
def explained(where: str, action: str) -> Iterator[None]:
    """Errors of the system as StoreError. The two that are answers pass."""
    try:
        yield
    except (FileNotFoundError, FileExistsError, StoreError):
        raise
    except Exception as error:  # fsspec lets through whatever the library of a service raises
        raise failure(where, action, error) from error


def failure(where: str, action: str, error: BaseException) -> StoreError:
    """The error of what could not be done to a place, with the reason and a remedy."""
    number = getattr(error, "errno", None)
    reason = getattr(error, "strerror", None) or str(error).partition("\n")[0] or type(error).__name__
    hint = ""
    if number in _SPACE:
        hint = "\nhint: free some space, then do the same again; what is finished is kept"
    elif number in _ACCESS:
        hint = "\nhint: choose another folder for the output, or for the store"
    return StoreError(f"{where}: cannot be {action} ({reason}){hint}")
