"""Missing blocks computed on the threads of this process, each written as soon as it is there."""

from __future__ import annotations

import threading
from collections.abc import Collection
from dataclasses import dataclass, field

from stickslip.engine import Progress, StopFlag, processors, spread
from stickslip.errors import BlockFailedError, StoreError
from stickslip.runs.work import Block, Work
from stickslip.runs.workdir.block_store import BlockStore
from stickslip.studies.study import Meter

_WAITING = 2  # threads that may wait for the disk, besides those that compute


@dataclass
class Tally:
    """The outcome of the blocks of a run. `cells` counts those of `finished`, `reused` cells among them."""

    finished: int = 0
    cells: int = 0
    reused: int = 0
    failed: list[int] = field(default_factory=list)


def compute_blocks(
    store: BlockStore,
    work: Work,
    numbers: Collection[int],
    tally: Tally,
    stop: StopFlag,
    *,
    stop_on_error: bool,
    progress: Progress | None,
) -> None:
    """Compute these blocks and count them in `tally`; it stays right whatever interrupts.

    An exception while computing is recorded in the store, and the others are computed unless `stop_on_error`; then it
    raises BlockFailedError. Blocks that cannot be written raise StoreError. `progress` is called with items done,
    in part too.
    """
    threads, before = work.options.threads or processors(), store.cells(store.finished())
    meter, counting, turns = Meter(work.study.cells_each, before), threading.Lock(), threading.Semaphore(threads)

    def packed(number: int) -> tuple[Block, bytes]:
        """A block and what its file holds; no more than `threads` at a time, while others wait for the disk."""
        with turns:
            if stop[0]:
                return Block({}, 0, False), b""
            try:
                block = work.compute(number, stop, meter.watch(number, len(store.blocks.cells(number))))
            except Exception:
                if stop_on_error:
                    stop[0] = 1  # before another thread has its turn
                raise
            return block, store.packed(number, block) if block.complete else b""

    def compute(number: int) -> None:
        try:
            block, data = packed(number)
        except StoreError:
            raise  # the older result cannot be read: no fault of the block
        except Exception as error:
            store.note_failure(number, error)
            meter.end(number, 0)
            with counting:
                tally.failed.append(number)
            if stop_on_error:
                raise BlockFailedError(number) from error
            return
        if block.complete:
            store.put(number, data)
            with counting:
                tally.finished += 1
                tally.cells += len(store.blocks.cells(number))
                tally.reused += block.reused
        meter.end(number, len(store.blocks.cells(number)) if block.complete else 0)

    def show(_: list[None]) -> None:
        if progress:
            progress(meter.items, work.size)

    spread(compute, sorted(numbers), threads + _WAITING, stop, show)
