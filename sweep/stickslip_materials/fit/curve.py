"""Measured points, the best curve a1 + a2 w + a3 shape(w/a4) of each form, and what the points leave open of it; a
fitted curve, and draws of those that the points allow beside it.

A form says which coefficients are free, and of what sign.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, NamedTuple

import numpy as np
import scipy  # type: ignore[import-untyped]
from numpy.typing import ArrayLike

from stickslip.theory.curve import SHAPES
from stickslip.vocabulary.models import BREAKAWAY, CURVE, FITTED
from stickslip_materials.fit.likelihood import Likelihood
from stickslip_materials.fit.uncertainty import CONFIDENCE, Flags, Floats, Interval, chance_of, rms, student

if TYPE_CHECKING:
    from stickslip_materials.fit.turns import SlowingLine

_BAND = 2000  # curves drawn for a band
_BATCHES = 200  # of draws, until enough of them lie within the bounds
_VISIBLE, _ROUNDING = 0.01, 1e-9  # of the span, of the friction: smaller residuals do no harm; are none
_SMOOTH = 3  # waves over the points that residuals may follow, each half a wave longer
_CERTAIN = 0.99  # confidence with which a branch must be seen
_TREND = 0.05  # chance of as many falls among points without a trend
_LEAST = 2  # points to spare for an interval, where the scatter is not given
_FEW, _WIDER = 3, 0.975  # with so few points to spare a branch that is seen was often seen by luck: 97.5 % cover 95 %


@dataclass(frozen=True)
class Form:
    """Curves whose a1, a2 and a3 are sums of `parts`, rows of three, of which the first `bounded` have weights >= 0.

    assumed : coefficients that the form fixes. nonnegative : those that cannot fall below 0.
    """

    parts: tuple[tuple[int, int, int], ...]
    bounded: int
    assumed: tuple[str, ...] = ()
    nonnegative: tuple[str, ...] = FITTED

    @property
    def whole(self) -> Form:
        """The form without what it fixes."""
        return self if self is STRENGTHENING else WEAKENING


WEAKENING = Form(((1, 0, 0), (0, 1, 0), (0, 0, 1)), 3)
FALLING = Form(((1, 0, 0), (0, 0, 1)), 2, assumed=("a2",))
# No branch: a straight line. a4 then means nothing.
STRAIGHT = Form(((1, 0, 0), (0, 1, 0)), 2, assumed=("a3", "a4"))
# a1 and mu_start = a1 + a3 are >= 0, with a slope of either sign.
STRENGTHENING = Form(((1, 0, -1), (0, 0, 1), (0, 1, 0)), 2, nonnegative=("a1", "a4", BREAKAWAY))
_COMBINED = {"a1": (1, 0, 0), "a2": (0, 1, 0), "a3": (0, 0, 1), BREAKAWAY: (1, 0, 1)}


class Chosen(NamedTuple):
    """The form of a curve, whether the points show its branch, and the best a1 to a4 in units of the points."""

    form: Form
    seen: bool
    best: Floats


class MeasuredPoints:
    """Speeds (m/s), friction, its standard deviations or None, and the law of the curve.

    left_out : how many were, since they stand apart: choosing them costs freedom. Curves through them have coefficients
    in `units`, the largest speed and friction being 1, so that nothing depends on their size; what they leave is
    weighted.
    """

    def __init__(self, speed: Floats, mu: Floats, deviation: Floats | None, law: str, left_out: int = 0) -> None:
        self.speed, self.mu, self.deviation, self.law, self.left_out = speed, mu, deviation, law, left_out
        slowest, fastest, most = float(speed[speed > 0].min()), float(speed.max()), float(mu.max())
        self.units = np.array([most, most / fastest, most, fastest])
        self.place, self.target = speed / fastest, mu / most
        self.limits = 0.1 * slowest / fastest, 50.0  # of a4: faster decay leaves e^-10 at the first point
        self.weight = np.ones_like(mu) if deviation is None else most / deviation
        self._likelihoods: dict[Form, Likelihood] = {}

    def of(self, which: Flags, left_out: int = 0) -> MeasuredPoints:
        """Some of the points."""
        deviation = None if self.deviation is None else self.deviation[which]
        return MeasuredPoints(self.speed[which], self.mu[which], deviation, self.law, left_out)

    def columns(self, a4: Floats) -> Floats:
        """What a1, a2 and a3 multiply, for each a4 (k,): (k, n, 3)."""
        columns = np.ones((a4.size, self.place.size, 3))
        columns[:, :, 1], columns[:, :, 2] = self.place, SHAPES[self.law](self.place / a4[:, None])
        return columns

    def freedom(self, form: Form) -> int:
        """Points to spare."""
        return self.speed.size - self.left_out - 4 + len(form.assumed)

    # --- curves -------------------------------------------------------------------------------------------------------

    def likelihood(self, form: Form) -> Likelihood:
        """Of the curves of a form."""
        if form not in self._likelihoods:
            spare = math.inf if self.deviation is not None else float(max(self.freedom(form), 0))
            reach = student(spare, _WIDER if _LEAST <= spare <= _FEW else CONFIDENCE)
            parts, model = np.array(form.parts, np.float64), (self.target, self.weight, self.columns, self.limits)
            self._likelihoods[form] = Likelihood(*model, parts, form.bounded, spare, reach)
        return self._likelihoods[form]

    def fit(self, form: Form) -> Floats:
        """The best a1 to a4."""
        if form is STRAIGHT:
            return np.array([*self._straight(falling=False)[0], 0.0, 1.0])
        likelihood = self.likelihood(form)
        return np.append(likelihood.solve(likelihood.scale)[0], math.exp(likelihood.scale))

    def choose(self) -> Chosen:
        """The form that the points ask for: weakening, unless they show none; then strengthening, falling, or none."""
        falls = scipy.stats.kendalltau(self.speed, self.mu, alternative="less").pvalue < _TREND  # by their order alone
        if self.freedom(WEAKENING) <= 0 and not falls:
            return Chosen(WEAKENING, False, self.fit(WEAKENING))
        for form in (WEAKENING, STRENGTHENING):
            if self.shows_branch(form):
                return Chosen(form, True, self.fit(form))
        if falls and (fall := self.fit(FALLING))[2] > 0:
            return Chosen(FALLING, True, fall)
        return Chosen(STRAIGHT, False, self.fit(STRAIGHT))

    def shows_branch(self, form: Form, confidence: float = _CERTAIN) -> bool:
        """True where the two coefficients of a branch lower the sum of squares by more than chance does."""
        best, freedom = self.fit(form), self.speed.size - 4
        rises = form is STRENGTHENING
        if rises and not (best[2] < 0 and self._rate(best) > 0):
            return False
        straight, left = self._straight(falling=rises)[1] ** 2, self.left(best)
        if straight <= _ROUNDING**2 * float(np.sum((self.target * self.weight) ** 2)):
            return False
        if self.deviation is not None:
            return straight - left > -2.0 * math.log(1.0 - confidence)  # the quantile of chi-squared of 2 degrees
        return freedom > 0 and straight > left * (1.0 - confidence) ** (-2.0 / freedom)  # F(2, freedom)

    def curve(self, a: Floats) -> Floats:
        """Friction at the points."""
        return np.asarray(self.columns(a[3:])[0] @ a[:3])

    def left(self, a: Floats) -> float:
        """The weighted sum of squares that a curve leaves."""
        return float(np.sum(((self.curve(a) - self.target) * self.weight) ** 2))

    def residuals(self, chosen: Chosen) -> tuple[Floats, Floats] | None:
        """The weighted residuals of a curve, and its derivatives; None where they are rounding, or few are to spare."""
        apart = self.curve(chosen.best) - self.target
        if self.freedom(chosen.form) < 2 or rms(apart) <= max(_VISIBLE * float(np.ptp(self.target)), _ROUNDING):
            return None
        free = [name not in chosen.form.assumed for name in CURVE]
        return apart * self.weight, self.jacobian(chosen.best)[:, free]

    def chance_of_shape(self, chosen: Chosen, residuals: Floats, jacobian: Floats) -> float:
        """The chance that points of this shape leave residuals that follow a curve as closely: one of another exponent
        of w/a4, or any smooth one."""
        place = np.argsort(np.argsort(self.speed)) / self.speed.size
        smooth = np.cos(math.pi * place[:, None] * np.arange(3, 3 + _SMOOTH)) * self.weight[:, None]
        z, step, shape = self.place / chosen.best[3], 1e-4, SHAPES[self.law]
        steeper = (shape(z ** (1.0 + step)) - shape(z)) * self.weight / step
        ways = [smooth, *([] if chosen.form is FALLING else [steeper[:, None]])]
        return min(chance_of(residuals, jacobian, way) for way in ways)

    def jacobian(self, a: Floats) -> Floats:
        """Derivatives of the curve with respect to a1 to a4, weighted; points by coefficients."""
        step = 1e-6 * a[3]
        below, here, above = self.columns(a[3] + step * np.array([-1.0, 0.0, 1.0]))
        columns = np.column_stack([here, a[2] * (above - below)[:, 2] / (2.0 * step)])
        return np.asarray(columns * self.weight[:, None])

    def _rate(self, a: Floats) -> float:
        """The slope of a curve at the slowest point."""
        slowest, step = float(self.place.min()), 1e-6 * a[3]
        weakening = SHAPES[self.law](np.array([slowest, slowest + step]) / a[3])
        return float(a[1] + a[2] * (weakening[1] - weakening[0]) / step)

    def _straight(self, falling: bool) -> tuple[Floats, float]:
        """The best straight line, and the norm of what it leaves."""
        columns = [np.ones_like(self.place), self.place, *([-self.place] if falling else [])]
        line, norm = scipy.optimize.nnls(np.column_stack(columns) * self.weight[:, None], self.target * self.weight)
        return line, float(norm)

    # --- what they leave open -----------------------------------------------------------------------------------------

    def can_draw(self, form: Form) -> bool:
        """True where points are to spare, so that their scatter is known."""
        return self.freedom(form.whole) >= (1 if self.deviation is not None else _LEAST)

    def intervals(self, form: Form) -> Mapping[str, Interval]:
        """Of a1 to a4 and of mu_start, in SI; an end that the points leave open is inf, or 0."""
        ends: dict[str, Interval] = dict.fromkeys(FITTED, (0.0, math.inf))
        if form is STRAIGHT or not self.can_draw(form):  # a branch that the points do not show may hide in any of them
            return ends
        likelihood, units = self.likelihood(form.whole), dict(zip(CURVE, self.units.tolist(), strict=True))
        slow, fast = likelihood.scale_interval
        ends["a4"] = slow * units["a4"], fast * units["a4"]
        # Slower than all points it is a straight line; without the rise that was taken away, not known.
        known = [BREAKAWAY] if form is FALLING else ["a2", BREAKAWAY] if math.isinf(fast) else [*_COMBINED]
        for name in known:
            row, unit = np.array(_COMBINED[name], np.float64), units.get(name, units["a1"])
            low, high = (end * unit for end in likelihood.interval(lambda _, row=row: row))  # type: ignore[misc]
            ends[name] = max(low, 0.0) if name in form.nonnegative else low, high
        if math.isinf(fast):
            ends["a2"] = ends["a2"][0], math.inf
        if slow == 0.0 and self.speed.min() > 0 and form is not STRENGTHENING:
            # a branch below the slowest point may be as steep as it likes
            ends |= {name: (ends[name][0], math.inf) for name in ("a3", BREAKAWAY)}
        return ends

    def draw(self, form: Form, count: int, random: np.random.Generator) -> Floats:
        """a1 to a4 of curves in SI, (count, 4) or fewer: those within the bounds of the form, but for a2, which may be
        < 0. Of points that show no branch: those with one they may hide, its a4 between the slowest and the fastest."""
        hidden = (float(self.place[self.place > 0].min()), 1.0) if form is STRAIGHT else None
        values, scale = self.likelihood(form.whole).draw(count, random, hidden)
        start, branch = values[:, 0] + values[:, 2], values[:, 2] <= 0 if form is STRENGTHENING else values[:, 2] >= 0
        inside = (values[:, 0] >= 0) & (start >= 0) & branch
        return np.asarray(np.column_stack([values, scale])[inside] * self.units)


# --- fitted curves ----------------------------------------------------------------------------------------------------


class Drawn(NamedTuple):
    """Curves drawn. coefficients : a1 to a4 by name, and mu_stop of a fit that has it, each (count,)."""

    coefficients: dict[str, Floats]


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
    outliers : positions of points that were left out.
    determined : whether the points tell where vibration ends; a material whose points do not is not ranked.
    has_intervals : whether what follows from the curve has an interval: points are to spare, and follow its shape.
    good : whether the curve may be used without reservation. quality : why, or why not, in plain words.
    law : of the curve.
    measured, form : points and form of the curve, which bands and draws come from.
    mu_stop : friction while the speed falls to 0, Eq. (2a); NaN where the points were not measured on the way down, or
        do not differ there. line : the points it follows from.
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
    assumed: tuple[str, ...]
    at_bound: tuple[str, ...]
    outliers: tuple[int, ...]
    has_intervals: bool
    law: str
    measured: MeasuredPoints = field(repr=False, compare=False)
    form: Form = field(repr=False, compare=False)
    unidentified: tuple[str, ...] = ()
    determined: bool = False
    good: bool = False
    quality: str = ""
    mu_stop: float = math.nan
    line: SlowingLine | None = field(default=None, repr=False, compare=False)

    @property
    def mu_start(self) -> float:
        """Friction coefficient at break-away, a1 + a3."""
        return self.a1 + self.a3

    @property
    def declines(self) -> bool:
        """True where friction falls from standstill on."""
        return self.a3 > 0

    def coefficients(self) -> dict[str, float]:
        """a1 to a4 by name, and mu_stop if there is one, as `evaluate` and `simulate` take them."""
        names = CURVE if math.isnan(self.mu_stop) else (*CURVE, "mu_stop")
        return {name: float(getattr(self, name)) for name in names}

    def row(self) -> dict[str, Floats]:
        """a1 to a4 as arrays of one, as those of curves drawn are."""
        return {name: np.array([getattr(self, name)]) for name in CURVE}

    def predict(self, speed: ArrayLike) -> Floats:
        """Friction coefficient at slip speeds (m/s)."""
        w = np.asarray(speed, np.float64)
        return np.asarray(self.a1 + self.a2 * w + self.a3 * SHAPES[self.law](w / self.a4))

    def band(self, speed: ArrayLike) -> tuple[Floats, Floats]:
        """Lower and upper end of the 95 % confidence band of the curve at slip speeds (m/s): quantiles of draws; not
        below 0, and infinite where none can be drawn.
        """
        w = np.asarray(speed, np.float64)
        if (drawn := self.draw(_BAND, falling=True)) is None:
            return np.zeros_like(w), np.full_like(w, np.inf)
        level, slope, drop, decay = (drawn.coefficients[name] for name in CURVE)
        curves = level + slope * w[..., None] + drop * SHAPES[self.law](w[..., None] / decay)
        low, high = np.quantile(curves, (0.025, 0.975), axis=-1)
        middle = self.predict(w)
        return np.minimum(np.maximum(low, 0.0), middle), np.maximum(high, middle)

    def draw(self, count: int, seed: int = 1, *, falling: bool = False) -> Drawn | None:
        """Curves as likely as the points leave them.

        a4 has the confidence distribution of the fit's profile likelihood, the others are t-distributed about the best
        ones for it, with the fit's degrees of freedom: quantiles of what follows from draws are profile-likelihood
        intervals. Draws beyond the bounds of the fit are drawn again. What the fit assumed is in all of them; where the
        points show no branch, the draws have those that they may hide.

        Parameters
        ----------
        count : of the curves
        seed : the same gives the same draws
        falling : include curves with a2 < 0, which fall for ever: where the points do not show that friction rises
            again, leaving these out would make it look certain

        Returns
        -------
        Drawn or None
            None where the points are too few to draw any.
        """
        if not self.measured.can_draw(self.form):
            return None
        random, inside = np.random.default_rng(seed), np.zeros((0, 4))
        for _ in range(_BATCHES):
            values = self.measured.draw(self.form, count, random)
            inside = np.concatenate([inside, values if falling or self.a3 < 0 else values[values[:, 1] >= 0]])
            if len(inside) >= count:
                coefficients = dict(zip(CURVE, inside[:count].T, strict=True))
                stop = {} if self.line is None else {"mu_stop": self.line.draw(coefficients, random)}
                return Drawn(coefficients | stop)
        return None


def draw_curves(fit: CurveFit, count: int, seed: int = 1, *, falling: bool = False) -> Drawn | None:
    """Curves as likely as the points leave them: `CurveFit.draw`."""
    return fit.draw(count, seed, falling=falling)
