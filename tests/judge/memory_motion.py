"""Contacts with memory, in kernel units: their equations, written down once more, with their Jacobians.

Rate and state: f = xi less that of steady sliding, phi = ln(w/b), psi = ln(theta b/D). CUT_1 and CUT_2 are b over the
cut-off speeds: w is 1/(1/w + 1/v_1) in friction, theta is theta + D/v_2. Where REST is not 0, which has none, friction
is a asinh(e^c w/(2 b)), c = REST + b psi/a, and phi stands for mu/a less what it is at w = b. Bristles: xi, w and
sigma_0 z; the sign of w is held, and steps end where w passes zero.
"""

from math import asinh, cos, exp, log, pi, sin

from .curve import slope_of_curve, weakened
from .jit import compiled
from .layout import A1, A2, A3, BELT, GAMMA

AGEING, SLIP, BRISTLES = range(3)
# rows of a cell after those of the curve, which are where `curve.py` looks for them

KIND, A, B, D, S_0, S_1, S_1_RATE, ELASTIC, SIGN, GROWTH, TURNS, LONG, START_0, START_1, START_2, REST, CUT_1, CUT_2 = (
    range(8, 26)
)
ROWS = 26


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
    if p[REST] != 0.0:
        return p[A] * (y[1] + at_belt(p, y[2])[1] - at_belt(p, 0.0)[1])
    if p[KIND] != BRISTLES:  # less that of steady sliding
        at_once, later = (1.0 + p[CUT_1]) / (1.0 + p[CUT_1] * exp(y[1])), (exp(y[2]) + p[CUT_2]) / (1.0 + p[CUT_2])
        return p[A] * (y[1] + log(at_once)) + p[B] * log(later)
    g, _ = curve_level(p, p[SIGN] * y[1])
    give = y[1] * (1.0 - yielding(p[ELASTIC], p[SIGN] * y[2] / g)[0])
    return y[2] + p[S_1] * exp(-((p[S_1_RATE] * y[1]) ** 2)) * give + p[A2] * y[1]


@compiled
def at_belt(p, psi):
    """c, and mu/a at w = b."""
    c = p[REST] + p[B] / p[A] * psi
    return c, (c if c > 40.0 else asinh(0.5 * exp(c)))


@compiled
def both_ways(p, y):
    """w and its derivatives by phi and psi; those of the first of these; tanh of mu/a at w = b."""
    c, chi = at_belt(p, y[2])
    r, half = p[B] / p[A], 0.5 * exp(min(c, 40.0))
    q = half / (1.0 + half * half) ** 0.5
    there, back = exp(max(y[1] + chi - c, -650.0)), exp(max(-y[1] - chi - c, -650.0))
    w, s = p[BELT] * (there - back), p[BELT] * (there + back)
    return w, s, r * (q * s - w), w, r * (q * w - s), q


@compiled
def slip_speed(p, y):
    if p[REST] != 0.0:
        return both_ways(p, y)[0]
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
    out[1] = acceleration(p, y) / w if p[REST] == 0.0 else 0.0
    per_time, e = p[BELT] / p[D], exp(y[1]) if p[REST] == 0.0 else max(abs(w) / p[BELT], 1e-290)
    if p[REST] != 0.0:
        _, s, _, _, _, q = both_ways(p, y)
        z, _, _ = following(p, e, y[2])
        out[1], out[2] = (acceleration(p, y) + p[B] / p[A] * z * w) / s - p[B] / p[A] * q * z, z
        return
    out[2] = per_time * (exp(-y[2]) - e) if p[KIND] == AGEING else -per_time * e * (y[1] + y[2])


@compiled
def following(p, e, psi):
    """psi' and its derivatives by e = |w|/b and by psi."""
    per_time = p[BELT] / p[D]
    if p[KIND] == AGEING:
        return per_time * (exp(-psi) - e), -per_time, -per_time * exp(-psi)
    return -per_time * e * (log(e) + psi), -per_time * (log(e) + psi + 1.0), -per_time * e


@compiled
def jacobian_both_ways(p, y, j):
    r, a, gamma = p[B] / p[A], p[A], p[GAMMA]
    w, s, w_psi, s_phi, s_psi, q = both_ways(p, y)
    z, z_e, z_psi = following(p, max(abs(w) / p[BELT], 1e-290), y[2])
    sign = 1.0 if w > 0.0 else -1.0 if w < 0.0 else 0.0
    z_phi, z_psi = z_e * sign * s / p[BELT], z_psi + z_e * sign * w_psi / p[BELT]
    pull = acceleration(p, y) + r * z * w
    j[0, 1], j[0, 2] = -s, -w_psi
    j[1, 0] = 1.0 / s
    j[1, 1] = (-gamma * s - a + r * (z_phi * w + z * s)) / s - pull / s * s_phi / s - r * q * z_phi
    by_psi = (-gamma * w_psi - a * r * q + r * (z_psi * w + z * w_psi)) / s
    j[1, 2] = by_psi - pull / s * s_psi / s - r * (q * (1.0 - q * q) * r * z + q * z_psi)
    j[2, 1], j[2, 2] = z_phi, z_psi


@compiled
def jacobian(p, y, j):
    """dy'/dy."""
    w = slip_speed(p, y)
    j[:] = 0.0
    if p[REST] != 0.0:
        jacobian_both_ways(p, y, j)
        return
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
    a, b = p[A] / (1.0 + p[CUT_1] * e), p[B] / (1.0 + p[CUT_2] * exp(-y[2]))
    j[1, 0], j[1, 1], j[1, 2] = 1.0 / w, -(a + force) / w - p[GAMMA], -b / w
    if p[KIND] == AGEING:
        j[2, 1], j[2, 2] = -per_time * e, -per_time * exp(-y[2])
    else:
        j[2, 1], j[2, 2] = -per_time * e * (1.0 + y[1] + y[2]), -per_time * e
