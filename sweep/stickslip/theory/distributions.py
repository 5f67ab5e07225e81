"""Distributions of one number, as maps from a standard normal deviate.

`at(z)` gives the value whose probability of not being exceeded is that of the normal deviate z. So points in the unit
cube, normal deviates, correlated deviates (a Gaussian copula) and the walks of subset simulation all go through one
map, and both tails keep their digits: near 1 a probability has lost them, a deviate has not. Probabilities are SciPy's;
so are the maps, but for the kinds that have a name of their own here: SciPy's `isf` of a bounded distribution is
`ppf(1 - q)`, without those digits.
"""

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike
from scipy import stats  # type: ignore[import-untyped]
from scipy.special import ndtr, ndtri  # type: ignore[import-untyped]

from stickslip.theory.curve import Floats

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
        score = np.asarray(z, np.float64)
        if not (math.isinf(self.low) and math.isinf(self.high)):
            below, above, inside = self.shares
            p, q = below + ndtr(score) * inside, above + ndtr(-score) * inside
            score = np.where(p < q, ndtri(p), -ndtri(q))
        with np.errstate(over="ignore"):  # far out: inf
            return np.asarray(np.clip(self.map(score), self.low, self.high))

    @property
    def shares(self) -> tuple[float, float, float]:
        """The shares of the whole that lie below, above and inside the ends, each with its digits."""
        below, above = float(self.whole.cdf(self.low)), float(self.whole.sf(self.high))
        if below < 0.5:
            return below, above, float(self.whole.cdf(self.high)) - below
        return below, above, float(self.whole.sf(self.low)) - above


def distribution(kind: str, numbers: Sequence[float], low: float = -math.inf, high: float = math.inf) -> Distribution:
    """The distribution of a kind, truncated to what lies from `low` to `high`.

    kind : one of `KINDS`, or a continuous distribution of scipy.stats by its name. numbers : in the order of the
    function here, or of `numbers_of`.
    """
    if kind in KINDS:
        return Distribution(*KINDS[kind](*numbers), low, high)
    whole = getattr(stats, kind)(*np.asarray(numbers, np.float64))
    return Distribution(whole, lambda z: np.where(z < 0, whole.ppf(ndtr(z)), whole.isf(ndtr(-z))), low, high)


def numbers_of(kind: str) -> tuple[str, ...]:
    """The numbers of a continuous distribution of scipy.stats; none where no such one has this name.

    Nor has one whose quantiles SciPy searches for: draws of some would take minutes.
    """
    named = getattr(stats, kind, None)
    if not isinstance(named, stats.rv_continuous) or type(named)._ppf is stats.rv_continuous._ppf:
        return ()
    return (*(named.shapes.split(", ") if named.shapes else ()), "loc", "scale")


# --- kinds with a name of their own -----------------------------------------------------------------------------------


def _normal(mean: float, std: float) -> tuple[Any, Map]:
    return stats.norm(mean, std), lambda z: mean + std * z


def _lognormal(median: float, factor: float) -> tuple[Any, Map]:
    std = math.log(factor) if factor > 0 else math.nan
    return stats.lognorm(std, scale=median), lambda z: median * np.exp(std * z)


def _uniform(low: float, high: float) -> tuple[Any, Map]:
    width = high - low
    return stats.uniform(low, width), lambda z: np.where(z < 0, low + width * ndtr(z), high - width * ndtr(-z))


def _triangular(low: float, mode: float, high: float) -> tuple[Any, Map]:
    width = high - low
    return stats.triang((mode - low) / (width or math.nan), low, width), lambda z: np.where(
        ndtr(z) * width < mode - low,
        low + np.sqrt(ndtr(z) * width * (mode - low)),
        high - np.sqrt(ndtr(-z) * width * (high - mode)),
    )


def _drawn(*values: float) -> tuple[Any, Map]:
    """One of some values, each as probable as any other; deviates in their order, not in that of their size."""
    last = len(values) - 1
    return None, lambda z: np.take(values, np.minimum((ndtr(z) * len(values)).astype(np.intp), last))


KINDS: dict[str, Callable[..., tuple[Any, Map]]] = {
    "normal": _normal, "lognormal": _lognormal, "uniform": _uniform, "triangular": _triangular, "drawn": _drawn,
}  # fmt: skip
