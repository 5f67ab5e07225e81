"""Lorentzian weakening, 1/(1 + (w/a4)^2).

D. P. Hess, A. Soom, Friction at a lubricated line contact operating at oscillating sliding velocities, Journal of
Tribology 112 (1990) 147-152.
"""

from math import inf
from typing import NamedTuple

from ....jit import compiled


class Lorentzian(NamedTuple):
    """Tag of this law."""

    code: int


TAG = Lorentzian(5)
BEND = 3.0**-0.5  # the inflection
STEEPEST = -1.125 * BEND  # the slope there
MOST_TRIES = 60


@compiled(inline=True)
def shape(z, delta):
    """1/(1 + z^2)."""
    return 1.0 / (1.0 + z * z)


@compiled(inline=True)
def weakening_slope(z, x, drop, delta):
    """-2 z x/(1 + z^2)."""
    return -2.0 * z * x / (1.0 + z * z)


@compiled
def speed_of_shape_slope(slope, delta):
    """The root of -2 z/(1 + z^2)^2 = slope beyond the inflection, where the slope only grows: by halving a bracket."""
    if slope >= 0.0:
        return inf
    if slope <= STEEPEST:
        return 0.0
    low, high = BEND, (-2.0 / slope) ** (1.0 / 3.0)
    for _ in range(MOST_TRIES):
        middle = 0.5 * (low + high)
        if -2.0 * middle / (1.0 + middle * middle) ** 2 < slope:
            low = middle
        else:
            high = middle
    return high


@compiled
def inflection(delta):
    """3^(-1/2)."""
    return BEND


@compiled
def hidden_depth(delta):
    """Half the speed over which friction falls."""
    return 0.5
