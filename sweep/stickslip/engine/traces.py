"""Cells over time: rigs whose drive is a single segment."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from stickslip.engine.exponents import run_signals
from stickslip.engine.options import Options, Results
from stickslip.engine.scales import signals_to_si, to_kernel
from stickslip.engine.threads import stop_flag
from stickslip.errors import NotReachedError
from stickslip.vocabulary.cells import Cells
from stickslip.vocabulary.flags import STATUS_MESSAGES, STATUSES
from stickslip_kernels import layout
from stickslip_kernels.allocate import new_signals

Floats = NDArray[np.float64]

_BEYOND = 0.01  # of a step: how far past its last sample a motion is integrated, so that rounding does not lose it


def trajectory(cell: Cells, times: NDArray[np.float64], options: Options) -> Results:
    """The motion of one cell (arrays of length 1) at `times` (s, evenly spaced, from 0), by names of `TRACE_VARIABLES`.

    The stepping is that of `compute`. Raises NotReachedError if the integration does not reach the last time.
    """
    rate = float(np.sqrt(cell["stiffness"][0] / cell["mass"][0]))
    horizon = max(float(times[-1]), np.finfo(float).tiny)
    column, rows = to_kernel(cell, horizon), new_signals(1)
    belt = np.array([[horizon * rate, column[layout.BELT, 0], 0.0]]), np.array([[0.0, 1.0]])
    signals = np.full((layout.SIGNAL_ROWS, times.size), np.nan)
    step = (times[1] if times.size > 1 else horizon) * rate
    samples = np.array([[0.0, times.size, 0.0, step]])
    run_signals(options.law, column, options.rtol, options.max_steps, stop_flag(), belt, rows, samples, signals)
    if (status := int(rows[layout.RIG_STATUS, 0])) != layout.HORIZON_REACHED:
        reached = np.max(times, where=np.isfinite(signals[layout.SIGNAL_XI]), initial=0.0)
        name = STATUSES[status]
        raise NotReachedError(f"the motion is known to {reached:g} s of {horizon:g} s, {name}: {STATUS_MESSAGES[name]}")
    return signals_to_si(signals, cell, column)


def sampled(
    cells: Cells, steps: Floats, counts: NDArray[np.int64], options: Options
) -> tuple[list[Floats], Floats, NDArray[np.int8]]:
    """Displacements (m) of many cells, each at times of its own from the start on: one array per cell.

    steps, counts : time between samples (s) and number of samples, at least 2, by cell.

    Beside them the velocities at the first and the last sample (m/s), shape (n, 2), and the status: other than
    horizon_reached where the integration ended early, from where on there is NaN. In this thread.
    """
    n, k, load = counts.size, cells["stiffness"], cells["normal_load"]
    rate, length = np.sqrt(k / cells["mass"]), load / k
    columns, rows, ends = to_kernel(cells, 1.0), new_signals(n), np.cumsum(counts)
    columns[layout.HORIZON] = steps * (counts - 1 + _BEYOND) * rate
    numbers = np.arange(n, dtype=np.float64)
    segments = np.column_stack([columns[layout.HORIZON], columns[layout.BELT], np.zeros(n)])
    belts = segments, np.column_stack([numbers, numbers + 1.0])
    signals = np.full((layout.SIGNAL_ROWS, int(ends[-1])), np.nan)
    wanted = np.column_stack([ends - counts, ends, np.zeros(n), steps * rate]).astype(np.float64)
    run_signals(options.law, columns, options.rtol, options.max_steps, stop_flag(), belts, rows, wanted, signals)
    velocities = signals[layout.SIGNAL_ETA][np.column_stack([ends - counts, ends - 1])] * (length * rate)[:, None]
    displacements = np.split(signals[layout.SIGNAL_XI], ends[:-1])
    for displacement, scale in zip(displacements, length, strict=True):
        displacement *= scale
    return displacements, velocities, rows[layout.RIG_STATUS].astype(np.int8)


def flows(cells: Cells, durations: NDArray[np.float64], samples: int, options: Options) -> Results:
    """The motions of many cells, each over its own duration (s), by names of `TRACE_VARIABLES`, shape (n, samples).

    The samples of a cell are evenly spaced and include both ends. The cells may be any that the kernels can integrate,
    with negative damping and friction as well. NaN from where the integration of a cell ended early. In this thread.
    """
    n, rate = durations.size, np.sqrt(cells["stiffness"] / cells["mass"])
    columns, rows = to_kernel(cells, 1.0), new_signals(n)
    columns[layout.HORIZON] = durations * rate
    numbers = np.arange(n, dtype=np.float64)
    segments = np.column_stack([columns[layout.HORIZON], columns[layout.BELT], np.zeros(n)])
    belts = segments, np.column_stack([numbers, numbers + 1.0])
    signals = np.full((layout.SIGNAL_ROWS, n * samples), np.nan)
    step = columns[layout.HORIZON] / max(samples - 1, 1)
    wanted = np.column_stack([numbers * samples, (numbers + 1.0) * samples, np.zeros(n), step])
    run_signals(options.law, columns, options.rtol, options.max_steps, stop_flag(), belts, rows, wanted, signals)
    each = {name: np.repeat(values, samples) for name, values in cells.items()}
    motion = signals_to_si(signals, each, np.repeat(columns, samples, axis=1))
    return {name: values.reshape(n, samples) for name, values in motion.items()}
