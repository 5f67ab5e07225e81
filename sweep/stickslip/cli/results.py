"""`inspect` and `export`: a result in words, its cells one by one, and as a table."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from stickslip.cli import params, screen
from stickslip.cli.outputs import PictureOptions, result_figure, save_page, save_table, show_result
from stickslip.cli.screen import JSON, Answer, fail, is_for_programs, reports_errors
from stickslip.vocabulary.quantities import STATUS_MESSAGES, flag_label

if TYPE_CHECKING:
    from stickslip.files.locations import Location


@click.command(
    epilog="""\b
Examples:
  stickslip inspect map.nc
  stickslip inspect map.nc --regime sustained --limit 5
  stickslip inspect map.zarr --status step_limit"""
)
@click.argument("file", type=params.PathOrUrl())
@click.option("--regime", "regimes", multiple=True, metavar="NAME", help="List cells of this regime.")
@click.option("--status", "statuses", multiple=True, metavar="NAME", help="List cells of this status.")
@click.option("--limit", type=click.IntRange(0), default=20, show_default=True, help="Largest number of cells to list.")
@JSON
@reports_errors
def inspect(file: Location, regimes: tuple[str, ...], statuses: tuple[str, ...], limit: int) -> Answer:
    """Count the cells of a result, and list problem cells.

    These are cells that failed, are unresolved or were not computed, unless --regime or --status say which to list.
    Each is listed with its place; `stickslip simulate FILE --at NAME=VALUE` computes the motion there. Of results that
    are no maps it says what was found.
    """
    from stickslip.config.grid import quantity_of
    from stickslip.config.studies import ReportTable, result_class
    from stickslip.dataset import coarse as inspection
    from stickslip.dataset.display import MapAxis
    from stickslip.files import reading

    ds = reading.look_into(file)
    if (kind := result_class(ds)) is not None:
        answer = dict(kind.answer(ds)) if is_for_programs() else {}
        if regimes or statuses or is_for_programs() and not answer:
            fail(f"{file}: --regime, --status and --json tell of the cells of a map; this file holds none")
        show_result(ds)
        return answer
    if "regime" not in ds.data_vars:
        fail(f"{file}: holds no regimes, expected a map or a list of cells")
    survey = inspection.survey(ds, regimes=regimes, statuses=statuses, limit=limit)
    total = sum(survey.counts.values())
    counts = [(flag_label(regime), ": ".join(filter(None, (status, STATUS_MESSAGES.get(status)))), f"{cells:,}",
               screen.share_text(cells / total)) for (regime, status), cells in survey.counts.items()]  # fmt: skip
    screen.echo(ReportTable("", ("regime", "status"), ("cells", "share"), counts).text())
    what = "such cells" if regimes or statuses else "cells failed, are unresolved or were not computed"
    first = f"The first {len(survey.cells):,} of " if 0 < len(survey.cells) < survey.wanted else ""
    screen.echo(f"\n{first}{survey.wanted:,} {what}{':' if survey.cells else ''}")
    if survey.cells:
        axes = [MapAxis(ds, dim, plain=True) for dim in ds["regime"].dims]
        names = (quantity_of(str(axis.dim)).removesuffix("_case") for axis in axes)  # as --at takes them
        rows = [
            (str(cell.number), *(axis.text(cell.position[str(axis.dim)]) for axis in axes), flag_label(cell.regime),
             cell.status) for cell in survey.cells
        ]  # fmt: skip
        screen.echo(ReportTable("", ("cell", *names, "regime", "status"), (), rows).text())
    return {
        "file": str(file),
        "cells": total,
        "counts": [
            {"regime": regime, "status": status, "cells": cells} for (regime, status), cells in survey.counts.items()
        ],
        "wanted": survey.wanted,
        "listed": [cell._asdict() for cell in survey.cells],
    }


@click.command(
    epilog="""\b
Examples:
  stickslip export quickstart.nc -o quickstart.csv
  stickslip export quickstart.nc --variable regime --variable period -o periods.xlsx
  stickslip export map.nc --select stiffness="5 N/mm" -o line.csv"""
)
@click.argument("file", type=params.PathOrUrl())
@click.option("-o", "--output", type=params.Target("table"), help="Table to write, .csv or .xlsx.  [default: FILE.csv]")
@click.option("--variable", "variables", multiple=True, metavar="NAME", help="Variable to write.  [default: all]")
@click.option(
    "--select", multiple=True, metavar="DIM=VALUE", help="Take only cells with this value, or label, of a dimension."
)
@reports_errors
def export(file: Location, output: Path | None, variables: tuple[str, ...], select: tuple[str, ...]) -> None:
    """Write a result as a table, CSV or Excel: one row a cell.

    Headings carry units, flags are words, what is not defined is empty. FILE may be larger than memory. A sheet of
    Excel holds 1,048,575 cells. (pip install "stickslip[excel]")
    """
    from stickslip.dataset import selection
    from stickslip.errors import PlotError
    from stickslip.files import reading

    target = output or params.checked(Path(file.name).with_suffix(".csv"), "table")
    with reading.look_into(file) as ds:
        places = params.pairs(select)
        try:
            part = selection.selected(ds, places)[0] if places else ds
        except PlotError as error:
            fail(f"{file}: {error}")
        save_table(part, target, variables)


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
    "each axis.",
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
    from stickslip.errors import PlotError
    from stickslip.files import reading

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
        stem = (file if isinstance(file, Path) else Path(file.name)).with_suffix("")  # in this folder if behind a URL
        target = output or plots.name_of(stem, None if variable == plots.subject(ds) else variable, places)
        plots.save(figure, target, picture.dpi or plots.DPI, picture.size)
    except PlotError as error:
        fail(f"{file}: {error}")
    screen.row("plot", target)
