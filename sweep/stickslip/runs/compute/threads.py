"""Missing blocks computed on the threads of this process, each written as soon as it is there."""

from __future__ import annotations

import threading
from collections.abc import Collection
from dataclasses import dataclass, field
from typing import Protocol

from stickslip.engine import Progress, StopFlag, processors, spread
from stickslip.errors import BlockFailedError, StoreError
from stickslip.runs.work import Block, Work
from stickslip.runs.workdir.parts import Parts

_WAITING = 2  # threads that may wait for the disk, besides those that compute


@dataclass
class Tally:
    """The outcome of the blocks of a run. `cells` counts those of `finished`, `reused` cells among them."""

    finished: int = 0
    cells: int = 0
    reused: int = 0
    failed: list[int] = field(default_factory=list)


class Compute(Protocol):
    """What `compute_blocks` does, here or elsewhere."""

    def __call__(
        self,
        parts: Parts,
        work: Work,
        numbers: Collection[int],
        tally: Tally,
        stop: StopFlag,
        *,
        stop_on_error: bool,
        progress: Progress | None,
    ) -> None:
        """Compute these blocks of a store."""


class _Meter:
    """Cells computed so far, counted from many threads; those of an unfinished block count until it fails."""

    def __init__(self, found: int) -> None:
        self._done, self._under_way, self._lock = found, dict[int, int](), threading.Lock()

    def move(self, number: int, cells: int) -> None:
        with self._lock:
            self._under_way[number] = self._under_way.get(number, 0) + cells

    def end(self, number: int, good: bool) -> None:
        with self._lock:
            cells = self._under_way.pop(number, 0)
            self._done += cells if good else 0

    @property
    def cells(self) -> int:
        with self._lock:
            return self._done + sum(self._under_way.values())


def compute_blocks(
    parts: Parts,
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
    raises BlockFailedError. Blocks that cannot be written raise StoreError. `progress` counts cells of finished blocks.
    """
    found, threads = parts.cells(parts.finished()), work.options.threads or processors()
    meter, counting, turns = _Meter(found), threading.Lock(), threading.Semaphore(threads)

    def packed(number: int) -> tuple[Block, bytes]:
        """A block and what its file holds; no more than `threads` at a time, while others wait for the disk."""
        with turns:
            if stop[0]:
                return Block({}, 0, False), b""
            try:
                block = work.compute(number, stop, lambda cells: meter.move(number, cells))
            except Exception:
                if stop_on_error:
                    stop[0] = 1  # before another thread has its turn
                raise
            return block, parts.packed(number, block) if block.complete else b""

    def compute(number: int) -> None:
        try:
            block, data = packed(number)
        except StoreError:
            raise  # the older result cannot be read: no fault of the block
        except Exception as error:
            parts.note_failure(number, error)
            meter.end(number, good=False)
            with counting:
                tally.failed.append(number)
            if stop_on_error:
                raise BlockFailedError(number) from error
            return
        if block.complete:
            parts.put(number, data)
            with counting:
                tally.finished += 1
                tally.cells += len(parts.blocks.cells(number))
                tally.reused += block.reused
        meter.end(number, good=block.complete)

    def show(_: list[None]) -> None:
        if progress:
            progress(meter.cells, work.size)

    spread(compute, sorted(numbers), threads + _WAITING, stop, show)
