"""`fit` and `article`: measured points, and the figures of the article."""

from __future__ import annotations

from pathlib import Path

import click

from stickslip.cli.common import fail, prepare_kernels, reports_wrong_input


@click.command(
    epilog="""\b
Examples:
  stickslip fit measured.csv                    # columns: speed [mm/s], mu
  stickslip fit bare.csv --unit mm/s            # columns: speed, mu
  stickslip fit greaseA.csv greaseB.csv --at "5 min"   # columns: time [s], mu"""
)
@click.argument("files", type=click.Path(path_type=Path), nargs=-1, required=True)
@click.option(
    "--at", default="300", metavar="TIME", show_default=True, help="Hold time at which lubricants are ranked."
)
@click.option("--unit", help="Of the speeds or times, such as mm/s, in files whose header names none.  [default: SI]")
@reports_wrong_input
def fit(files: tuple[Path, ...], at: str, unit: str | None) -> None:
    """Fit friction curves, or ageing, to measured points.

    Points of (speed, mu) give a1 to a4 of the Stribeck curve, points of (time, mu) the growth of static friction with
    the waiting time (hold time); several files of the latter are ranked. The header of each file names columns and
    units.
    """
    from stickslip.config.pick import seconds
    from stickslip.fit.described import describe_ageing, describe_curve, describe_ranking, fit_points

    fits = {file.stem: fit_points(file, unit) for file in files}
    for name, found in fits.items():
        click.echo(f"{name}\n{describe_curve(found.curve) if found.curve else describe_ageing(found.ageing)}\n")
    ageing = {name: found.ageing for name, found in fits.items() if found.ageing}
    if len(ageing) > 1:
        click.echo(describe_ranking(ageing, seconds(at)))


@click.command()
@click.argument("figures", nargs=-1)
@click.option("-o", "--output", type=click.Path(path_type=Path), default="article", show_default=True, help="Folder.")
@reports_wrong_input
def article(figures: tuple[str, ...], output: Path) -> None:
    """Reproduce the figures of the article.

    Writes a plot and a netCDF file for each FIGURE (fig2 to fig11, fig19, eq3, eq3_box; all unless given), and
    says what was found.
    """
    from stickslip.article import make
    from stickslip.errors import UnknownFigureError

    prepare_kernels("stribeck")
    prepare_kernels("stribeck", signals=True)  # trajectories
    try:
        made = make(figures, output, progress=lambda name: click.echo(f"{name} ...", err=True))
    except UnknownFigureError as error:
        fail(error)
    for figure in made:
        click.echo(f"{figure.name:8} {figure.plot}  {figure.data}")
