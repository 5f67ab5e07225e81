"""Blocks of a run computed by the workers of a Dask cluster, which load this file, too, as does the scheduler.

A scheduler is found, and its workers are held against this process before anything is sent to them; then a bounded
number of blocks is in flight. Nothing is kept on the cluster. A worker that sees the store writes its blocks there;
from others they are sent back here.
"""

from __future__ import annotations

import json
import logging
import pickle
import platform
import signal
import threading
import uuid
from collections import deque
from collections.abc import Callable, Collection, Iterator, Mapping
from concurrent.futures import CancelledError
from contextlib import ExitStack, contextmanager
from dataclasses import dataclass, replace
from functools import lru_cache
from importlib.metadata import version
from pathlib import Path
from queue import Empty, SimpleQueue
from time import monotonic, sleep
from typing import TYPE_CHECKING, Any

import dask.config

from stickslip import engine, errors
from stickslip._version import __version__
from stickslip.config.sections import LOCAL
from stickslip.errors import ClusterError
from stickslip.files.targets import TEMPORARY, folder_at, host
from stickslip.runs.block_store import BlockStore
from stickslip.runs.formats import Manifest
from stickslip.runs.threads import Tally
from stickslip.runs.work import Work
from stickslip.vocabulary.models import own_law

if TYPE_CHECKING:
    from distributed import Client, Future

PATIENCE = 10.0  # s, for a scheduler to answer
_STARTING = 60.0  # s, for processes to start on a busy machine
_SILENT = logging.CRITICAL + 1
_TALKATIVE = ("distributed", "tornado", "asyncio")  # loggers
_NAMED = 3  # workers named in a message
_PER_THREAD = 3  # blocks in flight for each thread of a worker: one is computed, the others are ready
_FEWEST = 4  # in flight at least, so that workers that join find some
_RETRIES = 2  # of a block whose computing raised something; it may have been the machine
_LOOK, _COUNT, _SETTLE = 0.2, 2.0, 60.0  # s: at the keyboard, workers; for slow folders
_LEAN = {  # of workers on this machine, which have one kind of task and no dashboard
    # At 64 KiB, as Dask has it, all arrays of all blocks are mapped anew: a quarter of a worker's time.
    "distributed.nanny.pre-spawn-environ.MALLOC_TRIM_THRESHOLD_": None,
    "distributed.worker.profile.enabled": False,
}
_HOW = (
    "hint: start one with `dask scheduler` and `dask worker tcp://HOST:8786`, and name it as tcp://HOST:8786; "
    "--dask local starts processes on this machine, --dask none computes without Dask"
)


@dataclass(frozen=True)
class Cluster:
    """A scheduler that answered. `where` names it for people."""

    client: Client
    where: str

    def ask(self, question: Callable[[], Any]) -> Any:
        """The answer of the scheduler. Raises ClusterError if it is gone."""
        try:
            return question()
        except (OSError, RuntimeError, ValueError, CancelledError) as error:  # whatever a closed client raises
            raise self.lost() from error

    def lost(self) -> ClusterError:
        """The error of a connection that broke."""
        return ClusterError(f"{self.where}: lost the connection to the Dask scheduler; it ended, or the network did")

    def __str__(self) -> str:
        count = len(self.client.nthreads())
        return f"{count:,} Dask worker{'s' if count != 1 else ''} ({self.where})"


@contextmanager
def connected(cluster: Any, threads: int | None) -> Iterator[Cluster]:
    """The cluster a run is to be computed on, quiet, its workers of the same versions as this process.

    cluster : address of a scheduler, its file, `local` for so many processes on this machine; or a client.
    Raises ClusterError: the scheduler does not answer, a worker is of another version, `distributed` is missing.
    """
    with ExitStack() as stack:
        try:
            if isinstance(cluster, str):
                client, where = _connect(stack, cluster, threads)
            else:
                client, where = cluster, cluster.scheduler.address
            connection = Cluster(client, where)
            _check_alike(connection)
        except KeyboardInterrupt:
            raise errors.Interrupted(0, 0, during=f"connecting to the Dask scheduler ({cluster})") from None
        yield connection


def _connect(stack: ExitStack, address: str, threads: int | None) -> tuple[Client, str]:
    """A client of the scheduler at an address, and the name of that for people."""
    try:
        from distributed import Client
    except ModuleNotFoundError as error:
        raise ClusterError(
            "computing on a Dask cluster needs the optional package distributed\n"
            "hint: pip install 'stickslip[dask]', here and where the workers run"
        ) from error
    stack.enter_context(_silenced())
    patience = _STARTING if address == LOCAL else PATIENCE
    stack.enter_context(dask.config.set({"distributed.comm.timeouts.connect": f"{patience:g} s"}))
    if address == LOCAL:
        where = "this machine"
        try:
            target: Any = stack.enter_context(_local_cluster(threads))
        except (OSError, RuntimeError) as error:
            raise ClusterError(f"{where}: cannot start worker processes ({error})\n{_HOW}") from error
    else:
        target = where = _address_in(Path(address)) if address.endswith(".json") else address
    try:
        client = Client(target, timeout=PATIENCE, set_as_default=False, name="stickslip")
    except Exception as error:  # none there, a URL without port or of an unknown kind, TLS without keys, ...
        raise ClusterError(f"{where}: no Dask scheduler answered ({errors.reason(error)})\n{_HOW}") from error
    stack.callback(client.close, timeout=PATIENCE)
    return client, where


def _local_cluster(threads: int | None) -> Any:
    """Worker processes on this machine, one thread each; nothing listens but on the loopback interface."""
    from distributed import LocalCluster

    count = threads or engine.processors()
    own = dask.config.get("distributed.worker.preload", None) or []
    preload = [*([own] if isinstance(own, str) else own), "stickslip.runs.cluster"]
    # Ctrl-C is ignored for a second or two: here, since half of a cluster cannot be closed, and in what starts.
    is_main = threading.current_thread() is threading.main_thread()  # signals are set there and nowhere else
    before = signal.signal(signal.SIGINT, signal.SIG_IGN) if is_main else None
    try:
        with dask.config.set(_LEAN):
            return LocalCluster(
                n_workers=count, threads_per_worker=1, memory_limit=0, host="127.0.0.1", dashboard_address=None,
                silence_logs=_SILENT, preload=preload,
            )  # fmt: skip
    finally:
        if is_main:
            signal.signal(signal.SIGINT, before)


@contextmanager
def _silenced() -> Iterator[None]:
    """Silence Dask, unless its configuration says how it is to log (`logging`, or DASK_LOGGING__DISTRIBUTED).

    It reports lost connections at length, and our messages would be lost among its own.
    """
    own = [] if dask.config.get("logging", None) else [*logging.root.manager.loggerDict, *_TALKATIVE]
    loggers = [logging.getLogger(name) for name in own if name.split(".")[0] in _TALKATIVE]
    levels = [logger.level for logger in loggers]
    for logger in loggers:
        logger.setLevel(_SILENT)
    try:
        yield
    finally:
        for logger, level in zip(loggers, levels, strict=True):
            logger.setLevel(level)


def _address_in(file: Path) -> str:
    """The address in a scheduler file; it may take the scheduler a while to write it."""
    end = monotonic() + PATIENCE
    while not file.exists() and monotonic() < end:
        sleep(0.1)
    try:
        return str(json.loads(file.read_text())["address"])
    except (OSError, ValueError, KeyError, TypeError) as error:
        raise ClusterError(f"{file}: not the file of a Dask scheduler ({errors.reason(error)})\n{_HOW}") from error


def _check_alike(cluster: Cluster) -> None:
    """Raise ClusterError unless the workers run what this process runs; workers to come check themselves."""
    try:
        workers = cluster.ask(lambda: cluster.client.run(versions))
    except Exception as error:  # what could not be loaded is told in many ways
        hint = "hint: install stickslip where scheduler and workers run"
        raise ClusterError(f"{cluster.where}: {errors.reason(error)}\n{hint}") from error
    wrong = [f"\n  {address}: {text}" for address, there in workers.items() if (text := unlike(versions(), there))]
    if wrong:
        raise ClusterError(
            f"{cluster.where}: {len(wrong)} of {len(workers)} workers do not run what runs here"
            f"{''.join(wrong[:_NAMED])}\nhint: install the same versions there and start the workers again"
        )


# --- on the workers ---------------------------------------------------------------------------------------------------


@dataclass(frozen=True)
class Job:
    """The data that all blocks of a run have in common.

    work : pickled, behind the law of one's own that it may need. packing : of blocks. place : path of the store.
    token : a name that exists in the store while the run lasts. versions : those of the process that runs it.
    """

    work: bytes
    packing: str
    place: str
    token: str
    versions: dict[str, str]


def versions() -> dict[str, str]:
    """Versions that must be equal for equal bits, as this process loaded them."""
    return {
        "stickslip": __version__,
        "kernels": engine.kernels_digest(),
        "Python": ".".join(platform.python_version_tuple()[:2]),
        "numba": version("numba"),
        "numpy": version("numpy"),
    }


def unlike(here: Mapping[str, str], there: Mapping[str, str]) -> str:
    """`numba 0.61.0 (here 0.68.1)` and so on for what differs between two processes; empty if nothing does."""
    differing = [name for name in here if there.get(name) != here[name]]
    return ", ".join(f"{name} {there.get(name, 'unknown')} (here {here[name]})" for name in differing)


def dask_setup(_worker: object) -> None:
    """Called as worker processes on this machine start, or start again: Ctrl-C in the terminal is not for them."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)


def compute_block(job: Job, number: int) -> bytes | None:
    """Compute a block and write it into the store; give its bytes where the store is not to be seen.

    Raises UnlikeWorkerError and UncomputedError.
    """
    if differing := unlike(job.versions, versions()):
        raise errors.UnlikeWorkerError(f"a worker on {host()}: {differing}")
    try:
        return _computed(job, number)
    except Exception as error:
        raise errors.UncomputedError.of(error) from None


def _computed(job: Job, number: int) -> bytes | None:
    work, manifest = _loaded(job.work)
    for law in work.study.kernels:
        engine.warm_up(law)
    store = BlockStore(folder_at(job.place), manifest, job.packing)
    data = store.packed(number, work.compute(number))
    try:
        # If this machine sees the store too, the token is there. Another folder of that name has no such token, nor
        # has the store once the run is over: a worker that comes late leaves nothing behind.
        store.folder.read(job.token)
        store.put(number, data)
    except (FileNotFoundError, errors.StoreError):  # whatever keeps this machine from it may not keep the other
        return data
    return None


@lru_cache(maxsize=2)
def _loaded(pickled: bytes) -> tuple[Work, Manifest]:
    """The work of a run, and its manifest, once per process."""
    _, work = pickle.loads(pickled)
    return work, Manifest.of(work)


# --- blocks in flight -------------------------------------------------------------------------------------------------


def compute_blocks(
    cluster: Cluster, store: BlockStore, work: Work, numbers: Collection[int], tally: Tally, stop: engine.StopFlag, *,
    stop_on_error: bool, progress: engine.Progress | None,
) -> None:  # fmt: skip
    """As `threads.compute_blocks`, on a cluster; raises ClusterError if that is lost."""
    # A name in the store by which workers know it; being temporary it is swept away should we be killed.
    token = f".dask-{uuid.uuid4().hex}{TEMPORARY}"
    pickled = pickle.dumps((own_law(work.config.friction.law), replace(work, known=None)))
    job = Job(pickled, store.packing, store.folder.absolute, token, versions())
    flight = _Flight(cluster, store, work, job, tally, stop, stop_on_error, progress)
    store.folder.write(token, b"")
    try:
        flight.send_all(sorted(numbers))
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
    stop: engine.StopFlag
    stop_on_error: bool
    progress: engine.Progress | None

    def __post_init__(self) -> None:
        self._finished_before = self.store.cells(self.store.finished())
        self._run = f"stickslip-{uuid.uuid4().hex}"  # no other run's block has the name of one of ours
        self._under_way: dict[str, tuple[int, Future]] = {}
        self._arrived: SimpleQueue[Future] = SimpleQueue()
        self._threads, self._counted = 0, -_COUNT

    def send_all(self, numbers: Collection[int]) -> None:
        """Send these blocks and wait for them."""
        waiting = deque(numbers)
        while (waiting or self._under_way) and not self.stop[0]:
            for _ in range(min(self._room() - len(self._under_way), len(waiting))):
                self._send(waiting.popleft())
            self._receive_all()
            if self.progress:
                self.progress(self._finished_before + self.tally.cells, self.work.size)

    def cancel(self) -> None:
        """Cancel what is in flight. Workers finish their current block."""
        for _, future in self._under_way.values():
            future.release()  # the scheduler forgets what is not referenced
        self._under_way.clear()

    def _room(self) -> int:
        """The number of blocks that may be in flight: it follows the workers as they come and go."""
        now = monotonic()
        if now - self._counted > _COUNT:
            self._threads, self._counted = sum(self.cluster.ask(self.cluster.client.nthreads).values()), now
        return max(_PER_THREAD * self._threads, _FEWEST)

    def _send(self, number: int) -> None:
        known = self.work.known_cells(number)
        if known is not None and known[0].all():
            block = self.work.compute(number)
            self.store.save(number, block)
            return self.tally.finish(len(self.store.blocks.cells(number)), block.reused)
        key = f"{self._run}-{number}"
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
        if data is not None:
            try:
                self.store.put(number, data, self.work)
            except errors.DamagedBlockError as error:
                return self.tally.fail(self.store, number, error, self.stop_on_error)
        self.tally.finish(len(self.store.blocks.cells(number)), 0)

    def _handle_error(self, number: int, future: Future) -> None:
        error = self.cluster.ask(future.exception)
        if isinstance(error, errors.UnlikeWorkerError):
            raise ClusterError(f"{self.cluster.where}: {error}\nhint: install the same versions there")
        self.tally.fail(self.store, number, error, self.stop_on_error)
