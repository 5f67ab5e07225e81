"""The state machine of the contact: stick, rise, fast, fall, hold.

Everything here is scalar and rare: `start_cell` puts a cell into a lane, `attend` looks at a lane whose step met
something. Slip is left to the lanes; stick and hold are closed forms and pass inside one call. The functions return
RUNNING when the lane slips on and DONE when its cell is finished. `s` is the flat buffer of lanes, `i` the lane, `book`
the slow state, `c` the cell; u, w, b are displacement, slip speed and belt speed in the frame of `layout.py`.
"""

from math import inf, isfinite, isnan, nan

from .events import LEVEL_REACHED, NO_EVENT, find_event
from .ageing import dwell_to_breakaway, static_friction
from .friction import coefficient, coefficient_slope, line_slope, speed_of_slope
from .jit import compiled
from .laws import inflection
from .lanes import SMALLEST_STEP, stage_jerk, stage_slope
from .layout import (
    A1, A2, A3, A4, AGEING, B, BAND, BAND2, BELT, BREAKAWAY_TIME, CELL, CELL_ROWS, CONTACT_START, CYCLE_START,
    DAMPING_RATIO, DECIDED, DECIDED_BY, DELTA, DROP, DW, EARLY_STOP, ENTERED_LINE, ERROR_LOG, ETA_START, EXPONENT,
    FAILED, FALL, FAST, FLAG, FLOOR, G, GAMMA, HEAT, HEAT_START, HOLD, HORIZON, HORIZON_REACHED, JERK, LEVEL, MARK,
    MODE, MU_STOP, MU_TURN, NEVER_BREAKS_AWAY, NOT_FINITE, OFFSET, RADIUS2, RATE, REGIME, RELEASE, RELEASE_CHANGE,
    RESTICK_TIME, RESTICK_XI, RISE, RTOL, SIDE, SIGMA, SLIP_START, SLOPE, STATUS, STEP, STEP_LIMIT, STEP_UNDERFLOW,
    STICK, STICK_COUNT, STICK_SUM, STUCK, TAKEN, TAU, TAU_END, TRIED, TURN, UNRESOLVED, W, W_MIN, W_REVERSAL,
    W_STABLE, XI_STAR, XI_START, Y, Y_BAND, Y_STAR,
)  # fmt: skip
from .regimes import (
    creeps_in, damping_ratio, decide, decide_cycle, decide_settled, finish, is_shrinking, note_ends, note_entry,
    note_entry_at_constant_speed, note_peak, note_side, proven_radius, record_extrema, reset_extrema, start_book,
)  # fmt: skip
from .trace import log_closed_form, log_slip

RUNNING, DONE = False, True
# A re-stick shorter than the integration can resolve is a grazing contact, not a stick phase: without it the slip
# speed would have dipped below zero by b t^2 / 2, t being its length. A dip of this many tolerances is called grazing;
# one turn of an undamped oscillation loses half as much (measured at any tolerance).
GRAZING_ERRORS = 0.1


# --- starting -------------------------------------------------------------------------------------------------------


@compiled
def start_cell(law, s, i, book, cells, c, results, control, log):
    """Put cell c into lane i and bring it to its first slip."""
    results[DAMPING_RATIO, c] = damping_ratio(law, cells, c)
    for row in range(CELL_ROWS):
        if isnan(cells[row, c]) and row != MU_STOP and row != ETA_START:
            results[REGIME, c], results[STATUS, c] = FAILED, NOT_FINITE
            return DONE
    start_book(law, book, i, cells, c)
    gamma, belt = cells[GAMMA, c], cells[BELT, c]
    book[i, W_MIN] = 0.0 if isnan(cells[MU_STOP, c]) else speed_of_slope(law, cells, c, 0.0)
    book[i, W_STABLE] = speed_of_slope(law, cells, c, -gamma)
    s[TAU + i], s[HEAT + i], s[TRIED + i], s[ERROR_LOG + i] = 0.0, 0.0, 0.0, 0.0
    s[G + i], s[RATE + i], s[EXPONENT + i] = gamma, 1.0 / cells[A4, c], cells[DELTA, c]
    s[TAU_END + i], s[MARK + i] = cells[HORIZON, c], 1.0
    s[FLOOR + i], s[BAND2 + i] = 1e-3 * abs(belt), book[i, BAND] ** 2
    xi, eta = cells[XI_START, c], cells[ETA_START, c]
    relative = 0.0 if isnan(eta) else belt - eta
    if relative == 0.0:
        book[i, SIGMA] = 1.0
        return come_to_rest(law, s, i, book, cells, results, control, log, xi, belt, True)
    start_sliding(law, s, i, book, cells, log, xi, relative)
    return RUNNING


@compiled
def start_sliding(law, s, i, book, cells, log, xi, relative):
    """Begin in slip: the mode follows from the slip speed and the sign of its derivative on the curve."""
    c = int(book[i, CELL])
    sigma = 1.0 if relative > 0.0 else -1.0
    u, w, b = sigma * xi, abs(relative), sigma * cells[BELT, c]
    book[i, SIGMA], book[i, SLIP_START] = sigma, 0.0
    note_side(book, i, xi)
    first_step(law, s, i, cells, c)
    if book[i, W_MIN] == 0.0:
        enter_curve(law, s, i, book, cells, RISE, u, w, b, False)
    elif w >= book[i, W_MIN]:
        enter_curve(law, s, i, book, cells, FAST, u, w, b, False)
    else:
        enter_curve(law, s, i, book, cells, RISE, u, w, b, False)
        if s[DW + i] < 0.0 or (s[DW + i] == 0.0 and w > b):
            enter_fall(law, s, i, book, cells, u, w, b, s[DW + i] == 0.0)
    note_ends(book, i, u, w, s[DW + i])
    log_slip(log, s, i, book[i, MODE], sigma)


@compiled
def first_step(law, s, i, cells, c):
    """Size of the first step of a slip from rest, where the slip speed may grow as fast as the curve falls."""
    steepest = cells[A4, c] * inflection(law, cells[DELTA, c])
    growth = abs(coefficient_slope(law, cells, c, steepest)) + cells[GAMMA, c]
    s[STEP + i] = 0.05 / (1.0 + growth)
    s[ERROR_LOG + i] = 0.0


# --- entering a mode of slip ----------------------------------------------------------------------------------------


@compiled
def enter_curve(law, s, i, book, cells, mode, u, w, b, turning):
    """Enter RISE or FAST at (u, w). RISE without hysteresis is the plain curve, which ends only at w = 0.

    turning : w' is zero here, exactly.
    """
    c = int(book[i, CELL])
    w_min = book[i, W_MIN]
    s[OFFSET + i], s[SLOPE + i], s[DROP + i] = cells[A1, c], cells[A2, c], cells[A3, c]
    plain_rise = mode == RISE and w_min == 0.0
    s[LEVEL + i] = 0.0 if plain_rise else w_min
    s[SIDE + i] = 1.0 if mode == RISE and not plain_rise else -1.0
    s[TURN + i] = 1.0 if mode == RISE and not plain_rise else 0.0
    enter(law, s, i, book, mode, u, w, b, turning)


@compiled
def enter_fall(law, s, i, book, cells, u, w, b, turning):
    """Enter FALL at (u, w): the straight line from there to (0, mu_stop) replaces the curve, Eq. (2a)."""
    c = int(book[i, CELL])
    mu_reversal = coefficient(law, cells, c, w)
    if isnan(book[i, MU_TURN]):
        book[i, MU_TURN] = mu_reversal
    book[i, W_REVERSAL] = w
    s[OFFSET + i], s[DROP + i] = cells[MU_STOP, c], 0.0
    s[SLOPE + i] = line_slope(w, mu_reversal, cells[MU_STOP, c])
    s[LEVEL + i], s[SIDE + i], s[TURN + i] = 0.0, -1.0, 1.0
    book[i, ENTERED_LINE] = s[TAU + i]
    enter(law, s, i, book, FALL, u, w, b, turning)


@compiled
def enter(law, s, i, book, mode, u, w, b, turning):
    """Set the state of lane i from (u, w) under the law just chosen."""
    drag = s[G + i] + s[SLOPE + i]
    offset = s[OFFSET + i]
    s[B + i] = b
    s[Y + i] = u + s[G + i] * b - offset
    s[W + i] = w
    s[DW + i] = 0.0 if turning else stage_slope(law, s, i, s[Y + i], w)
    s[JERK + i] = stage_jerk(law, s, i, s[Y + i], w, s[DW + i])
    # Steady sliding as this mode sees it; in a reverse slip (b < 0) the equilibrium of the forward one.
    s[Y_BAND + i] = book[i, SIGMA] * book[i, XI_STAR] + s[G + i] * b - offset
    s[Y_STAR + i] = drag * b if mode == FALL and b > 0.0 else s[Y_BAND + i]
    s[RADIUS2 + i] = proven_radius(law, s, i, book, mode, b) ** 2
    book[i, MODE] = mode


# --- rest: stick, break-away, reversal ------------------------------------------------------------------------------


@compiled
def come_to_rest(law, s, i, book, cells, results, control, log, u, b, starting):
    """The slip speed is zero, at (u, b) in the present frame: stick and break away again, or slip the other way.

    The belt holds the mass while |u + gamma b| is within static friction; the load grows at the rate b, so the stick
    phase is exact.
    """
    c = int(book[i, CELL])
    gamma, tau = s[G + i], s[TAU + i]
    load = u + gamma * b
    age = cells[CONTACT_START, c] if starting else 0.0
    if abs(load) > static_friction(cells, c, age):
        if load < 0.0:
            u, b, book[i, SIGMA] = -u, -b, -book[i, SIGMA]
        begin_slip(law, s, i, book, cells, log, u, b, False)
        return RUNNING
    if b < 0.0:
        u, b, load, book[i, SIGMA] = -u, -b, -load, -book[i, SIGMA]
    sigma = book[i, SIGMA]
    left = s[TAU_END + i] - tau
    dwell = dwell_to_breakaway(cells, c, load, b, age) if b > 0.0 else left
    amplitude = max(abs(s[Y + i] - s[Y_STAR + i]), b)
    grazing = not starting and b * dwell * dwell < 2.0 * GRAZING_ERRORS * control[RTOL] * amplitude
    if not grazing:
        book[i, STICK_COUNT] += 1.0
        if not starting and isnan(results[RESTICK_TIME, c]):
            results[RESTICK_TIME, c], results[RESTICK_XI, c] = tau, sigma * u
        note_ends(book, i, u, 0.0, 0.0)
        log_closed_form(log, tau, STICK, sigma, u, 0.0)
    if b == 0.0 and book[i, DECIDED] == 0.0:
        decide(s, i, book, results, STUCK, NEVER_BREAKS_AWAY)
        if control[EARLY_STOP] > 0.0:
            finish(s, i, book, results, STUCK, NEVER_BREAKS_AWAY, sigma * u, 0.0)
            return DONE
    if dwell >= left:
        book[i, STICK_SUM] += left
        finish(s, i, book, results, UNRESOLVED, HORIZON_REACHED, sigma * (u + b * left), sigma * b)
        return DONE
    note_entry_at_constant_speed(s, i, book, tau, u, 0.0, b, dwell)
    s[TAU + i] = tau + dwell
    limit = static_friction(cells, c, age + dwell)
    u = limit - gamma * b
    if not grazing:
        book[i, STICK_SUM] += dwell
        close_cycle(s, i, book, cells, results, control, s[TAU + i], dwell, limit)
        if book[i, DECIDED] > 0.0 and control[EARLY_STOP] > 0.0:
            note_ends(book, i, u, 0.0, 0.0)
            finish(s, i, book, results, UNRESOLVED, book[i, DECIDED_BY], sigma * (u), sigma * b)
            return DONE
    # Where static friction ends on the curve, w and w' vanish together here and w'' = b > 0 lifts the mass off.
    begin_slip(law, s, i, book, cells, log, u, b, limit <= cells[A1, c] + cells[A3, c])
    return RUNNING


@compiled
def close_cycle(s, i, book, cells, results, control, tau, dwell, load):
    """A break-away at tau under `load`, after a stick phase: the first starts the cycle, the second closes it.

    Without ageing the state after break-away is always the same, so one full cycle is the limit cycle, exactly. With it
    the load at break-away depends on the stick phase before: cycles follow each other until that map has converged.
    """
    c = int(book[i, CELL])
    if book[i, DECIDED] > 0.0:
        return
    if isnan(book[i, CYCLE_START]):
        results[BREAKAWAY_TIME, c] = tau
    elif cells[AGEING, c] == 0.0 or has_converged(book, i, load, control[RTOL]):
        decide_cycle(s, i, book, results, tau, dwell)
        return
    book[i, CYCLE_START], book[i, HEAT_START], book[i, RELEASE] = tau, s[HEAT + i], load
    book[i, MU_TURN] = nan
    reset_extrema(book, i)


@compiled
def has_converged(book, i, load, rtol):
    """Whether the loads at the breaks-away still to come differ from this one by less than the tolerance.

    Changes shrink by a constant factor near the fixed point of the return map; their sum is that of a geometric series.
    """
    change, before = abs(load - book[i, RELEASE]), book[i, RELEASE_CHANGE]
    book[i, RELEASE_CHANGE] = change
    if before == inf:  # one change tells nothing about the next
        return False
    return change == 0.0 or (change < before and change * change / (before - change) <= rtol * load)


@compiled
def begin_slip(law, s, i, book, cells, log, u, b, lifting_off):
    """Slip from rest at (u, b); `lifting_off` where the load equals the friction of the curve, so that w' is zero."""
    c = int(book[i, CELL])
    if isnan(book[i, SLIP_START]):
        book[i, SLIP_START] = s[TAU + i]
        note_side(book, i, book[i, SIGMA] * u)
    first_step(law, s, i, cells, c)
    enter_curve(law, s, i, book, cells, RISE, u, 0.0, b, lifting_off)
    note_ends(book, i, u, 0.0, s[DW + i])
    log_slip(log, s, i, RISE, book[i, SIGMA])


# --- attending to a flagged lane ------------------------------------------------------------------------------------


@compiled
def attend(law, s, i, book, cells, results, control, log):
    """Look at lane i, whose last step was flagged: record what it met, change the mode, or finish the cell."""
    if s[FLAG + i] == 2.0:
        return give_up(s, i, book, results, control)
    kind, h, y, w, dw, work = find_event(law, s, i, control[RTOL])
    jerk = stage_jerk(law, s, i, y, w, dw)
    if s[MARK + i] > 0.0:
        record_extrema(law, s, i, book, results, h, y, w, dw, jerk)
    if s[BAND2 + i] > 0.0:
        note_entry(law, s, i, book, h, y, w, dw)
    finished_step = s[TAKEN + i]
    s[TAU + i] += h
    s[HEAT + i] += work
    s[Y + i], s[W + i], s[DW + i], s[JERK + i] = y, w, dw, jerk
    if kind == NO_EVENT:
        check_settling(law, s, i, book, results)
        log_slip(log, s, i, book[i, MODE], book[i, SIGMA])
    else:
        s[STEP + i] = finished_step
        if change_mode(law, s, i, book, cells, results, control, log, kind) == DONE:
            return DONE
    if book[i, DECIDED] > 0.0 and control[EARLY_STOP] > 0.0:
        return close(s, i, book, results, book[i, DECIDED_BY])
    if s[TAU + i] >= s[TAU_END + i]:
        return close(s, i, book, results, HORIZON_REACHED)
    return RUNNING


@compiled
def close(s, i, book, results, status):
    """Finish a cell that is slipping."""
    sigma, b = book[i, SIGMA], s[B + i]
    u = s[Y + i] - s[G + i] * b + s[OFFSET + i]
    finish(s, i, book, results, UNRESOLVED, status, sigma * u, sigma * (b - s[W + i]))
    return DONE


@compiled
def give_up(s, i, book, results, control):
    """No further step: the budget is spent, or the step size fell below rounding."""
    if not (isfinite(s[Y + i]) and isfinite(s[W + i]) and isfinite(s[DW + i])):
        finish(s, i, book, results, FAILED, NOT_FINITE, s[Y + i], s[W + i])
    elif s[STEP + i] < SMALLEST_STEP:
        finish(s, i, book, results, FAILED, STEP_UNDERFLOW, s[Y + i], s[W + i])
    else:
        return close(s, i, book, results, STEP_LIMIT)
    return DONE


@compiled
def check_settling(law, s, i, book, results):
    """Inside the disc of `proven_radius` the motion has settled; where the mode may yet change, if it creeps in."""
    p, q = s[Y + i] - s[Y_STAR + i], s[W + i] - s[B + i]
    mode = book[i, MODE]
    may_change = mode == FALL or (mode == RISE and book[i, W_MIN] > 0.0)
    if p * p + q * q < s[RADIUS2 + i] and (not may_change or creeps_in(law, s, i, mode)):
        decide_settled(law, s, i, book, results, mode == FALL)


@compiled
def change_mode(law, s, i, book, cells, results, control, log, kind):
    """The mode of lane i ends at its present state."""
    mode, b, w = book[i, MODE], s[B + i], s[W + i]
    u = s[Y + i] - s[G + i] * b + s[OFFSET + i]
    if s[MARK + i] > 0.0:
        note_ends(book, i, u, w, s[DW + i])
    if kind == LEVEL_REACHED and s[LEVEL + i] == 0.0:
        return come_to_rest(law, s, i, book, cells, results, control, log, u, b, False)
    if mode == FALL:
        return leave_line(law, s, i, book, cells, results, control, log, u, w, b)
    if kind == LEVEL_REACHED and mode == RISE:
        enter_curve(law, s, i, book, cells, FAST, u, w, b, False)
    elif kind == LEVEL_REACHED:
        enter_fall(law, s, i, book, cells, u, w, b, False)
    else:
        note_peak(book, i, w - b)
        enter_fall(law, s, i, book, cells, u, w, b, True)
    log_slip(log, s, i, book[i, MODE], book[i, SIGMA])
    return RUNNING


@compiled
def leave_line(law, s, i, book, cells, results, control, log, u, w, b):
    """A trough of w on the line. If the curve lies above, neither is consistent: the mass holds its speed meanwhile.

    On the line the speed would rise, on the curve it would fall; the exact (Filippov) solution keeps w constant while
    the load u + gamma u' climbs from the line to the curve.
    """
    c = int(book[i, CELL])
    if book[i, DECIDED] == 0.0 and (b <= w or is_shrinking(s, i, book, cells)):
        decide_settled(law, s, i, book, results, b <= w)
    mu_line = s[OFFSET + i] + s[SLOPE + i] * w
    mu_curve = coefficient(law, cells, c, w)
    holds = mu_curve > mu_line
    if holds:
        left = s[TAU_END + i] - s[TAU + i]
        duration = (mu_curve - mu_line) / (b - w) if b > w else left
        log_closed_form(log, s[TAU + i], HOLD, book[i, SIGMA], u, w)
        if duration >= left and (book[i, DECIDED] == 0.0 or control[EARLY_STOP] == 0.0):
            sigma = book[i, SIGMA]
            finish(s, i, book, results, UNRESOLVED, HORIZON_REACHED, sigma * (u + (b - w) * left), sigma * (b - w))
            return DONE
        note_entry_at_constant_speed(s, i, book, s[TAU + i], u, w, b, duration)
        s[TAU + i] += duration
        s[HEAT + i] += w * duration * 0.5 * (mu_line + mu_curve)
        u += (b - w) * duration
    enter_curve(law, s, i, book, cells, RISE, u, w, b, holds)
    log_slip(log, s, i, RISE, book[i, SIGMA])
    return RUNNING
