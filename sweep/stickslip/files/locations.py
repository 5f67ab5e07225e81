"""Places of results: a path of this machine, or a URL that fsspec opens.

Services that keep objects write each whole or not at all, but have no rename (`targets.py`); they copy by themselves. So
a new store is written beside its place, under `.NAME.new`. Once it is whole, its objects are copied to its place: the
root, without which nobody sees a store there, is removed first and written last. Whoever is killed in between leaves
the new one whole, and `finish` goes on from there. One process at a time writes (`runs/workdir/lock.py`).
"""

from __future__ import annotations

import errno
import os
from collections.abc import Callable, Collection, Iterator
from contextlib import contextmanager, suppress
from dataclasses import dataclass
from pathlib import Path, PurePosixPath
from typing import Any
from urllib.parse import unquote, urlsplit

from stickslip.errors import StoreError

ROOT = "zarr.json"  # what makes a place a Zarr store
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


# --- behind URLs ------------------------------------------------------------------------------------------------------


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


# --- stores replaced --------------------------------------------------------------------------------------------------


@contextmanager
def replaced_store(target: Url) -> Iterator[Callable[[str, bytes], None]]:
    """A function that puts the bytes of a new store, inside `with`, its root last; at the end it replaces `target`.

    Whatever goes wrong leaves `target` alone, but for what goes wrong while objects are copied. Raises StoreError.
    """
    _check_ours(target)
    if is_unfinished(target):
        finish(target)
    new = _beside(target)
    _clear(new)
    keys = set[str]()

    def put(key: str, data: bytes) -> None:
        new.write(key, bytes(data))
        keys.add(key)

    try:
        yield put
    except BaseException:
        with suppress(StoreError):  # of what went wrong, the first is told
            _clear(new)
        raise
    _swap(new, target.folder(), keys)


def check_writable(target: Url) -> None:
    """Raise StoreError now if `replaced_store` would fail later."""
    _check_ours(target)
    probe, new = "probe", _beside(target)
    new.write(probe, b"")
    new.remove(probe)


def is_unfinished(target: Url) -> bool:
    """Recognize a new store that is whole and not yet in its place: its writer was killed, or is at work."""
    return _beside(target).has(ROOT) and not target.exists()


def finish(target: Url) -> None:
    """Put a new store in its place that is whole."""
    new = _beside(target)
    _swap(new, target.folder(), set(new.keys()))


def _swap(new: RemoteFolder, target: RemoteFolder, keys: set[str]) -> None:
    target.remove(ROOT)
    new.copy(sorted(keys - {ROOT}), target)
    if older := set(target.keys()) - keys:
        target.remove(*older)
    new.copy([ROOT], target)
    _clear(new)


def _clear(folder: RemoteFolder) -> None:
    """Remove all objects, the root first: what is left is not whole."""
    folder.remove(ROOT)
    if keys := folder.keys():
        folder.remove(*keys)


def _check_ours(target: Url) -> None:
    """Raise StoreError if something else than a store of ours, or a part of one, has the name of the target."""
    if not target.exists() and target.folder().keys() and not _beside(target).has(ROOT):
        raise StoreError(f"{target}: exists and is not a Zarr store, so it is left alone")


def _beside(target: Url) -> RemoteFolder:
    return target.with_name(f".{target.name}.new").folder()
