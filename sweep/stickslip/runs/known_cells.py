"""Cells of a finished result that a new run takes over: of the same map, or of one whose axes were extended since."""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from stickslip.config.grid import quantity_of
from stickslip.vocabulary.cells import Cells

Indices = NDArray[np.int64]
_ROUNDING = 1e-12  # relative: what a few operations on a number come to
_OF_STEP = 1e-10  # of an axis: what they come to where a value is much smaller than those they began with


@dataclass(frozen=True)
class KnownCells:
    """The cells of `dataset`, found from those of a new grid.

    points : for each dimension, where the points of the new grid lie in the dataset; -1 for those it does not have.
    """

    dataset: xr.Dataset
    shape: tuple[int, ...]
    points: tuple[Indices, ...]

    def cells(self, cells: range) -> tuple[NDArray[np.bool_], dict[str, NDArray[Any]]] | None:
        """Flags of the known cells of a range of the new grid, and their results; None if none is known."""
        numbers = np.unravel_index(np.arange(cells.start, cells.stop), self.shape or (1,))
        places = [points[number] for points, number in zip(self.points, numbers, strict=False)]  # none of a single cell
        have = np.logical_and.reduce([place >= 0 for place in places] or [np.ones(len(cells), bool)])
        if not have.any():
            return None
        dims = self.dataset["regime"].dims
        indices = {dim: xr.DataArray(place[have], dims="cell") for dim, place in zip(dims, places, strict=True)}
        part = self.dataset.drop_vars(self.dataset.coords).isel(indices).load()
        computed = part["regime"].values.ravel() != 0
        have[have] = computed
        return have, {str(name): part[name].values.ravel()[computed] for name in part.data_vars}


def points_of(old: Cells, new: Cells) -> tuple[Indices, ...]:
    """For each dimension of `new`, where its points lie in that dimension of `old`, -1 for new ones.

    Points are equal if all their quantities are, to the bit. Both grids have the same axes in the same order.
    """
    return tuple(_places(_quantities(old, i), _quantities(new, i)) for i in range(len(new.dims)))


def as_before(grid: Cells, values: Mapping[str, NDArray[np.float64]]) -> Cells:
    """`grid` with values of before, by coordinate, wherever only rounding tells its own from them."""
    coords = tuple(
        replace(c, values=_as_before(values[c.name], c.values)) if c.name in values else c for c in grid.coords
    )
    along = {quantity_of(c.name): (grid.dims.index(c.dim), c.values) for c in coords}
    return replace(grid, coords=coords, along=along)


def _as_before(before: NDArray[np.float64], values: NDArray[np.float64]) -> NDArray[np.float64]:
    known = np.unique(before[~np.isnan(before)])
    if not known.size:
        return values
    gaps, own = _gaps(known), np.unique(values)
    nearest = (np.searchsorted(known, values) - 1).clip(0, known.size - 1)
    above = (nearest + 1).clip(0, known.size - 1)
    nearest = np.where(abs(known[above] - values) < abs(known[nearest] - values), above, nearest)
    gap = np.minimum(gaps[nearest], _gaps(own)[np.searchsorted(own, values)])
    of_step = np.where(np.isfinite(gap), _OF_STEP * gap, 0.0)  # where a range passes through 0
    rounding = np.minimum(np.maximum(_ROUNDING * abs(values), of_step), gap / 4)
    return np.where(abs(known[nearest] - values) <= rounding, known[nearest], values)


def _gaps(ascending: NDArray[np.float64]) -> NDArray[np.float64]:
    """From each value to the nearest other one; infinite where there is none."""
    steps = np.diff(ascending, prepend=-np.inf, append=np.inf)
    return np.minimum(steps[:-1], steps[1:])


def _quantities(grid: Cells, dimension: int) -> NDArray[np.int64]:
    """The bits of all quantities along a dimension: shape (points, quantities)."""
    along = sorted((c for c in grid.coords if c.dim == grid.dims[dimension]), key=lambda c: c.name)
    return np.stack([np.ascontiguousarray(c.values, np.float64).view(np.int64) for c in along], axis=1)


def _places(old: NDArray[np.int64], new: NDArray[np.int64]) -> Indices:
    _, numbered = np.unique(np.concatenate([old, new]), axis=0, return_inverse=True)
    numbered = numbered.reshape(-1)
    places = np.full(numbered.max() + 1, -1, np.int64)
    places[numbered[: len(old)]] = np.arange(len(old))
    return places[numbered[len(old) :]]
