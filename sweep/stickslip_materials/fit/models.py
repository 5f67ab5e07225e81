"""Forms of a friction curve a1 + a2 w + a3 shape(w/a4), and measured points with the best curve of each form.

A form says which coefficients are free, and of what sign.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import NamedTuple

import numpy as np
import scipy  # type: ignore[import-untyped]

from stickslip.theory.curve import SHAPES
from stickslip.vocabulary.models import CURVE
from stickslip_materials.fit.profile import Cone, Model, Region, bottom
from stickslip_materials.fit.uncertainty import CONFIDENCE, Floats, Interval, Residuals, rms, student

_VISIBLE, _ROUNDING = 0.01, 1e-9  # of the span, of the friction: smaller residuals do no harm; are none
_CERTAIN = 0.99  # confidence with which a branch must be seen
_TREND = 0.05  # chance of as many falls among points without a trend
_UNEVEN = 6.63  # by which the deviance falls where the scatter differs along the speed: chi-squared, 1 %
LEAST = 2  # points to spare for an interval, where the scatter is not given
_FEW, _WIDER = 3, 0.975  # with so few points to spare a branch that is seen was often seen by luck: 97.5 % cover 95 %


@dataclass(frozen=True)
class Form:
    """Curves whose a1, a2 and a3 are sums of `parts`, rows of three, with weights >= 0, and of `free` rows with any.

    assumed : coefficients that the form fixes. nonnegative : those that cannot fall below 0.
    """

    parts: tuple[tuple[int, int, int], ...]
    free: tuple[tuple[int, int, int], ...] = ()
    assumed: tuple[str, ...] = ()
    nonnegative: tuple[str, ...] = CURVE

    @property
    def whole(self) -> Form:
        """The form without what it fixes."""
        return self if self is STRENGTHENING else WEAKENING

    @cached_property
    def cone(self) -> Cone:
        """Its a1, a2 and a3."""
        return Cone(np.array([*self.parts, *self.free], np.float64), len(self.parts))


WEAKENING = Form(((1, 0, 0), (0, 1, 0), (0, 0, 1)))
FALLING = Form(((1, 0, 0), (0, 0, 1)), assumed=("a2",))
# No branch: a straight line. a4 then means nothing.
STRAIGHT = Form(((1, 0, 0), (0, 1, 0)), assumed=("a3", "a4"))
# a1 and mu_start = a1 + a3 are >= 0, with a slope of either sign.
STRENGTHENING = Form(((1, 0, -1), (0, 0, 1)), free=((0, 1, 0),), nonnegative=("a1", "a4"))


class Chosen(NamedTuple):
    """The form of a curve, whether the points show its branch, and the best a1 to a4 in units of the points."""

    form: Form
    seen: bool
    best: Floats


@dataclass(frozen=True)
class MeasuredPoints:
    """Speeds (m/s), friction, its standard deviations or None, and the law of the curve.

    slope : of the logarithm of the scatter, over the range of log speeds; 0 for an even one.
    Curves through them have coefficients in `units`, the largest speed and friction being 1, so that nothing depends on
    their size; what they leave is weighted.
    """

    speed: Floats
    mu: Floats
    deviation: Floats | None
    law: str
    slope: float = 0.0
    _fits: dict[Form, Floats] = field(default_factory=dict, init=False, repr=False, compare=False)
    _regions: dict[Form, Region] = field(default_factory=dict, repr=False, compare=False)  # of any slope

    @cached_property
    def order(self) -> Floats:
        """The logarithms of the speeds over a range of 1, about their mean."""
        place = np.log(np.maximum(self.speed, self.speed[self.speed > 0].min() / 3.0))
        return np.asarray((place - place.mean()) / np.ptp(place))

    @cached_property
    def units(self) -> Floats:
        """Of a1 to a4."""
        return np.array([self.mu.max(), self.mu.max() / self.speed.max(), self.mu.max(), self.speed.max()])

    @cached_property
    def place(self) -> Floats:
        """The speeds in units of the largest."""
        return np.asarray(self.speed / self.units[3])

    @cached_property
    def target(self) -> Floats:
        """The friction in units of the largest."""
        return np.asarray(self.mu / self.units[0])

    @cached_property
    def weight(self) -> Floats:
        """1 over the deviations, in any unit."""
        known = self.deviation
        return np.asarray(np.exp(-self.slope * self.order) if known is None else self.mu.max() / known)

    @cached_property
    def limits(self) -> Interval:
        """Between which a4 is searched."""
        return 0.1 * float(self.place[self.place > 0].min()), 50.0  # faster decay leaves e^-10 at the first point

    @cached_property
    def model(self) -> Model:
        """Linear in a1, a2 and a3 for a given a4."""
        lines = np.column_stack([np.ones_like(self.place), self.place])
        return Model(
            self.target, self.weight, lines, lambda a4: SHAPES[self.law](self.place / a4[:, None]), self.limits
        )

    def without(self, positions: tuple[int, ...]) -> MeasuredPoints:
        """The points, some left out."""
        if not positions:
            return self
        deviation = None if self.deviation is None else np.delete(self.deviation, positions)
        return MeasuredPoints(np.delete(self.speed, positions), np.delete(self.mu, positions), deviation, self.law)

    def freedom(self, form: Form) -> int:
        """Points to spare."""
        return self.speed.size - 4 + len(form.assumed)

    def region(self, form: Form) -> Region:
        """The range of scales that the points allow of a form, whatever the slope: it is searched."""
        if form not in self._regions:
            known, spare = self.deviation is not None, self.freedom(form)
            few = not known and 0 < spare <= _FEW
            spare = spare if known or spare >= LEAST else 0  # one tells nothing of the scatter
            self._regions[form] = Region(
                replace(self, slope=0.0).model, form.cone, math.inf if known and spare > 0 else float(spare),
                None if known else self.order, 1 if form is WEAKENING else None,
                student(spare, _WIDER if few else CONFIDENCE) if spare > 0 and not known else None,
            )  # fmt: skip
        return self._regions[form]

    def uneven(self, chosen: Chosen) -> float | None:
        """The slope of a scatter that differs along the speed beyond doubt; None if it may be even, or is given."""
        if self.deviation is not None or self.residuals(chosen) is None:
            return None
        slope, deviance = self.region(chosen.form.whole).slope
        return slope if deviance > _UNEVEN and self.freedom(WEAKENING) > _FEW else None

    # --- curves -------------------------------------------------------------------------------------------------------

    def fit(self, form: Form) -> Floats:
        """The best a1 to a4."""
        if form not in self._fits:
            if form is STRAIGHT:
                line, _ = self._straight(falling=False)
                self._fits[form] = np.array([line[0], line[1], 0.0, 1.0])
            else:
                a4 = bottom(lambda scale: self.model.solve(scale, form.cone).left, self.model.grid)
                self._fits[form] = np.append(self.model.solve(np.array([a4]), form.cone).values[0], a4)
        return self._fits[form]

    def choose(self) -> Chosen:
        """The form that the points ask for: weakening, unless they show none; then strengthening, falling, or none."""
        if self.freedom(WEAKENING) <= 0 and not self.falls():
            return Chosen(WEAKENING, False, self.fit(WEAKENING))
        weak = self.fit(WEAKENING)
        if self._shows(weak):
            return Chosen(WEAKENING, True, weak)
        rise = self.fit(STRENGTHENING)
        if rise[2] < 0 and self._rate(rise) > 0 and self._shows(rise, falling=True):
            return Chosen(STRENGTHENING, True, rise)
        if self.falls() and (fall := self.fit(FALLING))[2] > 0:
            return Chosen(FALLING, True, fall)
        return Chosen(STRAIGHT, False, self.fit(STRAIGHT))

    def falls(self) -> bool:
        """True where friction falls over the whole range of speeds, by the order of the points alone (Kendall)."""
        return bool(scipy.stats.kendalltau(self.speed, self.mu, alternative="less").pvalue < _TREND)

    def _shows(self, a: Floats, falling: bool = False) -> bool:
        """True where the two coefficients of a branch lower the sum of squares by more than chance does."""
        gain, freedom = self.gain(a, falling), self.speed.size - 4
        if self.deviation is not None and (chi_squared := self.left(a)) > 0:
            return gain * chi_squared > -2.0 * math.log(1.0 - _CERTAIN)  # the quantile of chi-squared of 2 degrees
        return freedom > 0 and gain > (1.0 - _CERTAIN) ** (-2.0 / freedom) - 1.0  # of F(2, freedom), times 2/freedom

    def curve(self, a: Floats) -> Floats:
        """Friction at the points."""
        return np.asarray(a[0] + a[1] * self.place + a[2] * SHAPES[self.law](self.place / a[3]))

    def left(self, a: Floats) -> float:
        """The weighted sum of squares that a curve leaves."""
        return float(np.sum(((self.curve(a) - self.target) * self.weight) ** 2))

    def gain(self, a: Floats, falling: bool = False) -> float:
        """The part of what a curve leaves by which a straight line, which may be falling, leaves more."""
        straight = self._straight(falling)[1] ** 2
        if straight <= _ROUNDING**2 * float(np.sum((self.target * self.weight) ** 2)):
            return 0.0
        left = self.left(a)
        return math.inf if left == 0 else (straight - left) / left

    def residuals(self, chosen: Chosen) -> Residuals | None:
        """The residuals of a curve, weighted; None where they are rounding, or no points are to spare."""
        apart = self.curve(chosen.best) - self.target
        span = float(np.ptp(self.mu)) / self.units[0]
        if self.freedom(chosen.form) < 1 or rms(apart) <= max(_VISIBLE * span, _ROUNDING):
            return None
        free = [name not in chosen.form.assumed for name in CURVE]
        return Residuals(apart * self.weight, self.jacobian(chosen.best)[:, free], self.speed)

    def jacobian(self, a: Floats) -> Floats:
        """Derivatives of the curve with respect to a1 to a4, weighted; points by coefficients."""
        step = 1e-6
        ends = a[3] * np.array([1.0 - step, 1.0 + step])
        below, above = SHAPES[self.law](self.place / ends[:, None])
        scale = a[2] * (above - below) / np.ptp(ends)
        columns = [np.ones_like(self.place), self.place, SHAPES[self.law](self.place / a[3]), scale]
        return np.asarray(np.column_stack(columns) * self.weight[:, None])

    def steepened(self, a: Floats) -> Floats:
        """Derivative by d, about 1, of a curve of the shape with (w/a4)^d for w/a4, weighted."""
        z, step, shape = self.place / a[3], 1e-4, SHAPES[self.law]
        return np.asarray((shape(z ** (1.0 + step)) - shape(z)) * self.weight / step)

    def _rate(self, a: Floats) -> float:
        slowest, step = float(self.place.min()), 1e-6 * a[3]
        weakening = SHAPES[self.law](np.array([slowest, slowest + step]) / a[3])
        return float(a[1] + a[2] * (weakening[1] - weakening[0]) / step)

    def _straight(self, falling: bool) -> tuple[Floats, float]:
        """The best straight line, and the norm of what it leaves."""
        columns = [np.ones_like(self.place), self.place, *([-self.place] if falling else [])]
        line, norm = scipy.optimize.nnls(np.column_stack(columns) * self.weight[:, None], self.target * self.weight)
        return line, float(norm)
