"""`attractors` and `ramp`: what depends on how the motion began."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import click

from stickslip.cli import screen
from stickslip.cli.carried import run_request
from stickslip.cli.common import (
    CONFIG,
    DASK,
    OUTPUT,
    QUIET,
    THREADS,
    Target,
    configuration,
    fail,
    prepare_kernels,
    reports_wrong_input,
)

if TYPE_CHECKING:
    from stickslip.files.locations import Location


@click.command(
    epilog="""\b
Examples:
  stickslip attractors configs/attractors.yaml
  stickslip attractors configs/quickstart.yaml --displacement 0 "2 m" --velocity -1 1 -o basins.nc"""
)
@CONFIG
@click.option("--displacement", nargs=2, metavar="LOW HIGH", help="Displacements of the box: SI, or with units.")
@click.option("--velocity", nargs=2, metavar="LOW HIGH", help="Velocities of the box: SI, or with units.")
@click.option("--samples", type=int, help="Starting states per cell where the share is not exact.  [default: 1024]")
@click.option("--seed", type=int, help="Seed of the starting states.  [default: 1]")
@OUTPUT
@click.option("--plot", type=Target("plot"), help="Plot to write, .png, .svg or .pdf.")
@click.option("--fresh", is_flag=True, help="Replace a file of other attractors.")
@DASK
@THREADS
@QUIET
@reports_wrong_input
def attractors(
    config: Path,
    displacement: tuple[str, str] | None,
    velocity: tuple[str, str] | None,
    samples: int | None,
    seed: int | None,
    output: Location | None,
    plot: Path | None,
    fresh: bool,
    dask: str | None,
) -> None:
    """Find which regimes coexist, and what settles.

    How large a share of a box of starting states settles, and how large a shock ends sliding.

    The box is that of the section `attractors` of CONFIG, unless it is given here. With an output the work survives
    interruption as a run does, and `stickslip run` does the same for a configuration with that section.
    """
    from stickslip.config.sections import Output
    from stickslip.config.studies import Attractors, alone
    from stickslip.runs.request import Request

    one = configuration(config)
    ends = {"displacement": displacement, "velocity": velocity}
    box = {name: _interval(name, pair) for name, pair in ends.items() if pair}
    numbers = {name: value for name, value in (("samples", samples), ("seed", seed)) if value is not None}
    said = {} if one.attractors is None else dict(one.attractors)
    asked = said | box | numbers
    if missing := [name for name in ends if name not in asked]:
        fail(f"{config}: --{missing[0]}: missing, expected LOW HIGH, or a section attractors in the configuration")
    update = alone("attractors", Attractors.model_construct(**asked))
    one = one.model_copy(update={**update, "output": Output.model_construct(file=None, plot=None)})
    said_here = [word for name, pair in ends.items() if pair for word in (f"--{name}", *pair)]
    again = ["attractors", str(config), *said_here, "-o", "basins.nc"]
    try:
        run_request(Request(one, output, fresh=fresh, dask=dask), plot, again)
    except (TypeError, ValueError) as error:  # bad input, said before anything is computed
        fail(f"{config}: {error}")


@click.command(
    epilog="""\b
Examples:
  stickslip ramp configs/quickstart.yaml --along belt_speed --plot ramp.png
  stickslip ramp configs/quickstart.yaml --along belt_speed --between 0.2 "1 m/s" -o ramp.nc"""
)
@CONFIG
@click.option("--along", required=True, metavar="NAME", help="Parameter that goes up and down.")
@click.option(
    "--between", nargs=2, metavar="LOW HIGH", help="Its range: SI, or with units.  [default: that of the axis]"
)
@click.option("--points", type=int, default=200, show_default=True, help="Values to wait at, on each way.")
@OUTPUT
@click.option("--plot", type=Target("plot"), help="Plot to write; of a single line.")
@THREADS
@QUIET
@reports_wrong_input
def ramp(
    config: Path, along: str, between: tuple[str, str] | None, points: int, output: Location | None, plot: Path | None
) -> None:
    """Follow attractors up and down a parameter.

    Each value starts from where the motion at the one before ended. The other axes of CONFIG are lines of their own.
    """
    from stickslip import plots, studies
    from stickslip.errors import PlotError
    from stickslip.files import writing

    one = configuration(config)
    ends = _interval(along, between) if between else None
    prepare_kernels(one.friction.law)
    try:
        ds = studies.ramp(one, along, ends, points)
    except (TypeError, ValueError) as error:  # bad input, said before anything is computed
        fail(f"{config}: {error}")
    from stickslip.cli.attractor_rows import show_ramp

    show_ramp(ds)
    if output is not None:
        writing.write(ds, output)
        screen.echo(f"written  {output} ({screen.size_of(output)})")
    if plot is not None:
        try:
            plots.save(plots.plot_branches(ds), plot)
        except PlotError as error:
            fail(f"{plot}: {error}")
        screen.echo(f"plot     {plot}")


def _interval(name: str, ends: tuple[str, str]) -> tuple[float, float]:
    """Both ends in SI."""
    from stickslip.config.select import value_of

    low, high = (value_of(name, end, f"--{name}") for end in ends)
    return low, high
