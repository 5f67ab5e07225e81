"""Records of a fall for the observer of regimes: closed forms along the line of a hysteretic curve.

q = w - b and v = w' at its start, as in `hysteresis.py`.
"""

from math import isnan

from .. import layout as at
from .. import observers
from ..contacts.stribeck import hysteresis
from ..jit import compiled
from .extrema import note_turn
from .verdict import decide_settled, note_ends


@compiled(inline=True)
def record_line(m, i, line, u, w, v, duration):
    """Extrema, crossings, the settling band and the friction work of the next `duration` of a fall."""
    s, b, sigma, drag = m.s, m.s[at.B + i], m.s[at.SIGMA + i], line.drag
    q = w - b
    q1, v1 = hysteresis.oscillation(q, v, drag, duration)
    mu_belt = line.mu_stop + line.slope * b
    u1 = line.mu_stop + line.slope * (q1 + b) + s[at.G + i] * q1 + v1  # the equation of motion, u' = -q
    if isnan(s[at.MU_TURN + i]):
        s[at.MU_TURN + i] = line.mu_stop + line.slope * w
    if s[at.MARK + i] > 0.0:
        steepest = hysteresis.turn_time(v, -q - drag * v, drag)
        if steepest < duration:
            s[at.DW_TOP + i] = max(s[at.DW_TOP + i], abs(hysteresis.oscillation(q, v, drag, steepest)[1]))
        if q > 0.0 > q1:
            t = hysteresis.level_time(q, v, drag, 0.0, duration)
            note_turn(s, i, sigma * (mu_belt + hysteresis.oscillation(q, v, drag, t)[1]))
        note_ends(s, i, u1, b + q1, v1)
    if s[at.BAND2 + i] > 0.0:
        note_entry_on_line(s, i, q, v, drag, mu_belt - sigma * s[at.XI_STAR + i], duration)
    fast, fast1 = q * q + v * v, q1 * q1 + v1 * v1
    if fast > 0.0 and fast1 > 0.0:
        along = (q * q - v * v) / fast + (q1 * q1 - v1 * v1) / fast1
        s[at.GAIN + i] = max(s[at.GAIN + i] - 0.5 * along * drag * duration, 0.0)
        s[at.GAIN_TOP + i] = max(s[at.GAIN_TOP + i], s[at.GAIN + i])
    s[at.HEAT + i] += friction_work(line, q, v, b, duration, u1 - u)


@compiled(inline=True)
def friction_work(line, q, v, b, t, advance):
    """Integral of (mu_stop + slope w) w over the next time t, in which u moves by `advance`."""
    way = b * t - advance
    return line.mu_stop * way + line.slope * (hysteresis.square_integral(q, v, line.drag, t) + b * (2.0 * way - b * t))


@compiled
def note_entry_on_line(s, i, q, v, drag, shift, duration):
    """Note when in a fall the motion came into the settling band for good.

    The distance from steady sliding has its extremes where q = 0 and where drag q = -shift; q falls all the way, so
    that between these times the distance is monotone.
    """
    band2, end = s[at.BAND2 + i], duration
    q_end, v_end = hysteresis.oscillation(q, v, drag, end)
    levels = (0.0, -shift / drag)
    for _ in range(3):
        if hysteresis.distance2(q_end, v_end, drag, shift) >= band2:
            return
        start, q_start, v_start = 0.0, q, v
        for level in levels:  # the last extreme before the end of this piece
            if q_start > level > q_end:
                start = hysteresis.level_time(q, v, drag, level, duration)
                q_start, v_start = level, hysteresis.oscillation(q, v, drag, start)[1]  # exactly: it is not found again
        if hysteresis.distance2(q_start, v_start, drag, shift) >= band2:
            entered = hysteresis.entry_time(q_start, v_start, drag, shift, band2, end - start)
            s[at.ENTERED + i] = s[at.TAU + i] + start + entered
            return
        if start == 0.0:
            return
        end, q_end, v_end = start, q_start, v_start


@compiled
def settle_on_line(m, i, line, u, w, v, left, settled_by):
    """The slip speed falls to the belt speed on the line and stays there: steady sliding, settled."""
    s, b, sigma, drag = m.s, m.s[at.B + i], m.s[at.SIGMA + i], line.drag
    q, band2, u_star = w - b, s[at.BAND + i] ** 2, line.mu_stop + line.slope * b
    settled = 0.0
    if hysteresis.distance2(q, v, drag, 0.0) >= band2:
        latest = 1.0
        while hysteresis.distance2(*hysteresis.oscillation(q, v, drag, latest), drag, 0.0) >= band2 and latest < min(
            left, 1e300
        ):
            latest *= 2.0
        settled = hysteresis.entry_time(q, v, drag, 0.0, band2, latest)
    record_line(m, i, line, u, w, v, min(settled, left))
    status = at.HORIZON_REACHED
    if settled < left and s[at.DECIDED + i] == 0.0:
        inside = settled == 0.0 and hysteresis.distance2(q, v, drag, u_star - sigma * s[at.XI_STAR + i]) < band2
        entered = s[at.ENTERED + i] if inside else s[at.TAU + i] + settled
        decide_settled(m, i, entered, sigma * u_star, settled_by)
        if m.observer.until != at.UNTIL_HORIZON:
            left, status = settled, settled_by
    q1, v1 = hysteresis.oscillation(q, v, drag, left)
    observers.finish(m, i, status, u_star + (drag * q1 + v1), -q1)
