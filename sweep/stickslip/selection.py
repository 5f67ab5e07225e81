"""Which part of a dataset is drawn: dimensions fixed at a place, axes that rise."""

from __future__ import annotations

import math
from collections.abc import Hashable, Mapping
from typing import Any

import numpy as np
import xarray as xr


class PlotError(ValueError):
    """This dataset cannot be drawn as asked; the message says what is possible."""


def selected(ds: xr.Dataset, select: Mapping[str, Any]) -> xr.Dataset:
    """The dataset at the given places of some dimensions, which then are scalar coordinates."""
    for dim, wanted in select.items():
        if dim not in ds.dims:
            raise PlotError(f"cannot select {dim!r}; dimensions are {', '.join(map(str, ds.dims))}")
        ds = ds.isel({dim: _position(ds, dim, wanted)})
    return ds


def _position(ds: xr.Dataset, dim: str, wanted: Any) -> int:
    """Where along `dim` the value, label or position `wanted` is."""
    if dim in ds.coords and not _is_numeric(ds, dim):
        labels = [str(label) for label in ds[dim].values]
        if str(wanted) not in labels:
            raise PlotError(f"cannot select {dim}={wanted}; labels are {', '.join(labels)}")
        return labels.index(str(wanted))
    try:
        number = float(wanted)
    except (TypeError, ValueError):
        number = math.nan
    if not math.isfinite(number):
        raise PlotError(f"cannot select {dim}={wanted}; expected a number in SI units")
    if dim in ds.coords:
        return int(np.abs(ds[dim].values - number).argmin())
    if number not in range(ds.sizes[dim]):
        raise PlotError(f"cannot select {dim}={wanted}; positions are 0 to {ds.sizes[dim] - 1}")
    return int(number)


def ascending(ds: xr.Dataset) -> xr.Dataset:
    """Numeric axes sorted, so that cells do not overlap. What rises already is not touched, lazy data stay lazy."""
    for dim in ds.dims:
        if dim in ds.coords and _is_numeric(ds, dim):
            steps = np.diff(ds[dim].values)
            if (steps < 0).all():
                ds = ds.isel({dim: slice(None, None, -1)})
            elif not (steps > 0).all():
                ds = ds.sortby(dim)
    return ds


def _is_numeric(ds: xr.Dataset, dim: Hashable) -> bool:
    return ds[dim].dtype.kind in "fiu"
