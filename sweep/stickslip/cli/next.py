"""`next`: which measurement would tell most of what an explanation leaves open."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import click

from stickslip.cli import params, screen
from stickslip.cli.exits import fail, refuses_bad_input, reports_errors
from stickslip.cli.outputs import Outputs, save_result
from stickslip.cli.summary import show_result

if TYPE_CHECKING:
    from stickslip.files.locations import Location


@click.command(
    "next",
    epilog="""\b
Examples:
  stickslip next explain.nc --over belt_speed normal_load
  stickslip next explain.nc --over belt_speed="5..300 mm/s" --scatter period=2 --plot next.png""",
)
@click.argument("file", type=params.Place())
@click.argument("more", nargs=-1, metavar="[NAME]")
@click.option("--over", multiple=True, required=True, metavar="NAME[=RANGE]",
              help="One or two parameters in which an observation may differ.")  # fmt: skip
@click.option("--scatter", multiple=True, metavar="RESULT=PERCENT",
              help="Result to be measured, with its standard deviation.  [default: those observed before]")  # fmt: skip
@click.option("--points", type=click.IntRange(2, 1000), default=16, show_default=True, help="Points of each axis.")
@click.option("--draws", type=click.IntRange(2, 100_000), default=256, show_default=True,
              help="Draws of the explanation that are weighed.")  # fmt: skip
@params.OUTPUT
@params.plot_option()
@reports_errors
def next_command(
    file: Location, more: tuple[str, ...], over: tuple[str, ...], scatter: tuple[str, ...], points: int, draws: int,
    output: Location | None, plot: Path | None,
) -> None:  # fmt: skip
    """Say which measurement would tell most.

    FILE is what `stickslip explain` wrote. Over one or two parameters (`--over belt_speed normal_load`) the expected
    information of one more observation is computed, its regime and its results being what the draws say, and the best
    three places are named, with what each would narrow.
    """
    from stickslip.api.explained import next_measurement
    from stickslip.materials.system import ends_of

    with refuses_bad_input(""):
        ranges = {}
        for text in (*over, *more):
            name, equals, ends = text.partition("=")
            ranges[name.strip()] = ends_of(f"--over {name}", ends) if equals else None
    measured = {}
    for text in scatter:
        name, _, percent = text.partition("=")
        try:
            measured[name.strip()] = float(percent.strip().removesuffix("%")) / 100.0
        except ValueError:
            fail(f"--scatter: got {text!r}, expected RESULT=PERCENT")
    with refuses_bad_input(file), screen.progress_bar("draws") as move:
        ds = next_measurement(str(file), ranges, scatter=measured or None, points=points, draws=draws, progress=move)
    show_result(ds)
    save_result(ds, output)
    Outputs(plot).save(ds)
