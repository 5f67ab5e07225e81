"""Measured friction over slip speed, fitted by the Stribeck curve S(w) = a1 + a2 w + a3 exp(-w/a4), Eq. (2)."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import ArrayLike
from scipy import stats  # type: ignore[import-untyped]
from scipy.optimize import least_squares, nnls  # type: ignore[import-untyped]

from stickslip.fit.uncertainty import Floats, Interval, covariance, points_of, r_squared, rms, run_score, student
from stickslip.theory import stribeck

COEFFICIENTS = ("a1", "a2", "a3", "a4")

_FEWEST = 4  # distinct speeds; as many as coefficients
_TRIED = 80  # values of a4 tried for a start
_STARTS = 4  # of those, how many are followed to the bottom
_SHARE = 0.5  # of the mean friction: a coefficient that moves the curve by more, within its interval, is not known
_SYSTEMATIC = -3.0  # standard deviations of the number of runs; one random sample in 700 goes below
_CERTAIN = 0.99  # confidence with which a declining branch must be seen
_ROUNDING = 1e-9  # of the friction: smaller residuals are none
_VISIBLE = 0.01  # of the span of the points: smaller residuals do no harm, however regular they are


@dataclass(frozen=True)
class CurveFit:
    """A Stribeck curve through measured points, in SI.

    a1, a3 pure numbers, a2 s/m, a4 m/s, all >= 0.
    standard_error, interval : by name, of a1 to a4 and of mu_start = a1 + a3; the intervals are those of 95 %
        confidence, without their negative part. inf where the points determine nothing.
    covariance : (4, 4), in the order a1 to a4.
    residual_rms : of mu. r_squared : explained share of the variance of mu, NaN if mu does not vary.
    unidentified : coefficients that the points do not determine.
    good : whether the curve may be used without a second thought. quality : why, or why not, in plain words.
    """

    a1: float
    a2: float
    a3: float
    a4: float
    standard_error: Mapping[str, float]
    interval: Mapping[str, Interval]
    covariance: Floats = field(repr=False)
    residual_rms: float
    r_squared: float
    points: int
    unidentified: tuple[str, ...]
    good: bool
    quality: str

    @property
    def mu_start(self) -> float:
        """Friction coefficient at break-away, a1 + a3."""
        return self.a1 + self.a3

    def coefficients(self) -> dict[str, float]:
        """a1 to a4 by name, as `evaluate` and `simulate` take them."""
        return {name: float(getattr(self, name)) for name in COEFFICIENTS}

    def predict(self, speed: ArrayLike) -> Floats:
        """Friction coefficient at slip speeds (m/s)."""
        return stribeck(speed, **self.coefficients())


def fit_curve(speed: ArrayLike, mu: ArrayLike, sigma: ArrayLike | None = None) -> CurveFit:
    """The Stribeck curve nearest to measured points, by least squares with all coefficients >= 0.

    speed : slip speeds, m/s, >= 0. mu : friction coefficients there.
    sigma : standard deviation of each mu, or one for all; None: equal, and taken from the residuals.

    For any a4 the other three follow from a linear problem, so the search for a start is one over a4 alone; what it
    finds best is polished with all four. Raises ValueError for impossible points or fewer than 4 distinct speeds.
    """
    w = points_of("speed", speed)
    y = points_of("mu", mu, w.size)
    known = sigma is not None
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
    scaled = _Scaled(w / w.max(), y / y.max(), deviation / deviation.max())
    best = scaled.fit()
    units = np.array([y.max(), y.max() / w.max(), y.max(), w.max()])
    values = best * units
    freedom = math.inf if known else float(w.size - 4)
    residuals = y - stribeck(w, *values)
    jacobian = scaled.jacobian(best) / (deviation.max() / y.max()) / units  # of the residuals over sigma
    if values[2] == 0:
        jacobian[:, 3] = 0.0
    unit_covariance = covariance(jacobian)
    chi_squared = float(np.sum((residuals / deviation) ** 2))
    variance = 1.0 if known else chi_squared / freedom if freedom > 0 else math.inf
    with np.errstate(invalid="ignore"):
        matrix = np.where(unit_covariance == 0, 0.0, unit_covariance * variance)
    matrix[np.isinf(unit_covariance)] = np.inf
    errors = dict(zip(COEFFICIENTS, map(float, np.sqrt(np.diag(matrix))), strict=True))
    certain = np.isfinite(matrix[0, 0]) and np.isfinite(matrix[2, 2])
    together = matrix[0, 0] + matrix[2, 2] + 2.0 * matrix[0, 2] if certain else math.inf
    errors["mu_start"] = math.sqrt(max(float(together), 0.0))
    estimates = dict(zip(COEFFICIENTS, map(float, values), strict=True))
    estimates["mu_start"] = estimates["a1"] + estimates["a3"]
    reach = {name: student(freedom) * error if error > 0 else 0.0 for name, error in errors.items()}
    declines = _is_seen(scaled.gain(best), chi_squared if known else None, w.size - 4)
    judged = _Judged(estimates, reach, declines, w, y, residuals, r_squared(y, residuals, deviation**-2.0))
    findings = [*judged.findings(w.size - 4), *(_excess(chi_squared, w.size - 4) if known else ())]
    return CurveFit(
        **{name: estimates[name] for name in COEFFICIENTS},
        standard_error=errors,
        interval={name: (max(0.0, estimates[name] - r), estimates[name] + r) for name, r in reach.items()},
        covariance=matrix,
        residual_rms=rms(residuals),
        r_squared=judged.r_squared,
        points=int(w.size),
        unidentified=judged.unidentified(),
        good=not findings,
        quality=" ".join(findings) or judged.praise(),
    )


# --- the search -------------------------------------------------------------------------------------------------------


class _Scaled:
    """The points with the largest speed, friction and deviation as units, so that nothing depends on their size."""

    def __init__(self, speed: Floats, mu: Floats, deviation: Floats) -> None:
        self._u, self._weight = speed, 1.0 / deviation
        self._target = mu * self._weight
        self._limits = (0.1 * float(speed[speed > 0].min()), 50.0)  # faster decay leaves e^-10 at the first point

    def fit(self) -> Floats:
        """The best a1 to a4."""
        tried = np.geomspace(*self._limits, _TRIED)
        left = np.array([self._linear(a4)[1] for a4 in tried])
        before, after = np.append(np.inf, left[:-1]), np.append(left[1:], np.inf)
        valleys = np.flatnonzero((left <= before) & (left <= after))
        ends = [self._polished(tried[i]) for i in valleys[np.argsort(left[valleys])][:_STARTS]]
        return min(ends, key=lambda end: end[1])[0]

    def gain(self, best: Floats) -> float:
        """How much a declining branch lowers the sum of squares, as a share of what it leaves."""
        straight = nnls(np.column_stack([np.ones_like(self._u), self._u]) * self._weight[:, None], self._target)[1] ** 2
        left = float(np.sum((stribeck(self._u, *best) * self._weight - self._target) ** 2))
        if straight <= _ROUNDING**2 * float(self._target @ self._target):
            return 0.0
        return math.inf if left == 0 else (float(straight) - left) / left

    def jacobian(self, a: Floats) -> Floats:
        """Derivatives of the curve with respect to a1 to a4, weighted; points by coefficients."""
        decay = np.exp(-self._u / a[3])
        columns = [np.ones_like(decay), self._u, decay, a[2] * decay * self._u / a[3] ** 2]
        return np.asarray(np.column_stack(columns) * self._weight[:, None])

    def _linear(self, a4: float) -> tuple[Floats, float]:
        """The best a1 to a3 for a given a4, and the norm of the residuals."""
        columns = [np.ones_like(self._u), self._u, np.exp(-self._u / a4)]
        found, norm = nnls(np.column_stack(columns) * self._weight[:, None], self._target)
        return np.append(found, a4), float(norm)

    def _polished(self, a4: float) -> tuple[Floats, float]:
        """Downhill from the best with a given a4."""
        start, _ = self._linear(a4)
        low, high = self._limits
        run = least_squares(
            lambda a: stribeck(self._u, *a) * self._weight - self._target,
            start,
            jac=self.jacobian,
            bounds=([0.0, 0.0, 0.0, low * 0.999], [np.inf, np.inf, np.inf, high * 1.001]),
            x_scale=[1.0, 1.0, 1.0, a4],
            ftol=1e-14,
            xtol=1e-12,
            gtol=1e-14,
            max_nfev=200,
        )
        return self._linear(float(run.x[3]))  # a coefficient at its bound is 0, not almost


# --- the verdict ------------------------------------------------------------------------------------------------------


@dataclass(frozen=True)
class _Judged:
    """A fit and what is known of it.

    reach : half widths of the confidence intervals. declines : whether a declining branch is seen.
    """

    estimates: Mapping[str, float]
    reach: Mapping[str, float]
    declines: bool
    speed: Floats
    mu: Floats
    residuals: Floats
    r_squared: float

    def unidentified(self) -> tuple[str, ...]:
        """Coefficients that the points do not determine."""
        allowed = _SHARE * float(self.mu.mean())
        effect = {"a1": self.reach["a1"], "a2": self.reach["a2"] * float(self.speed.max())}
        unknown = {name for name, moved in effect.items() if not moved < allowed}
        unknown |= {name for name in ("a3", "a4") if not self.reach[name] < self.estimates[name]}
        if not self.declines:
            unknown |= {"a3", "a4"}
        return tuple(name for name in COEFFICIENTS if name in unknown)

    def findings(self, freedom: int) -> Iterator[str]:
        """What speaks against using the curve."""
        slowest, fastest = float(self.speed.min()), float(self.speed.max())
        a4 = self.estimates["a4"]
        unknown = self.unidentified()
        if freedom <= 0:
            yield f"{self.speed.size} points for four coefficients leave nothing to judge the fit by: measure more."
        elif not self.declines:
            yield (
                f"The points show no declining branch between {slowest:.3g} and {fastest:.3g} m/s, so a3 and a4 mean "
                "nothing: use a3 = 0, or measure slower if the friction is known to fall."
            )
        elif slowest > a4:
            yield (
                f"The slowest point, at {slowest:.3g} m/s, is {slowest / a4:.3g} times a4: the decline is over before "
                f"the points begin, and mu_start = {self.estimates['mu_start']:.3g} is extrapolated. Measure slower."
            )
        elif unknown:
            beyond = f" The decline does not end before {fastest:.3g} m/s: measure faster." if fastest < 2 * a4 else ""
            yield f"The points do not determine {' and '.join(unknown)}.{beyond}"
        if self.declines and self.r_squared < 0.5:
            yield f"The curve explains only {100 * self.r_squared:.0f} % of the variance of the points."
        harmless = max(_VISIBLE * float(np.ptp(self.mu)), _ROUNDING * float(self.mu.max()))
        if rms(self.residuals) > harmless and run_score(self._in_order()) < _SYSTEMATIC:
            yield "The residuals change sign too seldom along the speed: the points follow a curve of another shape."

    def praise(self) -> str:
        """What a good fit is told."""
        return (
            f"The curve explains {100 * self.r_squared:.3g} % of the variance of {self.speed.size} points, "
            f"with a residual rms of {rms(self.residuals):.2g}, and they determine all four coefficients."
        )

    def _in_order(self) -> Floats:
        """One residual per speed, the mean of repetitions, from slow to fast."""
        _, group = np.unique(self.speed, return_inverse=True)
        return np.asarray(np.bincount(group, self.residuals) / np.bincount(group))


def _is_seen(gain: float, chi_squared: float | None, freedom: int) -> bool:
    """Whether the two coefficients of the declining branch lower the sum of squares by more than chance does.

    gain : see `_Scaled.gain`. chi_squared : of the whole curve, where sigma is known. freedom : points left over.
    """
    if chi_squared is not None and chi_squared > 0:
        return gain * chi_squared > float(stats.chi2(2).ppf(_CERTAIN))
    return freedom > 0 and gain * freedom / 2.0 > float(stats.f(2, freedom).ppf(_CERTAIN))


def _excess(chi_squared: float, freedom: int) -> Iterator[str]:
    """Residuals that the standard deviations given do not explain, in fewer than one of a thousand samples."""
    if freedom > 0 and stats.chi2(freedom).sf(chi_squared) < 1e-3:
        times = math.sqrt(chi_squared / freedom)
        yield f"The residuals are {times:.2g} times sigma: the points follow another curve, or sigma is too small."
