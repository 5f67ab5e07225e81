"""From SI to kernel units and back: the scales of a cell.

They are the load N for forces, N/k for displacements, sqrt(m/k) for times, N/sqrt(k m) for speeds, N/m for
accelerations.
"""

from __future__ import annotations

from collections.abc import Callable, Collection
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from stickslip.engine.options import Results
from stickslip.vocabulary.cells import Parameters
from stickslip_kernels import layout

Floats = NDArray[np.float64]
_DECADE = float(np.log(10.0))


class Scales:
    """The scales of cells, each (n,): whatever is converted between SI and kernel units goes by them."""

    def __init__(self, cells: Parameters) -> None:
        self.mass, self.stiffness, self.mu_stop = cells["mass"], cells["stiffness"], cells["mu_stop"]
        self.load = cells["normal_load"]

    @cached_property
    def impedance(self) -> Floats:
        """sqrt(k m), N s/m."""
        return np.asarray(np.sqrt(self.stiffness * self.mass))

    @cached_property
    def time(self) -> Floats:
        """A radian of the free oscillation, s."""
        return np.asarray(np.sqrt(self.mass / self.stiffness))

    @cached_property
    def rate(self) -> Floats:
        """Its inverse, 1/s."""
        return np.asarray(np.sqrt(self.stiffness / self.mass))

    @cached_property
    def length(self) -> Floats:
        """Deflection of the spring by the load, m."""
        return np.asarray(self.load / self.stiffness)

    @cached_property
    def speed(self) -> Floats:
        """m/s."""
        return np.asarray(self.load / self.impedance)


def to_kernel(cells: Parameters, horizon: float) -> Floats:
    """Cells in SI to the rows of `layout.py`, shape (CELL_ROWS, n); horizon in s."""
    by = Scales(cells)
    speed, rate = by.speed, by.rate
    rows = np.empty((layout.CELL_ROWS, by.mass.size))
    rows[layout.GAMMA] = cells["damping"] / by.impedance
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
    rows[layout.XI_START] = cells["displacement"] * by.stiffness / by.load
    rows[layout.ETA_START] = cells["velocity"] / speed
    rows[layout.CONTACT_START] = cells["contact_time"] * rate
    rows[layout.HORIZON] = horizon * rate
    return rows


_Conversion = Callable[[Floats, Scales], Floats]
_ALWAYS: dict[str, _Conversion] = {
    "regime": lambda rows, by: rows[layout.REGIME],
    "status": lambda rows, by: rows[layout.STATUS],
    "breakaway_time": lambda rows, by: rows[layout.BREAKAWAY_TIME] * by.time,
    "restick_time": lambda rows, by: rows[layout.RESTICK_TIME] * by.time,
    "restick_displacement": lambda rows, by: rows[layout.RESTICK_XI] * by.length,
    "restick_margin": lambda rows, by: rows[layout.RESTICK_MARGIN] * by.speed,
    "period": lambda rows, by: rows[layout.PERIOD] * by.time,
    "frequency": lambda rows, by: 1.0 / (rows[layout.PERIOD] * by.time),
    "stick_fraction": lambda rows, by: rows[layout.CYCLE_STICK_TIME] / rows[layout.PERIOD],
    "spring_force_max": lambda rows, by: rows[layout.XI_MAX] * by.load,
    "spring_force_min": lambda rows, by: rows[layout.XI_MIN] * by.load,
    "slip_speed_max": lambda rows, by: rows[layout.SPEED_MAX] * by.speed,
    "acceleration_max": lambda rows, by: rows[layout.ACCELERATION_MAX] * by.load / by.mass,
    "mu_reversal": lambda rows, by: rows[layout.MU_REVERSAL],
    "mu_breakaway": lambda rows, by: rows[layout.MU_BREAKAWAY],
    "tendency": lambda rows, by: rows[layout.MU_BREAKAWAY] - 2.0 * rows[layout.MU_REVERSAL] + by.mu_stop,
    "energy_per_cycle": lambda rows, by: rows[layout.CYCLE_HEAT] * by.load * by.length,
    "equilibrium_crossings": lambda rows, by: rows[layout.CROSSINGS],
    "settling_time": lambda rows, by: rows[layout.SETTLING_TIME] * by.time,
    "settled_displacement": lambda rows, by: rows[layout.XI_SETTLED] * by.length,
    "displacement_amplitude": lambda rows, by: (
        0.5 * (rows[layout.CYCLE_XI_MAX] - rows[layout.CYCLE_XI_MIN]) * by.length
    ),
    "velocity_amplitude": lambda rows, by: 0.5 * rows[layout.CYCLE_SPEED_RANGE] * by.speed,
    "cycle_force_max": lambda rows, by: rows[layout.CYCLE_XI_MAX] * by.load,
    "cycle_force_min": lambda rows, by: rows[layout.CYCLE_XI_MIN] * by.load,
    "damping_ratio": lambda rows, by: rows[layout.DAMPING_RATIO],
    "steps": lambda rows, by: rows[layout.STEPS],
}
_TO_HORIZON: dict[str, _Conversion] = {
    "sticks": lambda rows, by: rows[layout.STICKS],
    "stick_time": lambda rows, by: rows[layout.STICK_TIME] * by.time,
    "displacement_end": lambda rows, by: rows[layout.XI_END] * by.length,
    "velocity_end": lambda rows, by: rows[layout.ETA_END] * by.speed,
}


def to_si(rows: Floats, cells: Parameters, full: bool, names: Collection[str] | None = None) -> Results:
    """The rows `run_block` filled to the variables people know.

    full : whether to add the variables that only a run to the horizon defines. names : the only ones to convert.
    """
    by, conversions = Scales(cells), _ALWAYS | _TO_HORIZON if full else _ALWAYS
    return {name: convert(rows, by) for name, convert in conversions.items() if names is None or name in names}


def signals_to_si(signals: NDArray[np.float64], cells: Parameters, columns: NDArray[np.float64]) -> Results:
    """Signals on steady belts, in SI, by names of `TRACE_VARIABLES`.

    cells, columns : of each sample, in SI and in kernel units; those of a single cell serve all samples.
    """
    by = Scales(cells)
    xi, eta, friction, mode = signals
    force, relative = xi * by.load, (columns[layout.BELT] - eta) * by.load / by.impedance
    accelerating = (mode != layout.STICK) & (mode != layout.HOLD)
    return {
        "displacement": force / by.stiffness,
        "velocity": cells["belt_speed"] - relative,
        "relative_speed": relative,
        "friction_coefficient": friction,
        "spring_force": force,
        "acceleration": np.where(accelerating, friction - xi - columns[layout.GAMMA] * eta, 0.0) * by.load / by.mass,
        "mode": mode,
    }
