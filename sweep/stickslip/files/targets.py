"""Targets of results: the file behind a name, and a check that it can be written, before an hour of computing.

All that writes goes through `behind` (`atomic.replaced`), all that is asked to write later through `check_target`.
"""

from __future__ import annotations

import os
import re
import stat
from dataclasses import dataclass, field
from importlib.util import find_spec
from pathlib import Path
from tempfile import TemporaryFile

from stickslip.errors import StoreError, reason
from stickslip.files.locations import ROOT, Url, check_writable, location

_ZARR_MARKERS = (ROOT, ".zgroup")
_LONGEST_NAME = 255  # bytes
NO_FILE_NAME = re.compile(r"[^\w.+-]+")  # what names of files that are made up do without


@dataclass(frozen=True)
class Kind:
    """A kind of file. name : of several. needs : by suffix, the package that makes it and the extra that brings it.

    folder : whether the folder it lies in is made; that of a picture is there, or its name is mistyped.
    """

    name: str
    suffixes: tuple[str, ...]
    needs: dict[str, tuple[str, str]] = field(default_factory=dict)
    folder: bool = False


KINDS = {
    "result": Kind("results", (".nc", ".zarr"), {".zarr": ("zarr", "zarr")}, folder=True),
    "table": Kind("tables", (".csv", ".xlsx"), {".xlsx": ("openpyxl", "excel")}, folder=True),
    "points": Kind("tables of points", (".csv",), folder=True),
    "plot": Kind("plots", (".png", ".svg", ".pdf")),
    "page": Kind("pages", (".html", ".htm", ".pdf"), {".pdf": ("plutoprint", "pdf")}),
    "sound": Kind("sounds", (".wav",)),
}


def behind(path: str | os.PathLike[str], *, zarr: bool = False) -> Path:
    """The file (or Zarr store) behind a path, links followed. Raises StoreError where there is something else: a
    device, a pipe, a folder."""
    target = Path(os.path.realpath(os.path.expanduser(path)))
    try:
        mode = target.stat().st_mode
    except FileNotFoundError:
        return target
    if zarr and not any((target / marker).exists() for marker in _ZARR_MARKERS):
        raise StoreError(f"{path}: exists and is not a Zarr store, so it is left alone")
    if not zarr and not stat.S_ISREG(mode):
        raise StoreError(f"{path}: exists and is not a regular file, so it is left alone")
    return target


def check_target(place: str | os.PathLike[str], *kinds: str) -> None:
    """Raises StoreError now if a file of one of these `KINDS`, or a `folder` of files, could not be written later."""
    where = location(place)
    possible = [KINDS[kind] for kind in kinds if kind != "folder"]
    kind = next((kind for kind in possible if where.suffix.lower() in kind.suffixes), None)
    if kind is None and "folder" in kinds:
        if not isinstance(where, Path) or (where.exists() and not where.is_dir()):
            raise StoreError(f"{place}: expected a folder, or a name for a new one")
        return check_place(where, is_folder=True)
    if kind is None:
        named = " and ".join(f"{kind.name} end in {', '.join(kind.suffixes)}" for kind in possible)
        raise StoreError(f"{place}: {named}")
    package, extra = kind.needs.get(where.suffix.lower(), ("", ""))
    if package and find_spec(package) is None:
        raise StoreError(
            f'{place}: {kind.name} in {where.suffix} need {package}\nhint: pip install "stickslip[{extra}]", or write '
            f"{kind.suffixes[0]}"
        )
    if isinstance(where, Url):
        check_url(where)
        return check_writable(where)
    check_place(where, is_zarr=where.suffix == ".zarr", folder=kind.folder)


def check_url(place: Url) -> None:
    """Raises StoreError for what is no Zarr store."""
    if place.suffix != ".zarr":
        raise StoreError(
            f"{place}: behind a URL only Zarr stores are written, expected a name that ends in .zarr\n"
            "hint: netCDF is written to a file of this machine, which can be copied then"
        )


def check_place(path: Path, *, is_zarr: bool = False, is_folder: bool = False, folder: bool = True) -> None:
    """Raises StoreError if nothing can be written under a name; `folder` : whether the one it is in may be new."""
    try:
        str(path).encode()
        if long := next((part for part in path.parts if len(os.fsencode(part)) > _LONGEST_NAME), None):
            raise StoreError(f"{path}: a name of {len(os.fsencode(long))} bytes, expected at most {_LONGEST_NAME}")
        there = Path(os.path.realpath(path)) if is_folder else behind(path, zarr=is_zarr).parent
        if not folder and not there.is_dir():
            raise StoreError(f"{path}: no folder {path.parent}")
        check_folder(there)
    except StoreError:
        raise
    except UnicodeEncodeError:
        raise StoreError(f"{str(path)!r}: a name that is not text (UTF-8)") from None
    except (OSError, ValueError) as error:  # the latter of a NUL
        message = "expected a folder, or a name for a new one" if is_folder else "cannot be written"
        raise StoreError(f"{path}: {message} ({reason(error)})") from None


def check_folder(path: Path) -> None:
    """Raises OSError if no file can be made in a folder; if it is not there, in the one that it would be made in."""
    while not path.exists():
        path = path.parent
    with TemporaryFile(dir=path):
        pass
