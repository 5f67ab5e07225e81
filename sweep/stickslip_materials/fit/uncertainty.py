"""Least squares: what measured numbers may be, the uncertainty of results, and whether residuals follow something."""

import math

import numpy as np
import scipy  # type: ignore[import-untyped]
from numpy.typing import ArrayLike, NDArray

Floats = NDArray[np.float64]
Flags = NDArray[np.bool_]
Interval = tuple[float, float]

CONFIDENCE, TAILS = 0.95, (0.025, 0.975)
LEAST_EXPLAINED = 0.5  # share of the variance
_SINGULAR = 1e-12  # share of the largest singular value below which a direction is not determined at all
_LOST = 1e-6  # share of a direction below which the coefficients follow it


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


def chance_of(residuals: Floats, jacobian: Floats, directions: Floats) -> float:
    """The chance that mere scatter follows directions (n, k) as closely as weighted residuals (n,) of a fit do, beside
    what its coefficients follow, (n, p): by the share of their sum of squares, which has a beta distribution."""
    q, _ = np.linalg.qr(jacobian[:, (jacobian != 0).any(axis=0)])
    size = np.linalg.norm(directions, axis=0) + 1e-300
    along, share, _ = np.linalg.svd(directions / size - q @ (q.T @ directions / size), full_matrices=False)
    along = along[:, share > _LOST]
    count, freedom = along.shape[1], residuals.size - q.shape[1]
    if not 0 < count < freedom:
        return 1.0
    explained = float(np.sum((along.T @ residuals) ** 2) / np.sum(residuals**2))
    return float(scipy.stats.beta(0.5 * count, 0.5 * (freedom - count)).sf(explained))


def point_apart(residuals: Floats, jacobian: Floats) -> tuple[int, float]:
    """The position of the point that is farthest from the others, and the chance that mere scatter has one as far: as
    of a direction of its own (`chance_of`), times the number of points."""
    q, _ = np.linalg.qr(jacobian[:, (jacobian != 0).any(axis=0)])
    share = residuals**2 / np.maximum(1.0 - np.sum(q**2, axis=1), 1e-9) / np.sum(residuals**2)
    freedom, i = residuals.size - q.shape[1], int(np.argmax(share))
    chance = residuals.size * float(scipy.stats.beta(0.5, 0.5 * (freedom - 1)).sf(share[i])) if freedom > 1 else 1.0
    return i, chance
