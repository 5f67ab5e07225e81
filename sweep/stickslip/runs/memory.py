"""A study computed in memory, its blocks on the threads of this process."""

from __future__ import annotations

from math import prod

from stickslip.engine import Progress, Results, spread, stop_flag, warm_up
from stickslip.errors import Interrupted
from stickslip.runs.blocks import blocks_of
from stickslip.study import Meter, Study


def compute_study(study: Study, progress: Progress | None = None) -> list[Results]:
    """The results of all blocks, in order. Raises Interrupted on Ctrl-C, and what computing a block raises.

    progress : called with (items done, in part too, and items in all) from this thread, now and then.
    """
    for law in study.kernels:
        warm_up(law)
    size = prod(study.shape)
    blocks, stop, meter = blocks_of((size,), study.weight), stop_flag(), Meter(study.cells_each)
    found: dict[int, Results] = {}

    def compute(number: int) -> None:
        items = blocks.cells(number)
        finished = study.compute(items, stop, meter.watch(number, len(items)))
        if finished.complete:
            found[number] = finished.results
        meter.end(number, len(items) if finished.complete else 0)

    def show(_: list[None]) -> None:
        if progress:
            progress(meter.items, size)

    try:
        spread(compute, range(blocks.count), study.options.threads, stop, show)
    except KeyboardInterrupt:
        raise Interrupted(sum(len(blocks.cells(number)) for number in found), size, counted=study.counted) from None
    return [found[number] for number in range(blocks.count)]
