"""Runs that resume where they stopped: finished blocks are kept, what is missing computed, then the result written."""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterator
from contextlib import contextmanager
from dataclasses import dataclass, replace
from functools import partial

from stickslip.engine import Progress, Results, StopFlag, stop_flag
from stickslip.errors import BlockFailedError, ClusterError, IncompleteError, Interrupted, StoreError
from stickslip.files.locations import Folder, Location
from stickslip.files.targets import check_target
from stickslip.runs import existing_output
from stickslip.runs.assembly import Gathered, assemble
from stickslip.runs.request import Outcome, Request
from stickslip.runs.settings import fingerprint
from stickslip.runs.threads import Tally, compute_blocks
from stickslip.runs.work import Work
from stickslip.runs.workdir import block_store
from stickslip.runs.workdir.block_store import BlockStore
from stickslip.runs.workdir.lock import Lock, hold_lock, writing_alone

Choice = Callable[[BlockStore, Request], set[int]]


@dataclass(frozen=True)
class Machines:
    """The threads, or the cluster, that compute blocks. compute : as `threads.compute_blocks`. name : for people; None
    for threads of this process."""

    compute: Callable[..., None]
    name: str | None = None


def run(request: Request) -> Outcome:
    """Compute what is missing, and write the result unless only a shard was asked for.

    Raises StoreError before anything is computed if output or store will not do, ClusterError if the cluster will not,
    IncompleteError if something could not be computed or written, and Interrupted on Ctrl-C.
    """
    folder = request.folder()
    block_store.check_ours(folder)
    if done := finished(request):
        _remove_leftovers(folder, request)
        return done
    if request.output is not None:
        check_target(request.output, "result")
    if not request.fresh:
        block_store.check_before(folder, Work(request.config), request.shard is not None)
    with _machines(request, folder) as machines:
        return _locked(request, folder, _missing, machines, request.fresh)


def finished(request: Request) -> Outcome | None:
    """The outcome where the result is there and whole, so that nothing is left to be done or written; else None.

    Raises StoreError for a result of another configuration or version.
    """
    if request.output is None or request.fresh:
        return None
    existing_output.finish_replacing(request.output, request.notice)
    with existing_output.opened(request.output, request.config, request.fresh) as old:
        whole = old is not None and old.complete
        return Outcome(old.cells, output=request.output, up_to_date=True) if old and whole else None


def retry_failed(request: Request) -> Outcome:
    """Compute the blocks that failed again, and write the result if nothing is missing then. Raises as `run` does."""
    folder = request.folder()
    anew = block_store.find(folder).manifest.fresh  # as the run that began it
    with _machines(request, folder) as machines:
        return _locked(request, folder, _failed_before, machines, anew)


@contextmanager
def _machines(request: Request, folder: Folder) -> Iterator[Machines]:
    """The machines of a request, found before anything is changed; no cluster if there are no blocks to compute."""
    if request.cluster is None or _has_all_blocks(request, folder):
        yield Machines(compute_blocks)
        return
    from stickslip.runs.dask import connecting, dispatch

    with connecting.connected(request) as cluster:
        yield Machines(partial(dispatch.compute_blocks, cluster), str(cluster))


def _has_all_blocks(request: Request, folder: Folder) -> bool:
    try:
        store = block_store.find(folder)
    except StoreError:
        return False
    return store.is_complete() and (
        not request.fresh or block_store.goes_on_fresh(store.manifest, Work(request.config))
    )


def _missing(store: BlockStore, request: Request) -> set[int]:
    """The blocks this run is to compute: those that failed before are left to `retry_failed`."""
    return _blocks_of(store, request) - store.finished() - store.failed()


def _failed_before(store: BlockStore, request: Request) -> set[int]:
    """The blocks that failed, which is forgotten."""
    failed = store.failed() & _blocks_of(store, request)
    for number in failed:
        store.clear_failure(number)
    return failed - store.finished()


def _blocks_of(store: BlockStore, request: Request) -> set[int]:
    all_blocks = range(store.blocks.count)
    return set(request.shard.blocks(store.blocks, store.manifest.deal) if request.shard else all_blocks)


def _locked(request: Request, folder: Folder, choose: Choice, machines: Machines, anew: bool) -> Outcome:
    """Compute the blocks that `choose` names, and write the result, while no other run works on the store.

    anew : whether the result replaces whatever is there.
    """
    stop = stop_flag()

    def lost() -> None:
        stop[0] = 1

    with hold_lock(folder, request.shard, lost, request.notice) as lock:
        with existing_output.opened(request.output, request.config, anew) as old:
            work = Work(request.config, old.known if old else None)
            store = block_store.prepare(folder, work, request.fresh, request.notice, work.packing(request.output))
            work = replace(work, cut=store.blocks)
            outcome = _computed(request, store, work, choose, machines, stop)
        _require_lock(lock, store, work)
        _require_none_failed(store, work, _blocks_of(store, request) & store.failed())
        if request.shard or not store.is_complete():
            return outcome
        if request.output is not None:
            _assembled(request, store, request.output)
        store.no_longer_fresh()
        if request.output is None:
            return outcome
        if request.keep:
            return replace(outcome, output=request.output)
        _require_lock(lock, store, work)
        store.delete()
    return replace(outcome, output=request.output, where=None)


def _computed(
    request: Request, store: BlockStore, work: Work, choose: Choice, machines: Machines, stop: StopFlag
) -> Outcome:
    """Compute blocks, and tell people what ended that."""
    if request.shard is None:
        block_store.remove_temporary(store.folder)
    before, numbers, tally = store.cells(store.finished()), choose(store, request), Tally()
    if numbers and (own := store.finished() & _blocks_of(store, request)):
        of = f" of shard {request.shard}" if request.shard else ""
        whole = store.cells(_blocks_of(store, request))
        (request.news or request.notice)(
            f"{store.cells(own):,} of {whole:,} {work.study.counted}{of} were found finished in {store.where}"
        )
    if numbers and machines.name is None:
        for law in work.study.kernels:
            request.prepare(law)
    at_once = request.on_error == "stop"
    try:
        machines.compute(store, work, numbers, tally, stop, stop_on_error=at_once, progress=_of_share(store, request))
    except KeyboardInterrupt:
        raise _interrupted(store, work) from None
    except BlockFailedError as failed:
        _require_none_failed(store, work, {failed.number})
    except (StoreError, ClusterError) as error:
        raise IncompleteError(f"{error}\n{_saved(store, work)}") from error
    return Outcome(
        work.size, before, tally.reused, tally.cells - tally.reused, where=store.where, machines=machines.name
    )  # fmt: skip


def _of_share(store: BlockStore, request: Request) -> Progress | None:
    """A callback with the items done of a shard, and of its own; what others did before does not count."""
    progress = request.progress
    if progress is None or request.shard is None:
        return progress
    own = _blocks_of(store, request)
    total, of_others = store.cells(own), store.cells(store.finished() - own)
    return lambda done, _size: progress(min(done - of_others, total), total)  # others may have gone on since


def _interrupted(store: BlockStore, work: Work) -> Interrupted:
    return Interrupted(store.cells(store.finished()), store.blocks.size, store.where, counted=work.study.counted)


def _saved(store: BlockStore, work: Work) -> str:
    """The cells that have been saved, whatever happened."""
    return _interrupted(store, work).kept_cells


def _require_lock(lock: Lock, store: BlockStore, work: Work) -> None:
    if not lock.ours:
        raise IncompleteError(f"{store.where}: another run took over\n{_saved(store, work)}")


def _require_none_failed(store: BlockStore, work: Work, failed: Collection[int]) -> None:
    if failed:
        first = store.failure(min(failed))
        count = f"{len(failed):,} block{'s' * (len(failed) > 1)} ({store.cells(failed):,} {work.study.counted}) failed"
        raise IncompleteError(
            f"{store.where}: {count}, the first, number {first.block}, with {first.message}\n"
            "hint: stickslip status shows what happened, stickslip retry-failed computes them again, and "
            f"stickslip collect writes a {work.study.name} without them\n{_saved(store, work)}"
        )


def _assembled(request: Request, store: BlockStore, output: Location) -> None:
    """Write the result; blocks that turn out damaged are computed again."""
    work = Work(request.config, cut=store.blocks)

    def repair(number: int) -> Results:
        block = work.compute(number)
        store.save(number, block)
        return block.results

    gathered = Gathered(store, work, repair, request.notice)
    try:
        with writing_alone(output, request.notice):
            assemble(gathered, store, work, output, request.assembling)
    except KeyboardInterrupt:
        raise _interrupted(store, work) from None
    except StoreError as error:
        raise IncompleteError(f"{error}\n{_saved(store, work)}") from error


def _remove_leftovers(folder: Folder, request: Request) -> None:
    """A run that was killed between writing its result and removing its store leaves the latter."""
    if request.keep or request.shard is not None or not folder.names():
        return
    try:
        if block_store.is_empty(folder):
            with hold_lock(folder, None, lambda: None, request.notice):
                return block_store.remove_temporary(folder)
        store = block_store.find(folder)
        if store.manifest.fingerprint != fingerprint(request.config):
            return
        if store.manifest.fresh and not store.is_complete():
            return request.notice(f"{store.where} holds a fresh run that was interrupted: the same command resumes it")
        with hold_lock(folder, None, lambda: None, request.notice):
            store.delete()
    except StoreError:  # not ours to remove, in use, or in a folder that is read-only
        return
