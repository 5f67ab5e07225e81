"""What lies between the branches of a ramp: the unstable cycle, and how stable steady sliding is."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np

from stickslip.basins.box import Box
from stickslip.basins.exact import exact_results
from stickslip.basins.ramp import Ramp
from stickslip.basins.starts import Work, unloaded
from stickslip.engine import Options, Results, StopFlag
from stickslip.vocabulary.cells import as_cells
from stickslip.vocabulary.results import BETWEEN_VARIABLES

_TOGETHER = 256  # cells that are held with the samples of their cycles
_ANY = Box((0.0, 1.0), (-1.0, 1.0))  # of starting states, whose share nobody asks for


def between_branches(
    ramp: Ramp, options: Options, stop: StopFlag, moved: Callable[[int], None] | None = None
) -> Results:
    """By names of `BETWEEN_VARIABLES` (`vocabulary.results`), arrays (lines, values); NaN where there is no unstable
    cycle, or it is not known exactly (`plain.py` says of which cells it is). Raises StoppedError once `stop` is raised.
    moved : called with cells finished.
    """
    lines, values = ramp.lines, ramp.values
    others = lines.others(0, lines.size)
    cells = as_cells(
        {name: np.repeat(one, values.size) for name, one in others.items()} | {lines.along: np.tile(values, lines.size)}
    )
    work = Work(replace(options, early_stop=True), stop)
    parts = []
    for first in range(0, cells["mass"].size, _TOGETHER):
        some = {name: one[first : first + _TOGETHER] for name, one in cells.items()}
        start = work.results(some, *unloaded(some))
        _, known = exact_results(some, start["regime"], _ANY, work)
        parts.append(known | {"damping_ratio": start["damping_ratio"]})
        if moved:
            moved(some["mass"].size)
    shape = lines.size, values.size
    return {name: np.concatenate([part[name] for part in parts]).reshape(shape) for name in BETWEEN_VARIABLES}
