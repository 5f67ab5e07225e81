"""What the command says of a result: a map, borders, ...; each kind knows what is worth a line, and how it is drawn."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING

import click

from stickslip.cli import screen

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.figure import Figure

    from stickslip.cli.backdrop import Extras
    from stickslip.cli.screen import Done


def show(ds: xr.Dataset, done: Done, output: Path | None, plot: Path | None) -> None:
    """The summary a run ends with: what came out, how long it took, and the files."""
    if is_searched(ds):
        show_searched(ds)
    elif "probability" in ds:
        from stickslip.cli.probability_rows import show_probabilities

        show_probabilities(ds)
    else:
        screen.show_map(ds, output)
    if "audit" in ds.attrs:
        click.echo(f"refined  {ds.attrs['refine_cells_computed']:,} cells computed for {ds['regime'].size:,}")
        click.echo(f"audit    {ds.attrs['audit']}")
    click.echo(screen.rate(done))
    if output is not None:
        name = "map" if "regime" in ds else "written"
        click.echo(f"{name:8} {output} ({screen.size_of(output)})")
    if plot is not None:
        click.echo(f"plot     {plot}")


def is_searched(ds: xr.Dataset) -> bool:
    """Whether a result is no map: borders, contours or margins."""
    return any(name in ds.attrs for name in ("border_found", "contour_found", "margin_found"))


def show_searched(ds: xr.Dataset) -> None:
    """What was found in a result that `is_searched`."""
    from stickslip.cli import border_rows

    if "border_found" in ds.attrs:
        border_rows.show_borders(ds)
    elif "contour_found" in ds.attrs:
        border_rows.show_contours(ds)
    else:
        border_rows.show_margins(ds)


def is_drawn(ds: xr.Dataset) -> bool:
    """Whether there is a plot of this result: borders of single lines are no lines to draw."""
    if "border" in ds:
        return ds["border"].ndim > 1 and "configuration" in ds.attrs and "cell" not in ds.dims
    return "geometry" in ds or "probability" in ds or ("regime" in ds and ds["regime"].ndim > 0)


def figure(ds: xr.Dataset, extras: Extras | None = None) -> Figure:
    """The plot of a result that `is_drawn`: a map; of borders, the map they lie in, with them over it."""
    from stickslip import plots
    from stickslip.cli.backdrop import Extras

    if is_searched(ds) and "margin_found" not in ds.attrs:
        return plots.plot_map((extras or Extras()).map_behind(ds), lines=ds, title=str(ds.attrs.get("title", "")))
    drawn: Callable[[xr.Dataset], Figure] = plots.plot_probability if "probability" in ds else plots.plot_map
    return drawn(ds)
