"""Measured friction over slip speed, fitted by level + slope w + drop shape(w/decay), and how well that is known."""

import math
from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from functools import cache

import numpy as np
import scipy  # type: ignore[import-untyped]
from numpy.typing import ArrayLike

from stickslip.vocabulary import units
from stickslip.vocabulary.models import BREAKAWAY, CURVE, CURVE_LAWS, FITTED
from stickslip_materials.fit.curve import (
    FALLING,
    STRAIGHT,
    STRENGTHENING,
    WEAKENING,
    Chosen,
    CurveFit,
    MeasuredPoints,
)
from stickslip_materials.fit.turns import Sweep, course
from stickslip_materials.fit.uncertainty import (
    CONFIDENCE,
    LEAST_EXPLAINED,
    Flags,
    Floats,
    covariance,
    point_apart,
    points_of,
    r_squared,
    rms,
)

BEST = "best"  # of all laws
_FEWEST = 4  # distinct speeds; as many as coefficients
_AT_END = 0.01  # share of the decay speed within which it is at the end of the range that was searched
_CHANCE = 0.003  # of an outlier among points that have none
_MOST_OUTLIERS = 10  # one point in so many, and one at least, may be left out
_SHARE = 0.5  # of the mean friction: a coefficient that moves the curve by more, within its interval, is not known
_RATIO = 8.0  # of the ends of an interval: a3 or a4 is not determined if it is more
_REGULAR = 0.005  # chance of residuals as regular, where the curve has the right shape
_BETTER = 6.0  # by which the AICc of another law is lower: twenty times as likely
_FEW = 4  # points to spare below which a branch that is not seen may well be there
_STRONGEST = 2.0  # friction at break-away, and its ratio to the largest measured: more is extrapolated


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
    sigma : standard deviation of each mu, or one for all; None: taken from the residuals, even for all points.
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
        is < 0; where they show neither, it is 0. A point that is no scatter of the others' is left out.

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
    distinct = np.unique(w).size
    if distinct < _FEWEST:
        raise ValueError(
            f"speed: got {distinct} distinct speed{'s' * (distinct != 1)}, expected at least {_FEWEST}: "
            "fewer cannot determine the four coefficients of the curve"
        )
    if not y.any():
        raise ValueError("mu: got nothing but 0, expected friction coefficients")

    def fitted(which: Flags, is_rough: bool = False) -> CurveFit:
        by_law = {name: MeasuredPoints(w, y, deviation, name).of(which) for name in CURVE_LAWS}
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
    likelihood = points.left(chosen.best)
    if points.deviation is None:
        likelihood = n * math.log(max(likelihood, 1e-26 * float(np.sum(points.target**2))) / n)
    return likelihood + 2.0 * free * n / (n - free - 1.0)


def _fitted(given: MeasuredPoints, criterion: Callable[[str], float], unit: str, is_rough: bool) -> CurveFit:
    """The curve through the points but outliers. is_rough : without intervals."""
    inside = _without_outliers(given)
    points = given if inside.all() else given.of(inside, left_out=int(np.count_nonzero(~inside)))
    chosen = points.choose()
    form, known = chosen.form, points.deviation is not None
    freedom = math.inf if known else float(points.freedom(form))
    residuals = points.mu - points.curve(chosen.best) * points.units[0]
    matrix = _covariance(points, chosen, freedom)
    open_ends = dict.fromkeys(FITTED, (0.0, math.inf))
    a1, a2, a3, a4 = map(float, chosen.best * points.units)
    fit = CurveFit(
        *(a1, a2, a3, a4),
        standard_error=_errors(matrix),
        interval=open_ends if is_rough else points.intervals(form),
        covariance=matrix,
        freedom=freedom,
        speeds=(float(points.speed.min()), float(points.speed.max())),
        searched=(float(points.limits[0] * points.units[3]), float(points.limits[1] * points.units[3])),
        residual_rms=rms(residuals),
        r_squared=r_squared(points.mu, residuals, (points.weight / points.weight.max()) ** 2),
        points=int(points.speed.size),
        assumed=form.assumed,
        at_bound=_at_bound(chosen, points),
        outliers=tuple(np.flatnonzero(~inside).tolist()),
        has_intervals=points.can_draw(form),
        law=points.law,
        measured=points,
        form=form,
    )
    if is_rough:
        return fit
    quality = _Quality(fit, chosen, points, given, criterion, unit)
    doubts = [*quality.shape()]
    reservations = [*quality.reservations(), *doubts]
    is_open = form is not STRENGTHENING and fit.interval["a2"][0] <= 0  # a2 is known where it is certain to be a rise
    praise = f"The points determine {'a1, a3 and a4' if is_open else 'all four coefficients'}."
    return replace(
        fit,
        interval=open_ends if doubts else fit.interval,  # intervals are those of the right curve
        unidentified=quality.unidentified(),
        determined=quality.determined(),
        has_intervals=fit.has_intervals and not doubts,
        good=not reservations,
        quality=" ".join(reservations) or praise,
    )


def _without_outliers(points: MeasuredPoints) -> Flags:
    """The points but those that are no scatter of the others; all where too few would be left."""
    inside = np.ones(points.speed.size, bool)
    for _ in range(max(1, inside.size // _MOST_OUTLIERS)):
        rest = points.of(inside)
        chosen = rest.choose()
        if chosen.form is STRAIGHT:  # a branch may hide behind it
            chosen = Chosen(WEAKENING, False, rest.fit(WEAKENING))
        residuals = rest.residuals(chosen)
        if residuals is None or inside.sum() <= _FEWEST + 2:
            break
        position, chance = point_apart(*residuals)
        if not chance < _CHANCE or np.unique(np.delete(rest.speed, position)).size < _FEWEST:
            break
        inside[np.flatnonzero(inside)[position]] = False
    return inside


# --- how well it is known, to first order -----------------------------------------------------------------------------


def _covariance(points: MeasuredPoints, chosen: Chosen, freedom: float) -> Floats:
    """Of the coefficients; inf on the diagonal where the points determine nothing."""
    variance = 1.0
    if math.isfinite(freedom):
        variance = points.left(chosen.best) / freedom if freedom > 0 else math.inf
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


def _at_bound(chosen: Chosen, points: MeasuredPoints) -> tuple[str, ...]:
    """Estimates, friction at break-away among them, at the end of the range that was allowed."""
    a1, a2, a3, a4 = chosen.best
    floor = {*chosen.form.nonnegative, BREAKAWAY} - {*chosen.form.assumed}
    values = {CURVE.level: a1, CURVE.slope: a2, CURVE.drop: a3, BREAKAWAY: a1 + a3}
    at_end = [name for name, value in values.items() if name in floor and value == 0.0]
    low, high = points.limits
    if chosen.form is not STRAIGHT and not low * (1 + _AT_END) < a4 < high * (1 - _AT_END):
        at_end.append(CURVE.decay)
    return tuple(at_end)


@dataclass(frozen=True)
class _Quality:
    """What speaks against using a fitted curve, and what the points do not determine.

    fit : with the intervals of a curve of the right shape. points : those that were fitted; given : all of them.
    criterion : AICc of the best curve of a law. unit : in which speeds are written.
    """

    fit: CurveFit
    chosen: Chosen
    points: MeasuredPoints
    given: MeasuredPoints
    criterion: Callable[[str], float]
    unit: str

    def unidentified(self) -> tuple[str, ...]:
        """Coefficients that the points do not determine."""
        unknown = {*self.fit.assumed}
        for name, unit in (("a1", 1.0), ("a2", float(self.points.speed.max()))):
            (low, high), value = self.fit.interval[name], getattr(self.fit, name)
            if not max(high - value, value - low) * unit < _SHARE * float(self.points.mu.mean()):
                unknown.add(name)
        for name in ("a3", "a4"):
            low, high = self.fit.interval[name]
            least, most = sorted((abs(low), abs(high)))
            if not (math.isfinite(high) and low * high > 0 and most < _RATIO * least):
                unknown.add(name)
        return tuple(name for name in CURVE if name in unknown)

    def determined(self) -> bool:
        """True where the points tell where vibration ends."""
        form = self.chosen.form
        if self.points.freedom(form) <= 0 or self._is_far():
            return False
        if form is STRAIGHT:
            return self.points.freedom(WEAKENING) >= _FEW
        has_end = math.isfinite(self.fit.interval[BREAKAWAY][1])
        return form is not WEAKENING or (has_end and not self._rests())

    def reservations(self) -> Iterator[str]:
        """Sentences against using the curve; those about its shape apart."""
        fit, form = self.fit, self.chosen.form
        slowest, fastest = map(self._speed, fit.speeds)
        if fit.outliers:
            places = (f"{self.given.mu[i]:.3g} at {self._speed(float(self.given.speed[i]))}" for i in fit.outliers)
            yield f"Left out as no scatter of the others: {', '.join(places)}."
        if self.points.freedom(form) <= 0 or form is STRAIGHT and self.points.freedom(WEAKENING) < _FEW:
            yield f"{fit.points} points do not test the fit of four coefficients: measure more points."
        elif form is STRAIGHT:
            yield f"No declining branch between {slowest} and {fastest}: a3 was taken as 0. Measure at lower speed."
        elif form is FALLING:
            yield f"Friction falls from {slowest} to {fastest}: a2 was taken as 0. Measure at higher speed."
        elif self._is_far() or fit.speeds[0] > fit.a4 or fit.speeds[0] > 0 and self._rests():
            yield f"mu_start = {fit.mu_start:.3g} is extrapolated from {slowest}. Measure at lower speed."
        if not self.chosen.seen:
            return
        if unknown := [name for name in self.unidentified() if name not in fit.assumed]:
            yield f"The points do not determine {' and '.join(unknown)}."
        if bounds := [name for name in ("a1", BREAKAWAY, "a4") if name in fit.at_bound]:  # a2: no rise is seen
            yield f"At its bound, beyond which the curve is a guess: {' and '.join(bounds)}."
        if fit.r_squared < LEAST_EXPLAINED:
            yield f"The curve explains only {100 * fit.r_squared:.0f} % of the variance of the points."

    def _is_far(self) -> bool:
        """True where mu_start is far above all points, or implausible and none of the points has it."""
        start, most = self.fit.mu_start, float(self.points.mu.max())
        return start > _STRONGEST * most or start >= max(_STRONGEST, 1.1 * most)

    def _rests(self) -> bool:
        """True where the branch is seen by the points at the slowest speed alone."""
        points = self.points
        slowest = points.speed == points.speed.min()
        if np.unique(points.speed[~slowest]).size < 3 or not points.mu[~slowest].any():
            return True
        return not points.of(~slowest).shows_branch(self.chosen.form, CONFIDENCE)

    def _speed(self, speed: float) -> str:
        rounded = float(f"{speed / units.factor(self.unit, 'm s-1'):.3g}")
        return f"{rounded:g} {self.unit}"

    def shape(self) -> Iterator[str]:
        """Residuals that follow another curve, by themselves or by another law, or that sigma does not explain."""
        points, law, freedom = self.points, self.points.law, self.points.freedom(self.chosen.form)
        residuals = points.residuals(self.chosen) if self.chosen.seen else None
        if residuals is not None:
            best = min(CURVE_LAWS, key=self.criterion)
            lower = self.criterion(law) - self.criterion(best)
            is_better = math.isfinite(lower) and lower > _BETTER
            if is_better or points.chance_of_shape(self.chosen, *residuals) < _REGULAR:
                hint = f", such as {best} (AICc lower by {lower:.2g})" if is_better else ""
                yield f"The points follow a curve of another shape than {law}{hint}."
        chi_squared = points.left(self.chosen.best)
        if points.deviation is not None and freedom > 0 and scipy.stats.chi2(freedom).sf(chi_squared) < 1e-3:
            yield f"The residuals are {math.sqrt(chi_squared / freedom):.2g} times sigma."
