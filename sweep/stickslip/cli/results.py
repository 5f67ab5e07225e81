"""`plot`: what is in the file of a result."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import click

from stickslip.cli import shown
from stickslip.cli.backdrop import MAP, Extras
from stickslip.cli.common import WHERE, check_plot, fail, prepare_kernels, reports_wrong_input

if TYPE_CHECKING:
    import xarray as xr

    from stickslip.files.locations import Location


@click.command(
    epilog="""\b
Examples:
  stickslip plot quickstart.nc
  stickslip plot quickstart.nc --variable spring_force_max -o force.svg
  stickslip plot map.nc --lines borders.nc -o map-with-borders.png
  stickslip plot map.nc --select damping=0.1 --select stiffness="5 N/mm\""""
)
@click.argument("file", type=WHERE)
@click.option("--variable", help="Variable to plot.  [default: regime, or what a result is about]")
@click.option(
    "--select", multiple=True, metavar="DIM=VALUE", help="Fix a dimension at the cell with this value, or label."
)
@click.option("--lines", type=WHERE, help="File of borders or contours to draw over the map.")
@MAP
@click.option("--no-borders", is_flag=True, help="Leave out the borders of linear theory.")
@click.option(
    "-o",
    "--output",
    type=click.Path(path_type=Path),
    help="Plot to write.  [default: FILE.png, FILE-VARIABLE.png for other variables than regime; of a URL, here]",
)
@reports_wrong_input
def plot(
    file: Location, variable: str | None, select: tuple[str, ...], lines: Location | None,
    map_file: Location | None,    no_borders: bool, output: Path | None,
) -> None:  # fmt: skip
    """Plot a result, whatever its kind."""
    from stickslip import plots
    from stickslip.dataset import select as selection
    from stickslip.dataset.kept import why_absent
    from stickslip.errors import PlotError
    from stickslip.files import reading

    ds = reading.look_into(file)
    given, variable = variable, variable or ("settling_share" if "settling_share" in ds else "regime")
    of_line = "settling_share" in ds and given is None
    if shown.is_over_map(ds):
        return _plot_borders(ds, file, output or _here(file).with_suffix(".png"), map_file)
    is_map = "time" not in ds.dims
    target = output or _plot_of(_here(file), variable if is_map else None)
    check_plot(target)
    places = _pairs(select) if is_map else {}
    try:
        if "probability" in ds and variable == "regime":
            state = places.pop("state", "stick_slip")
            figure = plots.plot_probability(selection.selected(ds, places)[0], state)
        elif "direction" in ds.dims:
            figure = plots.plot_ramp(ds, given or "velocity_amplitude", select=places)
        elif of_line and len(set(ds["settling_share"].dims) - set(places)) == 1:
            figure = plots.plot_attractors(ds, select=places)
        elif is_map:
            over = None if lines is None else reading.look_into(lines)
            figure = plots.plot_map(ds, variable, select=places, borders=not no_borders, lines=over)
        else:
            figure = plots.plot_trace(ds)
    except PlotError as error:
        fail(f"{file}: {error}")
    if not no_borders and (absent := why_absent(ds, "damping_ratio")):
        click.echo(f"{file}: no borders of linear theory are drawn: the map {absent}", err=True)
    for point in selection.told(ds, places):
        click.echo(f"drawn    {point}")
    plots.save(figure, target)
    click.echo(f"plot     {target}")


def _plot_borders(ds: xr.Dataset, file: Location, target: Path, map_file: Location | None) -> None:
    """Borders over the map they lie in: that of a file, or a coarse one that is computed."""
    from stickslip import plots
    from stickslip.config.reader import parse_config
    from stickslip.errors import PlotError

    check_plot(target)
    if map_file is None:
        prepare_kernels(parse_config(str(ds.attrs["configuration"]), str(file)).friction.law)
    try:
        plots.save(shown.figure(ds, Extras(map_file)), target)
    except PlotError as error:
        fail(f"{file}: {error}")
    click.echo(f"plot     {target}")


def _here(file: Location) -> Path:
    """The file, or its name in this folder if it is behind a URL."""
    return file if isinstance(file, Path) else Path(file.name)


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
