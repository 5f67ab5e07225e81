"""The cubic law of Thomsen and Fidlin, Int. J. Non-Linear Mech. 38 (2003) 389-403, and its thresholds.

mu(w) = mu_start - (3/2)(mu_start - mu_reversal)(w/v - (w/v)^3/3), with its minimum mu_reversal at w = v = v_reversal.
Unlike that of the exponential curve the loss of stability is supercritical: as the belt speeds up, stick-slip is
followed by oscillation in pure slip, and that by steady sliding. The thresholds come from harmonic balance, derived
here for SI; they hold for small (mu_start - mu_reversal) N/(v_reversal sqrt(k m)).
"""

import numpy as np
from numpy.typing import ArrayLike

from stickslip.theory.numerics import Floats, floats


def cubic(slip_speed: ArrayLike, mu_start: ArrayLike, mu_reversal: ArrayLike, v_reversal: ArrayLike) -> Floats:
    """Friction coefficient at slip speed w >= 0 (m/s); v_reversal in m/s."""
    w, start, reversal, v_min = floats(slip_speed, mu_start, mu_reversal, v_reversal)
    u = w / v_min
    return np.asarray(start - 1.5 * (start - reversal) * (u - u**3 / 3.0))


def cubic_slope(slip_speed: ArrayLike, mu_start: ArrayLike, mu_reversal: ArrayLike, v_reversal: ArrayLike) -> Floats:
    """Derivative of `cubic` (s/m) with respect to the slip speed (m/s)."""
    w, start, reversal, v_min = floats(slip_speed, mu_start, mu_reversal, v_reversal)
    return np.asarray(-1.5 * (start - reversal) / v_min * (1.0 - (w / v_min) ** 2))


def cubic_loss_of_stability(
    mu_start: ArrayLike, mu_reversal: ArrayLike, v_reversal: ArrayLike, damping: ArrayLike, normal_load: ArrayLike
) -> Floats:
    """Belt speed v_b1 (m/s) below which steady sliding is unstable: v_reversal sqrt(1 - 2 c v_reversal/(3 N drop)).

    drop = mu_start - mu_reversal; damping N s/m, load N. 0 where the damper keeps sliding stable at every speed,
    NaN for a drop below 0: friction that rises first makes sliding unstable above some speed, not below.
    In their units (N = 1, c = 2 beta): v_m sqrt(1 - 4 beta v_m/(3 (mu_s - mu_m))).
    """
    start, reversal, v_min, c, load = floats(mu_start, mu_reversal, v_reversal, damping, normal_load)
    left = 1.0 - 2.0 * c * v_min / (3.0 * load * (start - reversal))
    return np.where(start < reversal, np.nan, v_min * np.sqrt(np.maximum(left, 0.0)))


def cubic_pure_slip_speed(
    belt_speed: ArrayLike, mu_start: ArrayLike, mu_reversal: ArrayLike, v_reversal: ArrayLike, damping: ArrayLike,
    normal_load: ArrayLike,
) -> Floats:  # fmt: skip
    """Amplitude (m/s) of the velocity in self-excited pure slip, 2 sqrt(v_b1^2 - v_belt^2); A1 in their units.

    Times sqrt(m/k) it is the amplitude of the displacement. NaN outside the belt speeds where there is such a motion:
    from `cubic_stick_slip_limit`, below which the mass would overtake the belt and stick, to `cubic_loss_of_stability`.
    """
    v_b1 = cubic_loss_of_stability(mu_start, mu_reversal, v_reversal, damping, normal_load)
    (v,) = floats(belt_speed)
    exists = (v <= v_b1) & (v >= np.sqrt(0.8) * v_b1) & (v > 0)
    return np.where(exists, 2.0 * np.sqrt(np.maximum(v_b1**2 - v**2, 0.0)), np.nan)


def cubic_stick_slip_limit(
    mu_start: ArrayLike, mu_reversal: ArrayLike, v_reversal: ArrayLike, damping: ArrayLike, normal_load: ArrayLike
) -> Floats:
    """Belt speed v_b0 (m/s) between stick-slip below and pure slip above: sqrt(4/5) v_b1.

    There the velocity amplitude of pure slip is the belt speed, so the mass just touches it.
    """
    return np.asarray(np.sqrt(0.8) * cubic_loss_of_stability(mu_start, mu_reversal, v_reversal, damping, normal_load))
