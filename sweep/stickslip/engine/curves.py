"""The friction curve itself, as the kernels have it."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from stickslip.engine.compiled import kernels
from stickslip.engine.options import Options
from stickslip.engine.scales import to_kernel
from stickslip.vocabulary.cells import Parameters
from stickslip_kernels import layout


def friction_at_belt_speed(cells: Parameters, options: Options) -> NDArray[np.float64]:
    """Friction coefficient of each cell where the mass is at rest, and the slip speed that of the belt."""
    rows = to_kernel(cells, np.inf)
    return np.asarray(kernels(options.law).friction(rows, np.abs(rows[layout.BELT])))
