"""A few cells of a map computed beforehand: how long all would take, and how many would reach the step limit."""

from __future__ import annotations

from dataclasses import dataclass, replace
from time import perf_counter
from typing import TYPE_CHECKING

import numpy as np

from stickslip.engine import Options, compute, processors, warm_up
from stickslip.vocabulary.cells import Cells, Parameters
from stickslip.vocabulary.flags import STATUSES

if TYPE_CHECKING:
    from stickslip.studies.uncertainty import SampleStudy

_TOGETHER = 32  # neighbouring cells, as many as there are lanes


@dataclass(frozen=True)
class Probe:
    """What a few cells, spread over a map, took; `at_step_limit` of them ran out of steps."""

    cells: int
    seconds_per_cell: float
    threads: int
    at_step_limit: int


def probe(cells: Cells | SampleStudy, options: Options, most: int = 8192) -> Probe:
    """Compute about `most` cells, in short runs spread evenly. Raises KeyboardInterrupt on Ctrl-C."""
    sample = _spread_out(cells, most)
    count = sample["mass"].size
    options = replace(options, variables=None)  # whatever is kept of the map: `status` counts
    warm_up(options.law)
    began = perf_counter()
    part = compute(Cells.of(sample), options)
    seconds = perf_counter() - began
    if not part.complete:
        raise KeyboardInterrupt
    limited = int(np.count_nonzero(part.results["status"] == STATUSES.index("step_limit")))
    return Probe(count, seconds / count, options.threads or processors(), limited)


def _spread_out(cells: Cells | SampleStudy, most: int) -> Parameters:
    """Parameters of about `most` cells from all over."""
    runs = max(min(most, cells.size) // _TOGETHER, 1)
    starts = np.linspace(0, max(cells.size - _TOGETHER, 0), runs).astype(int)
    parts = [cells[int(start) : min(int(start) + _TOGETHER, cells.size)] for start in starts]
    return {name: np.concatenate([part[name] for part in parts]) for name in parts[0]}
