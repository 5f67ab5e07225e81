"""Blocks sent to the workers, a bounded number at a time, and the outcome of each."""

from __future__ import annotations

import pickle
import uuid
from collections import deque
from collections.abc import Collection
from dataclasses import astuple, dataclass
from queue import Empty, SimpleQueue
from time import monotonic, sleep
from typing import TYPE_CHECKING

from stickslip.engine import Progress, StopFlag
from stickslip.errors import ClusterError, DamagedBlockError, UnlikeWorkerError
from stickslip.files.locations import TEMPORARY
from stickslip.runs.dask.connecting import Cluster
from stickslip.runs.dask.worker import Job, compute_block, versions
from stickslip.runs.threads import Tally
from stickslip.runs.work import Work
from stickslip.runs.workdir.block_store import BlockStore
from stickslip.vocabulary.own_laws import pickled_law

if TYPE_CHECKING:
    from distributed import Future

_PER_THREAD = 3  # blocks in flight for each thread of a worker: one is computed, the others are ready
_FEWEST = 4  # in flight at least, so that workers that join find some
_RETRIES = 2  # of a block whose computing raised something; it may have been the machine
_ALONE = 16  # blocks that are tried once more alone after workers died over them
_LOOK, _COUNT, _LONELY, _SETTLE = 0.2, 2.0, 5.0, 60.0  # s: at the keyboard, workers; without workers; for slow folders


def compute_blocks(
    cluster: Cluster, store: BlockStore, work: Work, numbers: Collection[int], tally: Tally, stop: StopFlag, *,
    stop_on_error: bool, progress: Progress | None,
) -> None:  # fmt: skip
    """Compute these blocks on a cluster: as `threads.compute_blocks`, and raises ClusterError if that is lost."""
    # A name in the store by which workers know it; being temporary it is swept away should we be killed.
    token = f".dask-{uuid.uuid4().hex}{TEMPORARY}"
    job = Job(
        configuration=work.config.to_yaml(), blocks=astuple(work.blocks), packing=store.packing,
        place=store.folder.absolute, token=token, versions=versions(), law=pickled_law(work.config.friction.law),
        grid=b"" if work.grid is None else pickle.dumps(work.grid),
    )  # fmt: skip
    flight = _Flight(cluster, store, work, job, tally, stop, stop_on_error, progress)
    store.folder.write(token, b"")
    try:
        flight.send_all(sorted(numbers))
        flight.try_alone()
    finally:
        flight.cancel()
        store.folder.remove(token)
    # Blocks that other machines wrote may be listed here later: network file systems take their time.
    written, end = set(numbers).difference(tally.failed), monotonic() + _SETTLE
    while not stop[0] and not written <= store.finished() and monotonic() < end:
        sleep(1.0)


@dataclass
class _Flight:
    """The blocks in flight. Nothing of a block is held here or on the cluster once it has arrived."""

    cluster: Cluster
    store: BlockStore
    work: Work
    job: Job
    tally: Tally
    stop: StopFlag
    stop_on_error: bool
    progress: Progress | None

    def __post_init__(self) -> None:
        self._finished_before = self.store.cells(self.store.finished())
        self._run = f"stickslip-{uuid.uuid4().hex}"  # no other run's block has the name of one of ours
        self._under_way: dict[str, tuple[int, Future]] = {}
        self._arrived: SimpleQueue[Future] = SimpleQueue()
        self._suspects: list[int] = []
        self._alone = self._has_warned = False
        self._threads, self._counted, self._had_workers = 0, -_COUNT, monotonic()

    def send_all(self, numbers: Collection[int]) -> None:
        """Send these blocks and wait for them; those over which workers died are set aside, unless tried alone."""
        waiting = deque(numbers)
        while (waiting or self._under_way) and not self.stop[0]:
            for _ in range(min(self._room() - len(self._under_way), len(waiting))):
                self._send(waiting.popleft())
            self._receive_all()
            if self.progress:
                self.progress(self._finished_before + self.tally.cells, self.work.size)

    def try_alone(self) -> None:
        """Compute the blocks set aside once more, one after the other: most merely ran beside the one that kills.

        If there are very many the workers are at fault, and these blocks are recorded as failed at once.
        """
        suspects, self._suspects = self._suspects, []
        self._alone = True
        for number in suspects[:_ALONE]:
            self.send_all([number])
        for number in suspects[_ALONE:]:
            self._fail(number, RuntimeError("workers were killed while they computed this block or others with it"))

    def cancel(self) -> None:
        """Cancel what is in flight. Workers finish their current block."""
        for _, future in self._under_way.values():
            future.release()  # the scheduler forgets what is not referenced
        self._under_way.clear()

    def _room(self) -> int:
        """The number of blocks that may be in flight: it follows the workers as they come and go."""
        now = monotonic()
        if now - self._counted > _COUNT:
            self._threads, self._counted = self.cluster.threads(), now
            if self._threads:
                self._had_workers = now
            elif now - self._had_workers > _LONELY:
                self.cluster.notice(f"{self.cluster.where}: no workers there; waiting for some to join")
                self._had_workers = float("inf")  # said once, until some come
        return max(_PER_THREAD * self._threads, _FEWEST)

    def _send(self, number: int) -> None:
        known = self.work.known_cells(number)
        if known is not None and known[0].all():
            block = self.work.compute(number)
            self.store.save(number, block)
            return self._count(number, block.reused)
        key = f"{self._run}-{number}{'-alone' if self._alone else ''}"
        future = self.cluster.client.submit(compute_block, self.job, number, key=key, retries=_RETRIES, pure=False)
        self._under_way[key] = number, future
        future.add_done_callback(self._arrived.put)

    def _receive_all(self) -> None:
        """Wait a moment for blocks to come in, and see to all that did."""
        try:
            future = self._arrived.get(timeout=_LOOK)
            while True:
                self._handle(future)
                future = self._arrived.get_nowait()
        except Empty:
            return

    def _handle(self, future: Future) -> None:
        number = self._under_way[future.key][0]
        if future.status in ("pending", "lost"):  # its worker died at the last moment; it is computed again
            future.add_done_callback(self._arrived.put)
            return
        if future.status == "finished":
            self._receive(number, future)
        elif future.status == "error":
            self._handle_error(number, future)
        else:
            raise self.cluster.lost()
        del self._under_way[future.key]

    def _receive(self, number: int, future: Future) -> None:
        """A block was computed: it is written already, or its bytes are fetched and written here."""
        data = None if future.type is type(None) else self.cluster.ask(future.result)
        if data is None:
            return self._count(number, 0)
        try:
            self._write(number, data)
        except DamagedBlockError as error:
            self._fail(number, error)

    def _write(self, number: int, data: bytes) -> None:
        if not self._has_warned:
            self._has_warned = True
            self.cluster.notice(f"workers do not write to {self.store.where}: blocks are sent here to be written")
        self.store.put(number, data, self.work)
        self._count(number, 0)

    def _count(self, number: int, reused: int) -> None:
        self.tally.finish(len(self.store.blocks.cells(number)), reused)

    def _handle_error(self, number: int, future: Future) -> None:
        from distributed import KilledWorker

        error = self.cluster.ask(future.exception)
        if isinstance(error, UnlikeWorkerError):
            raise ClusterError(f"{self.cluster.where}: {error}\nhint: install the same versions there")
        if isinstance(error, KilledWorker):
            if not (self._alone or self.stop_on_error):
                return self._suspects.append(number)
            error = RuntimeError(
                f"{error.allowed_failures + 1} workers were killed while they computed this block, the last at "
                f"{error.last_worker.address}: too little memory, or the operating system or a job scheduler ended them"
            )
        self._fail(number, error)

    def _fail(self, number: int, error: Exception) -> None:
        self.tally.fail(self.store, number, error, self.stop_on_error)
