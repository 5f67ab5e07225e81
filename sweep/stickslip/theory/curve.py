"""The Stribeck curve S(w) = a1 + a2 w + a3 exp(-w/a4), Eq. (2) of the article, and what follows from it.

With g = a4 (a2 + c/N)/a3, which says how far the rise of the curve and the damper make up for its decline, the two
edges of stick-slip are one universal curve each: steady sliding is stable above v_H = a4 ln(1/g), and stick-slip that
started from sticking lives on up to v = a4 z, I1(z) e^-z / z = g/2. Between the two both are possible.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike
from scipy.special import i1e  # type: ignore[import-untyped]

from stickslip.theory.numerics import Floats, bisect, floats


def stribeck(slip_speed: ArrayLike, a1: ArrayLike, a2: ArrayLike, a3: ArrayLike, a4: ArrayLike) -> Floats:
    """Friction coefficient at slip speed w >= 0 (m/s): Eq. (2) in its standard form, a2 in s/m, a4 in m/s."""
    w, a1, a2, a3, a4 = floats(slip_speed, a1, a2, a3, a4)
    return np.asarray(a1 + a2 * w + a3 * np.exp(-w / a4))


def stribeck_slope(slip_speed: ArrayLike, a2: ArrayLike, a3: ArrayLike, a4: ArrayLike) -> Floats:
    """Derivative of `stribeck` (s/m) with respect to the slip speed (m/s)."""
    w, a2, a3, a4 = floats(slip_speed, a2, a3, a4)
    return np.asarray(a2 - a3 / a4 * np.exp(-w / a4))


def reversal_speed(a2: ArrayLike, a3: ArrayLike, a4: ArrayLike) -> Floats:
    """Speed v_min (m/s) at the minimum of the Stribeck curve, a4 ln(a3/(a2 a4)).

    0 for a curve that nowhere declines, inf for one that declines for ever (a2 = 0).
    """
    return loss_of_stability(a2, a3, a4, 0.0, 1.0)


def reversal_friction(a1: ArrayLike, a2: ArrayLike, a3: ArrayLike, a4: ArrayLike) -> Floats:
    """Friction coefficient at the minimum of the Stribeck curve; the limit a1 where the curve declines for ever."""
    v_min = reversal_speed(a2, a3, a4)
    endless = np.isinf(v_min)
    return np.where(endless, a1, stribeck(np.where(endless, 0.0, v_min), a1, a2, a3, a4))


def tendency(mu_start: ArrayLike, mu_reversal: ArrayLike, mu_stop: ArrayLike) -> Floats:
    """Stick-slip tendency, Eq. (3): mu_start - 2 mu_reversal + mu_stop; the article expects stick-slip where it is > 0.

    mu_reversal : where the slip speed turned around, not the minimum of the curve.

    Near-harmonic motion on straight branches gains (pi N A/4) times this number of energy per slip of amplitude A. It
    is an exact border for any stiffness if the branches mirror each other about mu_reversal, and for c = 0.
    """
    start, reversal, stop = floats(mu_start, mu_reversal, mu_stop)
    return np.asarray((start - reversal) - (reversal - stop))


def damping_ratio(
    slope: ArrayLike, mass: ArrayLike, stiffness: ArrayLike, damping: ArrayLike, normal_load: ArrayLike
) -> Floats:
    """Damping ratio of steady sliding, zeta = (c + N mu'(v_belt))/(2 sqrt(k m)).

    slope : of the friction curve at the belt speed (s/m), of any law; mass kg, stiffness N/m, damping N s/m, load N.
    Steady sliding is unstable below 0 and creeps home above 1. From m x'' + c x' + k x = N mu(v_belt - x'), linearised.
    """
    slope, m, k, c, load = floats(slope, mass, stiffness, damping, normal_load)
    return np.asarray((c + load * slope) / (2.0 * np.sqrt(k * m)))


def loss_of_stability(
    a2: ArrayLike, a3: ArrayLike, a4: ArrayLike, damping: ArrayLike, normal_load: ArrayLike
) -> Floats:
    """Belt speed v_H (m/s) below which steady sliding is unstable, a4 ln(a3/(a4 (a2 + c/N))): where zeta = 0.

    0 where sliding is stable at every speed, inf where it is at none (a2 = 0 and no damper). `reversal_speed` is this
    without damper. The loss is always subcritical: small motions die out just above, large ones do not.
    """
    g = _recovery(a2, a3, a4, damping, normal_load)
    with np.errstate(divide="ignore"):
        return np.multiply(a4, np.where(g < 1, -np.log(g), 0.0), dtype=np.float64)


def stick_slip_limit(a2: ArrayLike, a3: ArrayLike, a4: ArrayLike, damping: ArrayLike, normal_load: ArrayLike) -> Floats:
    """Belt speed (m/s) up to which stick-slip that started from sticking lives on, near-harmonically.

    v = a4 z with I1(z) e^-z / z = g/2, g = a4 (a2 + c/N)/a3: a slip whose speed amplitude is that of the belt loses to
    the rise of the curve and to the damper what it gains on the decline (harmonic balance). Exact for weak friction,
    kappa = N a3/(a4 sqrt(k m)) -> 0; 0.7 % too high at kappa = 3.
    0 where there is no stick-slip, inf where it has no end (a2 = 0 and no damper).
    """
    g = _recovery(a2, a3, a4, damping, normal_load)
    inside = (g > 0) & (g < 1)
    share = np.where(inside, g, 0.5)
    # I1(z)/z > 1/2 bounds the root from below, I1(z) e^-z < 1/sqrt(2 pi z) from above.
    high = (2.0 / (share * np.sqrt(2.0 * np.pi))) ** (2.0 / 3.0)
    z = bisect(lambda z: np.asarray(i1e(z) / z - 0.5 * share), -np.log(share), high)
    return np.multiply(a4, np.where(inside, z, np.where(g > 0, 0.0, np.inf)), dtype=np.float64)


def _recovery(a2: ArrayLike, a3: ArrayLike, a4: ArrayLike, damping: ArrayLike, normal_load: ArrayLike) -> Floats:
    """g = a4 (a2 + c/N)/a3: what rise and damper put against the decline; 1 for a flat curve, inf for a rising one."""
    a2, a3, a4, c, load = floats(a2, a3, a4, damping, normal_load)
    against, decline = np.broadcast_arrays(a4 * (a2 + c / load), a3)
    return np.asarray(np.divide(against, decline, out=np.where(against > 0, np.inf, 1.0), where=decline > 0))


class Groups(NamedTuple):
    """The four numbers that decide the motion on a plain Stribeck curve, see `groups`."""

    speed: Floats
    strength: Floats
    damping: Floats
    rise: Floats


def groups(
    mass: ArrayLike,
    stiffness: ArrayLike,
    damping: ArrayLike,
    normal_load: ArrayLike,
    belt_speed: ArrayLike,
    a2: ArrayLike,
    a3: ArrayLike,
    a4: ArrayLike,
) -> Groups:
    """The dimensionless groups of a cell, given in SI.

    speed : v_belt/a4. strength : kappa = N a3/(a4 sqrt(k m)), falls as the spring stiffens.
    damping : zeta0 = c/(2 sqrt(k m)), of the damper alone. rise : alpha = a2 a4/a3.

    Cells with equal groups move alike, with times in sqrt(m/k) and speeds in a4. a1 only shifts the equilibrium, as
    long as the contact does not stick against the belt; hysteresis and ageing add groups of their own.
    """
    m, k, c, load, v, a2, a3, a4 = floats(mass, stiffness, damping, normal_load, belt_speed, a2, a3, a4)
    impedance = np.sqrt(k * m)
    return Groups(*floats(v / a4, load * a3 / (a4 * impedance), c / (2.0 * impedance), a2 * a4 / a3))
