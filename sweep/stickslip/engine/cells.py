"""Many cells: blocks of them through the kernels, on threads, since the kernels run without the interpreter's lock.

Cells whose answer hangs on less than the error of the integration are integrated again, more tightly. They are few,
since they lie beside a border of regimes, or have next to no friction at speed. Which they are depends on the cell
alone, so its numbers do not depend on its neighbours.
"""

import os
from collections import deque
from collections.abc import Callable, Iterable, Iterator
from concurrent.futures import FIRST_COMPLETED, Future, ThreadPoolExecutor, wait
from itertools import islice
from math import ceil
from time import perf_counter
from typing import TypeVar

import numpy as np
from numpy.typing import NDArray

from stickslip.engine.compiling import warm_up
from stickslip.engine.dispatch import has_own_kernels, run_regimes, to_kernel, to_si
from stickslip.engine.options import Computed, Options, Progress, Results, StopFlag, columns, stop_flag
from stickslip.errors import StoppedError
from stickslip.vocabulary.cells import Cells, Parameters
from stickslip_kernels import layout
from stickslip_kernels.layout import new_regimes

T = TypeVar("T")
Item = TypeVar("Item")

Floats = NDArray[np.float64]
_ERRORS = 2.0  # tolerances: verdicts this close to a border may be wrong (those that were lay within 0.2 of them)
_GROWTH = 10.0  # of errors, from where on they show
_STEP, _TIGHTEST = 1e-3, 1e-12  # of a tolerance to the next; what the kernels were tested to
_LINE = 8  # numbers in a line of the processor's cache
_EVERY = 1.0  # s between calls that tell of cells finished, about
_TRIED, _FEWEST = 512, 64  # cells computed together before it is known how long they take, and at least
_SMALLEST_BLOCK = 512  # many times the lanes; below, lanes idle at the end of each block
_QUEUED_PER_THREAD = 4
_PATIENCE = 0.2  # s between checks for Ctrl-C where waiting cannot be interrupted (Windows)


def processors() -> int:
    """Processors this process may use."""
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1


def spread(
    work: Callable[[Item], T], items: Iterable[Item], threads: int | None, stop: StopFlag,
    finished: Callable[[list[T]], None],
) -> None:  # fmt: skip
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


# --- blocks -----------------------------------------------------------------------------------------------------------


def blocks(size: int, options: Options) -> Iterator[range]:
    """The cells of each block, in order: as long as may be, since lanes idle at the end of a block, and the last ones
    shorter, so that no thread waits long for another.
    """
    threads = options.threads or processors()
    start = 0
    while start < size:
        share = size if threads == 1 else max(ceil((size - start) / (2 * threads)), _SMALLEST_BLOCK)
        end = min(start + min(share, options.block), size)
        yield range(start, end)
        start = end


def compute(cells: Cells, options: Options, progress: Progress | None = None) -> Computed:
    """Every cell, on threads; the numbers do not depend on how the work is spread.

    progress : called with (cells done, cells in all) from this thread, now and then.

    Ctrl-C stops within milliseconds; the cells finished by then are returned, the others are "not computed".
    """
    if not has_own_kernels(options):  # else they are loaded where they are needed
        warm_up(options.law)
    size = cells.size
    results, stop = _room(size, options), stop_flag()
    done, filled = 0, set[range]()

    def compute_block(numbers: range) -> int:
        finished = _fill(results, cells, numbers, 0, options, stop)
        filled.add(numbers)
        return finished

    def count(finished: list[int]) -> None:
        nonlocal done
        done += sum(finished)
        if progress:
            progress(done, size)

    try:
        spread(compute_block, blocks(size, options), options.threads, stop, count)
    except KeyboardInterrupt:
        for numbers in blocks(size, options):
            if numbers not in filled:
                _leave_blank(results, slice(numbers.start, numbers.stop), options)
        done = int(np.count_nonzero(results["regime"]))  # finished blocks may not have been counted yet
    return Computed(results, done)


def compute_range(
    cells: Cells, start: int, end: int, options: Options, stop: StopFlag, moved: Callable[[int], None] | None = None,
    often: bool = False,
) -> Results:  # fmt: skip
    """The cells from `start` to `end`, by this thread alone: the numbers of `compute`, cell for cell.

    Raises StoppedError once `stop` is raised: half of them say nothing. moved : called with cells finished, now and
    then; often : about every second even where cells take long, which costs quick ones a few percent.
    """
    results, first = _room(end - start, options), start
    size = min(options.block, _TRIED) if often else options.block
    while first < end:
        numbers, began = range(first, min(first + size, end)), perf_counter()
        done, first = _fill(results, cells, numbers, start, options, stop), numbers.stop
        if done < len(numbers):
            raise StoppedError
        if moved:
            moved(done)
        if often:
            each = (perf_counter() - began) / len(numbers)
            size = min(options.block, max(_FEWEST, int(_EVERY / max(each, 1e-9))))
    return results


def solve(cells: Parameters, options: Options, stop: StopFlag, moved: Callable[[int], None] | None = None) -> Results:
    """The results of some cells, as by `compute_range`; `moved` is called about every second."""
    listed = Cells.of(cells)
    return compute_range(listed, 0, listed.size, options, stop, moved, often=True)


def _fill(results: Results, cells: Cells, numbers: range, origin: int, options: Options, stop: StopFlag) -> int:
    """Compute the cells of these numbers into `results`, which begins with cell `origin`; how many were finished."""
    place = slice(numbers.start - origin, numbers.stop - origin)
    if stop[0]:
        _leave_blank(results, place, options)
        return 0
    part = cells[numbers.start : numbers.stop]
    rows, done = _run_block(part, options, stop)
    in_si = to_si(rows, part, options)
    for name, values in results.items():
        values[place] = in_si[name]
    return done


def _leave_blank(results: Results, place: slice, options: Options) -> None:
    for name, values in blank_results(place.stop - place.start, options).items():
        results[name][place] = values


def bytes_per_cell(options: Options) -> int:
    """Memory the results of one cell take."""
    return sum(kind.itemsize for kind in columns(options).values())


def blank_results(size: int, options: Options) -> Results:
    """Results of cells that are not computed: zeros for flags and counts, NaN for the rest."""
    results = _room(size, options)
    for values in results.values():
        values.fill(np.nan if values.dtype.kind == "f" else 0)
    return results


def _room(size: int, options: Options) -> Results:
    """Results that nobody has filled yet, in one piece of memory: a large one has large pages, which cost less."""
    kinds = columns(options)
    room = iter(np.empty((sum(kind == np.float64 for kind in kinds.values()), size)))
    return {name: next(room) if kind == np.float64 else np.empty(size, kind) for name, kind in kinds.items()}


def _run_block(part: Parameters, options: Options, stop: StopFlag) -> tuple[Floats, int]:
    """One block through the kernels: the rows, and how many cells were finished.

    Rows are an odd number of cache lines apart: results of a cell a power of two apart would displace each other.
    """
    size = part["mass"].size
    cells, room = to_kernel(part, options.horizon, options), new_regimes((ceil(size / _LINE) | 1) * _LINE)
    rows = room[:, :size]
    if options.early_stop:
        run_regimes(options, options.rtol, cells, stop, room)
    else:
        order = _longest_first(cells)
        ordered, longest_first = np.ascontiguousarray(rows[:, order]), np.ascontiguousarray(cells[:, order])
        run_regimes(options, options.rtol, longest_first, stop, ordered)
        rows[:, order] = ordered
    integrate_closely(cells, rows, options, stop)
    done = int(np.count_nonzero(rows[layout.STATUS]))
    if done < size:  # nothing incomplete leaves this place
        rows[:, rows[layout.STATUS] == layout.NOT_RUN] = new_regimes(1)
    return rows, done


def _longest_first(cells: Floats) -> NDArray[np.intp]:
    """An order of these cells (kernel units) in which no lane has long to run when the queue is empty.

    To a fixed horizon the work is about that of the slips: each lasts a period of the free oscillation, each stick
    phase as long as the belt needs to load the spring by twice the drop of friction.
    """
    belt, drop = np.abs(cells[layout.BELT]), np.maximum(cells[layout.MU_STATIC] - cells[layout.A1], 0.0)
    with np.errstate(divide="ignore", invalid="ignore"):
        slips = cells[layout.HORIZON] / (2.0 * np.pi + 2.0 * drop / belt)
    return np.argsort(-slips, kind="stable")


# --- margins ----------------------------------------------------------------------------------------------------------


def integrate_closely(cells: Floats, rows: Floats, options: Options, stop: StopFlag) -> None:
    """Replace the results of cells that need a tighter tolerance than they were given.

    cells, rows : (CELL_ROWS, n) and (RESULT_ROWS, n) of `layout.py`, in kernel units. STEPS are of all runs together.
    Ringing without any drag may graze standstill, however closely that is looked at: what sticks there in the tightest
    run is rounding, and the first one holds.
    """
    rtol, first = np.full(rows.shape[1], options.rtol), rows.copy()
    while not stop[0]:
        wanted = np.maximum(_wanted(rows, rtol, options.rtol), _TIGHTEST)
        again = np.flatnonzero(wanted < rtol)
        if not again.size:
            grazes = (rtol < options.rtol) & (rows[layout.CLOSENESS] < _ERRORS * rtol)
            grazes &= first[layout.STATUS] == layout.NEUTRAL_RINGING
            first[layout.STEPS] = rows[layout.STEPS]
            rows[:, grazes] = first[:, grazes]
            return
        for tolerance in np.unique(wanted[again]):
            chosen = again[wanted[again] == tolerance]
            closer = new_regimes(chosen.size)
            run_regimes(options, float(tolerance), np.ascontiguousarray(cells[:, chosen]), stop, closer)
            closer[layout.STEPS] += rows[layout.STEPS, chosen]
            # What runs out of steps knows less than before; that holds, unless the verdict is close.
            less = np.isnan(closer[layout.RESTICK_TIME]) > np.isnan(rows[layout.RESTICK_TIME, chosen])
            less |= closer[layout.REGIME] == layout.UNRESOLVED
            less &= ~(rows[layout.CLOSENESS, chosen] < _ERRORS * rtol[chosen])
            rows[layout.STEPS, chosen], rtol[chosen] = closer[layout.STEPS], tolerance
            rows[:, chosen[~less]] = closer[:, ~less]


def _wanted(rows: Floats, rtol: Floats, given: float) -> Floats:
    """The tolerance that each cell needs; what it was integrated with where that will do."""
    wanted = np.where(rows[layout.CLOSENESS] < _ERRORS * rtol, _STEP * rtol, rtol)
    growth = np.clip(np.nan_to_num(rows[layout.ERROR_GROWTH] / _GROWTH, nan=1.0), 1.0, 1e300)
    # Whole decades, so that cells of a map share a few runs.
    return np.asarray(np.minimum(wanted, given * 10.0 ** -np.ceil(np.log10(growth))))
