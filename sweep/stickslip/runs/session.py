"""Runs that resume where they stopped: finished blocks are kept, what is missing computed, then the result written."""

import os
from collections.abc import Callable, Collection, Iterator, Sequence
from contextlib import contextmanager, suppress
from dataclasses import dataclass, replace
from functools import partial
from typing import Any

from stickslip.config.model import Config
from stickslip.config.reader import Given, as_config, load_config, parse_config
from stickslip.config.sections import ADDRESS, HERE, is_address
from stickslip.config.yaml import Setting
from stickslip.engine import Progress, Results, StopFlag, stop_flag, warm_up
from stickslip.errors import ClusterError, IncompleteError, Interrupted, StoreError
from stickslip.files.locations import Location, Url, location
from stickslip.files.targets import Folder, check_target, folder_at
from stickslip.runs import block_store
from stickslip.runs.block_store import BlockStore
from stickslip.runs.formats import Lock, Notice, hold_lock
from stickslip.runs.output import Gathered, assemble, existing_output
from stickslip.runs.threads import Tally, compute_blocks
from stickslip.runs.work import Shard, Work, fingerprint

Machines = tuple[Callable[..., None], str | None]  # `threads.compute_blocks`, or alike on a cluster, which has a name


@dataclass(frozen=True)
class Request:
    """The request of a run.

    output : result to write; None leaves the blocks in the store.
    place : path of the store; None lays it beside the output, of one behind a URL into the current folder.
    shard : compute only its blocks. fresh : start over. keep : leave the store once the result is written.
    progress, assembling : called with (cells done, cells in all) while computing and while writing the result.
    notice : called with a line for people when something is worth knowing.
    prepare : called with the friction law before the first block is computed here.
    dask : address of a Dask scheduler, its file, `local` or `none`; or a `distributed.Client`; None takes what the
        configuration says.
    """

    config: Config
    output: Location | None = None
    place: str | os.PathLike[str] | None = None
    shard: Shard | None = None
    fresh: bool = False
    keep: bool = False
    progress: Progress | None = None
    assembling: Progress | None = None
    notice: Notice = lambda text: None  # noqa: E731
    prepare: Callable[[str], None] = warm_up
    dask: Any = None

    def __post_init__(self) -> None:
        if self.fresh and self.shard:
            raise ValueError("fresh: a shard cannot start over, since other shards share its store")
        if isinstance(self.dask, str) and not is_address(self.dask):
            raise ValueError(f"dask: got {self.dask!r}, expected {ADDRESS}")

    @property
    def cluster(self) -> Any:
        """The address or client of the cluster that computes; None for threads of this process."""
        named = self.config.execution.dask if self.dask is None else self.dask
        return None if isinstance(named, str) and named == HERE else named

    def folder(self) -> Folder:
        """The place of the store. Raises StoreError if neither it nor an output is named."""
        if self.place is not None:
            return folder_at(self.place)
        if self.output is None:
            raise StoreError("a run needs a place", hint="name an output file, or a store with {store}")
        return folder_at(block_store.beside(self.output))


@dataclass(frozen=True)
class Outcome:
    """The outcome of a run, in cells: of the map, found in the store, taken over from an older result, computed.

    output : the result, if it was written or (`up_to_date`) was there already. where : the store, if it is still there.
    machines : what computed, if not threads of this process.
    """

    cells: int
    found: int = 0
    reused: int = 0
    computed: int = 0
    output: Location | None = None
    where: str | None = None
    machines: str | None = None
    up_to_date: bool = False


def request_for(
    place: Given,
    output: str | os.PathLike[str] | None = None,
    store: str | os.PathLike[str] | None = None,
    settings: Sequence[Setting] = (),
) -> Request:
    """The request behind a configuration, or behind the path of a store.

    store : place of the store of a configuration, if not beside its output.
    settings : of a command line, put into the configuration; those that change the results of a store are refused when
        it is used.
    The output is the one named, else that of the configuration; a store called `FILE.parts` belongs to FILE,
    which may be behind a URL.
    Raises ConfigError or StoreError.
    """
    text = os.fspath(place) if isinstance(place, str | os.PathLike) else None
    beside: Location | None = None
    at = store
    if text is None or not ("://" in text or os.path.isdir(text)):
        config = as_config(place, apart=None) if text is None else load_config(text, settings, apart=None)
    else:
        folder = folder_at(text)
        config, at = block_store.find(folder).config(), text
        if settings:
            changed = parse_config(config.to_yaml(), text, settings)
            config = changed.shown_in(config.written_in | changed.written_in)
        configured = None if config.output.file is None else location(config.output.file)
        beside = folder.path.with_suffix("") if folder.path.suffix == block_store.SUFFIX else None
        if beside and isinstance(configured, Url) and configured.name == beside.name:
            beside = configured
    file = next((file for file in (output, beside, config.output.file) if file is not None), None)
    return Request(config, None if file is None else location(file), at)


# --- runs -------------------------------------------------------------------------------------------------------------


def run(request: Request) -> Outcome:
    """Compute what is missing, and write the result unless only a shard was asked for.

    Raises StoreError before anything is computed if output or store will not do, ClusterError if the cluster will not,
    IncompleteError if something could not be computed or written, and Interrupted on Ctrl-C.
    """
    folder = request.folder()
    block_store.check_ours(folder)
    if request.output is not None and not request.fresh and (whole := _finished(request)):
        _remove_leftovers(folder, request)
        return whole
    if request.output is not None:
        check_target(request.output, "result")
    if not request.fresh:
        if (there := block_store.found_at(folder)) is not None:  # before anybody's lock is touched
            block_store.check_same(there, Work(request.config), request.shard is not None)
    with _machines(request) as machines:
        return _locked(request, folder, machines, request.fresh)


def retry_failed(request: Request) -> Outcome:
    """Compute the blocks that failed again, and write the result if nothing is missing then. Raises as `run` does."""
    folder = request.folder()
    if block_store.is_empty(folder) and (whole := _finished(request)):
        return whole
    anew = block_store.find(folder).manifest.fresh  # as the run that began it
    with _machines(request) as machines:
        return _locked(request, folder, machines, anew, again=True)


def _finished(request: Request) -> Outcome | None:
    """The outcome of a run whose result is there and whole; None for others."""
    with existing_output(request.output, request.config, False) as old:
        whole = old is not None and old.complete
        return Outcome(old.cells, output=request.output, up_to_date=True) if old and whole else None


@contextmanager
def _machines(request: Request) -> Iterator[Machines]:
    """The machines of a request, found before anything is changed."""
    if request.cluster is None:
        yield compute_blocks, None
        return
    from stickslip.runs import cluster as clusters

    threads = request.config.execution.threads
    with clusters.connected(request.cluster, threads) as cluster:
        yield partial(clusters.compute_blocks, cluster), str(cluster)


def _locked(request: Request, folder: Folder, machines: Machines, anew: bool, again: bool = False) -> Outcome:
    """Compute the blocks that are missing, and write the result, while no other run works on the store.

    anew : whether the result replaces whatever is there. again : compute the blocks that failed before, and no others.
    """
    stop = stop_flag()
    with hold_lock(folder, request.shard, lambda: stop.fill(1), request.notice) as lock:
        with existing_output(request.output, request.config, anew) as old:
            work = Work(request.config, old.known, grid=old.grid) if old else Work(request.config)
            packing, shards = work.packing(request.output), request.shard.count if request.shard else 0
            store = block_store.prepare(folder, work, request.fresh, request.notice, packing, shards)
            session = _Session(request, store, replace(work, cut=store.blocks), lock)
            outcome = session.compute(again, machines, stop)
        session.require_lock()
        session.require_none_failed(session.own & store.failed())
        if request.shard or not store.is_complete():
            return outcome
        if request.output is not None:
            session.assemble(request.output)
        store.no_longer_fresh()
        if request.output is None:
            return outcome
        if request.keep:
            return replace(outcome, output=request.output)
        session.require_lock()
        block_store.delete(folder)
    return replace(outcome, output=request.output, where=None)


@dataclass(frozen=True)
class _Session:
    """A run at work on its store, whose lock it holds."""

    request: Request
    store: BlockStore
    work: Work
    lock: Lock

    @property
    def own(self) -> set[int]:
        """The blocks of the run, or of its shard."""
        store, shard = self.store, self.request.shard
        return set(shard.blocks(store.blocks) if shard else range(store.blocks.count))

    def compute(self, again: bool, machines: Machines, stop: StopFlag) -> Outcome:
        """Compute blocks, and say what ended that."""
        request, store, work, own = self.request, self.store, self.work, self.own
        if request.shard is None:
            block_store.remove_temporary(store.folder)
        before, failed, tally = store.cells(store.finished()), store.failed() & own, Tally()
        if again:
            for number in failed:
                store.clear_failure(number)
        numbers = failed if again else own - store.finished() - failed
        if not own:
            only = f"there are only {store.blocks.count:,} blocks"
            request.notice(f"shard {request.shard} has nothing to compute: {only}")
        if numbers and (finished := store.finished() & own):
            of = f" of shard {request.shard}" if request.shard else ""
            counts = f"{store.cells(finished):,} of {store.cells(own):,} {work.study.counted}{of}"
            request.notice(f"{counts} were found finished in {store.where}")
        if numbers and isinstance(request.output, Url):
            request.notice(f"finished blocks are kept in {store.where} until the result is written")
        compute, name = machines
        if numbers and name is None:
            for law in work.study.kernels:
                request.prepare(law)
        try:
            compute(store, work, numbers, tally, stop, self._progress())
        except KeyboardInterrupt:
            raise self._interrupted() from None
        except (StoreError, ClusterError) as error:
            raise self._incomplete(str(error)) from error
        computed = tally.cells - tally.reused
        return Outcome(work.size, before, tally.reused, computed, where=store.where, machines=name)

    def _progress(self) -> Progress | None:
        """The callback; of a shard, with its own items alone, since what others did before does not count."""
        progress, store = self.request.progress, self.store
        if progress is None or self.request.shard is None:
            return progress
        total, of_others = store.cells(self.own), store.cells(store.finished() - self.own)
        return lambda done, _size: progress(min(done - of_others, total), total)  # others may have gone on since

    def assemble(self, output: Location) -> None:
        """Write the result; blocks that turn out damaged are computed again."""
        request, store = self.request, self.store
        work = replace(self.work, known=None)  # the older map is closed

        def repair(number: int) -> Results:
            block = work.compute(number)
            store.save(number, block)
            return block.results

        try:
            assemble(Gathered(store, work, repair, request.notice), store, work, output, request.assembling)
        except KeyboardInterrupt:
            raise self._interrupted() from None
        except StoreError as error:
            raise self._incomplete(str(error)) from error

    def require_lock(self) -> None:
        """Raise IncompleteError if another run took over."""
        if not self.lock.ours:
            raise self._incomplete(f"{self.store.where}: another run took over")

    def require_none_failed(self, failed: Collection[int]) -> None:
        """Raise IncompleteError if blocks failed."""
        if failed:
            store, study = self.store, self.work.study
            first = store.failure(min(failed))
            count = f"{len(failed):,} block{'s' * (len(failed) > 1)} ({store.cells(failed):,} {study.counted}) failed"
            raise self._incomplete(
                f"{store.where}: {count}, the first, number {first.block}, with {first.message}\n"
                "hint: stickslip status shows what happened, stickslip retry-failed computes them again, and "
                f"stickslip collect writes a {study.name} without them"
            )

    def _interrupted(self) -> Interrupted:
        store = self.store
        done = store.cells(store.finished())
        return Interrupted(done, store.blocks.size, store.where, counted=self.work.study.counted)

    def _incomplete(self, message: str) -> IncompleteError:
        """The error, which says what has been saved, whatever happened."""
        return IncompleteError(f"{message}\n{self._interrupted().kept_cells}")


def _remove_leftovers(folder: Folder, request: Request) -> None:
    """A run that was killed between writing its result and removing its store leaves the latter."""
    if request.keep or request.shard is not None or not folder.names():
        return
    with suppress(StoreError):  # not ours to remove, in use, or in a folder that is read-only
        store = block_store.found_at(folder)
        if store is not None:
            goes_on = store.manifest.fresh and not store.is_complete()
            if goes_on or store.manifest.fingerprint != fingerprint(request.config):
                return
        with hold_lock(folder, None, lambda: None, request.notice):
            block_store.delete(folder)
