"""The hysteretic curve below its minimum: down the line (fall), and at constant speed between line and curve (hold).

Closed forms over as many segments of the drive as they last; u, w, b are displacement, slip speed and belt speed in the
frame of `layout.py`, and alpha + u + gamma u' is the load.
"""

from math import inf

from ... import layout as at
from ... import observers
from ...drive import acceleration, belt_in_lane, next_segment, pass_time, segment_is_over
from ...events import LEVEL_REACHED, NO_EVENT, TURNED
from ...jit import compiled
from ...machine import DONE, RUNNING
from .first_passage import first_passage, is_above
from .friction import coefficient, line_slope
from .hysteresis_line import LONGEST, Line, along_line, end_on_line, first_stretch
from .slip import enter_curve
from .stick import stick

CURVE, LINE, DRIVE_OVER = range(3)  # what ends a hold


@compiled(inline=True)
def displacement_on_line(m, i, line, w, dw):
    """u of lane i from the equation of motion, friction being that of the line."""
    b = belt_in_lane(m, i, 0.0)
    return line.mu_stop + line.slope * w + dw - acceleration(m, i) - m.s[at.G + i] * (b - w)


@compiled
def fall(m, i, u, w, dw):
    """From (u, w) on, w' = dw <= 0, friction follows the line to (0, mu_stop), Eq. (2a), until w or w' is zero.

    A trough of w on the line leads up the curve; where that lies above, at constant speed until the load has risen
    to it or fallen back to the line (`hold`).
    """
    s, cells, c = m.s, m.cells, int(m.s[at.CELL + i])
    slope = line_slope(w, coefficient(m.law, cells, c, w), cells[at.MU_STOP, c])
    line = Line(cells[at.MU_STOP, c], slope, s[at.G + i] + slope)
    h = first_stretch(line.drag)
    s[at.MODE + i] = at.FALL
    while True:
        alpha, left = acceleration(m, i), s[at.TAU_END + i] - s[at.TAU + i]
        kind, t = end_on_line(m, i, w, dw, line.drag, min(h, left))
        if observers.stays_on_line(m, i, line, u, w, dw, kind, t):
            return DONE
        if t >= left:
            kind, t = NO_EVENT, left
        observers.observe_line(m, i, line, u, w, dw, t)
        w, dw = along_line(m, i, w, dw, line.drag, t)
        pass_time(m, i, t)
        if kind == LEVEL_REACHED:
            observers.observe_standstill(m, i, dw)
            return stick(m, i, displacement_on_line(m, i, line, 0.0, dw), True)
        h = min(2.0 * h, LONGEST)
        u = displacement_on_line(m, i, line, w, dw)
        if kind == NO_EVENT and segment_is_over(s, i):
            if not next_segment(m, i):
                return observers.finish(m, i, at.HORIZON_REACHED, u, belt_in_lane(m, i, 0.0) - w)
            dw += acceleration(m, i) - alpha
            h = first_stretch(line.drag)
        if kind == TURNED or dw > 0.0:
            observers.observe_trough(m, i, u, w)
            if observers.is_over(m, i):
                return observers.finish(m, i, s[at.DECIDED_BY + i], u, belt_in_lane(m, i, 0.0) - w)
            mu_line, mu_curve = line.mu_stop + slope * w, coefficient(m.law, cells, c, w)
            onto = CURVE
            if mu_curve > mu_line:
                onto, u, dw = hold(m, i, u, w, dw if kind != TURNED else 0.0, mu_line, mu_curve)
            if onto == DRIVE_OVER:
                return observers.finish(m, i, at.HORIZON_REACHED, u, belt_in_lane(m, i, 0.0) - w)
            if onto == CURVE:
                enter_curve(m, i, at.RISE if w < s[at.W_MIN + i] else at.FAST, u, w, mu_curve > mu_line and dw == 0.0)
                return RUNNING
            s[at.MODE + i] = at.FALL
            h = first_stretch(line.drag)


@compiled
def hold(m, i, u, w, dw, mu_line, mu_curve):
    """Constant slip speed w while the load lies between line and curve: the exact (Filippov) solution.

    On the line, where w' would be dw, the speed would rise; on the curve it would fall. Returns what the load has come
    to, u, and w' there, which is zero but where a jump of the load ends the hold.
    """
    s, gamma, load = m.s, m.s[at.G + i], mu_line + dw
    s[at.MODE + i] = at.HOLD
    while True:
        b, alpha = belt_in_lane(m, i, 0.0), acceleration(m, i)
        rate, left = b - w + gamma * alpha, s[at.TAU_END + i] - s[at.TAU + i]
        up = first_passage(load, rate, alpha, mu_curve, 0.0, 1.0, left)
        down = first_passage(-load, -rate, -alpha, -mu_line, 0.0, 1.0, left)
        t = min(up, down, left)
        observers.observe_constant_speed(m, i, u, b, w, t)
        u += t * (b - w + 0.5 * alpha * t)
        pass_time(m, i, t)
        if min(up, down) < inf and not segment_is_over(s, i):
            over = load - mu_curve if up <= down else mu_line - load
            jump = over if is_above(over, alpha, mu_curve if up <= down else mu_line) else 0.0
            return (CURVE, u, jump) if up <= down else (LINE, u, -jump)
        load += t * (rate + 0.5 * alpha * t) - alpha
        if not next_segment(m, i):
            return DRIVE_OVER, u, 0.0
        load += acceleration(m, i)
