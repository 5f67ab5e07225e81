"""`run` and `plan`: maps of a configuration."""

from __future__ import annotations

import shlex
from pathlib import Path
from time import perf_counter
from typing import TYPE_CHECKING, Literal

import click

from stickslip.cli import screen
from stickslip.cli.carried import carried_out, notice, report
from stickslip.cli.common import (
    CONFIG,
    DASK,
    EXIT_CODES,
    check_plot,
    fail,
    incomplete,
    path_or_none,
    prepare_kernels,
    reports_wrong_input,
)

if TYPE_CHECKING:
    from stickslip.config.model import Config
    from stickslip.runs.blocks import Shard
    from stickslip.runs.request import Outcome, Request

_MEMORY_OF_BLOCK = 4  # times its results: they, what the kernels fill, and the bytes that are written


@click.command(
    epilog=f"""\b
Examples:
  stickslip run configs/quickstart.yaml
  stickslip run my.yaml --output results/map.zarr --no-plot
  stickslip run my.yaml --shard 3/40        # one of forty jobs; then: stickslip collect my.yaml
  stickslip run my.yaml --dask tcp://login1:8786
\n{EXIT_CODES}"""
)
@CONFIG
@click.option("-o", "--output", type=click.Path(path_type=Path), help="File to write, .nc or .zarr.")
@click.option("--plot", type=click.Path(path_type=Path), help="Plot to write: .png, .svg or .pdf.")
@click.option("--no-plot", is_flag=True, help="Write no plot.")
@click.option("--store", metavar="PATH_OR_URL", help="Where finished blocks are kept.  [default: OUTPUT.parts]")
@click.option("--shard", metavar="I/N", help="Compute only this share of the blocks, and write no map.")
@click.option("--fresh", is_flag=True, help="Start over, and replace a map of another configuration.")
@click.option("--keep-parts", is_flag=True, help="Leave the finished blocks where they are.")
@click.option(
    "--on-error",
    type=click.Choice(["continue", "stop"]),
    default="continue",
    show_default=True,
    help="Whether a block that fails ends the run.",
)
@DASK
@reports_wrong_input
def run(
    config: Path,
    output: Path | None,
    plot: Path | None,
    no_plot: bool,
    store: str | None,
    shard: str | None,
    fresh: bool,
    keep_parts: bool,
    on_error: Literal["continue", "stop"],
    dask: str | None,
) -> None:
    """Compute the map a configuration asks for.

    Writes the file and the plot named in its `output` section, or by the options. Finished blocks are kept in
    OUTPUT.parts until the map is written: whatever stops a run, the same command resumes from there. Without an
    output the map is counted, plotted if a plot is asked for, and not kept.
    """
    from stickslip.config.grid import build_grid
    from stickslip.config.reader import load_config
    from stickslip.files import writing as files
    from stickslip.runs import session
    from stickslip.runs.request import Request

    loaded = load_config(config)
    grid = build_grid(loaded)
    output = output or path_or_none(loaded.output.file)
    target = None if no_plot or shard else plot or path_or_none(loaded.output.plot)
    if output is not None:
        files.check_writable(output)
    if target is not None:
        check_plot(target)
    part = _shard(shard, fresh)
    screen.terminal().print(f"{loaded.title}\n{screen.describe(grid)}", markup=False)
    if output is None and store is None:
        if part is not None:
            fail("a shard needs a place for its blocks: --store, or an output beside which they are kept")
        return _run_in_memory(loaded, grid.size, target, dask, _keeping(config))
    request = Request(loaded, output, store, part, fresh, keep_parts, on_error, dask=dask)
    outcome, seconds = carried_out(session.run, request, grid.size)
    _tell(outcome, seconds, request, target)


def _keeping(config: Path) -> str:
    """The command that writes the map of a configuration without an output to a file here."""
    return shlex.join(["stickslip", "run", str(config), "-o", f"{config.stem}.nc"])


def _shard(text: str | None, fresh: bool) -> Shard | None:
    from stickslip.runs.blocks import parse_shard

    if text is None:
        return None
    if fresh:
        fail("--fresh --shard: other shards share the store; remove it first, or start over without --shard")
    try:
        return parse_shard(text)
    except ValueError as error:
        fail(f"--shard: {error}")


def _tell(outcome: Outcome, seconds: float, request: Request, plot: Path | None) -> None:
    """The outcome of a run."""
    if outcome.output is not None:
        return report(outcome, seconds, request, plot)
    of = f"shard {request.shard}: " if request.shard else ""
    place = str(outcome.where)  # the store itself: what the configuration names may not be what was asked for
    click.echo(f"blocks   {of}{outcome.computed:,} cells computed into {place}")
    click.echo(f"next     {shlex.join(['stickslip', 'status', place])}    # progress of the map")
    click.echo(f"         {shlex.join(['stickslip', 'collect', place, *_named_output(request)])}    # writes it")


def _named_output(request: Request) -> list[str]:
    """The option that names the map where `collect` could not tell from the store alone."""
    if request.place is None:  # then the store is beside the map, and named after it
        return []
    return ["-o", str(request.output or "map.nc")]


def _run_in_memory(config: Config, cells: int, plot: Path | None, dask: str | None, keep: str) -> None:
    """A run that writes no file, and says so; `keep` is the command that does."""
    from stickslip import api

    api.check_in_memory(config, dask)
    notice(f"no output is named: the map is counted and then discarded; to keep it: {keep}")
    prepare_kernels(config.friction.law)
    began = finished = perf_counter()

    def note(done: int, of: int) -> None:
        nonlocal finished
        finished = perf_counter()
        move(done, of)

    try:
        with screen.progress_bar(cells) as move:
            ds = api.run(config, progress=note, dask=dask)
    except api.Interrupted as interrupted:
        incomplete(interrupted)
    if plot is not None and ds["regime"].ndim:
        from stickslip import plots

        plots.save(plots.plot_map(ds), plot)
    screen.report(ds, cells, finished - began, screen.threads(api.options_of(config)), None, plot)
    notice(f"the map was not kept; to keep it: {keep}")


@click.command(
    epilog="""\b
Example:
  stickslip plan configs/quickstart.yaml"""
)
@CONFIG
@reports_wrong_input
def plan(config: Path) -> None:
    """Estimate what a run takes: time, memory, disk space.

    Times a few cells spread over the map. Nothing is written.
    """
    from stickslip import api, engine
    from stickslip.config.grid import build_grid
    from stickslip.config.reader import load_config
    from stickslip.runs.assembly import IN_MEMORY
    from stickslip.runs.blocks import blocks_of
    from stickslip.runs.probe import probe

    loaded = load_config(config)
    grid = build_grid(loaded)
    options = api.options_of(loaded)
    prepare_kernels(loaded.friction.law)
    tried = probe(grid, options)
    blocks, each = blocks_of(grid.size), engine.bytes_per_cell(options)
    console = screen.terminal()
    console.print(f"{loaded.title}\n{screen.describe(grid)}", markup=False)
    largest = min(blocks.length, grid.size)
    console.print(f"blocks   {blocks.count:,} of up to {largest:,} cells, {tried.threads} at a time")
    needed = _MEMORY_OF_BLOCK * tried.threads * largest * each + 2 * min(grid.size, IN_MEMORY) * each
    console.print(
        f"memory   about {screen.memory(needed)} besides the program ({screen.memory(grid.size * each)} without a file)"
    )
    console.print(f"disk     up to {screen.memory(grid.size * each)} for finished blocks, and as much for the map")
    console.print(
        f"time     about {screen.duration_text(tried.seconds_per_cell * grid.size)} "
        f"({1 / tried.seconds_per_cell:,.0f} cells/s, from {tried.cells:,} cells spread over the map)"
    )
    if tried.at_step_limit:
        share = screen.share_text(tried.at_step_limit / tried.cells)
        console.print(
            f"steps    {tried.at_step_limit:,} of these cells ({share}) ended at the step limit: unresolved "
            f"with solver: {{max_steps: {options.max_steps}}}",
            markup=False,
        )
    for name, target in (("map", loaded.output.file), ("plot", loaded.output.plot)):
        if target is not None:
            console.print(f"{name:8} {target}", markup=False)
    if loaded.output.file is None:
        console.print(f"map      not kept, no output is named; to keep it: {_keeping(config)}", markup=False)
