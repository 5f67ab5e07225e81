"""P4, borders: the belt speed at which stick-slip ends, on 1,000 lines to 1e-9, beside a SciPy user who bisects.

Ours looks at 64 places of each line and narrows all brackets together, by `restick_margin` and once more by bisection
alone. SciPy halves the same range on the regime of `peers/scipy_events.cycle`, line after line, at the same rtol.
"""

from __future__ import annotations

from functools import partial
from statistics import median
from unittest.mock import patch

import numpy as np

import stickslip
from measure import Job, interleave
from peers.scipy_events import cycle
from problem import CURVE
from stickslip.studies import search

BETWEEN, TOLERANCE = (0.01, 5.0), 1e-9
RTOL = TOLERANCE / 100


def stiffnesses(count: int) -> np.ndarray:
    return np.random.default_rng(4).permutation(np.geomspace(0.1, 100.0, count))


def by_us(stiffness: np.ndarray) -> np.ndarray:
    lines = CURVE | {"stiffness": stiffness}
    return stickslip.border(lines, "belt_speed", BETWEEN, TOLERANCE, rtol=RTOL, threads=1)["border"].values[:, 0]


def by_our_bisection(stiffness: np.ndarray) -> np.ndarray:
    with patch.object(search, "_follow_guide", lambda *_: None):
        return by_us(stiffness)


def by_scipy(stiffness: float) -> float:
    low, high = BETWEEN
    while high - low > TOLERANCE * high:
        middle = 0.5 * (low + high)
        low, high = (middle, high) if cycle(stiffness, middle, RTOL) == "stick_slip" else (low, middle)
    return 0.5 * (low + high)


def measure(count: int = 1000, scipy_count: int = 3) -> dict:
    """Borders per CPU second of one thread, and the largest relative difference from SciPy's."""
    stiffness = stiffnesses(count)
    by_us(stiffness)
    jobs = [Job(partial(action, stiffness), 3) for action in (by_us, by_our_bisection)]
    jobs += [Job(partial(by_scipy, float(k)), 1) for k in stiffness[:scipy_count]]
    interleave(jobs)
    ours, bisection, *theirs = jobs
    scipy_seconds = sum(median(job.timings.cpu) for job in theirs) / scipy_count
    seconds = median(ours.timings.cpu)
    return {
        "lines": count,
        "scipy_lines": scipy_count,
        "borders_per_second": count / seconds,
        "bisection_per_second": count / median(bisection.timings.cpu),
        "scipy_per_second": 1 / scipy_seconds,
        "ratio": scipy_seconds * count / seconds,
        "worst_difference": max(abs(job.result / one - 1) for job, one in zip(theirs, ours.result, strict=False)),
    }


if __name__ == "__main__":
    print(measure())
