"""Roots: when an event happens inside the step of one lane.

`crossing` finds any root, inside a bracket, in as many passes over the series as it takes. The others are for what
nearly every step is like, and need one pass or two: a first guess from what is known of both ends, then the series
about that guess reverted; where that does not settle they ask `crossing`.
"""

from . import layout as at
from .dense import friction_work, horner, speed
from .jit import compiled

MOST_TRIES = 60
# Corrections at which a search ends, relative to the time found, since the zero at the start that is passed over may be
# close: Halley's method leaves about the cube of the last one, Newton's (order 2) the square.
TO_ROUNDING = 1e-5  # for the time of an event
FOR_A_VALUE = 1e-2  # for the value at an extremum, which is flat there
NEAR, NOTHING = 1e-3, 2e-15  # the largest correction by the reverted series, and what the next term may be
GUESSES = 3
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
def inverse_cubic(f0, slope0, f1, slope1, end):
    """Return where f vanishes, f0 and f1 being its values and slopes at 0 and `end`: Hermite's cubic of t over f.

    Outside (0, end], or NaN, where f is not monotone between them.
    """
    change = f1 - f0
    part = -f0 / change
    rest = 1.0 - part
    t = part * part * (3.0 - 2.0 * part) * end + change * part * rest * (rest / slope0 - part / slope1)
    return t if slope0 * slope1 > 0.0 else -1.0


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
def arrival(s, i, level, side, end, at_end):
    """When w passes `level` towards `side` (+1, -1), `end` at the latest; by how much y rises till then; the work.

    at_end : w and its first three derivatives at `end`; the third may be 0.
    """
    t, rise, w, fallen = passage(s, i, level, side, end, at_end)
    return t, rise, friction_work(s, i, t, rise, w, fallen)


@compiled(inline=True)
def passage(s, i, level, side, end, at_end):
    """`arrival`, with w there and its double integral in place of the work.

    As a rule all lanes have been asked already (`crossings.py`).
    """
    if s[at.CROSSES + i] > 0.0 and s[at.CROSS_LEVEL + i] == level and s[at.CROSS_TIME + i] <= end:
        return s[at.CROSS_TIME + i], s[at.CROSS_RISE + i], level, s[at.CROSS_FALLEN + i]
    return passage_in_lane(s, i, level, side, end, at_end)


@compiled
def passage_in_lane(s, i, level, side, end, at_end):
    """`passage`, searched for in this lane."""
    w, dw, jerk, _ = at_end
    t = inverse_cubic(s[at.W + i] - level, s[at.DW + i], w - level, dw, end)
    if not 0.0 < t <= end:  # true for NaN: as far from the end as Halley's method goes
        v = (level - w) / dw
        t = end + v / (1.0 + 0.5 * jerk / dw * v)
    for _ in range(GUESSES):
        if not 0.0 < t <= end:
            break
        w, dw, a, b, once, twice, _ = horner(s, i, t)
        d, settled = reverted(level, w, dw, a, b, end)
        if settled and 0.0 < t + d <= end and side * dw > 0.0:
            once, twice = integrals_after(d, once, twice, w, dw, a, b)
            t += d
            rise = t * (s[at.B + i] + 0.5 * t * s[at.ALPHA + i]) - once
            return t, rise, level, twice
        t += d
    t = crossing(s, i, 0, level, end, at_end, TO_ROUNDING)
    w, _, _, _, once, twice, _ = horner(s, i, t)
    return t, t * (s[at.B + i] + 0.5 * t * s[at.ALPHA + i]) - once, w, twice


@compiled
def extreme_speed(s, i, end, at_end, resolved):
    """When, before `end`, w' vanishes, and w there. at_end : as for `arrival`; resolved : as for `crossing`."""
    t = inverse_cubic(s[at.DW + i], s[at.JERK + i], at_end[1], at_end[2], end)
    for _ in range(GUESSES):
        if not 0.0 < t <= end:
            break
        w, dw, jerk, snap = speed(s, i, t)
        v = -dw / jerk
        d = v * (1.0 - 0.5 * v * snap / jerk)
        if abs(v) <= resolved * end and 0.0 < t + d <= end:
            return t + d, w + d * (dw + d * (0.5 * jerk + d * snap * (1.0 / 6.0)))
        t += d
    t = crossing(s, i, 1, 0.0, end, at_end, resolved)
    return t, speed(s, i, t)[0]
