"""Cells whose answer hangs on less than the error of the integration: integrated again, more tightly.

Such cells are few, since they lie beside a border of regimes, or have next to no friction at speed. Which they are
depends on the cell alone, so its numbers do not depend on its neighbours.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from stickslip.engine.dispatch import run_regimes
from stickslip.engine.options import Options, StopFlag
from stickslip_kernels import layout
from stickslip_kernels.allocate import new_regimes

Floats = NDArray[np.float64]

_ERRORS = 2.0  # tolerances: verdicts this close to a border may be wrong (those that were lay within 0.2 of them)
_WASTED = 10.0  # energy that a cycle exchanges over its friction work, from where on errors of the work show
_STEP, _TIGHTEST = 1e-3, 1e-12  # of a tolerance to the next; what the kernels were tested to


def integrate_closely(cells: Floats, rows: Floats, options: Options, stop: StopFlag) -> None:
    """Replace the results of cells that need a tighter tolerance than they were given.

    cells, rows : (CELL_ROWS, n) and (RESULT_ROWS, n) of `layout.py`, in kernel units. STEPS are of all runs together.
    Ringing without any drag may graze standstill, however closely that is looked at: what sticks there in the tightest
    run is rounding, and the first one holds.
    """
    if not ((rows[layout.CLOSENESS] < _ERRORS * options.rtol).any() or (rows[layout.EXCHANGED] > _WASTED).any()):
        return
    rtol, first = np.full(rows.shape[1], options.rtol), rows.copy()
    while not stop[0]:
        wanted = np.maximum(_wanted(rows, rtol, options.rtol), _TIGHTEST)
        again = np.flatnonzero(wanted < rtol)
        if not again.size:
            grazes = (rtol < options.rtol) & (rows[layout.CLOSENESS] < _ERRORS * rtol)
            grazes &= first[layout.STATUS] == layout.NEUTRAL_RINGING
            first[layout.STEPS] = rows[layout.STEPS]
            rows[:, grazes] = first[:, grazes]
            return
        for tolerance in np.unique(wanted[again]):
            chosen = again[wanted[again] == tolerance]
            closer = new_regimes(chosen.size)
            part = np.ascontiguousarray(cells[:, chosen])
            run_regimes(options, float(tolerance), part, stop, closer)
            closer[layout.STEPS] += rows[layout.STEPS, chosen]
            rows[:, chosen], rtol[chosen] = closer, tolerance


def _wanted(rows: Floats, rtol: Floats, asked: float) -> Floats:
    """The tolerance that each cell needs; what it was integrated with where that will do."""
    wanted = np.where(rows[layout.CLOSENESS] < _ERRORS * rtol, _STEP * rtol, rtol)
    wasted = np.clip(np.nan_to_num(rows[layout.EXCHANGED] / _WASTED, nan=1.0), 1.0, 1e300)
    # Whole decades, so that cells of a map share a few runs.
    return np.asarray(np.minimum(wanted, asked * 10.0 ** -np.ceil(np.log10(wasted))))
