"""Estimate of a run from a few of its cells: time, memory, space on the disk, and how shards of it share the work."""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from math import ceil
from time import perf_counter
from typing import TYPE_CHECKING

import numpy as np

from stickslip.config.grid import build_grid
from stickslip.config.model import Config
from stickslip.config.studies import Study
from stickslip.dataset.build import map_template
from stickslip.engine import Options, Results, bytes_per_cell, columns, compute, processors, warm_up
from stickslip.files import writing
from stickslip.files.locations import location
from stickslip.runs.work import Blocks, Work
from stickslip.vocabulary.cells import Cells
from stickslip.vocabulary.results import STATUSES

if TYPE_CHECKING:
    from stickslip.studies.uncertain import SampleStudy

_TOGETHER = 32  # neighbouring cells, as many as there are lanes
_TRIED = 8192  # cells, about
_OF_BLOCK = 4  # times its results: they, what the kernels fill, and the bytes that are written
_ONCE = 20_000_000  # bytes, whatever the map: what writes it, and reads it again for the summary
_OF_CELL = 800  # bytes of a cell while it is computed: its parameters, in SI and in kernel units, and all rows it fills
_PROGRAM = 500_000_000  # bytes of what is loaded
DISK = 500_000_000  # bytes/s: what is assumed of it
_MOST_STEPS = 200_000  # of a cell that is tried
_FIRST_SHARE, _MOST_GROWTH, _ENOUGH = 1e-7, 32.0, 0.5  # of the horizon; from one try to the next; s


@dataclass(frozen=True)
class Probe:
    """The time that a few cells, spread over a map, took; `at_step_limit` of them ran out of steps."""

    cells: int
    seconds_per_cell: float
    threads: int
    at_step_limit: int
    results: Results = field(repr=False)


def probe(cells: Cells | SampleStudy, options: Options, most: int = _TRIED) -> Probe:
    """Compute about `most` cells, in short runs spread evenly. Raises KeyboardInterrupt on Ctrl-C.

    To a horizon, the time grows with it: as much of it is tried as takes about a second. Cells that are not decided
    within `_MOST_STEPS` count as if they took all the steps they may.
    """
    runs = max(min(most, cells.size) // _TOGETHER, 1)
    starts = np.linspace(0, max(cells.size - _TOGETHER, 0), runs).astype(int)
    parts = [cells[int(start) : min(int(start) + _TOGETHER, cells.size)] for start in starts]
    sample = {name: np.concatenate([part[name] for part in parts]) for name in parts[0]}
    count = sample["mass"].size
    if options.variables is not None:
        options = options.keeping((*options.variables, "status", "steps"))
    warm_up(options.law)
    most_steps, share = options.max_steps, 1.0 if options.early_stop else _FIRST_SHARE
    while True:
        began = perf_counter()
        horizon, limit = share * options.horizon, min(most_steps, _MOST_STEPS) if options.early_stop else most_steps
        part = compute(Cells.of(sample), replace(options, horizon=horizon, max_steps=limit))
        seconds = perf_counter() - began
        if not part.complete:
            raise KeyboardInterrupt
        if share == 1.0 or seconds > _ENOUGH:
            break
        share = min(share * min(max(2.0 * _ENOUGH / seconds, 2.0), _MOST_GROWTH), 1.0)
    steps, limited = part.results["steps"] / share, part.results["status"] == STATUSES.index("step_limit")
    limited |= steps > most_steps
    whole = np.minimum(np.where(limited, most_steps, steps), most_steps).sum() / part.results["steps"].sum()
    return Probe(
        count, seconds * whole / count, options.threads or processors(), int(np.count_nonzero(limited)), part.results
    )


@dataclass(frozen=True)
class LastWrite:
    """The map put into its file, by one process, once all blocks are there: bytes, compressed, and time of the disk."""

    size: int
    files: int
    seconds: float


@dataclass(frozen=True)
class Estimate:
    """An estimate for one machine like this.

    largest : items of the largest block. at_once : blocks that are computed together. cells : to be computed.
    map_cells : of the map; 0 for results that are none. each : bytes of the results of a cell. block_memory : bytes for
    each block at a time, memory : for all, besides the program. store : most bytes of the finished blocks; less where
    they are compressed. whole : bytes of the map before compression, or in memory. seconds : of the whole run here.
    last_write : of maps with a file.
    """

    study: Study
    blocks: Blocks
    tried: Probe
    largest: int
    at_once: int
    cells: int
    map_cells: int
    each: int
    block_memory: int
    memory: int
    store: int
    whole: int
    seconds: float
    last_write: LastWrite | None

    def on(self, nodes: int, threads: int) -> NodeEstimate:
        """The estimate for shards on nodes of so many threads, each thread as fast as one here."""
        shards = min(nodes, self.blocks.count)
        least, most = self.blocks.count // shards, -(-self.blocks.count // shards)
        thread_seconds = self.tried.seconds_per_cell * min(self.tried.threads, processors())  # for a cell
        block = self.cells / self.blocks.count * thread_seconds
        memory = _PROGRAM + _ONCE + min(threads, most) * self.block_memory
        return NodeEstimate(nodes, threads, most, least, block, self.blocks.count, memory)


@dataclass(frozen=True)
class NodeEstimate:
    """Shards, one a node.

    most, least : blocks of a shard. block_seconds : time of a thread for a block. memory : bytes of a node, with the
    program.
    """

    nodes: int
    threads: int
    most: int
    least: int
    block_seconds: float
    blocks: int
    memory: int

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
    from stickslip.studies.uncertain import SampleStudy

    work = Work(config)
    study, blocks, options = work.study, work.blocks, work.options
    grid = build_grid(config)
    cells = study.sample(_TRIED) or (grid if config.uncertain is None else SampleStudy(config, options))
    tried = probe(cells, options)
    each, together = bytes_per_cell(options), min(blocks.length, work.size) * study.weight
    at_once = min(tried.threads, blocks.count)
    block_memory = _OF_BLOCK * together * each + _OF_CELL * min(options.block, together)
    map_cells = grid.size if study.name == "map" else 0
    number, last_write = study.cells_each * work.size, None
    if map_cells and grid.shape and config.output.file and not config.uncertain:
        written = {name: tried.results[name] for name in columns(options)}
        template = map_template(grid, getattr(study, "map_columns", study.columns), {})
        share = template["regime"].size / tried.results["regime"].size
        size = int(share * writing.packed_bytes(written))
        last_write = LastWrite(size, writing.count_files(template, location(config.output.file)), size / DISK)
    return Estimate(
        study, blocks, tried, min(blocks.length, blocks.size), at_once, number, map_cells, each, block_memory,
        _ONCE + at_once * block_memory, number * each, map_cells * each, tried.seconds_per_cell * number, last_write,
    )  # fmt: skip
