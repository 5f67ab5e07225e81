"""Attractors and ramps on screen: a line per cell where they are few, a summary where they are many."""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING, Any

from stickslip.cli import screen

if TYPE_CHECKING:
    import xarray as xr
    from numpy.typing import NDArray

_MOST_ROWS = 30


def show_attractors(ds: xr.Dataset) -> None:
    """Which regimes coexist, how much of the box settles, and what a shock may be."""
    import numpy as np

    share, masks = ds["settling_share"].values, ds["coexisting"].values
    if share.size <= _MOST_ROWS:
        for row in _rows(ds):
            screen.echo(row)
    else:
        for mask, count in zip(*np.unique(masks, return_counts=True), strict=True):
            screen.echo(f"cells    {count:,} with {regimes_in(int(mask)) or 'nothing computed'}")
        if (some := share[np.isfinite(share)]).size:
            screen.echo(f"settling {some.mean():.1%} of the starting states on average")
    screen.echo(f"shares   {ds.attrs['attractors_found']}")
    screen.echo(f"box      displacement {ds.attrs['box_displacement']}, velocity {ds.attrs['box_velocity']}")


def regimes_in(mask: int) -> str:
    """`stick_slip or damped`: the regimes of a mask."""
    from stickslip.vocabulary.flags import REGIMES

    return " or ".join(name for code, name in enumerate(REGIMES) if code and mask >> (code - 1) & 1)


def _rows(ds: xr.Dataset) -> Iterator[str]:
    """A line of text per cell."""
    import numpy as np

    from stickslip.dataset.axis import MapAxis

    dims = ds["settling_share"].dims
    axes = [MapAxis(ds, dim, plain=True) for dim in dims]
    for place in np.ndindex(ds["settling_share"].shape):
        one = ds.isel(dict(zip(dims, place, strict=True)))
        where = ", ".join(axis.heading(i) for axis, i in zip(axes, place, strict=True))
        found = regimes_in(int(one["coexisting"])) or "not computed"
        yield f"{where}{': ' if where else ''}{found}; {_share(one)}; {_shock(one)}"


def _share(one: xr.Dataset) -> str:
    share, error = float(one["settling_share"]), float(one["share_error"])
    low, high = float(one["settling_share_low"]), float(one["settling_share_high"])
    bounds = f", {low:.4g} to {high:.4g} with undecided states" if high > low else ""
    return f"share that settles {share:.6g} ({f'+- {error:.2g}' if error else 'exact'}{bounds})"


def _shock(one: xr.Dataset) -> str:
    import numpy as np

    from stickslip.dataset.display import unit_of

    shock = float(one["critical_shock"])
    if np.isnan(shock):
        return "critical shock unknown"
    if np.isposinf(shock):
        return "no shock ends sliding"
    return f"critical shock {unit_of(one['critical_shock']).text(shock)}" if shock else "any shock ends sliding"


def show_ramp(ds: xr.Dataset) -> None:
    """Where the regime changes on the way up, and on the way down."""
    import numpy as np

    from stickslip.dataset.axis import MapAxis
    from stickslip.dataset.display import displayed

    *dims, _, along = ds["regime"].dims
    axes, (values, unit) = [MapAxis(ds, dim, plain=True) for dim in dims], displayed(ds[along])
    for number, place in enumerate(np.ndindex(tuple(ds.sizes[dim] for dim in dims))):
        if number == _MOST_ROWS:
            return screen.echo("... and more lines; --output FILE.nc keeps them all")
        one = ds["regime"].isel(dict(zip(dims, place, strict=True)))
        where = ", ".join(axis.heading(i) for axis, i in zip(axes, place, strict=True))
        for direction, step in (("up", 1), ("down", -1)):
            changes = _changes(one.sel(direction=direction).values[::step], values[::step], unit)
            screen.echo(f"{where}{': ' if where else ''}{direction:4} {'; '.join(changes)}")


def _changes(codes: NDArray[Any], values: NDArray[Any], unit: str) -> list[str]:
    """`stick_slip -> damped from 0.79 to 0.8 m/s` for each change on the way."""
    import numpy as np

    from stickslip.vocabulary.flags import REGIMES

    found = [
        f"{REGIMES[codes[i]]} -> {REGIMES[codes[i + 1]]} from {values[i]:.6g} to {values[i + 1]:.6g} {unit}".rstrip()
        for i in np.flatnonzero(np.diff(codes))
    ]
    return found or [f"{REGIMES[codes[0]]} all the way"]
