"""Measured points with the form they ask for, and the curves they allow: intervals, bands, draws of one likelihood."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, replace
from functools import cached_property
from typing import NamedTuple

import numpy as np
from scipy import stats  # type: ignore[import-untyped]

from stickslip.fit.forms import COEFFICIENTS, FALLING, STRAIGHT, STRENGTHENING, WEAKENING, Form, ScaledPoints
from stickslip.fit.profile import Region
from stickslip.fit.residuals import Residuals
from stickslip.fit.uncertainty import CONFIDENCE, Floats, Interval, covariance, rms, student
from stickslip.theory.shapes import SHAPES

_VISIBLE, _ROUNDING = 0.01, 1e-9  # of the span, of the friction: smaller residuals do no harm; are none
_CERTAIN = 0.99  # confidence with which a branch must be seen
_TREND = 0.05  # chance of as many falls among points without a trend
_UNEVEN = 6.63  # by which the deviance falls where the scatter differs along the speed: chi-squared, 1 %
_LEAST = 2  # points to spare for an interval, where the scatter is not given
_FEW, _WIDER = 3, 0.975  # with so few points to spare a branch that is seen was often seen by luck: 97.5 % cover 95 %


@dataclass(frozen=True)
class MeasuredPoints:
    """Speeds (m/s), friction, its standard deviations or None, and the law of the curve.

    slope : of the logarithm of the scatter, over the range of log speeds; 0 for an even one.
    """

    speed: Floats
    mu: Floats
    deviation: Floats | None
    law: str
    slope: float = 0.0

    @cached_property
    def order(self) -> Floats:
        """The logarithms of the speeds over a range of 1, about their mean."""
        place = np.log(np.maximum(self.speed, self.speed[self.speed > 0].min() / 3.0))
        return np.asarray((place - place.mean()) / np.ptp(place))

    @cached_property
    def units(self) -> Floats:
        """Of a1 to a4 in the scaled points."""
        return np.array([self.mu.max(), self.mu.max() / self.speed.max(), self.mu.max(), self.speed.max()])

    @cached_property
    def scaled(self) -> ScaledPoints:
        """The points in their own units, weighted by 1 over their deviations."""
        weight = np.exp(-self.slope * self.order) if self.deviation is None else self.mu.max() / self.deviation
        return ScaledPoints(self.speed / self.speed.max(), self.mu / self.mu.max(), weight, self.law)

    def without(self, positions: tuple[int, ...]) -> MeasuredPoints:
        """The points, some left out."""
        if not positions:
            return self
        deviation = None if self.deviation is None else np.delete(self.deviation, positions)
        return MeasuredPoints(np.delete(self.speed, positions), np.delete(self.mu, positions), deviation, self.law)

    def residuals(self, chosen: Chosen) -> Residuals | None:
        """The residuals of a curve, weighted; None where they are rounding, or no points are to spare."""
        scaled = self.scaled
        apart = scaled.curve(chosen.best) - self.mu / self.units[0]
        span = float(np.ptp(self.mu)) / self.units[0]
        if self.freedom(chosen.form) < 1 or rms(apart) <= max(_VISIBLE * span, _ROUNDING):
            return None
        free = [name not in chosen.form.assumed for name in COEFFICIENTS]
        return Residuals(apart * scaled.weight, scaled.jacobian(chosen.best)[:, free], self.speed)

    def freedom(self, form: Form) -> int:
        """Points to spare."""
        return self.speed.size - 4 + len(form.assumed)


class Chosen(NamedTuple):
    """The form of a curve, whether the points show its branch, and the best a1 to a4 in units of the points."""

    form: Form
    seen: bool
    best: Floats


def chosen_form(points: MeasuredPoints) -> Chosen:
    """The form that the points ask for: weakening, unless they show none; then strengthening, falling, or no branch."""
    scaled, known = points.scaled, points.deviation is not None
    if points.freedom(WEAKENING) <= 0 and not falls(points.speed, points.mu):
        return Chosen(WEAKENING, False, scaled.fit(WEAKENING))

    def seen(best: Floats, falling: bool = False) -> bool:
        chi_squared = scaled.left(best) if known else None
        return is_seen(scaled.gain(best, falling), chi_squared, points.speed.size - 4)

    weak = scaled.fit(WEAKENING)
    if seen(weak):
        return Chosen(WEAKENING, True, weak)
    rise = scaled.fit(STRENGTHENING)
    if rise[2] < 0 and scaled.rate(rise) > 0 and seen(rise, falling=True):
        return Chosen(STRENGTHENING, True, rise)
    if falls(points.speed, points.mu) and (fall := scaled.fit(FALLING))[2] > 0:
        return Chosen(FALLING, True, fall)
    return Chosen(STRAIGHT, False, scaled.fit(STRAIGHT))


def is_seen(gain: float, chi_squared: float | None, freedom: int) -> bool:
    """Whether the two coefficients of a branch lower the sum of squares by more than chance does.

    gain : see `ScaledPoints.gain`. chi_squared : of the whole curve, where sigma is known. freedom : points left over.
    """
    if chi_squared is not None and chi_squared > 0:
        return gain * chi_squared > -2.0 * math.log(1.0 - _CERTAIN)  # the quantile of chi-squared of 2 degrees
    return freedom > 0 and gain > (1.0 - _CERTAIN) ** (-2.0 / freedom) - 1.0  # and of F(2, freedom), times 2/freedom


def falls(speed: Floats, mu: Floats) -> bool:
    """Whether friction falls over the whole range of speeds, by the order of the points alone (Kendall)."""
    return bool(stats.kendalltau(speed, mu, alternative="less").pvalue < _TREND)


class Allowed:
    """The curves that points allow, in SI: 95 % intervals by profile likelihood, and draws of the same likelihood."""

    def __init__(self, points: MeasuredPoints, chosen: Chosen) -> None:
        self._points, self._chosen = points, chosen
        form = chosen.form if chosen.form is STRENGTHENING else WEAKENING
        self._form = form
        known, spare = points.deviation is not None, points.freedom(form)
        few = not known and 0 < spare <= _FEW
        spare = spare if known or spare >= _LEAST else 0  # one tells nothing of the scatter
        even = replace(points, slope=0.0)
        self.region = Region(
            even.scaled.model, form.cone, math.inf if known and spare > 0 else float(spare),
            None if known else points.order, 1 if form is WEAKENING else None,
            student(spare, _WIDER if few else CONFIDENCE) if spare > 0 and not known else None,
        )  # fmt: skip

    @property
    def uneven(self) -> float | None:
        """The slope of a scatter that differs along the speed beyond doubt; None if it may be even."""
        slope, deviance = self.region.slope
        if self._points.residuals(self._chosen) is None:
            return None
        return slope if deviance > _UNEVEN and self._points.freedom(WEAKENING) > _FEW else None

    def intervals(self) -> Mapping[str, Interval]:
        """Of a1 to a4 and of mu_start; an end that the points leave open is inf, or 0."""
        form, units = self._chosen.form, self._points.units
        if form is STRAIGHT:  # a branch that the points do not show may hide in any of them
            return dict.fromkeys(("a1", "a2", "a3", "a4", "mu_start"), (0.0, math.inf))
        rows = np.array([[1.0, 0, 0], [0, 1, 0], [0, 0, 1], [1, 0, 1]])
        low, high = self.region.extent(lambda scale: np.broadcast_to(rows, (scale.size, 4, 3)))
        names = ("a1", "a2", "a3", "mu_start")
        best = np.append(self._chosen.best[:3], self._chosen.best[0] + self._chosen.best[2])
        ends = {
            name: (float(min(a, b) * unit), float(max(c, b) * unit))
            for name, a, b, c, unit in zip(names, low, best, high, units[[0, 1, 2, 0]], strict=True)
        }
        slow, fast = self.region.scale
        if slow == 0.0 and self._points.speed.min() > 0:  # a branch below the slowest point may be as steep as it likes
            ends |= (
                {name: (ends[name][0], math.inf) for name in ("a3", "mu_start")} if form is not STRENGTHENING else {}
            )
        if math.isinf(fast):  # a1 and a3 are one coefficient then, and with a2 a straight line
            ends |= {**dict.fromkeys(("a1", "a3"), (0.0, math.inf)), "a2": (ends["a2"][0], math.inf)}
        floor = (*form.nonnegative, "mu_start")
        ends = {name: (max(a, 0.0) if name in floor else a, b) for name, (a, b) in ends.items()}
        ends["a4"] = float(slow * units[3]), float(fast * units[3])
        if form is FALLING:  # without the rise that was assumed away, the others are not known
            ends |= dict.fromkeys(("a1", "a2", "a3"), (0.0, math.inf))
        return ends

    def friction(self, speed: Floats) -> tuple[Floats, Floats]:
        """Lower and upper ends of the friction coefficient at slip speeds (c,) in m/s."""
        u, size = speed / self._points.units[3], self._points.units[0]
        if self._chosen.form is STRAIGHT:
            low, high = self._line(np.column_stack([np.ones_like(u), u]))
            return low * size, high * size
        shape = SHAPES[self._points.law]

        def rows(scale: Floats) -> Floats:
            weakening = shape(u / scale[:, None])
            return np.stack([np.ones_like(weakening), np.broadcast_to(u, weakening.shape), weakening], axis=2)

        low, high = self.region.extent(rows)
        return np.broadcast_to(low, u.shape) * size, np.broadcast_to(high, u.shape) * size

    def _line(self, rows: Floats) -> tuple[Floats, Floats]:
        """The ends of combinations (c, 2) of the two coefficients of a straight line."""
        points = self._points
        basis = points.scaled.jacobian(self._chosen.best)[:, :2]
        spare = points.freedom(STRAIGHT)
        variance = 1.0 if points.deviation is not None else points.scaled.left(self._chosen.best) / spare
        error = np.sqrt(variance * np.einsum("ci,ij,cj->c", rows, covariance(basis), rows))
        reach = student(math.inf if points.deviation is not None else spare) * error
        middle = rows @ self._chosen.best[:2]
        return middle - reach, middle + reach

    @property
    def can_draw(self) -> bool:
        """Whether points are to spare, so that their scatter is known."""
        least = 1 if self._points.deviation is not None else _LEAST
        return self._points.freedom(self._form) >= least

    def draw(self, count: int, random: np.random.Generator) -> Floats:
        """a1 to a4 of curves, (count, 4) or fewer: those within the bounds of the form, but for a2, which may be < 0.

        Of points that show no branch: those with one they may hide, its a4 anywhere between the slowest and the
        fastest of them.
        """
        units, form = self._points.units, self._chosen.form
        speed = self._points.speed / units[3]
        hidden = (float(speed[speed > 0].min()), 1.0) if form is STRAIGHT else None
        values, scale = self.region.draw(count, random, hidden)
        start, branch = values[:, 0] + values[:, 2], values[:, 2] <= 0 if form is STRENGTHENING else values[:, 2] >= 0
        inside = (values[:, 0] >= 0) & (start >= 0) & branch
        return np.asarray(np.column_stack([values, scale])[inside] * units)
