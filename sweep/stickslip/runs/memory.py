"""A study computed in memory, its blocks on the threads of this process."""

from __future__ import annotations

from math import prod

from stickslip.engine import Progress, Results, spread, stop_flag, warm_up
from stickslip.errors import Interrupted
from stickslip.runs.blocks import blocks_of
from stickslip.study import Study


def compute_study(study: Study, progress: Progress | None = None) -> list[Results]:
    """The results of all blocks, in order. Raises Interrupted on Ctrl-C, and what computing a block raises.

    progress : called with (items done, items in all) from this thread, now and then.
    """
    for law in study.kernels:
        warm_up(law)
    size = prod(study.shape)
    blocks, stop, done = blocks_of((size,), study.weight), stop_flag(), 0
    found: dict[int, Results] = {}

    def compute(number: int) -> int:
        finished = study.compute(blocks.cells(number), stop)
        if not finished.complete:
            return 0
        found[number] = finished.results
        return len(blocks.cells(number))

    def count(items: list[int]) -> None:
        nonlocal done
        done += sum(items)
        if progress:
            progress(done, size)

    try:
        spread(compute, range(blocks.count), study.options.threads, stop, count)
    except KeyboardInterrupt:
        raise Interrupted(done, size, counted=study.counted) from None
    return [found[number] for number in range(blocks.count)]
