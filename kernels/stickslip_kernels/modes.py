"""The state machine of the contact: stick, rise, fast, fall, hold.

Everything here is scalar and rare: `start_cell` puts a cell into a lane, `attend` looks at a lane whose step met
something. Slip is left to the lanes; stick and hold are closed forms and pass inside one call. The functions return
RUNNING when the lane slips on and DONE when its cell is finished. `s` is the flat buffer of lanes, `i` the lane, `book`
the slow state, `c` the cell; u, w, b are displacement, slip speed and belt speed in the frame of `layout.py`.
"""

from math import isfinite, isnan

from .events import LEVEL_REACHED, NO_EVENT, find_event
from .friction import line_slope, speed_of_slope, stribeck, stribeck_slope
from .jit import compiled
from .lanes import SMALLEST_STEP
from .layout import (
    A1, A2, A3, A4, B, BAND, BAND2, BELT, BREAKAWAY_TIME, CELL, CELL_ROWS, CYCLE_START, DAMPING_RATIO, DECIDED,
    DECIDED_BY, DROP, DW, EARLY_STOP, ENTERED_LINE, ERROR_LOG, ETA_START, FAILED, FALL, FAST, FLAG, FLOOR, G, GAMMA,
    HEAT, HEAT_START, HOLD, HORIZON, HORIZON_REACHED, JERK, LEVEL, MARK, MODE, MU_STATIC, MU_STOP, MU_TURN,
    NEVER_BREAKS_AWAY, NOT_FINITE, OFFSET, RADIUS2, RATE, REGIME, RESTICK_TIME, RESTICK_XI, RISE, RTOL, SIDE, SIGMA,
    SLIP_START, SLOPE, STATUS, STEP, STEP_LIMIT, STEP_UNDERFLOW, STICK, STICK_COUNT, STICK_SUM, STUCK, TAKEN, TAU,
    TAU_END, TRIED, TURN, UNRESOLVED, W, W_MIN, W_REVERSAL, W_STABLE, XI_STAR, XI_START, Y, Y_BAND, Y_STAR,
)  # fmt: skip
from .regimes import (
    creeps_in, damping_ratio, decide, decide_cycle, decide_settled, finish, is_shrinking, note_ends, note_entry,
    note_entry_at_constant_speed, note_peak, note_side, proven_radius, record_extrema, reset_extrema, start_book,
)  # fmt: skip
from .rk import slip_acceleration, slip_jerk
from .trace import log_closed_form, log_slip

RUNNING, DONE = False, True
# A re-stick shorter than the integration can resolve is a grazing contact, not a stick phase: without it the slip
# speed would have dipped below zero by b t^2 / 2, t being its length. A dip of this many tolerances is called grazing;
# one turn of an undamped oscillation loses half as much (measured at any tolerance).
GRAZING_ERRORS = 0.1


# --- starting -------------------------------------------------------------------------------------------------------


@compiled
def start_cell(s, i, book, cells, c, results, control, log):
    """Put cell c into lane i and bring it to its first slip."""
    results[DAMPING_RATIO, c] = damping_ratio(cells, c)
    for row in range(CELL_ROWS):
        if isnan(cells[row, c]) and row != MU_STOP and row != ETA_START:
            results[REGIME, c], results[STATUS, c] = FAILED, NOT_FINITE
            return DONE
    start_book(book, i, cells, c)
    gamma, belt, a2, a3, a4 = cells[GAMMA, c], cells[BELT, c], cells[A2, c], cells[A3, c], cells[A4, c]
    book[i, W_MIN] = 0.0 if isnan(cells[MU_STOP, c]) else speed_of_slope(0.0, a2, a3, a4)
    book[i, W_STABLE] = speed_of_slope(-gamma, a2, a3, a4)
    s[TAU + i], s[HEAT + i], s[TRIED + i], s[ERROR_LOG + i] = 0.0, 0.0, 0.0, 0.0
    s[G + i], s[RATE + i], s[TAU_END + i], s[MARK + i] = gamma, 1.0 / a4, cells[HORIZON, c], 1.0
    s[FLOOR + i], s[BAND2 + i] = 1e-3 * abs(belt), book[i, BAND] ** 2
    xi, eta = cells[XI_START, c], cells[ETA_START, c]
    relative = 0.0 if isnan(eta) else belt - eta
    if relative == 0.0:
        book[i, SIGMA] = 1.0
        return come_to_rest(s, i, book, cells, results, control, log, xi, belt, True)
    start_sliding(s, i, book, cells, log, xi, relative)
    return RUNNING


@compiled
def start_sliding(s, i, book, cells, log, xi, relative):
    """Begin in slip: the mode follows from the slip speed and the sign of its derivative on the curve."""
    c = int(book[i, CELL])
    sigma = 1.0 if relative > 0.0 else -1.0
    u, w, b = sigma * xi, abs(relative), sigma * cells[BELT, c]
    book[i, SIGMA], book[i, SLIP_START] = sigma, 0.0
    note_side(book, i, xi)
    first_step(s, i, cells, c)
    if book[i, W_MIN] == 0.0:
        enter_curve(s, i, book, cells, RISE, u, w, b, False)
    elif w >= book[i, W_MIN]:
        enter_curve(s, i, book, cells, FAST, u, w, b, False)
    else:
        enter_curve(s, i, book, cells, RISE, u, w, b, False)
        if s[DW + i] < 0.0 or (s[DW + i] == 0.0 and w > b):
            enter_fall(s, i, book, cells, u, w, b, s[DW + i] == 0.0)
    note_ends(book, i, u, w, s[DW + i])
    log_slip(log, s, i, book[i, MODE], sigma)


@compiled
def first_step(s, i, cells, c):
    """Size of the first step of a slip from rest, where the slip speed may grow as fast as the curve falls."""
    growth = abs(stribeck_slope(0.0, cells[A2, c], cells[A3, c], cells[A4, c])) + cells[GAMMA, c]
    s[STEP + i] = 0.05 / (1.0 + growth)
    s[ERROR_LOG + i] = 0.0


# --- entering a mode of slip ----------------------------------------------------------------------------------------


@compiled
def enter_curve(s, i, book, cells, mode, u, w, b, turning):
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
    enter(s, i, book, mode, u, w, b, turning)


@compiled
def enter_fall(s, i, book, cells, u, w, b, turning):
    """Enter FALL at (u, w): the straight line from there to (0, mu_stop) replaces the curve, Eq. (2a)."""
    c = int(book[i, CELL])
    mu_reversal = stribeck(w, cells[A1, c], cells[A2, c], cells[A3, c], cells[A4, c])
    if isnan(book[i, MU_TURN]):
        book[i, MU_TURN] = mu_reversal
    book[i, W_REVERSAL] = w
    s[OFFSET + i], s[DROP + i] = cells[MU_STOP, c], 0.0
    s[SLOPE + i] = line_slope(w, mu_reversal, cells[MU_STOP, c])
    s[LEVEL + i], s[SIDE + i], s[TURN + i] = 0.0, -1.0, 1.0
    book[i, ENTERED_LINE] = s[TAU + i]
    enter(s, i, book, FALL, u, w, b, turning)


@compiled
def enter(s, i, book, mode, u, w, b, turning):
    """Set the state of lane i from (u, w) under the law just chosen."""
    drag = s[G + i] + s[SLOPE + i]
    offset = s[OFFSET + i]
    s[B + i] = b
    s[Y + i] = u + s[G + i] * b - offset
    s[W + i] = w
    s[DW + i] = 0.0 if turning else slip_acceleration(s[Y + i], w, drag, s[DROP + i], s[RATE + i])
    s[JERK + i] = slip_jerk(s[Y + i], w, s[DW + i], b, drag, s[RATE + i])
    # Steady sliding as this mode sees it; in a reverse slip (b < 0) the equilibrium of the forward one.
    s[Y_BAND + i] = book[i, SIGMA] * book[i, XI_STAR] + s[G + i] * b - offset
    s[Y_STAR + i] = drag * b if mode == FALL and b > 0.0 else s[Y_BAND + i]
    s[RADIUS2 + i] = proven_radius(s, i, book, mode, b) ** 2
    book[i, MODE] = mode


# --- rest: stick, break-away, reversal ------------------------------------------------------------------------------


@compiled
def come_to_rest(s, i, book, cells, results, control, log, u, b, starting):
    """The slip speed is zero, at (u, b) in the present frame: stick and break away again, or slip the other way.

    The belt holds the mass while |u + gamma b| <= mu_static; the load then grows at the rate b, so the stick phase is
    exact.
    """
    c = int(book[i, CELL])
    gamma, mu_static, tau = s[G + i], cells[MU_STATIC, c], s[TAU + i]
    load = u + gamma * b
    if abs(load) > mu_static:
        if load < 0.0:
            u, b, book[i, SIGMA] = -u, -b, -book[i, SIGMA]
        begin_slip(s, i, book, cells, log, u, b, False)
        return RUNNING
    if b < 0.0:
        u, b, load, book[i, SIGMA] = -u, -b, -load, -book[i, SIGMA]
    sigma = book[i, SIGMA]
    left = s[TAU_END + i] - tau
    dwell = (mu_static - load) / b if b > 0.0 else left
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
    if not grazing:
        book[i, STICK_SUM] += dwell
        close_cycle(s, i, book, results, s[TAU + i], dwell)
        if book[i, DECIDED] > 0.0 and control[EARLY_STOP] > 0.0:
            note_ends(book, i, mu_static - gamma * b, 0.0, 0.0)
            finish(s, i, book, results, UNRESOLVED, book[i, DECIDED_BY], sigma * (mu_static - gamma * b), sigma * b)
            return DONE
    begin_slip(s, i, book, cells, log, mu_static - gamma * b, b, True)
    return RUNNING


@compiled
def close_cycle(s, i, book, results, tau, dwell):
    """A break-away at tau: the first starts the cycle, the second closes it.

    After break-away the state is always the same, so one full cycle is the limit cycle, exactly.
    """
    c = int(book[i, CELL])
    if isnan(book[i, CYCLE_START]):
        book[i, CYCLE_START], book[i, HEAT_START] = tau, s[HEAT + i]
        results[BREAKAWAY_TIME, c] = tau
        reset_extrema(book, i)
    elif book[i, DECIDED] == 0.0:
        decide_cycle(s, i, book, results, tau, dwell)


@compiled
def begin_slip(s, i, book, cells, log, u, b, breaking_away):
    """Slip from rest at (u, b), the load exceeding the static limit or, `breaking_away`, having just reached it."""
    c = int(book[i, CELL])
    # Where static friction ends on the curve, w and w' vanish together here and w'' = b > 0 lifts the mass off.
    continuous = breaking_away and cells[MU_STATIC, c] <= cells[A1, c] + cells[A3, c]
    if isnan(book[i, SLIP_START]):
        book[i, SLIP_START] = s[TAU + i]
        note_side(book, i, book[i, SIGMA] * u)
    first_step(s, i, cells, c)
    enter_curve(s, i, book, cells, RISE, u, 0.0, b, continuous)
    note_ends(book, i, u, 0.0, s[DW + i])
    log_slip(log, s, i, RISE, book[i, SIGMA])


# --- attending to a flagged lane ------------------------------------------------------------------------------------


@compiled
def attend(s, i, book, cells, results, control, log):
    """Look at lane i, whose last step was flagged: record what it met, change the mode, or finish the cell."""
    if s[FLAG + i] == 2.0:
        return give_up(s, i, book, results, control)
    kind, h, y, w, dw, work = find_event(s, i, control[RTOL])
    jerk = slip_jerk(y, w, dw, s[B + i], s[G + i] + s[SLOPE + i], s[RATE + i])
    if s[MARK + i] > 0.0:
        record_extrema(s, i, book, results, h, y, w, dw, jerk)
    if s[BAND2 + i] > 0.0:
        note_entry(s, i, book, h, y, w, dw)
    finished_step = s[TAKEN + i]
    s[TAU + i] += h
    s[HEAT + i] += work
    s[Y + i], s[W + i], s[DW + i], s[JERK + i] = y, w, dw, jerk
    if kind == NO_EVENT:
        check_settling(s, i, book, results)
        log_slip(log, s, i, book[i, MODE], book[i, SIGMA])
    else:
        s[STEP + i] = finished_step
        if change_mode(s, i, book, cells, results, control, log, kind) == DONE:
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
def check_settling(s, i, book, results):
    """Inside the disc of `proven_radius` the motion has settled; where the mode may yet change, if it creeps in."""
    p, q = s[Y + i] - s[Y_STAR + i], s[W + i] - s[B + i]
    mode = book[i, MODE]
    may_change = mode == FALL or (mode == RISE and book[i, W_MIN] > 0.0)
    if p * p + q * q < s[RADIUS2 + i] and (not may_change or creeps_in(s, i, mode)):
        decide_settled(s, i, book, results, mode == FALL)


@compiled
def change_mode(s, i, book, cells, results, control, log, kind):
    """The mode of lane i ends at its present state."""
    mode, b, w = book[i, MODE], s[B + i], s[W + i]
    u = s[Y + i] - s[G + i] * b + s[OFFSET + i]
    if s[MARK + i] > 0.0:
        note_ends(book, i, u, w, s[DW + i])
    if kind == LEVEL_REACHED and s[LEVEL + i] == 0.0:
        return come_to_rest(s, i, book, cells, results, control, log, u, b, False)
    if mode == FALL:
        return leave_line(s, i, book, cells, results, control, log, u, w, b)
    if kind == LEVEL_REACHED and mode == RISE:
        enter_curve(s, i, book, cells, FAST, u, w, b, False)
    elif kind == LEVEL_REACHED:
        enter_fall(s, i, book, cells, u, w, b, False)
    else:
        note_peak(book, i, w - b)
        enter_fall(s, i, book, cells, u, w, b, True)
    log_slip(log, s, i, book[i, MODE], book[i, SIGMA])
    return RUNNING


@compiled
def leave_line(s, i, book, cells, results, control, log, u, w, b):
    """A trough of w on the line. If the curve lies above, neither is consistent: the mass holds its speed meanwhile.

    On the line the speed would rise, on the curve it would fall; the exact (Filippov) solution keeps w constant while
    the load u + gamma u' climbs from the line to the curve.
    """
    c = int(book[i, CELL])
    if book[i, DECIDED] == 0.0 and (b <= w or is_shrinking(s, i, book, cells)):
        decide_settled(s, i, book, results, b <= w)
    mu_line = s[OFFSET + i] + s[SLOPE + i] * w
    mu_curve = stribeck(w, cells[A1, c], cells[A2, c], cells[A3, c], cells[A4, c])
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
    enter_curve(s, i, book, cells, RISE, u, w, b, holds)
    log_slip(log, s, i, RISE, book[i, SIGMA])
    return RUNNING
