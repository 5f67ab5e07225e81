"""The compiled kernels as functions of arrays; Numba is not needed for it.

The loader of LLVM puts an object into memory and links it with the mathematics of the C library. The calls are those
of C, without the interpreter's lock.
"""

from __future__ import annotations

import ctypes
from collections.abc import Mapping
from typing import Any

import llvmlite.binding as llvm
import numpy as np
from numpy.typing import NDArray

from . import layout as at
from .layout import NO_STATIONS, NO_STOPS
from .objects import Object

# The functions of an object (`exports.py`) by the kinds of their arguments, all of 64 bits: f, i a number, F, I the
# address of an array of them. They return an integer that means nothing.
REGIMES = {
    "run_regimes": "FFiffIFFii",  # stations, cells, n, rtol, max_steps, stop, lanes, results, their columns, until
    "friction": "FFiFF",  # stations, cells, n, speeds, coefficients
}
SIGNALS = {
    # stations, cells, n, rtol, max_steps, stop, lanes, results, runs, signals, samples, stops, their rows, segments,
    # their number, spans
    "run_signals": "FFiffIFFFFiFiFiF",
}
_C_TYPES: dict[str, Any] = {"f": ctypes.c_double, "i": ctypes.c_int64, "F": ctypes.c_void_p, "I": ctypes.c_void_p}

LINE = 8  # numbers in a line of the cache

Addresses = Mapping[str, int]
Floats = NDArray[np.float64]
StopFlag = NDArray[np.int64]
_loaded: list[Any] = []  # what holds the code; it is never given back, since a thread may be running it


class UnknownSymbolError(Exception):
    """An object expects a function that this process does not have, or lacks one that is called."""


def exports(signals: bool) -> dict[str, str]:
    """The functions of an object for maps or for signals, and the kinds of their arguments."""
    return SIGNALS if signals else REGIMES


def load(law: Object, machine: Object, signals: bool) -> Addresses:
    """Addresses of the functions of a machine, which is linked to a law and loaded into this process for good."""
    llvm.initialize_native_target()
    llvm.initialize_native_asmprinter()
    target = llvm.Target.from_triple(llvm.get_process_triple())
    engine = llvm.create_mcjit_compiler(llvm.parse_assembly(""), target.create_target_machine(jit=True))
    for part in (law, machine):
        if missing := [name for name in part.symbols if not (llvm.address_of_symbol(name) or _is_in(engine, name))]:
            raise UnknownSymbolError(f"no function {', '.join(missing)} in this process")  # the loader would end it
        engine.add_object_file(llvm.ObjectFileRef.from_data(part.code))
        engine.finalize_object()
    _loaded.append(engine)
    addresses = {name: engine.get_function_address(name) for name in exports(signals)}
    if lacking := [name for name, address in addresses.items() if not address]:
        raise UnknownSymbolError(f"no function {', '.join(lacking)} in the object")
    return addresses


def _is_in(engine: Any, name: str) -> bool:
    """Return whether a law that is loaded has this function."""
    return name.startswith("law.") and bool(engine.get_function_address(name))


class Kernels:
    """The kernels of one friction law, for maps or for signals. Calls are serial, and may be made from any thread.

    stations : float64 (STATION_ROWS, STATIONS), of a table.
    """

    def __init__(self, addresses: Addresses, signals: bool, stations: Floats = NO_STATIONS) -> None:
        self.stations = stations
        self._law = _at(stations, (at.STATION_ROWS, at.STATIONS))
        self._functions: dict[str, Any] = {}
        for name, kinds in exports(signals).items():
            prototype = ctypes.CFUNCTYPE(ctypes.c_int64, *(_C_TYPES[kind] for kind in kinds))
            self._functions[name] = prototype(addresses[name])

    def run_regimes(
        self, cells: Floats, rtol: float, max_steps: float, stop: StopFlag, results: Floats, until: int
    ) -> None:
        """Integrate every cell of a block on its steady belt, and say what becomes of it.

        cells : float64 (CELL_ROWS, n), kernel units. rtol, max_steps : tolerance of a step, trial steps a cell may
            take. stop : int64 (1,); when another thread sets it, the block is abandoned, and unfinished cells stay
            "not computed".
        results : float64 (RESULT_ROWS, n or more) from `layout.new_regimes`. until : how far a cell is followed, a
            code of `layout.py`; UNTIL_REGIME leaves the other metrics NaN, but for the margins.
        """
        n, room, lanes = cells.shape[1], results.shape[1], _lanes()
        if room < n:
            raise ValueError(f"results of {n} cells in {room} columns")
        self._functions["run_regimes"](
            self._law, _at(cells, (at.CELL_ROWS, n)), n, rtol, max_steps, _at(stop, (1,), np.int64), lanes.ctypes.data,
            _at(results, (at.RESULT_ROWS, room)), room, until,
        )  # fmt: skip

    def run_signals(
        self, cells: Floats, rtol: float, max_steps: float, stop: StopFlag, drive: tuple[Floats, Floats],
        results: Floats, runs: Floats, signals: Floats, stops: Floats = NO_STOPS,
    ) -> None:  # fmt: skip
        """Integrate every cell of a block on a belt that follows segments, and sample its motion.

        cells, rtol, max_steps, stop : as for `run_regimes`; BELT and HORIZON are not used.
        drive : segments, float64 (any, SEGMENT_COLUMNS), and by cell the first of its own and the one past its last,
            float64 (n, 2). results : float64 (RIG_ROWS, n) from `layout.new_signals`.
        runs : float64 (n, RUN_COLUMNS), where each cell puts its samples. signals : float64 (SIGNAL_ROWS, any); what is
            not reached stays as it was. stops : a table of stick phases (any, STOP_COLUMNS), for n = 1, or NO_STOPS.
        """
        n, lanes, (segments, spans) = cells.shape[1], _lanes(), drive
        samples, rows, pieces = signals.shape[1], stops.shape[0], segments.shape[0]
        self._functions["run_signals"](
            self._law, _at(cells, (at.CELL_ROWS, n)), n, rtol, max_steps, _at(stop, (1,), np.int64), lanes.ctypes.data,
            _at(results, (at.RIG_ROWS, n)), _at(runs, (n, at.RUN_COLUMNS)), _at(signals, (at.SIGNAL_ROWS, samples)),
            samples, _at(stops, (rows, at.STOP_COLUMNS)), rows, _at(segments, (pieces, at.SEGMENT_COLUMNS)), pieces,
            _at(spans, (n, 2)),
        )  # fmt: skip

    def friction(self, cells: Floats, speeds: Floats) -> Floats:
        """Friction coefficient of each cell (CELL_ROWS, n) at a slip speed >= 0 of its own."""
        found, n = np.empty(speeds.size), speeds.size
        self._functions["friction"](self._law, _at(cells, (at.CELL_ROWS, n)), n, _at(speeds, (n,)), found.ctypes.data)
        return found


def _lanes() -> Floats:
    """The buffer of the lanes, at a line of the cache: loads of whole registers cross none."""
    room = np.zeros(at.LANE_NUMBERS + LINE)
    first = -(room.ctypes.data >> 3) % LINE
    return room[first : first + at.LANE_NUMBERS]


def _at(array: NDArray[Any], shape: tuple[int, ...], kind: type = np.float64) -> int:
    """Address of an array, which must be as the kernels expect it: they look at nothing but numbers."""
    if array.shape != shape or array.dtype != kind or not array.flags.c_contiguous:
        raise ValueError(f"expected a C-contiguous array of {kind.__name__}, shape {shape}, got {array.dtype}")
    return array.ctypes.data
