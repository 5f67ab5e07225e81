"""Measured static friction over waiting time, fitted by mu_s(t) = mu0 + beta log10(1 + t/t0); lubricants in order."""

import math
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import ArrayLike

from stickslip.theory import static_friction
from stickslip_materials.fit.likelihood import Likelihood
from stickslip_materials.fit.uncertainty import (
    LEAST_EXPLAINED,
    Floats,
    Interval,
    covariance,
    points_of,
    r_squared,
    rms,
    student,
)

_LN10 = math.log(10.0)
_FEWEST = 3  # distinct waiting times; with two, nothing is left to judge the line by
_BEYOND = 1e6  # how far outside the waiting times t0 is looked for
_UNLIKELY = 0.8  # confidence at which that is left out
_ASSUMED = 0.1  # of the shortest waiting time: the t0 taken where all are long against it


@dataclass(frozen=True)
class AgeingFit:
    """Growth of static friction with waiting time, in SI: mu0 at time zero, beta per decade, t0 in s.

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
    likelihood: Likelihood | None = field(repr=False, compare=False)

    def predict(self, time: ArrayLike) -> Floats:
        """Static friction coefficient after waiting times (s)."""
        return static_friction(time, self.mu0, self.beta, self.t0)

    def level(self, at: float) -> Interval:
        """The 95 % interval of `predict` at one waiting time (s), over every t0 that the points allow; an end may be
        infinite."""
        low, high = self._within(lambda t0: np.array([1.0, math.log1p(at / t0) / _LN10]))
        is_open = self._ends_of_t0[0] == 0 and at < self.t0  # mu0 falls without end where t0 does
        return -math.inf if is_open else low, high

    def slope(self) -> Interval:
        """The 95 % interval of beta, over every t0 that the points allow."""
        low, high = self._within(lambda t0: np.array([0.0, 1.0]))
        return low, math.inf if math.isinf(self._ends_of_t0[1]) else high

    @property
    def _ends_of_t0(self) -> Interval:
        return self.likelihood.scale_interval if self.likelihood and self.freedom > 0 else (self.t0, self.t0)

    def _within(self, along: Callable[[float], Floats]) -> Interval:
        """The interval of a combination of mu0 and beta, which depends on t0."""
        row = along(self.t0)
        middle = float(row @ [self.mu0, self.beta])
        if self.likelihood is None:
            reach = student(self.freedom) * math.sqrt(max(float(row @ self.covariance @ row), 0.0))
            return middle - reach, middle + reach
        if self.freedom <= 0:
            return -math.inf, math.inf
        low, high = self.likelihood.interval(along)
        return min(low, middle), max(high, middle)


def fit_ageing(time: ArrayLike, mu: ArrayLike, t0: float | None = None) -> AgeingFit:
    """Growth of static friction with the logarithm of waiting time, by least squares.

    Parameters
    ----------
    time : (n,) s, >= 0.
    mu : (n,) static friction coefficients measured after these times; repetitions count.
    t0 : s, where it is known; None looks for it.

    Returns
    -------
    AgeingFit
        Its intervals are those of the profile likelihood: of mu0 and beta over every t0 that the points allow. Where
        all waiting times are long against t0, these tell no lower limit of it: a smaller t0 with a smaller mu0 fits as
        well. Then a tenth of the shortest waiting time is taken, unless the likeliest t0 is clearly another
        (`t0_assumed`).

    Raises
    ------
    ValueError
        For impossible points or fewer than 3 distinct waiting times.
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
    shortest, longest, spare = float(t[t > 0].min()), float(t.max()), t.size - 3

    def columns(scale: Floats) -> Floats:
        growth = np.log1p(t / scale[:, None]) / _LN10
        return np.stack([np.ones_like(growth), growth], axis=2)

    likelihood = Likelihood(
        y, np.ones_like(y), columns, (shortest / _BEYOND, longest * _BEYOND), np.eye(2), 0, float(spare), student(spare)
    )
    if t0 is not None:
        return _fit_at(likelihood, t, float(t0), None)
    low, high = likelihood.scale_interval if spare > 0 else (0.0, math.inf)
    likeliest = math.exp(likelihood.scale)
    if low > 0:
        return _fit_at(likelihood, t, low if math.isinf(high) else likeliest, (low, high))
    usual = min(_ASSUMED * shortest, high)
    least, there = (likelihood.solve(math.log(scale))[1] for scale in (likeliest, usual))
    unlikely = spare > 0 and there > least * (1.0 + student(spare, _UNLIKELY) ** 2 / spare)
    return _fit_at(likelihood, t, likeliest if unlikely and likeliest > usual else usual, (low, high))


def _fit_at(likelihood: Likelihood, t: Floats, t0: float, limits: Interval | None) -> AgeingFit:
    """The straight line over log10(1 + t/t0) and its quality. limits : of t0; None where it was given."""
    y = likelihood.target
    mu0, beta = map(float, likelihood.solve(math.log(t0))[0])
    residuals = y - static_friction(t, mu0, beta, t0)
    is_free = limits is not None and limits[0] > 0 and math.isfinite(limits[1])
    assumed = limits is not None and not is_free
    freedom = t.size - (2 if limits is None else 3)
    columns = likelihood.columns(np.array([t0]))[0]
    if is_free:
        columns = np.column_stack([columns, -beta * t / (t0 + t) / _LN10])  # by ln t0
    variance = float(residuals @ residuals) / freedom if freedom > 0 else math.inf
    matrix = covariance(columns) * variance
    errors = [*map(float, np.sqrt(np.diag(matrix))), math.nan if assumed else 0.0]  # the last of t0, unless it is free
    errors[2] *= t0 if is_free else 1.0
    fit = AgeingFit(
        mu0=mu0,
        beta=beta,
        t0=t0,
        standard_error=dict(zip(("mu0", "beta", "t0"), errors, strict=False)),
        interval={},
        covariance=matrix[:2, :2],
        freedom=freedom,
        residual_rms=rms(residuals),
        r_squared=r_squared(y, residuals, np.ones_like(y)),
        points=int(t.size),
        t0_assumed=assumed,
        good=False,
        quality="",
        likelihood=None if limits is None else likelihood,
    )
    fit = replace(fit, interval={"mu0": fit.level(0.0), "beta": fit.slope(), "t0": limits or (t0, t0)})
    reservations = [*_reservations(fit)]
    good = f"Static friction grows by {fit.beta:.3g} per decade of waiting time."
    remark = f" The waiting times do not determine t0: taken as {t0:.3g} s." if assumed else ""
    return replace(fit, good=not reservations, quality=f"{' '.join(reservations) or good}{remark}")


def _reservations(fit: AgeingFit) -> Iterator[str]:
    (low, high), (least, most) = fit.interval["beta"], fit.interval["t0"]
    if not low > 0:
        yield f"The points show no ageing: the slope may be anything from {low:.2g} to {high:.2g} per decade."
    elif fit.r_squared < LEAST_EXPLAINED:
        yield f"The curve explains only {100 * fit.r_squared:.0f} % of the variance of the points."
    if fit.t0_assumed and least > 0 and math.isinf(most):
        yield f"Static friction grows in proportion to time (t0 above {least:.2g} s): beta and t0 are not determined."


# --- lubricants in order ----------------------------------------------------------------------------------------------


@dataclass(frozen=True)
class Rank:
    """One lubricant in an order, its number with the 95 % interval."""

    name: str
    value: float
    interval: Interval


@dataclass(frozen=True)
class Ranking:
    """Lubricants from best to worst, by static friction after a waiting time of `at` s and by its growth per decade."""

    at: float
    by_level: tuple[Rank, ...]
    by_slope: tuple[Rank, ...]


def rank(fits: Mapping[str, AgeingFit], at: float) -> Ranking:
    """Order lubricants by level and by slope, the lowest first: the best has the lowest of both.

    Parameters
    ----------
    fits : by the name of the lubricant, at least one
    at : waiting time (s) at which levels are compared

    Returns
    -------
    Ranking

    Raises
    ------
    ValueError
        For no fits, and an impossible waiting time.
    """
    if not fits:
        raise ValueError("fits: got none, expected at least one")
    if not (math.isfinite(at) and at >= 0):
        raise ValueError(f"at: got {at!r}, expected a waiting time >= 0 (s)")
    levels = [Rank(name, float(fit.predict(at)), fit.level(at)) for name, fit in fits.items()]
    slopes = [Rank(name, fit.beta, fit.interval["beta"]) for name, fit in fits.items()]
    return Ranking(float(at), *(tuple(sorted(ranks, key=lambda one: one.value)) for ranks in (levels, slopes)))
