"""A tile refined: round by round, what is to be computed next follows from what was found."""

from __future__ import annotations

from collections.abc import Callable, Generator, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from stickslip.refinement.audit import Audit, drawn
from stickslip.refinement.boxes import Boxes, Labels, Places
from stickslip.refinement.tiles import Indices, Tile

Asking = Generator[Places, Labels, Audit]
Look = Callable[[Indices], Labels | None]


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
    said, wrong = boxes.inferred().ravel()[places], 0
    if places.size:
        different, which = np.unique(places, return_inverse=True)
        found = yield different
        wrong = int((found[which] != said).sum())
        boxes.learn(different, found)
        yield from _settled(boxes, boxes.wanted())
    return Audit(places.size, wrong, int(own.sum()))


def _settled(boxes: Boxes, places: Places) -> Generator[Places, Labels, None]:
    while places.size:
        boxes.learn(places, (yield places))
        places = boxes.wanted()


@dataclass(frozen=True)
class Refined:
    """What was computed of several tiles, in the order it was asked for.

    tiles : to which of them, counted from 0, each computed cell belongs. places : where it is in its window.
    audits : of each tile.
    """

    tiles: NDArray[np.int64]
    places: Places
    audits: list[Audit]


def refine(tiles: Sequence[Tile], depth: int, density: float, look: Look) -> Refined | None:
    """Refine tiles side by side: what they ask for in a round is computed together.

    look : computes cells of the grid and gives their labels; None ends everything, and this returns None. Where windows
    overlap, the same cell may be asked for more than once.
    """
    running = {i: asking(tile, depth, density) for i, tile in enumerate(tiles)}
    wanted = {i: next(one) for i, one in running.items()}
    asked: list[tuple[int, Places]] = []
    audits: dict[int, Audit] = {}
    while wanted:
        labels = look(np.concatenate([tiles[i].cells(places) for i, places in wanted.items()]))
        if labels is None:
            return None
        asked += wanted.items()
        ends = np.cumsum([places.size for places in wanted.values()])[:-1]
        answers = zip(list(wanted), np.split(labels, ends), strict=True)
        wanted = {}
        for i, answer in answers:
            try:
                wanted[i] = running[i].send(answer)
            except StopIteration as end:
                audits[i] = end.value
    return Refined(
        np.repeat([i for i, _ in asked], [places.size for _, places in asked]),
        np.concatenate([places for _, places in asked]),
        [audits[i] for i in range(len(tiles))],
    )
