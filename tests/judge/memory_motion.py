"""Contacts with memory, in kernel units: their equations, written down once more, with their Jacobians.

Rate and state: f = xi less that of steady sliding, phi = ln(w/b), psi = ln(theta b/D). Bristles: xi, w and sigma_0 z;
the sign of w is held, and steps end where w passes zero.
"""

from math import cos, exp, pi, sin

from .curve import slope_of_curve, weakened
from .jit import compiled
from .layout import A1, A2, A3, BELT, GAMMA

AGEING, SLIP, BRISTLES = range(3)
# rows of a cell after those of the curve, which are where `curve.py` looks for them

KIND, A, B, D, S_0, S_1, S_1_RATE, ELASTIC, SIGN, GROWTH, TURNS, LONG, START_0, START_1, START_2 = range(8, 23)
ROWS = 23


@compiled
def curve_level(p, over):
    """g and its slope: the curve without the part that rises with the speed."""
    w = max(over, 0.0)
    return p[A1] + p[A3] - weakened(p, w) - p[A2] * w, slope_of_curve(p, w) - p[A2]


@compiled
def yielding(part, q):
    """alpha(q) q and its slope."""
    if part == 0.0:
        return q, 1.0
    if q <= part:
        return 0.0, 0.0
    if q >= 1.0:
        return q, 1.0
    angle = pi * ((q - part) / (1.0 - part) - 0.5)
    alpha = 0.5 + 0.5 * sin(angle)
    return alpha * q, alpha + q * 0.5 * pi / (1.0 - part) * cos(angle)


@compiled
def friction(p, y):
    """Friction coefficient of a state."""
    if p[KIND] != BRISTLES:  # less that of steady sliding
        return p[A] * y[1] + p[B] * y[2]
    g, _ = curve_level(p, p[SIGN] * y[1])
    give = y[1] * (1.0 - yielding(p[ELASTIC], p[SIGN] * y[2] / g)[0])
    return y[2] + p[S_1] * exp(-((p[S_1_RATE] * y[1]) ** 2)) * give + p[A2] * y[1]


@compiled
def slip_speed(p, y):
    return y[1] if p[KIND] == BRISTLES else p[BELT] * exp(y[1])


@compiled
def acceleration(p, y):
    """w'."""
    return y[0] + p[GAMMA] * (p[BELT] - slip_speed(p, y)) - friction(p, y)


@compiled
def rates(p, y, out):
    """y'."""
    w = slip_speed(p, y)
    out[0] = p[BELT] - w
    if p[KIND] == BRISTLES:
        g, _ = curve_level(p, p[SIGN] * w)
        out[1] = acceleration(p, y)
        out[2] = p[S_0] * w * (1.0 - yielding(p[ELASTIC], p[SIGN] * y[2] / g)[0])
        return
    out[1] = acceleration(p, y) / w
    per_time, e = p[BELT] / p[D], exp(y[1])
    out[2] = per_time * (exp(-y[2]) - e) if p[KIND] == AGEING else -per_time * e * (y[1] + y[2])


@compiled
def jacobian(p, y, j):
    """dy'/dy."""
    w = slip_speed(p, y)
    j[:] = 0.0
    if p[KIND] == BRISTLES:
        sign = p[SIGN]
        g, slope = curve_level(p, sign * w)
        q = sign * y[2] / g
        lost, lost_by_q = yielding(p[ELASTIC], q)
        give, by_w, by_f = (
            w * (1.0 - lost),
            1.0 - lost + w * lost_by_q * q * sign * slope / g,
            -w * lost_by_q * sign / g,
        )
        damping = p[S_1] * exp(-((p[S_1_RATE] * w) ** 2))
        j[0, 1], j[1, 0] = -1.0, 1.0
        j[1, 1] = -p[GAMMA] - p[A2] - damping * by_w + 2.0 * p[S_1_RATE] ** 2 * w * damping * give
        j[1, 2] = -1.0 - damping * by_f
        j[2, 1], j[2, 2] = p[S_0] * by_w, p[S_0] * by_f
        return
    force, per_time, e = acceleration(p, y), p[BELT] / p[D], exp(y[1])
    j[0, 1] = -w
    j[1, 0], j[1, 1], j[1, 2] = 1.0 / w, -(p[A] + force) / w - p[GAMMA], -p[B] / w
    if p[KIND] == AGEING:
        j[2, 1], j[2, 2] = -per_time * e, -per_time * exp(-y[2])
    else:
        j[2, 1], j[2, 2] = -per_time * e * (1.0 + y[1] + y[2]), -per_time * e
