"""Distributions of one number, as maps from a standard normal deviate.

`at(z)` gives the value whose probability of not being exceeded is that of the normal deviate z, and `score(x)` is its
inverse (-inf below the support, inf above). So points in the unit cube, normal deviates, correlated deviates (a
Gaussian copula) and the walks of subset simulation all go through one map, and both tails keep their digits: near 1 a
probability has lost them, a deviate has not.
"""

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Protocol

import numpy as np
from numpy.typing import ArrayLike
from scipy.special import ndtr, ndtri  # type: ignore[import-untyped]

from stickslip.theory.numerics import Floats


class Distribution(Protocol):
    """One number that is not known exactly."""

    def at(self, z: ArrayLike) -> Floats:
        """The values at standard normal deviates."""

    def score(self, x: float) -> float:
        """The standard normal deviate of a value."""


@dataclass(frozen=True)
class Normal:
    """Normal: mean, and standard deviation > 0."""

    mean: float
    std: float

    def at(self, z: ArrayLike) -> Floats:
        """The values at standard normal deviates."""
        return np.asarray(self.mean + self.std * np.asarray(z, np.float64))

    def score(self, x: float) -> float:
        """The standard normal deviate of a value."""
        return (x - self.mean) / self.std


@dataclass(frozen=True)
class Lognormal:
    """Lognormal: median > 0, and the factor > 1 within which, up or down, 68 % of the values lie."""

    median: float
    factor: float

    def at(self, z: ArrayLike) -> Floats:
        """The values at standard normal deviates."""
        with np.errstate(over="ignore"):  # far out, with a large factor: inf
            return np.asarray(self.median * np.exp(math.log(self.factor) * np.asarray(z, np.float64)))

    def score(self, x: float) -> float:
        """The standard normal deviate of a value."""
        if x <= 0:
            return -math.inf
        return math.log(x / self.median) / math.log(self.factor)


@dataclass(frozen=True)
class Uniform:
    """Uniform from low to high > low."""

    low: float
    high: float

    def at(self, z: ArrayLike) -> Floats:
        """The values at standard normal deviates."""
        z, width = np.asarray(z, np.float64), self.high - self.low
        return np.asarray(np.where(z < 0, self.low + width * ndtr(z), self.high - width * ndtr(-z)))

    def score(self, x: float) -> float:
        """The standard normal deviate of a value."""
        width = self.high - self.low
        return _deviate((x - self.low) / width, (self.high - x) / width)


@dataclass(frozen=True)
class Triangular:
    """Triangular from low to high with the most probable value at mode, low <= mode <= high, low < high."""

    low: float
    mode: float
    high: float

    def at(self, z: ArrayLike) -> Floats:
        """The values at standard normal deviates."""
        z, width = np.asarray(z, np.float64), self.high - self.low
        rising = self.low + np.sqrt(ndtr(z) * width * (self.mode - self.low))
        falling = self.high - np.sqrt(ndtr(-z) * width * (self.high - self.mode))
        return np.asarray(np.where(ndtr(z) * width < self.mode - self.low, rising, falling))

    def score(self, x: float) -> float:
        """The standard normal deviate of a value."""
        width = self.high - self.low
        if x <= self.low or x >= self.high:
            return _deviate(x - self.low, self.high - x)
        if x < self.mode:
            below = (x - self.low) ** 2 / (width * (self.mode - self.low))
            return _deviate(below, 1.0 - below)
        above = (self.high - x) ** 2 / (width * (self.high - self.mode))
        return _deviate(1.0 - above, above)


@dataclass(frozen=True)
class Truncated:
    """Another distribution, given that the value lies from low to high; -inf and inf leave a side open."""

    whole: Distribution
    low: float
    high: float

    def at(self, z: ArrayLike) -> Floats:
        """The values at standard normal deviates."""
        z = np.asarray(z, np.float64)
        below, above, inside = self._shares()
        p, q = below + ndtr(z) * inside, above + ndtr(-z) * inside
        return np.clip(self.whole.at(np.where(p < q, ndtri(p), -ndtri(q))), self.low, self.high)

    def score(self, x: float) -> float:
        """The standard normal deviate of a value."""
        if not self.low < x < self.high:
            return math.inf if x >= self.high else -math.inf
        below, above, inside = self._shares()
        inner = self.whole.score(x)
        return _deviate(float(ndtr(inner) - below) / inside, float(ndtr(-inner) - above) / inside)

    def _shares(self) -> tuple[float, float, float]:
        """The shares of the whole that lie below, above and inside."""
        a, b = self.whole.score(self.low), self.whole.score(self.high)
        inside = float(ndtr(b) - ndtr(a)) if a < 0 else float(ndtr(-a) - ndtr(-b))
        return float(ndtr(a)), float(ndtr(-b)), inside

    @property
    def kept(self) -> float:
        """Share of the whole that lies inside."""
        return self._shares()[2]


@dataclass(frozen=True)
class Drawn:
    """One of some values, each as probable as any other; deviates in their order, not in that of their size."""

    values: tuple[float, ...]

    def at(self, z: ArrayLike) -> Floats:
        """The values at standard normal deviates."""
        rows = (ndtr(np.asarray(z, np.float64)) * len(self.values)).astype(np.intp)
        return np.asarray(np.take(self.values, np.minimum(rows, len(self.values) - 1)), np.float64)

    def score(self, x: float) -> float:
        """The standard normal deviate of the share of values below x."""
        values = np.asarray(self.values)
        return _deviate(float(np.mean(values < x)), float(np.mean(values > x)))


KINDS: dict[str, Callable[..., Normal | Lognormal | Uniform | Triangular | Drawn]] = {
    "normal": Normal, "lognormal": Lognormal, "uniform": Uniform, "triangular": Triangular, "drawn": Drawn,
}  # fmt: skip


def share_outside(distribution: Distribution, low: float, high: float) -> tuple[float, float]:
    """The probability of a value below `low`, and of one above `high`; -inf and inf for no bound."""
    under = 0.0 if math.isinf(low) else float(ndtr(distribution.score(low)))
    over = 0.0 if math.isinf(high) else float(ndtr(-distribution.score(high)))
    return under, over


def _deviate(p: float, q: float) -> float:
    """The standard normal deviate of a probability p, and 1 - p = q: from the smaller, which has the digits."""
    if p <= 0 or q <= 0:
        return -math.inf if p <= 0 else math.inf
    return float(ndtri(p)) if p < q else -float(ndtri(q))
