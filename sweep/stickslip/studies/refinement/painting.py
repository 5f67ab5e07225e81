"""Any range of a full map from what was computed of its tiles."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property
from itertools import product

import numpy as np
from numpy.typing import NDArray

from stickslip.engine import Results
from stickslip.studies.refinement.boxes import Boxes, Labels, Places
from stickslip.studies.refinement.tiles import Tile, Tiles
from stickslip.vocabulary.flags import UNDECIDED

COMPUTED = 1  # of the flag `computed`
_COUNTS = ("equilibrium_crossings", "sticks")  # there is nothing between two of them


def labels_of(regimes: NDArray[np.int8]) -> Labels:
    """Regimes as `Boxes` takes them: below 0 where nothing is decided, so that nothing is inferred from such cells."""
    return np.where(np.isin(regimes, UNDECIDED), -1 - regimes, regimes).astype(np.int8)


@dataclass(frozen=True)
class Sketch:
    """Computed cells of a tile. places : of its window, each once; results : of the cells there, by column."""

    tile: Tile
    depth: int
    places: Places
    results: Results

    @cached_property
    def _boxes(self) -> Boxes:
        boxes = Boxes(self.tile.shape, self.depth)
        boxes.learn(self.places, labels_of(self.results["regime"]))
        boxes.wanted()  # finds out which boxes are split; nothing is left to be computed
        return boxes

    @cached_property
    def _regimes(self) -> NDArray[np.int8]:
        """The regime of every place of the window that was not computed."""
        return self._boxes.inferred().ravel()

    @cached_property
    def _levels(self) -> NDArray[np.int8]:
        return self._boxes.leaves()

    @cached_property
    def _rows(self) -> NDArray[np.int32]:
        """Return where in the results each place of the window is; -1 for what was not computed."""
        rows = np.full(self._boxes.known.size, -1, np.int32)
        rows[self.places] = np.arange(self.places.size, dtype=np.int32)
        return rows

    def paint(self, into: Results, at: NDArray[np.intp], places: Places, interpolate: bool) -> None:
        """Put what is known of some places of the window into results, where they are at the indices `at`."""
        rows = self._rows[places]
        computed = rows >= 0
        into["regime"][at] = self._regimes[places]
        into["computed"][at[computed]] = COMPUTED
        for name, values in self.results.items():
            into[name][at[computed]] = values[rows[computed]]
        if interpolate and not computed.all():
            self._interpolate(into, at[~computed], places[~computed])

    def _interpolate(self, into: Results, at: NDArray[np.intp], places: Places) -> None:
        """Metrics linearly from the corners of the box around each place, all of one regime; NaN where one has none."""
        corners = list(self._corners(places))
        for name, values in self.results.items():
            if values.dtype == np.float64 and name not in _COUNTS:
                into[name][at] = sum(weight * values[rows] for rows, weight in corners)

    def _corners(self, places: Places) -> list[tuple[NDArray[np.int32], NDArray[np.float64]]]:
        """The rows of each corner of the boxes around places, and its weight."""
        shape = self.tile.shape
        points = np.unravel_index(places, shape)
        inside = tuple(np.minimum(at, n - 2) for at, n in zip(points, shape, strict=True))
        level = self._levels[inside].astype(np.int64)
        first = [(at >> level) << level for at in inside]
        last = [np.minimum(start + (1 << level), n - 1) for start, n in zip(first, shape, strict=True)]
        share = [(at - a) / (b - a) for at, a, b in zip(points, first, last, strict=True)]
        found = []
        for upper in product((False, True), repeat=len(shape)):
            corner = [b if up else a for up, a, b in zip(upper, first, last, strict=True)]
            weight = np.prod([part if up else 1.0 - part for up, part in zip(upper, share, strict=True)], axis=0)
            found.append((self._rows[np.ravel_multi_index(corner, shape)], weight))
        return found


class Painter:
    """Any range of the cells of a map.

    sketch : gives that of a tile, when it is needed; None for a tile of which nothing is known.
    blank : results of so many cells that are not computed, the flag `computed` among them.
    """

    def __init__(
        self, tiles: Tiles, sketch: Callable[[int], Sketch | None], blank: Callable[[int], Results], interpolate: bool
    ) -> None:
        self._tiles, self._load, self._blank, self._interpolate = tiles, sketch, blank, interpolate
        self._sketches: dict[int, Sketch | None] = {}

    def cells(self, cells: range) -> Results:
        """The results of a range of cells."""
        flat = np.arange(cells.start, cells.stop, dtype=np.int64)
        owners, results = self._tiles.owners(flat), self._blank(len(cells))
        numbers = [int(number) for number in np.unique(owners)]
        # The next range mostly needs the same tiles.
        self._sketches = {n: self._sketches[n] if n in self._sketches else self._load(n) for n in numbers}
        for number, sketch in self._sketches.items():
            if sketch is not None:
                at = np.flatnonzero(owners == number)
                sketch.paint(results, at, sketch.tile.places(flat[at]), self._interpolate)
        return results
