"""Exponential weakening with an exponent, e^(-(w/a4)^delta): delta = 2 is the Gaussian form.

B. Armstrong-Helouvry, P. Dupont, C. Canudas de Wit, A survey of models, analysis tools and compensation methods for the
control of machines with friction, Automatica 30 (1994) 1083-1138, Eq. (3). Here delta >= 1: below, the curve falls
vertically at w = 0, and no method that needs a slope can leave it. The motion has no Taylor series at w = 0 where delta
is no whole number. At 1 and 2 the laws `stribeck` and `gaussian` are the same curve, and faster.
"""

from math import inf
from typing import NamedTuple

from ....exponential import exp, log
from ....jit import compiled


class StribeckDelta(NamedTuple):
    """Tag of this law."""

    code: int


TAG = StribeckDelta(1)
FLATTEST = 1e-290  # slopes nearer to zero are below the smallest value of the exponential
MOST_TRIES = 60


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
def speed_of_shape_slope(slope, delta):
    """On the convex part, beyond the inflection: with p = z^delta, p - (1 - 1/delta) ln p = ln delta - ln(-slope).

    The left side is convex in p, so Newton's method falls onto the larger root from above, until it no longer moves.
    """
    if slope >= -FLATTEST:
        return inf
    bend, level = 1.0 - 1.0 / delta, log(delta) - log(-slope)
    if level <= (bend * (1.0 - log(bend)) if bend > 0.0 else 0.0):
        return 0.0
    p = 2.0 * level + 2.0
    for _ in range(MOST_TRIES):
        new = p - (p - bend * log(p) - level) / (1.0 - bend / p)
        if not bend < new < p:
            break
        p = new
    return exp(log(p) / delta)


@compiled
def inflection(delta):
    """Return where delta z^delta = delta - 1."""
    return exp(log((delta - 1.0) / delta) / delta) if delta > 1.0 else 0.0


@compiled
def relaxation(delta):
    """The larger p = z^delta with delta^2 p^2 - 3 delta (delta - 1) p + (delta - 1)(delta - 2) = 0."""
    p = (3.0 * (delta - 1.0) + ((delta - 1.0) * (5.0 * delta - 1.0)) ** 0.5) / (2.0 * delta)
    return exp(log(p) / delta) if p > 0.0 else 0.0


@compiled
def last_weakening(delta):
    """e^-37 is negligible beside 1."""
    return exp(log(37.0) / delta)


@compiled
def hidden_depth(delta):
    """Half the width of the fall, which is steeper for a larger exponent."""
    return 0.5 / delta
