"""A scheduler found, and its workers held against this process before anything is sent to them."""

from __future__ import annotations

import asyncio
import json
import logging
import signal
import threading
from collections import Counter
from collections.abc import Callable, Iterator
from concurrent.futures import CancelledError
from contextlib import ExitStack, contextmanager
from dataclasses import dataclass
from pathlib import Path
from queue import SimpleQueue
from time import monotonic, sleep
from typing import TYPE_CHECKING, Any

import dask.config

from stickslip.config.sections import LOCAL
from stickslip.engine import processor, processors
from stickslip.errors import ClusterError, Interrupted, reason
from stickslip.runs.dask.worker import describe, loaded, unlike, versions
from stickslip.runs.workdir.lock import Notice

if TYPE_CHECKING:
    from distributed import Client

PATIENCE = 10.0  # s, for a scheduler to answer
_STARTING = 60.0  # s, for processes to start on a busy machine
_SILENT = logging.CRITICAL + 1
_TALKATIVE = ("distributed", "tornado", "asyncio")  # loggers
_NAMED = 3  # workers named in a message
_LEAN = {  # of workers on this machine, which have one kind of task and no dashboard
    # At 64 KiB, as Dask has it, all arrays of all blocks are mapped anew: a quarter of a worker's time.
    "distributed.nanny.pre-spawn-environ.MALLOC_TRIM_THRESHOLD_": None,
    "distributed.worker.profile.enabled": False,
}
_HOW = (
    "hint: start one with `dask scheduler` and `dask worker tcp://HOST:8786`, and name it as tcp://HOST:8786; "
    "execution.dask: local starts processes on this machine, none computes without Dask"
)


@dataclass(frozen=True)
class Cluster:
    """A scheduler that answered. `where` names it for people, `notice` tells them something."""

    client: Client
    where: str
    notice: Notice

    def threads(self) -> int:
        """The number of blocks that its workers compute at once, now. Raises ClusterError if the scheduler is gone."""
        return sum(self.ask(self.client.nthreads).values())

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
def connected(cluster: Any, threads: int | None, notice: Notice) -> Iterator[Cluster]:
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
            connection = Cluster(client, where, notice)
            _check_alike(connection)
        except KeyboardInterrupt:
            raise Interrupted(0, 0, during=f"connecting to the Dask scheduler ({cluster})") from None
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
        if address != LOCAL:
            _knock(target)
        client = Client(target, timeout=PATIENCE, set_as_default=False, name="stickslip")
    except (OSError, TimeoutError) as error:
        raise ClusterError(f"{where}: no Dask scheduler answered within {PATIENCE:g} s\n{_HOW}") from error
    except Exception as error:  # a URL without port or of an unknown kind, TLS without keys, ...
        raise ClusterError(f"{where}: cannot be connected to ({reason(error)})\n{_HOW}") from error
    stack.callback(client.close, timeout=PATIENCE)
    return client, where


def _knock(address: str) -> None:
    """Raises OSError or TimeoutError where no scheduler answers: a client waits for ever for one that is silent."""
    from distributed.core import connect
    from distributed.security import Security

    async def answer() -> None:
        comm = await connect(address, timeout=PATIENCE, **Security().get_connection_args("client"))
        comm.abort()

    def ask() -> None:  # in a thread, since notebooks have a loop already
        try:
            heard.put(asyncio.run(asyncio.wait_for(answer(), PATIENCE)))
        except BaseException as error:
            heard.put(error)

    heard: SimpleQueue[BaseException | None] = SimpleQueue()
    threading.Thread(target=ask, daemon=True).start()
    if (error := heard.get()) is not None:
        raise error


def _local_cluster(threads: int | None) -> Any:
    """Worker processes on this machine, one thread each; nothing listens but on the loopback interface."""
    from distributed import LocalCluster

    count = threads or processors()
    own = dask.config.get("distributed.worker.preload", None) or []
    preload = [*([own] if isinstance(own, str) else own), "stickslip.runs.dask.worker"]
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
    while True:
        try:
            return str(json.loads(file.read_text())["address"])
        except (OSError, ValueError, KeyError, TypeError) as error:
            if monotonic() > end:
                why = reason(error) if isinstance(error, OSError) else "it names no address"
                message = f"{file}: not the file of a Dask scheduler, {PATIENCE:g} s long ({why})"
                raise ClusterError(f"{message}\n{_HOW}") from error
        sleep(0.1)


# --- workers ----------------------------------------------------------------------------------------------------------


def _check_alike(cluster: Cluster) -> None:
    """Raise ClusterError unless scheduler and workers run what this process runs; workers to come check themselves."""
    try:
        cluster.client.run_on_scheduler(loaded)
    except OSError as error:
        raise cluster.lost() from error
    except Exception as error:  # what could not be loaded is told in many ways
        hint = "hint: its scheduler needs stickslip too: install it there"
        raise ClusterError(f"{cluster.where}: {reason(error)}\n{hint}") from error
    workers = cluster.ask(lambda: cluster.client.run(describe, on_error="return"))
    wrong = []
    for address, worker in workers.items():
        if isinstance(worker, BaseException):
            wrong.append(f"{address}: {str(worker) or type(worker).__name__}")
        elif differing := unlike(versions(), worker["versions"]):
            wrong.append(f"{address} on {worker['host']}: {differing}")
    if wrong:
        named = "\n".join(f"  {text}" for text in wrong[:_NAMED])
        more = f"\n  and {len(wrong) - _NAMED} more" if len(wrong) > _NAMED else ""
        raise ClusterError(
            f"{cluster.where}: {len(wrong)} of {len(workers)} workers do not run what runs here\n{named}{more}\n"
            "hint: install the same versions there and start the workers again"
        )
    if kinds := Counter(kind for worker in workers.values() if (kind := worker["processor"]) != processor()):
        counts = ", ".join(f"{count} on {kind}" for kind, count in kinds.items())
        cluster.notice(f"workers on another processor than this one ({processor()}): {counts}; last digits may differ")
