"""Tempered sequential Monte Carlo: draws from a posterior and its evidence, from a log-likelihood of many points.

The prior is that of independent standard normal deviates (`Uncertain.values` makes quantities of them), so that no
bound of a quantity is a wall for the moves. A population goes from the prior to the posterior through likelihoods to
powers that rise from 0 to 1: each power is chosen so that half of the population is still worth something, then the
population is resampled, and moved by Metropolis steps drawn from its own covariance until it has forgotten where it
was, or forgets no more: modes that no move connects keep the share that the weights gave them. Whole populations are
evaluated at once, and the same generator gives the same draws.

Sources: Del Moral, Doucet and Jasra (2006), J. R. Stat. Soc. B 68, 411-436; the powers as Jasra, Stephens, Doucet and
Tsagaris (2011), Scand. J. Stat. 38, 1-22, choose them; the number of moves after Dau and Chopin (2022), same journal
as the first, 84, 114-148, who show that a fixed one is what goes wrong.
"""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]
LogLikelihood = Callable[[Floats], Floats]

_WORTH = 0.5  # effective share of a population after a change of the power
_TAKEN = 0.3  # share of moves that are to be accepted; between the optima of one dimension (0.44) and of many (0.23)
_FORGOTTEN = 0.1  # correlation with where it was before, from which on a population has forgotten it
_PATIENCE, _PROGRESS = 10, 0.95  # moves after which that correlation is to have fallen to such a share of its least
_MOST_MOVES = 200
_HALVINGS = 200  # of an interval of powers


@dataclass(frozen=True, eq=False)
class Population:
    """Draws from a posterior, all of the same weight.

    points : (n, dimensions), standard normal deviates. log_likelihood : of these. log_evidence : -inf where no point of
    the prior has a likelihood. evaluations : of the likelihood of one point.
    """

    points: Floats
    log_likelihood: Floats
    log_evidence: float
    evaluations: int


def tempered(log_likelihood: LogLikelihood, dimensions: int, size: int, rng: np.random.Generator) -> Population:
    """A population of `size` points of the posterior.

    log_likelihood : of points (n, dimensions), (n,); -inf is a value, NaN is none.
    """
    points = rng.standard_normal((size, dimensions))
    values = log_likelihood(points)
    power, log_evidence, evaluations, reach = 0.0, 0.0, size, 2.38 / np.sqrt(dimensions)
    while power < 1.0:
        weights, step = _reweighted(values, 1.0 - power)
        mean = float(weights.mean())
        if mean == 0.0:
            return Population(points, values, -np.inf, evaluations)
        best = float(np.max(values))
        log_evidence += np.log(mean) + step * best
        power = power + step if step < 1.0 - power else 1.0
        chosen = _resampled(weights, rng)
        points, values = points[chosen], values[chosen]
        points, values, moves, reach = _moved(log_likelihood, points, values, power, reach, rng)
        evaluations += moves * size
    return Population(points, values, float(log_evidence), evaluations)


def _reweighted(values: Floats, left: float) -> tuple[Floats, float]:
    """Weights, the largest of them 1, after the largest step of the power, at most `left`, that keeps `_WORTH`.

    Points without a likelihood are lost at the smallest step; the worth is counted among the others.
    """
    known = np.isfinite(values)
    if not known.any():
        return np.zeros(values.size), left
    differences = np.where(known, values - values[known].max(), -np.inf)

    def weights(step: float) -> Floats:
        return np.asarray(np.where(known, np.exp(step * np.where(known, differences, 0.0)), 0.0))

    def worth(step: float) -> float:
        w = weights(step)
        return float(w.sum() ** 2 / (w @ w) / known.sum())

    if worth(left) >= _WORTH:
        return weights(left), left
    low, high = 0.0, left
    for _ in range(_HALVINGS):
        middle = 0.5 * (low + high)
        low, high = (middle, high) if worth(middle) >= _WORTH else (low, middle)
        if high - low <= 1e-6 * high:
            break
    return weights(high), high


def _resampled(weights: Floats, rng: np.random.Generator) -> NDArray[np.intp]:
    """Numbers of points in proportion to their weights, systematically: each as often as it should be, but for one."""
    places = (np.arange(weights.size) + rng.random()) / weights.size
    return np.minimum(np.searchsorted(np.cumsum(weights) / weights.sum(), places), weights.size - 1)


def _moved(
    log_likelihood: LogLikelihood, points: Floats, values: Floats, power: float, reach: float,
    rng: np.random.Generator,
) -> tuple[Floats, Floats, int, float]:  # fmt: skip
    """The population after so many moves that it has forgotten where it was; how many, and the reach they had."""
    size, dimensions = points.shape
    spread = np.atleast_2d(np.cov(points, rowvar=False)) + 1e-12 * np.eye(dimensions)
    root = np.asarray(np.linalg.cholesky(spread), np.float64)
    first = _whitened(points, root)
    enough = max(_FORGOTTEN, 3.0 / np.sqrt(size))  # what chance alone makes of independent points
    least, waited = np.inf, 0
    moves = 0
    while moves < _MOST_MOVES and waited < _PATIENCE:
        moves += 1
        tried = points + reach * rng.standard_normal(points.shape) @ root.T
        moved = log_likelihood(tried)
        gain = power * (moved - values) + 0.5 * (np.sum(points**2, 1) - np.sum(tried**2, 1))
        taken = np.log(rng.random(size)) < gain
        points, values = np.where(taken[:, None], tried, points), np.where(taken, moved, values)
        reach = min(reach * float(np.exp(taken.mean() - _TAKEN)), 10.0)
        left = float(np.abs(np.mean(first * _whitened(points, root), axis=0)).max())
        least, waited = (left, 0) if left < _PROGRESS * least else (least, waited + 1)
        if left <= enough:
            break
    return points, values, moves, reach


def _whitened(points: Floats, root: Floats) -> Floats:
    """The points along independent directions, centred, each of variance 1."""
    white = np.linalg.solve(root, (points - points.mean(0)).T).T
    return np.asarray(white / np.maximum(white.std(0), 1e-300))
