"""How much of a map is what."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
import xarray as xr

from .variables import REGIMES


class Share(NamedTuple):
    """Number of cells, and their part of all cells."""

    cells: int
    fraction: float


def summary(ds: xr.Dataset) -> dict[str, Share]:
    """The regimes that occur, in the order of `REGIMES`, with their number of cells and their share of the dataset."""
    counts = np.bincount(np.asarray(ds["regime"].values, np.int64).ravel(), minlength=len(REGIMES))
    total = max(1, int(counts.sum()))
    return {name: Share(int(n), int(n) / total) for name, n in zip(REGIMES, counts, strict=True) if n}
