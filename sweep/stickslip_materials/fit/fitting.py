"""Measured friction over slip speed, fitted by level + slope w + drop shape(w/decay): Stribeck's curve or others.

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
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, fields, replace
from functools import cache
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from stickslip.vocabulary.models import BREAKAWAY, CURVE, CURVE_LAWS, FITTED
from stickslip_materials.fit.branches import Sweep
from stickslip_materials.fit.curve import CurveFit, Drawn
from stickslip_materials.fit.models import STRAIGHT, WEAKENING, Chosen, MeasuredPoints
from stickslip_materials.fit.quality import Quality
from stickslip_materials.fit.turns import course
from stickslip_materials.fit.uncertainty import Flags, Floats, Interval, covariance, points_of, r_squared, rms, student

BEST = "best"  # of all laws
_FEWEST = 4  # distinct speeds; as many as coefficients
_AT_END = 0.01  # share of the decay speed within which it is at the end of the range that was searched
_CHANCE = 0.003  # of an outlier among points that have none
_MOST_OUTLIERS = 10  # one point in so many, and one at least, may be left out


def fit_curve(
    speed: ArrayLike,
    mu: ArrayLike,
    sigma: ArrayLike | None = None,
    *,
    unit: str = "m/s",
    law: str = "stribeck",
    direction: ArrayLike | None = None,
) -> CurveFit:
    """The friction curve nearest to measured points, by least squares.

    Parameters
    ----------
    speed : (n,) slip speeds, m/s, >= 0.
    mu : (n,) friction coefficients there.
    sigma : standard deviation of each mu, or one for all; None: taken from the residuals, with weights where these show
        that the scatter differs along the speed.
    unit : in which `quality` gives speeds.
    law : one of `vocabulary.models.CURVE_LAWS` (stribeck_delta with delta = 2, Gaussian), or "best": that of the lowest
        AICc.
    direction : of each point, > 0 where it was measured while the speed rose, < 0 while it fell. None: by the order of
        the points, if their speed turns. Of the law stribeck friction on the way down may have an end of its own,
        `mu_stop`.

    Returns
    -------
    CurveFit
        All coefficients are >= 0 where the points show a declining branch. Where they fall all the way but do not
        determine four coefficients, the slope is taken as 0; where they show a rise from zero speed instead, the drop
        is < 0; where they show neither, it is 0. A point that is no scatter of the others' (1 %, Monte Carlo) is left
        out.

    Raises
    ------
    ValueError
        For impossible points or fewer than 4 distinct speeds.
    """
    w = points_of("speed", speed)
    y = points_of("mu", mu, w.size)
    deviation = None if sigma is None else points_of("sigma", np.broadcast_to(np.asarray(sigma), w.shape), w.size)
    if deviation is not None and not deviation.all():
        raise ValueError(f"sigma[{int(np.argmin(deviation))}]: got 0, expected a standard deviation > 0")
    if law not in (*CURVE_LAWS, BEST):
        raise ValueError(f"law: got {law!r}, expected {', '.join(CURVE_LAWS)} or {BEST}")
    distinct = np.unique(w)
    if distinct.size < _FEWEST:
        raise ValueError(
            f"speed: got {distinct.size} distinct speed{'s' * (distinct.size != 1)}, expected at least {_FEWEST}: "
            "fewer cannot determine the four coefficients of the curve"
        )
    if not y.any():
        raise ValueError("mu: got nothing but 0, expected friction coefficients")

    def fitted(which: Flags, is_rough: bool = False) -> CurveFit:
        given = None if deviation is None else deviation[which]
        by_law = {name: MeasuredPoints(w[which], y[which], given, name) for name in CURVE_LAWS}
        criterion = cache(lambda name: _criterion(by_law[name]))  # other laws are fitted where they are compared
        fit = _fitted(by_law[min(CURVE_LAWS, key=criterion) if law == BEST else law], criterion, unit, is_rough)
        return replace(fit, outliers=tuple(np.flatnonzero(which)[[*fit.outliers]].tolist()))

    way = course(w) if direction is None else points_of("direction", direction, w.size, -math.inf)
    if way is None or not (way.min() < 0 < way.max()):
        return fitted(np.ones(w.size, bool))
    return Sweep(w, y, deviation, way, fitted).fit()


def _criterion(points: MeasuredPoints) -> float:
    """AICc of the best curve (Hurvich and Tsai 1989); inf where there are too few points."""
    chosen, n = points.choose(), points.speed.size
    free = int(np.count_nonzero(chosen.best[:3])) + (chosen.form is not STRAIGHT) + (points.deviation is None)
    if n - free - 1 <= 0:
        return math.inf
    left = points.left(chosen.best)
    rounding = 1e-26 * float(np.sum(points.target**2))
    likelihood = left if points.deviation is not None else n * math.log(max(left, rounding) / n)
    return likelihood + 2.0 * free * n / (n - free - 1.0)


def _fitted(given: MeasuredPoints, criterion: Callable[[str], float], unit: str, is_rough: bool) -> CurveFit:
    """The curve through the points but outliers, weighted as their scatter asks for. is_rough : without intervals."""
    left_out = outliers(given)
    points = given.without(left_out)
    chosen = points.choose()
    if (slope := points.uneven(chosen)) is not None:
        points = replace(points, slope=slope)
        chosen = points.choose()
    form, known = chosen.form, points.deviation is not None
    freedom = math.inf if known else float(points.freedom(form))
    residuals = points.mu - points.curve(chosen.best) * points.units[0]
    variance = 1.0 if known else points.left(chosen.best) / freedom if freedom > 0 else math.inf
    matrix = _covariance(points, chosen, variance)
    estimates: dict[str, Any] = dict(zip(CURVE, map(float, chosen.best * points.units), strict=True))
    open_ends = dict.fromkeys(FITTED, (0.0, math.inf))
    fit = CurveFit(
        **estimates,
        standard_error=_errors(matrix),
        interval=open_ends if is_rough else points.intervals(form),
        covariance=matrix,
        freedom=freedom,
        speeds=(float(points.speed.min()), float(points.speed.max())),
        searched=(float(points.limits[0] * points.units[3]), float(points.limits[1] * points.units[3])),
        residual_rms=rms(residuals),
        r_squared=r_squared(points.mu, residuals, (points.weight / points.weight.max()) ** 2),
        points=int(points.speed.size),
        unidentified=(),
        assumed=form.assumed,
        at_bound=_at_bound(estimates, chosen, points),
        outliers=left_out,
        scatter=math.exp(points.slope),
        determined=False,
        has_intervals=points.can_draw(form),
        good=False,
        quality="",
        law=points.law,
        preferred=math.nan,
        measured=points,
        form=form,
    )
    if is_rough:
        return fit
    quality = Quality(fit, chosen, points, given, criterion, unit)
    doubts = [*quality.shape()]
    reservations = [*quality.reservations(), *doubts]
    return replace(
        fit,
        interval=open_ends if doubts else fit.interval,  # intervals are those of the right curve
        unidentified=quality.unidentified(),
        determined=quality.determined(),
        has_intervals=fit.has_intervals and not doubts,
        good=not reservations,
        quality=" ".join(reservations) or quality.praise(),
        preferred=criterion("stribeck") - criterion(points.law),
    )


# --- points apart -----------------------------------------------------------------------------------------------------


def outliers(points: MeasuredPoints) -> tuple[int, ...]:
    """Positions of points that are no scatter of the others', with even weights and with those that the scatter asks
    for alike; none where too few would be left."""
    out: list[int] = []
    while len(out) < max(1, points.speed.size // _MOST_OUTLIERS) and points.speed.size - len(out) > _FEWEST + 2:
        inside = points.without(tuple(out))
        position = _apart(inside)
        if position is None:
            break
        others = inside.without((position,))
        if np.unique(others.speed).size < _FEWEST:
            break
        if (slope := others.uneven(others.choose())) is not None and _apart(replace(inside, slope=slope)) != position:
            break
        out.append(int(np.delete(np.arange(points.speed.size), out)[position]))
    return tuple(sorted(out))


def _apart(points: MeasuredPoints) -> int | None:
    """The point that is farthest from the curve of the others, if that is no chance; a branch may hide behind it."""
    chosen = points.choose()
    if chosen.form is STRAIGHT:
        chosen = Chosen(WEAKENING, False, points.fit(WEAKENING))
    residuals = points.residuals(chosen)
    if residuals is None:
        return None
    position, chance = residuals.outlier(math.inf if points.deviation is not None else points.freedom(chosen.form))
    return position if chance < _CHANCE else None


# --- how well it is known, to first order -----------------------------------------------------------------------------


def _covariance(points: MeasuredPoints, chosen: Chosen, variance: float) -> Floats:
    """Of the coefficients; inf on the diagonal where the points determine nothing."""
    fixed = [name in chosen.form.assumed or (name == CURVE.decay and chosen.best[2] == 0) for name in CURVE]
    unit = covariance(np.where(fixed, 0.0, points.jacobian(chosen.best) / points.units))
    with np.errstate(invalid="ignore"):
        matrix = np.where(unit == 0, 0.0, unit * variance)
    matrix[np.isinf(unit)] = np.inf
    return matrix


def _errors(matrix: Floats) -> dict[str, float]:
    certain = np.isfinite(matrix[0, 0]) and np.isfinite(matrix[2, 2])
    together = matrix[0, 0] + matrix[2, 2] + 2.0 * matrix[0, 2] if certain else math.inf
    errors = [*map(float, np.sqrt(np.diag(matrix))), math.sqrt(max(float(together), 0.0))]
    return dict(zip(FITTED, errors, strict=True))


def _at_bound(estimates: Mapping[str, float], chosen: Chosen, points: MeasuredPoints) -> tuple[str, ...]:
    """Estimates, friction at break-away among them, at the end of the range that was allowed."""
    values = {name: estimates[name] for name in CURVE[:3]} | {BREAKAWAY: estimates[CURVE.level] + estimates[CURVE.drop]}
    floor = {*chosen.form.nonnegative, BREAKAWAY} - {*chosen.form.assumed}
    at_end = [name for name, value in values.items() if name in floor and value == 0.0]
    low, high = points.limits
    if chosen.form is not STRAIGHT and not low * (1 + _AT_END) < chosen.best[3] < high * (1 - _AT_END):
        at_end.append(CURVE.decay)
    return tuple(at_end)


# --- repeats ----------------------------------------------------------------------------------------------------------


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
            weakens = self.coefficients()[CURVE.drop] >= 0
            of_kind = ((slope >= 0) | falling) & (drop >= 0) if weakens else drop <= 0
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
    values = {each.name: getattr(whole, each.name) for each in fields(CurveFit)} | {
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
