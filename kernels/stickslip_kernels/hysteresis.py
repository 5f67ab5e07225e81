"""The hysteretic curve below its minimum: down the line (fall), and at constant speed between line and curve (hold).

Both are closed forms and pass inside one call.
"""

from math import inf, isnan

from .friction import coefficient, line_slope
from .jit import compiled
from .layout import (
    BAND, BAND2, CELL, DECIDED, DECIDED_BY, DW_HIGH, EARLY_STOP, ENTERED, G, HEAT, HELD, HOLD, HORIZON_REACHED,
    MARK, MU_STOP, MU_TURN, RISE, SETTLED, SETTLING_OBSERVED, SIGMA, TAU, TAU_END, UNRESOLVED, XI_STAR,
)  # fmt: skip
from .line import distance2, entry_time, level_time, motion, square_integral, turn_time
from .extrema import note_turn
from .regimes import decide_settled, finish, note_ends
from .rest import DONE, RUNNING, come_to_rest
from .settling import is_shrinking, note_entry_at_constant_speed
from .slip import enter_curve
from .trace import log_closed_form, log_fall, log_slip

# A trough this close to the belt speed, in settling bands, is steady sliding on the line: the drift that is left takes
# a million times as long to matter.
STANDSTILL = 1e-6


@compiled
def fall(law, s, i, cells, results, control, log, u, w, dw, b):
    """From (u, w) on, w' = dw <= 0, friction follows the line to (0, mu_stop), Eq. (2a), until w or w' is zero."""
    c = int(s[CELL + i])
    mu_reversal = coefficient(law, cells, c, w)
    if isnan(s[MU_TURN + i]):
        s[MU_TURN + i] = mu_reversal
    slope = line_slope(w, mu_reversal, cells[MU_STOP, c])
    drag, q, left = s[G + i] + slope, w - b, s[TAU_END + i] - s[TAU + i]
    log_fall(log, s[TAU + i], s[SIGMA + i], u, w, dw, cells[MU_STOP, c], slope)
    stops, duration = end_of_fall(q, dw, drag, b)
    at_trough = not stops and duration < inf
    q1, dw1 = motion(q, dw, drag, min(duration, left))
    if duration == inf or (at_trough and duration < left and 0.0 <= -q1 < STANDSTILL * s[BAND + i]):
        status = SETTLED if duration == inf else SETTLING_OBSERVED
        return stay_on_line(s, i, cells, results, control, u, q, dw, drag, slope, b, status)
    along_line(s, i, results, u, q, dw, drag, slope, cells[MU_STOP, c], b, min(duration, left))
    u1 = cells[MU_STOP, c] + slope * (q1 + b) + s[G + i] * q1 + dw1  # the equation of motion, u' = -q
    s[TAU + i] += min(duration, left)
    if duration >= left:
        finish(s, i, results, UNRESOLVED, HORIZON_REACHED, s[SIGMA + i] * u1, -s[SIGMA + i] * q1)
        return DONE
    if stops:
        return come_to_rest(law, s, i, cells, results, control, log, u1, b, False)
    return leave_line(law, s, i, cells, results, control, log, u1, b + q1, b, slope)


@compiled
def end_of_fall(q, v, drag, b):
    """Whether the fall ends in rest rather than in a trough, and after what time; inf if w sinks to b for ever.

    At a trough w'' = b - w > 0: only below the belt speed.
    """
    turn = turn_time(q, v, drag)
    if turn == inf:
        if b > 0.0 and drag > 0.0:
            return False, inf
        latest = 1.0
        while motion(q, v, drag, latest)[0] > -b and latest < 1e300:
            latest *= 2.0
        return True, level_time(q, v, drag, -b, latest) if latest < 1e300 else inf
    if motion(q, v, drag, turn)[0] > -b:
        return False, turn
    return True, level_time(q, v, drag, -b, turn)


@compiled
def along_line(s, i, results, u, q, v, drag, slope, mu_stop, b, duration):
    """Note extrema, crossings, the settling band and the friction work of a fall."""
    sigma = s[SIGMA + i]
    q1, v1 = motion(q, v, drag, duration)
    u1 = mu_stop + slope * (q1 + b) + s[G + i] * q1 + v1
    if s[MARK + i] > 0.0:
        steepest = turn_time(v, -q - drag * v, drag)
        if steepest < duration:
            s[DW_HIGH + i] = max(s[DW_HIGH + i], abs(motion(q, v, drag, steepest)[1]))
        if q > 0.0 > q1:
            t = level_time(q, v, drag, 0.0, duration)
            note_turn(s, i, sigma * (mu_stop + slope * b + motion(q, v, drag, t)[1]))
        note_ends(s, i, u1, b + q1, v1)
    if s[BAND2 + i] > 0.0:
        note_entry_on_line(s, i, q, v, drag, mu_stop + slope * b - sigma * s[XI_STAR + i], duration)
    s[HEAT + i] += friction_work(q, v, drag, b, mu_stop, slope, duration, u1 - u)


@compiled
def note_entry_on_line(s, i, q, v, drag, shift, duration):
    """Note when in a fall the motion came into the settling band for good.

    The distance from steady sliding has its extremes where q = 0 and where drag q = -shift; q falls all the way, so
    that between these times the distance is monotone.
    """
    band2, end = s[BAND2 + i], duration
    q_end, v_end = motion(q, v, drag, end)
    levels = (0.0, -shift / drag)
    for _ in range(3):
        if distance2(q_end, v_end, drag, shift) >= band2:
            return
        start, q_start, v_start = 0.0, q, v
        for level in levels:  # the last extreme before the end of this piece
            if q_start > level > q_end:
                start = level_time(q, v, drag, level, duration)
                q_start, v_start = level, motion(q, v, drag, start)[1]  # exactly: it is not found again
        if distance2(q_start, v_start, drag, shift) >= band2:
            s[ENTERED + i] = s[TAU + i] + start + entry_time(q_start, v_start, drag, shift, band2, end - start)
            return
        if start == 0.0:
            return
        end, q_end, v_end = start, q_start, v_start


@compiled
def friction_work(q, v, drag, b, mu_stop, slope, t, advance):
    """Integral of (mu_stop + slope w) w over the next time t, in which u moves by `advance`."""
    way = b * t - advance
    return mu_stop * way + slope * (square_integral(q, v, drag, t) + b * (2.0 * way - b * t))


@compiled
def stay_on_line(s, i, cells, results, control, u, q, v, drag, slope, b, settled_by):
    """The slip sinks to the belt speed on the line and stays there: steady sliding, settled."""
    c = int(s[CELL + i])
    sigma, left = s[SIGMA + i], s[TAU_END + i] - s[TAU + i]
    band2, u_star = s[BAND + i] ** 2, cells[MU_STOP, c] + slope * b
    settled = 0.0
    if distance2(q, v, drag, 0.0) >= band2:
        latest = 1.0
        while distance2(*motion(q, v, drag, latest), drag, 0.0) >= band2 and latest < min(left, 1e300):
            latest *= 2.0
        settled = entry_time(q, v, drag, 0.0, band2, latest)
    along_line(s, i, results, u, q, v, drag, slope, cells[MU_STOP, c], b, min(settled, left))
    status = HORIZON_REACHED
    if settled < left and s[DECIDED + i] == 0.0:
        note_ends(s, i, u_star, b, 0.0)
        inside = settled == 0.0 and distance2(q, v, drag, u_star - sigma * s[XI_STAR + i]) < band2
        entered = s[ENTERED + i] if inside else s[TAU + i] + settled
        decide_settled(s, i, results, entered, sigma * u_star, settled_by)
        if control[EARLY_STOP] > 0.0:
            left, status = settled, s[DECIDED_BY + i]
    q1, v1 = motion(q, v, drag, left)
    finish(s, i, results, UNRESOLVED, status, sigma * (u_star + (drag * q1 + v1)), -sigma * q1)
    return DONE


@compiled
def leave_line(law, s, i, cells, results, control, log, u, w, b, slope):
    """A trough of w on the line. If the curve lies above, neither is consistent: the mass holds its speed meanwhile.

    On the line the speed would rise, on the curve it would fall; the exact (Filippov) solution keeps w constant while
    the load u + gamma u' climbs from the line to the curve.
    """
    c = int(s[CELL + i])
    s[HELD + i] = 1.0
    if s[DECIDED + i] == 0.0 and is_shrinking(s, i, cells, u, w, b):
        note_ends(s, i, s[SIGMA + i] * s[XI_STAR + i], b, 0.0)
        decide_settled(s, i, results, s[ENTERED + i], s[XI_STAR + i], SETTLING_OBSERVED)
    mu_line, mu_curve = cells[MU_STOP, c] + slope * w, coefficient(law, cells, c, w)
    holds = mu_curve > mu_line
    if holds:
        left = s[TAU_END + i] - s[TAU + i]
        duration = (mu_curve - mu_line) / (b - w)
        log_closed_form(log, s[TAU + i], HOLD, s[SIGMA + i], u, w)
        if duration >= left and (s[DECIDED + i] == 0.0 or control[EARLY_STOP] == 0.0):
            sigma = s[SIGMA + i]
            finish(s, i, results, UNRESOLVED, HORIZON_REACHED, sigma * (u + (b - w) * left), sigma * (b - w))
            return DONE
        note_entry_at_constant_speed(s, i, s[TAU + i], u, w, b, duration)
        s[TAU + i] += duration
        s[HEAT + i] += w * duration * 0.5 * (mu_line + mu_curve)
        u += (b - w) * duration
    enter_curve(law, s, i, cells, RISE, u, w, b, holds)
    log_slip(log, s, i, RISE, s[SIGMA + i])
    return RUNNING
