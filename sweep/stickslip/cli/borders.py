"""`border`: where along a parameter the regime changes."""

from __future__ import annotations

from itertools import islice
from pathlib import Path
from typing import TYPE_CHECKING

import click

from stickslip.cli import screen
from stickslip.cli.common import CONFIG, fail, incomplete, prepare_kernels, reports_wrong_input

if TYPE_CHECKING:
    from collections.abc import Iterator

    import xarray as xr

_MOST_ROWS = 30


@click.command(
    epilog="""\b
Examples:
  stickslip border configs/quickstart.yaml --along belt_speed
  stickslip border configs/quickstart.yaml --along belt_speed --between 1 "1.2 m/s" -o top.nc"""
)
@CONFIG
@click.option("--along", required=True, metavar="NAME", help="Parameter to search along.")
@click.option(
    "--between", nargs=2, metavar="LOW HIGH", help="Range to search: SI, or with units.  [default: that of the axis]"
)
@click.option("--tolerance", type=float, default=1e-9, show_default=True, help="Width to stop at, over the border.")
@click.option("--scan", type=int, default=64, show_default=True, help="Places of each line to look at first.")
@click.option("-o", "--output", type=click.Path(path_type=Path), help="File to write, .nc or .zarr.")
@reports_wrong_input
def border(
    config: Path, along: str, between: tuple[str, str] | None, tolerance: float, scan: int, output: Path | None
) -> None:
    """Find where along a parameter the regime changes.

    The other axes of CONFIG are the lines that are searched.
    """
    from stickslip import api
    from stickslip.config.reader import load_config
    from stickslip.errors import Interrupted
    from stickslip.files import writing

    one = load_config(config)
    if output is not None:
        writing.check_writable(output)
    ends = _ends(along, between) if between else None
    prepare_kernels(one.friction.law)
    try:
        ds = api.border(one, along, ends, tolerance, scan=scan)
    except Interrupted as error:
        incomplete(error)
    except (TypeError, ValueError) as error:  # bad input, said before anything is computed
        fail(f"{config}: {error}")
    for row in islice(_rows(ds), _MOST_ROWS):
        click.echo(row)
    found = int(ds["border"].notnull().sum())
    if found > _MOST_ROWS:
        click.echo(f"... and {found - _MOST_ROWS} more" + ("" if output else "; --output FILE.nc keeps them all"))
    click.echo(f"borders  {ds.attrs['border_found']}")
    click.echo(f"scan     {ds.attrs['border_scan']}")
    if output is not None:
        writing.write(ds, output)
        click.echo(f"written  {output} ({screen.size_of(output)})")


def _ends(along: str, between: tuple[str, str]) -> tuple[float, float]:
    """Both ends in SI."""
    from stickslip.config.pick import value_of

    low, high = (value_of(along, end, "--between") for end in between)
    return low, high


def _rows(ds: xr.Dataset) -> Iterator[str]:
    """A line of text per border."""
    import numpy as np

    from stickslip.dataset.axis import MapAxis
    from stickslip.vocabulary import units
    from stickslip.vocabulary.flags import REGIMES

    axes = [MapAxis(ds, dim, plain=True) for dim in ds["border"].dims[:-1]]
    unit = units.spelled(ds["border"].attrs["units"])
    for place in np.argwhere(ds["border"].notnull().values):
        one = ds.isel(dict(zip(ds["border"].dims, map(int, place), strict=True)))
        where = ", ".join(axis.heading(int(i)) for axis, i in zip(axes, place, strict=False))
        below, above = (REGIMES[int(one[name])] for name in ("regime_below", "regime_above"))
        value = f"{float(one['border']):.12g} {unit}".rstrip()
        yield f"{where}{': ' if where else ''}{below} -> {above} at {value} (width {float(one['border_width']):.2g})"
