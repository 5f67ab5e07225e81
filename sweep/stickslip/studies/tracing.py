"""Lines in a plane: which grid cells hold a border, without looking at the others, and how crossings make lines.

Grid points and grid cells are numbered by (row, column); cell (i, j) has the points (i, j) to (i + 1, j + 1) as
corners. Rows run along y, columns along x. Labels are small integers, 0 is "not looked at".

Around a cell, counter-clockwise, labels change at crossings. Where a label has the same one on both sides, A [C] A, its
two crossings are joined: the line cuts C off, and what is left is looked at again. Where nothing can be cut off, three
or more labels meet: all crossings left are joined to one point inside, a junction. Junctions are closed in upon in all
such cells together.
"""

from collections import defaultdict
from collections.abc import Callable, Iterable, Sequence
from typing import NamedTuple

import numpy as np

from stickslip.studies.search import Floats, Integers, Labels

_CORNERS = np.array([(0, 0), (0, 1), (1, 1), (1, 0)])  # counter-clockwise from the lower left
_NEIGHBOURS = ((-1, 0), (0, 1), (1, 0), (0, -1))  # beyond the sides that begin at these corners
LabelsInCells = Callable[[Integers, Floats, Floats], Labels]  # of (cell, share along x, share along y)
_SIDE = 5  # points along a side of the window that is looked at; half of it is the next
_HALF = _SIDE // 2 + 1


class Points:
    """The labels of grid points, computed when first asked for.

    shape : rows and columns. labels_at : labels (1 and above) of rows and columns.
    """

    def __init__(self, shape: tuple[int, int], labels_at: Callable[[Integers, Integers], Labels]) -> None:
        self._labels_at = labels_at
        self.known = np.zeros(shape, np.int8)

    def __call__(self, row: Integers, column: Integers) -> Labels:
        """Labels of some points; those not known yet are computed together."""
        new = self.known[row, column] == 0
        if new.any():
            r, c = np.unique([row[new], column[new]], axis=1)
            self.known[r, c] = self._labels_at(r, c)
        return self.known[row, column]


def border_cells(points: Points, scan: int) -> Integers:
    """The grid cells whose corners differ, as rows (row, column), as far as a coarse scan leads to them.

    scan : how many rows and columns of points are looked at first. Borders that cross no side between neighbours of the
    scan twice are found; a loop between them is missed.
    """
    shape = np.array(points.known.shape) - 1
    ahead, seen = _seeds(points, scan), np.zeros(shape, np.bool_)
    cells = []
    while ahead.size:
        ahead = np.unique(ahead[((ahead >= 0) & (ahead < shape)).all(axis=1)], axis=0)
        ahead = ahead[~seen[tuple(ahead.T)]]
        seen[tuple(ahead.T)] = True
        labels = corner_labels(points, ahead)
        differs = labels != np.roll(labels, -1, axis=1)
        cells.append(ahead[differs.any(axis=1)])
        ahead = np.concatenate([ahead[differs[:, i]] + step for i, step in enumerate(_NEIGHBOURS)])
    return np.concatenate(cells) if cells else np.zeros((0, 2), np.int64)


def corner_labels(points: Points, cells: Integers) -> Labels:
    """Labels of the corners of cells (n, 2), counter-clockwise from the lower left: (n, 4)."""
    row, column = (cells[:, np.newaxis] + _CORNERS).transpose(2, 0, 1)
    return points(row, column)


def scanned(points: int, scan: int) -> Integers:
    """Which of the points along a side are looked at first."""
    return np.unique(np.linspace(0, points - 1, min(points, scan)).round().astype(np.int64))


def _seeds(points: Points, scan: int) -> Integers:
    """Cells beside one side with different ends for every pair of neighbours of the scan that differ."""
    coarse = [scanned(length, scan) for length in points.known.shape]
    grid = np.stack(np.meshgrid(*coarse, indexing="ij"), axis=-1)  # of (row, column)
    labels = points(grid[..., 0], grid[..., 1])
    seeds = []
    for axis in (0, 1):
        first, second = (np.take(grid, range(start, grid.shape[axis] - 1 + start), axis) for start in (0, 1))
        differ = np.diff(labels, axis=axis) != 0
        side = _side_between(points, first[differ], second[differ], axis)
        across = np.array([axis, 1 - axis])
        seeds += [side, side - across]
    return np.concatenate(seeds)


def _side_between(points: Points, low: Integers, high: Integers, axis: int) -> Integers:
    """The lower of two neighbouring points with different labels between each of `low` and of `high`."""
    low, high = low.copy(), high.copy()
    home = points(*low.T)
    while True:
        apart = np.flatnonzero(high[:, axis] - low[:, axis] > 1)
        if not apart.size:
            return low
        middle = low[apart]
        middle[:, axis] = (low[apart, axis] + high[apart, axis]) // 2
        same = points(*middle.T) == home[apart]
        low[apart[same]] = middle[same]
        high[apart[~same]] = middle[~same]


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
