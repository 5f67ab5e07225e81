"""What the command says of a result: a map, borders; each kind knows what is worth a line, and how it is drawn."""

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
    else:
        screen.show_map(ds, output)
    click.echo(screen.rate(done))
    if output is not None:
        name = "map" if "regime" in ds else "written"
        click.echo(f"{name:8} {output} ({screen.size_of(output)})")
    if plot is not None:
        click.echo(f"plot     {plot}")


def is_drawn(ds: xr.Dataset) -> bool:
    """Whether there is a plot of this result."""
    return "regime" in ds and ds["regime"].ndim > 0


def figure(ds: xr.Dataset) -> Figure:
    """The plot of a result that `is_drawn`."""
    from stickslip import plots

    drawn: Callable[[xr.Dataset], Figure] = plots.plot_map
    return drawn(ds)
