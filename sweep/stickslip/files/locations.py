"""Places that people name: a path of this machine, or a URL of a Zarr store that fsspec opens; and what kind of file
lies there, with the command that takes it.
"""

from __future__ import annotations

import errno
import os
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path, PurePosixPath
from typing import Any
from urllib.parse import unquote, urlsplit

from stickslip.errors import StoreError, reason

ROOT = "zarr.json"  # what makes a place a Zarr store
SEAL = "header_sha256"  # attribute of a file of ours: the digest of what it says of itself
UNCACHED = {"use_listings_cache": False}  # of fsspec: other machines write there, too
_SPACE = (errno.ENOSPC, errno.EDQUOT, errno.EFBIG) if hasattr(errno, "EDQUOT") else (errno.ENOSPC, errno.EFBIG)
_ACCESS = (errno.EACCES, errno.EPERM, errno.EROFS, errno.ENOTDIR, errno.ENAMETOOLONG)


class Url(str):
    """The URL of a Zarr store, without a slash at its end, with what is asked of a `Path` that is a result.

    Services that keep objects write each whole or not at all, and have no rename: a new store is written once the older
    one is removed, and its root lists no arrays before the end, which says that nothing whole is there. Raises
    StoreError for what they refuse.
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
        with explained(self, "written", answers=()):
            service.pipe_file(f"{root}/{key}", data)

    def remove(self, *keys: str) -> None:
        """Remove objects, and all below these keys; those that are there."""
        service, root = self._opened()
        with explained(self, "removed"), suppress(FileNotFoundError):
            service.rm([f"{root}/{key}" for key in keys], recursive=True)

    def check_writable(self) -> None:
        """Raise StoreError now if `begin_store` would fail later."""
        self.check_is_zarr()
        key = ".probe" if self._keys_of_ours() else ROOT
        self.put(key, b"")
        self.remove(key)

    def check_is_zarr(self) -> None:
        """Raise StoreError for the name of anything else."""
        if self.suffix != ".zarr":
            raise StoreError(
                f"{self}: behind a URL only Zarr stores are written, expected a name that ends in .zarr\n"
                "hint: netCDF is written to a file of this machine, which can be copied then"
            )

    def begin_store(self) -> None:
        """Make room for a new store; the empty root says that what is there is ours, and not whole."""
        there = self._keys_of_ours()
        self.put(ROOT, b"")
        self.remove(*{key.partition("/")[0] for key in there} - {ROOT})

    def _keys_of_ours(self) -> dict[str, int]:
        """The objects of a store, or of a part of one. Raises StoreError for something else."""
        there = self.keys()
        if there and ROOT not in there:
            raise StoreError(f"{self}: exists and is not a Zarr store, so it is left alone")
        return there

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


# --- kinds of files ---------------------------------------------------------------------------------------------------

_BEGINNINGS = {  # of files, whatever they are called
    b"\x89HDF\r\n\x1a\n": "netcdf", b"CDF\x01": "netcdf", b"CDF\x02": "netcdf", b"CDF\x05": "netcdf",
    b"PK\x03\x04": "zip", b"\xd0\xcf\x11\xe0": "workbook", b"\x89PNG": "plot", b"%PDF": "plot",
}  # fmt: skip
_SUFFIXES = {".yaml": "configuration", ".yml": "configuration", ".csv": "table", ".tsv": "table", ".svg": "plot"}
_STORE = ".parts"
_TAKEN_BY = {  # what a kind is called, and who takes it; {} is the name of the file
    "configuration": ("a configuration", "`stickslip run {}` computes it, `stickslip validate {}` checks it"),
    "netcdf": ("a netCDF file", "`stickslip inspect {}` says what is in a result, `stickslip plot {}` draws it"),
    "zarr": ("a Zarr store", "`stickslip inspect {}` says what is in a result, `stickslip plot {}` draws it"),
    "store": ("the working store of a run", "`stickslip status {}` shows the run, `stickslip collect {}` writes it"),
    "workbook": ("an Excel workbook", "save the sheet as CSV: `stickslip fit` reads measured points from it"),
    "table": ("a table", "`stickslip fit {}` fits measured points, `stickslip rig features {}` judges a rig record"),
    "zip": ("an archive", None),
    "plot": ("a plot", None),
    "folder": ("a folder", None),
}


CONFIGURATIONS, RESULTS, TABLES = ("configuration",), ("netcdf", "zarr"), ("table",)  # that commands take


def wrong_file_type(path: Path, expected: tuple[str, ...]) -> tuple[str, str | None] | None:
    """What is at `path`, and the next step, if it cannot be of the kinds expected; None if it can, or is not there."""
    kind = _kind(path)
    if kind is None or kind in expected:
        return None
    name, hint = _TAKEN_BY[kind]
    return name, hint and hint.replace("{}", str(path))


def _kind(path: Path) -> str | None:
    """The kind of what is at `path`; None for nothing, and for a file that may be anything."""
    if path.is_dir():
        if path.suffix == _STORE:
            return "store"
        is_zarr = path.suffix == ".zarr" or any((path / name).exists() for name in (ROOT, ".zgroup"))
        return "zarr" if is_zarr else "folder"
    try:
        with path.open("rb") as file:
            begins = file.read(8)
    except OSError:
        return None
    kind = next((kind for start, kind in _BEGINNINGS.items() if begins.startswith(start)), None)
    if kind == "zip" and path.suffix.lower().startswith((".xls", ".ods")):
        return "workbook"
    return kind or _SUFFIXES.get(path.suffix.lower())
