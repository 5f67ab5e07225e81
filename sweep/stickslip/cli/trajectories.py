"""`simulate`: one cell over time."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import click

from stickslip.cli import screen
from stickslip.cli.common import (
    CONFIG_OR_RESULT,
    OUTPUT,
    check_plot,
    configuration,
    fail,
    prepare_kernels,
    reports_wrong_input,
    settings,
)

if TYPE_CHECKING:
    from stickslip.config.pick import Recipe
    from stickslip.files.locations import Location


@click.command(
    epilog="""\b
Examples:
  stickslip simulate configs/quickstart.yaml \\
      --at stiffness=5 --at belt_speed="10 cm/s" -t "1 min" -o trace.nc
  stickslip simulate configs/lubricants.yaml \\
      --at lubricant=grease --at belt_speed=0.1 -t 20 --plot trace.png"""
)
@CONFIG_OR_RESULT
@click.option("--at", multiple=True, metavar="NAME=VALUE", help="Value of an axis, or of any other quantity.")
@click.option("-t", "--duration", required=True, metavar="TIME", help='How long: seconds, or with a unit ("2 min").')
@click.option("--samples", type=click.IntRange(2), default=2001, show_default=True, help="Number of points in time.")
@OUTPUT
@click.option("--plot", type=click.Path(path_type=Path), help="Plot to write: .png, .svg or .pdf.")
@reports_wrong_input
def simulate(
    config: Location, at: tuple[str, ...], duration: str, samples: int, output: Location | None, plot: Path | None
) -> None:
    """Compute one cell of a configuration over time.

    CONFIG is a YAML file, or a result (.nc, .zarr), which holds its configuration. The axes need a value each (--at);
    everything else is as in the file.
    """
    from stickslip import api, plots
    from stickslip.config.pick import cell_of, config_at, seconds
    from stickslip.files import writing

    one = config_at(recipe_in(config), at)
    time, solver = seconds(duration), one.solver
    if output is None and plot is None:
        fail("nothing to do: name a file (--output trace.nc), a plot (--plot trace.png), or both")
    if output is not None:
        writing.check_writable(output)
    if plot is not None:
        check_plot(plot)
    law = one.friction.law
    prepare_kernels(law, signals=True)
    cell = cell_of(one)
    ds = api.simulate(duration=time, samples=samples, law=law, rtol=solver.rtol, max_steps=solver.max_steps, **cell)
    if output is not None:
        writing.write(ds, output)
        click.echo(f"trajectory  {output} ({screen.size_of(output)})")
    if plot is not None:
        plots.save(plots.plot_trace(ds, title=", ".join([one.title, *at])), plot)
        click.echo(f"plot        {plot}")


def recipe_in(path: Location) -> Recipe:
    """The configuration in a YAML file, or the one in a result."""
    from stickslip.config.pick import recipe_of
    from stickslip.config.sections import OUTPUT_SUFFIXES
    from stickslip.files import reading

    if path.suffix.lower() not in OUTPUT_SUFFIXES:
        return configuration(path)  # type: ignore[arg-type]
    with reading.look_into(path) as ds:
        return recipe_of(ds, str(path), settings())
