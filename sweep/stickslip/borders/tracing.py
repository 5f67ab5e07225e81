"""From crossings on the sides of grid cells to lines: which crossings a cell joins, and chains of them.

Around a cell, counter-clockwise, labels change at crossings. Where a label has the same one on both sides, A [C] A, its
two crossings are joined: the line cuts C off, and what is left is looked at again. Where nothing can be cut off, three
or more labels meet: all crossings left are joined to one point inside, a junction.
"""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterable, Sequence
from dataclasses import dataclass

Node = int


@dataclass(frozen=True)
class Crossing:
    """A change of label on the way around a cell."""

    node: Node
    before: int
    after: int


@dataclass(frozen=True)
class Segment:
    """A piece of a border from one node to another, with the labels to its left and right."""

    start: Node
    end: Node
    left: int
    right: int


@dataclass(frozen=True)
class Chain:
    """A line through nodes; a closed one ends where it began."""

    nodes: tuple[Node, ...]
    left: int
    right: int

    @property
    def closed(self) -> bool:
        """Whether it is a loop."""
        return self.nodes[0] == self.nodes[-1]


def joined(around: Sequence[Crossing], centre: int | None, junction: Node) -> list[Segment]:
    """The segments inside a cell.

    around : its crossings counter-clockwise. centre : label in the middle of the cell, which is not cut off as long as
    another can be; None if not known. junction : the node to be used where three or more labels meet.
    """
    left, found = list(around), []
    while len(left) > 1:
        cuts = [i for i in range(len(left)) if left[i].before == left[(i + 1) % len(left)].after]
        if not cuts:
            break
        i = next((i for i in cuts if left[i].after != centre), cuts[0])
        first, second = left[i], left[(i + 1) % len(left)]
        found.append(Segment(first.node, second.node, first.before, first.after))
        left = [one for one in left if one is not first and one is not second]
    return found + [Segment(one.node, junction, one.before, one.after) for one in left]


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

    starts = [i for i, piece in enumerate(pieces) if meeting[piece.start] != 2]
    found = [follow(i) for i in starts]
    return found + [follow(i) for i in range(len(pieces)) if not used[i]]
