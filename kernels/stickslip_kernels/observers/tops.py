"""Extrema of w and of w' inside the step, in all lanes at once, so that a lane needs no look to exceed its records.

`seek` says which one a step may hold, `search` finds it by the series, and once the step is committed `record_tops`
keeps it. Two passes over the series after a first guess are enough for nearly every step; where they are not, the lane
is looked at.
"""

from math import inf, nan

from .. import layout as at
from ..arithmetic import nonzero_bits, select, widest_vectors
from ..contacts.stribeck.equations import jerk_in_lane, slope_in_lane
from ..contacts.stribeck.laws import RECURRENCES
from ..dense import horner
from ..jit import compiled
from ..layout import WIDTH  # a literal, which `nonzero_bits` needs
from ..linking import by_law
from ..roots import FOR_A_VALUE, reverted


@by_law(":b", inline=True)
def has_exact_derivatives(law):
    """Return whether the series tells the extrema of w', as those of the motion do."""
    return False


has_exact_derivatives.of(*RECURRENCES)(lambda law: True)


# --- which a step may hold, from its start to a state after h ---------------------------------------------------------


@compiled(inline=True)
def reach(a, b, h):
    """Return how far beyond the nearer end an extremum within h may lie, its slopes at the ends being a and b.

    A bound where the slope only falls, or only rises, on the way.
    """
    return h * min(abs(a), abs(b))


@compiled(inline=True)
def has_top_speed(s, i, h, w, dw):
    """Return whether an extremum of w may be the largest so far."""
    w0, dw0 = s[at.W + i], s[at.DW + i]
    return (dw0 * dw < 0.0) & (max(w0, w) + reach(dw0, dw, h) >= s[at.W_TOP + i])


@compiled(inline=True)
def has_low_speed(s, i, h, w, dw):
    """Return whether a trough of w may be the least of this slip so far."""
    w0, dw0 = s[at.W + i], s[at.DW + i]
    return (dw0 < 0.0) & (dw > 0.0) & (min(w0, w) - reach(dw0, dw, h) <= s[at.W_LEAST + i])


@compiled(inline=True)
def has_top_slope(s, i, h, dw, jerk):
    """Return whether an extremum of w' may be the largest so far."""
    dw0, jerk0 = s[at.DW + i], s[at.JERK + i]
    return (jerk0 * jerk < 0.0) & (max(abs(dw0), abs(dw)) + reach(jerk0, jerk, h) >= s[at.DW_TOP + i])


@compiled(inline=True)
def seek(s, i, speed, slope, exact):
    """Have an extremum of w, else of w', found in lane i; True where one of w' must be looked at instead.

    exact : `has_exact_derivatives`.
    """
    slope_here = slope & exact
    s[at.SOUGHT + i] = select(speed, at.OF_SPEED, select(slope_here, at.OF_SLOPE, 0.0))
    return slope & (speed | (not slope_here))


# --- where it is ------------------------------------------------------------------------------------------------------


@compiled
def search(s):
    """Row TOP of the lanes with SOUGHT; where it is not found, SOUGHT becomes 0, and LOOK 1."""
    if nonzero_bits(s, at.SOUGHT, WIDTH) != 0:
        guess_tops(s)
        close_in(s)


@compiled(inline=True)
def sought_at(speed, dw, a, b, c):
    """The series, up to the cube, of what vanishes at the extremum, from coefficients 1 to 4 of the series of w."""
    third = select(speed, 3.0 * b, 12.0 * c)
    return select(speed, dw, 2.0 * a), select(speed, 2.0 * a, 6.0 * b), third, select(speed, 4.0 * c, 0.0)


@compiled(inline=True)
def guess_tops(s):
    """Hermite's inverse cubic between the ends of the step for w, a parabola for w'; then one pass by Halley."""
    widest_vectors()
    for i in range(at.WIDTH):
        speed, end = s[at.SOUGHT + i] == at.OF_SPEED, s[at.TAKEN + i]
        jerk0, jerk1, snap0 = s[at.JERK + i], s[at.JERK_NEW + i], 6.0 * s[at.SERIES + 3 * at.WIDTH + i]
        f0, f1 = select(speed, s[at.DW + i], jerk0), select(speed, s[at.DW_NEW + i], jerk1)
        slope0 = select(speed, jerk0, snap0)
        change = f1 - f0
        per_both, per_slope1 = 1.0 / (change * slope0), 1.0 / jerk1
        part = -f0 * slope0 * per_both
        rest, bow = 1.0 - part, change * change * per_both
        cubic = part * part * (3.0 - 2.0 * part) * end + part * rest * (rest * bow - part * change * per_slope1)
        t = select(speed, cubic, part * (part * end + rest * bow))
        t = select((t > 0.0) & (t <= end), t, part * end)
        _, dw, a, b, _, _, c = horner(s, i, t)
        f, slope, bend, _ = sought_at(speed, dw, a, b, c)
        s[at.GUESS + i] = t - f * slope / (slope * slope - f * bend)


@compiled(inline=True)
def close_in(s):
    """The extremum of w, or the time of that of w', by the series about the guess."""
    widest_vectors()
    for i in range(at.WIDTH):
        sought, end, t = s[at.SOUGHT + i], s[at.TAKEN + i], s[at.GUESS + i]
        speed = sought == at.OF_SPEED
        w, dw, a, b, _, _, c = horner(s, i, t)
        f, slope, bend, last = sought_at(speed, dw, a, b, c)
        d, exact = reverted(0.0, f, slope, bend, last, end)
        slope_there = dw + d * (2.0 * a + d * (3.0 * b + d * 4.0 * c))
        s[at.TOP + i] = select(speed, w + d * (dw + d * (a + d * (b + d * c))), slope_there)
        s[at.GUESS + i], s[at.GUESS_B + i], s[at.TOP_TIME + i] = t + d, b, select(exact, t + d, nan)
        found = (abs(d) <= FOR_A_VALUE * end) & (t + d > 0.0) & (t + d <= end)
        give_up(s, i, (sought > 0.0) & (not found))


@by_law("s:")
def confirm_slopes(law, s):
    """The extrema of w' by the equation of motion, which tells besides whether they are (`equations.extreme_slope`)."""
    widest_vectors()
    if not has_exact_derivatives(law) or nonzero_bits(s, at.SOUGHT, WIDTH) == 0:
        return
    for i in range(at.WIDTH):
        t, sixth_snap = s[at.GUESS + i], s[at.GUESS_B + i]
        w, _, _, _, once, _, _ = horner(s, i, t)
        is_slope = s[at.SOUGHT + i] == at.OF_SLOPE
        y = s[at.Y + i] + t * (s[at.B + i] + 0.5 * t * s[at.ALPHA + i]) - once
        slope = slope_in_lane(law, s, i, y, w)
        jerk = jerk_in_lane(law, s, i, y, w, slope, s[at.B + i] + t * s[at.ALPHA + i])
        s[at.TOP + i] = select(is_slope, slope, w)
        give_up(s, i, is_slope & (not (jerk * jerk <= 12.0 * abs(sixth_snap) * s[at.ALLOWED + i])))


@compiled(inline=True)
def give_up(s, i, missed):
    """Have lane i looked at where the extremum is not found. (A select of what was loaded would be a masked store.)"""
    s[at.LOOK + i] = max(s[at.LOOK + i], select(missed, 1.0, 0.0))
    s[at.SOUGHT + i] = min(s[at.SOUGHT + i], select(missed, 0.0, at.OF_SLOPE))


@compiled(inline=True)
def is_found(s, i, h, what):
    """Return whether TOP of lane i is the extremum of this kind in the first h of its step."""
    return s[at.SOUGHT + i] == what and h == s[at.TAKEN + i]


@compiled
def record_tops(s):
    """Keep what was found in the lanes whose steps have been committed; a trough is a margin, too."""
    widest_vectors()
    if nonzero_bits(s, at.SOUGHT, WIDTH) == 0:
        return
    for i in range(at.WIDTH):
        sought, top = s[at.SOUGHT + i], s[at.TOP + i]
        committed = (s[at.FLAG + i] == at.NOTHING_MET) & (s[at.GOOD + i] > 0.0)
        speed, slope = committed & (sought == at.OF_SPEED), committed & (sought == at.OF_SLOPE)
        v = s[at.SIGMA + i] * top
        s[at.V_HIGH + i] = max(s[at.V_HIGH + i], select(speed, v, -inf))
        s[at.V_LOW + i] = min(s[at.V_LOW + i], select(speed, v, inf))
        s[at.W_TOP + i] = max(s[at.W_TOP + i], select(speed & (s[at.W_TOP + i] > -inf), top, -inf))
        s[at.W_LEAST + i] = min(s[at.W_LEAST + i], select(speed & (s[at.DW_NEW + i] > 0.0), max(top, 0.0), inf))
        s[at.DW_TOP + i] = max(s[at.DW_TOP + i], select(slope, abs(top), 0.0))
