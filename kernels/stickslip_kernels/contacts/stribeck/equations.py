"""The equations of motion of slip, in the frame of `layout.py`."""

from math import inf

from ... import layout as at
from ...dense import load_and_speed, rise_and_work, speed
from ...jit import compiled
from ...linking import by_law
from ...roots import MOST_TRIES, crossing
from .laws import RECURRENCES, hidden_depth, last_weakening, next_station, shape, weakening_slope


@compiled(inline=True)
def weakening_in_lane(law, s, i, w):
    """The weakening part of friction of lane i at slip speed w."""
    return s[at.DROP + i] * shape(law, s[at.RATE + i] * w, s[at.EXPONENT + i])


@compiled(inline=True)
def slope_in_lane(law, s, i, y, w):
    """w' of lane i at (y, w)."""
    return y - (s[at.G + i] + s[at.SLOPE + i]) * w - weakening_in_lane(law, s, i, w)


@compiled(inline=True)
def jerk_in_lane(law, s, i, y, w, dw, b):
    """w'' of lane i at (y, w) with w' = dw, the belt moving at b; w' tells the weakening without computing it again."""
    drag, rate, drop = s[at.G + i] + s[at.SLOPE + i], s[at.RATE + i], s[at.DROP + i]
    weakening = y - drag * w - dw
    return (b - w) - (drag + rate * weakening_slope(law, rate * w, weakening, drop, s[at.EXPONENT + i])) * dw


@compiled(inline=True)
def state_at(law, s, i, t):
    """y, w, w' and the friction work at t after the start of the step of lane i."""
    w, rise, work = rise_and_work(s, i, t)
    y = s[at.Y + i] + rise
    return y, w, slope_in_lane(law, s, i, y, w), work


@compiled(inline=True)
def next_speed(law, s, i, w, way):
    """The next slip speed after w >= 0, upwards or downwards, at which the curve of lane i has a station."""
    return next_station(law, s[at.RATE + i] * w, way) / s[at.RATE + i]


# --- steps that resolve all the friction they pass through ------------------------------------------------------------
# Friction weakens within a few a4 of standstill. A step that starts and ends far above may dip into that zone between:
# no coefficient, stage or defect at its ends shows it, and a re-stick is missed. So the lowest point of a step is
# bounded from its ends, and a step that may hide the zone is refused; halved, it soon ends inside and sees it.


MARGIN = 1.25  # tangents bound a convex trough; the rest is for one that is not quite


@compiled(inline=True)
def know_steepness(law, s, i, cells, c):
    """Let lane i know where friction weakens: rows FAR and HIDES."""
    drop, a4 = cells[at.A3, c], cells[at.A4, c]
    s[at.FAR + i] = a4 * last_weakening(law, cells[at.DELTA, c])
    s[at.HIDES + i] = a4 * hidden_depth(law, cells[at.DELTA, c]) if drop != 0.0 else inf


@compiled(inline=True)
def may_hide(s, i, h, w, dw, sign=1.0):
    """Return whether the step of lane i over h, to w and w' = dw, may have met friction that its ends do not show.

    sign : of w. A trough of |w| inside lies at most h a b/(a + b) below its nearer end, where the tangents of slopes -a
    and b meet.
    """
    down, up, nearer = -sign * s[at.DW + i], sign * dw, min(sign * s[at.W + i], sign * w)
    slopes = down + up
    return (slopes > 0.0) & (MARGIN * h * down * up > slopes * max(s[at.HIDES + i], nearer - s[at.FAR + i]))


@compiled(inline=True)
def may_bend_twice(s, i, h, dw, jerk):
    """Return whether w'', of one sign at both ends of the step of lane i, may vanish twice in it, at a record of |w'|.

    It falls towards zero, and by its tangent at the start passes it: an extremum of w' that the ends do not show.
    """
    jerk0, snap0, top = s[at.JERK + i], 6.0 * s[at.SERIES + 3 * at.WIDTH + i], max(abs(s[at.DW + i]), abs(dw))
    falls = (jerk0 * jerk > 0.0) & (jerk0 * snap0 < 0.0) & (h * abs(snap0) > abs(jerk0))
    return falls & (top + h * abs(jerk0) >= s[at.DW_TOP + i])


# --- extrema of the acceleration within a step ------------------------------------------------------------------------

RESOLVED = 1e-3  # correction at which Newton's method ends, relative to the time found
FLAT = 1e-6  # the same of the step, where neither end is near


@compiled(inline=True)
def slope_and_jerk(law, s, i, t):
    """w' and w'' at t after the start of the step, by the equation of motion at y and w of the series."""
    y, w = load_and_speed(s, i, t)
    slope = slope_in_lane(law, s, i, y, w)
    return slope, jerk_in_lane(law, s, i, y, w, slope, s[at.B + i] + t * s[at.ALPHA + i])


@by_law("sife:f")
def extreme_slope(law, s, i, end, at_end):
    """w' where w'' vanishes before `end`, by the equation of motion: the Illinois method. at_end : as for `arrival`."""
    low, high, f_low, f_high, slope = 0.0, end, s[at.JERK + i], at_end[2], s[at.DW + i]
    for _ in range(MOST_TRIES):
        t = (low * f_high - high * f_low) / (f_high - f_low)
        slope, f = slope_and_jerk(law, s, i, t)
        moved = abs(t - high)
        if f * f_high < 0.0:
            low, f_low = high, f_high
        else:
            f_low *= 0.5
        high, f_high = t, f
        if moved <= FLAT * end or f == 0.0:
            break
    return slope


extreme_slope_of_motion = compiled(extreme_slope)


@extreme_slope.of(*RECURRENCES)
def _by_series(law, s, i, end, at_end):
    """The time by the series, as far as the equation of motion agrees that w'' is zero there. It need not just above a
    steep fall of friction, where what is left of the fall moves w by less than its tolerance, but not w''.
    """
    t = crossing(s, i, 2, 0.0, end, at_end, RESOLVED)
    slope, jerk = slope_and_jerk(law, s, i, t)
    if jerk * jerk <= 2.0 * abs(speed(s, i, t)[3]) * s[at.ALLOWED + i]:  # twice by how much the extremum differs
        return slope
    return extreme_slope_of_motion(law, s, i, end, at_end)
