"""Least squares, the uncertainty of its results, and what residuals say against a fit: another shape, a point apart.

Residuals of a fit are not independent: they are the scatter less what the coefficients could follow, which with few
points is most of it. So each statistic is compared with that of residuals of scatter drawn at random, under the same
projection; then it has its nominal level at any number of points (Dufour et al. 2004, Monte Carlo tests).
"""

import math

import numpy as np
import scipy  # type: ignore[import-untyped]
from numpy.typing import ArrayLike, NDArray

Floats = NDArray[np.float64]
Flags = NDArray[np.bool_]
Interval = tuple[float, float]

CONFIDENCE = 0.95
LEAST_EXPLAINED = 0.5  # share of the variance
_SINGULAR = 1e-12  # share of the largest singular value below which a direction is not determined at all
_DRAWN, _SEED = 999, 20  # residuals drawn


def points_of(name: str, values: ArrayLike, length: int | None = None, minimum: float = 0.0) -> Floats:
    """Measured numbers as an array of doubles. Raises ValueError naming the first that is impossible.

    length : how many there must be, None for any number. minimum : smallest value allowed.
    """
    array = np.atleast_1d(np.asarray(values, np.float64))
    if array.ndim != 1 or (length is not None and array.size != length):
        expected = "one row of numbers" if length is None else f"{length} numbers, one for each point"
        raise ValueError(f"{name}: got the shape {array.shape}, expected {expected}")
    wrong = ~np.isfinite(array) | (array < minimum)
    if wrong.any():
        i = int(np.argmax(wrong))
        least = f" >= {minimum:g}" if math.isfinite(minimum) else ""
        raise ValueError(f"{name}[{i}]: got {array[i]:g}, expected a finite number{least}")
    return array


def student(freedom: int | float, confidence: float = CONFIDENCE) -> float:
    """Standard errors that the confidence interval reaches to either side; freedom inf: at 95 % the normal 1.96."""
    if freedom <= 0:
        return math.inf
    upper = 0.5 + 0.5 * confidence
    return float(scipy.special.ndtri(upper) if math.isinf(freedom) else scipy.special.stdtrit(freedom, upper))


def covariance(jacobian: Floats) -> Floats:
    """(J^T J)^-1, parameters by parameters, for residuals of unit variance; inf where they determine nothing.

    jacobian : points by parameters.
    """
    scale = np.linalg.norm(jacobian, axis=0)
    scale = np.where(scale > 0, scale, 1.0)
    _, singular, directions = np.linalg.svd(jacobian / scale, full_matrices=False)
    known = singular > _SINGULAR * singular[0]
    inverse = directions.T / np.where(known, singular, 1.0)
    matrix = np.asarray(inverse[:, known] @ inverse[:, known].T) / np.outer(scale, scale)
    lost = (np.abs(directions[~known]) > 1e-6).any(axis=0)
    matrix[lost, :] = matrix[:, lost] = 0.0
    matrix[lost, lost] = np.inf
    return np.asarray(matrix)


def r_squared(values: Floats, residuals: Floats, weights: Floats) -> float:
    """Share of the (weighted) variance of the values that the fit explains; NaN if they do not vary."""
    spread = values - np.average(values, weights=weights)
    total = float(np.sum(weights * spread**2))
    if total <= 1e-28 * float(np.sum(weights * values**2)):
        return math.nan
    return 1.0 - float(np.sum(weights * residuals**2)) / total


def rms(residuals: Floats) -> float:
    """Root mean square."""
    return float(np.sqrt(np.mean(residuals**2)))


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
        mean = np.stack([np.bincount(group, residuals) for residuals in self._all]) / np.bincount(group)
        return self._chance(-np.sum(np.diff(mean, axis=1) ** 2, axis=1) / np.sum(mean**2, axis=1))

    def chance_of(self, direction: Floats) -> float:
        """Of residuals that follow a direction (n,) as well."""
        return self._chance(self._along(direction))

    def share_of(self, direction: Floats) -> float:
        """The share of the sum of squares that a direction (n,) explains."""
        return float(self._along(direction)[0])

    def _along(self, direction: Floats) -> Floats:
        left = direction - self._q @ (self._q.T @ direction)
        square = float(left @ left)
        if square <= 1e-9 * float(direction @ direction):  # the coefficients follow it
            return np.zeros(len(self._all))
        return np.asarray((self._all @ left) ** 2 / (np.sum(self._all**2, axis=1) * square))

    def outlier(self, freedom: float) -> tuple[int, float]:
        """The position of the point that is farthest from the curve of the others, in their standard deviations, and
        the chance that one is as far. freedom : points to spare; inf where deviations are known."""
        each = self._all / self._free
        if math.isfinite(freedom):
            total = np.sum(self._all**2, axis=1, keepdims=True)
            each = each / np.sqrt(np.maximum((total - each**2) / max(freedom - 1.0, 1.0), 1e-30 * total))
        return int(np.argmax(np.abs(each[0]))), self._chance(np.abs(each).max(axis=1))
