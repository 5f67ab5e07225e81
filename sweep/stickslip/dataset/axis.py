"""A dimension of a dataset as an axis: centres and edges of its cells, scale, words."""

from __future__ import annotations

from collections.abc import Hashable
from functools import cached_property

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from stickslip.config.grid import quantity_of
from stickslip.dataset.coarse import middles
from stickslip.dataset.display import unit_of
from stickslip.vocabulary.display_units import Unit, spoken

_MOST_BESIDE = 3  # parameters that vary together and are still spelled out


class MapAxis:
    """One dimension of a map, ready to be drawn or named.

    Numeric if the dimension has a numeric index, laid out as its `axis_spacing` says. Otherwise (named points,
    parameters that vary together) the points are placed side by side under their labels.
    Numbers are in the unit in which the dimension is shown (`display`), `unit`.
    plain : words are for the screen, with more digits and with units as people type them.
    log : logarithmic, whatever the dataset says.
    """

    def __init__(self, ds: xr.Dataset, dim: Hashable, plain: bool = False, log: bool = False) -> None:
        self._plain, self._log = plain, log
        self.dim = dim
        self.length = ds.sizes[dim]
        self._index = ds[dim] if dim in ds.coords else None
        self._beside = [ds[name] for name in ds.coords if name != dim and ds[name].dims == (dim,)]
        self.is_numeric = self._index is not None and self._index.dtype.kind in "fiu"

    @cached_property
    def unit(self) -> Unit:
        """The unit of the numbers."""
        return unit_of(self._index) if self._index is not None and self.is_numeric else Unit()

    @cached_property
    def title(self) -> str:
        """The quantity that the axis shows, with its unit."""
        if self._index is not None:
            return title(self._index)
        return title(self._beside[0]) if len(self._beside) == 1 else str(self.dim).replace("_", " ")

    @cached_property
    def centres(self) -> NDArray[np.float64]:
        """Positions of the points: at their values, or at 0, 1, 2 ... under labels."""
        if self._index is not None and self.is_numeric:
            return np.asarray(self.unit.of(self._index.values.astype(np.float64)))
        return np.arange(self.length, dtype=np.float64)

    @cached_property
    def edges(self) -> NDArray[np.float64]:
        """Borders of the cells: half way between neighbours, on the scale of the axis."""
        return np.exp(_midpoints(np.log(self.centres))) if self.is_log else _midpoints(self.centres)

    def pixel_edges(self, step: int) -> NDArray[np.float64]:
        """Borders of pixels of `step` cells; the last may be shorter."""
        return np.append(self.edges[:-1:step], self.edges[-1])

    def pixel_points(self, step: int) -> NDArray[np.float64]:
        """Positions of the cells in the middle of the pixels."""
        return self.centres[middles(self.length, step)]

    @cached_property
    def is_log(self) -> bool:
        """Tell whether the axis is logarithmic."""
        spacing = None if self._index is None else self._index.attrs.get("axis_spacing")
        return self.is_numeric and (self._log or spacing == "log") and bool((self.centres > 0).all())

    def text(self, i: int) -> str:
        """Point `i` in words: its label, its value, or the values of the parameters that vary together."""
        if self._index is not None:
            value = self._index.values[i]
            return self._quantity(self._index, value) if self.is_numeric else str(value)
        if len(self._beside) == 1:
            return self._quantity(self._beside[0], self._beside[0].values[i])
        if 1 < len(self._beside) <= _MOST_BESIDE:
            return ", ".join(f"{short_name(c)} = {self._quantity(c, c.values[i])}" for c in self._beside)
        return str(i)

    def _quantity(self, array: xr.DataArray, value: float) -> str:
        unit = unit_of(array)
        return unit.text(value) if self._plain else f"{unit.of(value):.4g} {unit.printed}".rstrip()

    def heading(self, i: int) -> str:
        """Point `i` with the name of what it is a point of, short enough for the title of a panel."""
        if self._index is not None and self.is_numeric:
            return f"{short_name(self._index)} = {self.text(i)}"
        if len(self._beside) == 1 and (self._index is None or self.dim == f"{self._beside[0].name}_case"):
            return f"{short_name(self._beside[0])} = {self.text(i)}"
        if self._index is None and 1 < len(self._beside) <= _MOST_BESIDE:
            return self.text(i)
        return f"{self.dim}: {self.text(i)}".replace("_", " ")


def short_name(array: xr.DataArray) -> str:
    """The name of a quantity as people write it: `belt speed`, but `mu_stop` as in a configuration."""
    return spoken(quantity_of(str(array.name)))


def title(array: xr.DataArray, unit: Unit | None = None) -> str:
    """Long name with the unit in which it is shown, if there is one. unit : which, where that is known."""
    name = str(array.attrs.get("long_name", array.name)).replace("_", " ")
    printed = (unit or unit_of(array)).printed
    return f"{name} ({printed})" if printed else name


def _midpoints(centres: NDArray[np.float64]) -> NDArray[np.float64]:
    """Edges between neighbouring centres, and as far outside the ends as inside; around a lone centre, a small cell."""
    if len(centres) == 1:
        half = 0.05 * abs(centres[0]) or 0.5
        return np.array([centres[0] - half, centres[0] + half])
    inner = (centres[1:] + centres[:-1]) / 2
    return np.concatenate([[2 * centres[0] - inner[0]], inner, [2 * centres[-1] - inner[-1]]])
