"""Exponential weakening with an exponent, e^(-(w/a4)^delta): delta = 2 is the Gaussian form.

B. Armstrong-Helouvry, P. Dupont, C. Canudas de Wit, A survey of models, analysis tools and compensation methods for the
control of machines with friction, Automatica 30 (1994) 1083-1138, Eq. (3). Here delta >= 1: below, the curve falls
vertically at w = 0, and no method that needs a slope can leave it.
"""

from math import inf
from typing import NamedTuple

from ..exponential import exp, log
from ..jit import compiled


class StribeckDelta(NamedTuple):
    """Tag of this law."""

    code: int


TAG = StribeckDelta(1)
STEPPER = "runge_kutta"
FLATTEST = 1e-290  # slopes nearer to zero are below the smallest value of the exponential
MOST_DOUBLINGS = 60


@compiled(inline=True)
def shape(z, delta):
    """e^(-|z|^delta); even, so that a trial stage just below w = 0 sees a smooth curve."""
    return exp(-exp(delta * log(abs(z))))


@compiled(inline=True)
def weakening_slope(z, x, drop, delta):
    """-delta |z|^(delta - 1) x, with the sign of z."""
    size = delta * exp((delta - 1.0) * log(abs(z))) * x
    return -size if z >= 0.0 else size


@compiled
def slope_at(z, delta):
    """shape'(z) for z > 0."""
    return weakening_slope(z, shape(z, delta), 1.0, delta)


@compiled
def speed_of_shape_slope(slope, delta):
    """By bisection on the convex part, where the slope grows from its least value to zero."""
    if slope >= -FLATTEST:
        return inf
    low = inflection(delta)
    if slope <= (slope_at(low, delta) if low > 0.0 else -1.0):
        return 0.0
    high = max(2.0 * low, 1.0)
    for _ in range(MOST_DOUBLINGS):
        if slope_at(high, delta) >= slope:
            break
        high *= 2.0
    for _ in range(200):
        middle = 0.5 * (low + high)
        if slope_at(middle, delta) < slope:
            low = middle
        else:
            high = middle
    return 0.5 * (low + high)


@compiled
def inflection(delta):
    """Where delta z^delta = delta - 1."""
    return exp(log((delta - 1.0) / delta) / delta) if delta > 1.0 else 0.0


@compiled
def last_weakening(delta):
    """e^-37 is negligible beside 1."""
    return exp(log(37.0) / delta)


@compiled
def hidden_depth(delta):
    """Half the width of the fall, which is steeper for a larger exponent."""
    return 0.5 / delta
