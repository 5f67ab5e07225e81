"""Compiling the kernels in a separate process.

It needs Numba, and memory, which the run does not. What it makes is a file of machine code that any number of processes
load, so that all of them run the same instructions.
"""

import logging
import os
import subprocess
import sys
import warnings
from collections.abc import Mapping, Sequence
from contextlib import suppress
from pathlib import Path
from time import perf_counter

from stickslip_kernels import objects
from stickslip_kernels.objects import Object

_log = logging.getLogger("stickslip")  # of what has to be known while it lasts; Python writes it to standard error
_OWN_FOLDER = "name a folder of your own by the environment variable NUMBA_CACHE_DIR"
_WITH_ITS_PARENT = (
    "import os, threading; threading.Thread(target=lambda: (os.read(0, 1), os._exit(1)), daemon=True).start(); "
)


def stored(name: str) -> Object | None:
    """The object of this name, of the package or from the cache."""
    if brought := objects.shipped(name):
        return brought
    return None if objects.CACHE_FOLDER is None else objects.read(objects.CACHE_FOLDER / objects.file_of(name))


def compile_apart(name: str) -> Object:
    """The object of this name: of the package, from the cache, or of another process, then put there.

    Processes that begin at once each compile, and the last one's file stays, which is renamed whole. Warns, once the
    kernels are there, where they could not be kept. Raises RuntimeError with what the other process says if it fails.
    """
    if brought := objects.shipped(name):
        return brought
    if objects.CACHE_FOLDER is None:
        made = _compile(name)
        _warn_not_compiled_here(objects.NO_CACHE)
        return made
    path = objects.CACHE_FOLDER / objects.file_of(name)
    if cached := _cached(path):
        return cached
    made = _compile(name)
    try:
        objects.write(path, made)
    except OSError as error:
        _warn_not_compiled_here(f"{path.parent}: {error.strerror}")
    return made


def _warn_not_compiled_here(why: str) -> None:
    text = f"the compiled kernels were not kept, and each process compiles them again ({why}): {_OWN_FOLDER}"
    warnings.warn(text, RuntimeWarning, stacklevel=6)


def _cached(path: Path) -> Object | None:
    """The object in a file, if it may be loaded; a warning says why one may not."""
    cached = objects.read(path)
    if cached is None:
        with suppress(OSError):
            why = objects.objection(path.lstat()) or "damaged"
            warnings.warn(f"{path}: {why}; the kernels are compiled again", RuntimeWarning, stacklevel=6)
    return cached


def _compile(name: str) -> Object:
    began = perf_counter()
    _log.info("Compiling %s for this machine, once ...", name)
    made = _made(name, objects.file_of(name), {})
    _log.info("Compiled in %.0f s.", perf_counter() - began)
    return made


def ship(folder: Path, laws: Sequence[str], kinds: Sequence[str]) -> list[Path]:
    """Write the objects of laws for kinds of processors (`objects.KINDS`), for a wheel to bring, and give their files.

    Where `folder` is `objects.shipped_folder()`, the next wheel has them. A machine takes some 11 s, a law 3 to 6.
    """
    folder.mkdir(parents=True, exist_ok=True)
    written: list[Path] = []

    def put(name: str, kind: str) -> Object:
        file = objects.shipped_file(name, kind)
        made = _made(name, file, {"NUMBA_CPU_NAME": kind, "NUMBA_CPU_FEATURES": ""})
        objects.write(folder / file, made)
        written.append(folder / file)
        return made

    for kind in kinds:
        machines = {made.machine(signals) for made in [put(law, kind) for law in laws] for signals in (False, True)}
        for machine in sorted(machines):
            put(machine, kind)
    return written


def _made(name: str, file: str, settings: Mapping[str, str]) -> Object:
    """The object of this name, from another process with these settings. Raises RuntimeError with what that says."""
    done = _python(f"from stickslip_kernels.building import main; main({name!r}, {file!r})", settings)
    if made := objects.unpacked(file, done.stdout):
        return made
    end = f"killed by signal {-done.returncode}" if done.returncode < 0 else done.stderr.decode(errors="replace")
    raise RuntimeError(f"no object {name} came of compiling the kernels\n{end.strip()[-2000:]}")


def _python(script: str, settings: Mapping[str, str]) -> subprocess.CompletedProcess[bytes]:
    """A script run by another process, with the modules of this one; if this one is killed, so that nobody waits for
    what it makes, its standard input ends, and it ends, too.
    """
    command = [sys.executable, "-c", f"{_WITH_ITS_PARENT}import sys; sys.path[:] = {sys.path!r}; {script}"]
    theirs, ours = os.pipe()
    try:
        environment = {**os.environ, **settings}
        return subprocess.run(command, check=False, stdin=theirs, capture_output=True, env=environment)
    finally:
        os.close(theirs)
        os.close(ours)
