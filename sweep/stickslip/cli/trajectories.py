"""`simulate`: one cell, in words and over time."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import click

from stickslip.cli import screen
from stickslip.cli import trajectory_words as words
from stickslip.cli.common import (
    CONFIG_OR_RESULT,
    JSON,
    OUTPUT,
    Target,
    configuration,
    prepare_kernels,
    reports_wrong_input,
    settings,
    tell_json,
)

if TYPE_CHECKING:
    import xarray as xr

    from stickslip.config.select import Recipe
    from stickslip.files.locations import Location


@click.command(
    epilog="""\b
Examples:
  stickslip simulate configs/quickstart.yaml --at stiffness="5 N/mm" --at belt_speed="20 mm/s"
  stickslip simulate configs/quickstart.yaml \\
      --at stiffness=5 --at belt_speed="10 cm/s" -t "1 min" -o trace.nc
  stickslip simulate configs/lubricants.yaml \\
      --at lubricant=grease --at belt_speed=0.1 --plot trace.png"""
)
@CONFIG_OR_RESULT
@click.option("--at", multiple=True, metavar="NAME=VALUE", help="Value of an axis, or of any other quantity.")
@click.option(
    "-t",
    "--duration",
    metavar="TIME",
    help='How long: seconds, or with a unit ("2 min").  [default: eight cycles, or until it has settled]',
)
@click.option("--samples", type=click.IntRange(2), help="Number of points in time.  [default: 2001, or 60 a vibration]")
@OUTPUT
@click.option("--plot", type=Target("plot"), help="Plot to write: .png, .svg or .pdf.")
@JSON
@reports_wrong_input
def simulate(
    config: Location, at: tuple[str, ...], duration: str | None, samples: int | None, output: Location | None,
    plot: Path | None, as_json: bool,
) -> None:  # fmt: skip
    """Compute one cell of a configuration, over time.

    CONFIG is a YAML file, or a result (.nc, .zarr), which holds its configuration. The axes need a value each (--at);
    everything else is as in the file. Says the regime, the frequency, the forces and more; -o writes the motion over
    time, --plot draws it, `stickslip listen` makes it heard.
    """
    from stickslip import api
    from stickslip.config.select import cell_of, config_at, seconds
    from stickslip.dataset.display import shown_as_written
    from stickslip.files import writing

    one = config_at(recipe_in(config), at)
    asked = None if duration is None else seconds(duration)
    law, solver, cell = one.friction.law, one.solver, cell_of(one)
    prepare_kernels(law)
    found = api.evaluate(cell, solver.rtol, solver.horizon, law=law, max_steps=solver.max_steps)
    look = words.look_at(found) if asked is None else words.look_for(found, asked)
    if as_json:
        files = {"duration": look.duration, "output": output, "plot": plot}
        tell_json(words.answer(found) | (files if output or plot else {}))
    else:
        _tell(found)
    if output is None and plot is None:
        if not as_json:
            screen.echo("over time: -o trace.nc, --plot trace.png; as sound: stickslip listen")
        return
    prepare_kernels(law, signals=True)
    ds = api.simulate(
        duration=look.duration, samples=samples or look.samples, law=law, rtol=solver.rtol,
        max_steps=solver.max_steps, options=None, **cell,
    )  # fmt: skip
    ds = shown_as_written(ds, one.written_in)
    if output is not None:
        writing.write(ds, output)
    if plot is not None:
        _draw(ds, words.titled(one.title, at), plot)
    if not as_json:
        _tell_files(look, output, plot)


def _tell(found: xr.Dataset) -> None:
    """The cell in words."""
    told = words.rows(found)
    width = max(len(what) for what, _ in told)
    for what, value in told:
        screen.echo(f"{what:<{width}}  {value}")


def _draw(ds: xr.Dataset, title: str, plot: Path) -> None:
    from stickslip import plots

    plots.save(plots.plot_trace(ds, title=title), plot)


def _tell_files(look: words.Look, output: Location | None, plot: Path | None) -> None:
    """What was written, and over which time."""
    over = f"{words.time(look.duration)}{f', {look.why}' if look.why else ''}"
    if output is not None:
        screen.echo(f"trajectory  {output} ({over}; {screen.size_of(output)})")
    if plot is not None:
        screen.echo(f"plot        {plot}" + (f" ({over})" if output is None else ""))


def recipe_in(path: Location) -> Recipe:
    """The configuration in a YAML file, or the one in a result."""
    from stickslip.config.sections import OUTPUT_SUFFIXES
    from stickslip.config.select import recipe_of
    from stickslip.files import reading

    if path.suffix.lower() not in OUTPUT_SUFFIXES:
        return configuration(path)  # type: ignore[arg-type]
    with reading.look_into(path) as ds:
        return recipe_of(ds, str(path), settings())
