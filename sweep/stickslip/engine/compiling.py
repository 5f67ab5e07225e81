"""The compiled kernels: in the cache or not, which they are, and compiling them in a separate process.

That needs Numba, and memory, which the run does not. What it makes is a file of machine code that any number of
processes load, so that all of them run the same instructions.
"""

import logging
import os
import subprocess
import sys
import threading
import warnings
from collections.abc import Mapping
from concurrent.futures import ThreadPoolExecutor
from contextlib import suppress
from pathlib import Path
from time import perf_counter

import llvmlite.binding as llvm

from stickslip.vocabulary.models import kernel_of, own_law
from stickslip_kernels import objects, runtime
from stickslip_kernels.layout import NO_STATIONS
from stickslip_kernels.objects import Object

_log = logging.getLogger("stickslip")  # of what has to be known while it lasts; Python writes it to standard error
_OWN_FOLDER = "name a folder of your own by the environment variable NUMBA_CACHE_DIR"
_WITH_ITS_PARENT = (
    "import os, threading; threading.Thread(target=lambda: (os.read(0, 1), os._exit(1)), daemon=True).start(); "
)
_loading = threading.Lock()
_machines: dict[tuple[str, bool], runtime.Kernels] = {}
_loaded: dict[tuple[str, bool], runtime.Addresses] = {}  # by the names of kernels, which several laws may share


def will_compile(name: str = "stribeck", signals: bool = False) -> bool:
    """Return whether a computation with this law compiles the kernels first: once per machine, version and law.

    signals : for trajectories and rigs rather than for regimes.
    """
    return (kernel_of(name), signals) not in _loaded and not is_cached(name, signals)


def is_cached(name: str, signals: bool = False) -> bool:
    """Return whether other processes will find the kernels of a law compiled."""
    law = kernel_of(name)
    return None not in (stored(law), stored(objects.machine_of(objects.contact_of(law), signals)))


def warm_up(name: str = "stribeck", signals: bool = False) -> None:
    """Load the kernels from the cache, and have them compiled into it before if need be; one thread at a time."""
    kernels(name, signals)


def kernels(name: str, signals: bool = False) -> runtime.Kernels:
    """The kernels of a law for regimes or for signals, as `warm_up` gets them."""
    key, own = (kernel_of(name), signals), own_law(name)
    stations = NO_STATIONS if own is None else own.stations
    machine = _machines.get((name, signals))
    if machine is None or machine.stations is not stations:  # a law of one's own may have been registered anew
        with _loading:
            if key not in _loaded:
                _loaded[key] = _addresses(*key)
        machine = _machines[name, signals] = runtime.Kernels(_loaded[key], signals, stations)
    return machine


def _addresses(name: str, signals: bool) -> runtime.Addresses:
    try:
        machine = objects.machine_of(objects.contact_of(name), signals)
        with ThreadPoolExecutor(2) as pool:  # side by side, where both are compiled
            law, of_contact = pool.map(compile_apart, (name, machine))
        return runtime.load(law, of_contact, signals)
    except (OSError, RuntimeError, runtime.UnknownSymbolError) as error:
        made = _compile_here(name, signals)
        text = f"the kernels are compiled in this process, and again in the next: {error}"
        warnings.warn(text, RuntimeWarning, stacklevel=5)
        return made


def _compile_here(name: str, signals: bool) -> runtime.Addresses:
    from stickslip_kernels import contacts, exports

    file, tag = contacts.of_law(name)
    functions = exports.c_functions(file, tag, signals)
    _compiled_here.append(functions)
    return {name: function.address for name, function in functions.items()}


_compiled_here: list[object] = []  # what holds code that was compiled here


def kernels_digest() -> str:
    """Names the kernels by their sources: equal digests compute equal bits (on one kind of machine)."""
    return objects.source_digest()


def processor() -> str:
    """The kind of processor the kernels are compiled for: another kind may round differently."""
    return objects.shipped_kind() or str(llvm.get_host_cpu_name())


# --- in another process -----------------------------------------------------------------------------------------------


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
    made = compiled(name, objects.file_of(name), {})
    _log.info("Compiled in %.0f s.", perf_counter() - began)
    return made


def compiled(name: str, file: str, settings: Mapping[str, str]) -> Object:
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
