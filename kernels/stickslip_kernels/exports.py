"""C functions that are called from outside, of numbers and addresses, a machine behind each; and those of laws, which
machines call.

The caller allocates everything, the lanes too, so that nothing of Python or of Numba's runtime is needed
(`runtime.py`).
"""

import numba
from numba import types

from . import contacts, runtime
from . import layout as at
from .drive import STEADY_BELT, Segments
from .jit import FASTMATH
from .lanes import run
from .layout import Machine
from .linking import FLOATS, PREFIX, Linked, columns_at, door, signature_of, with_stations
from .observers.signals import Signals

_TYPES = {"f": types.float64, "i": types.int64, "F": FLOATS, "I": types.CPointer(types.int64)}


def of_object(name):
    """The C functions of an object by name: of the machine of a contact, or of a law linked to that."""
    contact, _, purpose = name.partition("-")
    if purpose:
        return c_functions(contacts.files()[contact], Linked(0), purpose == "signals")
    file, tag = contacts.of_law(name)
    calls = {PREFIX + function.__name__: function for function in file.LINKED}
    return {symbol: _c_function(door(function, tag), signature_of(function)) for symbol, function in calls.items()}


def c_functions(contact, law, signals):
    """The C functions of a contact under a law, by name; they compile here (`numba.cfunc`)."""
    functions = _signals_of(contact, law) if signals else _regimes_of(contact, law)
    return {name: _c_function(functions[name], types.int64(*(_TYPES[kind] for kind in kinds)))
            for name, kinds in runtime.exports(signals).items()}  # fmt: skip


def _c_function(function, signature):
    return numba.cfunc(signature, error_model="numpy", fastmath=FASTMATH, _nrt=False)(function)


def _regimes_of(file, tag):
    contact, regimes = file.TAG, file.REGIMES

    def run_regimes(stations, cells, n, rtol, max_steps, stop, lanes, results, room, until):
        law, columns = with_stations(tag, stations), columns_at(cells, (at.CELL_ROWS, n))
        observer = regimes(columns_at(results, (at.RESULT_ROWS, room)), until)
        run(Machine(contact, law, STEADY_BELT, observer, lanes, columns, rtol, max_steps), stop)
        return 0

    def friction(stations, cells, n, speeds, found):
        law, columns = with_stations(tag, stations), columns_at(cells, (at.CELL_ROWS, n))
        for c in range(n):
            found[c] = contacts.steady_friction(contact, law, columns, c, speeds[c])
        return 0

    return {"run_regimes": run_regimes, "friction": friction}


def _signals_of(file, tag):
    contact = file.TAG

    def run_signals(
        stations, cells, n, rtol, max_steps, stop, lanes, results, runs, signals, samples, stops, rows, table, pieces,
        spans,
    ):  # fmt: skip
        observer = Signals(
            columns_at(results, (at.RIG_ROWS, n)),
            columns_at(runs, (n, at.RUN_COLUMNS)),
            columns_at(signals, (at.SIGNAL_ROWS, samples)),
            columns_at(stops, (rows, at.STOP_COLUMNS)),
        )
        drive = Segments(columns_at(table, (pieces, at.SEGMENT_COLUMNS)), columns_at(spans, (n, 2)))
        law, columns = with_stations(tag, stations), columns_at(cells, (at.CELL_ROWS, n))
        run(Machine(contact, law, drive, observer, lanes, columns, rtol, max_steps), stop)
        return 0

    return {"run_signals": run_signals}
