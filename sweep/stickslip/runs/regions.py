"""Cells are numbered with the last dimension running fastest; files want hyper-rectangles. Here is the way between."""

from __future__ import annotations

from math import prod

Region = tuple[slice, ...]


def regions(start: int, stop: int, shape: tuple[int, ...]) -> list[Region]:
    """The cells from `start` to `stop` as hyper-rectangles of an array of this shape, in the order of the cells.

    At most 2 n - 1 of them in n dimensions: a ragged beginning, what is whole, and a ragged end.
    """
    if start >= stop:
        return []
    if not shape:
        return [()]
    below = prod(shape[1:])
    (first, skipped), (last, rest) = divmod(start, below), divmod(stop, below)
    if first == last:
        return _at(first, regions(skipped, rest, shape[1:]))
    head = _at(first, regions(skipped, below, shape[1:])) if skipped else []
    first += bool(skipped)
    whole = [(slice(first, last), *(slice(0, length) for length in shape[1:]))] if first < last else []
    return head + whole + _at(last, regions(0, rest, shape[1:]))


def _at(index: int, inner: list[Region]) -> list[Region]:
    return [(slice(index, index + 1), *region) for region in inner]


def extent(region: Region) -> tuple[int, ...]:
    """Shape of a region."""
    return tuple(side.stop - side.start for side in region)
