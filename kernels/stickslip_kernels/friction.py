"""Friction laws: the coefficient as a function of the slip speed w = |v_rel|.

Everything here is in kernel units (`layout.py`); a1 and a3 are pure numbers, a2 is per unit of speed, a4 is a speed.
"""

from math import inf, log

from .exponential import exp
from .jit import compiled


@compiled(inline=True)
def stribeck(w, a1, a2, a3, a4):
    """Friction coefficient at slip speed w >= 0: Eq. (2) of the article in its standard form."""
    return a1 + a2 * w + a3 * exp(-w / a4)


@compiled(inline=True)
def stribeck_slope(w, a2, a3, a4):
    """Derivative of `stribeck` with respect to w."""
    return a2 - a3 / a4 * exp(-w / a4)


@compiled
def speed_of_slope(slope, a2, a3, a4):
    """Slip speed at which the curve has the given slope; 0 if it is steeper than that everywhere, inf if never.

    `speed_of_slope(0, ...)` is the minimum v_min = a4 ln(a3/(a2 a4)); `speed_of_slope(-gamma, ...)` is v_H, where
    steady sliding with damping gamma loses its stability.
    """
    if a2 - slope <= 0.0:
        return inf if a3 > 0.0 or a2 < slope else 0.0
    ratio = a3 / (a4 * (a2 - slope))
    return a4 * log(ratio) if ratio > 1.0 else 0.0


@compiled(inline=True)
def line_slope(w_reversal, mu_reversal, mu_stop):
    """Slope of the straight line from (w_reversal, mu_reversal) to (0, mu_stop): Eq. (2a)."""
    return (mu_reversal - mu_stop) / w_reversal
