"""Which draw an item is: by cell, scrambling, matrix and number, in that order, the last running fastest.

Scrambled Sobol points, any of them at once: no point depends on which others are asked for. So a block of a run makes
its own points wherever it lies, and a hundred million of them are never in memory together.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property, lru_cache
from typing import NamedTuple

import numpy as np
import scipy  # type: ignore[import-untyped]
from numpy.typing import NDArray

Integers = NDArray[np.int64]
Floats = NDArray[np.float64]

BITS = 30  # of a coordinate, as SciPy has them
_AT_ONCE = 2**16  # points of a scrambling that are made together; many, since SciPy walks to the first of them
_IN_MEMORY = 2**21  # points


class SobolPoints:
    """Independent scramblings of the first `count` Sobol points in the unit cube; count : a power of two.

    Scrambling: a random matrix and a digital shift (Matousek).
    """

    def __init__(self, dimensions: int, count: int, seed: int) -> None:
        self._dimensions, self._together = dimensions, min(count, _AT_ONCE)
        self._seed = seed
        self._part = lru_cache(_IN_MEMORY // self._together)(self._part_of)

    def at(self, scrambling: Integers, number: Integers) -> Floats:
        """Points by scrambling and number (both (n,)), as (n, dimensions), strictly between 0 and 1.

        A point is the middle of its interval of 2^-30: SciPy gives the lower end, which may be 0.
        """
        points = np.empty((number.size, self._dimensions))
        places = np.stack([scrambling, number // self._together])
        for scrambled, part in np.unique(places, axis=1).T.tolist():
            here = (places[0] == scrambled) & (places[1] == part)
            points[here] = self._part(scrambled, part)[number[here] % self._together]
        return points + 0.5 * 2.0**-BITS

    def _part_of(self, scrambling: int, part: int) -> Floats:
        """Points of a scrambling that are made together."""
        # A new one every time: SciPy spawns another from it, which it remembers.
        seed = np.random.SeedSequence(self._seed, spawn_key=(scrambling,))
        engine = scipy.stats.qmc.Sobol(self._dimensions, scramble=True, bits=BITS, seed=np.random.default_rng(seed))
        if part:  # SciPy takes 0 points for more than none
            engine.fast_forward(part * self._together)
        return np.asarray(engine.random(self._together), np.float64)


class DrawPlace(NamedTuple):
    """Places of items: four rows of numbers. matrix : 0 is A, 1 is B, 2 + i is A with the column i of B."""

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
        return SobolPoints(self.plain * self.quantities, self.draws, self.seed)

    def place(self, start: int, stop: int) -> DrawPlace:
        """Return where the items from `start` to `stop` stand."""
        shape = (-(-stop // self.per_cell) or 1, self.scramblings, self.matrices, self.draws)
        return DrawPlace(*np.unravel_index(np.arange(start, stop, dtype=np.int64), shape))

    def normals(self, place: DrawPlace) -> Floats:
        """Independent standard normal deviates of items, (n, quantities)."""
        points, d = self.points.at(place.scrambling, place.number), self.quantities
        drawn = points[:, :d].copy()
        if self.indices:
            columns = np.arange(d)
            from_b = (place.matrix[:, None] == 1) | (place.matrix[:, None] == 2 + columns)
            drawn = np.where(from_b, points[:, d:], drawn)
        return np.asarray(scipy.special.ndtri(drawn))
