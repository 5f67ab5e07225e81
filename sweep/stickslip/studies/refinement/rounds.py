"""A tile refined: round by round, what is to be computed next follows from what was found.

The audit of a refined map: random points among the cells that were inferred, and what they say of the others.

Points are drawn before anything is known of the map, each independently and anywhere with the same probability, in
numbers that are Poisson in every tile: so those that fall on inferred cells are a random sample of these, whatever made
them inferred. The number of wrong ones among them is binomial, and Clopper and Pearson (Biometrika 26, 1934) bound its
probability: the share of inferred cells that were wrong when the points were tried. What is mended afterwards only
makes the map better than the bound says.
"""

from __future__ import annotations

from collections.abc import Callable, Generator, Sequence
from dataclasses import dataclass

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


Asking = Generator[Places, Labels, Audit]
Look = Callable[[Indices], Labels]


def asking(tile: Tile, depth: int, density: float) -> Asking:
    """Gives the places of the window to compute, takes their labels, and so on; returns the audit.

    Boxes are split until all are uniform; then the audit; then boxes in which it found something wrong are split,
    until all are uniform again.
    """
    boxes = Boxes(tile.shape, depth)
    yield from _settled(boxes, boxes.first())
    places = drawn(tile, density)
    places = places[~boxes.known.ravel()[places]]
    own = ~boxes.known[tile.own]
    inferred, wrong = boxes.inferred().ravel()[places], 0
    if places.size:
        different, which = np.unique(places, return_inverse=True)
        labels = yield different
        wrong = int((labels[which] != inferred).sum())
        boxes.learn(different, labels)
        yield from _settled(boxes, boxes.wanted())
    return Audit(places.size, wrong, int(own.sum()))


def _settled(boxes: Boxes, places: Places) -> Generator[Places, Labels, None]:
    while places.size:
        boxes.learn(places, (yield places))
        places = boxes.wanted()


@dataclass(frozen=True)
class Refined:
    """Computed cells of several tiles, in the order it was asked for.

    tiles : to which of them, counted from 0, each computed cell belongs. places : where it is in its window.
    audits : of each tile.
    """

    tiles: NDArray[np.int64]
    places: Places
    audits: list[Audit]


def refine(tiles: Sequence[Tile], depth: int, density: float, look: Look) -> Refined:
    """Refine tiles side by side: what they ask for in a round is computed together.

    look : computes cells of the grid and gives their labels. Where windows overlap, the same cell may be asked for more
    than once.
    """
    running = {i: asking(tile, depth, density) for i, tile in enumerate(tiles)}
    wanted = {i: next(rounds) for i, rounds in running.items()}
    computed: list[tuple[int, Places]] = []
    audits: dict[int, Audit] = {}
    while wanted:
        labels = look(np.concatenate([tiles[i].cells(places) for i, places in wanted.items()]))
        computed += wanted.items()
        ends = np.cumsum([places.size for places in wanted.values()])[:-1]
        answers = zip(list(wanted), np.split(labels, ends), strict=True)
        wanted = {}
        for i, answer in answers:
            try:
                wanted[i] = running[i].send(answer)
            except StopIteration as end:
                audits[i] = end.value
    return Refined(
        np.repeat([i for i, _ in computed], [places.size for _, places in computed]),
        np.concatenate([places for _, places in computed]),
        [audits[i] for i in range(len(tiles))],
    )
