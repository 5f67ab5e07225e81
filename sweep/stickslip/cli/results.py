"""`plot`: what is in the file of a result."""

from __future__ import annotations

from pathlib import Path

import click

from stickslip.cli.common import check_picture, fail, reports_wrong_input


@click.command(
    epilog="""\b
Examples:
  stickslip plot quickstart.nc
  stickslip plot quickstart.nc --variable spring_force_max -o force.svg
  stickslip plot map.nc --select damping=0.1"""
)
@click.argument("file", type=click.Path(path_type=Path))
@click.option("--variable", default="regime", show_default=True, help="What to draw.")
@click.option("--select", multiple=True, metavar="DIM=VALUE", help="Fix a dimension: nearest point, or label.")
@click.option("--no-borders", is_flag=True, help="Leave out the borders of linear theory.")
@click.option("-o", "--output", type=click.Path(path_type=Path), help="Picture to draw.  [default: FILE.png]")
@reports_wrong_input
def plot(file: Path, variable: str, select: tuple[str, ...], no_borders: bool, output: Path | None) -> None:
    """Draw a result: a map, or a trajectory."""
    from stickslip import plots, store

    ds = store.open(file)
    target = output or file.with_suffix(".png")
    check_picture(target)
    try:
        if "time" in ds.dims:
            figure = plots.plot_trace(ds)
        else:
            figure = plots.plot_map(ds, variable, select=_pairs(select), borders=not no_borders)
    except plots.PlotError as error:
        fail(f"{file}: {error}")
    plots.save(figure, target)
    click.echo(f"picture  {target}")


def _pairs(texts: tuple[str, ...]) -> dict[str, str]:
    """NAME=VALUE texts as a mapping."""
    pairs = {}
    for text in texts:
        name, equals, value = text.partition("=")
        if not equals:
            fail(f"got {text!r}, expected NAME=VALUE")
        pairs[name.strip()] = value.strip()
    return pairs
