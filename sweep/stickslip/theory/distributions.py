"""Distributions of one number, as maps from a standard normal deviate.

`at(z)` gives the value whose probability of not being exceeded is that of the normal deviate z. So points in the unit
cube, normal deviates, correlated deviates (a Gaussian copula) and the walks of subset simulation all go through one
map, and both tails keep their digits: near 1 a probability has lost them, a deviate has not. Probabilities are SciPy's;
the maps are written out, since SciPy's `isf` of a bounded distribution is `ppf(1 - q)`, without those digits.
"""

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike
from scipy import stats  # type: ignore[import-untyped]
from scipy.special import ndtr, ndtri  # type: ignore[import-untyped]

from stickslip.theory.numerics import Floats

Map = Callable[[Floats], Floats]


@dataclass(frozen=True)
class Distribution:
    """One number that is not known exactly, given that it lies from `low` to `high`.

    whole : SciPy's distribution without those ends. map : from standard normal deviates to its values.
    """

    whole: Any
    map: Map
    low: float = -math.inf
    high: float = math.inf

    def at(self, z: ArrayLike) -> Floats:
        """The values at standard normal deviates."""
        z = np.asarray(z, np.float64)
        if math.isinf(self.low) and math.isinf(self.high):
            return np.asarray(self.map(z))
        below, above, inside = self.shares
        p, q = below + ndtr(z) * inside, above + ndtr(-z) * inside
        return np.clip(self.map(np.where(p < q, ndtri(p), -ndtri(q))), self.low, self.high)

    @property
    def shares(self) -> tuple[float, float, float]:
        """The shares of the whole that lie below, above and inside the ends, each with its digits."""
        below, above = float(self.whole.cdf(self.low)), float(self.whole.sf(self.high))
        if below < 0.5:
            return below, above, float(self.whole.cdf(self.high)) - below
        return below, above, float(self.whole.sf(self.low)) - above

    def outside(self, low: float, high: float) -> tuple[float, float]:
        """The probability of a value below `low`, and of one above `high`; -inf and inf for no bound."""
        below, above, inside = self.shares
        under = 0.0 if low <= self.low else (float(self.whole.cdf(low)) - below) / inside
        over = 0.0 if high >= self.high else (float(self.whole.sf(high)) - above) / inside
        return under, over


@dataclass(frozen=True)
class Drawn:
    """One of some values, each as probable as any other; deviates in their order, not in that of their size."""

    values: tuple[float, ...]

    def at(self, z: ArrayLike) -> Floats:
        """The values at standard normal deviates."""
        rows = (ndtr(np.asarray(z, np.float64)) * len(self.values)).astype(np.intp)
        return np.asarray(np.take(self.values, np.minimum(rows, len(self.values) - 1)), np.float64)

    def outside(self, low: float, high: float) -> tuple[float, float]:
        """The share of values below `low`, and of those above `high`."""
        values = np.asarray(self.values)
        return float(np.mean(values < low)), float(np.mean(values > high))


def normal(mean: float, std: float, *ends: float) -> Distribution:
    """Normal: mean, and standard deviation > 0."""
    return Distribution(stats.norm(mean, std), lambda z: mean + std * z, *ends)


def lognormal(median: float, factor: float, *ends: float) -> Distribution:
    """Lognormal: median > 0, and the factor > 1 within which, up or down, 68 % of the values lie."""

    def values(z: Floats) -> Floats:
        with np.errstate(over="ignore"):  # far out, with a large factor: inf
            return np.asarray(median * np.exp(math.log(factor) * z))

    return Distribution(stats.lognorm(math.log(factor), scale=median), values, *ends)


def uniform(low: float, high: float, *ends: float) -> Distribution:
    """Uniform from low to high > low."""
    width = high - low
    return Distribution(
        stats.uniform(low, width), lambda z: np.where(z < 0, low + width * ndtr(z), high - width * ndtr(-z)), *ends
    )


def triangular(low: float, mode: float, high: float, *ends: float) -> Distribution:
    """Triangular from low to high with the most probable value at mode, low <= mode <= high, low < high."""
    width = high - low

    def values(z: Floats) -> Floats:
        rising = low + np.sqrt(ndtr(z) * width * (mode - low))
        falling = high - np.sqrt(ndtr(-z) * width * (high - mode))
        return np.asarray(np.where(ndtr(z) * width < mode - low, rising, falling))

    return Distribution(stats.triang((mode - low) / width, low, width), values, *ends)


KINDS: dict[str, Callable[..., Distribution]] = {
    "normal": normal, "lognormal": lognormal, "uniform": uniform, "triangular": triangular,
}  # fmt: skip
