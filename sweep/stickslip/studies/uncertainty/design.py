"""Which draw an item is: by cell, scrambling, matrix and number, in that order, the last running fastest.

Scrambled Sobol points, any of them at once: no point depends on which others are asked for.

SciPy makes them one after the other. But point number n is the exclusive or of the point 0 with one direction per bit
of the Gray code of n, and SciPy's own points at powers of two tell the directions. So a block of a run computes its own
points wherever it lies, and a hundred million of them are never in memory together.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import NamedTuple

import numpy as np
import scipy  # type: ignore[import-untyped]
from numpy.typing import NDArray

Integers = NDArray[np.int64]
Floats = NDArray[np.float64]

BITS = 30  # of a coordinate, as SciPy has them
_HELD = 12  # bits of n whose points are held: 4096 points of each scrambling


@dataclass(frozen=True, eq=False)
class SobolPoints:
    """Independent scramblings of the first `count` Sobol points in the unit cube.

    near : (scramblings, held, dimensions), the first points. far : (scramblings, rest, dimensions), what turns them
    into those further on.
    """

    count: int
    near: Integers
    far: Integers

    @classmethod
    def scrambled(cls, dimensions: int, count: int, scramblings: int, seed: int) -> SobolPoints:
        """The points of a seed. count : a power of two. Scrambling: a random matrix and a digital shift (Matousek)."""
        near, far = [], []
        for child in np.random.SeedSequence(seed).spawn(scramblings):
            first, directions = _directions(dimensions, count, np.random.default_rng(child))
            held = min(count, 2**_HELD)
            near.append(first ^ _combined(np.arange(held), directions))
            far.append(_combined(np.arange(0, count, held), directions))
        return cls(count, np.array(near), np.array(far))

    @property
    def held(self) -> int:
        """Return how many points `near` has of each scrambling."""
        return int(self.near.shape[1])

    def at(self, scrambling: Integers, number: Integers) -> Floats:
        """Points by scrambling and number (both (n,)), as (n, dimensions), strictly between 0 and 1.

        A point is the middle of its interval of 2^-30: SciPy gives the lower end, which may be 0.
        """
        whole = self.near[scrambling, number % self.held] ^ self.far[scrambling, number // self.held]
        return np.asarray((whole + 0.5) * 2.0**-BITS, np.float64)


def _directions(dimensions: int, count: int, rng: np.random.Generator) -> tuple[Integers, Integers]:
    """The point 0 and the directions (bits, dimensions) of one scrambling, as integers."""
    engine = scipy.stats.qmc.Sobol(dimensions, scramble=True, bits=BITS, seed=rng)
    bits = count.bit_length() - 1
    first = _integers(engine.random(1))
    directions = np.zeros((bits, dimensions), np.int64)
    for bit in range(bits):
        engine.fast_forward(2**bit - engine.num_generated)
        directions[bit] = first ^ _integers(engine.random(1))
        if bit:  # the Gray code of 2^bit has the bit before it as well
            directions[bit] ^= directions[bit - 1]
    return first, directions


def _integers(points: Floats) -> Integers:
    return np.asarray(points[0] * 2.0**BITS, np.int64)


def _combined(numbers: Integers, directions: Integers) -> Integers:
    """The exclusive or of the directions that the Gray codes of `numbers` name."""
    found = np.zeros((numbers.size, directions.shape[1]), np.int64)
    gray = numbers ^ (numbers >> 1)
    for bit, direction in enumerate(directions):
        found ^= np.where(gray[:, None] >> bit & 1, direction, 0)
    return found


class Place(NamedTuple):
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
        return SobolPoints.scrambled(self.plain * self.quantities, self.draws, self.scramblings, self.seed)

    def place(self, start: int, stop: int) -> Place:
        """Return where the items from `start` to `stop` stand."""
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
        return np.asarray(scipy.special.ndtri(drawn))
