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

    from stickslip.cli.screen import Done


def show(ds: xr.Dataset, done: Done, output: Path | None, plot: Path | None) -> None:
    """The summary a run ends with: what came out, how long it took, and the files."""
    if "border" in ds:
        from stickslip.cli.border_rows import show_borders

        show_borders(ds)
    elif "settling_share" in ds:
        from stickslip.cli.attractor_rows import show_attractors

        show_attractors(ds)
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


def is_drawn(ds: xr.Dataset) -> bool:
    """Whether there is a plot of this result."""
    return "probability" in ds or any(name in ds and ds[name].ndim > 0 for name in ("regime", "settling_share"))


def figure(ds: xr.Dataset) -> Figure:
    """The plot of a result that `is_drawn`."""
    from stickslip import plots

    if "settling_share" in ds:
        return plots.plot_attractors(ds) if ds["settling_share"].ndim == 1 else plots.plot_map(ds, "settling_share")
    drawn: Callable[[xr.Dataset], Figure] = plots.plot_probability if "probability" in ds else plots.plot_map
    return drawn(ds)
