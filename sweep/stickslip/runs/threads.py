"""Missing blocks computed on the threads of this process, each written as soon as it is there."""

import threading
from collections.abc import Collection
from dataclasses import dataclass, field

from stickslip.engine import Progress, StopFlag, processors, spread
from stickslip.errors import BlockFailedError, StoppedError, StoreError
from stickslip.runs.work import Block, Work
from stickslip.runs.workdir.block_store import BlockStore
from stickslip.studies.study import Meter

_WAITING = 2  # threads that may wait for the disk, besides those that compute


@dataclass
class Tally:
    """The outcome of the blocks of a run. `cells` counts those of finished blocks, `reused` cells among them."""

    cells: int = 0
    reused: int = 0
    failed: list[int] = field(default_factory=list)
    _lock: threading.Lock = field(default_factory=threading.Lock)

    def finish(self, cells: int, reused: int) -> None:
        """Count a block that is in the store."""
        with self._lock:
            self.cells += cells
            self.reused += reused

    def fail(self, store: BlockStore, number: int, error: Exception, stop: bool) -> None:
        """Record the failure of a block in the store. Raises BlockFailedError if that is to stop the run."""
        store.note_failure(number, error)
        with self._lock:
            self.failed.append(number)
        if stop:
            raise BlockFailedError(number) from error


def compute_blocks(
    store: BlockStore, work: Work, numbers: Collection[int], tally: Tally, stop: StopFlag, *, stop_on_error: bool,
    progress: Progress | None,
) -> None:  # fmt: skip
    """Compute these blocks and count them in `tally`; it stays right whatever interrupts.

    An exception while computing is recorded in the store, and the others are computed unless `stop_on_error`; then it
    raises BlockFailedError. Blocks that cannot be written raise StoreError. `progress` is called with items done,
    in part too.
    """
    threads, before = work.options.threads or processors(), store.cells(store.finished())
    meter, turns = Meter(work.study.cells_each, before), threading.Semaphore(threads)

    def packed(number: int, items: int) -> tuple[Block, bytes]:
        """A block and what its file holds; no more than `threads` at a time, while others wait for the disk."""
        with turns:
            if stop[0]:
                raise StoppedError
            try:
                block = work.compute(number, stop, meter.watch(number, items))
            except Exception:
                if stop_on_error:
                    stop[0] = 1  # before another thread has its turn
                raise
            return block, store.packed(number, block)

    def compute(number: int) -> None:
        items = len(store.blocks.cells(number))
        try:
            block, data = packed(number, items)
        except StoreError:
            raise  # the older result cannot be read: no fault of the block
        except StoppedError:
            return meter.end(number, 0)
        except Exception as error:
            meter.end(number, 0)
            return tally.fail(store, number, error, stop_on_error)
        store.put(number, data)
        tally.finish(items, block.reused)
        meter.end(number, items)

    def show(_: list[None]) -> None:
        if progress:
            progress(meter.items, work.size)

    spread(compute, sorted(numbers), threads + _WAITING, stop, show)
