"""Numbers as people read them: in the unit in which they are neither thousands nor thousandths."""

from __future__ import annotations

from collections.abc import Iterable
from math import isfinite
from typing import NamedTuple

import numpy as np

from stickslip.vocabulary import units as si

_UNITS = {  # by SI unit: factors and names, the largest first
    "m": ((1.0, "m"), (1e-3, "mm"), (1e-6, "µm"), (1e-9, "nm")),
    "s": ((1.0, "s"), (1e-3, "ms"), (1e-6, "µs")),
    "kg": ((1.0, "kg"), (1e-3, "g"), (1e-6, "mg")),
    "N": ((1e3, "kN"), (1.0, "N"), (1e-3, "mN")),
    "J": ((1.0, "J"), (1e-3, "mJ"), (1e-6, "µJ"), (1e-9, "nJ")),
    "m s-1": ((1.0, "m/s"), (1e-3, "mm/s"), (1e-6, "µm/s")),
    "N m-1": ((1e3, "N/mm"), (1.0, "N/m")),
    "s-1": ((1e3, "kHz"), (1.0, "Hz"), (1e-3, "mHz")),
}
_DIGITS = 4


class Unit(NamedTuple):
    """What a number in SI is divided by to be in the unit called `name`."""

    factor: float
    name: str

    def text(self, value: float) -> str:
        """A value in SI, in this unit."""
        words = number(value / self.factor)
        return words if value != value else f"{words} {self.name}".rstrip()


def unit_for(units: str, values: Iterable[float]) -> Unit:
    """The unit for numbers in SI: the largest in which the largest of them is at least 1."""
    known = _UNITS.get(units)
    if known is None:
        return Unit(1.0, si.spelled(units))
    sizes = np.abs(np.asarray(list(values) if not isinstance(values, np.ndarray) else values, np.float64))
    sizes = sizes[np.isfinite(sizes)]
    largest = float(sizes.max()) if sizes.size else 0.0
    plain = next(one for one in known if one[0] == 1.0)
    if largest == 0.0:
        return Unit(*plain)
    return Unit(*next((one for one in known if largest >= one[0] * (1.0 - 1e-9)), known[-1]))


def number(value: float) -> str:
    """A number with as many digits as are read at a glance; a dash where there is none."""
    if not isfinite(value):
        return "–" if value != value else ("∞" if value > 0 else "-∞")
    return f"{value:.{_DIGITS}g}"


def quantity(value: float, units: str) -> str:
    """A single value in SI, in the unit that suits it."""
    return unit_for(units, [value]).text(value)
