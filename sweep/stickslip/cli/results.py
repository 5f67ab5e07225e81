"""`plot`: what is in the file of a result."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import click

from stickslip.cli.common import check_plot, fail, reports_wrong_input

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.figure import Figure


@click.command(
    epilog="""\b
Examples:
  stickslip plot quickstart.nc
  stickslip plot quickstart.nc --variable spring_force_max -o force.svg
  stickslip plot map.nc --select damping=0.1 --select stiffness="5 N/mm\""""
)
@click.argument("file", type=click.Path(path_type=Path))
@click.option("--variable", help="Variable to plot.  [default: regime; of attractors and ramps, what they are about]")
@click.option(
    "--select", multiple=True, metavar="DIM=VALUE", help="Fix a dimension at the cell with this value, or label."
)
@click.option("--no-borders", is_flag=True, help="Leave out the borders of linear theory.")
@click.option(
    "-o",
    "--output",
    type=click.Path(path_type=Path),
    help="Plot to write.  [default: FILE.png, FILE-VARIABLE.png for other variables than regime]",
)
@reports_wrong_input
def plot(file: Path, variable: str | None, select: tuple[str, ...], no_borders: bool, output: Path | None) -> None:
    """Plot a result: a map, probabilities, a trajectory, attractors, or a ramp."""
    from stickslip import plots
    from stickslip.dataset import select as selection
    from stickslip.errors import PlotError
    from stickslip.files import reading

    ds = reading.open(file)
    is_map = "time" not in ds.dims
    target = output or _plot_of(file, variable if is_map else None)
    check_plot(target)
    places = _pairs(select) if is_map else {}
    try:
        figure = _drawn(ds, variable, places, not no_borders)
    except PlotError as error:
        fail(f"{file}: {error}")
    for point in selection.told(ds, places):
        click.echo(f"drawn    {point}")
    plots.save(figure, target)
    click.echo(f"plot     {target}")


def _drawn(ds: xr.Dataset, variable: str | None, places: dict[str, str], borders: bool) -> Figure:
    """The plot that suits the kind of result."""
    from stickslip import plots
    from stickslip.dataset import select as selection

    if "time" in ds.dims:
        return plots.plot_trace(ds)
    if "direction" in ds.dims:
        return plots.plot_ramp(ds, variable or "velocity_amplitude", select=places)
    if "probability" in ds and variable is None:
        state = places.pop("state", "stick_slip")
        return plots.plot_probability(selection.selected(ds, places)[0], state)
    if "settling_share" in ds and variable is None:
        left = set(ds["settling_share"].dims) - set(places)
        if len(left) == 1:
            return plots.plot_attractors(ds, select=places)
        variable = "settling_share"
    return plots.plot_map(ds, variable or "regime", select=places, borders=borders)


def _plot_of(file: Path, variable: str | None) -> Path:
    """FILE.png for a trajectory and for regimes, the plot a run writes; for other variables one beside it."""
    if variable in (None, "regime"):
        return file.with_suffix(".png")
    return file.with_name(f"{file.stem}-{variable}.png")


def _pairs(texts: tuple[str, ...]) -> dict[str, str]:
    """NAME=VALUE texts as a mapping."""
    pairs = {}
    for text in texts:
        name, equals, value = text.partition("=")
        if not equals:
            fail(f"got {text!r}, expected NAME=VALUE")
        pairs[name.strip()] = value.strip()
    return pairs
