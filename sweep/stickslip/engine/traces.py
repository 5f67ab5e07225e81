"""One cell over time: a rig whose drive is a single segment."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from stickslip.engine.compiled import run, warm_up
from stickslip.engine.options import Options, Results
from stickslip.engine.scales import samples_to_si, to_kernel
from stickslip.errors import NotReachedError
from stickslip.vocabulary.cells import Cells
from stickslip.vocabulary.flags import STATUS_MESSAGES, STATUSES
from stickslip_kernels import layout
from stickslip_kernels.drive import Segments
from stickslip_kernels.observers.signals import NO_STOPS, Signals, new_results


def trajectory(cell: Cells, times: NDArray[np.float64], options: Options) -> Results:
    """The motion of one cell (arrays of length 1) at `times` (s, evenly spaced, from 0), by names of `TRACE_VARIABLES`.

    The stepping is that of `compute`. Raises NotReachedError if the integration does not reach the last time.
    """
    warm_up(options.law, signals=True)
    rate = float(np.sqrt(cell["stiffness"][0] / cell["mass"][0]))
    horizon = max(float(times[-1]), np.finfo(float).tiny)
    column, rows = to_kernel(cell, horizon), new_results(1)
    belt = Segments(np.array([[horizon * rate, column[layout.BELT, 0], 0.0]]), np.array([[0.0, 1.0]]))
    signals = np.full((layout.SIGNAL_ROWS, times.size), np.nan)
    step = (times[1] if times.size > 1 else horizon) * rate
    samples = np.array([[0.0, times.size, 0.0, step]])
    run(options.law, belt, Signals(rows, samples, signals, NO_STOPS), column, options.rtol, options.max_steps)
    if (status := int(rows[layout.RIG_STATUS, 0])) != layout.HORIZON_REACHED:
        reached = np.max(times, where=np.isfinite(signals[layout.SIGNAL_XI]), initial=0.0)
        name = STATUSES[status]
        raise NotReachedError(f"the motion is known to {reached:g} s of {horizon:g} s, {name}: {STATUS_MESSAGES[name]}")
    return samples_to_si(signals, cell, column[:, 0])
