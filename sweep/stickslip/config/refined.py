"""Which axes of a refined map have boxes, and whether there are any."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

from stickslip.config.model import Axis, Range
from stickslip.config.rules import Finding
from stickslip.config.studies import Refine

_MOST_IN_BOX = 18  # a box has at most about 2^18 cells: tiles of several boxes a side must fit into memory


def refined_axes(axes: Sequence[Axis], depth: int) -> tuple[int, ...]:
    """The positions of the axes along which boxes extend: ranges of at least the points that a box has on a side.

    Along the others (lists, groups, short ranges) every point is a map of its own.
    """
    return tuple(i for i, axis in enumerate(axes) if isinstance(axis, Range) and axis.size > 2**depth)


def broken_rules(axes: Sequence[Axis], asked: Refine) -> Iterator[Finding]:
    """What does not fit between a refinement and the axes."""
    dims = refined_axes(axes, asked.depth)
    ranges = {axis.name: axis.size for axis in axes if isinstance(axis, Range)}
    if not ranges:
        hint = "a list of values has nothing between them; leave refine out to compute every cell"
        yield Finding(("refine",), "an axis with start, stop and num", hint, "no range among the axes")
    elif not dims:
        name = max(ranges, key=lambda name: ranges[name])
        most = (ranges[name] - 1).bit_length() - 1 if ranges[name] > 1 else 0
        hint = f"boxes have 2^depth + 1 points a side, and the longest range, {name}, has {ranges[name]}"
        yield Finding(("refine", "depth"), f"at most {most}", hint)
    elif asked.depth * len(dims) > _MOST_IN_BOX:
        hint = f"boxes would have 2^{asked.depth * len(dims)} cells in {len(dims)} dimensions"
        yield Finding(("refine", "depth"), f"at most {_MOST_IN_BOX // len(dims)}", hint)
