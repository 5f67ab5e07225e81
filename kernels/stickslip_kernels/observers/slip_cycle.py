"""The slip cycle that a spiral comes to where steady sliding repels: a fixed point of the map of `amplitudes.py`.

A loop takes an amplitude a to a L(a), L(a) = R(a) R(-a R(a)). Spirals of a plane do not cross, so a motion that comes
from outside tends to the outermost a with L = 1. It is looked for inwards, in leaps of at most half of what the secant
of 1 - L says is left, as long as L < 1. Of a small deviation from it a loop leaves (a L)', its Floquet multiplier.
"""

from math import inf, nan

from ..jit import compiled
from .ring_down import ratio_and_time

HALF, TENTH = 0.5, 0.1  # of the way that is left, and of the amplitude: leaps at most
NEAR = 0.01  # tolerances, over the amplitude: what may be left
MOST_LEAPS = 100
MOST_LEFT = 0.999  # multiplier of a cycle that attracts for certain


@compiled
def loss(s, i, terms, a):
    """What a loop that begins at a > 0 loses of it: 1 - L(a)."""
    ratio = ratio_and_time(s, i, terms, a)[0]
    return 1.0 - ratio * ratio_and_time(s, i, terms, -a * ratio)[0]


@compiled
def cycle_inside(s, i, terms, a, rtol):
    """Amplitude of the cycle to which loops from a > 0 tend, and its multiplier; NaN where the map does not say."""
    before = loss(s, i, terms, a)
    if not 0.0 < before < 1.0:
        return nan, nan
    outer, a = a, a * (1.0 - before)
    for _ in range(MOST_LEAPS):
        here = loss(s, i, terms, a)
        bend = (before - here) / (outer - a)
        way = here / bend if bend > 0.0 else inf
        if abs(way) <= NEAR * rtol * a:
            left = 1.0 - a * bend
            return (a - way, left) if 0.0 <= left <= MOST_LEFT else (nan, nan)
        if not here > 0.0:
            return nan, nan
        outer, before = a, here
        a -= max(here * a, min(HALF * way, TENTH * a))
    return nan, nan
