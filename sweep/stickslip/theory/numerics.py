"""Arrays of numbers, and the roots of many equations at once."""

from collections.abc import Callable

import numpy as np
from numpy.typing import ArrayLike, NDArray

Floats = NDArray[np.float64]

_MOST_HALVINGS = 1100  # what it takes from 1 down to the smallest double


def floats(*values: ArrayLike) -> tuple[Floats, ...]:
    """Each as an array of doubles; shapes as given."""
    return tuple(np.asarray(value, np.float64) for value in values)


def bisect(function: Callable[[Floats], Floats], low: Floats, high: Floats) -> Floats:
    """The place where `function` changes from positive at `low` to negative at `high`, to the last bit.

    function : of an array, element by element, in the shape of `low` and `high`. An end that is NaN, or a function
        that is NaN, gives a number without meaning: the caller masks those.
    """
    low, high = np.array(low, np.float64), np.array(high, np.float64)
    for _ in range(_MOST_HALVINGS):
        middle = low + 0.5 * (high - low)
        positive = function(middle) > 0
        moved = np.where(positive, middle != low, middle != high) & ~np.isnan(middle)
        low, high = np.where(positive, middle, low), np.where(positive, high, middle)
        if not moved.any():
            break
    return low
