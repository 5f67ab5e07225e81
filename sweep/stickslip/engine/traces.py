"""Cells over time: rigs whose drive is a single segment."""

import numpy as np
from numpy.typing import NDArray

from stickslip.engine.dispatch import run_signals
from stickslip.engine.options import Options, Results
from stickslip.engine.scales import signals_to_si, to_kernel
from stickslip.engine.threads import stop_flag
from stickslip.errors import NotReachedError
from stickslip.vocabulary.cells import Parameters
from stickslip.vocabulary.flags import STATUS_MESSAGES, STATUSES
from stickslip.vocabulary.scales import Scales
from stickslip_kernels import layout
from stickslip_kernels.allocate import new_signals

Floats = NDArray[np.float64]

_BEYOND = 0.01  # of a step: how far past its last sample a motion is integrated, so that rounding does not lose it


def trajectory(cell: Parameters, times: NDArray[np.float64], options: Options) -> Results:
    """The motion of one cell (arrays of length 1) at `times` (s, evenly spaced, from 0), by names of `TRACE_VARIABLES`.

    The stepping is that of `compute`. Raises NotReachedError if the integration does not reach the last time.
    """
    horizon, rate = max(float(times[-1]), np.finfo(float).tiny), Scales(cell).rate
    columns, step = to_kernel(cell, horizon, options), (times[1] if times.size > 1 else horizon) * rate
    signals, status = _signals(columns, horizon * rate, step, np.array([times.size]), options)
    if status[0] != layout.HORIZON_REACHED:
        reached = np.max(times, where=np.isfinite(signals[layout.SIGNAL_XI]), initial=0.0)
        name = STATUSES[int(status[0])]
        raise NotReachedError(f"the motion is known to {reached:g} s of {horizon:g} s, {name}: {STATUS_MESSAGES[name]}")
    return signals_to_si(signals, cell, columns)


def sampled(
    cells: Parameters, steps: Floats, counts: NDArray[np.int64], options: Options, first: Floats | float = 0.0
) -> tuple[list[Floats], Floats, NDArray[np.int8]]:
    """Displacements (m) of many cells, each at times of its own: one array per cell.

    steps, counts : time between samples (s) and number of samples, at least 2, by cell. first : time of the first (s).

    Beside them the velocities at the first and the last sample (m/s), shape (n, 2), and the status: other than
    horizon_reached where the integration ended early, from where on there is NaN. In this thread.
    """
    by, columns, ends = Scales(cells), to_kernel(cells, 1.0, options), np.cumsum(counts)
    columns[layout.HORIZON] = (first + steps * (counts - 1 + _BEYOND)) * by.rate
    signals, status = _signals(columns, columns[layout.HORIZON], steps * by.rate, counts, options, first * by.rate)
    velocities = signals[layout.SIGNAL_ETA][np.column_stack([ends - counts, ends - 1])]
    displacements = np.split(signals[layout.SIGNAL_XI], ends[:-1])
    for displacement, length in zip(displacements, by.length, strict=True):
        displacement *= length
    return displacements, velocities * (by.length * by.rate)[:, None], status


def flows(cells: Parameters, durations: NDArray[np.float64], samples: int, options: Options) -> Results:
    """The motions of many cells, each over its own duration (s), by names of `TRACE_VARIABLES`, shape (n, samples).

    The samples of a cell are evenly spaced and include both ends. The cells may be any that the kernels can integrate,
    with negative damping and friction as well. NaN from where the integration of a cell ended early. In this thread.
    """
    n, columns = durations.size, to_kernel(cells, 1.0, options)
    columns[layout.HORIZON] = durations * Scales(cells).rate
    step = columns[layout.HORIZON] / max(samples - 1, 1)
    signals, _ = _signals(columns, columns[layout.HORIZON], step, np.full(n, samples), options)
    each = {name: np.repeat(values, samples) for name, values in cells.items()}
    motion = signals_to_si(signals, each, np.repeat(columns, samples, axis=1))
    return {name: values.reshape(n, samples) for name, values in motion.items()}


def _signals(
    columns: Floats, ends: Floats, steps: Floats, counts: NDArray[np.int64], options: Options,
    first: Floats | float = 0.0,
) -> tuple[Floats, NDArray[np.int8]]:  # fmt: skip
    """Signals of cells on steady belts, one cell after the other, and the status of each.

    columns : of cells, in kernel units, as are `ends` of the drives, the `steps` between `counts` samples, and the time
    of the `first`.
    """
    n, last = counts.size, np.cumsum(counts)
    numbers, rows = np.arange(n, dtype=np.float64), new_signals(n)
    belts = np.column_stack([ends, columns[layout.BELT], np.zeros(n)]), np.column_stack([numbers, numbers + 1.0])
    signals = np.full((layout.SIGNAL_ROWS, int(last[-1])), np.nan)
    runs = np.column_stack([last - counts, last, first + np.zeros(n), steps]).astype(np.float64)
    run_signals(options, columns, stop_flag(), belts, rows, runs, signals)
    return signals, rows[layout.RIG_STATUS].astype(np.int8)
