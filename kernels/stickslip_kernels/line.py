"""Slip along a straight line of friction, in closed form: the mode `fall` of the hysteretic curve.

With q = w - b, v = w' and drag = gamma + slope of the line, q'' + drag q' + q = 0: a linear oscillator, however steep
the line. Both kinds of roots are written so that nothing overflows or cancels.
"""

from math import atan2, cos, exp, expm1, inf, log1p, pi, sin

from .jit import compiled
from .quadrature import gauss

MOST_HALVINGS = 200
NODES, WEIGHTS = gauss(10)  # exact to rounding for the square of a sine over half a turn


@compiled
def motion(q, v, drag, t):
    """q and v after a time t."""
    half = 0.5 * drag
    discriminant = half * half - 1.0
    if discriminant < 0.0:
        omega = (-discriminant) ** 0.5
        decay = exp(-half * t)
        c, s = decay * cos(omega * t), decay * sin(omega * t) / omega
    else:
        root = discriminant**0.5
        fast = half + root if half > 0.0 else half - root  # the rate further from zero; the other is its inverse
        gap = fast - 1.0 / fast
        slow_decay = exp(-t / fast)
        c = 0.5 * (slow_decay + exp(-fast * t))
        s = slow_decay * (-expm1(-gap * t) / gap if gap != 0.0 else t)
    return q * c + (v + half * q) * s, v * c - (q + half * v) * s


@compiled
def turn_time(q, v, drag):
    """When v next vanishes; inf if never again."""
    half = 0.5 * drag
    discriminant = half * half - 1.0
    if discriminant < 0.0:
        omega = (-discriminant) ** 0.5
        phase = atan2(omega * v, q + half * v)
        if phase <= 0.0:  # half a turn on, without rounding by adding pi: near critical damping it is tiny
            phase = atan2(-omega * v, -(q + half * v))
        return (phase if phase > 0.0 else pi) / omega
    root = discriminant**0.5
    fast = half + root if half > 0.0 else half - root
    gap = fast - 1.0 / fast
    if q + v / fast == 0.0:
        return inf
    ratio = v / (q + v / fast)
    if not ratio * gap > -1.0:
        return inf
    t = log1p(ratio * gap) / gap if gap != 0.0 else ratio
    return t if t > 0.0 else inf


@compiled
def level_time(q, v, drag, level, latest):
    """When q, falling all the way to `latest`, reaches `level`, which the caller knows. By safeguarded Halley."""
    low, high, t, q1, v1 = 0.0, latest, 0.0, q, v
    for _ in range(MOST_HALVINGS):
        f = q1 - level
        if f > 0.0:
            low = t
        else:
            high = t
        square, curving = v1 * v1, -0.5 * f * (drag * v1 + q1)  # q'' = -drag v - q
        new = t - f * v1 / (square - curving)
        # Near a turn, where the slope vanishes, the method would find that; false for NaN as well.
        if not (abs(curving) < 0.5 * square and low <= new <= high):
            new = 0.5 * (low + high)
        elif abs(new - t) <= 1e-6 * t:  # what Halley's method leaves is about the cube of its last correction
            return new
        if new == t or high - low <= 1e-16 * high:
            break
        t = new
        q1, v1 = motion(q, v, drag, t)
    return t


@compiled
def distance2(q, v, drag, shift):
    """Squared distance, in the plane (u, u'), from a point at w = b and `shift` below steady sliding on the line."""
    p = v + drag * q + shift
    return p * p + q * q


@compiled
def entry_time(q, v, drag, shift, radius2, latest):
    """When the motion, outside a disc now and inside at `latest`, came into it."""
    outside, inside = 0.0, latest
    for _ in range(MOST_HALVINGS):
        t = 0.5 * (outside + inside)
        q1, v1 = motion(q, v, drag, t)
        if distance2(q1, v1, drag, shift) < radius2:
            inside = t
        else:
            outside = t
        if inside - outside <= 1e-15 * inside:
            break
    return inside


@compiled
def square_integral(q, v, drag, t):
    """Integral of q^2 over the next time t."""
    q1, v1 = motion(q, v, drag, t)
    if abs(drag) > 1e-3:  # q^2 + (v + drag q)^2 loses 2 drag q^2 per time
        return 0.5 * (distance2(q, v, drag, 0.0) - distance2(q1, v1, drag, 0.0)) / drag
    total = 0.0
    for node in range(len(NODES)):
        q1 = motion(q, v, drag, NODES[node] * t)[0]
        total += WEIGHTS[node] * q1 * q1
    return t * total
