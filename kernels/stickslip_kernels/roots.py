"""Events: the ends of a mode inside a step.

A step only says that an event lies inside it; the dense output of the step then tells the time, to the step's own
error. (The root of a cubic polynomial spoils a good step: 3e-4 at rtol 1e-6, measured.)
"""

from math import isnan

import numpy as np

from . import layout as at
from .arithmetic import lowest_bit, nonzero_bits, select, widest_vectors
from .dense import friction_work, horner, speed
from .jit import compiled
from .layout import WIDTH

NO_EVENT, LEVEL_REACHED, TURNED = range(3)


# --- what a step may hold: tested in all lanes, and again where one is looked at ----------------------------------
# Guards are turned by SIDE so that the level is reached from below, and a turning point is a maximum. An extremum
# inside a step is taken to be no further out than the nearer end plus h times the larger slope there.


@compiled(inline=True)
def reaches(s, i, w):
    """Return whether w has reached the level that ends the mode."""
    return s[at.SIDE + i] * w >= s[at.SIDE + i] * s[at.LEVEL + i]


@compiled(inline=True)
def grazes(s, i, h, w, dw):
    """Return whether the slip speed may have reached that level on the way to w, and have turned back."""
    side = s[at.SIDE + i]
    d0, d1 = side * s[at.DW + i], side * dw
    return (d0 > 0.0) & (d1 <= 0.0) & (max(side * s[at.W + i], side * w) + h * max(d0, -d1) >= side * s[at.LEVEL + i])


@compiled(inline=True)
def may_turn(s, i, h, dw):
    """Return whether w' may have vanished on the way to dw, also where it points the same way at both ends."""
    side = s[at.SIDE + i]
    d0, d1, j0, j1 = side * s[at.DW + i], side * dw, side * s[at.JERK + i], side * s[at.JERK_NEW + i]
    return (d1 <= 0.0) | ((j0 < 0.0) & (j1 > 0.0) & (min(d0, d1) - h * max(-j0, j1) <= 0.0))


# --- when -------------------------------------------------------------------------------------------------------------


@compiled(inline=True)
def end_motion(s, i):
    """w, w' and w'' at the end of the step of lane i, as `crossing` wants them."""
    return s[at.W_NEW + i], s[at.DW_NEW + i], s[at.JERK_NEW + i], 0.0


@compiled
def turn_time(s, i):
    """When w' of lane i first vanishes within its step, w moving towards LEVEL before; -1 if it does not."""
    h, at_end = s[at.TAKEN + i], end_motion(s, i)
    if s[at.SIDE + i] * at_end[1] <= 0.0:
        if s[at.SOUGHT + i] == at.OF_SPEED and not isnan(s[at.TOP_TIME + i]):
            return s[at.TOP_TIME + i]
        return extreme_speed(s, i, h, at_end, TO_ROUNDING)[0]
    # Towards the level at both ends: the slope may still turn between them.
    bottom = crossing(s, i, 2, 0.0, h, at_end, TO_ROUNDING)
    at_bottom = speed(s, i, bottom)
    return -1.0 if s[at.SIDE + i] * at_bottom[1] > 0.0 else crossing(s, i, 1, 0.0, bottom, at_bottom, TO_ROUNDING)


# --- when a derivative of w passes a level, or its speed an extremum --------------------------------------------------


MOST_TRIES = 60
# Corrections at which a search ends, relative to the time found, since the zero at the start that is passed over may be
# close: Halley's method leaves about the cube of the last one, Newton's (order 2) the square.
TO_ROUNDING = 1e-5  # for the time of an event
FOR_A_VALUE = 1e-2  # for the value at an extremum, which is flat there
NEAR, NOTHING = 1e-3, 2e-15  # the largest correction by the reverted series, and what the next term may be

STRAIGHT = 1e-3  # f f''/(2 f'^2) up to which that holds: two crossings close to each other are told apart


@compiled(inline=True)
def chosen(order, level, motion):
    """The derivative of w of this order less `level`, its slope and, for Halley's method, its second derivative."""
    w, dw, jerk, snap = motion
    if order == 0:
        return w - level, dw, jerk
    if order == 1:
        return dw - level, jerk, snap
    return jerk - level, snap, 0.0


@compiled(inline=True)
def at_start(s, i, order):
    """The derivative of w of this order (0, 1, 2) at the start of the step."""
    return s[at.SERIES + order * at.WIDTH + i] * (2.0 if order == 2 else 1.0)


@compiled(inline=True)
def sign_before(s, i, order, level):
    """Sign of the derivative of w of this order, less `level`, just after the start of the step.

    A zero the step starts on, as each slip after a stick phase does, is passed over: its slope tells the sign.
    """
    start = at_start(s, i, order) - level
    for n in range(order + 1, order + 3):
        if start == 0.0:
            start = s[at.SERIES + n * at.WIDTH + i]
    return 1.0 if start > 0.0 else -1.0 if start < 0.0 else 0.0


@compiled
def crossing(s, i, order, level, end, at_end, resolved):
    """The time in (0, end] at which the derivative of w of this order (0, 1, 2) passes `level`.

    at_end : w and its first three derivatives at `end`; the third may be 0. By Halley's method inside a shrinking
    bracket, from the end where that is near the crossing, else from the secant. `end` where there is no change of sign.
    """
    before, f_start = sign_before(s, i, order, level), at_start(s, i, order) - level
    f, slope, bend = chosen(order, level, at_end)
    if not f * before < 0.0:
        return end
    low, high, t = 0.0, end, end
    secant = end * max(f_start / (f_start - f), 0.1)
    for n in range(MOST_TRIES):
        square, curving = slope * slope, 0.5 * f * bend
        new = t - f * slope / (square - curving)
        near = 0.1 if n == 0 else 0.5  # the end of the step may be far from the crossing
        if abs(curving) < near * square and low <= new <= high:  # false where the slope vanishes, and for NaN
            if abs(new - t) <= resolved * new and abs(curving) <= STRAIGHT * square:
                return new
            t = new
        else:
            t = secant if n == 0 else 0.5 * (low + high)
        f, slope, bend = chosen(order, level, speed(s, i, t))
        if f * before > 0.0:
            low = t
        else:
            high = t
    return t


@compiled(inline=True)
def reverted(level, w, dw, a, b, end):
    """Return how far `level` is, by the series w, dw, a, b reverted, and whether that is exact to rounding."""
    per_dw = 1.0 / dw
    v = (level - w) * per_dw
    r = a * per_dw * v
    d = v * (1.0 - r + (2.0 * r * r - b * per_dw * v * v))
    return d, (abs(v) <= NEAR * end) & (abs(v * r * r * r) <= NOTHING * end)


@compiled(inline=True)
def integrals_after(d, once, twice, w, dw, a, b):
    """Integral and double integral of w, d later, where its series has the coefficients w, dw, a, b."""
    twice += d * (once + d * (0.5 * w + d * (dw * (1.0 / 6.0) + d * a * (1.0 / 12.0))))
    once += d * (w + d * (0.5 * dw + d * (a * (1.0 / 3.0) + d * b * 0.25)))
    return once, twice


@compiled(inline=True)
def arrival(s, i, level, end, at_end):
    """When w passes `level`, `end` at the latest; by how much y rises till then; the work.

    at_end : w and its first three derivatives at `end`; the third may be 0.
    """
    t, rise, w, fallen = passage(s, i, level, end, at_end)
    return t, rise, friction_work(s, i, t, rise, w, fallen)


@compiled(inline=True)
def passage(s, i, level, end, at_end):
    """`arrival`, with w there and its double integral in place of the work.

    As a rule all lanes have been asked already (`find_crossings`).
    """
    if s[at.CROSSES + i] > 0.0 and s[at.CROSS_LEVEL + i] == level and s[at.CROSS_TIME + i] <= end:
        return s[at.CROSS_TIME + i], s[at.CROSS_RISE + i], level, s[at.CROSS_FALLEN + i]
    return passage_in_lane(s, i, level, end, at_end)


@compiled
def passage_in_lane(s, i, level, end, at_end):
    """`passage`, searched for in this lane."""
    t = crossing(s, i, 0, level, end, at_end, TO_ROUNDING)
    w, _, _, _, once, twice, _ = horner(s, i, t)
    return t, t * (s[at.B + i] + 0.5 * t * s[at.ALPHA + i]) - once, w, twice


@compiled
def extreme_speed(s, i, end, at_end, resolved):
    """When, before `end`, w' vanishes, and w there. at_end : as for `arrival`; resolved : as for `crossing`."""
    t = crossing(s, i, 1, 0.0, end, at_end, resolved)
    return t, speed(s, i, t)[0]


# --- when w passes a level inside the step, in many lanes at once: as `passage`, but branch-free ----------------------
# The levels are those that flagged lanes will ask for: where the mode ends, else the speed of the belt, where u turns.
# Two passes over the series after a first guess are enough for nearly every step; where they are not, CROSSES becomes 0
# and the scalar search does it. Lanes are brought together into lanes GATHERED and up: loops are short and full-width.


GROUP = 8  # lanes brought together at once


@compiled(inline=True)
def gather(s, lanes, rows):
    """Copy the step and these rows of the first GROUP of some lanes; the lanes left. Bit i of `lanes`: lane i."""
    for k in range(GROUP):
        if lanes == 0:
            break
        i, to = np.uint32(lowest_bit(lanes)), np.uint32(at.GATHERED + k)
        lanes &= lanes - 1
        for n in range(at.ORDER + 1):
            s[at.SERIES + n * at.WIDTH + to] = s[at.SERIES + n * at.WIDTH + i]
        for row in rows:
            s[row + to] = s[row + i]
    return lanes


@compiled(inline=True)
def scatter(s, lanes, rows):
    """Copy these rows back."""
    for k in range(GROUP):
        if lanes == 0:
            break
        i, of = np.uint32(lowest_bit(lanes)), np.uint32(at.GATHERED + k)
        lanes &= lanes - 1
        for row in rows:
            s[row + i] = s[row + of]


NEEDED = (
    at.W, at.W_NEW, at.DW, at.DW_NEW, at.TAKEN, at.B, at.ALPHA, at.LEVEL, at.SIDE, at.CROSSES,
)  # fmt: skip
FOUND = (at.CROSSES, at.CROSS_LEVEL, at.CROSS_TIME, at.CROSS_RISE, at.CROSS_FALLEN)


@compiled
def find_crossings(s):
    """Rows CROSS_TIME, CROSS_RISE and CROSS_FALLEN of the lanes with CROSSES."""
    lanes = nonzero_bits(s, at.CROSSES, WIDTH)
    while lanes != 0:
        left = gather(s, lanes, NEEDED)
        guess_crossings(s)
        close_in(s)
        integrate_to_crossings(s)
        scatter(s, lanes, FOUND)
        lanes = left


@compiled(inline=True)
def guess_crossings(s):
    """Hermite's inverse cubic between the ends of the step, else Newton's method from its end; then one by Halley."""
    widest_vectors()
    for i in range(at.GATHERED, at.GATHERED + GROUP):
        w0, w1, slope0, slope1, end = s[at.W + i], s[at.W_NEW + i], s[at.DW + i], s[at.DW_NEW + i], s[at.TAKEN + i]
        reached = reaches(s, i, w1)
        level = select(reached, s[at.LEVEL + i], s[at.B + i])
        change = w1 - w0
        per_all = 1.0 / (change * slope0 * slope1)
        per_slope0, per_slope1 = change * slope1 * per_all, change * slope0 * per_all
        part = (level - w0) * slope0 * slope1 * per_all
        rest = 1.0 - part
        bow = rest * per_slope0 - part * per_slope1
        cubic = part * part * (3.0 - 2.0 * part) * end + change * part * rest * bow
        within = (slope0 * slope1 > 0.0) & (cubic > 0.0) & (cubic <= end)
        t = select(within, cubic, end + (level - w1) * per_slope1)
        w, dw, a = horner(s, i, t)[:3]
        off = level - w
        s[at.CROSS_LEVEL + i], s[at.GUESS + i] = level, t + off * dw / (dw * dw + off * a)


@compiled(inline=True)
def close_in(s):
    """The series about the guess, and how far the crossing is from there."""
    widest_vectors()
    for i in range(at.GATHERED, at.GATHERED + GROUP):
        t, end, level = s[at.GUESS + i], s[at.TAKEN + i], s[at.CROSS_LEVEL + i]
        w, dw, a, b = horner(s, i, t)[:4]
        d, settled = reverted(level, w, dw, a, b, end)
        towards = (s[at.W_NEW + i] - s[at.W + i]) * dw > 0.0
        found = settled & (t > 0.0) & (t + d > 0.0) & (t + d <= end) & towards
        s[at.CROSS_TIME + i] = t + d
        s[at.CROSSES + i] = min(s[at.CROSSES + i], select(found, 1.0, 0.0))
        s[at.GUESS_W + i], s[at.GUESS_DW + i], s[at.GUESS_A + i], s[at.GUESS_B + i] = w, dw, a, b


@compiled(inline=True)
def integrate_to_crossings(s):
    """Return what y rises by, and the double integral of w, up to the crossing."""
    widest_vectors()
    for i in range(at.GATHERED, at.GATHERED + GROUP):
        t, end = s[at.GUESS + i], s[at.CROSS_TIME + i]
        once, twice = horner(s, i, t)[4:6]
        w, dw, a, b = s[at.GUESS_W + i], s[at.GUESS_DW + i], s[at.GUESS_A + i], s[at.GUESS_B + i]
        once, twice = integrals_after(end - t, once, twice, w, dw, a, b)
        s[at.CROSS_RISE + i] = end * (s[at.B + i] + 0.5 * end * s[at.ALPHA + i]) - once
        s[at.CROSS_FALLEN + i] = twice
