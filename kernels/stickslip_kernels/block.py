"""A block of cells: the unit of work. Arrays in, arrays out; serial, nogil, and it never raises."""

import numpy as np

from .bits import as_index, lowest_bit, nonzero_bits
from .friction import coefficient
from .jit import compiled
from .lanes import step_lanes
from .layout import (
    A2, A3, BELT, CELL, ETA_END, FAILED, FLAG, LANE_NUMBERS, MAX_STEPS, MODE, NEGATIVE_FRICTION, NOT_COMPUTED, NOT_RUN,
    REGIME, RESULT_ROWS, RTOL, SIGMA, SPEED_MAX, STATUS, WIDTH,
)  # fmt: skip
from .modes import attend, start_cell
from .rest import DONE
from .trace import log_slip

NO_LOG = np.zeros((0, 0))


def new_results(n):
    """Results of n cells nobody has computed yet: NaN, and the codes for "not computed"."""
    results = np.full((RESULT_ROWS, n), np.nan)
    results[REGIME], results[STATUS] = NOT_COMPUTED, NOT_RUN
    return results


@compiled
def next_cell(law, s, i, cells, first, results, control, log):
    """Start the next cell, from number `first` on, that does not finish at once in lane i.

    Returns the number after it; the lane idles if there is none.
    """
    c = first
    while c < cells.shape[1]:
        c += 1
        if start_cell(law, s, i, cells, c - 1, results, control, log) != DONE:
            return c
    s[CELL + i] = -1.0
    return c


@compiled
def run_lanes(law, lanes, cells, results, control, log, stop):
    """`run_block` with its buffer, the lanes."""
    following, busy = 0, 0  # cells started so far; bit i: lane i is under way
    for i in range(WIDTH):
        following = next_cell(law, lanes, as_index(i), cells, following, results, control, log)
        busy |= (lanes[CELL + i] >= 0.0) << i
    while stop[0] == 0 and busy != 0:
        step_lanes(law, lanes, control[RTOL], control[MAX_STEPS])
        flagged = nonzero_bits(lanes, FLAG, WIDTH) & busy
        if log.shape[0] > 0 and flagged == 0:
            log_slip(log, lanes, as_index(0), lanes[MODE], lanes[SIGMA])
        while flagged != 0:
            i = lowest_bit(flagged)
            flagged &= flagged - 1
            if attend(law, lanes, as_index(i), cells, results, control, log) == DONE:
                following = next_cell(law, lanes, as_index(i), cells, following, results, control, log)
                busy ^= (lanes[CELL + i] < 0.0) << i


@compiled
def refuse_negative_friction(law, cells, results):
    """Nothing is said of cells whose slip reached speeds at which friction would drive the motion."""
    for c in range(cells.shape[1]):
        if cells[A2, c] < 0.0 or cells[A3, c] < 0.0:
            fastest = abs(cells[BELT, c] - results[ETA_END, c])
            if results[SPEED_MAX, c] > fastest:
                fastest = results[SPEED_MAX, c]
            if coefficient(law, cells, c, fastest) < 0.0:
                results[REGIME, c], results[STATUS, c] = FAILED, NEGATIVE_FRICTION


@compiled(allocates=True)
def run_block(law, cells, results, control, log, stop):
    """Integrate every cell of a block.

    law : tag of the friction law, see `laws`.
    cells : float64 (CELL_ROWS, n), kernel units, C-contiguous.
    results : float64 (RESULT_ROWS, n) from `new_results`, filled in place.
    control : RTOL, MAX_STEPS, EARLY_STOP. log : see `layout.py`; a log with rows wants n = 1.
    stop : int64 (1,); when another thread sets it, the block is left, unfinished cells staying "not computed".

    WIDTH cells are under way at a time; a finished lane takes the next cell of the queue. A cell's numbers do not
    depend on its lane or its neighbours.
    """
    run_lanes(law, np.zeros(LANE_NUMBERS), cells, results, control, log, stop)
    refuse_negative_friction(law, cells, results)
