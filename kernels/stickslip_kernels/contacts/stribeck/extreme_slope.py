"""Extrema of the acceleration within a step: by the series where it tells them, else by the equations of motion."""

from ... import layout as at
from ...dense import horner, load_and_speed
from ...jit import compiled
from ...roots import GUESSES, MOST_TRIES
from .equations import jerk_in_lane, slope_in_lane

FOR_A_VALUE_BY_NEWTON = 1e-3  # correction at which a search for a value ends, relative to the time found
FLAT = 1e-6  # the same of the step, where neither end is near


@compiled
def extreme_slope(law, s, i, end, at_end):
    """w' where w'' vanishes before `end`. at_end : as for `arrival`.

    The time by the series, w' there by the equation of motion, which tells besides whether w'' is zero. It need not be
    just above a steep fall of friction, where what is left of the fall moves w by less than its tolerance, but not w''.
    """
    jerk, snap = s[at.JERK + i], 6.0 * s[at.SERIES + 3 * at.WIDTH + i]
    change = at_end[2] - jerk
    part = -jerk / change
    t = part * (part * end + (1.0 - part) * change / snap)  # the parabola of t over w''
    for _ in range(GUESSES):
        if not 0.0 < t <= end:
            break
        w, dw, half_jerk, sixth_snap, once, _, _ = horner(s, i, t)
        d = -half_jerk / (3.0 * sixth_snap)
        if abs(d) <= FOR_A_VALUE_BY_NEWTON * end and 0.0 < t + d <= end:
            once += d * (w + d * (0.5 * dw + d * (half_jerk * (1.0 / 3.0) + d * sixth_snap * 0.25)))
            w += d * (dw + d * (half_jerk + d * sixth_snap))
            t += d
            y = s[at.Y + i] + t * (s[at.B + i] + 0.5 * t * s[at.ALPHA + i]) - once
            slope = slope_in_lane(law, s, i, y, w)
            jerk = jerk_in_lane(law, s, i, y, w, slope, s[at.B + i] + t * s[at.ALPHA + i])
            if jerk * jerk <= 12.0 * abs(sixth_snap) * s[at.ALLOWED + i]:  # twice by how much the extremum differs
                return slope
            break
        t += d
    return extreme_slope_of_motion(law, s, i, end, at_end)


@compiled
def extreme_slope_of_motion(law, s, i, end, at_end):
    """The same with w' and w'' by the equation of motion throughout: the Illinois method."""
    low, high, f_low, f_high, slope = 0.0, end, s[at.JERK + i], at_end[2], s[at.DW + i]
    for _ in range(MOST_TRIES):
        t = (low * f_high - high * f_low) / (f_high - f_low)
        y, w = load_and_speed(s, i, t)
        slope = slope_in_lane(law, s, i, y, w)
        f = jerk_in_lane(law, s, i, y, w, slope, s[at.B + i] + t * s[at.ALPHA + i])
        moved = abs(t - high)
        if f * f_high < 0.0:
            low, f_low = high, f_high
        else:
            f_low *= 0.5
        high, f_high = t, f
        if moved <= FLAT * end or f == 0.0:
            break
    return slope
