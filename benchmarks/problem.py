"""What is computed: problems P1 (fixed horizon) and P2 (regime map), ours, and the error of an answer.

P1: m = N = 1, c = 0, the article's curve, k = logspace(-1, 2, 100) x v_belt = linspace(0.02, 0.6, 100), sticking at x
= 0, t = 0..100 without early stop. P2: the same ranges, n x n, early stop, plain or hysteretic (mu_stop = 1.1).
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache

import numpy as np

from stickslip import engine
from stickslip.vocabulary.cells import Cells as Listed
from stickslip.vocabulary.cells import as_cells

A1, A2, A3, A4 = 1.0, 0.1, 0.3, 0.1
MU_START = A1 + A3
V_MIN = A4 * np.log(A3 / (A2 * A4))
HORIZON = 100.0
CURVE = {"mass": 1.0, "normal_load": 1.0, "a1": A1, "a2": A2, "a3": A3, "a4": A4}
MU_STOP = 1.1


@dataclass(frozen=True)
class Cells:
    """The two parameters that vary, one number a cell."""

    k: np.ndarray
    belt: np.ndarray

    def __len__(self) -> int:
        return self.k.size

    def part(self, index) -> Cells:
        return Cells(np.ascontiguousarray(self.k[index]), np.ascontiguousarray(self.belt[index]))


@dataclass(frozen=True)
class Answer:
    """What a solver found, one number a cell: first re-stick (NaN: none before the end) and the state at the end.

    seconds : time the solver states for itself, where the caller cannot measure it (another process).
    """

    restick_time: np.ndarray
    restick_x: np.ndarray
    x_end: np.ndarray
    v_end: np.ndarray
    seconds: float | None = None


def grid(n: int) -> Cells:
    k, belt = np.meshgrid(np.logspace(-1, 2, n), np.linspace(0.02, 0.6, n), indexing="ij")
    return Cells(k.ravel(), belt.ravel())


def cells_of(cells: Cells, **shared) -> Listed:
    """Cells in the form of the engine. shared : parameters that all of them have."""
    return Listed.of(as_cells(CURVE | shared | {"stiffness": cells.k, "belt_speed": cells.belt}))


def compute(cells: Cells, **options) -> dict[str, np.ndarray]:
    """Ours, with no dataset around it. options : those of `engine.Options`, and parameters that all cells share."""
    shared = {name: options.pop(name) for name in ("mu_stop", "damping", "delta", "a4") if name in options}
    return engine.compute(cells_of(cells, **shared), engine.Options(**options)).results


def ours(cells: Cells, horizon: float, rtol: float, threads: int = 1) -> Answer:
    found = compute(cells, rtol=rtol, horizon=horizon, early_stop=False, threads=threads)
    return Answer(
        found["restick_time"], found["restick_displacement"], found["displacement_end"], found["velocity_end"]
    )


@cache
def p1() -> tuple[Cells, Answer, dict[str, np.ndarray]]:
    """The cells of P1 in random order (fixed seed), our answer at rtol 1e-10 and how much work each cell is at 1e-6.

    The order is such that the first n cells are a stratified sample for any n: see `spread`.
    """
    cells = grid(100)
    work = compute(cells, rtol=1e-6, horizon=HORIZON, early_stop=False)
    order = spread(work["steps"])
    cells = cells.part(order)
    work = {name: work[name][order] for name in ("steps", "sticks")}
    return cells, ours(cells, HORIZON, 1e-10, engine.processors()), work


def spread(work: np.ndarray) -> np.ndarray:
    """An order of the cells whose every leading part has about the mean work of all.

    Cells differ by a factor of ten in work, and a slow peer sees twenty of them: a plain random sample would be off by
    tens of per cent. So cells are ranked by work (ties at random) and taken at the golden-ratio sequence of ranks.
    """
    n = work.size
    by_work = np.lexsort((np.random.default_rng(1).random(n), work))
    golden = (0.5 + np.arange(8 * n) * 0.6180339887498949) % 1.0
    ranks = np.floor(golden * n).astype(np.int64)
    _, first = np.unique(ranks, return_index=True)
    taken = ranks[np.sort(first)]
    return by_work[np.concatenate([taken, np.setdiff1d(np.arange(n), taken)])]


@dataclass(frozen=True)
class Errors:
    """Relative errors of the first re-stick, against our rtol 1e-10 answer; x in units of N/k.

    missed : cells where only one of the two found a re-stick at all. end : of the last x, in the same units.
    """

    time: float
    time_p99: float
    x: float
    end: float
    missed: int
    cells: int


def errors(found: Answer, exact: Answer, cells: Cells) -> Errors:
    n = found.restick_time.size
    t0, x0, k = exact.restick_time[:n], exact.restick_x[:n], cells.k[:n]
    both = np.isfinite(t0) & np.isfinite(found.restick_time)
    time = np.abs(found.restick_time - t0)[both] / t0[both]
    x = (np.abs(found.restick_x - x0) * k)[both] / MU_START
    end = np.abs(found.x_end - exact.x_end[:n]) * k / MU_START
    missed = int((np.isfinite(t0) != np.isfinite(found.restick_time)).sum())
    return Errors(
        float(np.median(time)),
        float(np.quantile(time, 0.99)),
        float(np.median(x)),
        float(np.median(end[np.isfinite(end)])) if np.isfinite(end).any() else np.nan,
        missed,
        n,
    )
