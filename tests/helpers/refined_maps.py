"""A refined map held against its full grid, of which nothing but the regimes is kept."""

from __future__ import annotations

from dataclasses import dataclass
from time import perf_counter

import numpy as np

from stickslip import engine
from stickslip.config.grid import build_grid, options_of
from stickslip.config.model import Config
from stickslip.config.reader import make_config
from stickslip.runs.threads import compute_study
from stickslip.runs.work import study_of
from stickslip.studies.refine import RefinedMap
from stickslip.studies.study import joined

_RANGE = 2**16  # cells computed or painted together
CURVES = {"plain": None, "hysteretic": 1.1}  # mu_stop


def map_config(n: int, mu_stop: float | None, **refine: object) -> Config:
    """The article's map: stiffness by belt speed, up to speeds where stick-slip has ended."""
    friction = {"a1": 1, "a2": 0.1, "a3": 0.3, "a4": 0.1} | ({} if mu_stop is None else {"mu_stop": mu_stop})
    axes = {
        "stiffness": {"start": 0.1, "stop": 100, "num": n, "spacing": "log"},
        "belt_speed": {"start": 0.02, "stop": 1.2, "num": n},
    }
    return make_config(
        {"system": {"mass": 1, "normal_load": 1}, "friction": friction, "axes": axes, "refine": dict(refine)}
    )


@dataclass(frozen=True)
class Compared:
    """A refined map beside the full grid: cells, those computed for it, those wrong, its audit, and seconds of both."""

    cells: int
    computed: int
    wrong: int
    bound: float
    tried: int
    seconds: float
    seconds_full: float


def compared(config: Config) -> Compared:
    """Compute a refined map and its full grid on all threads."""
    engine.warm_up(config.friction.law)
    study = study_of(config)
    assert isinstance(study, RefinedMap)
    began = perf_counter()
    parts = compute_study(study)
    seconds = perf_counter() - began
    began = perf_counter()
    truth = all_regimes(config)
    seconds_full = perf_counter() - began
    whole, found = joined(parts), study.findings(parts)
    painter = study.painter(lambda number: (whole, number))
    wrong = sum(int((painter.cells(part)["regime"] != truth[part.start : part.stop]).sum()) for part in _ranges(truth))
    return Compared(
        truth.size, found["refine_cells_computed"], wrong, found["audit_bound"], found["audit_points"],
        seconds, seconds_full,
    )  # fmt: skip


def all_regimes(config: Config) -> np.ndarray:
    """The regime of every cell of the grid."""
    grid, options, stop = build_grid(config), options_of(config), engine.stop_flag()
    regimes = np.zeros(grid.size, np.int8)

    def compute(part: range) -> None:
        found = engine.compute_range(grid, part.start, part.stop, options, stop)
        regimes[part.start : part.stop] = found["regime"]

    engine.spread(compute, _ranges(regimes), None, stop, lambda done: None)
    return regimes


def _ranges(cells: np.ndarray) -> list[range]:
    return [range(start, min(start + _RANGE, cells.size)) for start in range(0, cells.size, _RANGE)]
