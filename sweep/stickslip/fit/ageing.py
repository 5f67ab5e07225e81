"""Measured static friction over waiting time, fitted by mu_s(t) = mu0 + beta log10(1 + t/t0); lubricants in order."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import ArrayLike
from scipy import stats  # type: ignore[import-untyped]
from scipy.optimize import brentq, minimize_scalar  # type: ignore[import-untyped]

from stickslip.fit.uncertainty import CONFIDENCE, Floats, Interval, covariance, points_of, r_squared, rms, student
from stickslip.theory import static_friction

_FEWEST = 3  # distinct waiting times; with two, nothing is left to judge the line by
_BEYOND = 1e6  # how far outside the waiting times t0 is looked for
_TRIED = 121
_ASSUMED = 0.1  # of the shortest waiting time: the t0 taken where all are long against it


@dataclass(frozen=True)
class AgeingFit:
    """How static friction grows with waiting time, in SI: mu0 at time zero, beta per decade, t0 in s.

    standard_error, interval : by name; the intervals are those of 95 % confidence. That of t0 is (0, x) where nothing
        but an upper limit can be told, and without width where t0 was given.
    t0_assumed : the points do not determine t0, and mu0 and beta are those for the t0 that was taken.
    covariance : (2, 2) of mu0 and beta. freedom : of their t distribution.
    good : whether the points show ageing of this kind. quality : what they show, in plain words.
    """

    mu0: float
    beta: float
    t0: float
    standard_error: Mapping[str, float]
    interval: Mapping[str, Interval]
    covariance: Floats = field(repr=False)
    freedom: int
    residual_rms: float
    r_squared: float
    points: int
    t0_assumed: bool
    good: bool
    quality: str

    def predict(self, time: ArrayLike) -> Floats:
        """Static friction coefficient after waiting times (s)."""
        return static_friction(time, self.mu0, self.beta, self.t0)

    def level_error(self, at: float) -> float:
        """Standard error of `predict` at one waiting time (s), for the t0 of the fit."""
        direction = np.array([1.0, math.log1p(at / self.t0) / math.log(10.0)])
        return float(np.sqrt(max(direction @ self.covariance @ direction, 0.0)))


def fit_ageing(time: ArrayLike, mu: ArrayLike, t0: float | None = None) -> AgeingFit:
    """Growth of static friction with the logarithm of waiting time, by least squares.

    time : s, >= 0. mu : static friction coefficients measured after these times; repetitions count.
    t0 : s, where it is known; None looks for it. Usually all waiting times are long against t0, and then the points
        cannot tell it: a smaller t0 with a smaller mu0 fits as well. It is then taken as a tenth of the shortest
        waiting time (`t0_assumed`), which `quality` says; what the fit says between the points measured hardly changes.

    Raises ValueError for impossible points or fewer than 3 distinct waiting times.
    """
    t = points_of("time", time)
    y = points_of("mu", mu, t.size)
    if t0 is not None and not (math.isfinite(t0) and t0 > 0):
        raise ValueError(f"t0: got {t0!r}, expected a time > 0 (s)")
    count = np.unique(t).size
    if count < _FEWEST:
        raise ValueError(
            f"time: got {count} distinct waiting time{'s' * (count != 1)}, expected at least {_FEWEST}: "
            "fewer do not allow the growth to be assessed"
        )
    if t0 is not None:
        return _fit_at(t, y, float(t0), (float(t0), float(t0)))
    best, (low, high) = _search(t, y)
    if low > 0 and math.isfinite(high):
        return _fit_at(t, y, best, (low, high), free=True)
    taken = low if low > 0 else min(_ASSUMED * float(t[t > 0].min()), high)
    return _fit_at(t, y, taken, (low, high), assumed=True)


def _fit_at(t: Floats, y: Floats, t0: float, limits: Interval, free: bool = False, assumed: bool = False) -> AgeingFit:
    """The straight line over log10(1 + t/t0) and its quality.

    limits : confidence interval of t0. free : t0 was fitted too, so its uncertainty is in that of the others.
    """
    line, residuals = _line(t, y, t0)
    mu0, beta = map(float, line)
    freedom = t.size - (3 if free else 2)
    jacobian = _design(t, t0)
    if free:
        jacobian = np.column_stack([jacobian, -beta * t / (t0 + t) / math.log(10.0)])  # by ln t0
    matrix = covariance(jacobian) * float(residuals @ residuals) / freedom
    errors = [float(error) for error in np.sqrt(np.diag(matrix))]
    reach = [student(freedom) * error for error in errors]
    intervals = {"mu0": _around(mu0, reach[0]), "beta": _around(beta, reach[1]), "t0": limits}
    error_of_t0 = t0 * errors[2] if free else math.nan if assumed else 0.0
    explained = r_squared(y, residuals, np.ones_like(y))
    against = [*_against(intervals["beta"], explained), *(_straight(limits) if assumed else ())]
    remarks = [_about_t0(t, t0, limits)] if assumed else []
    praise = f"Static friction grows by {beta:.3g} per decade of waiting time; residual rms {rms(residuals):.2g}."
    return AgeingFit(
        mu0=mu0,
        beta=beta,
        t0=t0,
        standard_error={"mu0": errors[0], "beta": errors[1], "t0": error_of_t0},
        interval=intervals,
        covariance=matrix[:2, :2],
        freedom=freedom,
        residual_rms=rms(residuals),
        r_squared=explained,
        points=int(t.size),
        t0_assumed=assumed,
        good=not against,
        quality=" ".join([*(against or (praise,)), *remarks]),
    )


def _around(value: float, reach: float) -> Interval:
    return value - reach, value + reach


def _against(beta: Interval, explained: float) -> Iterator[str]:
    """What speaks against ageing of this kind."""
    if beta[1] < 0:
        yield "Static friction falls with waiting time: this is not ageing."
    elif not beta[0] > 0:
        yield f"The points show no ageing: the slope may be anything from {beta[0]:.2g} to {beta[1]:.2g} per decade."
    elif explained < 0.5:
        yield f"The growth explains only {100 * explained:.0f} % of the variance of the points."


def _straight(limits: Interval) -> Iterator[str]:
    """Growth in proportion to time, which is what the law is long before t0."""
    if limits[0] > 0 and math.isinf(limits[1]):
        yield (
            f"As far as measured, static friction grows in proportion to time (t0 above {limits[0]:.2g} s): "
            "beta and t0 cannot be distinguished. Measure at longer waiting times."
        )


def _about_t0(t: Floats, t0: float, limits: Interval) -> str:
    """What is said where the points do not determine t0."""
    low, high = limits
    if low > 0:
        return f"t0 is taken as {t0:.3g} s."
    shortest = float(t[t > 0].min())
    upper = "any" if math.isinf(high) else f"any below {high:.2g} s"
    said = f"The waiting times, of {shortest:.3g} s and more, do not determine t0"
    return f"{said} ({upper} fits as well): taken as {t0:.3g} s."


# --- the search for t0 ------------------------------------------------------------------------------------------------


def _design(t: Floats, t0: float) -> Floats:
    return np.column_stack([np.ones_like(t), np.log1p(t / t0) / math.log(10.0)])


def _line(t: Floats, y: Floats, t0: float) -> tuple[Floats, Floats]:
    """mu0 and beta for a given t0, and the residuals."""
    design = _design(t, t0)
    scale = np.array([1.0, np.abs(design[:, 1]).max()])
    found = np.linalg.lstsq(design / scale, y, rcond=None)[0] / scale
    return np.asarray(found), np.asarray(y - design @ found)


def _search(t: Floats, y: Floats) -> tuple[float, Interval]:
    """The best t0 and its 95 % confidence interval: where the sum of squares is not significantly above its smallest.

    The ends are 0 and inf where it never is.
    """

    def left(log_t0: float) -> float:
        residuals = _line(t, y, math.exp(log_t0))[1]
        return float(residuals @ residuals)

    tried = np.linspace(math.log(t[t > 0].min() / _BEYOND), math.log(t.max() * _BEYOND), _TRIED)
    sums = np.array([left(x) for x in tried])
    i = int(np.argmin(sums))
    around = (tried[max(i - 1, 0)], tried[min(i + 1, _TRIED - 1)])
    best = float(minimize_scalar(left, bounds=around, method="bounded", options={"xatol": 1e-10}).x)
    freedom = t.size - 3
    if freedom <= 0:
        return math.exp(best), (0.0, math.inf)
    rounding = 1e-26 * float(y @ y)
    allowed = left(best) * (1.0 + float(stats.f(1, freedom).ppf(CONFIDENCE)) / freedom) + rounding
    low = _border(left, allowed, best, tried[: i + 1][::-1])
    high = _border(left, allowed, best, tried[i:])
    return math.exp(best), (0.0 if low is None else math.exp(low), math.inf if high is None else math.exp(high))


def _border(left: Callable[[float], float], allowed: float, best: float, outward: Floats) -> float | None:
    """Where the sum of squares first exceeds what is allowed, going outward; None if it never does."""
    inside = best
    for x in outward[1:]:
        if left(x) > allowed:
            return float(brentq(lambda at: left(at) - allowed, inside, x)) if left(inside) < allowed else inside
        inside = float(x)
    return None


# --- lubricants in order ----------------------------------------------------------------------------------------------


@dataclass(frozen=True)
class Rank:
    """One lubricant in an order.

    apart : whether it differs from the one before it at 95 % confidence; True for the first.
    """

    name: str
    value: float
    interval: Interval
    apart: bool


@dataclass(frozen=True)
class Ranking:
    """Lubricants from best to worst, by static friction after a waiting time of `at` s and by its growth per decade."""

    at: float
    by_level: tuple[Rank, ...]
    by_slope: tuple[Rank, ...]


def rank(fits: Mapping[str, AgeingFit], at: float) -> Ranking:
    """Order lubricants by level and by slope, the lowest first: the best has the lowest of both.

    fits : by the name of the lubricant, at least one. at : waiting time (s) at which levels are compared.
    """
    if not fits:
        raise ValueError("fits: got none, expected at least one")
    if not (math.isfinite(at) and at >= 0):
        raise ValueError(f"at: got {at!r}, expected a waiting time >= 0 (s)")
    levels = {name: (float(fit.predict(at)), fit.level_error(at), fit.freedom) for name, fit in fits.items()}
    slopes = {name: (fit.beta, fit.standard_error["beta"], fit.freedom) for name, fit in fits.items()}
    return Ranking(float(at), _ordered(levels), _ordered(slopes))


def _ordered(measured: Mapping[str, tuple[float, float, int]]) -> tuple[Rank, ...]:
    """Names by value; each as value, standard error and degrees of freedom."""
    ranks: list[Rank] = []
    before: tuple[float, float, int] | None = None
    for name, this in sorted(measured.items(), key=lambda item: item[1][0]):
        value, error, freedom = this
        apart = before is None or _differ(before, this)
        ranks.append(Rank(name, value, _around(value, student(freedom) * error), apart))
        before = this
    return tuple(ranks)


def _differ(one: tuple[float, float, int], other: tuple[float, float, int]) -> bool:
    """Welch's test of two values with standard errors, at 95 % confidence."""
    (x, ex, nx), (y, ey, ny) = one, other
    variance = ex**2 + ey**2
    if not math.isfinite(variance):
        return False
    if variance == 0:
        return x != y
    freedom = variance**2 / (ex**4 / nx + ey**4 / ny)
    return abs(x - y) > student(freedom) * math.sqrt(variance)
