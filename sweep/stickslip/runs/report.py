"""A run from outside: what it will take, from a few of its cells; how far it is; and its result from the blocks that
are there.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from math import ceil
from time import perf_counter
from typing import TYPE_CHECKING

import numpy as np

from stickslip.config.grid import build_grid
from stickslip.config.model import Config
from stickslip.config.studies import Study
from stickslip.engine import Options, bytes_per_cell, compute, processors, warm_up
from stickslip.errors import StoreError
from stickslip.files.locations import Location, Url
from stickslip.files.targets import check_target
from stickslip.runs import block_store
from stickslip.runs.block_store import Failure
from stickslip.runs.formats import WHOLE, Holder, hold_lock, holders, shard_of
from stickslip.runs.output import Gathered, assemble, existing_output
from stickslip.runs.session import Request
from stickslip.runs.work import Blocks, Shard, Work, study_of
from stickslip.vocabulary.cells import Cells
from stickslip.vocabulary.quantities import STATUSES

if TYPE_CHECKING:
    from stickslip.studies.uncertain import SampleStudy

_TOGETHER = 32  # neighbouring cells, as many as there are lanes
_TRIED = 8192  # cells, about
_OF_BLOCK = 4  # times its results: they, what the kernels fill, and the bytes that are written
_ONCE = 20_000_000  # bytes, whatever the map: what writes it, and reads it again for the summary
_OF_CELL = 800  # bytes of a cell while it is computed: its parameters, in SI and in kernel units, and all rows it fills
_PROGRAM = 500_000_000  # bytes of what is loaded
_MOST_STEPS = 200_000  # of a cell that is tried
_FIRST_SHARE, _MOST_GROWTH, _ENOUGH = 1e-7, 32.0, 0.5  # of the horizon; from one try to the next; s
_OTHER = block_store.SAME_SETTINGS + ", or name another file with {output}"


# --- what a run will take ---------------------------------------------------------------------------------------------


@dataclass(frozen=True)
class Probe:
    """The time that a few cells, spread over a map, took."""

    cells: int
    seconds_per_cell: float
    threads: int


def probe(cells: Cells | SampleStudy, options: Options, most: int = _TRIED) -> Probe:
    """Compute about `most` cells, in short runs spread evenly. Raises KeyboardInterrupt on Ctrl-C.

    To a horizon, the time grows with it: as much of it is tried as takes about a second. Cells that are not decided
    within `_MOST_STEPS` count as if they took all the steps they may.
    """
    runs = max(min(most, cells.size) // _TOGETHER, 1)
    starts = np.linspace(0, max(cells.size - _TOGETHER, 0), runs).astype(int)
    parts = [cells[int(start) : min(int(start) + _TOGETHER, cells.size)] for start in starts]
    sample = Cells.of({name: np.concatenate([part[name] for part in parts]) for name in parts[0]})
    if options.variables is not None:
        options = options.keeping((*options.variables, "status", "steps"))
    warm_up(options.law)
    most_steps, share = options.max_steps, 1.0 if options.early_stop else _FIRST_SHARE
    limit = min(most_steps, _MOST_STEPS) if options.early_stop else most_steps
    while True:
        began = perf_counter()
        part = compute(sample, replace(options, horizon=share * options.horizon, max_steps=limit))
        seconds = perf_counter() - began
        if not part.complete:
            raise KeyboardInterrupt
        if share == 1.0 or seconds > _ENOUGH:
            break
        share = min(share * min(max(2.0 * _ENOUGH / seconds, 2.0), _MOST_GROWTH), 1.0)
    steps, limited = part.results["steps"], part.results["status"] == STATUSES.index("step_limit")
    whole = np.where(limited, most_steps, np.minimum(steps / share, most_steps)).sum() / steps.sum()
    return Probe(sample.size, seconds * whole / sample.size, options.threads or processors())


@dataclass(frozen=True)
class Estimate:
    """An estimate for one machine like this.

    at_once : blocks that are computed together. cells : to be computed. map_cells : of the map; 0 for results that are
    none. each : bytes of the results of a cell. block_memory : bytes for each block at a time, memory : for all,
    besides the program. store : most bytes of the finished blocks; less where they are compressed. whole : bytes of the
    map before compression, or in memory. seconds : of the whole run here.
    """

    study: Study
    blocks: Blocks
    tried: Probe
    at_once: int
    cells: int
    map_cells: int
    each: int
    block_memory: int
    memory: int
    store: int
    whole: int
    seconds: float

    def on(self, nodes: int, threads: int) -> NodeEstimate:
        """The estimate for shards on nodes of so many threads, each thread as fast as one here."""
        shards = min(nodes, self.blocks.count)
        most = -(-self.blocks.count // shards)
        thread_seconds = self.tried.seconds_per_cell * min(self.tried.threads, processors())  # for a cell
        seconds = ceil(most / threads) * self.cells / self.blocks.count * thread_seconds
        memory = _PROGRAM + _ONCE + min(threads, most) * self.block_memory
        return NodeEstimate(nodes, threads, shards, most, seconds, memory)


@dataclass(frozen=True)
class NodeEstimate:
    """Shards, one a node, unless there are fewer blocks.

    most : blocks of a shard. seconds : of the shard that takes longest; a block is computed by one thread. memory :
    bytes of a node, with the program.
    """

    nodes: int
    threads: int
    shards: int
    most: int
    seconds: float
    memory: int


def estimate(config: Config) -> Estimate:
    """Time a few cells of a configuration. Raises KeyboardInterrupt on Ctrl-C."""
    from stickslip.studies.uncertain import SampleStudy

    work = Work(config)
    study, blocks, options = work.study, work.blocks, work.options
    grid = build_grid(config)
    tried = probe(study.sample(_TRIED) or (SampleStudy(config, options) if config.uncertain else grid), options)
    each, together = bytes_per_cell(options), min(blocks.length, work.size) * study.weight
    at_once = min(tried.threads, blocks.count)
    block_memory = _OF_BLOCK * together * each + _OF_CELL * min(options.block, together)
    map_cells, number = grid.size if study.name == "map" else 0, study.cells_each * work.size
    return Estimate(
        study, blocks, tried, at_once, number, map_cells, each, block_memory, _ONCE + at_once * block_memory,
        number * each, map_cells * each, tried.seconds_per_cell * number,
    )  # fmt: skip


# --- how far it is ----------------------------------------------------------------------------------------------------


@dataclass(frozen=True)
class Status:
    """The progress of a run, in cells (or what else is `counted`) and blocks.

    holders : who works on it now; stale locks are not among them. shards : those that work, or died at it, and those
        that lack blocks.
    versions : of stickslip that began it.
    """

    where: str
    title: str
    cells: int
    cells_finished: int
    blocks: int
    blocks_finished: int
    failures: tuple[Failure, ...]
    holders: tuple[Holder, ...]
    begun: str
    version: str
    counted: str
    shards: tuple[ShardStatus, ...] = ()


@dataclass(frozen=True)
class ShardStatus:
    """The progress of a shard: blocks in all, numbers of those to compute. holder : None if no process works on it."""

    shard: Shard
    blocks: int
    missing: tuple[int, ...]
    holder: Holder | None


def status(request: Request) -> Status:
    """The progress of the run of a store. Raises StoreError where there is none."""
    folder = request.folder()
    store = block_store.find(folder)
    finished, locks = store.finished(), holders(folder)
    left = set(range(store.blocks.count)) - finished - store.failed()
    of_shards = {shard: holder for name, holder in locks.items() if (shard := shard_of(name))}
    count = 0 if WHOLE in locks else store.manifest.shards
    shards = []
    for shard in sorted({*of_shards, *(Shard(i, count) for i in range(1, count + 1))}, key=lambda shard: shard.number):
        own, holder = shard.blocks(store.blocks), of_shards.get(shard)
        if (missing := left & set(own)) or holder:
            at_work = None if holder is None or holder.stale else holder
            shards.append(ShardStatus(shard, len(own), tuple(sorted(missing)), at_work))
    return Status(
        where=store.where,
        title=request.config.title,
        cells=store.blocks.size,
        cells_finished=store.cells(finished),
        blocks=store.blocks.count,
        blocks_finished=len(finished),
        failures=tuple(store.failure(number) for number in sorted(store.failed())),
        holders=tuple(holder for holder in locks.values() if not holder.stale),
        begun=store.manifest.created,
        version=store.manifest.stickslip,
        counted=study_of(request.config).counted,
        shards=tuple(shards),
    )


# --- its result -------------------------------------------------------------------------------------------------------


@dataclass(frozen=True)
class Collected:
    """The file that `collect` wrote: number of its cells (or lines, ...), and of those that are "not computed".

    where : the store, if it is still there. up_to_date : the result was there and whole, and no store.
    """

    output: Location
    cells: int
    missing: int
    where: str | None
    study: Study
    up_to_date: bool = False


def collect(request: Request) -> Collected:
    """Write the result from the blocks that are there; the cells of others are "not computed".

    A result that exists already must be one of the same map, and keeps its cells. A complete result replaces its
    store, unless that is kept or another run works there. Raises StoreError.
    """
    output, config = request.output, request.config
    if output is None:
        raise StoreError("collect needs a file to write", hint="name it with {output}")
    folder = request.folder()
    if block_store.is_empty(folder):
        with existing_output(output, config, False, _OTHER) as old:
            if old and old.complete:
                return Collected(output, old.cells, 0, None, study_of(config), up_to_date=True)
            if old:
                hint = "{run} computes the rest"
                raise StoreError(f"{output}: is there, but not complete, and has no store", hint=hint)
    store = block_store.find(folder)
    block_store.check_same(store, Work(config), no_fresh=True)
    check_target(output, "result")
    if not store.finished():
        raise StoreError(f"{store.where}: no finished blocks there, so there is nothing to collect")
    anew = store.manifest.fresh and store.is_complete()  # as the run would replace it
    with existing_output(output, config, anew, _OTHER) as old:
        work = Work(config, old.known, store.blocks, old.grid) if old else Work(config, cut=store.blocks)
        gathered = Gathered(store, work, None, request.notice)
        if work.known and isinstance(output, Url):
            work.known.dataset.load()  # the older store goes before the new one is written
        assemble(gathered, store, work, output, request.assembling)
    missing = sum(gathered.missing.values())
    collected = Collected(output, store.blocks.size, missing, store.where, work.study)
    if missing or request.keep:
        return collected
    try:
        with hold_lock(folder, None, lambda: None, request.notice):
            block_store.delete(folder)
    except StoreError:  # another run works there; the last one removes it
        return collected
    return replace(collected, where=None)
