"""Stick: the mass moves with the belt until the load reaches static friction.

Closed forms over as many segments of the drive as the stick phase lasts; u, w, b are displacement, slip speed and belt
speed in the frame of `layout.py`, and alpha + u + gamma b is the load.
"""

from math import inf

from ... import layout as at
from ... import observers
from ...drive import acceleration, belt_in_lane, flip, next_segment, pass_time, segment_is_over, steady_load
from ...jit import compiled
from .ageing import static_friction
from .first_passage import ROUNDING, first_passage, is_above
from .slip import begin_slip

# A re-stick shorter than the integration can resolve is a grazing contact, not a stick phase. A dip of the slip speed
# below zero, had it not stuck, of this many tolerances is called grazing; one turn of an undamped oscillation loses
# half as much (measured at any tolerance). Only a slip in the direction of the belt can graze: one that comes back from
# the other arrives at a rate, and how long it then sticks is as exact as the load.
GRAZING_ERRORS = 0.1
# Without any drag (Coulomb's friction, no damper) a slip from break-away comes back to standstill exactly there: a dip
# of this share is an error of the integration, and no cycle of stick-slip exists.
WITHOUT_DRAG = 1e-4


@compiled
def stick(m, i, u, after_slip):
    """The slip speed is zero at u: move with the belt until break-away, or slip the other way at once.

    The belt holds the mass while the load is within static friction; in each segment the load is a quadratic of the
    time, so the moment of break-away is exact.
    """
    s, cells, c = m.s, m.cells, int(m.s[at.CELL + i])
    comes_back = belt_in_lane(m, i, 0.0) < 0.0
    if comes_back:
        flip(s, i)
        u = -u
    b, alpha, gamma = belt_in_lane(m, i, 0.0), acceleration(m, i), s[at.G + i]
    load, impulse, start, u_start = alpha + u + gamma * b, 0.0, s[at.TAU + i], u
    amplitude = max(abs(u - steady_load(m, i)), b)
    s[at.MODE + i] = at.STICK
    s[at.AGE + i] = 0.0 if after_slip else cells[at.CONTACT_START, c]
    if after_slip:
        observers.observe_contact(m, i, static_friction(cells, c, 0.0) - abs(load), comes_back)
    while True:
        left, rate, age = s[at.TAU_END + i] - s[at.TAU + i], b + gamma * alpha, s[at.AGE + i]
        limit, growth, later = static_friction(cells, c, age), cells[at.AGEING, c], cells[at.AGEING_TIME, c] + age
        up = first_passage(load, rate, alpha, limit, growth, later, left)
        down = first_passage(-load, -rate, -alpha, limit, growth, later, left)
        t = min(up, down, left)
        if min(up, down) == inf:
            observers.observe_load_that_stays(m, i, u, b)
            if observers.is_over(m, i):
                observers.observe_stick(m, i, start, u_start, load, after_slip, False)
                return observers.finish(m, i, s[at.DECIDED_BY + i], u, b)
        observers.observe_constant_speed(m, i, u, b, 0.0, t)
        u += t * (b + 0.5 * alpha * t)
        impulse += t * (load + t * (0.5 * rate + alpha * t / 6.0))
        pass_time(m, i, t)
        s[at.AGE + i] = age + t
        if min(up, down) < inf and not segment_is_over(s, i):
            break
        if not next_segment(m, i):
            b += alpha * t
            observers.observe_stick(m, i, start, u_start, alpha + u + gamma * b, after_slip, False)
            return observers.finish(m, i, at.HORIZON_REACHED, u, b)
        b, alpha = belt_in_lane(m, i, 0.0), acceleration(m, i)
        load = alpha + u + gamma * b
    smooth = not is_above(abs(load) - limit, alpha, limit)
    limit = static_friction(cells, c, s[at.AGE + i])
    if down < up:
        flip(s, i)
        u, u_start, impulse = -u, -u_start, -impulse
    if smooth:  # then the load is the limit, exactly
        u = limit - acceleration(m, i) - gamma * belt_in_lane(m, i, 0.0)
    dip = limit * (s[at.TAU + i] - start) - impulse  # of the slip speed below zero, had it not stuck
    at_once = s[at.TAU + i] == start
    error = max(GRAZING_ERRORS * m.rtol, WITHOUT_DRAG * has_no_drag(cells, c))
    grazing = after_slip and (at_once or (not comes_back and dip < error * amplitude))
    if not grazing:
        thrown = not smooth and at_once
        observers.observe_stick(m, i, start, u_start, limit, after_slip, thrown)
        observers.observe_breakaway(m, i, start, limit, thrown)
        if observers.is_over(m, i):
            return observers.finish(m, i, s[at.DECIDED_BY + i], u, belt_in_lane(m, i, 0.0))
    # Where static friction ends on the curve, w and w' vanish together here and w'' > 0 starts the slip.
    return begin_slip(m, i, at.RISE, u, 0.0, smooth and limit <= cells[at.A1, c] + cells[at.A3, c], not grazing)


@compiled
def has_no_drag(cells, c):
    """Return whether friction is Coulomb's, no greater at break-away, and nothing else damps or feeds cell c."""
    constant = cells[at.A2, c] == 0.0 and cells[at.A3, c] == 0.0 and cells[at.GAMMA, c] == 0.0
    return constant and cells[at.AGEING, c] == 0.0 and cells[at.MU_STATIC, c] <= cells[at.A1, c] * (1.0 + ROUNDING)
