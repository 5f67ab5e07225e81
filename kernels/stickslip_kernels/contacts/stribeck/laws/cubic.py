"""Weakening and strengthening along a cubic, 1 - 3/2 z + 1/2 z^3, z = w/a4: its minimum, 0, lies at w = a4.

J. J. Thomsen, A. Fidlin, Analytical approximations for stick-slip vibration amplitudes, International Journal of
Non-Linear Mechanics 38 (2003) 389-403: mu_s - 3/2 (mu_s - mu_m) (w/v_m - (w/v_m)^3/3), so a1 = mu_m, a2 = 0,
a3 = mu_s - mu_m, a4 = v_m.
"""

from typing import NamedTuple

from ....jit import compiled
from ..recurrences import CUBIC


class Cubic(NamedTuple):
    """Tag of this law."""

    code: int


TAG = Cubic(3)
RECURRENCE = CUBIC


@compiled(inline=True)
def shape(z, delta):
    """1 - 3/2 z + 1/2 z^3."""
    return 1.0 + z * (0.5 * z * z - 1.5)


@compiled(inline=True)
def weakening_slope(z, x, drop, delta):
    """drop (3/2 z^2 - 3/2)."""
    return drop * (1.5 * z * z - 1.5)


@compiled
def speed_of_shape_slope(slope, delta):
    """(1 + 2/3 slope)^(1/2)."""
    return (1.0 + slope / 1.5) ** 0.5 if slope > -1.5 else 0.0


@compiled(inline=True)
def bends():
    """From far above a4, where it is steep, to a4: w'' = b - w - mu' w' changes its sign twice on the way down."""
    return True
