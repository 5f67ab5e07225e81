"""Borders on screen, one a line."""

from __future__ import annotations

from collections.abc import Iterator
from itertools import islice
from typing import TYPE_CHECKING

import click

if TYPE_CHECKING:
    import xarray as xr

_MOST_ROWS = 30


def show_borders(ds: xr.Dataset) -> None:
    """The first borders, how many there are, and what can be missed."""
    for row in islice(_rows(ds), _MOST_ROWS):
        click.echo(row)
    found = int(ds["border"].notnull().sum())
    if found > _MOST_ROWS:
        click.echo(f"... and {found - _MOST_ROWS} more")
    click.echo(f"borders  {ds.attrs['border_found']}")
    click.echo(f"scan     {ds.attrs['border_scan']}")


def _rows(ds: xr.Dataset) -> Iterator[str]:
    """A line of text per border."""
    import numpy as np

    from stickslip.dataset.axis import MapAxis
    from stickslip.vocabulary import units
    from stickslip.vocabulary.flags import METHODS, REGIMES

    axes = [MapAxis(ds, dim, plain=True) for dim in ds["border"].dims[:-1]]
    unit = units.spelled(ds["border"].attrs["units"])
    for place in np.argwhere(ds["border"].notnull().values):
        one = ds.isel(dict(zip(ds["border"].dims, map(int, place), strict=True)))
        where = ", ".join(axis.heading(int(i)) for axis, i in zip(axes, place, strict=False))
        below, above = (REGIMES[int(one[name])] for name in ("regime_below", "regime_above"))
        value = f"{float(one['border']):.12g} {unit}".rstrip()
        how = f"width {float(one['border_width']):.2g}, by {METHODS[int(one['method'])]}"
        yield f"{where}{': ' if where else ''}{below} -> {above} at {value} ({how})"
