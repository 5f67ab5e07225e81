"""Least squares and the uncertainty of its results."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy import special  # type: ignore[import-untyped]

Floats = NDArray[np.float64]
Flags = NDArray[np.bool_]
Interval = tuple[float, float]

CONFIDENCE = 0.95
_SINGULAR = 1e-12  # share of the largest singular value below which a direction is not determined at all


def points_of(name: str, values: ArrayLike, length: int | None = None, minimum: float = 0.0) -> Floats:
    """Measured numbers as an array of doubles. Raises ValueError naming the first that is impossible.

    length : how many there must be, None for any number. minimum : smallest value allowed.
    """
    array = np.atleast_1d(np.asarray(values, np.float64))
    if array.ndim != 1 or (length is not None and array.size != length):
        wanted = "one row of numbers" if length is None else f"{length} numbers, one for each point"
        raise ValueError(f"{name}: got the shape {array.shape}, expected {wanted}")
    wrong = ~np.isfinite(array) | (array < minimum)
    if wrong.any():
        i = int(np.argmax(wrong))
        raise ValueError(f"{name}[{i}]: got {array[i]:g}, expected a finite number >= {minimum:g}")
    return array


def student(freedom: int | float, confidence: float = CONFIDENCE) -> float:
    """How many standard errors the confidence interval reaches to either side; freedom inf: at 95 % the normal 1.96."""
    if freedom <= 0:
        return math.inf
    upper = 0.5 + 0.5 * confidence
    return float(special.ndtri(upper) if math.isinf(freedom) else special.stdtrit(freedom, upper))


def covariance(jacobian: Floats) -> Floats:
    """(J^T J)^-1, parameters by parameters, for residuals of unit variance; inf where they determine nothing.

    jacobian : points by parameters.
    """
    scale = np.linalg.norm(jacobian, axis=0)
    scale = np.where(scale > 0, scale, 1.0)
    _, singular, directions = np.linalg.svd(jacobian / scale, full_matrices=False)
    known = singular > _SINGULAR * singular[0]
    inverse = directions.T / np.where(known, singular, 1.0)
    found = np.asarray(inverse[:, known] @ inverse[:, known].T) / np.outer(scale, scale)
    lost = (np.abs(directions[~known]) > 1e-6).any(axis=0)
    found[lost, :] = found[:, lost] = 0.0
    found[lost, lost] = np.inf
    return np.asarray(found)


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
