"""Measured friction over slip speed, fitted by the Stribeck curve S(w) = a1 + a2 w + a3 exp(-w/a4), Eq. (2)."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from stickslip.fit.forms import COEFFICIENTS, FALLING, STRENGTHENING, WEAKENING, Form, ScaledPoints
from stickslip.fit.uncertainty import Floats, Interval, covariance, points_of, r_squared, rms, student
from stickslip.fit.verdict import Verdict, excess, falls, is_seen
from stickslip.theory import stribeck, stribeck_slope

_FEWEST = 4  # distinct speeds; as many as coefficients
_AT_END = 0.01  # share of a4 within which it is at the end of the range that was searched


@dataclass(frozen=True)
class CurveFit:
    """A Stribeck curve through measured points, in SI.

    a1, a3 pure numbers, a2 s/m, a4 m/s; all >= 0, except where friction rises from zero speed: there a3 < 0, and a2 may
    be.
    standard_error, interval : by name, of a1 to a4 and of mu_start = a1 + a3; the intervals are those of 95 %
        confidence, without the part below a bound at 0. inf where the points determine nothing.
    covariance : (4, 4), in the order a1 to a4. freedom : of their t distribution, inf where sigma was given.
    speeds : the slowest and the fastest point, m/s. searched : between which a4 was looked for, m/s.
    residual_rms : of mu. r_squared : explained share of the variance of mu, NaN if mu does not vary.
    unidentified : coefficients that the points do not determine. assumed : those of them that were taken as 0.
    at_bound : those (and mu_start) that the points would have beyond their bound.
    good : whether the curve may be used without reservation. quality : why, or why not, in plain words.
    """

    a1: float
    a2: float
    a3: float
    a4: float
    standard_error: Mapping[str, float]
    interval: Mapping[str, Interval]
    covariance: Floats = field(repr=False)
    freedom: float
    speeds: Interval
    searched: Interval
    residual_rms: float
    r_squared: float
    points: int
    unidentified: tuple[str, ...]
    assumed: tuple[str, ...]
    at_bound: tuple[str, ...]
    good: bool
    quality: str

    @property
    def mu_start(self) -> float:
        """Friction coefficient at break-away, a1 + a3."""
        return self.a1 + self.a3

    @property
    def determined(self) -> bool:
        """Whether the points tell where vibration ends; a material whose points do not is not ranked."""
        return self.freedom > 0

    def coefficients(self) -> dict[str, float]:
        """a1 to a4 by name, as `evaluate` and `simulate` take them."""
        return {name: float(getattr(self, name)) for name in COEFFICIENTS}

    def predict(self, speed: ArrayLike) -> Floats:
        """Friction coefficient at slip speeds (m/s)."""
        return stribeck(speed, **self.coefficients())

    def free_covariance(self) -> Floats:
        """`covariance` with those coefficients fixed that were assumed."""
        fixed = np.array([name in self.assumed for name in COEFFICIENTS])
        return np.where(fixed[:, None] | fixed, 0.0, self.covariance)

    def band(self, speed: ArrayLike) -> tuple[Floats, Floats]:
        """Lower and upper end of the 95 % confidence band of the curve at slip speeds (m/s); infinite where the points
        determine nothing. To first order in the coefficients, not below 0, and for those that were assumed as they are.
        """
        w = np.asarray(speed, np.float64)
        decay = np.exp(-w / self.a4)
        slopes = np.stack([np.ones_like(w), w, decay, self.a3 * w / self.a4**2 * decay], axis=-1)
        covariance = self.free_covariance()
        known = np.isfinite(np.diag(covariance))
        matrix = np.where(np.outer(known, known), covariance, 0.0)
        error = np.sqrt(np.maximum(np.einsum("...i,ij,...j->...", slopes, matrix, slopes), 0.0))
        reach = np.where((slopes[..., ~known] != 0).any(axis=-1), np.inf, 0.0)
        reach = reach + (student(self.freedom) * error if error.any() else error)
        middle = self.predict(w)
        return np.maximum(middle - reach, 0.0), middle + reach


def fit_curve(speed: ArrayLike, mu: ArrayLike, sigma: ArrayLike | None = None, *, unit: str = "m/s") -> CurveFit:
    """The Stribeck curve nearest to measured points, by least squares.

    speed : slip speeds, m/s, >= 0. mu : friction coefficients there.
    sigma : standard deviation of each mu, or one for all; None: equal, and taken from the residuals.
    unit : in which `quality` tells speeds.

    All coefficients are >= 0 where the points show a declining branch. Where they fall all the way but do not determine
    four coefficients, a2 is taken as 0; where they show a rise from zero speed instead, a3 < 0. Raises ValueError for
    impossible points or fewer than 4 distinct speeds.
    """
    w = points_of("speed", speed)
    y = points_of("mu", mu, w.size)
    deviation = points_of("sigma", np.broadcast_to(np.asarray(1.0 if sigma is None else sigma), w.shape), w.size)
    if not deviation.all():
        raise ValueError(f"sigma[{int(np.argmin(deviation))}]: got 0, expected a standard deviation > 0")
    distinct = np.unique(w)
    if distinct.size < _FEWEST:
        raise ValueError(
            f"speed: got {distinct.size} distinct speed{'s' * (distinct.size != 1)}, expected at least {_FEWEST}: "
            "fewer cannot determine the four coefficients of the curve"
        )
    if not y.any():
        raise ValueError("mu: got nothing but 0, expected friction coefficients")
    known = sigma is not None
    chosen = _choose(w, y, deviation, known)
    form, values = chosen.form, chosen.values
    spare = w.size - 4 + len(form.assumed)
    freedom = math.inf if known else float(spare)
    residuals = y - stribeck(w, *values)
    chi_squared = float(np.sum((residuals / deviation) ** 2))
    variance = 1.0 if known else chi_squared / freedom if freedom > 0 else math.inf
    matrix = _covariance(chosen, variance)
    errors = _errors(matrix)
    estimates = dict(zip(COEFFICIENTS, map(float, values), strict=True))
    estimates["mu_start"] = estimates["a1"] + estimates["a3"]
    reach = {name: student(freedom) * error if error > 0 else 0.0 for name, error in errors.items()}
    share = r_squared(y, residuals, deviation**-2.0)
    at_bound = _at_bound(estimates, chosen)
    verdict = Verdict(form, chosen.seen, estimates, reach, at_bound, w, y, residuals, share, spare, unit)
    findings = [*verdict.findings(), *(excess(chi_squared, spare) if known else ())]
    return CurveFit(
        **{name: estimates[name] for name in COEFFICIENTS},
        standard_error=errors,
        interval={
            name: _interval(estimates[name], r, name in (*form.nonnegative, "mu_start")) for name, r in reach.items()
        },
        covariance=matrix,
        freedom=freedom,
        speeds=(float(w.min()), float(w.max())),
        searched=chosen.ends,
        residual_rms=rms(residuals),
        r_squared=share,
        points=int(w.size),
        unidentified=verdict.unidentified(),
        assumed=form.assumed,
        at_bound=at_bound,
        good=not findings,
        quality=" ".join(findings) or verdict.praise(),
    )


# --- which form -------------------------------------------------------------------------------------------------------


class _Chosen(NamedTuple):
    """A form and its best curve, in SI.

    seen : whether the points show its branch. jacobian : of the residuals over sigma by a1 to a4, 0 where one is not
    free. ends : between which a4 was searched, m/s.
    """

    form: Form
    seen: bool
    values: Floats
    jacobian: Floats
    ends: tuple[float, float]


def _choose(w: Floats, y: Floats, deviation: Floats, known: bool) -> _Chosen:
    """The form that the points ask for: weakening, unless they show none; then strengthening, falling, or no branch."""
    points = ScaledPoints(w / w.max(), y / y.max(), deviation / deviation.max())
    in_sigma = y.max() / deviation.max()

    def seen(best: Floats, falling: bool = False) -> bool:
        chi_squared = points.left(best) * in_sigma**2 if known else None
        return is_seen(points.gain(best, falling), chi_squared, w.size - 4)

    def chosen(form: Form, best: Floats, seen: bool) -> _Chosen:
        units = np.array([y.max(), y.max() / w.max(), y.max(), w.max()])
        jacobian = points.jacobian(best) * in_sigma / units
        fixed = [name in form.assumed or (name == "a4" and best[2] == 0) for name in COEFFICIENTS]
        low, high = (end * float(w.max()) for end in points.limits)
        return _Chosen(form, seen, best * units, np.where(fixed, 0.0, jacobian), (low, high))

    weak = points.fit(WEAKENING)
    if seen(weak):
        return chosen(WEAKENING, weak, True)
    rise = points.fit(STRENGTHENING)
    if rise[2] < 0 < stribeck_slope(w.min() / w.max(), *rise[1:]) and seen(rise, falling=True):
        return chosen(STRENGTHENING, rise, True)
    if falls(w, y) and (fall := points.fit(FALLING))[2] > 0:
        return chosen(FALLING, fall, True)
    return chosen(WEAKENING, weak, False)


# --- how well it is known ---------------------------------------------------------------------------------------------


def _covariance(chosen: _Chosen, variance: float) -> Floats:
    """Of a1 to a4; inf on the diagonal where the points determine nothing."""
    unit = covariance(chosen.jacobian)
    with np.errstate(invalid="ignore"):
        matrix = np.where(unit == 0, 0.0, unit * variance)
    matrix[np.isinf(unit)] = np.inf
    return matrix


def _errors(matrix: Floats) -> dict[str, float]:
    """Standard errors of a1 to a4 and of their sum mu_start."""
    errors = dict(zip(COEFFICIENTS, map(float, np.sqrt(np.diag(matrix))), strict=True))
    certain = np.isfinite(matrix[0, 0]) and np.isfinite(matrix[2, 2])
    together = matrix[0, 0] + matrix[2, 2] + 2.0 * matrix[0, 2] if certain else math.inf
    errors["mu_start"] = math.sqrt(max(float(together), 0.0))
    return errors


def _interval(value: float, reach: float, nonnegative: bool) -> Interval:
    return (max(0.0, value - reach) if nonnegative else value - reach, value + reach)


def _at_bound(estimates: Mapping[str, float], chosen: _Chosen) -> tuple[str, ...]:
    """Estimates, mu_start among them, at the end of the range that was allowed."""
    bounded = [name for name in (*COEFFICIENTS[:3], "mu_start") if name not in chosen.form.assumed]
    floor = {*chosen.form.nonnegative, "mu_start"}
    found = [name for name in bounded if name in floor and estimates[name] == 0.0]
    low, high = chosen.ends
    if not low * (1 + _AT_END) < estimates["a4"] < high * (1 - _AT_END):
        found.append("a4")
    return tuple(found)
