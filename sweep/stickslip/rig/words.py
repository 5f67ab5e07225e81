"""A test matrix in everyday terms: units such as mm/s, the points of a dimension, the names of tests."""

from __future__ import annotations

import math
from collections.abc import Hashable, Sequence
from dataclasses import dataclass

import numpy as np
import xarray as xr
from numpy.typing import ArrayLike

from stickslip.vocabulary import units

# SI units, what people say instead where all numbers are below 1, and the factor.
_SMALL = {"m s-1": ("mm/s", 1e3), "m": ("mm", 1e3), "kg": ("g", 1e3), "J": ("mJ", 1e3)}
_ALWAYS = {"N m-1": ("N/mm", 1e-3), "m-1": ("1/mm", 1e-3), "s-1": ("Hz", 1.0)}
_NO_BREAK = "\N{NO-BREAK SPACE}"
_RAISED = str.maketrans("23", "²³")


def unit_for(si: str, values: ArrayLike) -> tuple[str, float]:
    """The unit to show such values in, and what they are multiplied with; no text for pure numbers."""
    if si in _ALWAYS:
        return _ALWAYS[si]
    known = np.abs(np.asarray(values, np.float64))
    largest = float(np.max(known[np.isfinite(known)], initial=0.0))
    if si in _SMALL and 0.0 < largest < 1.0:
        return _SMALL[si]
    return units.spelled(si).translate(_RAISED), 1.0


def number(value: float) -> str:
    """A value to three digits, without an exponent as long as it stays short; a dash where there is none."""
    if not math.isfinite(value):
        return "–"
    size = abs(value)
    if 1000 <= size < 1e6:
        return f"{value:.0f}"
    return f"{value:.3g}".replace("e-0", "e-").replace("e+0", "e")


def quantity(value: float, si: str) -> str:
    """A value in SI with the unit people use: `10 mm/s`."""
    unit, factor = unit_for(si, value)
    return f"{value * factor:.4g} {unit}".rstrip()


@dataclass(frozen=True)
class Along:
    """One dimension of a matrix. unit : of the points, empty where they have none or say it themselves."""

    name: str
    unit: str
    points: tuple[str, ...]
    is_text: bool

    @property
    def title(self) -> str:
        """The name with the unit."""
        return f"{self.name} ({self.unit})" if self.unit else self.name

    def said(self, i: int) -> str:
        """A point that can stand alone: with its unit, or with the name of what it is a number of."""
        if not self.is_text and not self.unit:
            return f"{self.name} {self.points[i]}"
        return f"{self.points[i]}{_NO_BREAK}{self.unit}".rstrip()


def along(ds: xr.Dataset, dim: Hashable) -> Along:
    """A dimension: labels where it has them, else the values of its quantity, else its points counted from 1."""
    name = str(dim).removesuffix("_case").replace("_", " ")
    quantities = [ds[c] for c in ds.coords if ds[c].dims == (dim,)]
    named = ds[dim] if dim in ds.coords else quantities[0] if len(quantities) == 1 else None
    if named is None:
        return Along(name, "", tuple(str(i + 1) for i in range(ds.sizes[dim])), False)
    if named.dtype.kind not in "fiu":
        return Along(name, "", tuple(map(str, named.values.tolist())), True)
    unit, factor = unit_for(str(named.attrs.get("units", "1")), named.values)
    values = [value * factor for value in named.values.tolist()]
    written = [tuple(f"{value:.{digits}g}" for value in values) for digits in (4, 6, 9, 17)]
    return Along(name, unit, next((w for w in written if len(set(w)) == len(w)), written[-1]), False)


def name_of(dims: Sequence[Along], number: int) -> str:
    """What distinguishes a test of a matrix from the others: `felt, 10 s, 5 mm/s`; nothing where there is only one."""
    at = np.unravel_index(number, [len(d.points) for d in dims]) if dims else ()
    return ", ".join(d.said(int(i)) for d, i in zip(dims, at, strict=True))
