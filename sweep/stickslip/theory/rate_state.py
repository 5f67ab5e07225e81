"""Closed forms of rate-and-state friction, mu_0 + a ln(w/v_0) + b ln(v_0 theta/D_c), on a spring.

J. R. Rice, A. L. Ruina, Stability of steady frictional slipping, J. Appl. Mech. 50 (1983) 343.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from stickslip.theory.numerics import Floats, floats


class SmallMotions(NamedTuple):
    """The slowest to decay of the small motions about steady sliding: growth (1/s), and angular frequency (1/s)."""

    growth: Floats
    frequency: Floats


def critical_stiffness(
    mass: ArrayLike, damping: ArrayLike, normal_load: ArrayLike, belt_speed: ArrayLike, a: ArrayLike, b: ArrayLike,
    D_c: ArrayLike,
) -> Floats:  # fmt: skip
    """Spring stiffness below which steady sliding is unstable, N/m; 0 where it is stable on any spring.

    SI, arrays that broadcast. -r S (1 + m r/E), with the rate r = v/D_c at which the state follows, and the slopes of
    the force on the slip speed at once, E = c + a N/v, and in steady sliding, S = E - b N/v.
    """
    mass, at_once, steady, rate = _slopes(mass, damping, normal_load, belt_speed, a, b, D_c)
    return np.maximum(-rate * steady * (1.0 + mass * rate / at_once), 0.0)


def critical_frequency(
    damping: ArrayLike, normal_load: ArrayLike, belt_speed: ArrayLike, a: ArrayLike, b: ArrayLike, D_c: ArrayLike
) -> Floats:
    """Angular frequency of small motions at the critical stiffness, r (-S/E)^(1/2), 1/s; NaN where there is none."""
    _, at_once, steady, rate = _slopes(0.0, damping, normal_load, belt_speed, a, b, D_c)
    with np.errstate(invalid="ignore"):
        return np.asarray(rate * np.sqrt(-steady / at_once))


def small_motions(
    mass: ArrayLike, stiffness: ArrayLike, damping: ArrayLike, normal_load: ArrayLike, belt_speed: ArrayLike,
    a: ArrayLike, b: ArrayLike, D_c: ArrayLike,
) -> SmallMotions:  # fmt: skip
    """The leading root of m s^3 + (m r + E) s^2 + (k + r S) s + k r = 0, as in `critical_stiffness`."""
    mass, at_once, steady, rate = _slopes(mass, damping, normal_load, belt_speed, a, b, D_c)
    stiffness = np.broadcast_to(np.asarray(stiffness, np.float64), mass.shape)
    companion = np.zeros((*mass.shape, 3, 3))
    companion[..., 0, 0], companion[..., 0, 1] = -(rate + at_once / mass), -(stiffness + rate * steady) / mass
    companion[..., 0, 2], companion[..., 1, 0], companion[..., 2, 1] = -stiffness * rate / mass, 1.0, 1.0
    finite = np.asarray(np.isfinite(companion).all(axis=(-2, -1)))
    roots = np.linalg.eigvals(np.where(finite[..., None, None], companion, 0.0))
    leading = np.take_along_axis(roots, np.argmax(roots.real, axis=-1)[..., None], axis=-1)[..., 0]
    found = np.where(finite, leading, np.nan)
    return SmallMotions(np.asarray(found.real), np.abs(found.imag))


def _slopes(
    mass: ArrayLike, damping: ArrayLike, load: ArrayLike, speed: ArrayLike, a: ArrayLike, b: ArrayLike, D_c: ArrayLike
) -> tuple[Floats, Floats, Floats, Floats]:
    """Mass, E, S and r, of one shape."""
    given = floats(mass, damping, load, speed, a, b, D_c)
    mass, damping, load, speed, a, b, distance = np.broadcast_arrays(*given)
    at_once = damping + a * load / speed
    return mass, at_once, at_once - b * load / speed, speed / distance
