"""Cells through the kernels: from SI to kernel units, to the kernels that suit them, and back.

Units by the scales of a cell (`models/model.py`) and by its model. Some cells of a law may have kernels of their
own, which take a tenth of the time. Which kernels compute a cell depends on that cell alone, so its numbers do not
depend on its neighbours. `friction_at_belt_speed` is the friction curve itself, as the kernels have it.

Motion over time: test rigs, and cells as rigs whose drive is a single segment.
"""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from stickslip.engine.compiling import kernels
from stickslip.engine.options import Options, Results, StopFlag, columns, stop_flag
from stickslip.errors import NotReachedError
from stickslip.vocabulary.cells import Cells, Parameters
from stickslip.vocabulary.models import OwnKernels, model_of
from stickslip.vocabulary.models.model import Scales
from stickslip.vocabulary.quantities import STATUS_MESSAGES, STATUSES
from stickslip_kernels import layout
from stickslip_kernels.layout import NO_STOPS, new_signals

Floats = NDArray[np.float64]
_BEYOND = 0.01  # of a step: how far past its last sample a motion is integrated, so that rounding does not lose it
_ROWS = {name: row for name, row in vars(layout).items() if isinstance(row, int)}


def to_kernel(cells: Parameters, horizon: float, options: Options) -> Floats:
    """Cells in SI to the rows of `layout.py`, shape (CELL_ROWS, n); horizon in s."""
    by = Scales(cells)
    rows = np.zeros((layout.CELL_ROWS, by.mass.size))
    rows[layout.GAMMA] = cells["damping"] / by.impedance
    rows[layout.BELT] = cells["belt_speed"] / by.speed
    rows[layout.XI_START] = cells["displacement"] * by.stiffness / by.load
    rows[layout.ETA_START] = cells["velocity"] / by.speed
    rows[layout.CONTACT_START] = cells["contact_time"] * by.rate
    rows[layout.HORIZON] = horizon * by.rate
    for name, values in model_of(options.law).to_kernel(cells, by).items():
        rows[_ROWS[name]] = values
    return rows


_Conversion = Callable[[Floats, Scales], Floats]
_CONVERSIONS: dict[str, _Conversion] = {  # what all cells have; the models have the rest
    "regime": lambda rows, by: rows[layout.REGIME],
    "status": lambda rows, by: rows[layout.STATUS],
    "breakaway_time": lambda rows, by: rows[layout.BREAKAWAY_TIME] * by.time,
    "restick_time": lambda rows, by: rows[layout.RESTICK_TIME] * by.time,
    "restick_displacement": lambda rows, by: rows[layout.RESTICK_XI] * by.length,
    "restick_margin": lambda rows, by: rows[layout.RESTICK_MARGIN] * by.speed,
    "period": lambda rows, by: rows[layout.PERIOD] * by.time,
    "frequency": lambda rows, by: 1.0 / (rows[layout.PERIOD] * by.time),
    "stick_fraction": lambda rows, by: rows[layout.CYCLE_STICK_TIME] / rows[layout.PERIOD],
    "spring_force_max": lambda rows, by: rows[layout.XI_MAX] * by.load,
    "spring_force_min": lambda rows, by: rows[layout.XI_MIN] * by.load,
    "slip_speed_max": lambda rows, by: rows[layout.SPEED_MAX] * by.speed,
    "acceleration_max": lambda rows, by: rows[layout.ACCELERATION_MAX] * by.load / by.mass,
    "energy_per_cycle": lambda rows, by: rows[layout.CYCLE_HEAT] * by.load * by.length,
    "equilibrium_crossings": lambda rows, by: rows[layout.CROSSINGS],
    "settling_time": lambda rows, by: rows[layout.SETTLING_TIME] * by.time,
    "settled_displacement": lambda rows, by: rows[layout.XI_SETTLED] * by.length,
    "displacement_amplitude": lambda rows, by: (
        0.5 * (rows[layout.CYCLE_XI_MAX] - rows[layout.CYCLE_XI_MIN]) * by.length
    ),
    "velocity_amplitude": lambda rows, by: 0.5 * rows[layout.CYCLE_SPEED_RANGE] * by.speed,
    "cycle_force_max": lambda rows, by: rows[layout.CYCLE_XI_MAX] * by.load,
    "cycle_force_min": lambda rows, by: rows[layout.CYCLE_XI_MIN] * by.load,
    "damping_ratio": lambda rows, by: rows[layout.DAMPING_RATIO],
    "steps": lambda rows, by: rows[layout.STEPS],
    "sticks": lambda rows, by: rows[layout.STICKS],
    "stick_time": lambda rows, by: rows[layout.STICK_TIME] * by.time,
    "displacement_end": lambda rows, by: rows[layout.XI_END] * by.length,
    "velocity_end": lambda rows, by: rows[layout.ETA_END] * by.speed,
}


def to_si(rows: Floats, cells: Parameters, options: Options) -> Results:
    """The rows `run_block` filled to the variables people know: those that the options keep, in their order."""
    by, own = Scales(cells), model_of(options.law).conversions(options.law)
    return {
        name: own[name](lambda row: rows[_ROWS[row]], by) if name in own else _CONVERSIONS[name](rows, by)
        for name in columns(options)
    }


def by_theory(name: str, cells: Parameters, options: Options) -> Floats:
    """A result of the model that linear theory knows: no cell is computed."""

    def no_row(row: str) -> Floats:
        raise KeyError(f"{name} needs {row} of cells that are computed")

    return np.asarray(model_of(options.law).conversions(options.law)[name](no_row, Scales(cells)))


def signals_to_si(signals: Floats, cells: Parameters, columns: Floats) -> Results:
    """Signals on steady belts, in SI, by names of `TRACE_VARIABLES`.

    cells, columns : of each sample, in SI and in kernel units; those of a single cell serve all samples.
    """
    by = Scales(cells)
    xi, eta, friction, mode = signals
    force, relative = xi * by.load, (columns[layout.BELT] - eta) * by.load / by.impedance
    accelerating = (mode != layout.STICK) & (mode != layout.HOLD)
    return {
        "displacement": force / by.stiffness,
        "velocity": cells["belt_speed"] - relative,
        "relative_speed": relative,
        "friction_coefficient": friction,
        "spring_force": force,
        "acceleration": np.where(accelerating, friction - xi - columns[layout.GAMMA] * eta, 0.0) * by.load / by.mass,
        "mode": mode,
    }


# --- kernels ----------------------------------------------------------------------------------------------------------


def kernels_for(cells: Cells, options: Options) -> tuple[str, ...]:
    """Names of the kernels that the cells of a grid need, each once."""
    own = _own(options)
    if own is None:
        return (options.law,)
    given = {name: cells.along[name][1] if name in cells.along else cells.fixed[name] for name in own.parameters}
    values = [set(np.unique(np.nan_to_num(column)).tolist()) for column in given.values()]
    names = [name for value, name in own.by_value.items() if all(value in column for column in values)]
    others = any(column - set(own.by_value) for column in values)
    return (*names, own.otherwise or options.law) if others else tuple(names)


def has_own_kernels(options: Options) -> bool:
    """Return whether the kernels depend on the cells, and not on their law alone."""
    return _own(options) is not None


def _own(options: Options) -> OwnKernels | None:
    return model_of(options.law).own_kernels.get(options.law)


def run_regimes(options: Options, rtol: float, cells: Floats, stop: StopFlag, results: Floats) -> None:
    """`Kernels.run_regimes`, each cell by the kernels that suit it; they are loaded, or compiled, when first needed."""
    max_steps, until = options.max_steps, options.until
    for name, chosen in _kernels(options, cells):
        run = kernels(name).run_regimes
        if chosen is None:
            run(cells, rtol, max_steps, stop, results, until)
            continue
        rows = results[:, : chosen.size]  # there may be more room
        own = np.ascontiguousarray(rows[:, chosen])
        run(np.ascontiguousarray(cells[:, chosen]), rtol, max_steps, stop, own, until)
        rows[:, chosen] = own


def run_signals(
    options: Options, cells: Floats, stop: StopFlag, drive: tuple[Floats, Floats], results: Floats, runs: Floats,
    signals: Floats, stops: Floats = NO_STOPS,
) -> None:  # fmt: skip
    """The same of `Kernels.run_signals`."""
    segments, spans = drive
    rtol, max_steps = options.rtol, options.max_steps
    for name, chosen in _kernels(options, cells):
        run = kernels(name, signals=True).run_signals
        if chosen is None:
            run(cells, rtol, max_steps, stop, drive, results, runs, signals, stops)
            continue
        own, part = np.ascontiguousarray(results[:, chosen]), np.ascontiguousarray(cells[:, chosen])
        run(part, rtol, max_steps, stop, (segments, spans[chosen]), own, runs[chosen], signals, stops)
        results[:, chosen] = own


def _kernels(options: Options, cells: Floats) -> Iterator[tuple[str, NDArray[np.bool_] | None]]:
    """Names of kernels, and which cells are theirs; None for all."""
    own = _own(options)
    if own is None:
        yield options.law, None
        return
    values = cells[[getattr(layout, row) for row in own.rows]]
    left = np.ones(cells.shape[1], bool)
    for value, name in own.by_value.items():
        chosen = (values == value).all(axis=0)
        left &= ~chosen
        if chosen.any():
            yield name, None if chosen.all() else chosen
    if left.any() or not left.size:
        yield own.otherwise or options.law, None if left.all() else left


def friction_at_belt_speed(cells: Parameters, options: Options) -> Floats:
    """Friction coefficient of each cell where the mass is at rest, and the slip speed that of the belt."""
    rows = to_kernel(cells, np.inf, options)
    return np.asarray(kernels(options.law).friction(rows, np.abs(rows[layout.BELT])))


# --- motion over time -------------------------------------------------------------------------------------------------


def trajectory(cell: Parameters, times: Floats, options: Options) -> Results:
    """The motion of one cell (arrays of length 1) at `times` (s, evenly spaced, from 0), by names of `TRACE_VARIABLES`.

    The stepping is that of `compute`. Raises NotReachedError if the integration does not reach the last time.
    """
    horizon, rate = max(float(times[-1]), np.finfo(float).tiny), Scales(cell).rate
    columns, step = to_kernel(cell, horizon, options), (times[1] if times.size > 1 else horizon) * rate
    signals, status = _signals(columns, horizon * rate, step, np.array([times.size]), options)
    if status[0] != layout.HORIZON_REACHED:
        reached = np.max(times, where=np.isfinite(signals[layout.SIGNAL_XI]), initial=0.0)
        name = STATUSES[int(status[0])]
        raise NotReachedError(f"the motion is known to {reached:g} s of {horizon:g} s, {name}: {STATUS_MESSAGES[name]}")
    return signals_to_si(signals, cell, columns)


def sampled(
    cells: Parameters, steps: Floats, counts: NDArray[np.int64], options: Options, first: Floats | float = 0.0
) -> tuple[list[Floats], Floats, NDArray[np.int8]]:
    """Displacements (m) of many cells, each at times of its own: one array per cell.

    steps, counts : time between samples (s) and number of samples, at least 2, by cell. first : time of the first (s).

    Beside them the velocities at the first and the last sample (m/s), shape (n, 2), and the status: other than
    horizon_reached where the integration ended early, from where on there is NaN. In this thread.
    """
    by, columns, ends = Scales(cells), to_kernel(cells, 1.0, options), np.cumsum(counts)
    columns[layout.HORIZON] = (first + steps * (counts - 1 + _BEYOND)) * by.rate
    signals, status = _signals(columns, columns[layout.HORIZON], steps * by.rate, counts, options, first * by.rate)
    velocities = signals[layout.SIGNAL_ETA][np.column_stack([ends - counts, ends - 1])]
    displacements = np.split(signals[layout.SIGNAL_XI], ends[:-1])
    for displacement, length in zip(displacements, by.length, strict=True):
        displacement *= length
    return displacements, velocities * (by.length * by.rate)[:, None], status


def flows(cells: Parameters, durations: Floats, samples: int, options: Options) -> Results:
    """The motions of many cells, each over its own duration (s), by names of `TRACE_VARIABLES`, shape (n, samples).

    The samples of a cell are evenly spaced and include both ends. The cells may be any that the kernels can integrate,
    with negative damping and friction as well. NaN from where the integration of a cell ended early. In this thread.
    """
    n, columns = durations.size, to_kernel(cells, 1.0, options)
    columns[layout.HORIZON] = durations * Scales(cells).rate
    step = columns[layout.HORIZON] / max(samples - 1, 1)
    signals, _ = _signals(columns, columns[layout.HORIZON], step, np.full(n, samples), options)
    each = {name: np.repeat(values, samples) for name, values in cells.items()}
    motion = signals_to_si(signals, each, np.repeat(columns, samples, axis=1))
    return {name: values.reshape(n, samples) for name, values in motion.items()}


def _signals(
    columns: Floats, ends: Floats, steps: Floats, counts: NDArray[np.int64], options: Options,
    first: Floats | float = 0.0,
) -> tuple[Floats, NDArray[np.int8]]:  # fmt: skip
    """Signals of cells on steady belts, one cell after the other, and the status of each.

    columns : of cells, in kernel units, as are `ends` of the drives, the `steps` between `counts` samples, and the time
    of the `first`.
    """
    n, last = counts.size, np.cumsum(counts)
    numbers, rows = np.arange(n, dtype=np.float64), new_signals(n)
    belts = np.column_stack([ends, columns[layout.BELT], np.zeros(n)]), np.column_stack([numbers, numbers + 1.0])
    signals = np.full((layout.SIGNAL_ROWS, int(last[-1])), np.nan)
    runs = np.column_stack([last - counts, last, first + np.zeros(n), steps]).astype(np.float64)
    run_signals(options, columns, stop_flag(), belts, rows, runs, signals)
    return signals, rows[layout.RIG_STATUS].astype(np.int8)


# --- rigs -------------------------------------------------------------------------------------------------------------


@dataclass(frozen=True)
class Sampling:
    """When samples are taken: at `rate` (1/s), from `start` (s, one per rig) to the end of the drive."""

    rate: float
    start: Floats


@dataclass(frozen=True)
class RigRuns:
    """Results of the kernels for some rigs, in SI.

    results : by names of `rig.quantities.EXACT`, one number per rig; NaN but for status and steps where it did not get
        to the end.
    signals : by rig, arrays over its samples by name: displacement, velocity, friction_force, mode (`MODES`).
    """

    results: Results
    signals: list[Results]


def compute_rigs(
    cells: Parameters, drives: Sequence[Floats], sampling: Sampling, options: Options, stop: StopFlag
) -> RigRuns:
    """Integrate some rigs to the end of their drives, in this thread alone.

    cells : as for maps; belt speed and starting velocity are not used. drives : by rig, segments of constant
    acceleration, shape (m, 3): duration (s), speed at the start (m/s), acceleration (m/s2); the speed does not jump
    between them. Once `stop` is raised, what is left has the status "not_run".
    """
    by = Scales(cells)
    counts = [_samples(drive, sampling.rate, start) for drive, start in zip(drives, sampling.start, strict=True)]
    belts, runs = _tables(drives, counts, by, sampling)
    rows = new_signals(by.mass.size)
    signals = np.full((layout.SIGNAL_ROWS, sum(counts)), np.nan)
    run_signals(options, to_kernel(cells, np.inf, options), stop, belts, rows, runs, signals)
    parts = np.split(signals, np.cumsum(counts)[:-1], axis=1)
    results = _results_to_si(rows, by, cells["displacement"])
    return RigRuns(results, [_signals_to_si(part, by, i) for i, part in enumerate(parts)])


def _samples(drive: Floats, rate: float, start: float) -> int:
    """Count the samples between `start` and the end of a drive; none at its very end, which rounding might miss."""
    end = float(drive[:, 0].sum())
    rounding = 1e-6 + 4.0 * np.finfo(float).eps * len(drive) * end * rate  # of a step
    return max(0, int((end - start) * rate - rounding) + 1)


def _tables(
    drives: Sequence[Floats], counts: Sequence[int], by: Scales, sampling: Sampling
) -> tuple[tuple[Floats, Floats], Floats]:
    """The drives in kernel units, one after the other, and where each rig puts its samples."""
    runs = np.empty((len(drives), layout.RUN_COLUMNS))
    ends, filled = np.cumsum([len(drive) for drive in drives]), np.cumsum(counts)
    runs[:, layout.FIRST_SAMPLE], runs[:, layout.LAST_SAMPLE] = np.r_[0, filled[:-1]], filled
    runs[:, layout.SAMPLE_START], runs[:, layout.SAMPLE_STEP] = sampling.start * by.rate, by.rate / sampling.rate
    lengths = [len(drive) for drive in drives]
    segments, each, unit = np.concatenate(drives), np.repeat(by.rate, lengths), np.repeat(by.speed, lengths)
    table = np.empty((len(segments), layout.SEGMENT_COLUMNS))
    table[:, layout.SEGMENT_TIME] = segments[:, 0] * each
    table[:, layout.SEGMENT_BELT] = segments[:, 1] / unit
    table[:, layout.SEGMENT_ALPHA] = segments[:, 2] / (unit * each)
    return (table, np.column_stack([np.r_[0, ends[:-1]], ends]).astype(np.float64)), runs


def _results_to_si(rows: Floats, by: Scales, start: Floats) -> Results:
    """start : displacement at the start, m."""
    work, heat, damper = rows[layout.RIG_DRIVE_WORK], rows[layout.RIG_FRICTION_HEAT], rows[layout.RIG_DAMPER_HEAT]
    stored = 0.5 * (rows[layout.RIG_XI_END] ** 2 + rows[layout.RIG_ETA_END] ** 2)
    stored -= 0.5 * (start / by.length) ** 2
    results = {
        "sticks_exact": rows[layout.RIG_STICKS],
        "slips_exact": rows[layout.RIG_SLIPS],
        "stick_time": rows[layout.RIG_STICK_TIME] * by.time,
        "breakaway_time": rows[layout.RIG_BREAKAWAY_TIME] * by.time,
        "breakaway_force": rows[layout.RIG_BREAKAWAY_LOAD] * by.load,
        "acceleration_max_exact": rows[layout.RIG_ACCELERATION_MAX] * by.load / by.mass,
        "drive_work": work * by.load * by.length,
        "friction_heat": heat * by.load * by.length,
        "damper_heat": damper * by.load * by.length,
        "energy_error": (work - heat - damper - stored) / np.where(work == 0.0, np.nan, work),
    }
    status = rows[layout.RIG_STATUS]
    results = {name: np.where(status == layout.HORIZON_REACHED, values, np.nan) for name, values in results.items()}
    return {"status": status.astype(np.int8), "steps": rows[layout.RIG_STEPS], **results}


def _signals_to_si(rows: Floats, by: Scales, i: int) -> Results:
    return {
        "displacement": rows[layout.SIGNAL_XI] * by.length[i],
        "velocity": rows[layout.SIGNAL_ETA] * by.speed[i],
        "friction_force": rows[layout.SIGNAL_FRICTION] * by.load[i],
        "mode": rows[layout.SIGNAL_MODE],
    }
