"""Exponential weakening, e^(-w/a4): Eq. (2) of the article in its standard form (Bo & Pavelescu 1982; Tustin 1947)."""

from math import inf, log
from typing import NamedTuple

from ....exponential import exp
from ....jit import compiled
from ..recurrences import EXPONENTIAL


class Stribeck(NamedTuple):
    """Tag of this law."""

    code: int


TAG = Stribeck(0)
RECURRENCE = EXPONENTIAL


@compiled(inline=True)
def shape(z, delta):
    """e^-z."""
    return exp(-z)


@compiled(inline=True)
def weakening_slope(z, x, drop, delta):
    """-x: no second exponential."""
    return -x


@compiled
def speed_of_shape_slope(slope, delta):
    """-ln(-slope)."""
    if slope >= 0.0:
        return inf
    return -log(-slope) if slope > -1.0 else 0.0


@compiled
def relaxation(delta):
    """Everywhere: the shape is completely monotone."""
    return 0.0


@compiled
def last_weakening(delta):
    """e^-37 is negligible beside 1."""
    return 37.0


@compiled
def hidden_depth(delta):
    """The Taylor series resolves e^-z over more than two units; the defect at the end of a step shows the rest."""
    return 2.0
