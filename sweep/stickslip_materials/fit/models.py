"""Measured points, the best curve a1 + a2 w + a3 shape(w/a4) of each form, and what the points leave open of it.

A form says which coefficients are free, and of what sign.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
import scipy  # type: ignore[import-untyped]

from stickslip.theory.curve import SHAPES
from stickslip.vocabulary.models import BREAKAWAY, CURVE, FITTED
from stickslip_materials.fit.likelihood import Likelihood
from stickslip_materials.fit.uncertainty import CONFIDENCE, Flags, Floats, Interval, chance_of, rms, student

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

    Curves through them have coefficients in `units`, the largest speed and friction being 1, so that nothing depends on
    their size; what they leave is weighted.
    """

    def __init__(self, speed: Floats, mu: Floats, deviation: Floats | None, law: str) -> None:
        self.speed, self.mu, self.deviation, self.law = speed, mu, deviation, law
        slowest, fastest, most = float(speed[speed > 0].min()), float(speed.max()), float(mu.max())
        self.units = np.array([most, most / fastest, most, fastest])
        self.place, self.target = speed / fastest, mu / most
        self.limits = 0.1 * slowest / fastest, 50.0  # of a4: faster decay leaves e^-10 at the first point
        self.weight = np.ones_like(mu) if deviation is None else most / deviation
        self._likelihoods: dict[Form, Likelihood] = {}

    def of(self, which: Flags) -> MeasuredPoints:
        """Some of the points."""
        deviation = None if self.deviation is None else self.deviation[which]
        return MeasuredPoints(self.speed[which], self.mu[which], deviation, self.law)

    def columns(self, a4: Floats) -> Floats:
        """What a1, a2 and a3 multiply, for each a4 (k,): (k, n, 3)."""
        columns = np.ones((a4.size, self.place.size, 3))
        columns[:, :, 1], columns[:, :, 2] = self.place, SHAPES[self.law](self.place / a4[:, None])
        return columns

    def freedom(self, form: Form) -> int:
        """Points to spare."""
        return self.speed.size - 4 + len(form.assumed)

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
