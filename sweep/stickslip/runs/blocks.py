"""Cells of a run, cut into blocks: one file, one thread and one unit of loss each.

A block of a map is a chunk of its file too, so that what a thread has compressed goes into the file as it is.
"""

import re
from dataclasses import dataclass
from math import gcd, prod

_FEWEST, _MOST = 4096, 131_072  # cells; below, files cost more than cells; above, a thread takes memory and is missed
_GOLDEN = (1 + 5**0.5) / 2
_BLOCKS = 64  # aimed at, so that many threads and shards find work to the end; a large map has more
Region = tuple[slice, ...]


@dataclass(frozen=True)
class Blocks:
    """The items from 0 to `size`, plane after plane of `plane` items, each in blocks of `length`, the last one shorter.

    size : a multiple of `plane`.
    """

    size: int
    length: int
    plane: int

    @property
    def count(self) -> int:
        """Number of blocks."""
        return self.size // self.plane * self._in_plane

    def cells(self, number: int) -> range:
        """The items of a block."""
        plane, part = divmod(number, self._in_plane)
        start, end = plane * self.plane + part * self.length, (plane + 1) * self.plane
        return range(start, min(start + self.length, end))

    def at(self, item: int) -> int:
        """The block an item is in."""
        plane, place = divmod(item, self.plane)
        return plane * self._in_plane + place // self.length

    @property
    def _in_plane(self) -> int:
        return -(-self.plane // self.length)


@dataclass(frozen=True)
class Shard:
    """Part `number` of `count` (from 1) of the blocks of a run."""

    number: int
    count: int

    def blocks(self, blocks: Blocks) -> list[int]:
        """Its blocks, in every process the same.

        Neighbours cost alike, and so do blocks at the same place of each row. Dealt is a row of all blocks in steps
        of about the golden section, of which any piece lies evenly over the map and over the places in its rows.
        """
        count, step = blocks.count, round(blocks.count / _GOLDEN)
        while gcd(step, count) != 1:
            step += 1
        each, more = divmod(count, self.count)  # the first `more` shards get one more
        begin, end = (number * each + min(number, more) for number in (self.number - 1, self.number))
        return [place * step % count for place in range(begin, end)]

    def __str__(self) -> str:
        return f"{self.number}/{self.count}"


def blocks_of(shape: tuple[int, ...], weight: int = 1) -> Blocks:
    """The blocks of an array of items of this shape, each of which takes about `weight` cells.

    A block is one long along some dimensions, cut along the next, whole along those after it. Nothing but the shape
    enters, so that every machine cuts alike.
    """
    size = prod(shape)
    fewest, most = max(_FEWEST // weight, 1), max(_MOST // weight, 1)
    aim, below = min(max(-(-size // _BLOCKS), fewest), most), 1
    for length in reversed(shape):
        if below * length > aim:
            parts = -(-length // (aim // below))
            return Blocks(size, -(-length // parts) * below, length * below)
        below *= length
    return Blocks(size, size, size)


def chunks_of(blocks: Blocks, shape: tuple[int, ...]) -> tuple[int, ...] | None:
    """The chunks of a file whose chunks are blocks of an array of this shape; None if blocks are not of that kind."""
    below, chunks = 1, list[int]()
    for length in reversed(shape):
        cut = blocks.length // below if below < blocks.length else 1
        chunks.insert(0, min(cut, length))
        below *= length
    return tuple(chunks) if blocks_of_chunks(tuple(chunks), shape) == blocks else None


def blocks_of_chunks(chunks: tuple[int, ...], shape: tuple[int, ...]) -> Blocks:
    """The blocks that are these chunks."""
    cuts = [i for i, (chunk, length) in enumerate(zip(chunks, shape, strict=True)) if chunk < length]
    size = prod(shape)
    if not cuts:
        return Blocks(size, size, size)
    return Blocks(size, prod(chunks), prod(shape[cuts[-1] :]))


def parse_shard(text: str) -> Shard:
    """The shard called `2/8`. Raises ValueError."""
    match = re.fullmatch(r"(\d{1,9})/(\d{1,9})", text.strip())
    if not match or not int(match[2]):
        raise ValueError(f"got {text!r}, expected a shard such as 1/8, 2/8 up to 8/8")
    number, count = int(match[1]), int(match[2])
    if not 1 <= number <= count:
        raise ValueError(
            f"got {text!r}, but shards are counted from 1: 1/{count} to {count}/{count}\n"
            f"hint: in a SLURM array: --array=1-{count} and --shard $SLURM_ARRAY_TASK_ID/{count}"
        )
    return Shard(number, count)


# --- blocks in arrays -------------------------------------------------------------------------------------------------


def regions(start: int, stop: int, shape: tuple[int, ...]) -> list[Region]:
    """The cells from `start` to `stop` as hyper-rectangles of an array of this shape, in the order of the cells.

    Cells are numbered with the last dimension running fastest; files want hyper-rectangles. At most 2 n - 1
    of them in n dimensions: a ragged beginning, what is whole, and a ragged end.
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
