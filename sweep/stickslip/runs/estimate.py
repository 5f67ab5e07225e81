"""Estimate of a run: time, memory, space on the disk, and how shards of it share the work."""

from __future__ import annotations

from dataclasses import dataclass
from math import ceil

from stickslip.config.grid import build_grid
from stickslip.config.model import Config
from stickslip.config.studies import Study
from stickslip.engine import bytes_per_cell, processors
from stickslip.runs.blocks import Blocks
from stickslip.runs.probe import Probe, probe
from stickslip.runs.work import Work

_OF_BLOCK = 4  # times its results: they, what the kernels fill, and the bytes that are written
_ONCE = 20_000_000  # bytes, whatever the map: what writes it, and reads it again for the summary
_OF_CELL = 800  # bytes of a cell while it is computed: its parameters, in SI and in kernel units, and all rows it fills


@dataclass(frozen=True)
class Estimate:
    """An estimate for one machine like this.

    at_once : blocks that are computed together. cells : to be computed. map_cells : of the map; 0 for results that are
        none. each : bytes of the results of a cell. memory : bytes, besides the program.
    """

    study: Study
    blocks: Blocks
    tried: Probe
    at_once: int
    cells: int
    map_cells: int
    each: int
    memory: int

    @property
    def seconds(self) -> float:
        """Time of the whole run here."""
        return self.tried.seconds_per_cell * self.cells

    @property
    def largest(self) -> int:
        """Items of the largest block."""
        return min(self.blocks.length, self.blocks.size)

    @property
    def store(self) -> int:
        """Most bytes of the finished blocks; less where they are compressed."""
        return self.cells * self.each

    @property
    def whole(self) -> int:
        """Bytes of the map before compression, or in memory."""
        return self.map_cells * self.each

    def on(self, nodes: int, threads: int) -> Nodes:
        """The estimate for shards on nodes of so many threads, each thread as fast as one here."""
        shards = min(nodes, self.blocks.count)
        least, most = self.blocks.count // shards, -(-self.blocks.count // shards)
        block = self.cells / self.blocks.count * self._thread_seconds
        return Nodes(nodes, threads, most, least, block, self.blocks.count)

    @property
    def _thread_seconds(self) -> float:
        """Of a thread for a cell."""
        return self.tried.seconds_per_cell * min(self.tried.threads, processors())


@dataclass(frozen=True)
class Nodes:
    """Shards, one a node. most, least : blocks of a shard. block_seconds : time of a thread for a block."""

    nodes: int
    threads: int
    most: int
    least: int
    block_seconds: float
    blocks: int

    @property
    def shards(self) -> int:
        """The number of shards: one a node, unless there are fewer blocks."""
        return min(self.nodes, self.blocks)

    @property
    def seconds(self) -> float:
        """Time of the shard that takes longest; a block is computed by one thread."""
        return ceil(self.most / self.threads) * self.block_seconds

    @property
    def seconds_of_one(self) -> float:
        """Time of the whole run on one such node."""
        return ceil(self.blocks / self.threads) * self.block_seconds


def estimate(config: Config) -> Estimate:
    """Time a few cells of a configuration. Raises KeyboardInterrupt on Ctrl-C."""
    from stickslip.studies.uncertainty import SampleStudy

    work = Work(config)
    study, blocks, options = work.study, work.blocks, work.options
    grid = build_grid(config)
    tried = probe(grid if config.uncertain is None else SampleStudy(config, options), options)
    each, together = bytes_per_cell(options), min(blocks.length, work.size) * study.weight
    at_once = min(tried.threads, blocks.count)
    memory = _ONCE + at_once * (_OF_BLOCK * together * each + _OF_CELL * min(options.block, together))
    map_cells = grid.size if study.name == "map" else 0
    return Estimate(study, blocks, tried, at_once, study.cells_each * work.size, map_cells, each, memory)
