"""`plan`: what a run takes, on this machine and on many."""

from __future__ import annotations

import shlex
from collections.abc import Iterator
from math import ceil
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from stickslip.cli import params, screen
from stickslip.cli.exits import JSON, fields, reports_errors
from stickslip.cli.outputs import plot_limits
from stickslip.cli.run import study_answer

if TYPE_CHECKING:
    from stickslip.config.model import Config
    from stickslip.runs.estimate import Estimate, NodeEstimate

_MARGIN, _START = 1.5, 10  # of what is resources of sbatch: a factor, and minutes to load, or to compile
_TASK = "$SLURM_ARRAY_TASK_ID"


@click.command(
    epilog="""\b
Examples:
  stickslip plan configs/quickstart.yaml
  stickslip plan my.yaml --nodes 40 --threads 64"""
)
@params.CONFIG
@click.option("--nodes", type=click.IntRange(1), metavar="N", help="Plan for N nodes too, each with --threads threads.")
@params.THREADS
@JSON
@reports_errors
def plan(config: Path, nodes: int | None) -> dict[str, Any]:
    """Estimate what a run takes: time, memory, disk space.

    Times a few cells spread over the map. Nothing is written. With --nodes it says how shards share the work, and how
    they are submitted.
    """
    from stickslip.runs.estimate import estimate

    loaded = params.configuration(config)
    params.configured_targets(loaded)  # what keeps a run from beginning is no plan
    whole = estimate(loaded)
    shared = None if nodes is None else whole.on(nodes, loaded.execution.threads or whole.tried.threads)
    lines = {} if shared is None else _shell_lines(config, loaded, shared)
    screen.echo(f"{loaded.title}\n{whole.study.described()}")
    screen.print_rows([*_here(loaded, whole), *(_on_nodes(whole, shared, lines) if shared else ())])
    return _answer(loaded, whole, shared, lines)


def _here(loaded: Config, whole: Estimate) -> Iterator[tuple[str, str]]:
    """The estimate for this machine, in rows of a label and a text."""
    from stickslip.runs.estimate import DISK

    study, tried = whole.study, whole.tried
    yield "blocks", f"{whole.blocks.count:,} of up to {whole.largest:,} {study.counted}, {whole.at_once} at a time"
    if whole.map_cells:
        yield from _space(loaded, whole)
    rate = f"{1 / tried.seconds_per_cell:,.0f} cells/s, from {tried.cells:,} cells spread over the map"
    yield "time", f"about {screen.duration_text(whole.seconds)} ({rate})"
    if last := whole.last_write:
        files = f", {last.files:,} files" if last.files > 1 else ""
        text = (
            f"about {screen.duration_text(last.seconds)} at the end, by one process, at {screen.memory(DISK)}/s of disk"
        )
        yield "write", f"{text}: {screen.memory(last.size)}{files}"
    if tried.at_step_limit:
        share = screen.share_text(tried.at_step_limit / tried.cells)
        limit = f"unresolved with solver: {{max_steps: {study.options.max_steps}}}"
        yield "steps", f"{tried.at_step_limit:,} of these cells ({share}) ended at the step limit: {limit}"
    for name, target in ((study.name, loaded.output.file), ("plot", loaded.output.plot)):
        if target is not None:
            yield name, target
    if loaded.output.plot is not None and (part := plot_limits(loaded)):
        yield "", part
    if loaded.output.file is None:
        yield study.name, "not kept, no output is named: run -o FILE.nc writes a file"


def _space(loaded: Config, whole: Estimate) -> Iterator[tuple[str, str]]:
    """Memory and disk space of a map."""
    size, stored = screen.memory(whole.whole), screen.memory(whole.store)
    if loaded.study is not None and loaded.study.is_map:
        yield "cells", f"about {whole.cells:,} are computed; more if the borders between regimes are long"
    yield "memory", f"about {screen.memory(whole.memory)} besides the program ({size} without a file)"
    map_size = "as much" if stored == size else f"{size}, before compression,"
    yield "disk", f"up to {stored} for finished blocks, and {map_size} for the map"
    if whole.each > 1:
        names = loaded.output.variables
        variables = f"{len(names)} variables" if names else "all variables"
        yield "", f"{whole.each} bytes a cell for {variables}; output.variables chooses"


def _on_nodes(whole: Estimate, shared: NodeEstimate, lines: dict[str, str]) -> Iterator[tuple[str, str]]:
    """The estimate for many machines."""
    share = f"{shared.most:,}" if shared.least == shared.most else f"{shared.least:,} or {shared.most:,}"
    threads = f"{shared.threads} thread{'s' * (shared.threads != 1)} each"
    longest, alone = screen.duration_text(shared.seconds), screen.duration_text(shared.seconds_of_one)
    yield "nodes", f"{shared.nodes:,} of {threads}, if a thread there is as fast as one here"
    yield "shards", f"{shared.shards:,} of {share} blocks"
    yield "lasts", f"about {longest} for the longest shard, {alone} on one node"
    if whole.blocks.count < shared.nodes:
        yield "", f"there are only {whole.blocks.count:,} blocks: further nodes have nothing to compute"
    elif shared.most < shared.threads:
        yield "", f"a shard has fewer blocks than a node has threads: only {shared.most} of them will compute"
    yield "submit", lines["submit"]
    yield "status", lines["status"]
    yield "collect", f"{lines['collect']}    # once all are done"


def _shell_lines(config: Path, loaded: Config, shared: NodeEstimate) -> dict[str, str]:
    """The lines for the shell; shards are counted from 1."""
    from stickslip.files.locations import location
    from stickslip.runs.block_store import beside

    output = loaded.output.file or f"{config.stem}.nc"
    named = [] if loaded.output.file else ["-o", output]
    again = params.settings_again()
    threads = [] if "--threads" in again else ["--threads", str(shared.threads)]
    run = shlex.join(["stickslip", "run", str(config), *named, *again, *threads])
    run += f" --shard {_TASK}/{shared.shards}"
    store = str(beside(location(output)))
    minutes = ceil(_MARGIN * shared.seconds / 60) + _START
    resources = f"--cpus-per-task={shared.threads} --mem={ceil(_MARGIN * shared.memory / 1e6)}M --time={minutes}"
    return {
        "submit": f"sbatch --array=1-{shared.shards} {resources} --wrap={shlex.quote(run)}",
        "status": shlex.join(["stickslip", "status", store]),
        "collect": shlex.join(["stickslip", "collect", store]),
    }


def _answer(loaded: Config, whole: Estimate, shared: NodeEstimate | None, lines: dict[str, str]) -> dict[str, Any]:
    nodes = shared and lines | fields(
        shared, "nodes", "threads", "shards", "seconds",
        blocks_least="least", blocks_most="most", seconds_one_node="seconds_of_one", bytes_memory="memory",
    )  # fmt: skip
    return (
        study_answer(loaded.title, whole.study, whole.blocks.size)
        | fields(whole, "cells", "seconds", block_items="largest", bytes_per_cell="each", bytes_memory="memory",
                 bytes_store="store", bytes_map="whole")
        | fields(whole.tried, "threads", probed="cells", probed_at_step_limit="at_step_limit")
        | fields(loaded.output, "plot", output="file")
        | {"blocks": whole.blocks.count, "cells_per_second": 1.0 / whole.tried.seconds_per_cell, "nodes": nodes,
           "last_write": whole.last_write and fields(whole.last_write, "seconds", "files", bytes="size")}
    )  # fmt: skip
