"""`run` and `plan`: maps of a configuration."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Literal

import click

from stickslip.cli import screen
from stickslip.cli.backdrop import Extras
from stickslip.cli.carried import keeping, run_request
from stickslip.cli.common import (
    CONFIG,
    DASK,
    EXIT_CODES,
    OUTPUT,
    fail,
    location_or_none,
    path_or_none,
    prepare_kernels,
    reports_wrong_input,
)

if TYPE_CHECKING:
    from stickslip.files.locations import Location
    from stickslip.runs.blocks import Shard

_MEMORY_OF_BLOCK = 4  # times its results: they, what the kernels fill, and the bytes that are written


@click.command(
    epilog=f"""\b
Examples:
  stickslip run configs/quickstart.yaml
  stickslip run my.yaml --output results/map.zarr --no-plot
  stickslip run my.yaml -o s3://bucket/map.zarr
  stickslip run my.yaml --shard 3/40        # one of forty jobs; then: stickslip collect my.yaml
  stickslip run my.yaml --dask tcp://login1:8786
\n{EXIT_CODES}"""
)
@CONFIG
@OUTPUT
@click.option("--plot", type=click.Path(path_type=Path), help="Plot to write: .png, .svg or .pdf.")
@click.option("--report", type=click.Path(path_type=Path), help="Page to write: .html, with plots, shares, meanings.")
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
    output: Location | None,
    plot: Path | None,
    report: Path | None,
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
    from stickslip.config.reader import load_config
    from stickslip.runs.request import Request

    loaded = load_config(config)
    output = output or location_or_none(loaded.output.file)
    target = None if no_plot or shard else plot or path_or_none(loaded.output.plot)
    part = _shard(shard, fresh)
    request = Request(loaded, output, store, part, fresh, keep_parts, on_error, dask=dask)
    keep = ["run", str(config), "-o", f"{config.stem}.nc"]
    run_request(request, target, keep, Extras(page=None if shard else report))


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
    from stickslip import engine
    from stickslip.config.grid import build_grid
    from stickslip.config.reader import load_config
    from stickslip.runs.probe import probe
    from stickslip.runs.work import Work
    from stickslip.uncertainty import sample_study

    loaded = load_config(config)
    work = Work(loaded)
    study, blocks, options = work.study, work.blocks, work.options
    prepare_kernels(loaded.friction.law)
    grid = build_grid(loaded)
    tried = probe(grid if loaded.uncertain is None else sample_study(loaded), options)
    each, cells = engine.bytes_per_cell(options), study.cells_each * work.size
    console = screen.terminal()
    console.print(f"{loaded.title}\n{study.described()}", markup=False)
    largest = min(blocks.length, work.size)
    console.print(f"blocks   {blocks.count:,} of up to {largest:,} {study.counted}, {tried.threads} at a time")
    together = _MEMORY_OF_BLOCK * tried.threads * largest * study.weight
    needed = screen.memory(together * each)
    if study.name == "map":
        whole, stored = screen.memory(grid.size * each), screen.memory(cells * each)
        if loaded.refine is not None:
            console.print(f"cells    about {cells:,} are computed; more if the borders between regimes are long")
        console.print(f"memory   about {needed} besides the program ({whole} without a file)")
        map_size = "as much" if stored == whole else f"{whole}, before compression,"
        console.print(f"disk     up to {stored} for finished blocks, and {map_size} for the map")
    console.print(
        f"time     about {screen.duration_text(tried.seconds_per_cell * cells)} "
        f"({1 / tried.seconds_per_cell:,.0f} cells/s, from {tried.cells:,} cells spread over the map)"
    )
    if tried.at_step_limit:
        share = screen.share_text(tried.at_step_limit / tried.cells)
        console.print(
            f"steps    {tried.at_step_limit:,} of these cells ({share}) ended at the step limit: unresolved "
            f"with solver: {{max_steps: {options.max_steps}}}",
            markup=False,
        )
    for name, target in ((study.name, loaded.output.file), ("plot", loaded.output.plot)):
        if target is not None:
            console.print(f"{name:8} {target}", markup=False)
    if loaded.output.file is None:
        command = keeping(["run", str(config), "-o", f"{config.stem}.nc"])
        console.print(f"{study.name:8} not kept, no output is named; to keep it: {command}", markup=False)
