"""Where in a bracket to look next, if a number is known at its ends whose zero is what is searched for.

The ITP method: I. F. D. Oliveira, R. H. C. Takahashi, An enhancement of the bisection method average performance
preserving minmax optimality, ACM TOMS 47 (2021) 5: the place of the secant, moved a little to the middle, and never so
far from it that halving would have been done a round earlier.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]
_MORE_ROUNDS = 1  # than halving takes at most: n_0 of the article
_MOVED = 0.2  # kappa_1, over the first width; kappa_2 is 2


def first_reach(width: Floats, narrow: Floats) -> Floats:
    """How wide a bracket may be after the next round so that halving still ends in time, in the first round.

    width, narrow : of the bracket, and at which the search ends. The reach halves with each round.
    """
    narrow = np.maximum(narrow, np.finfo(np.float64).tiny)
    return np.asarray(narrow * np.exp2(np.ceil(np.log2(np.maximum(width / narrow, 1.0))) + _MORE_ROUNDS - 1))


def guess(low: Floats, high: Floats, at_low: Floats, at_high: Floats, first: Floats, reach: Floats) -> Floats:
    """The place to look at inside each bracket.

    at_low, at_high : the number at the ends, of opposite sign. first : width of the bracket at the start.
    """
    width, middle = high - low, low + (high - low) / 2
    secant = low + width * (at_low / (at_low - at_high))
    to_middle = middle - secant
    moved = np.minimum(_MOVED / first * width**2, np.abs(to_middle))
    off = secant + np.copysign(moved, to_middle) - middle
    allowed = np.maximum(reach - width / 2, 0.0)
    return np.asarray(middle + np.clip(off, -allowed, allowed))
