"""Rational weakening, 1/(1 + w/a4).

R. I. Leine, D. H. van Campen, A. de Kraker, L. van den Steen, Stick-slip vibrations induced by alternate friction
models, Nonlinear Dynamics 16 (1998) 41-54, use mu = F/(1 + delta |v|): a1 = a2 = 0, a3 = F, a4 = 1/delta.
"""

from math import inf
from typing import NamedTuple

from ....jit import compiled
from ..recurrences import QUOTIENT


class Rational(NamedTuple):
    """Tag of this law."""

    code: int


TAG = Rational(2)
RECURRENCE = QUOTIENT


@compiled(inline=True)
def shape(z, delta):
    """1/(1 + z)."""
    return 1.0 / (1.0 + z)


@compiled(inline=True)
def weakening_slope(z, x, drop, delta):
    """-x/(1 + z)."""
    return -x / (1.0 + z)


@compiled
def speed_of_shape_slope(slope, delta):
    """(-slope)^(-1/2) - 1."""
    if slope >= 0.0:
        return inf
    return (-slope) ** -0.5 - 1.0 if slope > -1.0 else 0.0


@compiled
def relaxation(delta):
    """Everywhere: the shape is completely monotone."""
    return 0.0


@compiled
def hidden_depth(delta):
    """Half the speed over which friction halves first."""
    return 0.5


@compiled(inline=True)
def steps_over(z, z_end, rise, rise_end):
    """Beyond the pole."""
    return z_end <= -1.0
