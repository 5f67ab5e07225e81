"""Targets of results: checked before an hour of computing, and replaced whole or not at all.

A temporary file beside the target is written, flushed and renamed over it: a crash, a full disk or a lack of permission
leaves the old file as it was, and what is new survives a power failure. All that writes goes through `replaced`, all
that is asked to write later through `check_target`.

Services that keep objects behind URLs have no rename. A new Zarr store there is written once the older one is removed,
and its root lists no arrays before the end, which says that nothing whole is there.
"""

import glob
import hashlib
import os
import re
import socket
import stat
import uuid
from collections.abc import Collection, Iterable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field
from importlib.util import find_spec
from pathlib import Path
from tempfile import TemporaryFile

from stickslip.errors import StoreError, reason
from stickslip.files.locations import ROOT, Check, Move, Url, location, placed, remove

_ZARR_MARKERS = (ROOT, ".zgroup")
_LONGEST_NAME = 255  # bytes, of a file
_LONGEST_TARGET = 180  # bytes of the target's name in that of the temporary file
_PART = re.compile(r"(?P<machine>[0-9a-f]{8})-(?P<pid>\d+)-[0-9a-f]{8}\.part")
NO_FILE_NAME = re.compile(r"[^\w.+-]+")  # what names of files that are made up do without


# --- checked beforehand -----------------------------------------------------------------------------------------------


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
    "page": Kind("pages", (".html", ".htm")),
}


def kinds_of(kinds: Iterable[str | Kind]) -> list[Kind]:
    """The kinds of files of these names; a `folder` is none."""
    return [kind if isinstance(kind, Kind) else KINDS[kind] for kind in kinds if kind != "folder"]


def check_target(place: str | os.PathLike[str], *kinds: str | Kind) -> None:
    """Raises StoreError now if a file of one of these `KINDS`, or a `folder` of files, could not be written later.

    kinds : by name, or those of an extension themselves.
    """
    where = location(place)
    possible = kinds_of(kinds)
    kind = next((kind for kind in possible if where.suffix.lower() in kind.suffixes), None)
    if kind is None and "folder" in kinds:
        if not isinstance(where, Path) or (where.exists() and not where.is_dir()):
            raise StoreError(f"{place}: expected a folder, or a name for a new one")
        return _check_place(where, is_folder=True)
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
        return _check_writable(where)
    _check_place(where, is_zarr=where.suffix == ".zarr", folder=kind.folder)


def check_url(place: Url) -> None:
    """Raises StoreError for what is no Zarr store."""
    if place.suffix != ".zarr":
        raise StoreError(
            f"{place}: behind a URL only Zarr stores are written, expected a name that ends in .zarr\n"
            "hint: netCDF is written to a file of this machine, which can be copied then"
        )


def _check_place(path: Path, *, is_zarr: bool = False, is_folder: bool = False, folder: bool = True) -> None:
    """Raises StoreError if nothing can be written under a name; `folder` : whether the one it is in may be new."""
    try:
        str(path).encode()
        if long := next((part for part in path.parts if len(os.fsencode(part)) > _LONGEST_NAME), None):
            raise StoreError(f"{path}: a name of {len(os.fsencode(long))} bytes, expected at most {_LONGEST_NAME}")
        there = Path(os.path.realpath(path)) if is_folder else _behind(path, zarr=is_zarr).parent
        if not folder and not there.is_dir():
            raise StoreError(f"{path}: no folder {path.parent}")
        with TemporaryFile(dir=next(parent for parent in (there, *there.parents) if parent.exists())):
            pass
    except StoreError:
        raise
    except UnicodeEncodeError:
        raise StoreError(f"{str(path)!r}: a name that is not text (UTF-8)") from None
    except (OSError, ValueError) as error:  # the latter of a NUL
        message = "expected a folder, or a name for a new one" if is_folder else "cannot be written"
        raise StoreError(f"{path}: {message} ({reason(error)})") from None


def _behind(path: str | os.PathLike[str], *, zarr: bool = False) -> Path:
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


# --- replaced ---------------------------------------------------------------------------------------------------------


@contextmanager
def replaced(
    path: str | os.PathLike[str],
    move: Move = os.replace,
    check: Check | None = None,
    *,
    zarr: bool = False,
) -> Iterator[Path]:
    """A temporary file, to be written inside `with`, that replaces the one behind `path` at its end.

    Whatever goes wrong leaves that alone and becomes a StoreError that names it. check : as for `placed`.
    """
    try:
        target = _behind(path, zarr=zarr)
        with _neighbour(target) as temporary, placed(temporary, target, move, check):
            yield temporary
    except StoreError:
        raise
    except (OSError, RuntimeError) as error:  # netCDF4 reports a full disk as RuntimeError("NetCDF: HDF error")
        raise StoreError(f"{os.fspath(path)}: cannot be written ({reason(error)})") from error


@contextmanager
def _neighbour(target: Path) -> Iterator[Path]:
    """A name in the folder of `target`, on the same disk so that a rename suffices; gone afterwards.

    So are those that processes of this machine left when they were killed; what others write may still be in use. The
    folder is created if need be.
    """
    raw = os.fsencode(target.name)
    short = target.name if len(raw) <= _LONGEST_TARGET else hashlib.sha256(raw).hexdigest()[:16]
    here = hashlib.sha256(f"{host()} {space()}".encode()).hexdigest()[:8]
    temporary = target.with_name(f".{short}.{here}-{os.getpid()}-{uuid.uuid4().hex[:8]}.part")
    try:
        target.parent.mkdir(parents=True, exist_ok=True)
        for path in target.parent.glob(f".{glob.escape(short)}.*-*-*.part"):
            writer = _PART.fullmatch(path.name[len(short) + 2 :])  # None: of another target
            if writer and writer["machine"] == here and not is_alive(int(writer["pid"])):
                remove(path)
        yield temporary
    finally:
        remove(temporary)


# --- stores behind URLs -----------------------------------------------------------------------------------------------


def _check_writable(target: Url) -> None:
    """Raise StoreError now if `begin_store` would fail later."""
    key = ".probe" if _keys_of_ours(target) else ROOT
    target.put(key, b"")
    target.remove(key)


def begin_store(target: Url) -> None:
    """Make room for a new store; the empty root says that what is there is ours, and not whole."""
    there = _keys_of_ours(target)
    target.put(ROOT, b"")
    target.remove(*{key.partition("/")[0] for key in there} - {ROOT})


def _keys_of_ours(target: Url) -> Collection[str]:
    """The objects of a store, or of a part of one. Raises StoreError for something else."""
    there = target.keys()
    if there and ROOT not in there:
        raise StoreError(f"{target}: exists and is not a Zarr store, so it is left alone")
    return there


# --- by whom ----------------------------------------------------------------------------------------------------------


def host() -> str:
    """Name of this machine."""
    return socket.gethostname()


def space() -> str:
    """Within which process numbers mean something: containers may share the name of their host."""
    try:
        return os.readlink("/proc/self/ns/pid")
    except OSError:
        return ""


def is_alive(pid: int) -> bool:
    """Tell whether a process of this machine runs; True where that cannot be asked without harm (Windows)."""
    if os.name == "nt":
        return True
    if pid <= 0:  # to the system a group of processes
        return False
    try:
        os.kill(pid, 0)
    except (ProcessLookupError, OverflowError):
        return False
    except OSError:  # of another user
        pass
    return True
