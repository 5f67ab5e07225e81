"""`plot`: what is in the file of a result, as a picture or as a page."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from stickslip.cli import screen, shown
from stickslip.cli.backdrop import MAP, Extras
from stickslip.cli.common import PAGES, WHERE, Target, fail, pairs, prepare_kernels, reports_wrong_input
from stickslip.cli.picture import Picture, free_name

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.figure import Figure

    from stickslip.files.locations import Location


@click.command(
    epilog="""\b
Examples:
  stickslip plot quickstart.nc
  stickslip plot quickstart.nc --variable spring_force_max -o force.svg
  stickslip plot map.nc --lines borders.nc -o map-with-borders.png
  stickslip plot map.nc --select damping=0.1 --select stiffness="5 N/mm"
  stickslip plot map.nc --variable period --log period --limits "period=1..100 ms"
  stickslip plot map.nc --mark "pump: stiffness=5 N/mm, belt_speed=20 mm/s" --size "16 cm x 9 cm"
  stickslip plot map.nc -o map.html"""
)
@click.argument("file", type=WHERE)
@click.option("--variable", help="Variable to plot.  [default: regime, or what a result is about]")
@click.option(
    "--select", multiple=True, metavar="DIM=VALUE", help="Fix a dimension at the cell with this value, or label."
)
@click.option("--lines", type=WHERE, help="File of borders or contours to draw over the map.")
@MAP
@click.option("--no-borders", is_flag=True, help="Leave out the borders of linear theory.")
@click.option("--title", help="Title of the picture.  [default: that of the result, and what is selected]")
@click.option("--size", metavar="WxH", help="Size: '16 cm x 9 cm', '1920 px x 1080 px'.")
@click.option("--dpi", type=click.IntRange(20, 1200), help="Dots per inch of a PNG.  [default: 150]")
@click.option("--units", multiple=True, metavar="NAME=UNIT,...", help="Units to show: 'period=ms, belt_speed=mm/s'.")
@click.option("--log", multiple=True, metavar="NAME,...", help="Logarithmic axes, or colours of a variable.")
@click.option(
    "--limits", multiple=True, metavar="NAME=LOW..HIGH", help="Limits of an axis or of colours: 'period=0.1..2 s'."
)
@click.option(
    "--mark", "marks", multiple=True, metavar="[LABEL:]NAME=VALUE,...", help="Operating point to draw; may be repeated."
)
@click.option(
    "--marks", "marks_file", type=click.Path(path_type=Path, exists=True, dir_okay=False), metavar="FILE",
    help="Table of operating points to draw: a column 'label', and one for each axis; coloured by their regimes.",
)  # fmt: skip
@click.option("--no-hatch", is_flag=True, help="Leave out the hatching that tells regimes apart without colours.")
@click.option("--no-note", is_flag=True, help="Leave out the note of what is held fixed.")
@click.option(
    "-o",
    "--output",
    type=Target("plot", "page"),
    help="Picture to write, .png, .svg or .pdf, or page, .html.  [default: FILE.png, with the names of --variable and "
    "--select in it, in this folder if FILE is a URL; a number if another picture has that name]",
)
@reports_wrong_input
def plot(
    file: Location, variable: str | None, select: tuple[str, ...], lines: Location | None,
    map_file: Location | None, no_borders: bool, output: Path | None, **wishes: Any,
) -> None:  # fmt: skip
    """Plot a result, whatever its kind.

    Numbers are shown in the units in which the configuration was written; the file is SI.
    """
    from stickslip import plots
    from stickslip.dataset import selection
    from stickslip.dataset.summary import why_absent
    from stickslip.errors import PlotError
    from stickslip.files import reading

    ds, picture = reading.look_into(file), Picture(**wishes)
    if output is not None and output.suffix.lower() in PAGES:
        of_pictures = {"--variable": variable, "--select": select, "--lines": lines, "--size": picture.size,
                       "--dpi": picture.dpi}  # fmt: skip
        if given := [name for name, value in of_pictures.items() if value]:
            fail(f"{', '.join(given)}: for a picture; a page shows the whole result")
        try:
            return shown.write_page(ds, output, Extras(map_file), picture)
        except PlotError as error:
            fail(f"{file}: {error}")
    places = pairs(select) if "time" not in ds.dims else {}
    try:
        ds = picture.prepared(ds)
        if plots.is_over_map(ds):
            figure = _over_map(ds, file, map_file, picture)
        else:
            over = None if lines is None else reading.look_into(lines)
            figure = plots.plot_result(ds, variable, select=places, title=picture.title, look=picture.look(ds),
                                       borders=not no_borders, lines=over)  # fmt: skip
            told = {name: at for name, at in places.items() if name != "state"}
            for point in selection.points_taken(ds, told):
                screen.echo(f"drawn    {point}")
        request = _words({**picture.request(), "variable": variable, "select": select, "lines": lines,
                          "map": map_file, "no_borders": no_borders})  # fmt: skip
        named = None if variable == plots.subject(ds) else variable
        target = output or free_name(_here(file), named, places, request)
        picture.save(figure, target, request)
    except PlotError as error:
        fail(f"{file}: {error}")
    if not no_borders and "quiet_above" not in ds and (absent := why_absent(ds, "damping_ratio")):
        screen.echo(f"{file}: no borders of linear theory are drawn: the map {absent}", err=True)
    screen.echo(f"plot     {target}")


def _over_map(ds: xr.Dataset, file: Location, map_file: Location | None, picture: Picture) -> Figure:
    """Borders over the map they lie in: that of a file, or a coarse one that is computed."""
    from stickslip.config.reader import parse_config

    if map_file is None:
        prepare_kernels(parse_config(str(ds.attrs["configuration"]), str(file)).friction.law)
    return shown.figure(ds, Extras(map_file), picture)


def _here(file: Location) -> Path:
    """The file without suffix, in this folder if it is behind a URL."""
    return (file if isinstance(file, Path) else Path(file.name)).with_suffix("")


def _words(asked: dict[str, Any]) -> str:
    """What is asked of a picture as one text, nothing for a picture without any wishes."""
    found = {name: ", ".join(value) if isinstance(value, tuple) else value for name, value in asked.items() if value}
    return "; ".join(f"{name}: {value}" for name, value in sorted(found.items()))
