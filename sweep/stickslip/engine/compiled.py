"""The compiled kernels: in the cache or not, and which they are."""

import os
import threading
import warnings

import llvmlite.binding as llvm

from stickslip.engine.compiling import compile_apart, stored
from stickslip.vocabulary.models import kernel_of, own_law
from stickslip_kernels import objects, runtime
from stickslip_kernels.allocate import NO_STATIONS

_loading = threading.Lock()
_machines: dict[tuple[str, bool], runtime.Kernels] = {}
_loaded: dict[tuple[str, bool], runtime.Addresses] = {}  # by the names of kernels, which several laws may share


def _free_after_fork() -> None:
    """A fresh lock: its holder is not part of the forked process."""
    global _loading
    _loading = threading.Lock()


if hasattr(os, "register_at_fork"):
    os.register_at_fork(after_in_child=_free_after_fork)


def will_compile(name: str = "stribeck", signals: bool = False) -> bool:
    """Return whether a computation with this law compiles the kernels first: once per machine, version and law.

    signals : for trajectories and rigs rather than for regimes.
    """
    return (kernel_of(name), signals) not in _loaded and not is_cached(name, signals)


def is_cached(name: str, signals: bool = False) -> bool:
    """Return whether other processes will find the kernels of a law compiled."""
    law = stored(kernel_of(name))
    return law is not None and stored(law.machine(signals)) is not None


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
        law = compile_apart(name)
        return runtime.load(law, compile_apart(law.machine(signals)), signals)
    except (OSError, RuntimeError, runtime.UnknownSymbolError) as error:
        made = _compile_here(name, signals)
        text = f"the kernels are compiled in this process, and again in the next: {error}"
        warnings.warn(text, RuntimeWarning, stacklevel=5)
        return made


def _compile_here(name: str, signals: bool) -> runtime.Addresses:
    from stickslip_kernels import contacts, exports

    _, file = contacts.of_law(name)
    functions = exports.c_functions(file, file.LAWS[name], signals)
    _compiled_here.append(functions)
    return {name: function.address for name, function in functions.items()}


_compiled_here: list[object] = []  # what holds code that was compiled here


def kernels_digest() -> str:
    """Names the kernels by their sources: equal digests compute equal bits (on one kind of machine)."""
    return objects.source_digest()


def processor() -> str:
    """The kind of processor the kernels are compiled for: another kind may round differently."""
    return objects.shipped_kind() or str(llvm.get_host_cpu_name())
