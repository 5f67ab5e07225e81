"""Named bytes behind a URL: whatever fsspec opens. What a system complains about, in words for people."""

from __future__ import annotations

import errno
from collections.abc import Callable, Collection, Iterator
from contextlib import contextmanager, suppress
from typing import Any

from stickslip.errors import StoreError

_SPACE = (errno.ENOSPC, errno.EDQUOT, errno.EFBIG) if hasattr(errno, "EDQUOT") else (errno.ENOSPC, errno.EFBIG)
_HINT = "hint: make the bucket first, or correct its name"
_ACCESS = (errno.EACCES, errno.EPERM, errno.EROFS, errno.ENOTDIR, errno.ENAMETOOLONG)


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
    """What could not be done to a place, why, and what helps."""
    number = getattr(error, "errno", None)
    reason = getattr(error, "strerror", None) or str(error).partition("\n")[0] or type(error).__name__
    hint = ""
    if number in _SPACE:
        hint = "\nhint: free some space, then do the same again; what is finished is kept"
    elif number in _ACCESS:
        hint = "\nhint: choose another folder for the output, or for the store"
    return StoreError(f"{where}: cannot be {action} ({reason}){hint}")


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
                found = self._fs.ls(self._root, detail=False)
            except FileNotFoundError:
                return []
            return sorted(path.rstrip("/").rpartition("/")[2] for path in found)

    def keys(self) -> list[str]:
        """Names that exist, and what is in folders: `regime/c/0/1`."""
        return sorted(path.removeprefix(self._root).lstrip("/") for path in self._found())

    def has(self, name: str) -> bool:
        """Whether a name exists."""
        try:
            self.read(name)
        except FileNotFoundError:
            return False
        return True

    def read(self, name: str) -> bytes:
        """What is written under a name."""
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

    def vanish(self) -> None:
        """Remove the folder, where the service has folders."""
        with suppress(Exception):
            self._fs.rmdir(self._root)

    def size(self) -> int:
        """Bytes of all objects."""
        return sum(int(found["size"] or 0) for found in self._found().values())

    def _found(self) -> dict[str, dict[str, Any]]:
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
                    raise StoreError(f"{self.where}: cannot be written (there is no {first!r})\n{_HINT}") from None
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
