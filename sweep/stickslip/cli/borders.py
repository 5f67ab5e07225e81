"""`border`: where along a parameter the regime changes."""

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
  stickslip border configs/quickstart.yaml --along belt_speed
  stickslip border configs/quickstart.yaml --along belt_speed --at stiffness="5 N/mm"
  stickslip border configs/quickstart.yaml --along belt_speed --between 1 "1.2 m/s" -o top.nc"""
)
@CONFIG
@click.option("--at", multiple=True, metavar="NAME=VALUE", help="Value of an axis, or of any other quantity.")
@click.option("--along", required=True, metavar="NAME", help="Parameter to search along.")
@click.option(
    "--between", nargs=2, metavar="LOW HIGH", help="Range to search: SI, or with units.  [default: that of the axis]"
)
@click.option("--tolerance", type=float, default=1e-9, show_default=True, help="Width to stop at, over the border.")
@click.option("--scan", type=int, default=64, show_default=True, help="Places of each line to look at first.")
@OUTPUT
@click.option("--plot", type=Target("plot"), help="Plot to write: the borders over a map.")
@MAP
@click.option("--fresh", is_flag=True, help="Replace a file of another search.")
@DASK
@THREADS
@QUIET
@reports_wrong_input
def border(
    config: Path,
    at: tuple[str, ...],
    along: str,
    between: tuple[str, str] | None,
    tolerance: float,
    scan: int,
    output: Location | None,
    plot: Path | None,
    map_file: Location | None,
    fresh: bool,
    dask: str | None,
) -> None:
    """Find where along a parameter the regime changes.

    The other axes of CONFIG are the lines that are searched, but those that --at gives a value. With an output the
    search survives interruption as a run does, and `stickslip run` does the same for a configuration with a section
    `border`.
    """
    from stickslip.config.sections import Output
    from stickslip.config.select import config_at
    from stickslip.config.studies import Border, alone
    from stickslip.runs.request import Request

    ends = _ends(along, between) if between else None
    asked = Border.model_construct(along=along, between=ends, tolerance=tolerance, scan=scan)
    one = configuration(config)
    one = (config_at(one, at, in_part=True) if at else one).model_copy(
        update={**alone("border", asked), "output": Output.model_construct(file=None, plot=None)}
    )
    again = ["border", str(config), *(word for one_at in at for word in ("--at", one_at)), "--along", along]
    again += ["-o", "borders.nc"]
    try:
        run_request(Request(one, output, fresh=fresh, dask=dask), plot, again, Extras(map_file))
    except (TypeError, ValueError) as error:  # bad input, said before anything is computed
        fail(f"{config}: {error}")


def _ends(along: str, between: tuple[str, str]) -> tuple[float, float]:
    """Both ends in SI."""
    from stickslip.config.select import value_of

    low, high = (value_of(along, end, "--between") for end in between)
    return low, high
