"""Compiling the kernels in a separate process.

It needs Numba, and memory, which the run does not. What it makes is a file of machine code that any number of processes
load, so that all of them run the same instructions.
"""

from __future__ import annotations

import os
import subprocess
import sys
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from stickslip_kernels import objects

Object = tuple[list[str], bytes]


def compile_apart(law: str, signals: bool) -> Object:
    """The object with the kernels of a law: from the cache, or from another process that puts it there.

    One process at a time on this machine compiles. Where no cache can be written, the object passes through a temporary
    file. Raises RuntimeError with what that process says if it fails.
    """
    name = objects.name_of(law, signals)
    if objects.CACHE_FOLDER is None:
        with tempfile.TemporaryDirectory(prefix="stickslip-") as folder:
            return _compile(law, signals, Path(folder) / name)
    path = objects.CACHE_FOLDER / name
    if found := objects.read(path):
        return found
    with _alone():
        return objects.read(path) or _compile(law, signals, path)  # another process may have been first


def _compile(law: str, signals: bool, path: Path) -> Object:
    call = f"from stickslip_kernels.building import main; main({str(law)!r}, {signals}, {str(path)!r})"
    command = [sys.executable, "-c", f"import sys; sys.path[:] = {sys.path!r}; {call}"]
    done = subprocess.run(command, check=False, capture_output=True, text=True)
    if made := objects.read(path):
        return made
    raise RuntimeError(f"no object of the kernels came of compiling them\n{done.stderr.strip()[-2000:]}")


@contextmanager
def _alone() -> Iterator[None]:
    """One process of this user and machine at a time, where the system has such locks; they end with their process."""
    try:
        import fcntl
    except ModuleNotFoundError:  # Windows
        yield
        return
    with open(Path(tempfile.gettempdir()) / f"stickslip-compiling-{os.getuid()}", "a") as file:
        fcntl.flock(file, fcntl.LOCK_EX)
        yield
