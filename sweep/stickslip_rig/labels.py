"""The dimensions of a test matrix in everyday terms: units such as mm/s, labels of points, names of tests."""

from collections.abc import Hashable, Iterable, Sequence
from dataclasses import dataclass

import numpy as np
import xarray as xr
from numpy.typing import ArrayLike

from stickslip.vocabulary import display_units
from stickslip.vocabulary.display_units import Unit

_AS_THEY_ARE = ("s", "N")  # units that people give all times of a matrix in, and all forces
_NO_BREAK = "\N{NO-BREAK SPACE}"


def unit_for(si: str, values: ArrayLike) -> Unit:
    """The customary unit for the largest of some values in SI."""
    return display_units.unit_for(si, 0.0 if si in _AS_THEY_ARE else values)


@dataclass(frozen=True)
class Dimension:
    """One dimension of a matrix. unit : of the points, empty where they have none or are texts."""

    name: str
    unit: str
    points: tuple[str, ...]
    is_text: bool = False

    @property
    def title(self) -> str:
        """The name with the unit."""
        return f"{self.name} ({self.unit})" if self.unit else self.name

    def label(self, i: int) -> str:
        """A point that can stand alone: with its unit, or with the name of what it is a number of."""
        if not self.is_text and not self.unit:
            return f"{self.name} {self.points[i]}"
        return f"{self.points[i]}{_NO_BREAK}{self.unit}".rstrip()


def dimensions(ds: xr.Dataset, dims: Iterable[Hashable]) -> list[Dimension]:
    """Some dimensions of a matrix."""
    return [dimension(ds, dim) for dim in dims]


def dimension(ds: xr.Dataset, dim: Hashable) -> Dimension:
    """A dimension: labels where it has them, else the values of its quantity, else its points counted from 1."""
    name = str(dim).removesuffix("_case").replace("_", " ")
    quantities = [ds[c] for c in ds.coords if ds[c].dims == (dim,)]
    index = ds[dim] if dim in ds.coords else quantities[0] if len(quantities) == 1 else None
    if index is None:
        return Dimension(name, "", tuple(str(i + 1) for i in range(ds.sizes[dim])))
    if index.dtype.kind not in "fiu":
        return Dimension(name, "", tuple(map(str, index.values.tolist())), is_text=True)
    unit = unit_for(str(index.attrs.get("units", "1")), index.values)
    values = [unit.of(value) for value in index.values.tolist()]
    texts = [tuple(f"{value:.{digits}g}" for value in values) for digits in (4, 6, 9, 17)]
    return Dimension(name, unit.printed, next((row for row in texts if len(set(row)) == len(row)), texts[-1]))


def point_name(dims: Sequence[Dimension], number: int) -> str:
    """The points that distinguish a test from the others: `felt, 10 s, 5 mm/s`; nothing where there is only one."""
    at = np.unravel_index(number, [len(d.points) for d in dims]) if dims else ()
    return ", ".join(d.label(int(i)) for d, i in zip(dims, at, strict=True))
