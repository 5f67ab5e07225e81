"""Boxes of cells, split where the labels of their points differ.

A window of points (cells, seen as points of a lattice) is covered by boxes of 2^depth + 1 points a side, which share
their faces. Each is known by its corners and its centre (for contours, by its corners). A box in whose closed hull two
computed points differ is split into boxes of half the side, which are known in the same way; boxes of 2 points a side
have nothing inside. So a point that is computed for one box is looked at by every box it touches, whatever their sizes:
a border that leaves a box through a face splits its neighbour too, and is followed to its end.

Points with labels below 0 are undecided: they differ from everything, themselves included, so that all around them is
computed.

A grid is cut into tiles, which are refined one by one. Along axes without boxes (lists, groups, short ranges) every
point is a map of its own. The cut follows from the grid and the depth alone, so that the numbers do not depend on who
computes which tile. A tile looks at one box more on each side than it owns: a border near its edge is seen from both
sides.

The audit tries random points among the cells that were inferred. They are drawn before anything is known of the map,
each independently and anywhere with the same probability, in numbers that are Poisson in every tile: so those that fall
on inferred cells are a random sample of these, whatever made them inferred. The number of wrong ones among them is
binomial, and Clopper and Pearson (Biometrika 26, 1934) bound its probability: the share of inferred cells that were
wrong when the points were tried. What is mended afterwards only makes the map better than the bound says.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from itertools import product
from math import prod
from typing import Any, NamedTuple

import numpy as np
import scipy  # type: ignore[import-untyped]
from numpy.typing import NDArray

from stickslip.studies.search import Integers, Labels

CONFIDENCE = 0.95  # of the audit
_SEED = 20_150_417  # any number, the same in all runs
_TILE = 21  # a tile has about 2^21 cells: large enough to follow borders, small enough for memory and for many threads
_NOTHING = (127, -128)  # smallest and largest label of no point at all
_OPEN = (-128, 126)  # of a point that differs from itself


class Boxes:
    """The boxes of one window, and what is known of its points.

    shape : points along each side, at least 2 each. Integers count points, the last dimension running fastest.
    """

    def __init__(self, shape: tuple[int, ...], depth: int, centres: bool = True) -> None:
        self.shape, self.depth, self._centres = shape, depth, centres
        side = 1 << depth
        lengths = tuple(-(-(n - 1) // side) * side for n in shape)  # the last boxes may end outside the window
        padded = tuple(n + 1 for n in lengths)
        self.known = np.zeros(shape, bool)
        self._labels = np.zeros(shape, np.int8)
        self._low, self._high = np.full(padded, _NOTHING[0], np.int8), np.full(padded, _NOTHING[1], np.int8)
        self._split = [np.zeros(tuple(n >> level for n in lengths), bool) for level in range(depth + 1)]
        self._begun = False

    def learn(self, places: Integers, labels: Labels) -> None:
        """Take in the labels of points."""
        at = np.unravel_index(places, self.shape)
        self.known[at], self._labels[at] = True, labels
        self._low[at] = np.where(labels < 0, _OPEN[0], labels)
        self._high[at] = np.where(labels < 0, _OPEN[1], labels)

    def wanted(self) -> Integers:
        """The points that must be computed next, none once all boxes are uniform: at first those of the largest boxes,
        then those of boxes that are split."""
        places = [np.zeros(0, np.int64)]
        if not self._begun:
            self._begun, every = True, np.argwhere(np.ones(self._split[-1].shape, bool))
            places.append(self._places(every << self.depth, self.depth))
        for level, (low, high) in zip(range(1, self.depth + 1), self._hulls(), strict=True):
            split = low < high
            fresh = np.argwhere(split & ~self._split[level])
            self._split[level] |= split
            for half in product((0, 1 << (level - 1)), repeat=len(self.shape)):
                places.append(self._places((fresh << level) + np.array(half), level - 1))
        return np.unique(np.concatenate(places))

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
        low, high, hulls = self._low, self._high, []
        for level in range(self.depth + 1):
            for axis in range(low.ndim):
                low, high = (of(*_neighbours(ends, axis, 2 if level else 1))
                             for ends, of in ((low, np.minimum), (high, np.maximum)))  # fmt: skip
            hulls.append((low, high))
        return hulls[1:]

    def _places(self, first: NDArray[Any], level: int) -> Integers:
        """Corners and centres, where not yet known, of the boxes of a level with these first corners: (boxes, dims)."""
        side = 1 << level
        points = [first + np.array(corner) for corner in product((0, side), repeat=len(self.shape))]
        if level and self._centres:
            points.append(first + side // 2)
        inside = np.minimum(np.concatenate(points), np.array(self.shape) - 1)
        places = np.unique(np.ravel_multi_index(tuple(inside.T), self.shape))
        missing: Integers = places[~self.known.ravel()[places]]
        return missing


def _neighbours(values: Labels, axis: int, step: int) -> tuple[Labels, Labels]:
    """Neighbours along an axis: of every two points (step 1), or of every pair (step 2)."""
    before, last = [slice(None)] * axis, -1 if step == 1 else None
    return values[(*before, slice(0, last, step))], values[(*before, slice(1, None, step))]


def _twice(values: Labels, shape: tuple[int, ...]) -> Labels:
    """Each value twice along every axis, if it is not of that shape already."""
    if values.shape == shape:
        return values.copy()
    for axis in range(values.ndim):
        values = np.repeat(values, 2, axis)
    return values


@dataclass(frozen=True)
class Tile:
    """A part of the grid: the cells it owns, and the window of cells it looks at.

    starts, stops : the window, along every dimension of the grid; a single point along those that are not refined.
    own : the cells owned, along the refined dimensions, relative to the window.
    """

    number: int
    grid: tuple[int, ...]
    refined: tuple[int, ...]
    starts: tuple[int, ...]
    stops: tuple[int, ...]
    own: tuple[slice, ...]

    @property
    def shape(self) -> tuple[int, ...]:
        """Points of the window along the refined dimensions."""
        return tuple(self.stops[i] - self.starts[i] for i in self.refined)

    @property
    def size(self) -> int:
        """Number of cells owned."""
        return prod(side.stop - side.start for side in self.own)

    def cells(self, places: Integers) -> Integers:
        """The cells of the grid at places of the window."""
        points = [np.full(places.size, start, np.int64) for start in self.starts]
        for i, along in zip(self.refined, np.unravel_index(places, self.shape), strict=True):
            points[i] += along
        return np.ravel_multi_index(points, self.grid)

    def places(self, cells: Integers) -> Integers:
        """Return where cells of the grid are in the window that holds them."""
        points = np.unravel_index(cells, self.grid)
        return np.ravel_multi_index([points[i] - self.starts[i] for i in self.refined], self.shape)


@dataclass(frozen=True)
class Tiles:
    """All tiles of a grid. refined : the dimensions along which boxes extend, at least one."""

    grid: tuple[int, ...]
    refined: tuple[int, ...]
    depth: int

    @property
    def length(self) -> int:
        """Cells of a tile along a refined dimension; the last tile has up to one more."""
        return 1 << max(_TILE // len(self.refined), self.depth + 1)

    @property
    def shape(self) -> tuple[int, ...]:
        """Number of tiles along each dimension of the grid."""
        return tuple(max(1, -(-(n - 1) // self.length)) if i in self.refined else n for i, n in enumerate(self.grid))

    @property
    def count(self) -> int:
        """Number of tiles."""
        return prod(self.shape)

    def tile(self, number: int) -> Tile:
        """A tile by its number, the last dimension running fastest."""
        halo = (1 << self.depth) if self.depth else 0
        at = [int(i) for i in np.unravel_index(number, self.shape)]
        starts, stops, own = list(at), [i + 1 for i in at], []
        for i in self.refined:
            first = at[i] * self.length
            last = self.grid[i] if at[i] == self.shape[i] - 1 else first + self.length
            starts[i], stops[i] = max(0, first - halo), min(self.grid[i], last + halo + 1)
            own.append(slice(first - starts[i], last - starts[i]))
        return Tile(number, self.grid, self.refined, tuple(starts), tuple(stops), tuple(own))

    def owners(self, cells: Integers) -> Integers:
        """The numbers of the tiles that own these cells."""
        at = [
            np.minimum(along // self.length, self.shape[i] - 1) if i in self.refined else along
            for i, along in enumerate(np.unravel_index(cells, self.grid))
        ]
        return np.ravel_multi_index(at, self.shape)


class Audit(NamedTuple):
    """Outcome of an audit. inferred : cells that were not computed when the points were tried."""

    tried: int
    wrong: int
    inferred: int

    @property
    def bound(self) -> float:
        """Upper bound of the share of inferred cells that are wrong, at the level `CONFIDENCE`; 1 if none was tried."""
        if not self.inferred:
            return 0.0
        if self.wrong >= self.tried:
            return 1.0
        return float(scipy.stats.beta.ppf(CONFIDENCE, self.wrong + 1, self.tried - self.wrong))


def density(share: float, depth: int, dims: int) -> float:
    """Points per cell: `share` of the points that every map is computed at, corners and centres of its boxes."""
    return 2.0 * share / 2.0 ** (depth * dims)


def drawn(tile: Tile, density: float) -> Integers:
    """Random places of a tile, in its window; the same place may come twice."""
    draw = np.random.default_rng([_SEED, tile.number])
    count = int(draw.poisson(density * tile.size))
    points = tuple(draw.integers(side.start, side.stop, count) for side in tile.own)
    return np.ravel_multi_index(points, tile.shape).astype(np.int64)


class Refined(NamedTuple):
    """Computed cells of several tiles, in the order they were computed in.

    tiles : to which of them, counted from 0, each computed cell belongs. places : where it is in its window.
    audits : of each tile.
    """

    tiles: Integers
    places: Integers
    audits: list[Audit]


def refine(tiles: Sequence[Tile], depth: int, density: float, look: Callable[[Integers], Labels]) -> Refined:
    """Refine tiles side by side: what they need in a round is computed together.

    Boxes are split until all are uniform; then the audit; then boxes in which it was wrong are split, until all are
    uniform again. look : computes cells of the grid and gives their labels. Where windows overlap, the same cell may be
    computed more than once.
    """
    boxes = [Boxes(tile.shape, depth) for tile in tiles]
    rounds: list[tuple[int, Integers]] = []

    def learn(wanted: list[Integers]) -> list[Labels]:
        """The labels of places of each tile, once they are computed."""
        labels = look(np.concatenate([tile.cells(places) for tile, places in zip(tiles, wanted, strict=True)]))
        of_tiles = np.split(labels, np.cumsum([places.size for places in wanted])[:-1])
        for i, (places, of_tile) in enumerate(zip(wanted, of_tiles, strict=True)):
            boxes[i].learn(places, of_tile)
            rounds.append((i, places))
        return of_tiles

    def settle() -> None:
        while True:
            wanted = [of_tile.wanted() for of_tile in boxes]
            if not any(places.size for places in wanted):
                return
            learn(wanted)

    settle()
    audits, tried, inferred = [], [], [of_tile.inferred().ravel() for of_tile in boxes]
    for tile, of_tile in zip(tiles, boxes, strict=True):
        places = drawn(tile, density)
        tried.append(places[~of_tile.known.ravel()[places]])
        audits.append(Audit(tried[-1].size, 0, int((~of_tile.known[tile.own]).sum())))
    if any(places.size for places in tried):
        different, which = zip(*(np.unique(places, return_inverse=True) for places in tried), strict=True)
        for i, labels in enumerate(learn([*different])):
            wrong = labels[which[i]] != inferred[i][tried[i]]
            audits[i] = audits[i]._replace(wrong=int(wrong.sum()))
        settle()
    return Refined(
        np.repeat([i for i, _ in rounds], [places.size for _, places in rounds]),
        np.concatenate([places for _, places in rounds]),
        audits,
    )
