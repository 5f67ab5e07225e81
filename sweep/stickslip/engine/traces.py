"""One cell over time."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from stickslip.engine.compiled import warm_up
from stickslip.engine.options import Options, Results
from stickslip.engine.scales import samples_to_si, to_kernel
from stickslip.errors import NotReachedError
from stickslip.vocabulary.cells import Cells
from stickslip.vocabulary.flags import STATUS_MESSAGES, STATUSES
from stickslip_kernels import block, laws, layout, trace


def trajectory(cell: Cells, times: NDArray[np.float64], options: Options) -> Results:
    """The motion of one cell (arrays of length 1) at `times` (s, ascending from 0), by names of `TRACE_VARIABLES`.

    The stepping is that of `compute`, with a log of what happened. Raises NotReachedError if the integration does not
    reach the last time.
    """
    warm_up(options.law)
    horizon = max(float(times[-1]), np.finfo(float).tiny)
    column = to_kernel(cell, horizon)
    control = np.array([options.rtol, options.max_steps, 0.0])
    capacity = 1024
    while True:
        rows, log = block.new_results(1), np.zeros((capacity, layout.LOG_COLUMNS))
        block.run_block(laws.LAWS[options.law], column, rows, control, log, np.zeros(1, np.int64))
        if log[0, 0] < capacity:
            break
        capacity = int(log[0, 0]) + 1
    m, k = float(cell["mass"][0]), float(cell["stiffness"][0])
    if (status := int(rows[layout.STATUS, 0])) != layout.HORIZON_REACHED:
        reached = log[int(log[0, 0]), layout.LOG_TAU] * np.sqrt(m / k)
        name = STATUSES[status]
        raise NotReachedError(f"the motion is known to {reached:g} s of {horizon:g} s, {name}: {STATUS_MESSAGES[name]}")
    samples = np.empty((layout.SAMPLE_ROWS, times.size))
    trace.sample(laws.LAWS[options.law], log, np.ascontiguousarray(column[:, 0]), times * np.sqrt(k / m), samples)
    return samples_to_si(samples, cell)
