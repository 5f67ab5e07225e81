"""How far each parameter of a cell may be changed, and what a change is measured in.

A change is the logarithm of the ratio to the value that the cell has; where that is 0, or where a parameter may change
its sign (the starting state), it is the difference over a scale of the cell.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from stickslip.engine import Scales
from stickslip.theory import reversal_friction, reversal_speed
from stickslip.vocabulary.cells import Parameters
from stickslip.vocabulary.curve import broken_bounds, coefficients
from stickslip.vocabulary.quantities import MEASURED, SEARCHABLE

Floats = NDArray[np.float64]

CHANGEABLE = ("belt_speed", "stiffness", "damping", "normal_load", "mass", "mu_stop", "mu_static")
_IF_GIVEN = ("mu_stop", "mu_static")  # changed where a cell has them
_SIGNED = ("displacement", "velocity")  # changed by amounts, not by factors


@dataclass(frozen=True, eq=False)
class Reach:
    """One parameter in n cells: its value, how far down and up it may go, all in SI and (n,).

    by_factor : whether changes are logarithms of ratios. scale : what other changes are divided by. A value of NaN
    means that the cell does not have this parameter.
    """

    name: str
    value: Floats
    low: Floats
    high: Floats
    by_factor: NDArray[np.bool_]
    scale: Floats

    def at(self, change: Floats, cells: NDArray[np.int64]) -> Floats:
        """Values after changes, one for each of `cells`, no further than the reach."""
        value = self.value[cells]
        with np.errstate(over="ignore"):
            changed = np.where(self.by_factor[cells], value * np.exp(change), value + change * self.scale[cells])
        return np.where(change == 0.0, value, np.clip(changed, self.low[cells], self.high[cells]))

    def change(self, value: Floats) -> Floats:
        """The changes (n,) that lead to values."""
        with np.errstate(divide="ignore", invalid="ignore"):
            return np.where(self.by_factor, np.log(value / self.value), (value - self.value) / self.scale)

    @property
    def room(self) -> tuple[Floats, Floats]:
        """The largest change against and with the sign of the value, both at least 0; 0 where there is no value."""
        ends = self.change(self.low), self.change(self.high)
        down, up = np.minimum(*ends), np.maximum(*ends)
        return np.nan_to_num(np.maximum(-down, 0.0)), np.nan_to_num(np.maximum(up, 0.0))


def parameters_of(cells: Parameters) -> tuple[str, ...]:
    """The parameters of `CHANGEABLE` that cells have."""
    return tuple(name for name in CHANGEABLE if name not in _IF_GIVEN or not np.isnan(cells[name]).all())


def reach_of(name: str, cells: Parameters, within: float | tuple[float, float]) -> Reach:
    """Return how far a parameter may be changed: within a factor or a range, and within what is possible."""
    value = _value(name, cells)
    scale = np.broadcast_to(_scale(name, cells), value.shape).astype(np.float64)
    by_factor = (value != 0) & ~np.isnan(value) & (name not in _SIGNED)
    if isinstance(within, tuple):
        low, high = (np.full_like(value, end) for end in within)
        low, high = np.minimum(low, value), np.maximum(high, value)
        low = np.where(by_factor & (value > 0), np.maximum(low, np.minimum(value, 1e-12 * np.abs(high))), low)
        high = np.where(by_factor & (value < 0), np.minimum(high, np.maximum(value, -1e-12 * np.abs(low))), high)
    else:
        ends = np.where(by_factor, value / within, value - scale), np.where(by_factor, value * within, value + scale)
        low, high = np.minimum(*ends), np.maximum(*ends)
    least, most = _bounds(name, cells)
    return Reach(name, value, np.minimum(np.maximum(low, least), value), np.maximum(np.minimum(high, most), value),
                 by_factor, scale)  # fmt: skip


def is_possible(cells: Parameters) -> NDArray[np.bool_]:
    """Return whether cells could be computed: the bounds between parameters, as `as_cells` checks them."""
    bounds = {name: cells[name] for name in ("a1", "mu_static", "mu_stop")}
    broken = broken_bounds(cells["a1"] + cells["a3"], **bounds)
    return np.asarray((cells["a1"] >= 0) & ~np.logical_or.reduce([*broken.values()]))


def with_measured(cells: Parameters) -> Parameters:
    """The cells with mu_start, mu_reversal and v_reversal of their curves; NaN where a curve has no declining branch.

    The minimum of a curve that falls for ever towards a1 (a2 = 0) lies at an infinite speed.
    """
    curve = [cells[name] for name in ("a1", "a2", "a3", "a4")]
    speed = reversal_speed(*curve[1:])
    has = (curve[2] > 0) & (curve[1] >= 0) & (speed > 0)
    found = {"mu_start": curve[0] + curve[2], "mu_reversal": reversal_friction(*curve), "v_reversal": speed}
    return cells | {name: np.where(has, found[name], np.nan) for name in MEASURED}


def without_measured(cells: Parameters) -> Parameters:
    """Cells whose coefficients follow from what is measured of their curves, where that is among them; a1 is NaN where
    no curve has such a minimum."""
    if not set(MEASURED) <= set(cells):
        return cells
    rest = {name: values for name, values in cells.items() if name not in MEASURED}
    start, minimum, speed = (cells[name] for name in MEASURED)
    with np.errstate(invalid="ignore"):  # no drop down to a minimum at standstill
        curve = coefficients(start, minimum, speed, cells["a4"])._asdict()
    curve["a1"] = np.where(start >= minimum, curve["a1"], np.nan)
    return rest | {name: np.where(np.isnan(start), cells[name], values) for name, values in curve.items()}


def _value(name: str, cells: Parameters) -> Floats:
    """The value a parameter has; static friction that is not given is that at break-away."""
    value = np.where(np.isinf(cells[name]), np.nan, cells[name].astype(np.float64))
    return np.where(np.isnan(value), cells["a1"] + cells["a3"], value) if name == "mu_static" else value


def _scale(name: str, cells: Parameters) -> Floats:
    """Return what a change of a parameter that may be 0 is compared with."""
    by, mu_start = Scales(cells), cells["a1"] + cells["a3"]
    slope = np.where(cells["a3"] > 0, cells["a3"], np.maximum(mu_start, 1.0)) / cells["a4"]
    speed = np.where(cells["belt_speed"] != 0, np.abs(cells["belt_speed"]), cells["a4"])
    scales: dict[str, Floats] = {
        "damping": 2.0 * by.impedance, "a2": slope, "belt_speed": speed,
        "velocity": speed, "displacement": np.maximum(mu_start, 1e-3) * by.load / by.stiffness,
        "contact_time": cells["ageing_time"],
    }  # fmt: skip
    return scales.get(name, np.maximum(mu_start, 1e-3))


def _bounds(name: str, cells: Parameters) -> tuple[Floats, Floats]:
    """The least and the largest value, of the parameter itself and beside the others of the cell."""
    row, like = SEARCHABLE[name], np.ones_like(cells["a1"])
    least = like * (-np.inf if row.at_least is None else row.at_least)
    most = like * (np.inf if row.at_most is None else row.at_most)
    mu_start = cells["a1"] + cells["a3"]
    if name in ("mu_start", "mu_reversal"):  # a1 >= 0, and mu_reversal <= mu_start
        unit = coefficients(1.0, 0.0, cells["v_reversal"], cells["a4"])
        with np.errstate(divide="ignore", invalid="ignore"):
            share = 1.0 - 1.0 / unit.a3
            if name == "mu_start":
                least = np.fmax(cells["mu_reversal"], cells["mu_stop"])
                most = np.fmin(cells["mu_reversal"] / share, cells["mu_static"])
            else:
                least, most = cells["mu_start"] * share, cells["mu_start"]
    if name == "mu_static":
        least = np.maximum(least, mu_start)
    if name == "mu_stop":
        most = np.minimum(most, mu_start)
    if name in ("a1", "a3"):
        rest = mu_start - cells[name]
        least = np.maximum(least, np.nan_to_num(cells["mu_stop"], nan=0.0) - rest)
        most = np.minimum(most, np.nan_to_num(cells["mu_static"], nan=np.inf) - rest)
    return least, most
