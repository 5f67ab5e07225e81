"""Repeats of one material: one curve through the points of all, known as well as the repeats agree.

Specimens differ by more than the scatter of the points of each, and not only in level: what varies from repeat to
repeat is the whole curve. So nothing is assumed about how. The curve is fitted to all points, and again without each
repeat in turn; with n repeats, the covariance of the coefficients is (n-1)/n times the sum of the squares of what
leaving one out changes (the jackknife over groups: Efron and Stein, Ann. Statist. 9 (1981) 586; as cluster-robust CR3:
MacKinnon, Nielsen and Webb, J. Appl. Econometrics 38 (2023) 671), and intervals follow the t distribution of n-1
degrees of freedom. This holds scatter within and between repeats, whatever their speeds and numbers of points.
Coefficients above 0 vary by factors, as levels of friction do from specimen to specimen; the slope does not, which may
be 0.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, field, fields

import numpy as np
from numpy.typing import ArrayLike

from stickslip.fit.curve import CurveFit, fit_curve
from stickslip.fit.models import Drawn, drawn_in_batches
from stickslip.fit.uncertainty import CONFIDENCE, Floats, Interval, student
from stickslip.theory import stribeck
from stickslip.vocabulary.models import CURVE, FITTED

_BAND = 2000  # curves drawn for a band


@dataclass(frozen=True)
class RepeatedFit(CurveFit):
    """A curve through the points of several repeats of one material.

    As `CurveFit`; uncertainties are those between repeats. repeats : their names. without : the curve without each.
    """

    repeats: tuple[str, ...] = ()
    without: tuple[CurveFit, ...] = field(default=(), repr=False)

    def draw(self, count: int, seed: int = 1, *, falling: bool = False) -> Drawn | None:
        """Curves as likely as the repeats leave them; see `draw_curves`."""
        random, n = np.random.default_rng(seed), len(self.without)
        values = np.array([[*fit.coefficients().values()] for fit in (self, *self.without)])
        by_factors = (values > 0).all(axis=0) & (np.array(CURVE) != CURVE.slope)
        best, *others = np.where(by_factors, np.log(np.where(by_factors, values, 1.0)), values)
        root = (np.array(others) - np.mean(others, axis=0)) * np.sqrt((n - 1) / n)

        def batch() -> Floats:
            spread = np.sqrt(random.chisquare(n - 1, (count, 1)) / (n - 1))
            drawn = best + random.standard_normal((count, n)) @ root / spread
            with np.errstate(over="ignore"):
                drawn = np.where(by_factors, np.exp(drawn), drawn)
            level, slope, drop, decay = drawn.T
            weakens = self.coefficients()[CURVE.drop] >= 0
            of_kind = ((slope >= 0) | falling) & (drop >= 0) if weakens else drop <= 0
            possible = (level >= 0) & (level + drop >= 0) & (decay > 0) & np.isfinite(drawn).all(axis=1)
            return np.asarray(drawn[of_kind & possible])

        return drawn_in_batches(batch, count)

    def band(self, speed: ArrayLike) -> tuple[Floats, Floats]:
        """Lower and upper end of the 95 % confidence band of the curve at slip speeds (m/s): quantiles of draws."""
        w = np.asarray(speed, np.float64)
        drawn = self.draw(_BAND, falling=True)
        if drawn is None:
            return np.zeros_like(w), np.full_like(w, np.inf)
        curves = stribeck(w[..., None], **drawn.coefficients)
        tail = (1 - CONFIDENCE) / 2
        low, high = np.quantile(curves, (tail, 1 - tail), axis=-1)
        return np.maximum(low, 0.0), high


def fit_repeats(
    speeds: Sequence[ArrayLike], mus: Sequence[ArrayLike], names: Sequence[str] = (), *, unit: str = "m/s"
) -> RepeatedFit:
    """One curve through the points of several repeats of one material.

    Parameters
    ----------
    speeds, mus : slip speeds (m/s) and friction coefficients, an array for each repeat, which may differ in length
    names : of the repeats, for the result
    unit : in which `quality` tells speeds

    Returns
    -------
    RepeatedFit
        Its intervals and draws hold the scatter between repeats, on n-1 degrees of freedom.

    Raises
    ------
    ValueError
        For fewer than two repeats, and where the others, without one of them, have fewer than 4 distinct speeds.
    """
    w, y = ([np.asarray(values, np.float64) for values in given] for given in (speeds, mus))
    if len(w) < 2 or len(w) != len(y):
        raise ValueError(f"repeats: got {len(w)}, expected at least 2, each with speeds and friction coefficients")
    whole = fit_curve(np.concatenate(w), np.concatenate(y), unit=unit)
    without = []
    for i in range(len(w)):
        try:
            without.append(fit_curve(np.concatenate(w[:i] + w[i + 1 :]), np.concatenate(y[:i] + y[i + 1 :])))
        except ValueError as error:
            raise ValueError(f"without {names[i] if names else f'repeat {i + 1}'}: {error}") from None
    best, *others = ([getattr(fit, name) for name in FITTED] for fit in (whole, *without))
    scatter = np.array(others) - np.mean(others, axis=0)
    matrix = (len(w) - 1) / len(w) * scatter.T @ scatter
    errors = [math.sqrt(variance) for variance in np.diag(matrix)]
    reach = [student(len(w) - 1) * error for error in errors]
    count = f"{len(w)} repeats ({', '.join(names)})" if names else f"{len(w)} repeats"
    quality = f"{whole.quality} Intervals are those of {count}, which hold what differs between them."
    values = {each.name: getattr(whole, each.name) for each in fields(CurveFit)}
    values |= {
        "standard_error": dict(zip(FITTED, errors, strict=True)),
        "interval": dict(zip(FITTED, map(_within, best, reach, FITTED), strict=True))
        | dict.fromkeys(whole.assumed, (0.0, math.inf)),
        "has_intervals": not whole.assumed,  # what was assumed differs from no repeat to another
        "covariance": matrix[:4, :4], "freedom": float(len(w) - 1),
        "quality": f"{quality} Two leave them wide: measure a third." if len(w) == 2 else quality,
    }  # fmt: skip
    return RepeatedFit(**values, repeats=tuple(names), without=tuple(without))


def _within(value: float, reach: float, name: str) -> Interval:
    """An interval, of what varies by factors as well."""
    if value > 0 and name != CURVE.slope:
        factor = math.exp(min(reach / value, 700.0))
        return value / factor, value * factor
    return max(0.0, value - reach) if value >= 0 else value - reach, value + reach
