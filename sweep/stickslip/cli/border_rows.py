"""Borders on screen, one a line."""

from __future__ import annotations

from collections.abc import Iterator
from itertools import islice
from typing import TYPE_CHECKING

from stickslip.cli import screen

if TYPE_CHECKING:
    import xarray as xr

    from stickslip.dataset.display import Unit

_MOST_ROWS = 30


def show_borders(ds: xr.Dataset) -> None:
    """The first borders, how many there are, and what can be missed."""
    for row in islice(_rows(ds), _MOST_ROWS):
        screen.echo(row)
    found = ds["border"].notnull()
    rows = int(found.sum())
    if "regime_throughout" in ds:
        rows += int((ds["regime_throughout"] != 0).sum())
    if rows > _MOST_ROWS:
        screen.echo(f"... and {rows - _MOST_ROWS} more")
    screen.echo(f"borders  {ds.attrs['border_found']}")
    screen.echo(f"scan     {ds.attrs['border_scan']}")


def _rows(ds: xr.Dataset) -> Iterator[str]:
    """A line of text per border, or for a line without any."""
    import numpy as np

    from stickslip.dataset.axis import MapAxis
    from stickslip.dataset.display import unit_of
    from stickslip.vocabulary.flags import REGIMES

    axes = [MapAxis(ds, dim, plain=True) for dim in ds["border"].dims[:-1]]
    unit = unit_of(ds["border"])
    found = ds["border"].notnull().values
    without = np.asarray(~found.any(axis=-1))
    for place in np.ndindex(without.shape):
        one = ds.isel(dict(zip(ds["border"].dims, place, strict=False)))
        named = ", ".join(axis.heading(i) for axis, i in zip(axes, place, strict=True))
        where = f"{named}: " if named else ""
        if without[place]:
            if code := int(one["regime_throughout"]) if "regime_throughout" in one else 0:
                yield f"{where}{REGIMES[code]} throughout, no border"
            continue
        for crossing in np.flatnonzero(found[place]):
            yield where + _border(one.isel(crossing=crossing), unit)


def _border(one: xr.Dataset, unit: Unit) -> str:
    """One border: the regimes on either side, where it is, and how it was found."""
    from stickslip.vocabulary.flags import METHODS, REGIMES

    below, above = (REGIMES[int(one[name])] for name in ("regime_below", "regime_above"))
    how = f"width {unit.of(float(one['border_width'])):.2g}, by {METHODS[int(one['method'])]}"
    return f"{below} -> {above} at {unit.text(float(one['border']), 12)} ({how})"


def show_contours(ds: xr.Dataset) -> None:
    """The first lines, how many there are, and what can be missed."""
    for row in islice(_lines(ds), _MOST_ROWS):
        screen.echo(row)
    if ds.sizes["line"] > _MOST_ROWS:
        screen.echo(f"... and {ds.sizes['line'] - _MOST_ROWS} more")
    screen.echo(f"lines    {ds.attrs['contour_found']}")
    screen.echo(f"grid     {ds.attrs['contour_grid']}")
    screen.echo(f"scan     {ds.attrs['contour_scan']}")
    screen.echo(f"looked   at {ds.attrs['contour_looked_at']}")


def _lines(ds: xr.Dataset) -> Iterator[str]:
    """A line of text per line."""
    from stickslip.dataset.display import unit_of
    from stickslip.dataset.polylines import plane_names, polylines
    from stickslip.vocabulary.flags import REGIMES

    names = plane_names(ds)
    units = [unit_of(ds[name]) for name in names]
    beside = [name for name, one in ds.coords.items() if one.dims == ("line",)]
    for number, line in enumerate(polylines(ds)):
        where = ", ".join(f"{name} = {ds[name].values[number]}" for name in beside)
        ranges = ", ".join(
            f"{name} {unit.of(values.min()):.6g} to {unit.text(values.max())}"
            for name, values, unit in zip(names, (line.x, line.y), units, strict=True)
        )
        kind = "loop" if line.closed else "line"
        sides = f"{REGIMES[line.left]} | {REGIMES[line.right]}"
        yield f"{where}{': ' if where else ''}{sides}: {kind} of {len(line.x)} points, {ranges}"


def show_margins(ds: xr.Dataset) -> None:
    """Of how many cells which parameter leads to a border, and how far it has to go."""
    import numpy as np
    from rich.table import Table

    from stickslip.cli import screen

    table = Table("parameter", box=None, pad_edge=False, header_style="bold")
    for name in ("cells with a border", "nearest", "median", "farthest"):
        table.add_column(name, justify="right")
    for name in (str(one).removeprefix("margin_") for one in ds.data_vars if str(one).startswith("margin_")):
        ratio, margin = ds[f"ratio_{name}"].values.ravel(), ds[f"margin_{name}"].values.ravel()
        by_factor = bool(np.isfinite(ratio).any())
        sizes = np.sort(np.exp(np.abs(np.log(ratio[ratio > 0]))) if by_factor else np.abs(margin[~np.isnan(margin)]))
        spelled = [f"x {one:.3g}" if by_factor else f"{one:.3g}" for one in sizes]
        told = [spelled[0], spelled[len(spelled) // 2], spelled[-1]] if spelled else ["-"] * 3
        table.add_row(name, f"{np.count_nonzero(~np.isnan(margin)):,} of {margin.size:,}", *told)
    screen.print_table(table)
    screen.echo(f"found    {ds.attrs['margin_found']}")
    screen.echo(f"within   {ds.attrs['margin_within']}")
    screen.echo(f"scan     {ds.attrs['margin_scan']}")
