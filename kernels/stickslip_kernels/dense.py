"""Dense output: the motion of one lane inside its step, and the times at which something happens there.

Rows SERIES hold the coefficients of w over the step: the Taylor series, exact as the step itself, or the Hermite
polynomial of a Runge-Kutta step (`lanes.interpolate`). y and the friction work follow by integration.
"""

from .equations import slope_in_lane
from .jit import compiled
from .layout import ALPHA, B, G, ORDER, SERIES, SIDE, WIDTH, Y
from .taylor import conservative_work, square_integral

MOST_TRIES = 60
NEAR = 1e-3  # of the step: a root this near is found to rounding from the value and three derivatives
# Corrections at which a search ends, relative to the step: Halley's method leaves about the cube of the last one,
# Newton's (order 2) the square.
TO_ROUNDING = 1e-5  # for the time of an event
FOR_A_VALUE = 1e-2  # for the value at an extremum, which is flat there
FOR_A_VALUE_BY_NEWTON = 1e-3


@compiled
def speed(s, i, t):
    """w, w', w'' and w''' of lane i at t after the start of its step."""
    w, dw, half_jerk, sixth_snap = s[SERIES + ORDER * WIDTH + i], 0.0, 0.0, 0.0
    for j in range(ORDER):
        sixth_snap = sixth_snap * t + half_jerk
        half_jerk = half_jerk * t + dw
        dw = dw * t + w
        w = w * t + s[SERIES + (ORDER - 1 - j) * WIDTH + i]
    return w, dw, 2.0 * half_jerk, 6.0 * sixth_snap


@compiled(inline=True)
def motion(s, i, t):
    """Coefficients 0 to 3 of the series of w about t after the start of the step, the integral and double integral of w
    from the start to t. All in one pass: each sum waits for itself only.
    """
    w, dw, half_jerk, sixth_snap = s[SERIES + ORDER * WIDTH + i], 0.0, 0.0, 0.0
    once, twice = w, w
    for j in range(ORDER):
        n = ORDER - 1 - j
        c = s[SERIES + n * WIDTH + i]
        sixth_snap = sixth_snap * t + half_jerk
        half_jerk = half_jerk * t + dw
        dw = dw * t + w
        w = w * t + c
        once = once * (t * ((n + 1) / (n + 2))) + c
        twice = twice * (t * ((n + 1) / (n + 3))) + c
    return w, dw, half_jerk, sixth_snap, t * once, 0.5 * t * t * twice


@compiled(inline=True)
def load_and_speed(s, i, t):
    """y and w of lane i at t after the start of its step."""
    w = s[SERIES + ORDER * WIDTH + i]
    once = w
    for j in range(ORDER):
        n = ORDER - 1 - j
        c = s[SERIES + n * WIDTH + i]
        w = w * t + c
        once = once * (t * ((n + 1) / (n + 2))) + c
    return s[Y + i] + t * (s[B + i] + 0.5 * t * s[ALPHA + i] - once), w


@compiled(inline=True)
def friction_work(s, i, t, rise, w, fallen):
    """Friction work until t after the start of the step, in the words of `conservative_work`."""
    work = conservative_work(s, i, t, rise, w, fallen)
    if s[G + i] != 0.0:
        work -= s[G + i] * square_integral(s, i, t)
    return work


@compiled
def rise_and_work(s, i, t):
    """w, by how much y rises, and the friction work, until t after the start of the step of lane i."""
    w = s[SERIES + ORDER * WIDTH + i]
    once, twice = w, w
    for j in range(ORDER):
        n = ORDER - 1 - j
        c = s[SERIES + n * WIDTH + i]
        w = w * t + c
        once = once * (t * ((n + 1) / (n + 2))) + c
        twice = twice * (t * ((n + 1) / (n + 3))) + c
    rise = t * (s[B + i] + 0.5 * t * s[ALPHA + i] - once)
    return w, rise, friction_work(s, i, t, rise, w, 0.5 * t * t * twice)


@compiled(inline=True)
def state_at(law, s, i, t):
    """y, w, w' and the friction work at t after the start of the step of lane i."""
    w, rise, work = rise_and_work(s, i, t)
    y = s[Y + i] + rise
    return y, w, slope_in_lane(law, s, i, y, w), work


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
    return s[SERIES + order * WIDTH + i] * (2.0 if order == 2 else 1.0)


@compiled(inline=True)
def sign_before(s, i, order, level):
    """Sign of the derivative of w of this order, less `level`, just after the start of the step.

    A zero the step starts on, as each slip from rest does, is passed over: its slope tells the sign.
    """
    start = at_start(s, i, order) - level
    for n in range(order + 1, order + 3):
        if start == 0.0:
            start = s[SERIES + n * WIDTH + i]
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
            if abs(new - t) <= resolved * end:
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
def arrival(s, i, level, end, at_end):
    """When w passes `level` towards its side of it, `end` at the latest; by how much y rises till then; the work.

    at_end : as for `crossing`, which is asked where the end of the step is no good guide. Else the series of w about a
    point near the root is reverted, which leaves the fourth power of the distance.
    """
    w, dw, jerk, _ = at_end
    v = (level - w) / dw
    t = end + v / (1.0 + 0.5 * jerk / dw * v)
    for _ in range(3):
        if not 0.0 < t <= end:  # true for NaN
            break
        w, dw, a, b, once, twice = motion(s, i, t)
        v, r = (level - w) / dw, a / dw
        d = v * (1.0 - v * (r - v * (2.0 * r * r - b / dw)))
        if abs(v) <= NEAR * end and t + d <= end and s[SIDE + i] * dw > 0.0:
            twice += d * (once + d * (0.5 * w + d * (dw * (1.0 / 6.0) + d * a * (1.0 / 12.0))))
            once += d * (w + d * (0.5 * dw + d * (a * (1.0 / 3.0) + d * b * 0.25)))
            t += d
            rise = t * (s[B + i] + 0.5 * t * s[ALPHA + i]) - once
            return t, rise, friction_work(s, i, t, rise, level, twice)
        t += d
    t = crossing(s, i, 0, level, end, at_end, TO_ROUNDING)
    _, rise, work = rise_and_work(s, i, t)
    return t, rise, work
