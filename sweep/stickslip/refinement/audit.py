"""The audit of a refined map: random points among the cells that were inferred, and what they say of the others.

Points are drawn before anything is known of the map, each independently and anywhere with the same probability, in
numbers that are Poisson in every tile: so those that fall on inferred cells are a random sample of these, whatever made
them inferred. The number of wrong ones among them is binomial, and Clopper and Pearson (Biometrika 26, 1934) bound its
probability: the share of inferred cells that were wrong when the points were tried. What is mended afterwards only
makes the map better than the bound says.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from stickslip.refinement.boxes import Places
from stickslip.refinement.tiles import Tile

CONFIDENCE = 0.95
_SEED = 20_150_417  # any number, the same in all runs


@dataclass(frozen=True)
class Audit:
    """What came of it. inferred : cells that were not computed when the points were tried."""

    tried: int
    wrong: int
    inferred: int

    def __add__(self, other: Audit) -> Audit:
        return Audit(self.tried + other.tried, self.wrong + other.wrong, self.inferred + other.inferred)

    @property
    def bound(self) -> float:
        """Upper bound of the share of inferred cells that are wrong, at the level `CONFIDENCE`; 1 if none was tried."""
        if not self.inferred:
            return 0.0
        if self.wrong >= self.tried:
            return 1.0
        from scipy.stats import beta  # type: ignore[import-untyped]  # takes its time

        return float(beta.ppf(CONFIDENCE, self.wrong + 1, self.tried - self.wrong))


def density(share: float, depth: int, dims: int) -> float:
    """Points per cell: `share` of the points that every map is computed at, corners and centres of its boxes."""
    return 2.0 * share / 2.0 ** (depth * dims)


def drawn(tile: Tile, density: float) -> Places:
    """Random places of a tile, in its window; the same place may come twice."""
    draw = np.random.default_rng([_SEED, tile.number])
    count = int(draw.poisson(density * tile.size))
    points = tuple(draw.integers(side.start, side.stop, count) for side in tile.own)
    return np.ravel_multi_index(points, tile.shape).astype(np.int64)
