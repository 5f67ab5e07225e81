"""Shapes of friction as people write them, in a module of theirs, each with its slope."""

import math

HILL, WIDTH = 5.0, 0.2  # where one of them rises again


def shape(z):
    """Lorentzian weakening, Hess and Soom (1990)."""
    return 1.0 / (1.0 + z * z)


def slope(z):
    return -2.0 * z / (1.0 + z * z) ** 2


def bell(z):
    return math.exp(-z * z)


def bell_slope(z):
    return -2.0 * z * math.exp(-z * z)


def falling(z):
    return math.exp(-z)


def falling_slope(z):
    return -math.exp(-z)


def hilly(z):
    return math.exp(-z) + 0.3 * math.exp(-(((z - HILL) / WIDTH) ** 2))


def hilly_slope(z):
    return -math.exp(-z) - 0.6 * (z - HILL) / WIDTH**2 * math.exp(-(((z - HILL) / WIDTH) ** 2))


def rising(z):
    return 1.0 + 0.1 * math.log1p(z)


def rising_slope(z):
    return 0.1 / (1.0 + z)


def wavy(z):
    return 0.7 + 0.3 * math.exp(-z) * math.cos(4.0 * z)


def wavy_slope(z):
    return -0.3 * math.exp(-z) * (math.cos(4.0 * z) + 4.0 * math.sin(4.0 * z))
