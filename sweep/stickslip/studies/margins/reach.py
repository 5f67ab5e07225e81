"""Reach of each parameter of a cell, and the measure of its changes.

A change is the logarithm of the ratio to the value that the cell has; where that is 0, or where a parameter may change
its sign (the starting state), it is the difference over a scale of the cell.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from stickslip.engine import Scales
from stickslip.vocabulary.cells import Parameters
from stickslip.vocabulary.models import model_with
from stickslip.vocabulary.quantities import SEARCHABLE

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
    own = [name for name in CHANGEABLE if name in cells]
    return tuple(name for name in own if name not in _IF_GIVEN or not np.isnan(cells[name]).all())


def reach_of(name: str, cells: Parameters, within: float | tuple[float, float]) -> Reach:
    """Return how far a parameter may be changed: within a factor or a range, and within what is possible."""
    model, by = model_with(cells), Scales(cells)
    value = np.where(np.isinf(cells[name]), np.nan, cells[name].astype(np.float64))
    if name == model.static:  # where it is not given it is that at break-away
        value = np.where(np.isnan(value), model.start_of(cells), value)
    scale = 2.0 * by.impedance if name == "damping" else model.change_scale(name, cells, by)
    scale = np.broadcast_to(scale, value.shape).astype(np.float64)
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


def _bounds(name: str, cells: Parameters) -> tuple[Floats, Floats]:
    """The least and the largest value, of the parameter itself and beside the others of the cell."""
    row, like = SEARCHABLE[name], np.ones_like(cells["mass"])
    least = like * (-np.inf if row.at_least is None else row.at_least)
    most = like * (np.inf if row.at_most is None else row.at_most)
    return model_with(cells).within(name, cells, least, most)
