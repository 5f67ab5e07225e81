"""Lorentzian weakening, 1/(1 + (w/a4)^2).

D. P. Hess, A. Soom, Friction at a lubricated line contact operating at oscillating sliding velocities, Journal of
Tribology 112 (1990) 147-152.
"""

from math import inf
from typing import NamedTuple

from .laws import LAWS, hidden_depth, inflection, shape, speed_of_shape_slope, weakening_slope


class Lorentzian(NamedTuple):
    """Tag of this law."""

    code: int


LAWS["lorentzian"] = Lorentzian(5)
BEND = 3.0**-0.5  # the inflection
STEEPEST = -1.125 * BEND  # the slope there
MOST_TRIES = 60

shape.of(Lorentzian)(lambda law, z, delta: 1.0 / (1.0 + z * z))
weakening_slope.of(Lorentzian)(lambda law, z, x, drop, delta: -2.0 * z * x / (1.0 + z * z))
inflection.of(Lorentzian)(lambda law, delta: BEND)
hidden_depth.of(Lorentzian)(lambda law, delta: 0.5)  # half the speed over which friction falls


@speed_of_shape_slope.of(Lorentzian)
def _speed_of_slope(law, slope, delta):
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
