"""Results of cells nobody has computed yet."""

import numpy as np
from numpy.typing import NDArray

from . import layout as at

NO_STATIONS = np.zeros((at.STATION_ROWS, at.STATIONS))  # of a law that is no table
NO_STOPS = np.zeros((0, at.STOP_COLUMNS))  # for `run_signals`: no table of stick phases


def new_regimes(n: int) -> NDArray[np.float64]:
    """Results (RESULT_ROWS, n) for the observer of regimes: NaN, no steps, and the codes for "not computed"."""
    results = np.full((at.RESULT_ROWS, n), np.nan)
    results[at.REGIME], results[at.STATUS], results[at.STEPS] = at.NOT_COMPUTED, at.NOT_RUN, 0.0
    return results


def new_signals(n: int) -> NDArray[np.float64]:
    """Results (RIG_ROWS, n) for the observer of signals: NaN, and the code for "not computed"."""
    results = np.full((at.RIG_ROWS, n), np.nan)
    results[at.RIG_STATUS] = at.NOT_RUN
    return results
