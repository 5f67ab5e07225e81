"""The compiled kernels: in the cache or not, and which they are."""

from __future__ import annotations

import os
import threading

import llvmlite.binding as llvm
import numpy as np

from stickslip.engine.compiling import compile_apart
from stickslip_kernels import block, jit, laws, layout
from stickslip_kernels.rig import block as rig_block

_loading = threading.Lock()


def _free_after_fork() -> None:
    """A lock nobody holds: whoever does is not part of the forked process."""
    global _loading
    _loading = threading.Lock()


if hasattr(os, "register_at_fork"):
    os.register_at_fork(after_in_child=_free_after_fork)


def will_compile(law: str = "stribeck", rigs: bool = False) -> bool:
    """Whether a computation with this law compiles the kernels first: once per machine, version and law."""
    return not jit.is_ready(_version(law, rigs))


def warm_up(law: str = "stribeck", rigs: bool = False) -> None:
    """Load the kernels from the cache, and have them compiled into it before if need be; one thread at a time."""
    with _loading:
        if jit.CACHE_FOLDER is not None and will_compile(law, rigs):
            compile_apart(f"load({law!r}, {rigs})", lambda: will_compile(law, rigs))
        load(law, rigs)


def load(law: str, rigs: bool = False) -> None:
    """Load the kernels of maps or of rigs, or compile them in this process: `compiling` says who should."""
    cells, control, stop = np.empty((layout.CELL_ROWS, 0)), np.array([1e-6, 1.0, 1.0]), np.zeros(1, np.int64)
    if rigs:
        none, runs = np.empty((0, layout.SEGMENT_COLUMNS)), np.empty((0, layout.RUN_COLUMNS))
        results, signals = rig_block.new_results(0), np.empty((layout.SIGNAL_ROWS, 0))
        rig_block.run_rigs(laws.LAWS[law], cells, none, runs, results, signals, rig_block.NO_STOPS, control, stop)
    else:
        block.run_block(laws.LAWS[law], cells, block.new_results(0), control, block.NO_LOG, stop)
    jit.mark_ready(_version(law, rigs))


def _version(law: str, rigs: bool) -> str:
    return f"{law}-rigs" if rigs else law


def kernels_digest() -> str:
    """Names the kernels by their sources: equal digests compute equal bits (on one kind of machine)."""
    return jit.source_digest()


def processor() -> str:
    """The kind of processor the kernels are compiled for: another kind may round differently."""
    return str(llvm.get_host_cpu_name())
