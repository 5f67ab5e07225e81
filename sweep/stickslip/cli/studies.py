"""`border`, `contours`, `attractors` and `ramp`: where regimes change, and what depends on how the motion began."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from stickslip.cli import params
from stickslip.cli.exits import QUIET, fail, refuses_bad_input, reports_errors
from stickslip.cli.outputs import Outputs, save_plot, save_result
from stickslip.cli.run import FRESH, run_request
from stickslip.cli.summary import show_ramp

if TYPE_CHECKING:
    from stickslip.config.model import Config
    from stickslip.files.locations import Location

TOLERANCE = click.option(
    "--tolerance", type=float, default=1e-9, show_default=True, help="Width to stop at, over the border."
)
BETWEEN = click.option(
    "--between", nargs=2, metavar="LOW HIGH", help="Its range: SI, or with units.  [default: that of the axis]"
)


def RUN_OPTIONS(command: params.Command) -> params.Command:  # noqa: N802, a decorator
    """The options of all that survive interruption as a run does."""
    return params.decorated(command, FRESH, params.DASK, params.THREADS, QUIET)


def _run_study(
    place: Path, config: Config, section: tuple[str, Any], keep: list[str], output: Location | None, fresh: bool,
    dask: str | None, outputs: Outputs,
) -> None:  # fmt: skip
    """Compute a configuration with a section of a study in place of its own, and with no other outputs than these.

    section : its name, and what it holds. keep : further words of the command that writes the result to a file.
    """
    from stickslip.config.sections import Output
    from stickslip.config.studies import alone
    from stickslip.runs.session import Request

    update = {**alone(*section), "output": Output.model_construct(file=None, plot=None)}
    with refuses_bad_input(place):
        request = Request(config.model_copy(update=update), output, fresh=fresh, dask=dask)
        run_request(request, [section[0], str(place), *keep], outputs)


@click.command(
    epilog="""\b
Examples:
  stickslip border configs/quickstart.yaml --along belt_speed
  stickslip border configs/quickstart.yaml --along belt_speed --at stiffness="5 N/mm"
  stickslip border configs/quickstart.yaml --along belt_speed --between 1 "1.2 m/s" -o top.nc"""
)
@params.CONFIG
@params.AT
@click.option("--along", required=True, metavar="NAME", help="Parameter to search along.")
@BETWEEN
@TOLERANCE
@click.option("--scan", type=int, default=64, show_default=True, help="Places of each line to look at first.")
@params.OUTPUT
@params.plot_option("Plot to write: the borders over a map.")
@params.MAP
@RUN_OPTIONS
@reports_errors
def border(
    config: Path, at: tuple[str, ...], along: str, between: tuple[str, str] | None, tolerance: float, scan: int,
    output: Location | None, plot: Path | None, map_file: Location | None, fresh: bool, dask: str | None,
) -> None:  # fmt: skip
    """Find where along a parameter the regime changes.

    The other axes of CONFIG are the lines that are searched, but those that --at gives a value. With an output the
    search survives interruption as a run does, and `stickslip run` does the same for a configuration with a section
    `border`.
    """
    from stickslip.config.select import config_at
    from stickslip.config.studies import Border

    ends = params.interval(along, between) if between else None
    section = Border.model_construct(along=along, between=ends, tolerance=tolerance, scan=scan)
    loaded = params.configuration(config)
    loaded = config_at(loaded, at, in_part=True) if at else loaded
    keep = [*(word for text in at for word in ("--at", text)), "--along", along, "-o", "borders.nc"]
    _run_study(config, loaded, ("border", section), keep, output, fresh, dask, Outputs(plot, map=map_file))


@click.command(
    epilog="""\b
Examples:
  stickslip contours configs/quickstart.yaml --plot borders.png
  stickslip contours configs/quickstart.yaml -o borders.nc --csv borders.csv
  stickslip contours configs/start_state.yaml --points 1024 --plot basins.svg"""
)
@params.CONFIG
@click.option("--over", nargs=2, metavar="Y X", help="The two parameters.  [default: the last two axes]")
@click.option(
    "--between",
    nargs=3,
    multiple=True,
    metavar="NAME LOW HIGH",
    help="Range of a parameter: SI, or with units.  [default: that of the axis]",
)
@click.option("--points", type=int, default=512, show_default=True, help="Points of the grid along either axis.")
@TOLERANCE
@click.option("--scan", type=int, default=64, show_default=True, help="Points along either axis to look at first.")
@params.OUTPUT
@click.option("--csv", "table", type=params.Target("points"), help="Table of the lines to write, .csv.")
@params.plot_option("Plot to write: the lines over a map.")
@params.MAP
@RUN_OPTIONS
@reports_errors
def contours(
    config: Path, over: tuple[str, str] | None, between: tuple[tuple[str, str, str], ...], points: int,
    tolerance: float, scan: int, output: Location | None, table: Path | None, plot: Path | None,
    map_file: Location | None, fresh: bool, dask: str | None,
) -> None:  # fmt: skip
    """Follow the borders of regimes in a plane.

    Lines, loops among them, whose points are found one by one to the tolerance. Only the surroundings of a line are
    computed, so that a fine grid costs no more than its lines are long. Other axes of CONFIG become panels.
    """
    from stickslip.config.studies import Contours

    ranges = {name: params.interval(name, (low, high)) for name, low, high in between} or None
    section = Contours.model_construct(
        axes=over, between=ranges, points=points, tolerance=tolerance, scan=scan, rtol=None
    )
    loaded, outputs = params.configuration(config), Outputs(plot, table, map=map_file)
    _run_study(config, loaded, ("contours", section), ["-o", "contours.nc"], output, fresh, dask, outputs)


@click.command(
    epilog="""\b
Examples:
  stickslip attractors configs/attractors.yaml
  stickslip attractors configs/quickstart.yaml --displacement 0 "2 m" --velocity -1 1 -o basins.nc"""
)
@params.CONFIG
@click.option("--displacement", nargs=2, metavar="LOW HIGH", help="Displacements of the box: SI, or with units.")
@click.option("--velocity", nargs=2, metavar="LOW HIGH", help="Velocities of the box: SI, or with units.")
@click.option("--samples", type=int, help="Starting states per cell where the share is not exact.  [default: 1024]")
@click.option("--seed", type=int, help="Seed of the starting states.  [default: 1]")
@params.OUTPUT
@params.plot_option()
@RUN_OPTIONS
@reports_errors
def attractors(
    config: Path, displacement: tuple[str, str] | None, velocity: tuple[str, str] | None, samples: int | None,
    seed: int | None, output: Location | None, plot: Path | None, fresh: bool, dask: str | None,
) -> None:  # fmt: skip
    """Find which regimes coexist, and what settles.

    How large a share of a box of starting states settles, and how large a shock ends sliding.

    The box is that of the section `attractors` of CONFIG, unless it is given here. With an output the work survives
    interruption as a run does, and `stickslip run` does the same for a configuration with that section.
    """
    from stickslip.config.studies import Attractors

    loaded = params.configuration(config)
    ends = {"displacement": displacement, "velocity": velocity}
    keys = {} if loaded.attractors is None else dict(loaded.attractors)
    keys |= {name: params.interval(name, pair, f"--{name}") for name, pair in ends.items() if pair}
    keys |= {name: value for name, value in (("samples", samples), ("seed", seed)) if value is not None}
    if missing := [name for name in ends if name not in keys]:
        fail(f"{config}: --{missing[0]}: missing, expected LOW HIGH, or a section attractors in the configuration")
    keep = [*(word for name, pair in ends.items() if pair for word in (f"--{name}", *pair)), "-o", "basins.nc"]
    section = Attractors.model_construct(**keys)
    _run_study(config, loaded, ("attractors", section), keep, output, fresh, dask, Outputs(plot))


@click.command(
    epilog="""\b
Examples:
  stickslip ramp configs/quickstart.yaml --along belt_speed --plot ramp.png
  stickslip ramp configs/quickstart.yaml --along belt_speed --between 0.2 "1 m/s" -o ramp.nc"""
)
@params.CONFIG
@click.option("--along", required=True, metavar="NAME", help="Parameter that goes up and down.")
@BETWEEN
@click.option("--points", type=int, default=200, show_default=True, help="Values to wait at, on each way.")
@params.OUTPUT
@params.plot_option("Plot to write; of a single line.")
@params.THREADS
@QUIET
@reports_errors
def ramp(
    config: Path, along: str, between: tuple[str, str] | None, points: int, output: Location | None, plot: Path | None
) -> None:
    """Follow attractors up and down a parameter.

    Each value starts from where the motion at the one before ended. The other axes of CONFIG are lines of their own.
    """
    from stickslip.api import studies

    loaded = params.configuration(config)
    ends = params.interval(along, between, f"--{along}") if between else None
    with refuses_bad_input(config):
        ds = studies.ramp(loaded, along, ends, points)
    show_ramp(ds)
    save_result(ds, output)
    if plot is not None:
        with refuses_bad_input(plot):
            from stickslip import plots

            save_plot(plots.plot_branches(ds), plot)
