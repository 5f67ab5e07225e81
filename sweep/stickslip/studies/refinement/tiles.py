"""A grid cut into tiles, which are refined one by one.

Boxes extend along the axes that are ranges with more points than a box has a side; along the others (lists, groups,
short ranges) every point is a map of its own. The cut follows from the grid and the depth alone, so that the numbers do
not depend on who computes which tile. A tile looks at one box more on each side than it owns: a border near its edge is
seen from both sides.
"""

from dataclasses import dataclass
from math import prod

import numpy as np
from numpy.typing import NDArray

Indices = NDArray[np.int64]

_TILE = 21  # a tile has about 2^21 cells: large enough to follow borders, small enough for memory and for many threads


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

    def cells(self, places: Indices) -> Indices:
        """The cells of the grid at places of the window."""
        points = [np.full(places.size, start, np.int64) for start in self.starts]
        for i, along in zip(self.refined, np.unravel_index(places, self.shape), strict=True):
            points[i] += along
        return np.ravel_multi_index(points, self.grid)

    def places(self, cells: Indices) -> Indices:
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

    def owners(self, cells: Indices) -> Indices:
        """The numbers of the tiles that own these cells."""
        at = [
            np.minimum(along // self.length, self.shape[i] - 1) if i in self.refined else along
            for i, along in enumerate(np.unravel_index(cells, self.grid))
        ]
        return np.ravel_multi_index(at, self.shape)
