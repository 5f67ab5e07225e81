"""From the draws of one cell to probabilities, moments and Sobol indices, each with its standard error.

Scramblings are independent of each other, and each gives an unbiased estimate. So the spread of their estimates is the
error of their mean, whatever is estimated and however evenly Sobol points lie; errors of plain Monte Carlo would be far
too large, and one scrambling alone has none. (Owen 1997; L'Ecuyer, Nakayama, Owen and Tuffin 2023 find this interval
the most reliable of those tried.)
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]


class Mean(NamedTuple):
    """A mean over scramblings and its standard error; arrays of one shape."""

    value: Floats
    error: Floats


def ratio(above: Floats, below: Floats) -> Mean:
    """The ratio of two sums over scramblings (first dimension), with the jackknife error over scramblings.

    NaN where the sum `below` is 0, or would be without one of the scramblings: then nothing is known of the error.
    """
    with np.errstate(divide="ignore", invalid="ignore"):
        whole = above.sum(0) / below.sum(0)
        without = (above.sum(0) - above) / (below.sum(0) - below)
    count = len(above)
    if count < 2:
        return Mean(whole, np.full(whole.shape, np.nan))
    with np.errstate(invalid="ignore"):
        error = np.sqrt((count - 1) / count * np.sum((without - without.mean(0)) ** 2, axis=0))
    known = np.isfinite(whole)
    return Mean(np.where(known, whole, np.nan), np.where(known, error, np.nan))


class Indices(NamedTuple):
    """First-order and total Sobol indices, (..., quantities)."""

    first: Mean
    total: Mean


class IndexSums(NamedTuple):
    """What indices are made of, of one scrambling: (..., quantities), the variance with a last dimension 1."""

    first: Floats
    total: Floats
    variance: Floats


def index_sums(a: Floats, b: Floats, mixed: Floats) -> IndexSums:
    """The sums of one scrambling.

    a, b : values at the draws of A and of B, (..., draws). mixed : at those of A with one column of B,
    (..., quantities, draws).
    First order by Saltelli et al. (2010, table 2 b), total by Jansen (1999), as `scipy.stats.sobol_indices`.
    """
    centre = 0.5 * (a.mean(-1) + b.mean(-1))[..., None]
    a, b = a - centre, b - centre
    mixed = mixed - centre[..., None]
    step = mixed - a[..., None, :]
    first = np.mean(b[..., None, :] * step, axis=-1)
    total = 0.5 * np.mean(step**2, axis=-1)
    return IndexSums(first, total, 0.5 * np.mean(a**2 + b**2, axis=-1)[..., None])


def indices_of(sums: list[IndexSums]) -> Indices:
    """The indices from the sums of all scramblings; NaN where nothing varies."""
    first, total, variance = (np.array([getattr(one, name) for one in sums]) for name in IndexSums._fields)
    return Indices(ratio(first, variance + 0 * first), ratio(total, variance + 0 * total))
