"""The state machine of a rig: the modes of the contact on a belt that accelerates.

As in `modes.py`, everything here is scalar and looks at one lane. Slip on the curve is left to the lanes, every step
of which is looked at (RADIUS2 is infinite); stick, fall and hold are closed forms over as many segments of the drive as
they last. Functions return RUNNING when the lane slips on and DONE at the end of the drive.
u, w, b are displacement, slip speed and belt speed in the frame of `layout.py`; f = alpha + u + gamma u' is the load.
"""

from math import inf, isfinite, isnan, nan

from ..ageing import static_friction
from ..equations import jerk_in_lane, slope_in_lane, weakening_in_lane
from ..events import LEVEL_REACHED, NO_EVENT, TURNED, find_event
from ..friction import coefficient, line_slope, speed_of_slope
from ..jit import compiled
from ..lanes import begin_stepping, restart
from ..layout import (
    A1, A2, A3, A4, AGEING, AGEING_TIME, ALPHA, B, BAND2, CELL, CELL_ROWS, CONTACT_START, DELTA, DROP, DW, EXPONENT,
    FALL, FAST, FIRST_SEGMENT, FLAG, FLOOR, G, GAMMA, HOLD, HORIZON_REACHED, JERK, LANE_NUMBERS, LAST_SEGMENT,
    LEVEL, MARK, MODE, MU_STOP, NOT_FINITE, OFFSET, RADIUS2, RATE, RIG_AGE, RIG_BREAKAWAY_LOAD, RIG_BREAKAWAY_TIME,
    RIG_ETA_END, RIG_SLIPS, RIG_STATUS, RIG_STEPS, RIG_STICKS, RIG_STICK_TIME, RIG_SUMS, RIG_XI_END, RISE, RTOL,
    SEGMENT_BELT, SIDE, SIGMA, SLOPE, SLOW, SMALLEST_STEP, STEP, STEP_LIMIT, STEP_UNDERFLOW, STICK, STOP_END,
    STOP_LOAD, STOP_START, TAKEN, TAU, TAU_END, TRIED, TURN, W, WEAK, WEAK_NEW, WIDTH, W_MIN, XI_START, Y, Y_STAR,
)  # fmt: skip
from ..rest import DONE, GRAZING_ERRORS, RUNNING
from ..steep import know_steepness
from .drive import belt_in_lane, flip, next_segment, open_segment, pass_time, segment_is_over
from .line import LONGEST, end_on_line, motion
from .passing import first_passing, is_above
from .signals import displacement_in_lane, displacement_on_line, record_constant_speed, record_line, record_slip

CURVE, LINE, DRIVE_OVER = range(3)  # what ends a hold
SMALLEST_SPEED = 1e-12  # motion below it is lost beside forces of the size of the load

# --- starting and ending --------------------------------------------------------------------------------------------


@compiled
def start_rig(law, s, i, cells, c, segments, runs, results, signals, stops, control):
    """Put rig c into lane i, sticking at XI_START, and bring it to its first slip."""
    for row in RIG_SUMS:
        results[row, c] = 0.0
    for row in range(CELL_ROWS):
        if isnan(cells[row, c]) and (row <= AGEING_TIME or row == XI_START or row == CONTACT_START) and row != MU_STOP:
            results[RIG_STATUS, c] = NOT_FINITE
            return DONE
    first, last = int(runs[c, FIRST_SEGMENT]), int(runs[c, LAST_SEGMENT])
    fastest = 0.0
    for n in range(first, last):
        fastest = max(fastest, abs(segments[n, SEGMENT_BELT]))
    for row in range(SLOW, LANE_NUMBERS, WIDTH):
        s[row + i] = 0.0
    s[CELL + i], s[SIGMA + i], s[RIG_AGE + i] = c, 1.0, cells[CONTACT_START, c]
    s[W_MIN + i] = 0.0 if isnan(cells[MU_STOP, c]) else speed_of_slope(law, cells, c, 0.0)
    know_steepness(law, s, i, cells, c)
    s[G + i], s[RATE + i], s[EXPONENT + i] = cells[GAMMA, c], 1.0 / cells[A4, c], cells[DELTA, c]
    s[TRIED + i], s[MARK + i], s[BAND2 + i], s[RADIUS2 + i] = 0.0, 0.0, 0.0, inf
    s[FLOOR + i] = 1e-3 * fastest + SMALLEST_SPEED
    s[TAU_END + i] = 0.0
    open_segment(s, i, segments, first)
    return stick(law, s, i, cells, segments, runs, results, signals, stops, control, cells[XI_START, c], False)


@compiled
def finish(s, i, results, status, u, velocity):
    """Close the rig of lane i."""
    c, sigma = int(s[CELL + i]), s[SIGMA + i]
    results[RIG_STATUS, c], results[RIG_STEPS, c] = status, s[TRIED + i]
    results[RIG_XI_END, c], results[RIG_ETA_END, c] = sigma * u, sigma * velocity
    return DONE


@compiled
def give_up(s, i, results):
    """No further step: the budget is spent, or the step size fell below rounding."""
    finite = isfinite(s[Y + i]) and isfinite(s[W + i]) and isfinite(s[DW + i])
    if finite and s[STEP + i] >= SMALLEST_STEP:
        return finish(s, i, results, STEP_LIMIT, nan, nan)
    return finish(s, i, results, STEP_UNDERFLOW if finite else NOT_FINITE, nan, nan)


# --- slip -----------------------------------------------------------------------------------------------------------


@compiled
def attend_rig(law, s, i, cells, segments, runs, results, signals, stops, control):
    """Look at lane i, which has tried a good step or can go no further: record it, commit it, change the mode."""
    if s[FLAG + i] == 2.0:
        return give_up(s, i, results)
    kind, h, y, w, dw, _ = find_event(law, s, i)
    b_end = s[B + i] + h * s[ALPHA + i]
    jerk = jerk_in_lane(law, s, i, y, w, dw, b_end)
    record_slip(law, s, i, runs, results, signals, h, dw, jerk)
    s[TAU + i] += h
    s[B + i] = b_end
    s[Y + i], s[W + i], s[DW + i], s[JERK + i], s[WEAK + i] = y, w, dw, jerk, s[WEAK_NEW + i]
    if kind != NO_EVENT:
        restart(law, s, i, s[TAKEN + i])
        if change_mode(law, s, i, cells, segments, runs, results, signals, stops, control, kind) == DONE:
            return DONE
    while segment_is_over(s, i):
        if slip_into_next_segment(law, s, i, cells, segments, runs, results, signals, stops, control) == DONE:
            return DONE
    return RUNNING


@compiled
def change_mode(law, s, i, cells, segments, runs, results, signals, stops, control, kind):
    """The mode of lane i ends at its present state."""
    mode, w = s[MODE + i], s[W + i]
    u = displacement_in_lane(s, i, s[Y + i], 0.0)
    if kind == LEVEL_REACHED and s[LEVEL + i] == 0.0:
        s[RIG_AGE + i] = 0.0
        return stick(law, s, i, cells, segments, runs, results, signals, stops, control, u, True)
    if kind == LEVEL_REACHED and mode == RISE:
        enter_curve(law, s, i, cells, FAST, u, w, False)
        return RUNNING
    return fall(law, s, i, cells, segments, runs, results, signals, stops, control, u, w, s[DW + i])


@compiled
def slip_into_next_segment(law, s, i, cells, segments, runs, results, signals, stops, control):
    """The acceleration of the belt jumps, and with it w'; the end of the drive ends the rig."""
    u, w = displacement_in_lane(s, i, s[Y + i], 0.0), s[W + i]
    if not next_segment(s, i, segments, runs):
        return finish(s, i, results, HORIZON_REACHED, u, belt_in_lane(s, i, 0.0) - w)
    set_slip(law, s, i, cells, u, w, False)
    restart(law, s, i, s[TAKEN + i])
    if s[DW + i] < 0.0 and w <= s[W_MIN + i]:
        if w == 0.0:
            return stick(law, s, i, cells, segments, runs, results, signals, stops, control, u, True)
        return fall(law, s, i, cells, segments, runs, results, signals, stops, control, u, w, s[DW + i])
    return RUNNING


@compiled
def set_slip(law, s, i, cells, u, w, turning):
    """Put lane i at (u, w) under the friction and the belt of its rows; `turning` where w' is zero, exactly."""
    c, b = int(s[CELL + i]), belt_in_lane(s, i, 0.0)
    s[Y + i], s[W + i] = u + s[G + i] * b + s[ALPHA + i] - s[OFFSET + i], w
    s[WEAK + i] = weakening_in_lane(law, s, i, w)
    s[DW + i] = 0.0 if turning else slope_in_lane(law, s, i, s[Y + i], w)
    s[JERK + i] = jerk_in_lane(law, s, i, s[Y + i], w, s[DW + i], s[B + i])
    # Steady sliding at the present speed of the belt: errors are measured against the distance from it.
    mu = coefficient(law, cells, c, abs(b))
    s[Y_STAR + i] = (mu if b >= 0.0 else -mu) + s[G + i] * b - s[OFFSET + i]


@compiled
def enter_curve(law, s, i, cells, mode, u, w, turning):
    """Enter RISE or FAST at (u, w). RISE without hysteresis is the plain curve, which ends only at w = 0."""
    c, w_min = int(s[CELL + i]), s[W_MIN + i]
    s[OFFSET + i], s[SLOPE + i], s[DROP + i] = cells[A1, c], cells[A2, c], cells[A3, c]
    below = mode == RISE and w_min > 0.0
    s[LEVEL + i] = w_min
    s[SIDE + i], s[TURN + i] = (1.0, 1.0) if below else (-1.0, 0.0)
    s[MODE + i] = mode
    set_slip(law, s, i, cells, u, w, turning)


@compiled
def begin_slip(law, s, i, cells, results, u, turning):
    """Slip from rest at u."""
    c = int(s[CELL + i])
    results[RIG_SLIPS, c] += 1.0
    enter_curve(law, s, i, cells, RISE, u, 0.0, turning)
    begin_stepping(law, s, i, cells, c)


# --- below the hysteretic curve -------------------------------------------------------------------------------------


@compiled
def fall(law, s, i, cells, segments, runs, results, signals, stops, control, u, w, dw):
    """From (u, w) on, w' = dw <= 0, friction follows the line to (0, mu_stop), Eq. (2a), until w or w' is zero.

    A trough of w on the line leads up the curve; where that lies above, at constant speed until the load has climbed
    to it or sunk back to the line (`hold`).
    """
    c, gamma, mu_stop = int(s[CELL + i]), s[G + i], cells[MU_STOP, int(s[CELL + i])]
    slope = line_slope(w, coefficient(law, cells, c, w), mu_stop)
    h = first_stretch(gamma + slope)
    s[MODE + i] = FALL
    while True:
        alpha = s[ALPHA + i]
        kind, t = end_on_line(w, dw, s[B + i] - w, alpha, gamma + slope, min(h, s[TAU_END + i] - s[TAU + i]))
        record_line(s, i, runs, results, signals, mu_stop, slope, w, dw, t)
        w, dw, _, _ = motion(w, dw, s[B + i] - w, alpha, gamma + slope, t)
        pass_time(s, i, t)
        h = min(2.0 * h, LONGEST)
        if kind == LEVEL_REACHED:
            s[RIG_AGE + i] = 0.0
            u = displacement_on_line(s, i, mu_stop, 0.0, dw, belt_in_lane(s, i, 0.0))
            return stick(law, s, i, cells, segments, runs, results, signals, stops, control, u, True)
        u = displacement_on_line(s, i, mu_stop + slope * w, w, dw, belt_in_lane(s, i, 0.0))
        if kind != TURNED and segment_is_over(s, i):
            if not next_segment(s, i, segments, runs):
                return finish(s, i, results, HORIZON_REACHED, u, belt_in_lane(s, i, 0.0) - w)
            dw += s[ALPHA + i] - alpha
            h = first_stretch(gamma + slope)
        if kind == TURNED or dw > 0.0:
            mu_line, mu_curve = mu_stop + slope * w, coefficient(law, cells, c, w)
            if mu_curve <= mu_line:
                enter_curve(law, s, i, cells, RISE if w < s[W_MIN + i] else FAST, u, w, False)
                return RUNNING
            onto, u, dw = hold(s, i, segments, runs, results, signals, u, w, mu_line, mu_curve)
            if onto == DRIVE_OVER:
                return finish(s, i, results, HORIZON_REACHED, u, belt_in_lane(s, i, 0.0) - w)
            if onto == CURVE:
                enter_curve(law, s, i, cells, RISE, u, w, dw == 0.0)
                return RUNNING
            s[MODE + i] = FALL
            h = first_stretch(gamma + slope)


@compiled(inline=True)
def first_stretch(drag):
    """A time in which little of the quickest part of the motion on a line dies down."""
    return min(0.5 / abs(drag), LONGEST)


@compiled
def hold(s, i, segments, runs, results, signals, u, w, mu_line, mu_curve):
    """Constant slip speed w while the load lies between line and curve: the exact (Filippov) solution.

    Returns what the load has come to, u, and w' there, which is zero but where a jump of the load ends the hold.
    """
    s[MODE + i] = HOLD
    while True:
        b, alpha, gamma = belt_in_lane(s, i, 0.0), s[ALPHA + i], s[G + i]
        load, rate, left = alpha + u + gamma * (b - w), b - w + gamma * alpha, s[TAU_END + i] - s[TAU + i]
        up = first_passing(load, rate, alpha, mu_curve, 0.0, 1.0, left)
        down = first_passing(-load, -rate, -alpha, -mu_line, 0.0, 1.0, left)
        t = min(up, down, left)
        record_constant_speed(s, i, runs, results, signals, u, b, w, t)
        u += t * (b - w + 0.5 * alpha * t)
        pass_time(s, i, t)
        if min(up, down) < inf and not segment_is_over(s, i):
            over = load - mu_curve if up <= down else mu_line - load
            jump = over if is_above(over, alpha, mu_curve if up <= down else mu_line) else 0.0
            return (CURVE, u, jump) if up <= down else (LINE, u, -jump)
        if not next_segment(s, i, segments, runs):
            return DRIVE_OVER, u, 0.0


# --- stick ----------------------------------------------------------------------------------------------------------


@compiled
def stick(law, s, i, cells, segments, runs, results, signals, stops, control, u, after_slip):
    """The slip speed is zero: ride on the belt to the break-away, or slip the other way at once.

    The belt holds the specimen while |f| is within static friction; f is a quadratic of the time in each segment, so
    the moment of break-away is exact.
    """
    c = int(s[CELL + i])
    b, alpha, gamma = belt_in_lane(s, i, 0.0), s[ALPHA + i], s[G + i]
    load, start, impulse = alpha + u + gamma * b, s[TAU + i], 0.0
    s[MODE + i] = STICK
    while True:
        left, rate, age = s[TAU_END + i] - s[TAU + i], b + gamma * alpha, s[RIG_AGE + i]
        limit, growth, later = static_friction(cells, c, age), cells[AGEING, c], cells[AGEING_TIME, c] + age
        up = first_passing(load, rate, alpha, limit, growth, later, left)
        down = first_passing(-load, -rate, -alpha, limit, growth, later, left)
        t = min(up, down, left)
        record_constant_speed(s, i, runs, results, signals, u, b, 0.0, t)
        u += t * (b + 0.5 * alpha * t)
        impulse += t * (load + t * (0.5 * rate + alpha * t / 6.0))
        pass_time(s, i, t)
        s[RIG_AGE + i] = age + t
        if min(up, down) < inf and not segment_is_over(s, i):
            break
        if not next_segment(s, i, segments, runs):
            load = alpha + u + gamma * (b + alpha * t)
            note_stick(s, i, results, stops, start, s[SIGMA + i] * load)
            return finish(s, i, results, HORIZON_REACHED, u, b + alpha * t)
        b, alpha = belt_in_lane(s, i, 0.0), s[ALPHA + i]
        load = alpha + u + gamma * b
    # Reached smoothly, the load is the limit: where static friction ends on the curve, w' is zero then.
    smooth = not is_above(abs(load) - limit, alpha, limit)
    limit = static_friction(cells, c, s[RIG_AGE + i])
    if down < up:
        flip(s, i)
        u, impulse = -u, -impulse
    dip = limit * (s[TAU + i] - start) - impulse  # of the slip speed below zero, had it not stuck; see `rest.py`
    amplitude = max(limit, abs(belt_in_lane(s, i, 0.0)))
    if not (after_slip and dip < GRAZING_ERRORS * control[RTOL] * amplitude):
        note_stick(s, i, results, stops, start, s[SIGMA + i] * limit)
        if isnan(results[RIG_BREAKAWAY_TIME, c]):
            results[RIG_BREAKAWAY_TIME, c], results[RIG_BREAKAWAY_LOAD, c] = s[TAU + i], limit
    begin_slip(law, s, i, cells, results, u, smooth and limit <= cells[A1, c] + cells[A3, c])
    return RUNNING


@compiled
def note_stick(s, i, results, stops, start, load):
    """Note a stick phase from `start` to now, and the load at its end, seen in the true frame."""
    c = int(s[CELL + i])
    results[RIG_STICKS, c] += 1.0
    results[RIG_STICK_TIME, c] += s[TAU + i] - start
    if stops.shape[0] > 0:
        stops[0, 0] += 1.0
        row = int(stops[0, 0])
        if row < stops.shape[0]:
            stops[row, STOP_START], stops[row, STOP_END], stops[row, STOP_LOAD] = start, s[TAU + i], load
