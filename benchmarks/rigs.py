"""P3, test rigs: reciprocating strokes, ours through the lanes beside a SciPy user's code on the same rigs.

SciPy integrates phase by phase with events and dense output (`tests/helpers/scipy_rig.py`, here at rtol 1e-6 as a user
would); both give the motion at the same times, 8,000 a second, and the times of all events.
"""

from __future__ import annotations

import sys
from functools import partial
from pathlib import Path
from statistics import median

import numpy as np

from measure import Job, Timings, interleave, timed
from stickslip import engine
from stickslip.vocabulary.cells import as_cells

sys.path.append(str(Path(__file__).parents[1] / "tests"))
from helpers.scipy_rig import Rig, trapezoidal  # noqa: E402

RATE = 8000.0  # samples per second
RTOL = 1e-6
LOOSE = {"method": "DOP853", "rtol": RTOL, "atol": 1e-9}


def rigs(count: int) -> tuple[dict, list]:
    """Parameters in SI and drives: two strokes of 5 mm at 1 to 30 mm/s, on different springs and curves."""
    random = np.random.default_rng(7)
    cells = as_cells(
        {
            "mass": 10 ** random.uniform(-1.3, -0.7, count),
            "stiffness": 10 ** random.uniform(3.3, 4.0, count),
            "damping": random.uniform(0.0, 2.0, count),
            "normal_load": random.uniform(5.0, 20.0, count),
            "belt_speed": 10 ** random.uniform(-3.0, -1.5, count),
            "a1": random.uniform(0.2, 0.4, count),
            "a2": random.uniform(0.0, 0.5, count),
            "a3": random.uniform(0.05, 0.3, count),
            "a4": 10 ** random.uniform(-2.0, -1.3, count),
        }
    )
    return cells, [trapezoidal(5e-3, speed, 0.05, dwell=0.1) for speed in cells["belt_speed"]]


def by_scipy(cells: dict, drives: list, i: int) -> Rig:
    """One rig, with its samples."""
    one = {name: float(values[i]) for name, values in cells.items()}
    curve = tuple(one[name] for name in ("a1", "a2", "a3", "a4"))
    rig = Rig(drives[i], one["mass"], one["stiffness"], one["damping"], one["normal_load"], curve, tolerance=LOOSE)
    rig.sample(RATE)
    return rig


def by_us(cells: dict, drives: list) -> engine.RigRuns:
    """All rigs, with their samples."""
    tables = [np.array(drive) for drive in drives]
    sampling = engine.Sampling(RATE, np.zeros(len(drives)))
    return engine.compute_rigs(cells, tables, sampling, engine.Options(rtol=RTOL), engine.stop_flag())


def measure(count: int = 512, scipy_count: int = 8) -> dict:
    """CPU seconds per rig on one thread, ours and SciPy's, and how far their solutions differ."""
    cells, drives = rigs(count)
    by_us(cells, drives)
    jobs = [Job(partial(by_us, cells, drives), 3)]
    jobs += [Job(partial(by_scipy, cells, drives, i), 1) for i in range(scipy_count)]
    interleave(jobs)
    ours, seconds = jobs[0], sum(median(job.timings.cpu) for job in jobs[1:]) / scipy_count
    part = Timings()  # ours on the same rigs as SciPy, repeatedly, since the others are longer or shorter
    copies = count // scipy_count
    same = {name: np.tile(values[:scipy_count], copies) for name, values in cells.items()}
    for _ in range(3):
        timed(partial(by_us, same, drives[:scipy_count] * copies), part)
    own = median(part.cpu) / (scipy_count * copies)
    exact = ours.result.results
    found = [job.result for job in jobs[1:]]
    first = [(exact["breakaway_time"][i], rig.breakaways[0]) for i, rig in enumerate(found) if rig.breakaways]
    return {
        "rigs": count,
        "scipy_rigs": scipy_count,
        "samples_per_rig": float(np.mean([len(signals["mode"]) for signals in ours.result.signals])),
        "seconds_per_rig": own,
        "scipy_seconds_per_rig": seconds,
        "ratio": seconds / own,
        "same_sticks": sum(int(exact["slips_exact"][i]) == len(rig.breakaways) for i, rig in enumerate(found)),
        "worst_breakaway_error": max((abs(a / b - 1) for a, b in first), default=float("nan")),
        "worst_energy_error": float(np.abs(exact["energy_error"]).max()),
    }


if __name__ == "__main__":
    print(measure())
