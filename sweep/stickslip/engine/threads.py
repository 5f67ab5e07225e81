"""Work spread over threads: the kernels run without the interpreter's lock."""

import os
from collections import deque
from collections.abc import Callable, Iterable, Iterator
from concurrent.futures import FIRST_COMPLETED, Future, ThreadPoolExecutor, wait
from itertools import islice
from typing import TypeVar

import numpy as np

from stickslip.engine.options import StopFlag

T = TypeVar("T")
Item = TypeVar("Item")

_QUEUED_PER_THREAD = 4
_PATIENCE = 0.2  # s between checks for Ctrl-C where waiting cannot be interrupted (Windows)


def processors() -> int:
    """Processors this process may use."""
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1


def stop_flag() -> StopFlag:
    """A flag that the kernels poll; once it is 1 they return within milliseconds."""
    return np.zeros(1, np.int64)


def spread(
    work: Callable[[Item], T],
    items: Iterable[Item],
    threads: int | None,
    stop: StopFlag,
    finished: Callable[[list[T]], None],
) -> None:
    """Call `work` with every item, on threads (None: one per processor), a few of them waiting at any time.

    finished : called from this thread with what has come back, in no order, and now and then with nothing.

    Ctrl-C, or an error in a thread, raises `stop`, waits for the threads to leave, and comes out as it is.
    """
    threads = threads or processors()
    waiting, pending = iter(items), set[Future[T]]()
    with ThreadPoolExecutor(threads) as pool:
        try:
            while True:
                # A few items wait in the queue, not all: what is looked at on each return stays short.
                room = _QUEUED_PER_THREAD * threads - len(pending)
                pending |= {pool.submit(work, item) for item in islice(waiting, room)}
                if not pending:
                    return
                done, pending = wait(pending, timeout=_PATIENCE, return_when=FIRST_COMPLETED)
                finished([future.result() for future in done])
        except BaseException:
            stop[0] = 1
            pool.shutdown(wait=True, cancel_futures=True)
            raise


def in_order(work: Callable[[Item], T], items: Iterable[Item], threads: int | None) -> Iterator[T]:
    """Yield what `work` makes of the items, in order, on threads (None: one per processor) that are a few ahead."""
    threads = threads or processors()
    waiting: deque[Future[T]] = deque()
    with ThreadPoolExecutor(threads) as pool:
        try:
            for item in items:
                waiting.append(pool.submit(work, item))
                if len(waiting) > 2 * threads:
                    yield waiting.popleft().result()
            while waiting:
                yield waiting.popleft().result()
        finally:
            pool.shutdown(wait=True, cancel_futures=True)
