"""How the cells of a run are cut into blocks: one file, one thread and one unit of loss each."""

from __future__ import annotations

import re
from dataclasses import dataclass

_FEWEST, _MOST = 4096, 131_072  # cells; below, files cost more than cells; above, a thread takes memory and is missed
_BLOCKS = 256  # aimed at, so that many threads and shards find work to the end


@dataclass(frozen=True)
class Blocks:
    """The cells from 0 to `size` in blocks of `length`, the last one shorter."""

    size: int
    length: int

    @property
    def count(self) -> int:
        """Number of blocks."""
        return -(-self.size // self.length)

    def cells(self, number: int) -> range:
        """The cells of a block."""
        return range(number * self.length, min((number + 1) * self.length, self.size))


@dataclass(frozen=True)
class Shard:
    """Part `number` of `count` (from 1) of the blocks of a run."""

    number: int
    count: int

    def blocks(self, blocks: Blocks) -> range:
        """Every `count`-th block: neighbours cost alike, so each shard gets its share of the expensive ones."""
        return range(self.number - 1, blocks.count, self.count)

    def __str__(self) -> str:
        return f"{self.number}/{self.count}"


def blocks_of(size: int, weight: int = 1) -> Blocks:
    """The blocks of a run of this many items, each of which takes about `weight` cells.

    Nothing else enters, so that every machine cuts alike.
    """
    fewest, most = max(_FEWEST // weight, 1), max(_MOST // weight, 1)
    return Blocks(size, min(max(-(-size // _BLOCKS), fewest), most))


def parse_shard(text: str) -> Shard:
    """The shard called `2/8`. Raises ValueError."""
    found = re.fullmatch(r"(\d{1,9})/(\d{1,9})", text.strip())
    if not found or not 1 <= int(found[1]) <= int(found[2]):
        raise ValueError(f"got {text!r}, expected a shard such as 1/8, 2/8 up to 8/8")
    return Shard(int(found[1]), int(found[2]))
