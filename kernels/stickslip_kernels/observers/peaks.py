"""Extremes of w and of w' inside the step, in all lanes whose steps have series of their own, so that no lane needs a
look to keep them. (`tops.py` has one of both in a step, for laws of which more is known.)
"""

from math import inf, nan

from .. import layout as at
from ..dense import horner
from ..intrinsics import nonzero_bits, select, widest_vectors
from ..jit import compiled
from ..layout import WIDTH  # a literal, which `nonzero_bits` needs
from ..roots import FOR_A_VALUE

SPEED, SLOPE = at.TOP, at.TOP_TIME  # rows of what is found: the extreme of w, and of w'; NaN where none is
SEEK_SPEED, SEEK_SLOPE = at.SOUGHT, at.GUESS  # 1 where it is sought


@compiled(inline=True)
def refined(s, i, t, order):
    """A time nearer to where w' (order 1) or w'' (2) vanishes, by Halley's method, and the extreme there."""
    w, dw, a, b, _, _, c = horner(s, i, t)
    if order == 1:
        f, slope, half_bend = dw, 2.0 * a, 3.0 * b
    else:
        f, slope, half_bend = 2.0 * a, 6.0 * b, 12.0 * c
    d = -f * slope / (slope * slope - f * half_bend)
    top = w + d * (dw + d * (a + d * (b + d * c))) if order == 1 else dw + d * (2.0 * a + d * (3.0 * b + d * 4.0 * c))
    return d, top


@compiled(inline=True)
def first_guess(s, i, order):
    """When w' or w'' vanishes: by Hermite's inverse cubic between the ends, or a parabola from the start."""
    h = s[at.TAKEN + i]
    if order == 1:
        f_0, f_1, slope_0 = s[at.DW + i], s[at.DW_NEW + i], s[at.JERK + i]
    else:
        f_0, f_1, slope_0 = s[at.JERK + i], s[at.JERK_NEW + i], 6.0 * s[at.SERIES + 3 * at.WIDTH + i]
    change = f_1 - f_0
    part = -f_0 / change
    rest, bow = 1.0 - part, change / slope_0
    t = part * (part * h + rest * bow)
    if order == 1:
        t = part * part * (3.0 - 2.0 * part) * h + part * rest * (rest * bow - part * change / s[at.JERK_NEW + i])
    return select((t > 0.0) & (t <= h), t, part * h)


def search(order, row):
    """The loop that finds one of them where it is sought."""
    sought = (SEEK_SPEED, SEEK_SLOPE)[order - 1]

    @compiled
    def loop(s):
        widest_vectors()
        for i in range(at.WIDTH):
            t = first_guess(s, i, order)
            t = min(max(t + refined(s, i, t, order)[0], 0.0), s[at.TAKEN + i])
            d, top = refined(s, i, t, order)
            h = s[at.TAKEN + i]
            found = (abs(d) <= FOR_A_VALUE * h) & (t + d >= 0.0) & (t + d <= h)
            s[row + i] = select((s[sought + i] > 0.0) & found, top, nan)

    return loop


find_speed = search(1, SPEED)
find_slope = search(2, SLOPE)


@compiled
def find(s):
    """Rows SPEED and SLOPE of all lanes."""
    if nonzero_bits(s, SEEK_SPEED, WIDTH) != 0:
        find_speed(s)
    else:
        forget(s, SPEED)
    if nonzero_bits(s, SEEK_SLOPE, WIDTH) != 0:
        find_slope(s)
    else:
        forget(s, SLOPE)
    look_at_others(s)


@compiled(inline=True)
def forget(s, row):
    """Nothing was found."""
    for i in range(at.WIDTH):
        s[row + i] = nan


@compiled(inline=True)
def may_be_steepest(s, i, h, dw, bend):
    """Return whether w' may have an extremum, the largest so far, on the way to w' = dw and w'' = bend."""
    dw_0, bend_0 = s[at.DW + i], s[at.JERK + i]
    beyond = h * min(abs(bend_0), abs(bend))
    way = select(s[at.B + i] < 0.0, -1.0, 1.0)  # zeros count alike for belts both ways
    return ((way * bend_0 > 0.0) != (way * bend > 0.0)) & (max(abs(dw_0), abs(dw)) + beyond > s[at.DW_TOP + i])


@compiled
def look_at_others(s):
    """Have lanes looked at whose extremes were not found, or passed the speed of the belt and back."""
    widest_vectors()
    for i in range(at.WIDTH):
        top, slope, b = s[SPEED + i], s[SLOPE + i], s[at.B + i]
        missed = ((s[SEEK_SPEED + i] > 0.0) & (top != top)) | ((s[SEEK_SLOPE + i] > 0.0) & (slope != slope))
        passed = (top == top) & ((top > b) != (s[at.W + i] > b)) & ((s[at.W_NEW + i] > b) == (s[at.W + i] > b))
        s[at.LOOK + i] = max(s[at.LOOK + i], select(missed | passed, 1.0, 0.0))


@compiled
def keep(s):
    """Extend the extremes of lanes whose steps have been committed by those found inside."""
    widest_vectors()
    for i in range(at.WIDTH):
        committed = (s[at.FLAG + i] == at.NOTHING_MET) & (s[at.GOOD + i] > 0.0) & (s[at.BY_SERIES + i] > 0.0)
        top, slope = s[SPEED + i], abs(s[SLOPE + i])
        found = committed & (top == top)
        s[at.AMPLITUDE + i] = max(s[at.AMPLITUDE + i], select(found, abs(top - s[at.B + i]), 0.0))
        s[at.FASTEST + i] = max(s[at.FASTEST + i], select(found, abs(top), 0.0))
        s[at.V_HIGH + i] = max(s[at.V_HIGH + i], select(found, top, -inf))
        s[at.V_LOW + i] = min(s[at.V_LOW + i], select(found, top, inf))
        s[at.DW_TOP + i] = max(s[at.DW_TOP + i], select(committed & (slope == slope), slope, 0.0))
