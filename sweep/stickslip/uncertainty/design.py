"""Which draw an item is: by cell, scrambling, matrix and number, in that order, the last running fastest."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.special import ndtri  # type: ignore[import-untyped]

from stickslip.uncertainty.points import Integers, SobolPoints

Floats = NDArray[np.float64]


class Place(NamedTuple):
    """Where items stand: four rows of numbers. matrix : 0 is A, 1 is B, 2 + i is A with the column i of B."""

    cell: Integers
    scrambling: Integers
    matrix: Integers
    number: Integers


@dataclass(frozen=True)
class Design:
    """The draws of every cell, the same in all of them, so that cells differ by what they are and not by luck.

    quantities : how many are uncertain. draws : per scrambling and matrix, a power of two.
    indices : whether the matrices of Saltelli (2010) are drawn, quantities + 2 of them, or one alone.
    """

    quantities: int
    draws: int
    scramblings: int
    seed: int
    indices: bool

    @property
    def matrices(self) -> int:
        """Matrices of draws per scrambling."""
        return self.quantities + 2 if self.indices else 1

    @property
    def plain(self) -> int:
        """Matrices that are independent draws, from which probabilities are counted: A, and B if there is one."""
        return 2 if self.indices else 1

    @property
    def unit(self) -> int:
        """Draws of one cell in one scrambling."""
        return self.matrices * self.draws

    @property
    def per_cell(self) -> int:
        """Draws of one cell."""
        return self.scramblings * self.unit

    @cached_property
    def points(self) -> SobolPoints:
        """In the unit cube; the columns of B after those of A."""
        return SobolPoints.scrambled(self.plain * self.quantities, self.draws, self.scramblings, self.seed)

    def place(self, start: int, stop: int) -> Place:
        """Where the items from `start` to `stop` stand."""
        shape = (-(-stop // self.per_cell) or 1, self.scramblings, self.matrices, self.draws)
        return Place(*np.unravel_index(np.arange(start, stop, dtype=np.int64), shape))

    def normals(self, place: Place) -> Floats:
        """Independent standard normal deviates of items, (n, quantities)."""
        points, d = self.points.at(place.scrambling, place.number), self.quantities
        drawn = points[:, :d].copy()
        if self.indices:
            columns = np.arange(d)
            from_b = (place.matrix[:, None] == 1) | (place.matrix[:, None] == 2 + columns)
            drawn = np.where(from_b, points[:, d:], drawn)
        return np.asarray(ndtri(drawn))
