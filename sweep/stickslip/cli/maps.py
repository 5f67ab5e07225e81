"""`run`: what a configuration asks for."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Literal

import click

from stickslip.cli.backdrop import Extras
from stickslip.cli.carried import run_request
from stickslip.cli.common import (
    CONFIG,
    DASK,
    EXIT_CODES,
    JSON,
    OUTPUT,
    QUIET,
    THREADS,
    Target,
    configuration,
    fail,
    location_or_none,
    reports_wrong_input,
    tell_json,
)

if TYPE_CHECKING:
    from stickslip.files.locations import Location
    from stickslip.runs.blocks import Shard


@click.command(
    epilog=f"""\b
Examples:
  stickslip run configs/quickstart.yaml
  stickslip run my.yaml --output results/map.zarr --no-plot
  stickslip run my.yaml -o s3://bucket/map.zarr
  stickslip run my.yaml --set axes.belt_speed.num=50 --set "system.mass=200 g"
  stickslip run my.yaml --shard 3/40        # 1/40 to 40/40; then: stickslip collect my.yaml
  stickslip run my.yaml --dask tcp://login1:8786
\n{EXIT_CODES}"""
)
@CONFIG
@OUTPUT
@click.option("--plot", type=Target("plot"), help="Plot to write: .png, .svg or .pdf.")
@click.option("--report", type=Target("page"), help="Page to write (.html, .pdf): plots, shares, meanings.")
@click.option("--no-plot", is_flag=True, help="Write no plot.")
@click.option("--store", metavar="PATH_OR_URL", help="Where finished blocks are kept.  [default: OUTPUT.parts]")
@click.option("--shard", metavar="I/N", help="Compute only share I of N, from 1, of the blocks, and write no map.")
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
@THREADS
@QUIET
@JSON
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
    as_json: bool,
) -> None:
    """Compute the map a configuration asks for.

    Writes the file and the plot named in its `output` section, or by the options. Finished blocks are kept in
    OUTPUT.parts until the map is written: whatever stops a run, the same command resumes from there. Without an
    output the map is counted, plotted if a plot is asked for, and not kept.
    """
    from stickslip.runs.request import Request

    loaded = configuration(config)
    if shard and isinstance(output, Path) and not output.absolute().parent.is_dir():
        fail(f"{output}: no folder {output.parent}, which all shards need to see; make it first, or correct its name")
    output = output or location_or_none(loaded.output.file, "result")
    target = None if no_plot or shard else plot or location_or_none(loaded.output.plot, "plot")
    part = _shard(shard, fresh)
    request = Request(loaded, output, store, part, fresh, keep_parts, on_error, dask=dask)
    keep = ["run", str(config), "-o", f"{config.stem}.nc"]
    answer = run_request(request, target, keep, Extras(page=None if shard else report))
    if as_json:
        tell_json(answer)


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
