"""`article`: the figures of the article."""

from __future__ import annotations

from pathlib import Path

import click

from stickslip.cli import screen
from stickslip.cli.common import Target, fail, prepare_kernels, reports_wrong_input


@click.command()
@click.argument("figures", nargs=-1)
@click.option("-o", "--output", type=Target("folder"), default="article", show_default=True, help="Folder.")
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
        made = make(figures, output, progress=lambda name: screen.echo(f"{name} ...", err=True))
    except UnknownFigureError as error:
        fail(error)
    for figure in made:
        screen.echo(f"{figure.name:8} {figure.plot}  {figure.data}")
