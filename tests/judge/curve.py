"""The friction curve mu(w) = a1 + a2 w + a3 shape(w/a4), and the scale on which it changes."""

from math import exp, expm1, inf

from .jit import compiled
from .layout import A2, A3, A4, DELTA, LAW

FLAT = 40.0  # e^-40 of the weakening is left there


@compiled
def weakened(c, w):
    """mu(0) - mu(w)."""
    z, delta, law = w / c[A4], c[DELTA], c[LAW]
    if law == 0:
        lost = -expm1(-z)
    elif law == 1:
        lost = -expm1(-(abs(z) ** delta))
    elif law == 2:
        lost = z / (1.0 + z)
    else:
        lost = 1.5 * z - 0.5 * z**3
    return c[A3] * lost - c[A2] * w


@compiled
def slope_of_curve(c, w):
    """mu'(w)."""
    z, delta, law = w / c[A4], c[DELTA], c[LAW]
    if law == 0:
        slope = -exp(-z)
    elif law == 1:
        slope = -delta * abs(z) ** (delta - 1.0) * exp(-(abs(z) ** delta)) * (1.0 if z >= 0.0 else -1.0)
    elif law == 2:
        slope = -1.0 / (1.0 + z) ** 2
    else:
        slope = 1.5 * z * z - 1.5
    return c[A2] + c[A3] / c[A4] * slope


@compiled
def room(c, w, share):
    """By how much w may change in a step that starts at w."""
    if c[A3] == 0.0:
        return inf
    z, law = w / c[A4], c[LAW]
    if law >= 2:
        return share * c[A4] * (1.0 + z)
    width = 1.0 if law == 0 else 1.0 / c[DELTA]
    end = FLAT**width
    return c[A4] * (share * width + 0.5 * max(0.0, z - end))


@compiled
def speed_of_minimum(c):
    """Where the curve is lowest; 0 if it rises from the start, inf if it falls without end."""
    if c[A3] <= 0.0:
        return 0.0
    if slope_of_curve(c, 1e9 * c[A4]) < 0.0 or (c[A2] == 0.0 and c[LAW] != 3):
        return inf
    low, high = 0.0, c[A4]
    falls = False
    for n in range(4000):  # the last fall on a fine grid over the weakening
        w = c[A4] * 1e-4 * (1.01**n - 1.0)
        if slope_of_curve(c, w) < 0.0:
            low, high, falls = w, c[A4] * 1e-4 * (1.01 ** (n + 1) - 1.0), True
    if not falls:
        return 0.0
    for _ in range(200):
        middle = 0.5 * (low + high)
        if slope_of_curve(c, middle) < 0.0:
            low = middle
        else:
            high = middle
    return 0.5 * (low + high)
