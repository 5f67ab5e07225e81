"""`contours`: where in a plane of two parameters the regime changes, as lines."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import click

from stickslip.cli.backdrop import MAP, Extras
from stickslip.cli.carried import run_request
from stickslip.cli.common import CONFIG, DASK, OUTPUT, QUIET, THREADS, Target, configuration, fail, reports_wrong_input

if TYPE_CHECKING:
    from stickslip.files.locations import Location


@click.command(
    epilog="""\b
Examples:
  stickslip contours configs/quickstart.yaml --plot borders.png
  stickslip contours configs/quickstart.yaml -o borders.nc --csv borders.csv
  stickslip contours configs/start_state.yaml --points 1024 --plot basins.svg"""
)
@CONFIG
@click.option("--over", nargs=2, metavar="Y X", help="The two parameters.  [default: the last two axes]")
@click.option(
    "--between",
    nargs=3,
    multiple=True,
    metavar="NAME LOW HIGH",
    help="Range of a parameter: SI, or with units.  [default: that of the axis]",
)
@click.option("--points", type=int, default=512, show_default=True, help="Points of the grid along either axis.")
@click.option("--tolerance", type=float, default=1e-9, show_default=True, help="Width to stop at, over the border.")
@click.option("--scan", type=int, default=64, show_default=True, help="Points along either axis to look at first.")
@OUTPUT
@click.option("--csv", "table", type=Target("points"), help="Table of the lines to write, .csv.")
@click.option("--plot", type=Target("plot"), help="Plot to write: the lines over a map.")
@MAP
@click.option("--fresh", is_flag=True, help="Replace a file of another search.")
@DASK
@THREADS
@QUIET
@reports_wrong_input
def contours(
    config: Path, over: tuple[str, str] | None, between: tuple[tuple[str, str, str], ...], points: int,
    tolerance: float, scan: int, output: Location | None, table: Path | None, plot: Path | None,
    map_file: Location | None,
    fresh: bool, dask: str | None,
) -> None:  # fmt: skip
    """Follow the borders of regimes in a plane.

    Lines, loops among them, whose points are found one by one to the tolerance. Only the surroundings of a line are
    computed, so that a fine grid costs no more than its lines are long. Other axes of CONFIG become panels.
    """
    from stickslip.config.sections import Output
    from stickslip.config.studies import Contours, alone
    from stickslip.runs.request import Request

    asked = Contours.model_construct(
        axes=over, between=_ranges(between), points=points, tolerance=tolerance, scan=scan, rtol=None
    )
    one = configuration(config).model_copy(
        update={**alone("contours", asked), "output": Output.model_construct(file=None, plot=None)}
    )
    again = ["contours", str(config), "-o", "contours.nc"]
    try:
        run_request(Request(one, output, fresh=fresh, dask=dask), plot, again, Extras(map_file, table))
    except (TypeError, ValueError) as error:  # bad input, said before anything is computed
        fail(f"{config}: {error}")


def _ranges(between: tuple[tuple[str, str, str], ...]) -> dict[str, tuple[float, float]] | None:
    """Ranges in SI by parameter."""
    from stickslip.config.select import value_of

    return {name: (value_of(name, low, "--between"), value_of(name, high, "--between"))
            for name, low, high in between} or None  # fmt: skip
