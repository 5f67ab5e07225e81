"""Slip on the curve: w' and w'', one step of SciPy's DOP853 pair, how long it may be, when something happens in it."""

from math import inf, sqrt

from scipy.integrate._ivp import dop853_coefficients as dop853

from .curve import room, slope_of_curve, weakened
from .jit import compiled
from .layout import A1, A3, GAMMA

STAGES, WEIGHTS, E3, E5 = dop853.A[:12, :12].copy(), dop853.B.copy(), dop853.E3.copy(), dop853.E5.copy()
LONGEST_STEP = 0.25


@compiled
def rate(c, p, w):
    """w'."""
    return p - c[GAMMA] * w + weakened(c, w)


@compiled
def bend(c, belt, p, w):
    """w''."""
    return belt - w - (c[GAMMA] + slope_of_curve(c, w)) * rate(c, p, w)


@compiled
def step(c, belt, p, w, heat, h, k):
    """A step of DOP853: p, w, heat after h, and the error of p and w in units of their own size and change."""
    mu0 = c[A1] + c[A3]
    for i in range(12):
        dp, dw, dq = 0.0, 0.0, 0.0
        for j in range(i):
            a = STAGES[i, j]
            dp += a * k[j, 0]
            dw += a * k[j, 1]
        pi_, wi = p + h * dp, w + h * dw
        d = weakened(c, wi)
        k[i, 0], k[i, 1], k[i, 2] = belt - wi, pi_ - c[GAMMA] * wi + d, (mu0 - d) * wi
    dp, dw, dq = 0.0, 0.0, 0.0
    for i in range(12):
        b = WEIGHTS[i]
        dp, dw, dq = dp + b * k[i, 0], dw + b * k[i, 1], dq + b * k[i, 2]
    p1, w1 = p + h * dp, w + h * dw
    k[12, 0], k[12, 1] = belt - w1, rate(c, p1, w1)
    five, three = 0.0, 0.0
    for component in range(2):
        e5, e3 = 0.0, 0.0
        for i in range(13):
            e5 += E5[i] * k[i, component]
            e3 += E3[i] * k[i, component]
        size = max(abs(p), abs(p1)) if component == 0 else max(abs(w), abs(w1))
        size = max(size, 1e-300)
        five += (e5 / size) ** 2
        three += (e3 / size) ** 2
    if not (five < inf and three < inf):
        return p1, w1, heat + h * dq, inf
    error = 0.0 if five == 0.0 else abs(h) * five / sqrt((five + 0.01 * three) * 2.0)
    return p1, w1, heat + h * dq, error


@compiled
def longest(c, belt, p, w, share):
    """The longest step that keeps w inside its room and follows the fastest rate of the curve."""
    allowed = room(c, w, share)
    speeding, bending = abs(rate(c, p, w)), abs(bend(c, belt, p, w))
    h = min(LONGEST_STEP, 2.0 / (1e-300 + abs(c[GAMMA] + slope_of_curve(c, w))))
    if allowed < inf and speeding + bending > 0.0:
        h = min(h, 2.0 * allowed / (speeding + sqrt(speeding**2 + 2.0 * bending * allowed)))
    return h


@compiled
def quantity(c, belt, p, w, kind, level):
    """What an event waits for: 0 w - level, 1 w', 2 w''."""
    if kind == 0:
        return w - level
    return rate(c, p, w) if kind == 1 else bend(c, belt, p, w)


@compiled
def locate(c, belt, p, w, h, kind, level, k):
    """When within the next h the quantity changes its sign: regula falsi (Illinois) on steps from here, bisection."""
    left, at_left = 0.0, quantity(c, belt, p, w, kind, level)
    end = step(c, belt, p, w, 0.0, h, k)
    right, at_right = h, quantity(c, belt, end[0], end[1], kind, level)
    side = 0
    for n in range(200):
        t = (left * at_right - right * at_left) / (at_right - at_left)
        if n > 20 or not (left < t < right):
            t = 0.5 * (left + right)
        if not (left < t < right) or right - left <= 4e-16 * h:
            break
        there = step(c, belt, p, w, 0.0, t, k)
        value = quantity(c, belt, there[0], there[1], kind, level)
        if value == 0.0:
            return t
        if (value > 0.0) == (at_right > 0.0):
            right, at_right = t, value
            if side == 1:
                at_left *= 0.5
            side = 1
        else:
            left, at_left = t, value
            if side == -1:
                at_right *= 0.5
            side = -1
    return right
