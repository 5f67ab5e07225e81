"""The forms of a friction curve a1 + a2 w + a3 shape(w/a4): which coefficients are free, and of what sign."""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from scipy.optimize import nnls  # type: ignore[import-untyped]

from stickslip.fit.profile import Cone, Model, bottom
from stickslip.fit.uncertainty import Floats
from stickslip.theory.shapes import SHAPES

COEFFICIENTS = ("a1", "a2", "a3", "a4")
_ROUNDING = 1e-9  # of the friction: smaller residuals are none


@dataclass(frozen=True)
class Form:
    """Curves whose a1, a2 and a3 are sums of `parts`, rows of three, with weights >= 0, and of `free` rows with any.

    assumed : coefficients that the form fixes. nonnegative : those that cannot fall below 0.
    """

    parts: tuple[tuple[int, int, int], ...]
    free: tuple[tuple[int, int, int], ...] = ()
    assumed: tuple[str, ...] = ()
    nonnegative: tuple[str, ...] = COEFFICIENTS

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


class ScaledPoints:
    """Measured points with the largest speed and friction as units, so that nothing depends on their size.

    weight : 1 over the deviations, in any unit. limits : between which a4 is searched, in units of the largest speed.
    """

    def __init__(self, speed: Floats, mu: Floats, weight: Floats, law: str) -> None:
        self.speed, self.target, self.weight, self._shape = speed, mu, weight, SHAPES[law]
        slowest = float(speed[speed > 0].min())
        self.limits = (0.1 * slowest, 50.0)  # faster decay leaves e^-10 at the first point
        lines = np.column_stack([np.ones_like(speed), speed])
        self.model = Model(mu, weight, lines, lambda a4: self._shape(speed / a4[:, None]), self.limits)
        self._best: dict[Form, Floats] = {}

    def fit(self, form: Form) -> Floats:
        """The best a1 to a4."""
        if form not in self._best:
            self._best[form] = self._fitted(form)
        return self._best[form]

    def _fitted(self, form: Form) -> Floats:
        if form is STRAIGHT:
            line, _ = self._straight(falling=False)
            return np.array([line[0], line[1], 0.0, 1.0])
        a4 = bottom(lambda scale: self.model.solve(scale, form.cone).left, self.model.grid)
        return np.append(self.model.solve(np.array([a4]), form.cone).values[0], a4)

    def curve(self, a: Floats) -> Floats:
        """Friction at the points."""
        return np.asarray(a[0] + a[1] * self.speed + a[2] * self._shape(self.speed / a[3]))

    def left(self, a: Floats) -> float:
        """The weighted sum of squares that a curve leaves."""
        return float(np.sum(((self.curve(a) - self.target) * self.weight) ** 2))

    def gain(self, a: Floats, falling: bool = False) -> float:
        """How much less than a straight line a curve leaves, as a share of what it leaves itself.

        falling : whether the line may fall.
        """
        straight = self._straight(falling)[1] ** 2
        if straight <= _ROUNDING**2 * float(np.sum((self.target * self.weight) ** 2)):
            return 0.0
        left = self.left(a)
        return math.inf if left == 0 else (straight - left) / left

    def jacobian(self, a: Floats) -> Floats:
        """Derivatives of the curve with respect to a1 to a4, weighted; points by coefficients."""
        step = 1e-6
        ends = a[3] * np.array([1.0 - step, 1.0 + step])
        below, above = self._shape(self.speed / ends[:, None])
        columns = [
            np.ones_like(self.speed),
            self.speed,
            self._shape(self.speed / a[3]),
            a[2] * (above - below) / np.ptp(ends),
        ]
        return np.asarray(np.column_stack(columns) * self.weight[:, None])

    def rate(self, a: Floats) -> float:
        """The slope of a curve at the slowest point."""
        slowest, step = float(self.speed.min()), 1e-6 * a[3]
        weakening = self._shape(np.array([slowest, slowest + step]) / a[3])
        return float(a[1] + a[2] * (weakening[1] - weakening[0]) / step)

    def steepened(self, a: Floats) -> Floats:
        """How a curve of the shape with (w/a4)^d for w/a4 differs from this one, weighted, by d about 1."""
        z, step = self.speed / a[3], 1e-4
        return np.asarray((self._shape(z ** (1.0 + step)) - self._shape(z)) * self.weight / step)

    def _straight(self, falling: bool) -> tuple[Floats, float]:
        """The best straight line, and the norm of what it leaves."""
        columns = [np.ones_like(self.speed), self.speed, *([-self.speed] if falling else [])]
        line, norm = nnls(np.column_stack(columns) * self.weight[:, None], self.target * self.weight)
        return line, float(norm)
