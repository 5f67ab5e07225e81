"""Gaussian weakening, e^(-(w/a4)^2): `stribeck_delta` at delta = 2, which has a recurrence where others have none.

No law of its own for people: the engine sends cells of that exponent here.
"""

from typing import NamedTuple

from ....exponential import exp
from ....jit import compiled
from ..recurrences import GAUSSIAN
from . import stribeck_delta as general

DELTA = 2.0
SEEN = 1.4  # up to here either way, e^-z^2 is at least a seventh of what it is at most


class Gaussian(NamedTuple):
    """Tag of this law."""

    code: int


TAG = Gaussian(4)
RECURRENCE = GAUSSIAN


@compiled(inline=True)
def shape(z, delta):
    """e^(-z^2)."""
    return exp(-z * z)


@compiled(inline=True)
def weakening_slope(z, x, drop, delta):
    """-2 z x."""
    return -2.0 * z * x


@compiled
def speed_of_shape_slope(slope, delta):
    """As for any exponent."""
    return general.speed_of_shape_slope(slope, DELTA)


@compiled
def inflection(delta):
    """2^(-1/2)."""
    return 0.5**0.5


@compiled
def relaxation(delta):
    """(3/2)^(1/2)."""
    return 1.5**0.5


@compiled
def last_weakening(delta):
    """e^-37 is negligible beside 1."""
    return 37.0**0.5


@compiled
def hidden_depth(delta):
    """As for any exponent: a step that starts where nearly all has weakened sees e^-z^2 over half as much again."""
    return general.hidden_depth(DELTA)


@compiled(inline=True)
def steps_over(z, z_end, rise, rise_end):
    """The shape is even: beyond the zone on both sides nothing tells that it was crossed."""
    return (z > SEEN) & (z_end < -SEEN)


@compiled(inline=True)
def bends():
    """At 2^(-1/2)."""
    return True
