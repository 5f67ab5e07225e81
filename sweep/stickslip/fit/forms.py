"""The least-squares search for a Stribeck curve a1 + a2 w + a3 exp(-w/a4), within one of its forms.

A form says which coefficients are free and of what sign. For any a4 the others follow from a linear problem, so the
search for a start is one over a4 alone; what it finds best is polished with all of them.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from scipy.optimize import least_squares, nnls  # type: ignore[import-untyped]

from stickslip.fit.uncertainty import Floats
from stickslip.theory import stribeck

COEFFICIENTS = ("a1", "a2", "a3", "a4")

_TRIED = 80  # values of a4 tried for a start
_STARTS = 4  # of those, how many are followed to the bottom
_ROUNDING = 1e-9  # of the friction: smaller residuals are none


@dataclass(frozen=True)
class Form:
    """Curves whose a1, a2 and a3 are sums of `parts`, rows of three, with weights >= 0.

    assumed : coefficients that are 0 in all of them. nonnegative : those that cannot fall below 0.
    """

    parts: tuple[tuple[float, float, float], ...]
    assumed: tuple[str, ...] = ()
    nonnegative: tuple[str, ...] = COEFFICIENTS


WEAKENING = Form(((1, 0, 0), (0, 1, 0), (0, 0, 1)))
FALLING = Form(((1, 0, 0), (0, 0, 1)), assumed=("a2",))
# a1 and mu_start = a1 + a3 are >= 0, with a slope of either sign.
STRENGTHENING = Form(((1, 0, -1), (0, 0, 1), (0, 1, 0), (0, -1, 0)), nonnegative=("a1", "a4"))


class ScaledPoints:
    """Measured points with the largest speed, friction and deviation as units, so that nothing depends on their size.

    limits : between which a4 is searched, in units of the largest speed.
    """

    def __init__(self, speed: Floats, mu: Floats, deviation: Floats) -> None:
        self._u, self._weight = speed, 1.0 / deviation
        self._target = mu * self._weight
        self.limits = (0.1 * float(speed[speed > 0].min()), 50.0)  # faster decay leaves e^-10 at the first point

    def fit(self, form: Form) -> Floats:
        """The best a1 to a4."""
        parts = np.array(form.parts, np.float64)
        tried = np.geomspace(*self.limits, _TRIED)
        left = np.array([self._linear(a4, parts)[1] for a4 in tried])
        before, after = np.append(np.inf, left[:-1]), np.append(left[1:], np.inf)
        valleys = np.flatnonzero((left <= before) & (left <= after))
        ends = [self._polished(tried[i], parts) for i in valleys[np.argsort(left[valleys])][:_STARTS]]
        weights, a4, _ = min(ends, key=lambda end: end[2])
        return np.append(weights @ parts, a4)

    def left(self, a: Floats) -> float:
        """The weighted sum of squares that a curve leaves."""
        return float(np.sum((stribeck(self._u, *a) * self._weight - self._target) ** 2))

    def gain(self, a: Floats, falling: bool = False) -> float:
        """How much less than a straight line a curve leaves, as a share of what it leaves itself.

        falling : whether the line may fall.
        """
        columns = [np.ones_like(self._u), self._u, *([-self._u] if falling else [])]
        straight = float(nnls(np.column_stack(columns) * self._weight[:, None], self._target)[1]) ** 2
        if straight <= _ROUNDING**2 * float(self._target @ self._target):
            return 0.0
        left = self.left(a)
        return math.inf if left == 0 else (straight - left) / left

    def jacobian(self, a: Floats) -> Floats:
        """Derivatives of the curve with respect to a1 to a4, weighted; points by coefficients."""
        basis = self._basis(a[3])
        return np.column_stack([basis, a[2] * basis[:, 2] * self._u / a[3] ** 2])

    def _basis(self, a4: float) -> Floats:
        """What a1, a2 and a3 multiply, weighted; points by three."""
        columns = [np.ones_like(self._u), self._u, np.exp(-self._u / a4)]
        return np.asarray(np.column_stack(columns) * self._weight[:, None])

    def _linear(self, a4: float, parts: Floats) -> tuple[Floats, float]:
        """The best weights of the parts for a given a4, and the norm of the residuals."""
        found, norm = nnls(self._basis(a4) @ parts.T, self._target)
        return found, float(norm)

    def _polished(self, a4: float, parts: Floats) -> tuple[Floats, float, float]:
        """Downhill from the best with a given a4: weights, a4, the norm of the residuals."""
        start, _ = self._linear(a4, parts)
        low, high = self.limits
        count = len(parts)

        def curve(p: Floats) -> Floats:
            return np.append(p[:-1] @ parts, p[-1])

        def slopes(p: Floats) -> Floats:
            full = self.jacobian(curve(p))
            return np.column_stack([full[:, :3] @ parts.T, full[:, 3]])

        run = least_squares(
            lambda p: stribeck(self._u, *curve(p)) * self._weight - self._target,
            np.append(start, a4),
            jac=slopes,
            bounds=([0.0] * count + [low * 0.999], [np.inf] * count + [high * 1.001]),
            x_scale=[1.0] * count + [a4],
            ftol=1e-14,
            xtol=1e-12,
            gtol=1e-14,
            max_nfev=200,
        )
        found = float(run.x[-1])
        weights, norm = self._linear(found, parts)  # a coefficient at its bound is 0, not almost
        return weights, found, norm
