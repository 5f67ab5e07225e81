"""Reports of studies on their results: lines for the screen, tables for pages."""

from collections.abc import Hashable, Iterable, Iterator, Sequence
from itertools import islice

import numpy as np
import xarray as xr

from stickslip.dataset.display import MapAxis

MOST_ROWS = 30  # of a list on the screen


def first(rows: Iterable[str], count: int) -> Iterator[str]:
    """The first of so many rows, and how many more there are."""
    yield from islice(rows, MOST_ROWS)
    if count > MOST_ROWS:
        yield f"... and {count - MOST_ROWS} more"


def attributes(ds: xr.Dataset, **labels: str) -> Iterator[str]:
    """Attributes, each behind its label."""
    return (f"{label:8} {ds.attrs[name]}" for label, name in labels.items())


def axes_over(ds: xr.Dataset, dims: Sequence[Hashable]) -> list[MapAxis]:
    """The axes of some dimensions, their values as plain text."""
    return [MapAxis(ds, dim, plain=True) for dim in dims]


def parts_over(ds: xr.Dataset, dims: Sequence[Hashable]) -> Iterator[tuple[tuple[int, ...], xr.Dataset]]:
    """Each place along some dimensions, and the dataset there."""
    for place in np.ndindex(tuple(ds.sizes[dim] for dim in dims)):
        yield place, ds.isel(dict(zip(dims, place, strict=True)))


def cells_over(ds: xr.Dataset, dims: Sequence[Hashable]) -> Iterator[tuple[str, xr.Dataset]]:
    """Each cell over some dimensions: its place as the beginning of a line of text, and its part of the dataset."""
    axes = axes_over(ds, dims)
    for place, part in parts_over(ds, dims):
        where = ", ".join(axis.heading(i) for axis, i in zip(axes, place, strict=True))
        yield f"{where}: " if where else "", part
