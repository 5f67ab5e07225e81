"""Measured friction over slip speed, fitted by a1 + a2 w + a3 shape(w/a4): the Stribeck curve or another law."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import ArrayLike

from stickslip.fit.models import (
    COEFFICIENTS,
    STRAIGHT,
    WEAKENING,
    Allowed,
    Chosen,
    Drawn,
    MeasuredPoints,
    drawn_in_batches,
)
from stickslip.fit.quality import Quality
from stickslip.fit.uncertainty import Floats, Interval, covariance, points_of, r_squared, rms
from stickslip.theory.curve import SHAPES
from stickslip.vocabulary.models import LAWS

BEST = "best"  # of all laws
_FEWEST = 4  # distinct speeds; as many as coefficients
_AT_END = 0.01  # share of a4 within which it is at the end of the range that was searched
_CHANCE = 0.003  # of an outlier among points that have none
_MOST_OUTLIERS = 10  # one point in so many, and one at least, may be left out


@dataclass(frozen=True)
class CurveFit:
    """A friction curve through measured points, in SI.

    a1, a3 pure numbers, a2 s/m, a4 m/s; all >= 0, except where friction rises from zero speed: there a3 < 0, and a2 may
    be. Points without a branch have a3 = 0, and then a4 means nothing.
    standard_error : by name, of a1 to a4 and of mu_start = a1 + a3, to first order.
    interval : by name, 95 % by profile likelihood, without the part below a bound at 0; an end that the points
        leave open is inf, or 0; all are where another curve is said to fit better.
    covariance : (4, 4), in the order a1 to a4, to first order. freedom : points to spare, inf where sigma was given.
    speeds : the slowest and the fastest point, m/s. searched : between which a4 was looked for, m/s.
    residual_rms : of mu. r_squared : explained share of the variance of mu, NaN if mu does not vary.
    unidentified : coefficients that the points do not determine. assumed : those of them that were fixed.
    at_bound : those (and mu_start) that the points would have beyond their bound.
    outliers : positions of points that were left out. scatter : standard deviation at the fastest point over that at
        the slowest, by which points were weighted; 1 unless they show that it differs, or sigma was given.
    determined : whether the points tell where vibration ends; a material whose points do not is not ranked.
    has_intervals : whether what follows from the curve has an interval: points are to spare, and follow its shape.
    good : whether the curve may be used without reservation. quality : why, or why not, in plain words.
    law : of the curve. preferred : by how much its AICc is below that of the Stribeck curve.
    allowed : the curves that the points allow, which bands and draws come from.
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
    outliers: tuple[int, ...]
    scatter: float
    determined: bool
    has_intervals: bool
    good: bool
    quality: str
    law: str
    preferred: float
    allowed: Allowed = field(repr=False, compare=False)

    @property
    def mu_start(self) -> float:
        """Friction coefficient at break-away, a1 + a3."""
        return self.a1 + self.a3

    @property
    def declines(self) -> bool:
        """True where friction falls from standstill on."""
        return self.a3 > 0

    def coefficients(self) -> dict[str, float]:
        """a1 to a4 by name, as `evaluate` and `simulate` take them."""
        return {name: float(getattr(self, name)) for name in COEFFICIENTS}

    def predict(self, speed: ArrayLike) -> Floats:
        """Friction coefficient at slip speeds (m/s)."""
        w = np.asarray(speed, np.float64)
        return np.asarray(self.a1 + self.a2 * w + self.a3 * SHAPES[self.law](w / self.a4))

    def band(self, speed: ArrayLike) -> tuple[Floats, Floats]:
        """Lower and upper end of the 95 % confidence band of the curve at slip speeds (m/s), by profile likelihood; not
        below 0, and infinite where the points determine nothing. What was assumed is taken as it is.
        """
        w = np.asarray(speed, np.float64)
        low, high = (end.reshape(w.shape) for end in self.allowed.friction(w.ravel()))
        middle = self.predict(w)
        return np.minimum(np.maximum(low, 0.0), middle), np.maximum(high, middle)

    def draw(self, count: int, seed: int = 1, *, falling: bool = False) -> Drawn | None:
        """Curves as likely as the points leave them; see `draw_curves`."""
        if not self.allowed.can_draw:
            return None
        random = np.random.default_rng(seed)

        def batch() -> Floats:
            values = self.allowed.draw(count, random)
            return values if falling or self.a3 < 0 else values[values[:, 1] >= 0]

        return drawn_in_batches(batch, count)


def draw_curves(fit: CurveFit, count: int, seed: int = 1, *, falling: bool = False) -> Drawn | None:
    """Curves as likely as the points leave them, or as the repeats of a `RepeatedFit` do.

    a4 has the confidence distribution of the fit's profile likelihood, the others are t-distributed about the best ones
    for it, with the fit's degrees of freedom: quantiles of what follows from draws are profile-likelihood intervals.
    Draws beyond the bounds of the fit are drawn again. What the fit assumed is in all of them; where the points show no
    branch, the draws have those that they may hide.

    Parameters
    ----------
    fit : of a curve
    count : of the curves
    seed : the same gives the same draws
    falling : keep curves with a2 < 0 as well, which fall for ever: where the points do not show that friction rises
        again, leaving these out would make it look certain

    Returns
    -------
    Drawn or None
        None where the points are too few to draw any.
    """
    return fit.draw(count, seed, falling=falling)


def fit_curve(
    speed: ArrayLike, mu: ArrayLike, sigma: ArrayLike | None = None, *, unit: str = "m/s", law: str = "stribeck"
) -> CurveFit:
    """The friction curve nearest to measured points, by least squares.

    Parameters
    ----------
    speed : (n,) slip speeds, m/s, >= 0.
    mu : (n,) friction coefficients there.
    sigma : standard deviation of each mu, or one for all; None: taken from the residuals, with weights where these show
        that the scatter differs along the speed.
    unit : in which `quality` gives speeds.
    law : one of `vocabulary.models.LAWS` (stribeck_delta with delta = 2, Gaussian), or "best": that of the lowest AICc.

    Returns
    -------
    CurveFit
        All coefficients are >= 0 where the points show a declining branch. Where they fall all the way but do not
        determine four coefficients, a2 is taken as 0; where they show a rise from zero speed instead, a3 < 0; where
        they show neither, a3 = 0. A point that is no scatter of the others' (1 %, Monte Carlo) is left out.

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
    if law not in (*LAWS, BEST):
        raise ValueError(f"law: got {law!r}, expected {', '.join(LAWS)} or {BEST}")
    distinct = np.unique(w)
    if distinct.size < _FEWEST:
        raise ValueError(
            f"speed: got {distinct.size} distinct speed{'s' * (distinct.size != 1)}, expected at least {_FEWEST}: "
            "fewer cannot determine the four coefficients of the curve"
        )
    if not y.any():
        raise ValueError("mu: got nothing but 0, expected friction coefficients")
    by_law = {name: MeasuredPoints(w, y, deviation, name) for name in LAWS}
    criteria = {name: _criterion(points) for name, points in by_law.items()}
    chosen_law = min(LAWS, key=lambda name: criteria[name]) if law == BEST else law
    return _fitted(by_law[chosen_law], criteria, unit)


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


def _fitted(given: MeasuredPoints, criteria: Mapping[str, float], unit: str) -> CurveFit:
    """The curve through the points but outliers, weighted as their scatter asks for."""
    left_out = outliers(given)
    points = given.without(left_out)
    chosen = points.choose()
    allowed = Allowed(points, chosen)
    if points.deviation is None and (slope := allowed.uneven) is not None:
        points = replace(points, slope=slope)
        chosen = points.choose()
        allowed = Allowed(points, chosen)
    form, known = chosen.form, points.deviation is not None
    freedom = math.inf if known else float(points.freedom(form))
    residuals = points.mu - points.curve(chosen.best) * points.units[0]
    variance = 1.0 if known else points.left(chosen.best) / freedom if freedom > 0 else math.inf
    matrix = _covariance(points, chosen, variance)
    estimates = dict(zip(COEFFICIENTS, map(float, chosen.best * points.units), strict=True))
    estimates["mu_start"] = estimates["a1"] + estimates["a3"]
    at_bound = _at_bound(estimates, chosen, points)
    share = r_squared(points.mu, residuals, (points.weight / points.weight.max()) ** 2)
    nothing = dict.fromkeys(estimates, (0.0, math.inf))
    interval = allowed.intervals() if allowed.can_draw else nothing
    quality = Quality(chosen, estimates, interval, at_bound, points, rms(residuals), share, unit, criteria,
                      given, left_out)  # fmt: skip
    doubts = [*quality.shape()]
    reservations = [*quality.reservations(), *doubts]
    return CurveFit(
        **{name: estimates[name] for name in COEFFICIENTS},
        standard_error=_errors(matrix),
        interval=nothing if doubts else interval,  # intervals are those of the right curve
        covariance=matrix,
        freedom=freedom,
        speeds=(float(points.speed.min()), float(points.speed.max())),
        searched=(float(points.limits[0] * points.units[3]), float(points.limits[1] * points.units[3])),
        residual_rms=quality.residual_rms,
        r_squared=share,
        points=int(points.speed.size),
        unidentified=quality.unidentified(),
        assumed=form.assumed,
        at_bound=at_bound,
        outliers=left_out,
        scatter=math.exp(points.slope),
        determined=quality.determined(),
        has_intervals=allowed.can_draw and not doubts,
        good=not reservations,
        quality=" ".join(reservations) or quality.praise(),
        law=points.law,
        preferred=criteria["stribeck"] - criteria[points.law],
        allowed=allowed,
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
        if inside.deviation is None and (slope := Allowed(others, others.choose()).uneven) is not None:
            if _apart(replace(inside, slope=slope)) != position:
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
    """Of a1 to a4; inf on the diagonal where the points determine nothing."""
    fixed = [name in chosen.form.assumed or (name == "a4" and chosen.best[2] == 0) for name in COEFFICIENTS]
    unit = covariance(np.where(fixed, 0.0, points.jacobian(chosen.best) / points.units))
    with np.errstate(invalid="ignore"):
        matrix = np.where(unit == 0, 0.0, unit * variance)
    matrix[np.isinf(unit)] = np.inf
    return matrix


def _errors(matrix: Floats) -> dict[str, float]:
    certain = np.isfinite(matrix[0, 0]) and np.isfinite(matrix[2, 2])
    together = matrix[0, 0] + matrix[2, 2] + 2.0 * matrix[0, 2] if certain else math.inf
    errors = [*map(float, np.sqrt(np.diag(matrix))), math.sqrt(max(float(together), 0.0))]
    return dict(zip((*COEFFICIENTS, "mu_start"), errors, strict=True))


def _at_bound(estimates: Mapping[str, float], chosen: Chosen, points: MeasuredPoints) -> tuple[str, ...]:
    """Estimates, mu_start among them, at the end of the range that was allowed."""
    floor = {*chosen.form.nonnegative, "mu_start"} - {*chosen.form.assumed}
    bounded = (*COEFFICIENTS[:3], "mu_start")
    at_end = [name for name in bounded if name in floor and estimates[name] == 0.0]
    low, high = points.limits
    if chosen.form is not STRAIGHT and not low * (1 + _AT_END) < chosen.best[3] < high * (1 - _AT_END):
        at_end.append("a4")
    return tuple(at_end)
