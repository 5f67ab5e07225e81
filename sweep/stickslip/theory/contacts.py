"""Contacts in closed form: Coulomb friction with its cycle, static friction that ages, small motions with memory.

Coulomb friction has a static and a kinetic coefficient. In slip the velocity of the mass is a free damped vibration
that starts at the belt speed with the acceleration -(mu_static - mu_kinetic) N/m, and slip ends when it is back at the
belt speed. Everything depends on kappa = (mu_static - mu_kinetic) N/(v_belt sqrt(k m)) and zeta = c/(2 sqrt(k m)).
Without damper there is stick-slip at every belt speed; with one, as long as kappa exceeds kappa_c(zeta).
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from stickslip.theory.curve import Floats, bisect, floats


class CoulombCycle(NamedTuple):
    """One cycle, break-away to break-away, in SI; NaN where there is no stick-slip.

    Displacements: of the mass, 0 where the spring is slack. acceleration_max : largest magnitude; at break-away the
    acceleration jumps to (mu_static - mu_kinetic) N/m. energy_per_cycle : friction heat.
    """

    stick_time: Floats
    slip_time: Floats
    period: Floats
    breakaway_displacement: Floats
    restick_displacement: Floats
    displacement_max: Floats
    displacement_min: Floats
    slip_speed_max: Floats
    acceleration_max: Floats
    energy_per_cycle: Floats


def coulomb_cycle(
    mass: ArrayLike, stiffness: ArrayLike, normal_load: ArrayLike, belt_speed: ArrayLike, mu_static: ArrayLike,
    mu_kinetic: ArrayLike, damping: ArrayLike = 0.0,
) -> CoulombCycle:  # fmt: skip
    """The stick-slip cycle for constant coefficients mu_static > mu_kinetic >= 0 and a belt speed > 0 (m/s).

    Without damper, with D = (mu_static - mu_kinetic) N/k and w = sqrt(k/m): stick time 2 D/v, slip time
    (2/w)(pi - atan(D w/v)), displacement mu_kinetic N/k -+ sqrt(D^2 + v^2/w^2). With a damper the slip time is a root,
    e^-zeta s (cos b s + ((zeta - kappa)/b) sin b s) = 1, b = sqrt(1 - zeta^2), s = w t; the rest stays closed.
    NaN where a damper ends stick-slip, see `critical_speed`.
    """
    m, k, load, v, static, kinetic, c = np.broadcast_arrays(
        *floats(mass, stiffness, normal_load, belt_speed, mu_static, mu_kinetic, damping)
    )
    drop = (static - kinetic) * load
    with np.errstate(divide="ignore", invalid="ignore"):
        kappa, zeta = drop / (v * np.sqrt(k * m)), c / (2.0 * np.sqrt(k * m))
        exists = (v > 0) & (kappa > critical_strength(zeta))
    kappa, zeta, v = np.where(exists, kappa, 1.0), np.where(exists, zeta, 0.0), np.where(exists, v, np.nan)
    w = np.sqrt(k / m)
    velocity = _Free(zeta, np.ones_like(kappa), -kappa)  # in units of v and 1/w
    acceleration = velocity.derivative()
    end = _slip_angle(kappa, zeta)
    last = acceleration(end)
    stick_time = (drop + v * np.sqrt(k * m) * last) / (k * v)
    period = stick_time + end / w
    breakaway = (static * load - c * v) / k
    crossing = velocity.first_zero()  # velocity zero: first at the largest displacement, then at the smallest
    centre, scale = kinetic * load / k, v / w
    jerk = acceleration.derivative()
    peak, trough = jerk.first_zero(), jerk.first_zero() + jerk.half_period
    inner = [np.where(at < end, np.abs(acceleration(at)), 0.0) for at in (peak, trough)]
    return CoulombCycle(
        stick_time=stick_time,
        slip_time=end / w + 0.0 * v,
        period=period,
        breakaway_displacement=breakaway + 0.0 * v,
        restick_displacement=breakaway - v * stick_time,
        displacement_max=centre - scale * acceleration(crossing),  # at zero velocity k x = mu N - m x''
        displacement_min=centre - scale * acceleration(crossing + velocity.half_period),
        slip_speed_max=v * (1.0 - velocity(acceleration.first_zero())),
        acceleration_max=v * w * np.max([kappa, np.abs(last), *inner], axis=0),
        energy_per_cycle=kinetic * load * v * period,  # in a cycle the belt moves v T past a mass that returns
    )


def critical_strength(zeta: ArrayLike) -> Floats:
    """kappa_c: stick-slip persists where kappa = (mu_static - mu_kinetic) N/(v_belt sqrt(k m)) exceeds it.

    zeta : damping ratio c/(2 sqrt(k m)) >= 0. 0 without damper, inf from zeta = 1. At the border a slip that started at
    the belt speed just touches it again: kappa_c = -e^(zeta s) sin(b s)/b, with the root s in (pi/b, 2 pi/b) of
    e^(zeta s) (cos b s - (zeta/b) sin b s) = 1, b = sqrt(1 - zeta^2).
    """
    (zeta,) = floats(zeta)
    between = (zeta > 0) & (zeta < 1)
    z = np.where(between, zeta, 0.5)
    b = np.sqrt((1.0 - z) * (1.0 + z))

    def short_of_contact(angle: Floats) -> Floats:  # angle = 2 pi - b s: no digits are lost where it is small
        lost = -np.expm1(-z * (2.0 * np.pi - angle) / b)
        return np.asarray(lost - 2.0 * np.sin(0.5 * angle) ** 2 + z / b * np.sin(angle))

    angle = bisect(short_of_contact, np.zeros_like(z), np.full_like(z, np.pi))
    with np.errstate(over="ignore"):
        kappa = np.exp(z * (2.0 * np.pi - angle) / b) * np.sin(angle) / b
    return np.where(between, kappa, np.where(zeta >= 1, np.inf, np.where(zeta == 0, 0.0, np.nan)))


def critical_speed(
    mass: ArrayLike, stiffness: ArrayLike, damping: ArrayLike, normal_load: ArrayLike, mu_static: ArrayLike,
    mu_kinetic: ArrayLike,
) -> Floats:  # fmt: skip
    """Belt speed (m/s) from which there is no stick-slip: (mu_static - mu_kinetic) N/(kappa_c sqrt(k m)), exactly.

    inf without damper, 0 from critical damping on, and 0 where friction does not drop (mu_static <= mu_kinetic): no
    belt speed has stick-slip then.
    """
    m, k, c, load, static, kinetic = floats(mass, stiffness, damping, normal_load, mu_static, mu_kinetic)
    impedance = np.sqrt(k * m)
    return _speed_of_drop((static - kinetic) * load, impedance * critical_strength(c / (2.0 * impedance)))


def critical_speed_lightly_damped(
    mass: ArrayLike, stiffness: ArrayLike, damping: ArrayLike, normal_load: ArrayLike, mu_static: ArrayLike,
    mu_kinetic: ArrayLike,
) -> Floats:  # fmt: skip
    """The classical approximation of `critical_speed` (m/s): dF/sqrt(4 pi zeta k m), dF = (mu_static - mu_kinetic) N.

    The limit of light damping; too high otherwise, by 3 % at zeta = 0.01 and by 15 % at 0.05.
    """
    m, k, c, load, static, kinetic = floats(mass, stiffness, damping, normal_load, mu_static, mu_kinetic)
    resistance = np.sqrt(2.0 * np.pi * c * np.sqrt(k * m))  # 2 zeta k m = c sqrt(k m)
    return _speed_of_drop((static - kinetic) * load, resistance)


def _speed_of_drop(drop: Floats, resistance: Floats) -> Floats:
    """A drop of friction (N) over what resists it (N s/m); 0 without a drop, even where nothing resists."""
    with np.errstate(divide="ignore", invalid="ignore"):
        speed = drop / resistance
    return np.where((drop <= 0) & (resistance >= 0), 0.0, speed)


class _Free:
    """Free damped vibration q'' + 2 zeta q' + q = 0 from q and q' at time 0; arrays, 0 <= zeta < 1."""

    def __init__(self, zeta: Floats, q: Floats, rate: Floats) -> None:
        self._zeta, self._q, self._rate = zeta, q, rate
        self._b = np.sqrt((1.0 - zeta) * (1.0 + zeta))
        self._sine = (rate + zeta * q) / self._b
        self.half_period = np.pi / self._b

    def __call__(self, time: Floats) -> Floats:
        turn = self._b * time
        return np.asarray(np.exp(-self._zeta * time) * (self._q * np.cos(turn) + self._sine * np.sin(turn)))

    def derivative(self) -> _Free:
        """The rate of change, which is such a vibration too."""
        return _Free(self._zeta, self._rate, -2.0 * self._zeta * self._rate - self._q)

    def first_zero(self) -> Floats:
        """When it first passes through zero, in (0, half_period]."""
        angle = np.arctan2(-self._q, self._sine)
        return np.asarray(np.where(angle <= 0, angle + np.pi, angle) / self._b)


def _slip_angle(kappa: Floats, zeta: Floats) -> Floats:
    """Slip time in units of sqrt(m/k), where there is stick-slip (kappa > kappa_c)."""
    velocity = _Free(zeta, np.ones_like(kappa), -kappa)
    lowest = velocity.derivative().first_zero()  # from here to half a period later the mass only speeds up
    caught_up = bisect(lambda s: 1.0 - velocity(s), lowest, lowest + velocity.half_period)
    return np.where(zeta == 0, 2.0 * (np.pi - np.arctan(kappa)), caught_up)


# --- static friction that grows with the logarithm of the time in contact: mu_s(t) = mu0 + beta log10(1 + t/t0) -------


def static_friction(time: ArrayLike, mu0: ArrayLike, beta: ArrayLike, t0: ArrayLike) -> Floats:
    """Static friction coefficient after `time` (s) in contact; beta per decade, t0 (s) > 0 where the growth sets in."""
    t, mu0, beta, t0 = floats(time, mu0, beta, t0)
    return np.asarray(mu0 + beta * np.log1p(t / t0) / np.log(10.0))


def breakaway_time(
    force: ArrayLike, rate: ArrayLike, normal_load: ArrayLike, mu0: ArrayLike, beta: ArrayLike, t0: ArrayLike
) -> Floats:
    """Time (s) from the beginning of contact until a contact loaded at a constant rate breaks away.

    force : N, of spring and damper together, when contact begins. rate : N/s at which it grows (k v_belt), of either
    sign; the limit is the same both ways. mu0, beta >= 0, t0 > 0 : see `static_friction`.

    The first t >= 0 from which force + rate t > N mu_s(t): 0 if the force exceeds the limit from the start, inf if it
    is below and does not grow. If it is equal at the start while the limit grows faster, that is no break-away: the
    contact holds until the load catches up. With A = N beta/ln 10, B = rate t0 and D = (force - N mu0 - B)/A the time
    is t0 (-(A/B) W(-(B/A) e^D) - 1) on the branch W_-1; on W_0 lies the crossing that does not count.
    """
    f, r, load, mu, aged, onset = np.broadcast_arrays(*floats(force, rate, normal_load, mu0, beta, t0))
    f, r = np.where(r < 0, -f, f), np.abs(r)
    margin = load * mu - f  # what the contact can still bear
    growth = load * aged / np.log(10.0)
    slips = (margin < 0) | (f < -load * mu)
    solvable = ~slips & (r > 0) & (growth > 0)
    a, rising, left = (np.where(solvable, v, 1.0) for v in (growth, r, margin))
    # From where the margin begins to fall to where it is used up for certain, since ln(1 + s) <= sqrt(s).
    start, root = np.maximum(a / rising - onset, 0.0), a / np.sqrt(onset)
    end = np.maximum(start, ((root + np.sqrt(root**2 + 4.0 * rising * left)) / (2.0 * rising)) ** 2)
    curved = bisect(lambda t: left + a * np.log1p(t / onset) - rising * t, start, end)
    with np.errstate(divide="ignore", invalid="ignore"):
        straight = np.where(margin > 0, margin / r, np.where(r > 0, 0.0, np.inf))
    return np.where(slips, 0.0, np.where(solvable, curved, straight))


# --- contacts with memory in steady sliding ---------------------------------------------------------------------------

# An inner state follows the slip at a rate r. Friction then has two slopes over the slip speed: E at once, the state
# being what it was, and S in steady sliding, the damper in both. Small motions go with e^(st),
#
#     m s^3 + (m r + E) s^2 + (k + r S) s + k r = 0.
#
# J. R. Rice, A. L. Ruina, Stability of steady frictional slipping, J. Appl. Mech. 50 (1983) 343.


class Slopes(NamedTuple):
    """Slopes of the force on the mass over the slip speed, at once and in steady sliding (N s/m); the rate r (1/s)."""

    at_once: Floats
    steady: Floats
    rate: Floats


class SmallMotions(NamedTuple):
    """The slowest to decay of the small motions about steady sliding: growth (1/s), and angular frequency (1/s)."""

    growth: Floats
    frequency: Floats

    @property
    def damping_ratio(self) -> Floats:
        """Decay over the distance of the root from zero."""
        return np.asarray(-self.growth / np.hypot(self.growth, self.frequency))


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
