"""Incomplete stores: their status, and a result collected from their finished blocks."""

from __future__ import annotations

from dataclasses import dataclass, replace
from pathlib import Path

from stickslip.config.studies import Study
from stickslip.errors import StoreError
from stickslip.files.locations import ROOT, Location, Url
from stickslip.files.targets import check_target
from stickslip.runs import block_store
from stickslip.runs.block_store import Failure
from stickslip.runs.lock import WHOLE, Holder, hold_lock, holders, shard_of
from stickslip.runs.output import Gathered, assemble, existing_output
from stickslip.runs.session import Request
from stickslip.runs.work import Shard, Work, study_of

_OTHER = block_store.SAME_SETTINGS + ", or name another file with {output}"


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
    if request.output is None:
        raise StoreError("collect needs a file to write", hint="name it with {output}")
    folder = request.folder()
    if block_store.is_empty(folder) and (whole := _whole(request, request.output)):
        return whole
    store = block_store.find(folder)
    block_store.check_same(store, Work(request.config), no_fresh=True)
    check_target(request.output, "result")
    if not store.finished():
        raise StoreError(f"{store.where}: no finished blocks there, so there is nothing to collect")
    before = _seen(request.output)

    def check() -> None:
        if gathered.missing and _seen(request.output) != before:
            raise StoreError(
                f"{request.output}: another run wrote it meanwhile, and may have had more blocks: it is left as it is\n"
                "hint: collect again if cells are missing"
            )

    anew = store.manifest.fresh and store.is_complete()  # as the run would replace it
    with existing_output(request.output, request.config, anew, _OTHER) as old:
        known, grid = (old.known, old.grid) if old else (None, None)
        work = Work(request.config, known, store.blocks, grid)
        gathered = Gathered(store, work, None, request.notice)
        if work.known and isinstance(request.output, Url):
            work.known.dataset.load()  # the older store goes before the new one is written
        assemble(gathered, store, work, request.output, request.assembling, check)
    missing = sum(gathered.missing.values())
    collected = Collected(request.output, store.blocks.size, missing, store.where, work.study)
    if missing or request.keep:
        return collected
    try:
        with hold_lock(folder, None, lambda: None, request.notice):
            store.delete()
    except StoreError:  # another run works there; the last one removes it
        return collected
    return replace(collected, where=None)


def _whole(request: Request, output: Location) -> Collected | None:
    """An existing result, if it is the whole one of this configuration; None where there is none.

    Raises StoreError for a part of it, and for something else.
    """
    with existing_output(output, request.config, False, _OTHER) as old:
        if old is None:
            return None
        if not old.complete:
            raise StoreError(f"{output}: is there, but not complete, and has no store", hint="{run} computes the rest")
        return Collected(output, old.cells, 0, None, study_of(request.config), up_to_date=True)


def _seen(output: Location | None) -> tuple[int, ...] | None:
    """Marks of a result at a path, other than those of one that replaces it; None for none, and behind a URL."""
    if not isinstance(output, Path):
        return None
    try:
        about = (output / ROOT if output.is_dir() else output).stat()
    except OSError:
        return None
    return about.st_ino, about.st_mtime_ns, about.st_size


@dataclass(frozen=True)
class Status:
    """The progress of a run, in cells (or what else is `counted`) and blocks.

    holders : who works on it now; stale locks are not among them. shards : those that work, or died at it, and those
        that lack blocks.
    versions : of stickslip that began it. size : bytes.
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
    size: int
    counted: str
    shards: tuple[ShardStatus, ...] = ()


@dataclass(frozen=True)
class ShardStatus:
    """The progress of a shard: blocks in all, numbers of those to compute. holder : None if no process works on it.

    died : whether one did, which has left its lock.
    """

    shard: Shard
    blocks: int
    missing: tuple[int, ...]
    holder: Holder | None
    died: bool


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
        missing, died = left & set(own), holder is not None and holder.stale
        if missing or holder:
            shards.append(ShardStatus(shard, len(own), tuple(sorted(missing)), None if died else holder, died))
    return Status(
        where=store.where,
        title=request.config.title,
        cells=store.blocks.size,
        cells_finished=store.cells(finished),
        blocks=store.blocks.count,
        blocks_finished=len(finished),
        failures=tuple(store.failure(number) for number in sorted(store.failed() - finished)),
        holders=tuple(holder for holder in locks.values() if not holder.stale),
        begun=store.manifest.created,
        version=store.manifest.stickslip,
        size=folder.size(),
        counted=study_of(request.config).counted,
        shards=tuple(shards),
    )
