"""C functions that are called from outside, of numbers and addresses, one machine behind each.

The caller allocates everything, the lanes too, so that nothing of Python or of Numba's runtime is needed
(`runtime.py`).
"""

import numba
from llvmlite import ir
from numba import types
from numba.core import cgutils
from numba.extending import intrinsic
from numba.np.arrayobj import populate_array

from . import contacts, runtime
from . import layout as at
from .block import run
from .contacts.stribeck.laws import with_stations
from .drive import STEADY_BELT, Segments
from .machine import Machine
from .observers.signals import Signals

_TYPES = {"f": types.float64, "i": types.int64, "F": types.CPointer(types.float64), "I": types.CPointer(types.int64)}


def c_functions(law, signals):
    """The C functions for maps or for signals of a law, by name; they compile here (`numba.cfunc`)."""
    tags = contacts.tags_of(law)
    functions = _signals_of(*tags[:2]) if signals else _regimes_of(*tags)
    return {name: _c_function(functions[name], kinds) for name, kinds in runtime.exports(signals).items()}


def _c_function(function, kinds):
    signature = types.int64(*(_TYPES[kind] for kind in kinds))
    return numba.cfunc(signature, error_model="numpy", fastmath={"contract"}, _nrt=False)(function)


def _regimes_of(contact, tag, regimes):
    def run_regimes(stations, cells, n, rtol, max_steps, stop, lanes, results, room, until):
        law = with_stations(tag, array_at(stations, (at.STATION_ROWS, at.STATIONS)))
        observer = regimes(array_at(results, (at.RESULT_ROWS, room)), until)
        columns, s = array_at(cells, (at.CELL_ROWS, n)), array_at(lanes, (at.LANE_NUMBERS,))
        run(Machine(contact, law, STEADY_BELT, observer, s, columns, rtol, max_steps), array_at(stop, (1,)))
        return 0

    def friction(stations, cells, n, speeds, found):
        law = with_stations(tag, array_at(stations, (at.STATION_ROWS, at.STATIONS)))
        columns, w, mu = array_at(cells, (at.CELL_ROWS, n)), array_at(speeds, (n,)), array_at(found, (n,))
        for c in range(n):
            mu[c] = contacts.steady_friction(contact, law, columns, c, w[c])
        return 0

    return {"run_regimes": run_regimes, "friction": friction}


def _signals_of(contact, tag):
    def run_signals(
        stations, cells, n, rtol, max_steps, stop, lanes, results, runs, signals, samples, stops, rows, table, pieces,
        spans,
    ):  # fmt: skip
        law = with_stations(tag, array_at(stations, (at.STATION_ROWS, at.STATIONS)))
        observer = Signals(
            array_at(results, (at.RIG_ROWS, n)),
            array_at(runs, (n, at.RUN_COLUMNS)),
            array_at(signals, (at.SIGNAL_ROWS, samples)),
            array_at(stops, (rows, at.STOP_COLUMNS)),
        )
        drive = Segments(array_at(table, (pieces, at.SEGMENT_COLUMNS)), array_at(spans, (n, 2)))
        columns, s = array_at(cells, (at.CELL_ROWS, n)), array_at(lanes, (at.LANE_NUMBERS,))
        run(Machine(contact, law, drive, observer, s, columns, rtol, max_steps), array_at(stop, (1,)))
        return 0

    return {"run_signals": run_signals}


@intrinsic
def array_at(typing_context, address, shape):
    """The C-contiguous array at an address. (`numba.carray` counts references.)"""

    def generate(context, builder, signature, arguments):
        array = context.make_array(signature.return_type)(context, builder)
        extents, itemsize = cgutils.unpack_tuple(builder, arguments[1]), ir.Constant(ir.IntType(64), 8)
        strides = [itemsize]
        for extent in extents[:0:-1]:
            strides.insert(0, builder.mul(strides[0], extent))
        populate_array(array, arguments[0], extents, strides, itemsize, meminfo=None)
        return array._getvalue()

    return types.Array(address.dtype, len(shape), "C")(address, shape), generate
