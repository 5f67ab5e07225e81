"""Shapes of friction as people write them, in a module of theirs."""

import math

from numba import njit

CENTRE = 1.0


@njit
def squared(z):
    return z * z


def shape(z, delta):  # this and its slope and recurrence are those of docs/own-law.md, so that both are compiled once
    """Lorentzian weakening, Hess and Soom (1990)."""
    return 1.0 / (1.0 + z * z)


def slope(z, delta):
    return -2.0 * z / (1.0 + z * z) ** 2


def with_helper(z, delta):
    return 1.0 / (1.0 + squared(z) * CENTRE)


def stretched(z, delta):
    return math.exp(-(z**delta))


def stretched_slope(z, delta):
    return -delta * z ** (delta - 1.0) * math.exp(-(z**delta))


def recurrence(n, z, s, d, delta):
    """Coefficient n of -2 z s^2."""
    total = 0.0
    for i in range(n + 1):
        for j in range(n + 1 - i):
            total -= 2.0 * z[i] * s[j] * s[n - i - j]
    return total


def bell(z, delta):
    return math.exp(-z * z)


def bell_slope(z, delta):
    return -2.0 * z * math.exp(-z * z)


def bell_recurrence(n, z, s, d, delta):
    total = 0.0
    for j in range(n + 1):
        total -= 2.0 * z[j] * s[n - j]
    return total
