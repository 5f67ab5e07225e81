"""What is written: checked before an hour of computing, then replaced whole or not at all.

A temporary file beside the target is written, flushed and renamed over it: a crash, a full disk or a lack of permission
leaves the old file as it was, and what is new survives a power failure. All that writes results goes through
`replaced`, all that is asked to write later through `check_target`.

A working store is a `Folder`: it holds bytes under names, each written in that way. Whatever the system complains about
comes out as a StoreError with path, reason and remedy; a name that is not there as FileNotFoundError.
"""

import errno
import glob
import hashlib
import os
import re
import shutil
import socket
import stat
import uuid
from collections.abc import Callable, Iterable, Iterator
from concurrent.futures import ThreadPoolExecutor
from contextlib import contextmanager, suppress
from dataclasses import dataclass, field
from importlib.util import find_spec
from pathlib import Path
from tempfile import TemporaryFile

from stickslip.errors import StoreError, reason
from stickslip.files.locations import ROOT, Url, explained, location

TEMPORARY = ".tmp"  # suffix of what is not written yet in a folder
_ZARR_MARKERS = (ROOT, ".zgroup")
_LONGEST_NAME = 255  # bytes, of a file
_LONGEST_TARGET = 180  # bytes of the target's name in that of the temporary file
_PART = re.compile(r"(?P<machine>[0-9a-f]{8})-(?P<pid>\d+)-[0-9a-f]{8}\.part")
NO_FILE_NAME = re.compile(r"[^\w.+-]+")  # what names of files that are made up do without
Move = Callable[[Path, Path], None]


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
    where, possible = location(place), kinds_of(kinds)
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
        return where.check_writable()
    _check_place(where, is_zarr=where.suffix == ".zarr", folder=kind.folder)


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
def replaced(path: str | os.PathLike[str], *, zarr: bool = False) -> Iterator[Path]:
    """A temporary file, or `zarr` folder, to be written inside `with`, that replaces the one behind `path` at its end.

    Whatever goes wrong leaves that alone and becomes a StoreError that names it.
    """
    try:
        target = _behind(path, zarr=zarr)
        with _neighbour(target) as temporary:
            with placed(temporary, target, _replace_folder if zarr else os.replace):
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
                _remove(path)
        yield temporary
    finally:
        _remove(temporary)


@contextmanager
def placed(temporary: Path, target: Path, move: Move) -> Iterator[None]:
    """Whatever is written to `temporary` inside `with` goes to `target` at its end; after an error it is removed."""
    try:
        yield
        _flush_all(temporary)
        move(temporary, target)
        _flush(target.parent)
    except BaseException:
        _remove(temporary)
        raise


def _replace_folder(temporary: Path, target: Path) -> None:
    """Rename a folder over another one, which no system does in one go.

    A crash between both renames leaves both, the old one named ``.NAME....old``.
    """
    if not target.exists():
        return os.replace(temporary, target)
    old = temporary.with_suffix(".old")
    os.replace(target, old)
    try:
        os.replace(temporary, target)
    except OSError:
        os.replace(old, target)
        raise
    shutil.rmtree(old)


def _flush(path: Path) -> None:
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
        return _flush(path)
    with ThreadPoolExecutor(8) as pool:
        list(pool.map(_flush, [Path(parent) / name for parent, _, names in os.walk(path) for name in names]))


def _remove(path: Path) -> None:
    """Remove a file or a folder, if it is there."""
    if path.is_dir():
        shutil.rmtree(path, ignore_errors=True)
    with suppress(OSError):
        path.unlink()


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

    def write(self, name: str, data: bytes, move: Move = os.replace) -> None:
        """Write to a temporary name, flush, rename, flush the folder."""
        temporary = self.path / f".{name}.{uuid.uuid4().hex}{TEMPORARY}"
        with explained(str(self.path / name), "written"):
            self._make()
            with placed(temporary, self.path / name, move):
                temporary.write_bytes(data)

    def create(self, name: str, data: bytes) -> None:
        """As `write`, by a link, which never replaces. Raises FileExistsError."""
        self.write(name, data, _link)

    def remove(self, name: str) -> None:
        """Remove a name."""
        with explained(str(self.path / name), "removed"):
            (self.path / name).unlink(missing_ok=True)

    def rmdir(self) -> None:
        """Remove the folder, if it is empty."""
        with suppress(OSError):
            self.path.rmdir()

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
        _flush(self.path.absolute().parent)


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
