"""From SI to kernel units and back: the scales of a cell.

They are the load N for forces, N/k for displacements, sqrt(m/k) for times, N/sqrt(k m) for speeds, N/m for
accelerations.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from stickslip.engine.options import Results
from stickslip.vocabulary.cells import Cells
from stickslip_kernels import layout

_DECADE = float(np.log(10.0))


def to_kernel(cells: Cells, horizon: float) -> NDArray[np.float64]:
    """Cells in SI to the rows of `layout.py`, shape (CELL_ROWS, n); horizon in s."""
    k, load = cells["stiffness"], cells["normal_load"]
    impedance = np.sqrt(k * cells["mass"])
    speed, rate = load / impedance, np.sqrt(k / cells["mass"])
    rows = np.empty((layout.CELL_ROWS, k.size))
    rows[layout.GAMMA] = cells["damping"] / impedance
    rows[layout.BELT] = cells["belt_speed"] / speed
    rows[layout.A1] = cells["a1"]
    rows[layout.A2] = cells["a2"] * speed
    rows[layout.A3] = cells["a3"]
    rows[layout.A4] = cells["a4"] / speed
    rows[layout.DELTA] = cells["delta"]
    mu_start = cells["a1"] + cells["a3"]
    rows[layout.MU_STATIC] = np.fmax(cells["mu_static"], mu_start)
    rows[layout.MU_STOP] = cells["mu_stop"]
    rows[layout.AGEING] = cells["ageing_rate"] / _DECADE
    rows[layout.AGEING_TIME] = cells["ageing_time"] * rate
    rows[layout.XI_START] = cells["displacement"] * k / load
    rows[layout.ETA_START] = cells["velocity"] / speed
    rows[layout.CONTACT_START] = cells["contact_time"] * rate
    rows[layout.HORIZON] = horizon * rate
    return rows


def to_si(rows: NDArray[np.float64], cells: Cells, full: bool) -> Results:
    """The rows `run_block` filled to the variables people know.

    full : whether to add the variables that only a run to the horizon defines.
    """
    m, k, load = cells["mass"], cells["stiffness"], cells["normal_load"]
    time, length, speed = np.sqrt(m / k), load / k, load / np.sqrt(k * m)
    period = rows[layout.PERIOD] * time
    si = {
        "regime": rows[layout.REGIME],
        "status": rows[layout.STATUS],
        "breakaway_time": rows[layout.BREAKAWAY_TIME] * time,
        "restick_time": rows[layout.RESTICK_TIME] * time,
        "restick_displacement": rows[layout.RESTICK_XI] * length,
        "restick_margin": rows[layout.RESTICK_MARGIN] * speed,
        "period": period,
        "frequency": 1.0 / period,
        "stick_fraction": rows[layout.CYCLE_STICK_TIME] / rows[layout.PERIOD],
        "spring_force_max": rows[layout.XI_MAX] * load,
        "spring_force_min": rows[layout.XI_MIN] * load,
        "slip_speed_max": rows[layout.SPEED_MAX] * speed,
        "acceleration_max": rows[layout.ACCELERATION_MAX] * load / m,
        "mu_reversal": rows[layout.MU_REVERSAL],
        "mu_breakaway": rows[layout.MU_BREAKAWAY],
        "tendency": rows[layout.MU_BREAKAWAY] - 2.0 * rows[layout.MU_REVERSAL] + cells["mu_stop"],
        "energy_per_cycle": rows[layout.CYCLE_HEAT] * load * length,
        "equilibrium_crossings": rows[layout.CROSSINGS],
        "settling_time": rows[layout.SETTLING_TIME] * time,
        "settled_displacement": rows[layout.XI_SETTLED] * length,
        "displacement_amplitude": 0.5 * (rows[layout.CYCLE_XI_MAX] - rows[layout.CYCLE_XI_MIN]) * length,
        "velocity_amplitude": 0.5 * rows[layout.CYCLE_SPEED_RANGE] * speed,
        "cycle_force_max": rows[layout.CYCLE_XI_MAX] * load,
        "cycle_force_min": rows[layout.CYCLE_XI_MIN] * load,
        "damping_ratio": rows[layout.DAMPING_RATIO],
        "steps": rows[layout.STEPS],
    }
    if full:
        si |= {
            "sticks": rows[layout.STICKS],
            "stick_time": rows[layout.STICK_TIME] * time,
            "displacement_end": rows[layout.XI_END] * length,
            "velocity_end": rows[layout.ETA_END] * speed,
        }
    return si


def signals_to_si(signals: NDArray[np.float64], cells: Cells, columns: NDArray[np.float64]) -> Results:
    """Signals on steady belts, in SI, by names of `TRACE_VARIABLES`.

    cells, columns : of each sample, in SI and in kernel units; those of a single cell serve all samples.
    """
    m, k, load, belt = (cells[name] for name in ("mass", "stiffness", "normal_load", "belt_speed"))
    xi, eta, friction, mode = signals
    force, relative = xi * load, (columns[layout.BELT] - eta) * load / np.sqrt(k * m)
    accelerating = (mode != layout.STICK) & (mode != layout.HOLD)
    return {
        "displacement": force / k,
        "velocity": belt - relative,
        "relative_speed": relative,
        "friction_coefficient": friction,
        "spring_force": force,
        "acceleration": np.where(accelerating, friction - xi - columns[layout.GAMMA] * eta, 0.0) * load / m,
        "mode": mode,
    }
