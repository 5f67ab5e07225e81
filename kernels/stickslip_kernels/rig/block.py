"""A block of rigs through the lanes: arrays in, arrays out; serial, nogil, and it never raises."""

import numpy as np

from ..jit import compiled
from ..lanes import step_lanes
from ..layout import (
    CELL, FLAG, LANE_NUMBERS, MAX_STEPS, NOT_RUN, RIG_BOOK_COLUMNS, RIG_ROWS, RIG_STATUS, RTOL, STOP_COLUMNS, WIDTH,
)  # fmt: skip
from ..rest import DONE
from .modes import attend_rig, start_rig

NO_STOPS = np.zeros((0, STOP_COLUMNS))


def new_results(n):
    """Results of n rigs nobody has computed yet."""
    results = np.full((RIG_ROWS, n), np.nan)
    results[RIG_STATUS] = NOT_RUN
    return results


@compiled
def next_rig(law, s, i, book, cells, first, segments, runs, results, signals, stops, control):
    """Start the next rig, from number `first` on, that does not finish at once in lane i.

    Returns the number after it; the lane idles if there is none.
    """
    c = first
    while c < cells.shape[1]:
        c += 1
        if start_rig(law, s, i, book, cells, c - 1, segments, runs, results, signals, stops, control) != DONE:
            return c
    book[i, CELL] = -1.0
    return c


@compiled
def run_lanes(law, lanes, book, cells, segments, runs, results, signals, stops, control, stop):
    """`run_rigs` with its buffers: the lanes and the slow state of each."""
    following, busy = 0, 0
    for i in range(WIDTH):
        following = next_rig(law, lanes, i, book, cells, following, segments, runs, results, signals, stops, control)
        busy += book[i, CELL] >= 0.0
    while stop[0] == 0 and busy > 0:
        step_lanes(law, lanes, control[RTOL], control[MAX_STEPS])
        for i in range(WIDTH):
            if lanes[FLAG + i] != 0.0 and book[i, CELL] >= 0.0:
                if attend_rig(law, lanes, i, book, cells, segments, runs, results, signals, stops, control) == DONE:
                    following = next_rig(
                        law, lanes, i, book, cells, following, segments, runs, results, signals, stops, control
                    )
                    busy -= book[i, CELL] < 0.0


@compiled(allocates=True)
def run_rigs(law, cells, segments, runs, results, signals, stops, control, stop):
    """Integrate every rig of a block to the end of its drive.

    law : tag of the friction law, see `laws`.
    cells : float64 (CELL_ROWS, n), kernel units; BELT, ETA_START and HORIZON are not used.
    segments : float64 (any, SEGMENT_COLUMNS); runs : float64 (n, RUN_COLUMNS), see `layout.py`.
    results : float64 (RIG_ROWS, n) from `new_results`. signals : float64 (SIGNAL_ROWS, any), filled where `runs` says;
        what is not reached stays as it was.
    stops : a table of stick phases, for n = 1, or NO_STOPS. control, stop : as for `block.run_block`.
    """
    lanes, book = np.zeros(LANE_NUMBERS), np.zeros((WIDTH, RIG_BOOK_COLUMNS))
    run_lanes(law, lanes, book, cells, segments, runs, results, signals, stops, control, stop)
