"""The command `stickslip`.

Everything slow is imported inside the command that needs it, so that `--help` answers at once. Results go to standard
output; progress, notices and errors to standard error.
"""

from __future__ import annotations

import sys
import warnings
from collections.abc import Callable
from functools import wraps
from pathlib import Path
from time import perf_counter
from typing import Any, NoReturn

import click

from . import screen
from ._version import __version__

DONE, INCOMPLETE, WRONG_INPUT = 0, 1, 2
CONFIG = click.argument("config", type=click.Path(path_type=Path))
EXIT_CODES = """\b
Exit codes:
  0  done
  1  computed, but not to the end (Ctrl-C), or a bug (then with a traceback)
  2  the input is wrong, and nothing was computed"""


@click.group(context_settings={"help_option_names": ["-h", "--help"], "max_content_width": 100}, epilog=EXIT_CODES)
@click.version_option(__version__, prog_name="stickslip")
def main() -> None:
    """Where does a friction contact stick and slip?

    A YAML file names a friction pair and what to vary; `run` computes the motion of every combination and writes a map
    of regimes: netCDF or Zarr, and a picture.

    \b
    Start here:
      stickslip init my.yaml            a commented configuration to change
      stickslip plan my.yaml            how many cells, how long
      stickslip run my.yaml             compute it
      stickslip simulate my.yaml ...    one cell over time
    """
    warnings.showwarning = lambda message, *_: click.echo(f"warning: {message}", err=True)


# --- what all commands share ------------------------------------------------------------------------------------------


def fail(message: object) -> NoReturn:
    """End with the exit code for wrong input."""
    click.echo(message, err=True)
    sys.exit(WRONG_INPUT)


def reports_wrong_input(command: Callable[..., None]) -> Callable[..., None]:
    """Turn the errors meant for people into their text and an exit code; all others are bugs and show a traceback."""

    @wraps(command)
    def guarded(*args: Any, **kwargs: Any) -> None:
        from .problems import ConfigError
        from .store import StoreError

        try:
            command(*args, **kwargs)
        except (ConfigError, StoreError) as error:
            fail(error)
        except Exception as error:
            from .engine import NotReachedError

            if not isinstance(error, NotReachedError):
                raise
            click.echo(str(error), err=True)
            sys.exit(INCOMPLETE)

    return guarded


def prepare_kernels(law: str) -> None:
    """Compile the kernels if that is still to do, and say so."""
    from . import engine

    if not engine.will_compile(law):
        return engine.warm_up(law)
    console = screen.terminal(stderr=True)
    began = perf_counter()
    notice = "Compiling the kernels for this machine: once, about half a minute ..."
    if not console.is_terminal:
        console.print(notice)
    with console.status(notice):
        engine.warm_up(law)
    seconds = screen.duration_text(perf_counter() - began)
    console.print(f"Compiled the kernels in {seconds}; the next run finds them ready.")


# --- run, plan, validate ----------------------------------------------------------------------------------------------


@main.command(
    epilog=f"""\b
Examples:
  stickslip run configs/quickstart.yaml
  stickslip run my.yaml --output results/map.zarr --no-plot
\n{EXIT_CODES}"""
)
@CONFIG
@click.option("-o", "--output", type=click.Path(path_type=Path), help="File to write, .nc or .zarr.")
@click.option("--plot", type=click.Path(path_type=Path), help="Picture to draw: .png, .svg or .pdf.")
@click.option("--no-plot", is_flag=True, help="Draw no picture.")
@reports_wrong_input
def run(config: Path, output: Path | None, plot: Path | None, no_plot: bool) -> None:
    """Compute the map a configuration asks for.

    Writes the file and the picture named in its `output` section, or by the options. Ctrl-C stops at once and keeps
    what is finished in FILE.partial.nc.
    """
    from . import api, store
    from .config import load_config
    from .grid import build_grid

    loaded = load_config(config)
    grid = build_grid(loaded)
    output = output or _path(loaded.output.file)
    picture = None if no_plot else plot or _path(loaded.output.plot)
    if output is not None:
        store.check_writable(output)
    if picture is not None:
        _check_picture(picture)
    screen.terminal().print(f"{loaded.title}\n{screen.describe(grid)}", markup=False)
    prepare_kernels(loaded.friction.law)
    began = finished = perf_counter()

    def note(done: int, cells: int) -> None:
        nonlocal finished
        finished = perf_counter()
        move(done, cells)

    try:
        with screen.progress_bar(grid.size) as move:
            ds = api.run(loaded, output, progress=note)
    except api.Interrupted as interrupted:
        click.echo(str(interrupted), err=True)
        sys.exit(INCOMPLETE)
    if picture is not None and grid.dims:
        from . import plots  # Matplotlib takes its time, and the first block need not wait for it

        plots.save(plots.plot_map(ds), picture)
    screen.report(ds, finished - began, api.options_of(loaded), output, picture)


def _path(name: str | Path | None) -> Path | None:
    return None if name is None else Path(name)


def _check_picture(picture: Path) -> None:
    from .models import PLOT_SUFFIXES

    if picture.suffix.lower() not in PLOT_SUFFIXES:
        fail(f"{picture}: pictures end in {', '.join(PLOT_SUFFIXES)}")
    if not picture.absolute().parent.is_dir():
        fail(f"{picture}: no folder {picture.parent}")


@main.command(
    epilog="""\b
Example:
  stickslip plan configs/quickstart.yaml"""
)
@CONFIG
@reports_wrong_input
def plan(config: Path) -> None:
    """Say what a run would take, in time and memory.

    Times a few cells spread over the map. Nothing is written.
    """
    from . import api, engine
    from .config import load_config
    from .grid import build_grid

    loaded = load_config(config)
    grid = build_grid(loaded)
    options = api.options_of(loaded)
    prepare_kernels(loaded.friction.law)
    probe = engine.probe(grid.cells, grid.size, options)
    step = engine.block_size(grid.size, options)
    console = screen.terminal()
    console.print(f"{loaded.title}\n{screen.describe(grid)}", markup=False)
    console.print(f"blocks   {-(-grid.size // step):,} of up to {step:,} cells, {probe.threads} at a time")
    console.print(f"memory   {screen.memory(engine.bytes_per_cell(options) * grid.size)} for the results")
    console.print(
        f"time     about {screen.duration_text(probe.seconds_per_cell * grid.size)} "
        f"({1 / probe.seconds_per_cell:,.0f} cells/s, from {probe.cells:,} cells spread over the map)"
    )
    for name, target in (("map", loaded.output.file), ("picture", loaded.output.plot)):
        if target is not None:
            console.print(f"{name:8} {target}", markup=False)


@main.command()
@click.argument("configs", type=click.Path(path_type=Path), nargs=-1, required=True)
def validate(configs: tuple[Path, ...]) -> None:
    """Check configurations without computing anything.

    Every mistake of every file is listed, with its line and column.
    """
    from .config import load_config
    from .grid import build_grid
    from .problems import ConfigError

    wrong = False
    for path in configs:
        try:
            click.echo(f"{path}: good, {screen.describe(build_grid(load_config(path)))}")
        except ConfigError as error:
            click.echo(str(error), err=True)
            wrong = True
    sys.exit(WRONG_INPUT if wrong else DONE)


# --- simulate, plot ---------------------------------------------------------------------------------------------------


@main.command(
    epilog="""\b
Examples:
  stickslip simulate configs/quickstart.yaml \\
      --at stiffness=5 --at belt_speed="10 cm/s" -t "1 min" -o trace.nc
  stickslip simulate configs/lubricants.yaml \\
      --at lubricant=grease --at belt_speed=0.1 -t 20 --plot trace.png"""
)
@CONFIG
@click.option("--at", multiple=True, metavar="NAME=VALUE", help="Value of an axis, or of any other quantity.")
@click.option("-t", "--duration", required=True, metavar="TIME", help='How long: seconds, or with a unit ("2 min").')
@click.option("--samples", type=click.IntRange(2), default=2001, show_default=True, help="Points in time.")
@click.option("-o", "--output", type=click.Path(path_type=Path), help="File to write, .nc or .zarr.")
@click.option("--plot", type=click.Path(path_type=Path), help="Picture to draw: .png, .svg or .pdf.")
@reports_wrong_input
def simulate(
    config: Path, at: tuple[str, ...], duration: str, samples: int, output: Path | None, plot: Path | None
) -> None:
    """Compute one cell of a configuration over time.

    The axes need a value each (--at); everything else is as in the file.
    """
    from . import api, plots, store
    from .config import load_config
    from .pick import cell_at, seconds

    loaded = load_config(config)
    cell = cell_at(loaded, at)
    time, solver = seconds(duration), loaded.solver
    if output is None and plot is None:
        fail("nothing to do: name a file (--output trace.nc), a picture (--plot trace.png), or both")
    if output is not None:
        store.check_writable(output)
    if plot is not None:
        _check_picture(plot)
    prepare_kernels(loaded.friction.law)
    ds = api.simulate(
        duration=time, samples=samples, law=loaded.friction.law, rtol=solver.rtol, max_steps=solver.max_steps, **cell
    )
    if output is not None:
        store.write(ds, output)
        click.echo(f"trajectory  {output} ({screen.size_of(output)})")
    if plot is not None:
        plots.save(plots.plot_trace(ds, title=", ".join([loaded.title, *at])), plot)
        click.echo(f"picture     {plot}")


@main.command(
    epilog="""\b
Examples:
  stickslip plot quickstart.nc
  stickslip plot quickstart.nc --variable spring_force_max -o force.svg
  stickslip plot map.nc --select damping=0.1"""
)
@click.argument("file", type=click.Path(path_type=Path))
@click.option("--variable", default="regime", show_default=True, help="What to draw.")
@click.option("--select", multiple=True, metavar="DIM=VALUE", help="Fix a dimension: nearest point, or label.")
@click.option("--no-borders", is_flag=True, help="Leave out the borders of linear theory.")
@click.option("-o", "--output", type=click.Path(path_type=Path), help="Picture to draw.  [default: FILE.png]")
@reports_wrong_input
def plot(file: Path, variable: str, select: tuple[str, ...], no_borders: bool, output: Path | None) -> None:
    """Draw a result: a map, or a trajectory."""
    from . import plots, store

    ds = store.open(file)
    target = output or file.with_suffix(".png")
    _check_picture(target)
    try:
        if "time" in ds.dims:
            figure = plots.plot_trace(ds)
        else:
            figure = plots.plot_map(ds, variable, select=_pairs(select), borders=not no_borders)
    except plots.PlotError as error:
        fail(f"{file}: {error}")
    plots.save(figure, target)
    click.echo(f"picture  {target}")


def _pairs(texts: tuple[str, ...]) -> dict[str, str]:
    """NAME=VALUE texts as a mapping."""
    pairs = {}
    for text in texts:
        name, equals, value = text.partition("=")
        if not equals:
            fail(f"got {text!r}, expected NAME=VALUE")
        pairs[name.strip()] = value.strip()
    return pairs


# --- fit, article -----------------------------------------------------------------------------------------------------


@main.command(
    epilog="""\b
Examples:
  stickslip fit measured.csv                    # columns: speed [mm/s], mu
  stickslip fit greaseA.csv greaseB.csv --at "5 min"   # columns: time [s], mu"""
)
@click.argument("files", type=click.Path(path_type=Path), nargs=-1, required=True)
@click.option(
    "--at", default="300", metavar="TIME", show_default=True, help="Waiting time at which lubricants are ranked."
)
@reports_wrong_input
def fit(files: tuple[Path, ...], at: str) -> None:
    """Fit friction curves, or ageing, to measured points.

    Points of (speed, mu) give a1 to a4 of the Stribeck curve, points of (time, mu) the growth of static friction with
    the waiting time; several files of the latter are ranked. The header of each file names columns and units.
    """
    from .measured import describe_ageing, describe_curve, describe_ranking, fit_points
    from .pick import seconds

    fits = {file.stem: fit_points(file) for file in files}
    for name, found in fits.items():
        click.echo(f"{name}\n{describe_curve(found.curve) if found.curve else describe_ageing(found.ageing)}\n")
    ageing = {name: found.ageing for name, found in fits.items() if found.ageing}
    if len(ageing) > 1:
        click.echo(describe_ranking(ageing, seconds(at)))


@main.command()
@click.argument("figures", nargs=-1)
@click.option("-o", "--output", type=click.Path(path_type=Path), default="article", show_default=True, help="Folder.")
@reports_wrong_input
def article(figures: tuple[str, ...], output: Path) -> None:
    """Compute the figures of the article again.

    Writes a picture and a netCDF file for each FIGURE (fig2 to fig11, fig19, eq3, eq3_box; all unless given), and
    says what was found.
    """
    from .article import UnknownFigure, make

    prepare_kernels("stribeck")
    try:
        made = make(figures, output, progress=lambda name: click.echo(f"{name} ...", err=True))
    except UnknownFigure as error:
        fail(error)
    for figure in made:
        click.echo(f"{figure.name:8} {figure.picture}  {figure.data}")


# --- schema, init -----------------------------------------------------------------------------------------------------


@main.command()
def schema() -> None:
    """Print the JSON Schema of configurations.

    It lets editors check and complete the YAML.

    \b
    In VS Code with the YAML extension:
      stickslip schema > stickslip.schema.json
    and as first line of a configuration
      # yaml-language-server: $schema=stickslip.schema.json
    """
    import json

    from .schema import json_schema

    click.echo(json.dumps(json_schema(), indent=2))


@main.command()
@click.argument("file", type=click.Path(path_type=Path), default="stickslip.yaml")
def init(file: Path) -> None:
    """Write a commented configuration to start from.

    FILE is stickslip.yaml unless given; a file that exists is never overwritten.
    """
    from .starter import STARTER

    try:
        with file.open("x", encoding="utf-8") as target:
            target.write(STARTER)
    except FileExistsError:
        fail(f"{file}: exists already; name another file, or remove it first")
    except OSError as error:
        fail(f"{file}: {error.strerror}")
    click.echo(f"wrote {file}; next: stickslip run {file}")
