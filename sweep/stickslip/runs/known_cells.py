"""Cells of a finished result that a new run takes over: of the same map, or of one whose axes were extended since."""

from dataclasses import dataclass
from typing import Any

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from stickslip.runs.blocks import Region, regions
from stickslip.vocabulary.cells import Cells

Indices = NDArray[np.int64]
_ROUNDING = 1e-12  # relative: what a few operations on a number come to, and no step of an axis is


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
        parts = [self._region(region) for region in regions(cells.start, cells.stop, self.shape)]
        have = np.concatenate([part[0] for part in parts])
        if not have.any():
            return None
        results = [part[1] for part in parts if part[1]]
        return have, {name: np.concatenate([part[name] for part in results]) for name in results[0]}

    def _region(self, region: Region) -> tuple[NDArray[np.bool_], dict[str, NDArray[Any]]]:
        """Flags and results as `cells` gives them, of a region; no results where none are known."""
        places = [points[side] for points, side in zip(self.points, region, strict=True)]
        have: NDArray[np.bool_] = np.ones((), bool)
        for place in places:
            have = np.logical_and.outer(have, place >= 0)
        if not have.any():
            return have.ravel(), {}
        dims = self.dataset["regime"].dims
        indices = {dim: place[place >= 0] for dim, place in zip(dims, places, strict=True)}
        part = self.dataset.drop_vars(self.dataset.coords).isel(indices).transpose(*dims).load()
        computed = part["regime"].values.ravel() != 0
        have = have.ravel()
        have[have] = computed
        return have, {str(name): part[name].values.ravel()[computed] for name in part.data_vars}


def points_of(old: Cells, new: Cells) -> tuple[Indices, ...]:
    """For each dimension of `new`, where its points lie in that dimension of `old`, -1 for new ones.

    Points are equal if all their quantities are, to the bit. Both grids have the same axes in the same order.
    """
    return tuple(_places(_quantities(old, i), _quantities(new, i)) for i in range(len(new.dims)))


def rounded(old: Cells, new: Cells) -> dict[str, float]:
    """The quantities whose values are those of `new` but for rounding, each with the largest difference, in SI; empty
    if any value of `old` is another one. Both grids have the same axes in the same order.
    """
    differences: dict[str, float] = {}
    for coordinate in old.coords:
        other = next(c.values for c in new.coords if c.name == coordinate.name)
        values, known = (np.unique(v[~np.isnan(v)]) for v in (coordinate.values, other))
        if not known.size:
            return {}
        above = np.searchsorted(known, values).clip(1, known.size) - 1
        apart = np.abs(known[np.stack([above, np.minimum(above + 1, known.size - 1)])] - values).min(axis=0)
        if not (apart <= _ROUNDING * np.abs(values)).all():
            return {}
        if (apart > 0).any():
            differences[coordinate.name] = float(apart.max())
    return differences


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
