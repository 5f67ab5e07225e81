"""`plot`: what is in the file of a result, as a picture or as a page."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from stickslip.cli import params, screen
from stickslip.cli.exits import fail, reports_errors
from stickslip.cli.outputs import PictureOptions, result_figure, save_page

if TYPE_CHECKING:
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
@click.argument("file", type=params.PathOrUrl())
@click.option("--variable", help="Variable to plot.  [default: regime, or what a result is about]")
@click.option(
    "--select", multiple=True, metavar="DIM=VALUE", help="Fix a dimension at the cell with this value, or label."
)
@click.option("--lines", type=params.PathOrUrl(), help="File of borders or contours to draw over the map.")
@click.option("--title", help="Title of the picture.  [default: that of the result, and what is selected]")
@click.option("--size", metavar="WxH", help="Size: '16 cm x 9 cm', '1920 px x 1080 px'.")
@click.option("--dpi", type=click.IntRange(20, 1200), help="Dots per inch of a PNG.  [default: 150]")
@click.option("--units", multiple=True, metavar="NAME=UNIT,...", help="Units to show: 'period=ms, belt_speed=mm/s'.")
@click.option("--log", multiple=True, metavar="NAME,...", help="Logarithmic axes, or colours of a variable.")
@click.option(
    "--limits", multiple=True, metavar="NAME=LOW..HIGH", help="Limits of an axis or of colours: 'period=0.1..2 s'."
)
@click.option(
    "--mark", "marks", multiple=True, metavar="POINT",
    help="Operating point to draw, [LABEL:]NAME=VALUE,...; or a table of them (.csv): a column 'label', and one for "
    "each axis; coloured by their regimes.",
)  # fmt: skip
@click.option(
    "-o",
    "--output",
    type=params.Target("plot", "page"),
    help="Picture to write, .png, .svg or .pdf, or page, .html.  [default: FILE.png, with the names of --variable and "
    "--select in it, in this folder if FILE is a URL]",
)
@reports_errors
def plot(
    file: Location, variable: str | None, select: tuple[str, ...], lines: Location | None,
    output: Path | None, **options: Any,
) -> None:  # fmt: skip
    """Plot a result, whatever its kind.

    Numbers are shown in the units in which the configuration was written; the file is SI.
    """
    from stickslip import plots
    from stickslip.dataset import selection
    from stickslip.dataset.summary import why_absent
    from stickslip.errors import PlotError
    from stickslip.files import reading
    from stickslip.plots.marks import law_with_theory

    ds, picture = reading.look_into(file), PictureOptions(**options)
    of_pictures = {"--variable": variable, "--select": select, "--lines": lines, "--size": picture.size,
                   "--dpi": picture.dpi}  # fmt: skip
    try:
        if output is not None and output.suffix.lower() in params.PAGES:
            if given := [name for name, value in of_pictures.items() if value]:
                fail(f"{', '.join(given)}: for a picture; a page shows the whole result")
            return save_page(ds, output, picture)
        places = params.pairs(select) if "time" not in ds.dims else {}
        ds = picture.with_units(ds)
        if plots.is_over_map(ds):
            figure = result_figure(ds, picture)
        else:
            over = None if lines is None else reading.look_into(lines)
            figure = plots.plot_result(
                ds, variable, select=places, title=picture.title, look=picture.look(ds), lines=over
            )
            for point in selection.points_taken(ds, {name: at for name, at in places.items() if name != "state"}):
                screen.row("drawn", point)
        stem = (file if isinstance(file, Path) else Path(file.name)).with_suffix("")  # in this folder if behind a URL
        target = output or plots.name_of(stem, None if variable == plots.subject(ds) else variable, places)
        plots.save(figure, target, picture.dpi or plots.DPI, picture.size)
    except PlotError as error:
        fail(f"{file}: {error}")
    of_cells = plots.kind_of(ds) in ("map", "refine") and law_with_theory(ds) is None  # borders, where they are drawn
    if of_cells and (absent := why_absent(ds, "damping_ratio")):
        screen.notice(f"{file}: no borders of linear theory are drawn: the map {absent}")
    screen.row("plot", target)
