"""Repeats of one material.

Repeats of a material differ by more than the scatter of the points of each, and not only in level: what varies from
repeat to repeat is the whole curve. So nothing is assumed about how. The curve is fitted to all points, and again
without each repeat in turn; with n repeats, the covariance of the coefficients is (n-1)/n times the sum of the squares
of what leaving one out changes (the jackknife over groups: Efron and Stein, Ann. Statist. 9 (1981) 586; as
cluster-robust CR3: MacKinnon, Nielsen and Webb, J. Appl. Econometrics 38 (2023) 671), and intervals follow the t
distribution of n-1 degrees of freedom. This holds scatter within and between repeats, whatever their speeds and numbers
of points. Coefficients above 0 vary by factors, as levels of friction do from specimen to specimen; the slope does not,
which may be 0.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass, field, fields
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from stickslip.vocabulary.models import CURVE, FITTED
from stickslip_materials.fit.curve import CurveFit, Drawn
from stickslip_materials.fit.fitting import fit_curve
from stickslip_materials.fit.turns import course
from stickslip_materials.fit.uncertainty import Floats, Interval, student


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
        fits = (self, *self.without)
        names = [*CURVE, *_mu_stop_of(fits)]
        values = np.array([[getattr(fit, name) for name in names] for fit in fits])
        by_factors = (values > 0).all(axis=0) & (np.array(names) != CURVE.slope)
        best, *others = np.where(by_factors, np.log(np.where(by_factors, values, 1.0)), values)
        root = (np.array(others) - np.mean(others, axis=0)) * np.sqrt((n - 1) / n)

        def batch() -> Floats:
            spread = np.sqrt(random.chisquare(n - 1, (count, 1)) / (n - 1))
            drawn = best + random.standard_normal((count, n)) @ root / spread
            with np.errstate(over="ignore"):
                drawn = np.where(by_factors, np.exp(drawn), drawn)
            level, slope, drop, decay = drawn.T[: len(CURVE)]
            of_kind = ((slope >= 0) | falling) & (drop >= 0) if self.a3 >= 0 else drop <= 0
            possible = (level >= 0) & (level + drop >= 0) & (decay > 0) & np.isfinite(drawn).all(axis=1)
            return np.asarray(drawn[of_kind & possible])

        return self._slowing(Drawn.in_batches(batch, count, names), random)


def fit_repeats(
    speeds: Sequence[ArrayLike],
    mus: Sequence[ArrayLike],
    names: Sequence[str] = (),
    *,
    unit: str = "m/s",
    directions: Sequence[ArrayLike] | None = None,
) -> RepeatedFit:
    """One curve through the points of several repeats of one material.

    Parameters
    ----------
    speeds, mus : slip speeds (m/s) and friction coefficients, an array for each repeat, which may differ in length
    names : of the repeats, for the result
    unit : in which `quality` tells speeds
    directions : of the points, as for `fit_curve`; None: by the order of those of each repeat

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
    ways = [course(speed) for speed in w] if directions is None else [np.asarray(way) for way in directions]
    d = [np.zeros(speed.size) if way is None else way for speed, way in zip(w, ways, strict=True)]
    whole = fit_curve(np.concatenate(w), np.concatenate(y), unit=unit, direction=np.concatenate(d))
    without = []
    for i in range(len(w)):
        speed, mu, way = (np.concatenate(of[:i] + of[i + 1 :]) for of in (w, y, d))
        try:
            without.append(fit_curve(speed, mu, direction=way))
        except ValueError as error:
            raise ValueError(f"without {names[i] if names else f'repeat {i + 1}'}: {error}") from None
    fitted = [*FITTED, *_mu_stop_of((whole, *without))]
    best, *others = ([getattr(fit, name) for name in fitted] for fit in (whole, *without))
    scatter = np.array(others) - np.mean(others, axis=0)
    matrix = (len(w) - 1) / len(w) * scatter.T @ scatter
    errors = [math.sqrt(variance) for variance in np.diag(matrix)]
    reach = [student(len(w) - 1) * error for error in errors]
    count = f"{len(w)} repeats ({', '.join(names)})" if names else f"{len(w)} repeats"
    values: dict[str, Any] = {each.name: getattr(whole, each.name) for each in fields(CurveFit)} | {
        "standard_error": dict(zip(fitted, errors, strict=True)),
        "interval": {**whole.interval, **dict(zip(fitted, map(_within, best, reach, fitted), strict=True))}
        | dict.fromkeys(whole.assumed, (0.0, math.inf)),
        "has_intervals": not whole.assumed,  # what was assumed differs from no repeat to another
        "covariance": matrix[:4, :4], "freedom": float(len(w) - 1),
        "quality": f"{whole.quality} Intervals are those of {count}, which hold what differs between them.",
    }  # fmt: skip
    return RepeatedFit(**values, repeats=tuple(names), without=tuple(without))


def _mu_stop_of(fits: Sequence[CurveFit]) -> list[str]:
    """The name of mu_stop, if all have one."""
    return ["mu_stop"] if all("mu_stop" in fit.coefficients() for fit in fits) else []


def _within(value: float, reach: float, name: str) -> Interval:
    """An interval, of what varies by factors as well."""
    if value > 0 and name != CURVE.slope:
        factor = math.exp(min(reach / value, 700.0))
        return value / factor, value * factor
    return max(0.0, value - reach) if value >= 0 else value - reach, value + reach
