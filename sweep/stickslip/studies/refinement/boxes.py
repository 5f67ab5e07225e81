"""Boxes of cells, split where the labels of their points differ.

A window of points (cells, seen as points of a lattice) is covered by boxes of 2^depth + 1 points a side, which share
their faces. Each is known by its corners and its centre. A box in whose closed hull two computed points differ is
split into boxes of half the side, which are known by their corners and centres in turn; boxes of 2 points a side have
nothing inside. So a point that is computed for one box is looked at by every box it touches, whatever their sizes: a
border that leaves a box through a face splits its neighbour too, and is followed to its end.

Points with labels below 0 are undecided: they differ from everything, themselves included, so that all around them is
computed.
"""

from itertools import product
from typing import Any

import numpy as np
from numpy.typing import NDArray

Places = NDArray[np.int64]
Labels = NDArray[np.int8]

_NOTHING = (127, -128)  # smallest and largest label of no point at all
_OPEN = (-128, 126)  # of a point that differs from itself


class Boxes:
    """The boxes of one window, and what is known of its points.

    shape : points along each side, at least 2 each. Places count points, the last dimension running fastest.
    """

    def __init__(self, shape: tuple[int, ...], depth: int) -> None:
        self.shape, self.depth = shape, depth
        side = 1 << depth
        lengths = tuple(-(-(n - 1) // side) * side for n in shape)  # the last boxes may end outside the window
        padded = tuple(n + 1 for n in lengths)
        self.known = np.zeros(shape, bool)
        self._labels = np.zeros(shape, np.int8)
        self._low, self._high = np.full(padded, _NOTHING[0], np.int8), np.full(padded, _NOTHING[1], np.int8)
        self._split = [np.zeros(tuple(n >> level for n in lengths), bool) for level in range(depth + 1)]

    def first(self) -> Places:
        """The points that are computed in any case: corners and centres of the largest boxes."""
        every = np.argwhere(np.ones(self._split[-1].shape, bool))
        return self._places(every << self.depth, self.depth)

    def learn(self, places: Places, labels: Labels) -> None:
        """Take in the labels of points."""
        at = np.unravel_index(places, self.shape)
        self.known[at], self._labels[at] = True, labels
        self._low[at] = np.where(labels < 0, _OPEN[0], labels)
        self._high[at] = np.where(labels < 0, _OPEN[1], labels)

    def wanted(self) -> Places:
        """The points that must be computed next, because boxes are split; none once all boxes are uniform."""
        places = []
        for level, (low, high) in zip(range(1, self.depth + 1), self._hulls(), strict=True):
            split = low < high
            fresh = np.argwhere(split & ~self._split[level])
            self._split[level] |= split
            for half in product((0, 1 << (level - 1)), repeat=len(self.shape)):
                places.append(self._places((fresh << level) + np.array(half), level - 1))
        return np.unique(np.concatenate(places)) if places else np.zeros(0, np.int64)

    def inferred(self) -> Labels:
        """The labels of all points: where none is computed, that of the box, which is the same for all its points."""
        label = np.zeros(self._split[-1].shape, np.int8)
        for low, _ in reversed(list(self._hulls())):
            label = np.where(low == _NOTHING[0], _twice(label, low.shape), low)
        if self.depth:
            label = _twice(label, tuple(n - 1 for n in self._low.shape))
            label = np.pad(label, [(0, 1)] * label.ndim, "edge")[tuple(slice(n) for n in self.shape)]
        return np.where(self.known, self._labels, label) if self.depth else self._labels

    def _hulls(self) -> list[tuple[Labels, Labels]]:
        """Smallest and largest label of the computed points of each box, faces included; for levels 1 to depth."""
        low, high = self._low, self._high
        for axis in range(low.ndim):
            low = np.minimum(_from(low, 0, 1, axis), _from(low, 1, 1, axis))
            high = np.maximum(_from(high, 0, 1, axis), _from(high, 1, 1, axis))
        hulls = []
        for _ in range(self.depth):
            for axis in range(low.ndim):
                low = np.minimum(_from(low, 0, 2, axis), _from(low, 1, 2, axis))
                high = np.maximum(_from(high, 0, 2, axis), _from(high, 1, 2, axis))
            hulls.append((low, high))
        return hulls

    def _places(self, first: NDArray[Any], level: int) -> Places:
        """Corners and centres, where not yet known, of the boxes of a level with these first corners: (boxes, dims)."""
        side = 1 << level
        points = [first + np.array(corner) for corner in product((0, side), repeat=len(self.shape))]
        if level:
            points.append(first + side // 2)
        inside = np.minimum(np.concatenate(points), np.array(self.shape) - 1)
        places = np.unique(np.ravel_multi_index(tuple(inside.T), self.shape))
        missing: Places = places[~self.known.ravel()[places]]
        return missing


def _from(values: Labels, start: int, step: int, axis: int) -> Labels:
    """Neighbours along an axis: every point but the last or the first (step 1), every other point (step 2)."""
    stop = values.shape[axis] - 1 + start if step == 1 else None
    return values[(*[slice(None)] * axis, slice(start, stop, step))]


def _twice(values: NDArray[np.int8], shape: tuple[int, ...]) -> NDArray[np.int8]:
    """Each value twice along every axis, if it is not of that shape already."""
    if values.shape == shape:
        return values.copy()
    for axis in range(values.ndim):
        values = np.repeat(values, 2, axis)
    return values
