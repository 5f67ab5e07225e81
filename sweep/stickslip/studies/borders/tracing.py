"""From crossings on the sides of grid cells to lines: which crossings a cell joins, and chains of them.

Around a cell, counter-clockwise, labels change at crossings. Where a label has the same one on both sides, A [C] A, its
two crossings are joined: the line cuts C off, and what is left is looked at again. Where nothing can be cut off, three
or more labels meet: all crossings left are joined to one point inside, a junction.

Junctions are closed in upon in all such cells together.
"""

from collections import defaultdict
from collections.abc import Callable, Iterable, Sequence
from typing import NamedTuple

import numpy as np

from stickslip.studies.borders.search import Floats, Integers, Labels

Node = int


class Crossing(NamedTuple):
    """A change of label on the way around a cell."""

    node: Node
    before: int
    after: int


class Segment(NamedTuple):
    """A piece of a border from one node to another, with the labels to its left and right."""

    start: Node
    end: Node
    left: int
    right: int


class Chain(NamedTuple):
    """A line through nodes; a closed one ends where it began."""

    nodes: tuple[Node, ...]
    left: int
    right: int

    @property
    def closed(self) -> bool:
        """Return whether it is a loop."""
        return self.nodes[0] == self.nodes[-1]


def joined(around: Sequence[Crossing], centre: int | None, junction: Node) -> list[Segment]:
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
    leaving: dict[Node, list[int]] = defaultdict(list)
    meeting: dict[Node, int] = defaultdict(int)
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


LabelsInCells = Callable[[Integers, Floats, Floats], Labels]  # of (cell, share along x, share along y)
_SIDE = 5  # points along a side of the window that is looked at; half of it is the next
_HALF = _SIDE // 2 + 1


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
