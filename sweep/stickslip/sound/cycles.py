"""States on the cycles of cells, from which one period of them is sampled.

A cycle with a stick phase begins a little before its break-away: there the mass moves with the belt, and the load on
the contact says where it is. One without begins at the largest displacement along the belt, at rest, where friction
lies on the curve whatever came before. Both follow from what the kernels say of a cell.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from stickslip.engine import Options, Results, Scales
from stickslip.vocabulary.cells import Parameters, taken
from stickslip.vocabulary.flags import REGIMES
from stickslip.vocabulary.models import CURVE_LAWS, STRIBECK, model_of
from stickslip.vocabulary.suggest import listed

Floats = NDArray[np.float64]

RTOL = 1e-9  # of the motion, so that its errors are not heard beside it
LEAD = 0.02  # s of sticking before a break-away, at most
_PERIODIC = REGIMES.index("stick_slip"), REGIMES.index("sustained")


@dataclass(frozen=True)
class Cycles:
    """Cells that have a cycle, started on it.

    which : their numbers among those asked for. cells : they, with start states on the cycle. period : s.
    moving : s, how long it is from the start until the mass sticks again; the period where it never does.
    """

    which: NDArray[np.intp]
    cells: Parameters
    period: Floats
    moving: Floats


def check_law(options: Options) -> None:
    """Raise ValueError for a law whose cycles begin with no break-away."""
    if model_of(options.law) is not STRIBECK:
        raise ValueError(f"law: no sound of {options.law}, a contact with memory, expected {listed(CURVE_LAWS)}")


def cycles_of(cells: Parameters, results: Results, lead: float = LEAD) -> Cycles:
    """The cycles of cells whose results are known; lead : s of sticking before the break-away, at most."""
    which = np.flatnonzero(np.isin(results["regime"], _PERIODIC) & (results["period"] > 0.0))
    own, results = taken(cells, which), taken(results, which)
    sticks = results["regime"] == _PERIODIC[0]
    period, sticking = results["period"], np.where(sticks, results["stick_fraction"] * results["period"], 0.0)
    belt, ahead = own["belt_speed"], np.minimum(0.5 * sticking, lead)
    forward = belt > 0.0
    force = np.where(forward, results["cycle_force_max"], results["cycle_force_min"])
    load = np.where(forward, 1.0, -1.0) * results["mu_breakaway"] * Scales(own).load
    force = np.where(sticks, load - own["damping"] * belt - own["stiffness"] * belt * ahead, force)
    start = {
        "displacement": force / own["stiffness"],
        "velocity": np.where(sticks, np.nan, 0.0),
        "contact_time": np.where(sticks, sticking - ahead, 0.0),
    }
    return Cycles(which, own | start, period, np.where(sticks, ahead + period - sticking, period))
