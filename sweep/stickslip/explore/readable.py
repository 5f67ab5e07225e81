"""Numbers as people read them: in the unit they were written in, or the one that is customary for their size."""

from __future__ import annotations

from math import isfinite
from typing import NamedTuple

import xarray as xr
from numpy.typing import ArrayLike

from stickslip.dataset import display
from stickslip.vocabulary import display_units
from stickslip.vocabulary import units as si

_DIGITS = 4


class Unit(NamedTuple):
    """What a number in SI is divided by to be in the unit called `name`."""

    factor: float
    name: str

    def text(self, value: float) -> str:
        """A value in SI, in this unit."""
        words = number(value / self.factor)
        return words if value != value else f"{words} {self.name}".rstrip()


def unit_for(units: str, values: ArrayLike, written: str | None = None) -> Unit:
    """The unit for numbers in SI: the one they were written in, else the customary one for the largest of them."""
    if written is not None:
        return Unit(si.factor(written, units), written)
    unit = display_units.unit_for(units, values)
    return Unit(unit.size, unit.name)


def unit_shown(array: xr.DataArray, values: ArrayLike) -> Unit:
    """The unit for an array of a dataset: that of its display, where people or their configuration asked for one.

    values : what decides else.
    """
    units, asked = str(array.attrs.get("units", "1")), display.unit_of(array)
    if asked.name not in (si.spelled(units), "Hz", "s", "ms", "µs"):
        return Unit(asked.size, asked.name)
    return unit_for(units, values)


def number(value: float) -> str:
    """A number with as many digits as are read at a glance; a dash where there is none."""
    if not isfinite(value):
        return "–" if value != value else ("∞" if value > 0 else "-∞")
    return f"{value:.{_DIGITS}g}"


def quantity(value: float, units: str) -> str:
    """A single value in SI, in the unit that suits it."""
    return unit_for(units, value).text(value)
