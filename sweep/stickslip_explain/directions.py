"""Which combinations of quantities observations fix: directions along which the posterior is narrower than the prior.

Of two covariance matrices, prior P and posterior Q of the same numbers, the directions v with Q v = r P v are those
along which the data have narrowed what was known by sqrt(r), one after the other and independent of each other under
both; r is the same whatever units the numbers have. Products of powers (stiffness/mass) show in logarithms, which are
taken of all quantities that are positive.
"""

from collections.abc import Mapping
from typing import NamedTuple

import numpy as np
import scipy  # type: ignore[import-untyped]
from numpy.typing import NDArray

Floats = NDArray[np.float64]
Draws = Mapping[str, Floats]


class Directions(NamedTuple):
    """Directions of the quantities, the one that is fixed best first.

    ratio : (n,) posterior over prior variance. weights : (n, quantities), exponents or coefficients, the largest part
    of each direction being 1.
    """

    ratio: Floats
    weights: Floats


def directions(prior: Draws, posterior: Draws) -> Directions:
    """The directions of draws of the same quantities from prior and posterior."""
    positive = {name for name in prior if (prior[name] > 0).all() and (posterior[name] > 0).all()}
    before, after = (
        np.array([np.log(values) if name in positive else values for name, values in draws.items()])
        for draws in (prior, posterior)
    )
    scale = before.std(1)
    p, q = (np.atleast_2d(np.cov(draws / scale[:, None])) for draws in (before, after))
    ratio, vectors = scipy.linalg.eigh(q, p)
    rows, largest = np.arange(len(scale)), np.abs(vectors.T).argmax(1)
    parts = vectors.T / vectors.T[rows, largest][:, None]
    weights = parts / scale
    return Directions(np.maximum(ratio, 0.0), weights / weights[rows, largest][:, None])
