"""A tile refined: round by round, what is to be computed next follows from what was found.

The audit of a refined map: random points among the cells that were inferred, and what they say of the others.

Points are drawn before anything is known of the map, each independently and anywhere with the same probability, in
numbers that are Poisson in every tile: so those that fall on inferred cells are a random sample of these, whatever made
them inferred. The number of wrong ones among them is binomial, and Clopper and Pearson (Biometrika 26, 1934) bound its
probability: the share of inferred cells that were wrong when the points were tried. What is mended afterwards only
makes the map better than the bound says.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np
import scipy  # type: ignore[import-untyped]
from numpy.typing import NDArray

from stickslip.studies.refinement.boxes import Boxes, Labels, Places
from stickslip.studies.refinement.tiles import Indices, Tile

CONFIDENCE = 0.95
_SEED = 20_150_417  # any number, the same in all runs


@dataclass(frozen=True)
class Audit:
    """Outcome of an audit. inferred : cells that were not computed when the points were tried."""

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
        return float(scipy.stats.beta.ppf(CONFIDENCE, self.wrong + 1, self.tried - self.wrong))


def density(share: float, depth: int, dims: int) -> float:
    """Points per cell: `share` of the points that every map is computed at, corners and centres of its boxes."""
    return 2.0 * share / 2.0 ** (depth * dims)


def drawn(tile: Tile, density: float) -> Places:
    """Random places of a tile, in its window; the same place may come twice."""
    draw = np.random.default_rng([_SEED, tile.number])
    count = int(draw.poisson(density * tile.size))
    points = tuple(draw.integers(side.start, side.stop, count) for side in tile.own)
    return np.ravel_multi_index(points, tile.shape).astype(np.int64)


@dataclass(frozen=True)
class Refined:
    """Computed cells of several tiles, in the order they were computed in.

    tiles : to which of them, counted from 0, each computed cell belongs. places : where it is in its window.
    audits : of each tile.
    """

    tiles: NDArray[np.int64]
    places: Places
    audits: list[Audit]


def refine(tiles: Sequence[Tile], depth: int, density: float, look: Callable[[Indices], Labels]) -> Refined:
    """Refine tiles side by side: what they need in a round is computed together.

    Boxes are split until all are uniform; then the audit; then boxes in which it was wrong are split, until all are
    uniform again. look : computes cells of the grid and gives their labels. Where windows overlap, the same cell may be
    computed more than once.
    """
    boxes = [Boxes(tile.shape, depth) for tile in tiles]
    rounds: list[tuple[int, Places]] = []

    def learn(wanted: list[Places]) -> list[Labels]:
        """The labels of places of each tile, once they are computed."""
        labels = look(np.concatenate([tile.cells(places) for tile, places in zip(tiles, wanted, strict=True)]))
        of_tiles = np.split(labels, np.cumsum([places.size for places in wanted])[:-1])
        for i, (places, of_tile) in enumerate(zip(wanted, of_tiles, strict=True)):
            boxes[i].learn(places, of_tile)
            rounds.append((i, places))
        return of_tiles

    def settle(wanted: list[Places]) -> None:
        while any(places.size for places in wanted):
            learn(wanted)
            wanted = [of_tile.wanted() for of_tile in boxes]

    settle([of_tile.first() for of_tile in boxes])
    audits, tried, inferred = [], [], [of_tile.inferred().ravel() for of_tile in boxes]
    for tile, of_tile in zip(tiles, boxes, strict=True):
        places = drawn(tile, density)
        tried.append(places[~of_tile.known.ravel()[places]])
        audits.append(Audit(tried[-1].size, 0, int((~of_tile.known[tile.own]).sum())))
    if any(places.size for places in tried):
        different, which = zip(*(np.unique(places, return_inverse=True) for places in tried), strict=True)
        for i, labels in enumerate(learn([*different])):
            wrong = labels[which[i]] != inferred[i][tried[i]]
            audits[i] = replace(audits[i], wrong=int(wrong.sum()))
        settle([of_tile.wanted() for of_tile in boxes])
    return Refined(
        np.repeat([i for i, _ in rounds], [places.size for _, places in rounds]),
        np.concatenate([places for _, places in rounds]),
        audits,
    )
