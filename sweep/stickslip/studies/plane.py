"""The borders in one plane: every node solved along a side of a fine grid, joined to lines and loops.

Grid points and grid cells are numbered by (row, column); cell (i, j) has the points (i, j) to (i + 1, j + 1) as
corners. Rows run along y, columns along x. Which cells hold a border is found by boxes (`search.Boxes`), of whose
points hardly more than those beside a border are looked at.

Around a cell, counter-clockwise, labels change at crossings. Where a label has the same one on both sides, A [C] A, its
two crossings are joined: the line cuts C off, and what is left is looked at again. Where nothing can be cut off, three
or more labels meet: all crossings left are joined to one point inside, a junction. Junctions are closed in upon in all
such cells together.
"""

from collections import defaultdict
from collections.abc import Callable, Iterable, Mapping, Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from stickslip.config.studies import Moved
from stickslip.engine import Options, Results, StopFlag, by_theory, solve
from stickslip.studies.lines import Side, decided, growth_of, guide_of, uncontradicted
from stickslip.studies.search import Boxes, Brackets, Floats, Integers, Labels, Looked, Scan, search_lines
from stickslip.vocabulary.cells import Cells, Parameters
from stickslip.vocabulary.models import model_of
from stickslip.vocabulary.quantities import REGIMES

OPEN = REGIMES.index("unresolved")  # what all that is undecided is called here: a region like any other
_ALONG_X, _ALONG_Y, _JUNCTION = range(3)
_SMALLEST = 1e-15  # of the share of a side
_CLOSED_IN = 0.25  # of a cell: wider, the middle of the crossings around a junction says more than that of the window
_NEUTRAL = 2e-3  # damping ratio below which a cell may be undecided because motions grow or decay too slowly
_STEPS = 4.0 ** np.arange(-5, 2)  # of the grid, to places about such a cell
_AROUND = np.array([(-1, 0), (0, 1), (1, 0), (0, -1)])  # along y and x
_ROUNDS = 12  # of closing in on a junction: to 2e-4 of a cell
_SIDE = 5  # points along a side of the window about a junction that is looked at; half of it is the next
_HALF = _SIDE // 2 + 1
# Sides of a cell counter-clockwise: direction, row and column of where they begin, whether they are run backwards.
_SIDES = ((_ALONG_X, 0, 0, False), (_ALONG_Y, 0, 1, False), (_ALONG_X, 1, 0, True), (_ALONG_Y, 0, 0, True))
LabelsInCells = Callable[[Integers, Floats, Floats], Labels]  # of (cell, share along x, share along y)


class Crossing(NamedTuple):
    """A change of label on the way around a cell."""

    node: int
    before: int
    after: int


class Segment(NamedTuple):
    """A piece of a border from one node to another, with the labels to its left and right."""

    start: int
    end: int
    left: int
    right: int


class Chain(NamedTuple):
    """A line through nodes; a closed one ends where it began."""

    nodes: tuple[int, ...]
    left: int
    right: int


_Rings = Mapping[tuple[int, ...], list[Crossing]]  # crossings in ascending order, by side (direction, row, column)


class LineNodes(NamedTuple):
    """Points of lines: (n,) each. `along` : which parameter was searched along there, or a junction."""

    x: Floats
    y: Floats
    width: Floats
    along: NDArray[np.int8]


class PlaneSearch:
    """A panel looked at through the engine. Everything raises StoppedError once the stop flag is raised."""

    def __init__(
        self, cells: Cells, y: Side, x: Side, panel: int, scan: int, tolerance: float, options: Options, stop: StopFlag,
        moved: Moved | None = None,
    ) -> None:  # fmt: skip
        self.cells, self.x, self.y, self.panel = cells, x, y, panel
        self.scan, self.tolerance = scan, tolerance
        self.options, self.stop, self.moved = options, stop, moved
        depth = max(((x.points - 1) // (scan - 1)).bit_length() - 1, 0)  # boxes are no wider than steps of the scan
        self.boxes = Boxes((y.points, x.points), depth, centres=False)

    def columns(self) -> Results:
        """The lines, as columns of a study."""
        labels = self.labels_on_grid()
        along_x, along_y = labels[:, 1:] != labels[:, :-1], labels[1:] != labels[:-1]
        sides = [np.insert(np.argwhere(differ), 0, way, axis=1)
                 for way, differ in ((_ALONG_X, along_x), (_ALONG_Y, along_y))]  # fmt: skip
        cells = np.argwhere(along_x[:-1] | along_x[1:] | along_y[:, :-1] | along_y[:, 1:])
        nodes, rings = self.nodes(np.concatenate(sides), labels)
        segments, nodes = self.segments(cells, nodes, rings)
        chains = chained(segments)
        return {"lines": np.array([len(chains)])} | _table(chains, nodes)

    @property
    def growth(self) -> str | None:
        """The result of linear theory that leads to borders, if one does."""
        return model_of(self.options.law).growth

    def labels_on_grid(self) -> Labels:
        """The labels of all grid points, those away from borders inferred. A loop inside a box is missed."""
        while (wanted := self.boxes.wanted()).size:
            self.boxes.learn(wanted, self.labels_of_points(*np.unravel_index(wanted, self.boxes.shape)))
        return self.boxes.inferred()

    def labels_of_points(self, row: Integers, column: Integers) -> Labels:
        """Regimes of grid points. Where one is undecided as small motions hardly grow or decay, it is that of the
        nearest decided place on its side of where they do neither."""
        labels = self.looked(self.x.places[column], self.y.places[row])[0]
        if (growth := self.growth) is None:
            return labels

        def theory(name: str, x: Floats, y: Floats) -> Floats:
            return by_theory(name, self.at(x, y), self.options)

        here = np.flatnonzero(labels == OPEN)
        x, y = self.x.places[column[here]], self.y.places[row[here]]
        neutral = np.abs(theory("damping_ratio", x, y)) < _NEUTRAL
        here, side = here[neutral], np.sign(theory(growth, x[neutral], y[neutral]))
        for step in _STEPS:
            if not here.size:
                break
            which, around = np.repeat(here, len(_AROUND)), np.tile(_AROUND, (here.size, 1))
            x, y = self.x.near(column[which], step * around[:, 1]), self.y.near(row[which], step * around[:, 0])
            beside = np.full(which.size, OPEN, np.int8)
            same = theory(growth, x, y) * np.repeat(side, len(_AROUND)) > 0
            beside[same] = self.looked(x[same], y[same])[0]
            of_each = beside.reshape(here.size, len(_AROUND))
            labels[here] = of_each[np.arange(here.size), np.argmax(of_each != OPEN, axis=1)]
            left = labels[here] == OPEN
            here, side = here[left], side[left]
        return labels

    def at(self, x: Floats, y: Floats) -> Parameters:
        """The cells there."""
        return self.cells.take(np.full(x.size, self.panel), **{self.x.name: x, self.y.name: y})

    def looked(self, x: Floats, y: Floats) -> tuple[Labels, Floats]:
        """Regimes of cells, `OPEN` what is undecided; and the guide to where stick-slip ends by grazing."""
        results = solve(self.at(x, y), self.options, self.stop, self.moved)
        regime = results["regime"]
        labels = np.where(decided(regime), regime, OPEN).astype(np.int8)
        return labels, np.asarray(guide_of(results, self.options), np.float64)

    def labels_in_cells(self, cells: Integers, x: Floats, y: Floats) -> Labels:
        """Regimes at shares of grid cells (n, 2) along both sides."""
        return self.looked(self.x.at(cells[:, 1], x), self.y.at(cells[:, 0], y))[0]

    def nodes(self, sides: Integers, labels: Labels) -> tuple[LineNodes, _Rings]:
        """Return where labels change on sides of grid cells, (n, 3) of direction, row and column."""
        brackets = self._crossings(sides, labels)
        direction, row, column = sides[brackets["line"]].T
        flat, place = direction == _ALONG_X, brackets["place"]
        x, y = self.x.at(column, np.where(flat, place, 0.0)), self.y.at(row, np.where(flat, 0.0, place))
        rings: dict[tuple[int, ...], list[Crossing]] = {}
        for node, (side, below, above) in enumerate(
            zip(sides[brackets["line"]].tolist(), brackets["below"].tolist(), brackets["above"].tolist(), strict=True)
        ):
            rings.setdefault(tuple(side), []).append(Crossing(node, below, above))
        return LineNodes(x, y, brackets["high"] - brackets["low"], direction.astype(np.int8)), rings

    def _crossings(self, sides: Integers, labels: Labels) -> Brackets:
        """Brackets on sides of the grid, as lines from 0 to 1 whose ends are known."""
        direction, row, column = sides.T
        flat = direction == _ALONG_X
        low, high = (labels[row + up, column + right] for up, right in ((0, 0), (~flat, flat)))
        open_ended = (low == OPEN) | (high == OPEN)

        def there(line: Integers, place: Floats) -> tuple[Floats, Floats]:
            x = self.x.at(column[line], np.where(flat[line], place, 0.0))
            return x, self.y.at(row[line], np.where(flat[line], 0.0, place))

        guide_at = growth_of(lambda line, place: self.at(*there(line, place)), self.options) if self.growth else None

        def labels_at(line: Integers, place: Floats) -> Looked:
            labels = np.where(place == 0.0, low[line], high[line])  # of ends, as neighbours see them
            inside = (place != 0.0) & (place != 1.0)
            computed = inside if guide_at else np.ones(place.size, np.bool_)
            regimes, guide = self.looked(*there(line[computed], place[computed]))
            labels[inside] = regimes[inside[computed]]
            guide = uncontradicted(guide_at(line, place), labels) if guide_at else guide
            return Looked(labels, (labels != OPEN) | open_ended[line], guide)

        tolerance = min(share_of(side, self.tolerance) for side in (self.x, self.y))
        return search_lines(len(sides), Scan(0.0, 1.0, 2, "linear"), tolerance, labels_at, guide_at)[0]

    def segments(self, cells: Integers, nodes: LineNodes, rings: _Rings) -> tuple[list[Segment], LineNodes]:
        """Return what is inside the grid cells; and the nodes, with one more where three labels meet."""
        around = [_ring(cell, rings) for cell in cells.tolist()]
        centres: list[int | None] = [None] * len(cells)
        many = np.array([i for i, ring in enumerate(around) if len(ring) > 2], np.int64)
        half = np.full(many.size, 0.5)
        for i, label in zip(many, self.labels_in_cells(cells[many], half, half), strict=True):
            centres[i] = int(label)
        parts = [joined(ring, centre, junction=-1) for ring, centre in zip(around, centres, strict=True)]
        ends = np.array([i for i, part in enumerate(parts) if any(piece.end == -1 for piece in part)], np.int64)
        place, width = meeting_points(
            ends.size, lambda which, x, y: self.labels_in_cells(cells[ends[which]], x, y), _ROUNDS
        )
        row, column = cells[ends].T
        x, y = self.x.at(column, place[:, 0]), self.y.at(row, place[:, 1])
        for number, i in enumerate(ends):
            if width[number] > _CLOSED_IN:
                on_sides = [crossing.node for crossing in around[i]]
                x[number], y[number] = nodes.x[on_sides].mean(), nodes.y[on_sides].mean()
            parts[i] = joined(around[i], centres[i], nodes.x.size + number)
        columns = zip(nodes, (x, y, width, np.full(ends.size, _JUNCTION, np.int8)), strict=True)
        nodes = LineNodes(*(np.concatenate([of_sides, inside]) for of_sides, inside in columns))
        return [piece for part in parts for piece in part], nodes


def share_of(side: Side, tolerance: float) -> float:
    """Return how much of a side of a grid cell the tolerance is, at least, where a border may lie."""
    low, high = np.abs(side.places[:-1]), np.abs(side.places[1:])
    scale = (np.maximum(low, high) / np.diff(side.places)).min()
    return float(np.clip(tolerance * scale, _SMALLEST, 0.5))


def _ring(cell: list[int], rings: _Rings) -> list[Crossing]:
    """The crossings around a cell, counter-clockwise from its lower left corner."""
    row, column = cell
    ring: list[Crossing] = []
    for direction, up, right, backwards in _SIDES:
        there = rings.get((direction, row + up, column + right), [])
        ring += [Crossing(node, after, before) for node, before, after in reversed(there)] if backwards else there
    return ring


def _table(chains: list[Chain], nodes: LineNodes) -> Results:
    """Lines and nodes as columns."""
    order = np.array([node for chain in chains for node in chain.nodes], np.int64)
    return {
        "node_count": np.array([len(chain.nodes) for chain in chains], np.int32),
        "closed": np.array([chain.nodes[0] == chain.nodes[-1] for chain in chains], np.int8),
        "regime_left": np.array([chain.left for chain in chains], np.int8),
        "regime_right": np.array([chain.right for chain in chains], np.int8),
        "x": nodes.x[order], "y": nodes.y[order], "node_width": nodes.width[order], "node_along": nodes.along[order],
    }  # fmt: skip


def joined(around: Sequence[Crossing], centre: int | None, junction: int) -> list[Segment]:
    """The segments inside a cell.

    around : its crossings counter-clockwise. centre : label in the middle of the cell, which is not cut off as long as
    another can be; None if not known. junction : the node to be used where three or more labels meet.
    """
    left, segments = list(around), []
    while len(left) > 1:
        cuts = [i for i in range(len(left)) if left[i].before == left[(i + 1) % len(left)].after]
        if not cuts:
            break
        i = next((i for i in cuts if left[i].after != centre), cuts[0])
        first, second = left[i], left[(i + 1) % len(left)]
        segments.append(Segment(first.node, second.node, first.before, first.after))
        left = [crossing for crossing in left if crossing is not first and crossing is not second]
    return segments + [Segment(crossing.node, junction, crossing.before, crossing.after) for crossing in left]


def chained(segments: Iterable[Segment]) -> list[Chain]:
    """Lines from end to end, then loops. The label with the smaller number is on the left.

    Nodes with two segments are passed; where one segment or three and more meet, lines end.
    """
    pieces = [s if s.left < s.right else Segment(s.end, s.start, s.right, s.left) for s in segments]
    leaving: dict[int, list[int]] = defaultdict(list)
    meeting: dict[int, int] = defaultdict(int)
    for i, piece in enumerate(pieces):
        leaving[piece.start].append(i)
        meeting[piece.start] += 1
        meeting[piece.end] += 1
    used = [False] * len(pieces)

    def follow(i: int) -> Chain:
        nodes = [pieces[i].start]
        while True:
            used[i] = True
            nodes.append(end := pieces[i].end)
            if meeting[end] != 2 or not leaving[end] or used[leaving[end][0]]:
                return Chain(tuple(nodes), pieces[i].left, pieces[i].right)
            i = leaving[end][0]

    lines = [follow(i) for i, piece in enumerate(pieces) if meeting[piece.start] != 2]
    return lines + [follow(i) for i in range(len(pieces)) if not used[i]]


def meeting_points(cells: int, labels_at: LabelsInCells, rounds: int) -> tuple[Floats, Floats]:
    """Places (cells, 2), as shares of the cell along x and y, and the width of the last window around them.

    A window of 5 x 5 points becomes the one of 3 x 3 of them in which the third most frequent label is met most
    often. Where no three labels are met, the window stays as it is: half a cell wide or wider, it is the whole cell.
    """
    corner, width = np.zeros((cells, 2)), np.ones(cells)
    active = np.arange(cells)
    steps = np.stack(np.meshgrid(*[np.linspace(0.0, 1.0, _SIDE)] * 2), axis=-1).reshape(-1, 2)  # of (x, y)
    for _ in range(rounds):
        if not active.size:
            break
        places = (corner[active, np.newaxis] + width[active, np.newaxis, np.newaxis] * steps).reshape(-1, 2)
        labels = labels_at(np.repeat(active, len(steps)), *places.T).reshape(-1, _SIDE, _SIDE)
        windows = np.lib.stride_tricks.sliding_window_view(labels, (_HALF, _HALF), axis=(1, 2))
        thirds = _third_most(windows.reshape(len(active), _HALF * _HALF, -1))
        best = np.argmax(thirds, axis=1)
        active, best = (values[thirds[np.arange(len(active)), best] > 0] for values in (active, best))
        step = width[active, np.newaxis] / (_SIDE - 1)
        corner[active] += np.stack(np.divmod(best, _HALF)[::-1], axis=1) * step
        width[active] /= 2
    return corner + width[:, np.newaxis] / 2, width


def _third_most(labels: Labels) -> Integers:
    """Return how often the third most frequent of labels occurs, along the last axis."""
    counts = np.stack([(labels == label).sum(axis=-1) for label in range(max(3, int(labels.max(initial=0)) + 1))])
    return np.asarray(np.sort(counts, axis=0)[-3], np.int64)
