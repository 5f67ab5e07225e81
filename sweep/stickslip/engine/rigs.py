"""Test rigs: blocks of them through the kernels, with samples of their motion."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from stickslip.engine.dispatch import run_signals
from stickslip.engine.options import Options, Results, StopFlag
from stickslip.engine.scales import to_kernel
from stickslip.vocabulary.cells import Parameters
from stickslip.vocabulary.scales import Scales
from stickslip_kernels import layout
from stickslip_kernels.allocate import new_signals

Floats = NDArray[np.float64]


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
