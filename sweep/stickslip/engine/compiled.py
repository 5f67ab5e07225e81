"""The compiled kernels: in the cache or not, and which they are."""

from __future__ import annotations

import os
import threading
from typing import Any

import llvmlite.binding as llvm
import numpy as np
from numpy.typing import NDArray

from stickslip.engine.compiling import compile_apart
from stickslip_kernels import block, drive, jit, laws, layout

_loading = threading.Lock()


def _free_after_fork() -> None:
    """A fresh lock: its holder is not part of the forked process."""
    global _loading
    _loading = threading.Lock()


if hasattr(os, "register_at_fork"):
    os.register_at_fork(after_in_child=_free_after_fork)


def will_compile(law: str = "stribeck", signals: bool = False) -> bool:
    """Whether a computation with this law compiles the kernels first: once per machine, version and law.

    signals : for trajectories and rigs rather than for regimes.
    """
    return not jit.is_ready(_version(law, signals))


def warm_up(law: str = "stribeck", signals: bool = False) -> None:
    """Load the kernels from the cache, and have them compiled into it before if need be; one thread at a time."""
    with _loading:
        if jit.CACHE_FOLDER is not None and will_compile(law, signals):
            compile_apart(f"load({law!r}, {signals})", lambda: will_compile(law, signals))
        load(law, signals)


def load(law: str, signals: bool = False) -> None:
    """Load the kernels of regimes or of signals, or compile them in this process: `compiling` says who should."""
    cells = np.empty((layout.CELL_ROWS, 0))
    if signals:
        belts = drive.Segments(np.empty((0, layout.SEGMENT_COLUMNS)), np.empty((0, 2)))
        observer = block.signals.Signals(
            block.signals.new_results(0),
            np.empty((0, layout.RUN_COLUMNS)),
            np.empty((layout.SIGNAL_ROWS, 0)),
            block.signals.NO_STOPS,
        )
        run(law, belts, observer, cells, 1e-6, 1)
    else:
        run(law, drive.STEADY_BELT, block.regime.Regime(block.regime.new_results(0), True), cells, 1e-6, 1)
    jit.mark_ready(_version(law, signals))


def run(
    law: str, belts: Any, observer: Any, cells: NDArray[np.float64], rtol: float, max_steps: int,
    stop: NDArray[np.int64] | None = None,
) -> None:  # fmt: skip
    """`block.run_block`, with arguments of the types it has been compiled for."""
    stop = np.zeros(1, np.int64) if stop is None else stop
    block.run_block(laws.LAWS[law], belts, observer, cells, float(rtol), float(max_steps), stop)


def _version(law: str, signals: bool) -> str:
    return f"{law}-signals" if signals else law


def kernels_digest() -> str:
    """Names the kernels by their sources: equal digests compute equal bits (on one kind of machine)."""
    return jit.source_digest()


def processor() -> str:
    """The kind of processor the kernels are compiled for: another kind may round differently."""
    return str(llvm.get_host_cpu_name())
