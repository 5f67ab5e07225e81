"""The Stribeck curve S(w) = a1 + a2 w + a3 exp(-w/a4), Eq. (2) of the article, and what follows from it.

With g = a4 (a2 + c/N)/a3, which says how far the rise of the curve and the damper make up for its decline, the two
edges of stick-slip are one universal curve each: steady sliding is stable above v_H = a4 ln(1/g), and stick-slip that
started from sticking persists up to v = a4 z, I1(z) e^-z / z = g/2, if friction is weak. Between the two both are
possible.

a2 and a3 may be negative, as in fits of measured curves: friction that weakens at high speed, or that strengthens.
"""

from collections.abc import Callable
from typing import NamedTuple

import numpy as np
import scipy  # type: ignore[import-untyped]
from numpy.typing import ArrayLike, NDArray

Floats = NDArray[np.float64]

_MOST_HALVINGS = 1100  # what it takes from 1 down to the smallest double


def floats(*values: ArrayLike) -> tuple[Floats, ...]:
    """Each as an array of doubles; shapes as given."""
    return tuple(np.asarray(value, np.float64) for value in values)


def bisect(function: Callable[[Floats], Floats], low: Floats, high: Floats) -> Floats:
    """The place where `function` changes from positive at `low` to negative at `high`, to the last bit.

    function : of an array, element by element, in the shape of `low` and `high`. An end that is NaN, or a function
        that is NaN, gives a number without meaning: the caller masks those.
    """
    low, high = np.array(low, np.float64), np.array(high, np.float64)
    for _ in range(_MOST_HALVINGS):
        middle = low + 0.5 * (high - low)
        positive = function(middle) > 0
        moved = np.where(positive, middle != low, middle != high) & ~np.isnan(middle)
        low, high = np.where(positive, middle, low), np.where(positive, high, middle)
        if not moved.any():
            break
    return low


# --- the Stribeck curve -----------------------------------------------------------------------------------------------

STRONGEST = 3.0  # friction number kappa up to which `stick_slip_limit` is within 3 % of the kernels
_ROUNDING = 1e-12  # relative; 0.3/0.1 is below 3, other quotients are above


# By names of `vocabulary.models.LAWS`; stribeck_delta is the Gaussian, delta = 2.
SHAPES: dict[str, Callable[[Floats], Floats]] = {
    "stribeck": lambda z: np.exp(-z),
    "stribeck_delta": lambda z: np.exp(-np.square(z)),
    "rational": lambda z: 1.0 / (1.0 + z),
    "cubic": lambda z: np.where(z < 1.0, 1.0 - 1.5 * z + 0.5 * z**3, 0.0),
}


def weakening(name: str, z: ArrayLike, delta: ArrayLike = 1.0) -> tuple[Floats, Floats]:
    """Shape of the weakening of friction that a law names, over z = w/a4, and its derivative.

    delta : exponent of stribeck_delta.
    """
    z, delta = floats(z, delta)
    if name == "rational":
        return 1.0 / (1.0 + z), -1.0 / np.square(1.0 + z)
    if name == "cubic":
        return 1.0 - 1.5 * z + 0.5 * z**3, 1.5 * np.square(z) - 1.5
    power = z**delta if name == "stribeck_delta" else z
    per_z = delta * z ** (delta - 1.0) if name == "stribeck_delta" else 1.0
    return np.exp(-power), -per_z * np.exp(-power)


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

    0 for a curve that nowhere declines, inf for one that declines everywhere (a2 <= 0), NaN for one that rises first
    and then declines without end (a3 < a2 a4 < 0): it has a maximum, but no minimum.
    """
    return loss_of_stability(a2, a3, a4, 0.0, 1.0)


def reversal_friction(a1: ArrayLike, a2: ArrayLike, a3: ArrayLike, a4: ArrayLike) -> Floats:
    """Friction coefficient at the minimum of the Stribeck curve.

    Where the curve declines without end, the limit: a1 for a2 = 0, -inf for a2 < 0. NaN where `reversal_speed` is.
    """
    v_min = reversal_speed(a2, a3, a4)
    endless = np.isinf(v_min)
    limit = np.where(np.less(a2, 0), -np.inf, a1)
    return np.where(endless, limit, stribeck(np.where(endless, 0.0, v_min), a1, a2, a3, a4))


def tendency(mu_start: ArrayLike, mu_reversal: ArrayLike, mu_stop: ArrayLike) -> Floats:
    """Stick-slip tendency, Eq. (3): mu_start - 2 mu_reversal + mu_stop; the article expects stick-slip where it is > 0.

    mu_start : friction coefficient at break-away. Not a1 + a3 where static friction is higher: then `mu_static`, and
        what ageing has added to it by the break-away (`static_friction`).
    mu_reversal : at the reversal point that the motion reached, not the minimum of the curve. It belongs to a motion,
        measured or simulated (`evaluate` returns it): so the number diagnoses a motion, it predicts none.

    Near-harmonic motion on straight branches gains (pi N A/4) times this number of energy per slip of amplitude A. It
    is an exact border for any stiffness if the branches mirror each other about mu_reversal, for c = 0, and if
    mu_start is where the curve begins (mu_static = a1 + a3, no ageing).
    """
    start, reversal, stop = floats(mu_start, mu_reversal, mu_stop)
    return np.asarray((start - reversal) - (reversal - stop))


def damping_ratio(
    slope: ArrayLike, mass: ArrayLike, stiffness: ArrayLike, damping: ArrayLike, normal_load: ArrayLike
) -> Floats:
    """Damping ratio of steady sliding, zeta = (c + N mu'(v_belt))/(2 sqrt(k m)).

    slope : of the friction curve at the belt speed (s/m), of any law; mass kg, stiffness N/m, damping N s/m, load N.
    Steady sliding is unstable below 0, and approached without overshoot above 1. From m x'' + c x' + k x = N mu(v_belt
    - x'), linearised.
    """
    slope, m, k, c, load = floats(slope, mass, stiffness, damping, normal_load)
    return np.asarray((c + load * slope) / (2.0 * np.sqrt(k * m)))


def loss_of_stability(
    a2: ArrayLike, a3: ArrayLike, a4: ArrayLike, damping: ArrayLike, normal_load: ArrayLike
) -> Floats:
    """Belt speed v_H (m/s) below which steady sliding is unstable, a4 ln(a3/(a4 (a2 + c/N))): where zeta = 0.

    0 where sliding is stable at every speed, inf where it is at none (without damper: where a2 <= 0), NaN where it is
    stable below some speed and not above (a3 < 0). `reversal_speed` is this without damper. The loss is always
    subcritical: small motions decay just above, large ones do not.
    """
    decline, against, a4 = _slopes(a2, a3, a4, damping, normal_load)
    unstable_at_rest = decline > against
    unstable_at_speed = (against < 0) | ((against == 0) & (decline > 0))
    return np.select(
        [unstable_at_rest & unstable_at_speed, unstable_at_rest, (decline <= against) & ~unstable_at_speed],
        [np.inf, a4 * -np.log(_share(decline, against)), 0.0],
        np.nan,
    )


def stick_slip_limit(
    a2: ArrayLike, a3: ArrayLike, a4: ArrayLike, damping: ArrayLike, normal_load: ArrayLike,
    mass: ArrayLike | None = None, stiffness: ArrayLike | None = None, *, strongest: float = STRONGEST,
) -> Floats:  # fmt: skip
    """Belt speed (m/s) up to which stick-slip that started from sticking persists, near-harmonically.

    v = a4 z with I1(z) e^-z / z = g/2, g = a4 (a2 + c/N)/a3: a slip whose speed amplitude is that of the belt loses to
    the rise of the curve and to the damper what it gains on the decline (harmonic balance).

    mass, stiffness : with both the domain is checked, NaN outside it; without them the limit of weak friction.
    strongest : the domain is kappa = N a3/(a4 sqrt(k m)) <= strongest, see `groups`; inf gives every value.

    Exact as kappa -> 0. Against `evaluate` the error is below 0.33 % kappa^2 up to kappa = 3, so at most 3 % (for g
    from 0.001 to 0.98; it is largest at g = 0.2, where the limit is too high). Beyond it grows fast: up to 20 % at
    kappa = 10, 96 % at 50. For the plain curve without ageing and mu_static. Far below the limit the contact may fail
    to hold the mass that the belt catches (a1 N well below v sqrt(k m)): then it oscillates indefinitely without
    sticking (`sustained`). 0 where there is no stick-slip, inf where it has no end (a2 <= 0 and no damper), NaN where
    `loss_of_stability` is.
    """
    stable_from = loss_of_stability(a2, a3, a4, damping, normal_load)
    decline, against, a4 = _slopes(a2, a3, a4, damping, normal_load)
    share = _share(decline, against)
    # I1(z)/z > 1/2 bounds the root from below, I1(z) e^-z < 1/sqrt(2 pi z) from above.
    high = (2.0 / (share * np.sqrt(2.0 * np.pi))) ** (2.0 / 3.0)
    z = bisect(lambda z: np.asarray(scipy.special.i1e(z) / z - 0.5 * share), -np.log(share), high)
    ends = (stable_from > 0) & np.isfinite(stable_from)
    limit = np.where(ends, a4 * z, stable_from)
    if mass is None or stiffness is None:
        return limit
    m, k, load = floats(mass, stiffness, normal_load)
    kappa = decline * load / np.sqrt(k * m)
    return np.where(ends & (kappa > strongest * (1.0 + _ROUNDING)), np.nan, limit)


def unstable_amplitude(
    belt_speed: ArrayLike, a2: ArrayLike, a3: ArrayLike, a4: ArrayLike, damping: ArrayLike, normal_load: ArrayLike
) -> Floats:
    """Speed amplitude (m/s) of the unstable cycle about stable steady sliding, near-harmonically.

    a4 r with 2 I1(r)/r = g e^z, z = v/a4: the vibration that gains on the decline of the curve what it loses to its
    rise and to the damper. Smaller ones die out, larger ones grow. It is the cycle itself where friction is weak and
    the amplitude is below the belt speed; above, slip would change its direction. NaN where steady sliding is unstable
    or the curve does not decline.
    """
    decline, against, a4 = _slopes(a2, a3, a4, damping, normal_load)
    z = np.abs(belt_speed) / a4
    excess = z + np.log(_share(decline, against))
    exists = (against > 0) & (against < decline) & (excess > 0)
    excess = np.where(exists, excess, 1.0)
    high = excess + 10.0 + 3.0 * np.log1p(excess)
    r = bisect(lambda r: excess - r - np.log(2.0 * scipy.special.i1e(r) / r), 1e-9 * excess, high)
    return np.where(exists, a4 * r, np.nan)


def _slopes(
    a2: ArrayLike, a3: ArrayLike, a4: ArrayLike, damping: ArrayLike, normal_load: ArrayLike
) -> tuple[Floats, Floats, Floats]:
    """The decline of the curve at zero speed, a3/a4, what rise and damper set against it, a2 + c/N, and a4."""
    a2, a3, a4, c, load = np.broadcast_arrays(*floats(a2, a3, a4, damping, normal_load))
    return a3 / a4, a2 + c / load, a4


def _share(decline: Floats, against: Floats) -> Floats:
    """g = against/decline where it lies between 0 and 1, that is where stick-slip has an end; elsewhere a stand-in."""
    inside = (against > 0) & (against < decline)
    return np.divide(against, decline, out=np.full_like(against, 0.5), where=inside)


class Groups(NamedTuple):
    """The four numbers that decide the motion on a plain Stribeck curve, see `groups`."""

    speed: Floats
    strength: Floats
    damping: Floats
    rise: Floats


def groups(
    mass: ArrayLike, stiffness: ArrayLike, damping: ArrayLike, normal_load: ArrayLike, belt_speed: ArrayLike,
    a2: ArrayLike, a3: ArrayLike, a4: ArrayLike,
) -> Groups:  # fmt: skip
    """The dimensionless groups of a cell, given in SI.

    speed : v_belt/a4. strength : kappa = N a3/(a4 sqrt(k m)), falls as the spring stiffens.
    damping : zeta0 = c/(2 sqrt(k m)), of the damper alone. rise : alpha = a2 a4/a3.

    Cells with equal groups move alike, with times in sqrt(m/k) and speeds in a4. a1 only shifts the equilibrium, as
    long as the contact does not stick against the belt; hysteresis and ageing add groups of their own.
    """
    m, k, c, load, v, a2, a3, a4 = floats(mass, stiffness, damping, normal_load, belt_speed, a2, a3, a4)
    impedance = np.sqrt(k * m)
    return Groups(*floats(v / a4, load * a3 / (a4 * impedance), c / (2.0 * impedance), a2 * a4 / a3))


# --- the cubic law of Thomsen and Fidlin, Int. J. Non-Linear Mech. 38 (2003) 389-403 ----------------------------------

# mu(w) = mu_start - (3/2)(mu_start - mu_reversal)(w/v - (w/v)^3/3), with its minimum mu_reversal at w = v = v_reversal.
# Unlike that of the exponential curve the loss of stability is supercritical: as the belt speeds up, stick-slip is
# followed by oscillation in pure slip, and that by steady sliding. The thresholds come from harmonic balance, derived
# here for SI; they hold for small (mu_start - mu_reversal) N/(v_reversal sqrt(k m)).


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
