"""A block of rigs through the lanes: arrays in, arrays out; serial, nogil, and it never raises."""

import numpy as np

from ..bits import as_index, lowest_bit, nonzero_bits
from ..jit import compiled
from ..lanes import step_lanes
from ..layout import CELL, FLAG, LANE_NUMBERS, MAX_STEPS, NOT_RUN, RIG_ROWS, RIG_STATUS, RTOL, STOP_COLUMNS, WIDTH
from ..rest import DONE
from .modes import attend_rig, start_rig

NO_STOPS = np.zeros((0, STOP_COLUMNS))


def new_results(n):
    """Results of n rigs nobody has computed yet."""
    results = np.full((RIG_ROWS, n), np.nan)
    results[RIG_STATUS] = NOT_RUN
    return results


@compiled
def next_rig(law, s, i, cells, first, segments, runs, results, signals, stops, control):
    """Start the next rig, from number `first` on, that does not finish at once in lane i.

    Returns the number after it; the lane idles if there is none.
    """
    c = first
    while c < cells.shape[1]:
        c += 1
        if start_rig(law, s, i, cells, c - 1, segments, runs, results, signals, stops, control) != DONE:
            return c
    s[CELL + i] = -1.0
    return c


@compiled
def run_lanes(law, lanes, cells, segments, runs, results, signals, stops, control, stop):
    """`run_rigs` with its buffer, the lanes."""
    following, busy = 0, 0  # rigs started so far; bit i: lane i is under way
    for i in range(WIDTH):
        following = next_rig(
            law, lanes, as_index(i), cells, following, segments, runs, results, signals, stops, control
        )
        busy |= (lanes[CELL + i] >= 0.0) << i
    while stop[0] == 0 and busy != 0:
        step_lanes(law, lanes, control[RTOL], control[MAX_STEPS])
        flagged = nonzero_bits(lanes, FLAG, WIDTH) & busy
        while flagged != 0:
            i = lowest_bit(flagged)
            flagged &= flagged - 1
            if attend_rig(law, lanes, as_index(i), cells, segments, runs, results, signals, stops, control) == DONE:
                following = next_rig(
                    law, lanes, as_index(i), cells, following, segments, runs, results, signals, stops, control
                )
                busy ^= (lanes[CELL + i] < 0.0) << i


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
    run_lanes(law, np.zeros(LANE_NUMBERS), cells, segments, runs, results, signals, stops, control, stop)
