"""Static friction that grows with the logarithm of the time in contact, mu_s(t) = mu0 + beta log10(1 + t/t0)."""

import numpy as np
import scipy  # type: ignore[import-untyped]
from numpy.typing import ArrayLike

from stickslip.theory.numerics import Floats, floats

_SMALLEST_EXPONENT = 700.0  # e^-700 is still a normal number
_POLISHING = 4  # Newton steps; one is enough but near a double root


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
    a, b, left = (np.where(solvable, v, 1.0) for v in (growth, r * onset, margin))
    late = _outer_root(left / a, b / a)
    curved = _polished(onset * late, left, a, np.where(solvable, r, 1.0), onset)
    with np.errstate(divide="ignore", invalid="ignore"):
        straight = np.where(margin > 0, margin / r, np.where(r > 0, 0.0, np.inf))
    return np.where(slips, 0.0, np.where(solvable, curved, straight))


def _outer_root(margin: Floats, ratio: Floats) -> Floats:
    """s = t/t0 >= 0 with margin + ln(1 + s) = ratio s, the larger one of two: the branch W_-1 of Lambert's function.

    margin >= 0, ratio > 0. With y = ratio (1 + s) it is y - ln y = margin + ratio - ln ratio, y >= 1, which stands for
    y = -W_-1(-e^-(...)) also where that power is too small for a double (weak ageing) or y too close to 1.
    """
    excess = margin + (ratio - 1.0) - np.log1p(ratio - 1.0)  # over y = 1, where the two branches meet
    p = np.sqrt(2.0 * excess)
    close = p + p**2 / 3.0 + 11.0 / 72.0 * p**3
    middle = -np.real(scipy.special.lambertw(-np.exp(-1.0 - np.minimum(excess, _SMALLEST_EXPONENT)), -1)) - 1.0
    far = excess
    for _ in range(_POLISHING):
        far = excess + np.log1p(far)  # gains almost three digits a turn
    above = np.select([excess < 1e-6, excess < _SMALLEST_EXPONENT], [close, middle], far)  # y - 1
    return np.asarray(np.maximum((above + 1.0 - ratio) / ratio, 0.0))


def _polished(time: Floats, margin: Floats, growth: Floats, rate: Floats, t0: Floats) -> Floats:
    """Newton on margin + growth ln(1 + t/t0) - rate t, whose terms lose no digits where t is much shorter than t0."""
    for _ in range(_POLISHING):
        rest = margin + growth * np.log1p(time / t0) - rate * time
        slope = (growth - rate * t0 - rate * time) / (t0 + time)
        step = np.divide(rest, slope, out=np.zeros_like(time), where=slope < 0)
        time = np.maximum(time - step, 0.0)
    return time
