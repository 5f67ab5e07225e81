"""The state machine of the contact: stick, rise, fast, fall, hold.

Everything here is scalar and rare: `start_cell` puts a cell into a lane, `attend` looks at a lane whose step met
something. Slip on the curve (`slip.py`: rise, fast) is left to the lanes; stick (`rest.py`), fall and hold
(`hysteresis.py`) are closed forms and pass inside one call. Functions return RUNNING when the lane slips on and DONE
when its cell is finished. `s` is the flat buffer of lanes with their slow state, `i` the lane, `c` the cell; u, w, b
are displacement, slip speed and belt speed in the frame of `layout.py`.
"""

from math import isfinite, isnan, nan

from .events import LEVEL_REACHED, NO_EVENT, TURNED, find_event
from .extrema import count_quiet_turns, note_peak, note_side, record_extrema, show_tops
from .friction import speed_of_slope, stable_speeds
from .jit import compiled
from .equations import jerk_in_lane, weakening_in_lane
from .lanes import begin_stepping, restart
from .layout import (
    A4, B, BAND2, BELT, CELL, CELL_ROWS, DAMPING_RATIO, DECIDED, DECIDED_BY, DELTA, DW, EARLY_STOP, ETA_START,
    EXPONENT, FAILED, FAST, FLAG, FLOOR, G, GAMMA, HEAT, HORIZON, HORIZON_REACHED, JERK, LEVEL, MARK, MODE,
    MU_STOP, NEGATIVE_FRICTION, NOT_FINITE, OFFSET, RATE, REGIME, RISE, SETTLING_CERTAIN, SIGMA, SLIP_START,
    SLOPE, SMALLEST_STEP, STABLE_FROM, STABLE_TO, STATUS, STEP, STEP_LIMIT, STEP_UNDERFLOW, TAKEN, TAU, TAU_END,
    TRIED, UNRESOLVED, W, WEAK, WEAK_NEW, W_MIN, XI_STAR, XI_START, Y,
)  # fmt: skip
from .regimes import damping_ratio, decide_settled, finish, note_ends, start_book
from .rest import DONE, RUNNING, come_to_rest
from .hysteresis import fall
from .settling import check_settling, note_entry, set_band, settles_for_certain
from .slip import enter_curve
from .steep import know_steepness
from .trace import log_slip

ROUNDING = 1e-12  # motion smaller than this is lost beside forces of the size of the load


# --- starting -------------------------------------------------------------------------------------------------------


@compiled
def start_cell(law, s, i, cells, c, results, control, log):
    """Put cell c into lane i and bring it to its first slip."""
    results[DAMPING_RATIO, c] = damping_ratio(law, cells, c)
    for row in range(CELL_ROWS):
        if isnan(cells[row, c]) and row != MU_STOP and row != ETA_START:
            results[REGIME, c], results[STATUS, c] = FAILED, NOT_FINITE
            return DONE
    start_book(law, s, i, cells, c)
    gamma, belt = cells[GAMMA, c], cells[BELT, c]
    s[W_MIN + i] = 0.0 if isnan(cells[MU_STOP, c]) else speed_of_slope(law, cells, c, 0.0)
    s[STABLE_FROM + i], s[STABLE_TO + i] = stable_speeds(law, cells, c)
    s[TAU + i], s[HEAT + i], s[TRIED + i] = 0.0, 0.0, 0.0
    know_steepness(law, s, i, cells, c)
    s[G + i], s[RATE + i], s[EXPONENT + i] = gamma, 1.0 / cells[A4, c], cells[DELTA, c]
    s[TAU_END + i], s[MARK + i] = cells[HORIZON, c], 1.0
    s[FLOOR + i] = 1e-3 * abs(belt) + ROUNDING
    xi, eta = cells[XI_START, c], cells[ETA_START, c]
    relative = 0.0 if isnan(eta) else belt - eta
    if relative == 0.0:
        s[SIGMA + i] = 1.0
        return come_to_rest(law, s, i, cells, results, control, log, xi, belt, True)
    return start_sliding(law, s, i, cells, results, control, log, xi, relative)


@compiled
def start_sliding(law, s, i, cells, results, control, log, xi, relative):
    """Begin in slip: the mode follows from the slip speed and the sign of its derivative on the curve."""
    c = int(s[CELL + i])
    sigma = 1.0 if relative > 0.0 else -1.0
    u, w, b = sigma * xi, abs(relative), sigma * cells[BELT, c]
    s[SIGMA + i], s[SLIP_START + i] = sigma, 0.0
    set_band(s, i, u, w, b)
    note_side(s, i, xi)
    enter_curve(law, s, i, cells, FAST if w >= s[W_MIN + i] > 0.0 else RISE, u, w, b, False)
    begin_stepping(law, s, i, cells, c)
    dw = s[DW + i]
    note_ends(s, i, u, w, dw)
    if w < s[W_MIN + i] and (dw < 0.0 or (dw == 0.0 and w > b)):
        return fall(law, s, i, cells, results, control, log, u, w, dw, b)
    log_slip(log, s, i, s[MODE + i], sigma)
    return RUNNING


# --- attending to a flagged lane ------------------------------------------------------------------------------------


@compiled(inline=True)
def attend(law, s, i, cells, results, control, log):
    """Look at lane i, whose last step was flagged: record what it met, change the mode, or finish the cell."""
    count_quiet_turns(s, i)
    if s[FLAG + i] == 2.0:
        return give_up(law, s, i, results)
    kind, h, y, w, dw, work = find_event(law, s, i)
    jerk = jerk_in_lane(law, s, i, y, w, dw, s[B + i])
    if s[MARK + i] > 0.0:
        record_extrema(law, s, i, results, control, h, y, w, dw, jerk)
    if s[BAND2 + i] > 0.0:
        note_entry(s, i, h, y, w)
    s[TAU + i] += h
    s[HEAT + i] += work
    s[Y + i], s[W + i], s[DW + i], s[JERK + i], s[WEAK + i] = y, w, dw, jerk, s[WEAK_NEW + i]
    if kind == NO_EVENT:
        if s[MARK + i] > 0.0:
            show_tops(s, i)
        check_settling(law, s, i, results, control)
        log_slip(log, s, i, s[MODE + i], s[SIGMA + i])
    else:
        restart(law, s, i, s[TAKEN + i])
        if change_mode(law, s, i, cells, results, control, log, kind) == DONE:
            return DONE
    if s[DECIDED + i] > 0.0 and control[EARLY_STOP] > 0.0:
        return close(s, i, results, s[DECIDED_BY + i])
    if s[TAU + i] >= s[TAU_END + i]:
        return close(s, i, results, HORIZON_REACHED)
    return RUNNING


@compiled(inline=True)
def close(s, i, results, status):
    """Finish a cell that is slipping."""
    sigma, b = s[SIGMA + i], s[B + i]
    u = s[Y + i] - s[G + i] * b + s[OFFSET + i]
    finish(s, i, results, UNRESOLVED, status, sigma * u, sigma * (b - s[W + i]))
    return DONE


@compiled(inline=True)
def give_up(law, s, i, results):
    """No further step: the budget is spent, or the step size fell below rounding."""
    finite = isfinite(s[Y + i]) and isfinite(s[W + i]) and isfinite(s[DW + i])
    if finite and s[STEP + i] >= SMALLEST_STEP:
        if s[DECIDED + i] == 0.0 and settles_for_certain(law, s, i):
            decide_settled(s, i, results, nan, s[XI_STAR + i], SETTLING_CERTAIN)
            return close(s, i, results, SETTLING_CERTAIN)
        return close(s, i, results, STEP_LIMIT)
    mu = s[OFFSET + i] + s[SLOPE + i] * s[W + i] + weakening_in_lane(law, s, i, s[W + i])
    status = NEGATIVE_FRICTION if mu < 0.0 else STEP_UNDERFLOW if finite else NOT_FINITE
    finish(s, i, results, FAILED, status, nan, nan)
    return DONE


@compiled(inline=True)
def change_mode(law, s, i, cells, results, control, log, kind):
    """The mode of lane i ends at its present state."""
    mode, b, w = s[MODE + i], s[B + i], s[W + i]
    u = s[Y + i] - s[G + i] * b + s[OFFSET + i]
    if s[MARK + i] > 0.0:
        note_ends(s, i, u, w, s[DW + i])
    if kind == LEVEL_REACHED and s[LEVEL + i] == 0.0:
        return come_to_rest(law, s, i, cells, results, control, log, u, b, False)
    if kind == LEVEL_REACHED and mode == RISE:
        enter_curve(law, s, i, cells, FAST, u, w, b, False)
        log_slip(log, s, i, FAST, s[SIGMA + i])
        return RUNNING
    if kind == TURNED:
        note_peak(s, i, w - b)
    return fall(law, s, i, cells, results, control, log, u, w, s[DW + i], b)
