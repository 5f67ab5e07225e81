"""Replacing files: what is written appears whole or not at all, and survives a power failure.

A temporary file beside the target is written, flushed and renamed over the target, so that a crash, a full disk or
a lack of permission leaves the old file as it was.
"""

from __future__ import annotations

import glob
import hashlib
import os
import shutil
import uuid
from collections.abc import Callable, Iterator
from concurrent.futures import ThreadPoolExecutor
from contextlib import contextmanager, suppress
from pathlib import Path

from stickslip.errors import StoreError, reason
from stickslip.files import process
from stickslip.files.targets import behind

Move = Callable[[Path, Path], None]
_LONGEST_NAME = 180  # bytes of the target's name in that of the temporary file; file systems allow 255 in all


@contextmanager
def replaced(path: str | os.PathLike[str], move: Move = os.replace, *, zarr: bool = False) -> Iterator[Path]:
    """A temporary file, to be written inside `with`, that replaces the one behind `path` (`targets.behind`) at its end.

    Whatever goes wrong leaves that alone and becomes a StoreError that names it.
    """
    with _explained(path):
        target = behind(path, zarr=zarr)
        with _neighbour(target) as temporary, placed(temporary, target, move):
            yield temporary


@contextmanager
def placed(temporary: Path, target: Path, move: Move = os.replace) -> Iterator[None]:
    """Whatever is written to `temporary` inside `with` goes to `target` at its end; after an error it is removed."""
    try:
        yield
        _flush_all(temporary)
        move(temporary, target)
        flush(target.parent)
    except BaseException:
        _remove(temporary)
        raise


@contextmanager
def _explained(path: str | os.PathLike[str]) -> Iterator[None]:
    """Whatever the operating system or the netCDF library complains about becomes a StoreError that names the path."""
    try:
        yield
    except StoreError:
        raise
    except (OSError, RuntimeError) as error:  # netCDF4 reports a full disk as RuntimeError("NetCDF: HDF error")
        raise StoreError(f"{os.fspath(path)}: cannot be written ({reason(error)})") from error


@contextmanager
def _neighbour(target: Path) -> Iterator[Path]:
    """A free name in the folder of `target`, on the same disk so that a rename suffices; gone afterwards.

    So are those of processes that were killed. The folder is created if need be.
    """
    ours = f".{_short(target.name)}.{_here()}-"
    temporary = target.with_name(f"{ours}{os.getpid()}-{uuid.uuid4().hex[:8]}.part")
    try:
        target.parent.mkdir(parents=True, exist_ok=True)
        _remove_left_over(target.parent, ours)
        yield temporary
    finally:
        _remove(temporary)


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


def _short(name: str) -> str:
    """The name, or what stands for one so long that nothing could be added to it."""
    raw = os.fsencode(name)
    return name if len(raw) <= _LONGEST_NAME else hashlib.sha256(raw).hexdigest()[:16]


def _here() -> str:
    """This machine in a few characters: what others write may still be in use."""
    return hashlib.sha256(f"{process.host()} {process.space()}".encode()).hexdigest()[:8]


def _remove_left_over(folder: Path, beginning: str) -> None:
    """Remove what processes of this machine left in a folder when they were killed."""
    for path in folder.glob(f"{glob.escape(beginning)}*-*.part"):
        pid = path.name.removeprefix(beginning).partition("-")[0]
        if pid.isdigit() and not process.is_alive(int(pid)):
            _remove(path)


def _remove(path: Path) -> None:
    """Remove a file or a folder, if it is there."""
    if path.is_dir():
        shutil.rmtree(path, ignore_errors=True)
    with suppress(OSError):
        path.unlink()
