"""Compiling the kernels in a separate process.

A process that compiles continues with code that the compiler linked function by function; one that loads the result
from the cache gets the same code linked as a whole, and may differ from the first in last digits. So no process
computes with what it compiled itself: another one compiles, and all load. It also keeps the compiler's memory out of
the run.
"""

from __future__ import annotations

import os
import subprocess
import sys
import tempfile
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path


def compile_apart(load: str, missing: Callable[[], bool]) -> None:
    """Have another process put kernels into the cache, one at a time on this machine.

    load : the call of `engine` that loads them. missing : whether they are not there yet, asked again once it is our
    turn. If that process fails, nothing is reported: the caller finds nothing in the cache, compiles itself, and meets
    the error.
    """
    with _alone():
        if missing():
            code = f"import sys; sys.path[:] = {sys.path!r}; from stickslip import engine; engine.{load}"
            subprocess.run([sys.executable, "-c", code], check=False, capture_output=True)


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
