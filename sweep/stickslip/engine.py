"""The seam to the kernels: blocks of cells on a pool of threads, SI outside, kernel units inside.

This is the only module that knows the kernels. Both conversions stand here, side by side (`to_kernel`, `to_si`); the
scales of a cell are the load N for forces, N/k for displacements, sqrt(m/k) for times, N/sqrt(k m) for speeds.
"""

from __future__ import annotations

import os
from collections.abc import Callable, Iterable
from concurrent.futures import FIRST_COMPLETED, Future, ThreadPoolExecutor, wait
from dataclasses import dataclass
from itertools import islice
from math import ceil, inf, isinf
from numbers import Integral
from time import perf_counter
from typing import Any, TypeVar

import llvmlite.binding as llvm
import numpy as np
from numpy.typing import NDArray

from stickslip_kernels import block, jit, laws, layout, trace

from .cells import Cells
from .compiling import compile_apart
from .variables import LAWS, STATUS_MESSAGES, STATUSES, VARIABLES

Results = dict[str, NDArray[Any]]
Progress = Callable[[int, int], None]
StopFlag = NDArray[np.int64]
T = TypeVar("T")

RTOL_RANGE = (1e-12, 1e-2)
_SMALLEST_BLOCK = 256  # a few times the lanes; below, lanes idle at the end of each block
_QUEUED_PER_THREAD = 4
_PATIENCE = 0.2  # s between two looks at the keyboard where waiting cannot be interrupted (Windows)
_BLOCKS_PER_THREAD = 8  # so that no thread waits long for the last one


@dataclass(frozen=True)
class Options:
    """How to integrate and how to spread the work. Defaults and limits are those of the configuration.

    law : one of `variables.LAWS`. horizon : s; inf for none. threads : None for one per processor.
    block : most cells computed together.
    """

    law: str = "stribeck"
    rtol: float = 1e-6
    horizon: float = inf
    max_steps: int = 1_000_000
    early_stop: bool = True
    threads: int | None = None
    block: int = 4096

    def __post_init__(self) -> None:
        if self.law not in LAWS:
            raise ValueError(f"law: got {self.law!r}, expected {', '.join(LAWS)}")
        if not RTOL_RANGE[0] <= self.rtol <= RTOL_RANGE[1]:
            raise ValueError(f"rtol: got {self.rtol!r}, expected {RTOL_RANGE[0]:g} to {RTOL_RANGE[1]:g}")
        if not self.horizon > 0:
            raise ValueError(f"horizon: got {self.horizon!r}, expected a time > 0 (s)")
        if not self.early_stop and isinf(self.horizon):
            raise ValueError("early_stop=False integrates every cell to the horizon, so it needs a finite horizon (s)")
        for name in ("max_steps", "block", "threads"):
            value = getattr(self, name)
            if not (value is None and name == "threads" or (isinstance(value, Integral) and int(value) >= 1)):
                raise ValueError(f"{name}: got {value!r}, expected a whole number >= 1")


class NotReachedError(RuntimeError):
    """A trajectory could not be integrated to its end; the message says how far, and why."""


@dataclass(frozen=True)
class Computed:
    """Results by names of `VARIABLES`, flat, in SI; `done` cells of them, fewer than all after an interruption."""

    results: Results
    done: int

    @property
    def complete(self) -> bool:
        """Whether every cell was computed."""
        return self.done == len(self.results["regime"])


# --- units ------------------------------------------------------------------------------------------------------------


def to_kernel(cells: Cells, horizon: float) -> NDArray[np.float64]:
    """Cells in SI to the rows of `layout.py`, shape (CELL_ROWS, n); horizon in s."""
    k, load = cells["stiffness"], cells["normal_load"]
    impedance = np.sqrt(k * cells["mass"])
    speed, rate = load / impedance, np.sqrt(k / cells["mass"])
    rows = np.empty((layout.CELL_ROWS, k.size))
    rows[layout.GAMMA] = cells["damping"] / impedance
    rows[layout.BELT] = cells["belt_speed"] / speed
    rows[layout.A1] = cells["a1"]
    rows[layout.A2] = cells["a2"] * speed
    rows[layout.A3] = cells["a3"]
    rows[layout.A4] = cells["a4"] / speed
    rows[layout.DELTA] = cells["delta"]
    mu_start = cells["a1"] + cells["a3"]
    rows[layout.MU_STATIC] = np.fmax(cells["mu_static"], mu_start)
    rows[layout.MU_STOP] = cells["mu_stop"]
    rows[layout.AGEING] = cells["ageing_rate"] / np.log(10.0)
    rows[layout.AGEING_TIME] = cells["ageing_time"] * rate
    rows[layout.XI_START] = cells["displacement"] * k / load
    rows[layout.ETA_START] = cells["velocity"] / speed
    rows[layout.CONTACT_START] = cells["contact_time"] * rate
    rows[layout.HORIZON] = horizon * rate
    return rows


def to_si(rows: NDArray[np.float64], cells: Cells, full: bool) -> Results:
    """The rows `run_block` filled to the variables people know.

    full : whether to add the variables that only a run to the horizon defines.
    """
    m, k, load = cells["mass"], cells["stiffness"], cells["normal_load"]
    time, length, speed = np.sqrt(m / k), load / k, load / np.sqrt(k * m)
    period = rows[layout.PERIOD] * time
    si = {
        "regime": rows[layout.REGIME],
        "status": rows[layout.STATUS],
        "breakaway_time": rows[layout.BREAKAWAY_TIME] * time,
        "restick_time": rows[layout.RESTICK_TIME] * time,
        "restick_displacement": rows[layout.RESTICK_XI] * length,
        "period": period,
        "frequency": 1.0 / period,
        "stick_fraction": rows[layout.CYCLE_STICK_TIME] / rows[layout.PERIOD],
        "spring_force_max": rows[layout.XI_MAX] * load,
        "spring_force_min": rows[layout.XI_MIN] * load,
        "slip_speed_max": rows[layout.SPEED_MAX] * speed,
        "acceleration_max": rows[layout.ACCELERATION_MAX] * load / m,
        "mu_reversal": rows[layout.MU_REVERSAL],
        "tendency": cells["a1"] + cells["a3"] - 2.0 * rows[layout.MU_REVERSAL] + cells["mu_stop"],
        "energy_per_cycle": rows[layout.CYCLE_HEAT] * load * length,
        "equilibrium_crossings": rows[layout.CROSSINGS],
        "settling_time": rows[layout.SETTLING_TIME] * time,
        "damping_ratio": rows[layout.DAMPING_RATIO],
        "steps": rows[layout.STEPS],
    }
    if full:
        si |= {
            "sticks": rows[layout.STICKS],
            "stick_time": rows[layout.STICK_TIME] * time,
            "displacement_end": rows[layout.XI_END] * length,
            "velocity_end": rows[layout.ETA_END] * speed,
        }
    return si


# --- many cells -------------------------------------------------------------------------------------------------------


def will_compile(law: str = "stribeck") -> bool:
    """Whether a computation with this law compiles the kernels first: once per machine, version and law."""
    return not jit.is_ready(law)


def warm_up(law: str = "stribeck") -> None:
    """Load the kernels from the cache, and have them compiled into it before if need be."""
    if jit.CACHE_FOLDER is not None and will_compile(law):
        compile_apart(law, lambda: will_compile(law))
    load(law)


def load(law: str) -> None:
    """Load the kernels, or compile them in this process: `compiling` says who should."""
    none, control = np.empty((layout.CELL_ROWS, 0)), np.array([1e-6, 1.0, 1.0])
    block.run_block(laws.LAWS[law], none, block.new_results(0), control, block.NO_LOG, np.zeros(1, np.int64))
    jit.mark_ready(law)


def processors() -> int:
    """Processors this process may use."""
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1


def block_size(size: int, options: Options) -> int:
    """Cells per block: `options.block`, less where that would leave a thread without work."""
    threads = options.threads or processors()
    share = ceil(size / (threads * _BLOCKS_PER_THREAD))
    return min(options.block, max(share, _SMALLEST_BLOCK))


def compute(
    cells: Callable[[int, int], Cells], size: int, options: Options, progress: Progress | None = None
) -> Computed:
    """Every cell from 0 to `size`, on threads; the numbers do not depend on how the work is spread.

    cells : gives the cells from start to stop; called from the threads.
    progress : called with (cells done, cells in all) from this thread, now and then.

    Ctrl-C stops within milliseconds; the cells finished by then are returned, the others are "not computed".
    """
    warm_up(options.law)
    results, step, stop = blank_results(size, options), block_size(size, options), stop_flag()
    done = 0

    def compute_block(start: int) -> int:
        return _fill(results, cells, range(start, min(start + step, size)), 0, options, stop)

    def count(finished: list[int]) -> None:
        nonlocal done
        done += sum(finished)
        if progress:
            progress(done, size)

    try:
        spread(compute_block, range(0, size, step), options.threads, stop, count)
    except KeyboardInterrupt:
        done = int(np.count_nonzero(results["regime"]))  # finished blocks may not have been counted yet
    return Computed(results, done)


def compute_range(
    cells: Callable[[int, int], Cells],
    start: int,
    end: int,
    options: Options,
    stop: StopFlag,
    moved: Callable[[int], None] | None = None,
) -> Computed:
    """The cells from `start` to `end`, by this thread alone: the numbers of `compute`, cell for cell.

    stop : once it is raised, what is left stays "not computed". moved : called with cells finished, now and then.
    """
    results, done = blank_results(end - start, options), 0
    for first in range(start, end, options.block):
        part = _fill(results, cells, range(first, min(first + options.block, end)), start, options, stop)
        done += part
        if moved:
            moved(part)
    return Computed(results, done)


def stop_flag() -> StopFlag:
    """What the kernels look at while they run; set it to 1 and they leave within milliseconds."""
    return np.zeros(1, np.int64)


def spread(
    work: Callable[[int], T],
    items: Iterable[int],
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


def _fill(
    results: Results,
    cells: Callable[[int, int], Cells],
    numbers: range,
    origin: int,
    options: Options,
    stop: StopFlag,
) -> int:
    """Compute the cells of these numbers into `results`, which begins with cell `origin`; how many were finished."""
    if stop[0]:
        return 0
    part = cells(numbers.start, numbers.stop)
    rows, done = _run_block(part, options, stop)
    known = np.s_[:] if done == len(numbers) else rows[layout.STATUS] != layout.NOT_RUN
    for name, values in to_si(rows, part, not options.early_stop).items():
        results[name][numbers.start - origin : numbers.stop - origin][known] = values[known]
    return done


@dataclass(frozen=True)
class Probe:
    """What a few cells, spread over all, took."""

    cells: int
    seconds_per_cell: float
    threads: int


def probe(cells: Callable[[int, int], Cells], size: int, options: Options, most: int = 8192) -> Probe:
    """Time about `most` cells, in short runs spread evenly over all, to know beforehand what all of them take."""
    length = 32
    starts = np.unique(np.linspace(0, max(size - length, 0), max(most // length, 1)).astype(int))
    parts = [cells(int(start), min(int(start) + length, size)) for start in starts]
    sample = {name: np.concatenate([part[name] for part in parts]) for name in parts[0]}
    count = sample["mass"].size
    warm_up(options.law)
    began = perf_counter()
    part = compute(lambda start, stop: {name: values[start:stop] for name, values in sample.items()}, count, options)
    if not part.complete:
        raise KeyboardInterrupt
    return Probe(count, (perf_counter() - began) / count, options.threads or processors())


def kernels_digest() -> str:
    """Names the kernels by their sources: equal digests compute equal bits (on one kind of machine)."""
    return jit.source_digest()


def processor() -> str:
    """The kind of processor the kernels are compiled for: another kind may round differently."""
    return str(llvm.get_host_cpu_name())


def columns(options: Options) -> dict[str, np.dtype[Any]]:
    """Names and types of what `compute` gives, in its order."""
    return {name: values.dtype for name, values in blank_results(0, options).items()}


def bytes_per_cell(options: Options) -> int:
    """Memory the results of one cell take."""
    return sum(values.nbytes for values in blank_results(1, options).values())


def blank_results(size: int, options: Options) -> Results:
    """Results of cells nobody has computed: zeros for flags and counts, NaN for the rest."""
    names = [v.name for v in VARIABLES.values() if v.when == "always" or not options.early_stop]
    whole = {"regime": np.int8, "status": np.int8, "steps": np.int32}
    return {name: np.zeros(size, whole[name]) if name in whole else np.full(size, np.nan) for name in names}


def _run_block(part: Cells, options: Options, stop: StopFlag) -> tuple[NDArray[np.float64], int]:
    """One block through the kernels: the rows, and how many cells were finished."""
    rows = block.new_results(part["mass"].size)
    control = np.array([options.rtol, options.max_steps, options.early_stop], np.float64)
    block.run_block(laws.LAWS[options.law], to_kernel(part, options.horizon), rows, control, block.NO_LOG, stop)
    unfinished = rows[layout.STATUS] == layout.NOT_RUN
    rows[:, unfinished] = block.new_results(1)  # nothing half-known leaves this place
    return rows, int((~unfinished).sum())


# --- one trajectory ---------------------------------------------------------------------------------------------------


def trajectory(cell: Cells, times: NDArray[np.float64], options: Options) -> Results:
    """The motion of one cell (arrays of length 1) at `times` (s, ascending from 0), by names of `TRACE_VARIABLES`.

    The stepping is that of `compute`, with a log of what happened. Raises NotReachedError if the integration does not
    reach the last time.
    """
    warm_up(options.law)
    horizon = max(float(times[-1]), np.finfo(float).tiny)
    column = to_kernel(cell, horizon)
    control = np.array([options.rtol, options.max_steps, 0.0])
    capacity = 1024
    while True:
        rows, log = block.new_results(1), np.zeros((capacity, layout.LOG_COLUMNS))
        block.run_block(laws.LAWS[options.law], column, rows, control, log, np.zeros(1, np.int64))
        if log[0, 0] < capacity:
            break
        capacity = int(log[0, 0]) + 1
    m, k = float(cell["mass"][0]), float(cell["stiffness"][0])
    if (status := int(rows[layout.STATUS, 0])) != layout.HORIZON_REACHED:
        reached = log[int(log[0, 0]), layout.LOG_TAU] * np.sqrt(m / k)
        name = STATUSES[status]
        raise NotReachedError(f"the motion is known to {reached:g} s of {horizon:g} s, {name}: {STATUS_MESSAGES[name]}")
    samples = np.empty((layout.SAMPLE_ROWS, times.size))
    trace.sample(laws.LAWS[options.law], log, np.ascontiguousarray(column[:, 0]), times * np.sqrt(k / m), samples)
    return _samples_to_si(samples, cell)


def _samples_to_si(samples: NDArray[np.float64], cell: Cells) -> Results:
    """The rows `trace.sample` filled, in SI."""
    m, k, load, belt = (float(cell[name][0]) for name in ("mass", "stiffness", "normal_load", "belt_speed"))
    force, relative = samples[layout.SAMPLE_XI] * load, samples[layout.SAMPLE_RELATIVE] * load / np.sqrt(k * m)
    return {
        "displacement": force / k,
        "velocity": belt - relative,
        "relative_speed": relative,
        "friction_coefficient": samples[layout.SAMPLE_FRICTION],
        "spring_force": force,
        "acceleration": samples[layout.SAMPLE_ACCELERATION] * load / m,
        "mode": samples[layout.SAMPLE_MODE],
    }
