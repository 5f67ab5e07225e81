"""Contacts with memory in steady sliding: small motions, and the stiffness at which they neither grow nor decay.

An inner state follows the slip at a rate r. Friction then has two slopes over the slip speed: E at once, the state
being what it was, and S in steady sliding, the damper in both. Small motions go with e^(st),

    m s^3 + (m r + E) s^2 + (k + r S) s + k r = 0.

J. R. Rice, A. L. Ruina, Stability of steady frictional slipping, J. Appl. Mech. 50 (1983) 343.
"""

from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from stickslip.theory.numerics import Floats, floats


class Slopes(NamedTuple):
    """Slopes of the force on the mass over the slip speed, at once and in steady sliding (N s/m); the rate r (1/s)."""

    at_once: Floats
    steady: Floats
    rate: Floats


class SmallMotions(NamedTuple):
    """The slowest to decay of the small motions about steady sliding: growth (1/s), and angular frequency (1/s)."""

    growth: Floats
    frequency: Floats


def rate_state_slopes(
    damping: ArrayLike, normal_load: ArrayLike, belt_speed: ArrayLike, a: ArrayLike, b: ArrayLike, D_c: ArrayLike
) -> Slopes:
    """Slopes of mu_0 + a ln(w/v_0) + b ln(v_0 theta/D_c): c + a N/v, less b N/v; v/D_c. SI, arrays that broadcast."""
    damping, load, speed, a, b, distance = np.broadcast_arrays(*floats(damping, normal_load, belt_speed, a, b, D_c))
    at_once = damping + a * load / speed
    return Slopes(at_once, at_once - b * load / speed, speed / distance)


def lugre_slopes(
    damping: ArrayLike, belt_speed: ArrayLike, level: ArrayLike, slope: ArrayLike, drag: ArrayLike,
    contact_stiffness: ArrayLike, contact_damping: ArrayLike,
) -> Slopes:  # fmt: skip
    """Slopes of bristles, sigma_0 z + sigma_1 z' + `drag` w with z' = w - sigma_0 w z/g(w), in SI.

    level, slope : g (N) and its derivative (N s/m) at the belt speed. contact_damping : there as well. With q = v g'/g:
    c + drag + sigma_1 q, c + drag + g', and sigma_0 v/g.
    """
    given = floats(damping, belt_speed, level, slope, drag, contact_stiffness, contact_damping)
    damping, speed, level, slope, drag, stiff, damp = np.broadcast_arrays(*given)
    at_once = damping + drag + damp * np.abs(speed) * slope / level
    return Slopes(at_once, damping + drag + slope, stiff * np.abs(speed) / level)


def critical_stiffness(mass: ArrayLike, slopes: Slopes) -> Floats:
    """Spring stiffness below which steady sliding is unstable, N/m: -r S (1 + m r/E).

    0 where it is stable on any spring, inf where it is unstable on any. For E < 0 < S it is unstable above instead.
    """
    mass, at_once, steady, rate = np.broadcast_arrays(np.asarray(mass, np.float64), *slopes)
    with np.errstate(divide="ignore", invalid="ignore"):
        critical = -rate * steady * (1.0 + mass * rate / at_once)
    on_any = np.where(at_once > 0.0, 0.0, np.inf)
    lost = (at_once <= 0.0) & ((steady <= 0.0) | (mass * rate + at_once <= 0.0))
    return np.where((critical > 0.0) & ~lost, critical, on_any)


def critical_frequency(slopes: Slopes) -> Floats:
    """Angular frequency of small motions at the critical stiffness, r (-S/E)^(1/2), 1/s; NaN where there is none."""
    with np.errstate(divide="ignore", invalid="ignore"):
        return np.asarray(slopes.rate * np.sqrt(-slopes.steady / slopes.at_once))


_E_FOLDS = 5.0  # from what the start disturbs to a cycle


def time_to_cycle(displacement: float, belt_speed: float, growth: float) -> float:
    """Roughly the time (s) after which a cycle is seen that begins on the belt: the spring is loaded to `displacement`
    (m), and small motions have grown; 0 where they do not."""
    return abs(displacement / belt_speed) + _E_FOLDS / growth if growth > 0.0 and belt_speed else 0.0


def small_motions(mass: ArrayLike, stiffness: ArrayLike, slopes: Slopes) -> SmallMotions:
    """The leading root of the cubic equation above."""
    given = np.broadcast_arrays(*floats(mass, stiffness), *slopes)
    mass, stiffness, at_once, steady, rate = given
    companion = np.zeros((*mass.shape, 3, 3))
    companion[..., 0, 0], companion[..., 0, 1] = -(rate + at_once / mass), -(stiffness + rate * steady) / mass
    companion[..., 0, 2], companion[..., 1, 0], companion[..., 2, 1] = -stiffness * rate / mass, 1.0, 1.0
    finite = np.asarray(np.isfinite(companion).all(axis=(-2, -1)))
    roots = np.linalg.eigvals(np.where(finite[..., None, None], companion, 0.0))
    leading = np.take_along_axis(roots, np.argmax(roots.real, axis=-1)[..., None], axis=-1)[..., 0]
    root = np.where(finite, leading, np.nan)
    return SmallMotions(np.asarray(root.real), np.abs(root.imag))
