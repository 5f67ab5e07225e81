"""The borders in one plane: every node solved along a side of a fine grid, joined to lines and loops."""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from stickslip.config.studies import Moved
from stickslip.engine import Options, Results, StopFlag, by_theory, solve
from stickslip.studies.borders.lines import Side, growth_of, guide_of, uncontradicted
from stickslip.studies.borders.search import Brackets, Floats, Integers, Labels, Looked, Scan, search_lines
from stickslip.studies.borders.tracing import Chain, Crossing, Segment, chained, joined, meeting_points
from stickslip.studies.borders.walk import Points, border_cells, corner_labels
from stickslip.vocabulary.cells import Cells, Parameters
from stickslip.vocabulary.flags import REGIMES, UNDECIDED
from stickslip.vocabulary.models import model_of

OPEN = REGIMES.index("unresolved")  # what all that is undecided is called here: a region like any other
_ALONG_X, _ALONG_Y, JUNCTION = range(3)
_SMALLEST = 1e-15  # of the share of a side
_CLOSED_IN = 0.25  # of a cell: wider, the middle of the crossings around a junction says more than that of the window
_NEUTRAL = 2e-3  # damping ratio below which a cell may be undecided because motions grow or decay too slowly
_STEPS = 4.0 ** np.arange(-5, 2)  # of the grid, to places about such a cell
_AROUND = np.array([(-1, 0), (0, 1), (1, 0), (0, -1)])  # along y and x
_ROUNDS = 12  # of closing in on a junction: to 2e-4 of a cell
# Sides of a cell counter-clockwise: direction, row and column of where they begin, whether they are run backwards.
_SIDES = ((_ALONG_X, 0, 0, False), (_ALONG_Y, 0, 1, False), (_ALONG_X, 1, 0, True), (_ALONG_Y, 0, 0, True))


@dataclass
class Nodes:
    """Points of lines: (n,) each. `along` : which parameter was searched along there, or a junction.

    of_side : the crossings of a side of the grid (direction, panel, row, column), in ascending order: node numbers,
        with the labels before and after.
    """

    panel: Integers
    x: Floats
    y: Floats
    width: Floats
    along: NDArray[np.int8]
    of_side: dict[tuple[int, ...], list[Crossing]]

    def add(self, panel: int, x: float, y: float, width: float) -> int:
        """Append a junction, and give its number."""
        self.panel, self.x = np.append(self.panel, panel), np.append(self.x, x)
        self.y, self.width = np.append(self.y, y), np.append(self.width, width)
        self.along = np.append(self.along, np.int8(JUNCTION))
        return self.x.size - 1


class PlaneSearch:
    """A panel looked at through the engine. Everything raises StoppedError once the stop flag is raised."""

    def __init__(
        self, cells: Cells, y: Side, x: Side, panel: int, scan: int, tolerance: float, options: Options, stop: StopFlag,
        moved: Moved | None = None,
    ) -> None:  # fmt: skip
        self.cells, self.x, self.y, self.panel = cells, x, y, panel
        self.scan, self.tolerance = scan, tolerance
        self.options, self.stop, self.moved = options, stop, moved
        self.computed, self.undecided = 0, 0  # undecided: grid points that take the label of another
        self.points = Points((1, y.points, x.points), self.labels_of_points)

    def columns(self) -> Results:
        """The lines, as columns of a study."""
        cells = border_cells(self.points, (self.scan, self.scan))
        nodes = self.nodes(cells)
        chains = chained(self.segments(cells, nodes))
        counts = {"lines": len(chains), "looked_at": self.points.looked_at, "computed": self.computed,
                  "undecided": self.undecided}  # fmt: skip
        return {name: np.array([one]) for name, one in counts.items()} | _table(chains, nodes)

    @property
    def growth(self) -> str | None:
        """The result of linear theory that leads to borders, if one does."""
        return model_of(self.options.law).growth

    def labels_of_points(self, panel: Integers, row: Integers, column: Integers) -> Labels:
        """Regimes of grid points. Where one is undecided as small motions hardly grow or decay, it is that of the
        nearest decided place on its side of where they do neither."""
        labels = self.labels(panel, self.x.places[column], self.y.places[row])
        if (growth := self.growth) is None:
            return labels

        def theory(name: str, which: Integers, x: Floats, y: Floats) -> Floats:
            return by_theory(name, self.at(panel[which], x, y), self.options)

        def places(which: Integers, around: Integers, step: float) -> tuple[Floats, Floats]:
            y, x = step * around.T.astype(np.float64)
            return self.x.near(column[which], x), self.y.near(row[which], y)

        here = np.flatnonzero(labels == OPEN)
        here = here[np.abs(theory("damping_ratio", here, *places(here, _AROUND[:1], 0.0))) < _NEUTRAL]
        side = np.sign(theory(growth, here, *places(here, _AROUND[:1], 0.0)))
        for step in _STEPS:
            if not here.size:
                break
            which, around = np.repeat(here, len(_AROUND)), np.tile(_AROUND, (here.size, 1))
            x, y = places(which, around, step)
            found = np.full(which.size, OPEN, np.int8)
            same = theory(growth, which, x, y) * np.repeat(side, len(_AROUND)) > 0
            found[same] = self.labels(panel[which[same]], x[same], y[same])
            of_each = found.reshape(here.size, len(_AROUND))
            labels[here] = of_each[np.arange(here.size), np.argmax(of_each != OPEN, axis=1)]
            self.undecided += int(np.count_nonzero(labels[here] != OPEN))
            here, side = here[labels[here] == OPEN], side[labels[here] == OPEN]
        return labels

    def labels(self, panel: Integers, x: Floats, y: Floats) -> Labels:
        """Regimes of cells; what is undecided is `OPEN`."""
        return self.looked(panel, x, y)[0]

    def at(self, panel: Integers, x: Floats, y: Floats) -> Parameters:
        """The cells there."""
        return self.cells.take(panel + self.panel, **{self.x.name: x, self.y.name: y})

    def looked(self, panel: Integers, x: Floats, y: Floats) -> tuple[Labels, Floats]:
        """Regimes of cells, and the guide to where stick-slip ends by grazing."""
        results = solve(self.at(panel, x, y), self.options, self.stop, self.moved)
        self.computed += panel.size
        regime = results["regime"]
        labels = np.where(np.isin(regime, UNDECIDED), OPEN, regime).astype(np.int8)
        return labels, np.asarray(guide_of(results, self.options), np.float64)

    def labels_in_cells(self, cells: Integers, x: Floats, y: Floats) -> Labels:
        """Regimes at shares of grid cells (n, 3) along both sides."""
        panel, row, column = cells.T
        return self.labels(panel, self.x.at(column, x), self.y.at(row, y))

    def nodes(self, cells: Integers) -> Nodes:
        """Return where labels change on the sides of grid cells."""
        sides = _sides(cells, corner_labels(self.points, cells))
        found = self._crossings(sides)
        direction, panel, row, column = sides[found["line"]].T
        middle, across = found["place"], np.zeros(found.size)
        flat = direction == _ALONG_X
        x = self.x.at(column, np.where(flat, middle, across))
        y = self.y.at(row, np.where(flat, across, middle))
        of_side: dict[tuple[int, ...], list[Crossing]] = {}
        for node, one in enumerate(found):
            side = tuple(sides[one["line"]].tolist())
            of_side.setdefault(side, []).append(Crossing(node, int(one["below"]), int(one["above"])))
        return Nodes(panel, x, y, found["high"] - found["low"], direction.astype(np.int8), of_side)

    def _crossings(self, sides: Integers) -> Brackets:
        """Brackets on sides of the grid, as lines from 0 to 1 whose ends are known."""
        direction, panel, row, column = sides.T
        flat = direction == _ALONG_X
        low = self.points(panel, row, column)
        high = self.points(panel, np.where(flat, row, row + 1), np.where(flat, column + 1, column))
        open_ended = (low == OPEN) | (high == OPEN)

        def there(line: Integers, place: Floats) -> tuple[Integers, Floats, Floats]:
            x = self.x.at(column[line], np.where(flat[line], place, 0.0))
            y = self.y.at(row[line], np.where(flat[line], 0.0, place))
            return panel[line], x, y

        guide_at = growth_of(lambda line, place: self.at(*there(line, place)), self.options) if self.growth else None

        def labels_at(line: Integers, place: Floats) -> Looked:
            labels = np.where(place == 0.0, low[line], high[line])  # of ends, as neighbours see them
            inside = (place != 0.0) & (place != 1.0)
            some = inside if guide_at else np.ones(place.size, np.bool_)
            found, guide = self.looked(*there(line[some], place[some]))
            labels[inside] = found[inside[some]]
            guide = uncontradicted(guide_at(line, place), labels) if guide_at else guide
            return Looked(labels, (labels != OPEN) | open_ended[line], guide)

        shares = [share_of(side, self.tolerance) for side in (self.x, self.y)]
        found, _ = search_lines(len(sides), Scan(0.0, 1.0, 2, "linear"), min(shares), labels_at, guide_at)
        return found

    def segments(self, cells: Integers, nodes: Nodes) -> list[Segment]:
        """Return what is inside the grid cells; where three labels meet, a node is added."""
        rings = [_ring(cell, nodes.of_side) for cell in cells.tolist()]
        centres: list[int | None] = [None] * len(cells)
        many = np.array([i for i, ring in enumerate(rings) if len(ring) > 2], np.int64)
        half = np.full(many.size, 0.5)
        for i, label in zip(many, self.labels_in_cells(cells[many], half, half), strict=True):
            centres[i] = int(label)
        parts = [joined(*one, junction=-1) for one in zip(rings, centres, strict=True)]
        ends = np.array([i for i, part in enumerate(parts) if any(piece.end == -1 for piece in part)], np.int64)
        place, width = meeting_points(
            ends.size, lambda which, x, y: self.labels_in_cells(cells[ends[which]], x, y), _ROUNDS
        )
        for i, share, window in zip(ends, place, width, strict=True):
            panel, row, column = cells[i]
            x, y = (
                float(side.at(np.array(number), part))
                for side, number, part in ((self.x, column, share[0]), (self.y, row, share[1]))
            )
            if window > _CLOSED_IN:
                around = [one.node for one in rings[i]]
                x, y = float(nodes.x[around].mean()), float(nodes.y[around].mean())
            parts[i] = joined(rings[i], centres[i], nodes.add(panel, x, y, window))
        return [piece for part in parts for piece in part]


def share_of(side: Side, tolerance: float) -> float:
    """Return how much of a side of a grid cell the tolerance is, at least, where a border may lie."""
    low, high = np.abs(side.places[:-1]), np.abs(side.places[1:])
    scale = (np.maximum(low, high) / np.diff(side.places)).min()
    return float(np.clip(tolerance * scale, _SMALLEST, 0.5))


def _sides(cells: Integers, labels: Labels) -> Integers:
    """The sides of cells whose ends differ, once each: (n, 4) of direction, panel, row and column."""
    differs = labels != np.roll(labels, -1, axis=1)
    found = [np.zeros((0, 4), np.int64)]
    for k, (direction, row, column, _) in enumerate(_SIDES):
        begins = cells[differs[:, k]] + (0, row, column)
        found.append(np.insert(begins, 0, direction, axis=1))
    return np.unique(np.concatenate(found), axis=0)


def _ring(cell: list[int], of_side: Mapping[tuple[int, ...], list[Crossing]]) -> list[Crossing]:
    """The crossings around a cell, counter-clockwise from its lower left corner."""
    panel, row, column = cell
    found: list[Crossing] = []
    for direction, up, right, backwards in _SIDES:
        there = of_side.get((direction, panel, row + up, column + right), [])
        found += [Crossing(one.node, one.after, one.before) for one in reversed(there)] if backwards else there
    return found


def _table(chains: list[Chain], nodes: Nodes) -> Results:
    """Lines and nodes as columns."""
    order = np.array([node for chain in chains for node in chain.nodes], np.int64)
    return {
        "node_count": np.array([len(chain.nodes) for chain in chains], np.int32),
        "closed": np.array([chain.closed for chain in chains], np.int8),
        "regime_left": np.array([chain.left for chain in chains], np.int8),
        "regime_right": np.array([chain.right for chain in chains], np.int8),
        "x": nodes.x[order], "y": nodes.y[order], "node_width": nodes.width[order], "node_along": nodes.along[order],
    }  # fmt: skip
