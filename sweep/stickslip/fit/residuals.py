"""What residuals say against a fit: another shape, a point apart.

Residuals of a fit are not independent: they are the scatter less what the coefficients could follow, which with few
points is most of it. So each statistic is compared with that of residuals of scatter drawn at random, under the same
projection; then it has its nominal level at any number of points (Dufour et al. 2004, Monte Carlo tests).
"""

from __future__ import annotations

import math

import numpy as np

from stickslip.fit.uncertainty import Floats

_DRAWN = 999
_SEED = 20


class Residuals:
    """Weighted residuals of a fit (n,) beside drawn ones; `jacobian` (n, p) spans what the coefficients follow."""

    def __init__(self, residuals: Floats, jacobian: Floats, speed: Floats) -> None:
        q, _ = np.linalg.qr(jacobian[:, (jacobian != 0).any(axis=0)])
        drawn = np.random.default_rng(_SEED).standard_normal((_DRAWN, residuals.size))
        self._all = np.vstack([residuals, drawn - drawn @ q @ q.T])
        self._free = np.sqrt(np.maximum(1.0 - np.sum(q**2, axis=1), 1e-9))
        self._q, self._speed = q, speed

    def _chance(self, statistic: Floats) -> float:
        """The share of drawn residuals with at least the first one's statistic."""
        return float(np.mean(statistic[1:] >= statistic[0] * (1 - 1e-12)) * _DRAWN + 1.0) / (_DRAWN + 1.0)

    def chance_of_runs(self) -> float:
        """Of neighbours over the speed as alike: the ratio of von Neumann (1941), repetitions at a speed being one."""
        _, group = np.unique(self._speed, return_inverse=True)
        mean = np.stack([np.bincount(group, one) for one in self._all]) / np.bincount(group)
        return self._chance(-np.sum(np.diff(mean, axis=1) ** 2, axis=1) / np.sum(mean**2, axis=1))

    def chance_of(self, direction: Floats) -> float:
        """Of residuals that follow a direction (n,) as well."""
        left = direction - self._q @ (self._q.T @ direction)
        return self._chance((self._all @ left) ** 2 / np.sum(self._all**2, axis=1))

    def outlier(self, freedom: float) -> tuple[int, float, float]:
        """The point that is farthest from the curve of the others: its position, in how many of their standard
        deviations, and the chance that one is as far. freedom : points to spare; inf where deviations are known."""
        each = self._all / self._free
        if math.isfinite(freedom):
            total = np.sum(self._all**2, axis=1, keepdims=True)
            each = each / np.sqrt(np.maximum((total - each**2) / max(freedom - 1.0, 1.0), 1e-30 * total))
        largest = np.abs(each).max(axis=1)
        return int(np.argmax(np.abs(each[0]))), float(largest[0]), self._chance(largest)
