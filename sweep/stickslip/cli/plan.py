"""`plan`: what a run takes, on this machine and on many."""

from __future__ import annotations

import shlex
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from stickslip.cli import params, screen
from stickslip.cli.exits import JSON, reports_errors
from stickslip.cli.outputs import plot_limits
from stickslip.cli.run import resume_command, study_answer

if TYPE_CHECKING:
    from stickslip.config.model import Config
    from stickslip.runs.estimate import Estimate, Nodes

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
    whole = estimate(loaded)
    shared = None if nodes is None else whole.on(nodes, loaded.execution.threads or whole.tried.threads)
    lines = {} if shared is None else _shell_lines(config, loaded, shared)
    _show(config, loaded, whole)
    if shared is not None:
        _show_nodes(whole, shared, lines)
    return _answer(loaded, whole, shared, lines)


def _show(config: Path, loaded: Config, whole: Estimate) -> None:
    """Print the estimate for this machine."""
    study, tried = whole.study, whole.tried
    screen.echo(f"{loaded.title}\n{study.described()}")
    screen.echo(
        f"blocks   {whole.blocks.count:,} of up to {whole.largest:,} {study.counted}, {whole.at_once} at a time"
    )
    if whole.map_cells:
        _show_space(loaded, whole)
    screen.echo(
        f"time     about {screen.duration_text(whole.seconds)} "
        f"({1 / tried.seconds_per_cell:,.0f} cells/s, from {tried.cells:,} cells spread over the map)"
    )
    if tried.at_step_limit:
        share = screen.share_text(tried.at_step_limit / tried.cells)
        screen.echo(
            f"steps    {tried.at_step_limit:,} of these cells ({share}) ended at the step limit: unresolved "
            f"with solver: {{max_steps: {study.options.max_steps}}}"
        )
    for name, target in ((study.name, loaded.output.file), ("plot", loaded.output.plot)):
        if target is not None:
            screen.echo(f"{name:8} {target}")
    if loaded.output.plot is not None and (part := plot_limits(loaded)):
        screen.echo(f"         {part}")
    if loaded.output.file is None:
        command = resume_command(["run", str(config), "-o", f"{config.stem}.nc"])
        screen.echo(f"{study.name:8} not kept, no output is named; to keep it: {command}")


def _show_space(loaded: Config, whole: Estimate) -> None:
    """Print memory and disk space of a map."""
    size, stored = screen.memory(whole.whole), screen.memory(whole.store)
    if loaded.study is not None and loaded.study.is_map:
        screen.echo(f"cells    about {whole.cells:,} are computed; more if the borders between regimes are long")
    screen.echo(f"memory   about {screen.memory(whole.memory)} besides the program ({size} without a file)")
    map_size = "as much" if stored == size else f"{size}, before compression,"
    screen.echo(f"disk     up to {stored} for finished blocks, and {map_size} for the map")
    if whole.each > 1:
        names = loaded.output.variables
        variables = f"{len(names)} variables" if names else "all variables"
        screen.echo(f"         {whole.each} bytes a cell for {variables}; output.variables chooses")


def _show_nodes(whole: Estimate, shared: Nodes, lines: dict[str, str]) -> None:
    """Print the estimate for many machines."""
    share = f"{shared.most:,}" if shared.least == shared.most else f"{shared.least:,} or {shared.most:,}"
    threads = f"{shared.threads} thread{'s' * (shared.threads != 1)} each"
    screen.echo(f"nodes    {shared.nodes:,} of {threads}, if a thread there is as fast as one here")
    screen.echo(f"shards   {shared.shards:,} of {share} blocks")
    screen.echo(
        f"lasts    about {screen.duration_text(shared.seconds)} for the longest shard, "
        f"{screen.duration_text(shared.seconds_of_one)} on one node"
    )
    if whole.blocks.count < shared.nodes:
        screen.echo(f"         there are only {whole.blocks.count:,} blocks: further nodes have nothing to compute")
    elif shared.most < shared.threads:
        idle = f"only {shared.most} of them will compute"
        screen.echo(f"         a shard has fewer blocks than a node has threads: {idle}")
    screen.echo(f"submit   {lines['submit']}")
    screen.echo(f"status   {lines['status']}")
    screen.echo(f"collect  {lines['collect']}    # once all are done")


def _shell_lines(config: Path, loaded: Config, shared: Nodes) -> dict[str, str]:
    """The lines for the shell; shards are counted from 1."""
    output = loaded.output.file or f"{config.stem}.nc"
    named = [] if loaded.output.file else ["-o", output]
    again = params.settings_again()
    threads = [] if "--threads" in again else ["--threads", str(shared.threads)]
    run = shlex.join(["stickslip", "run", str(config), *named, *again, *threads])
    run += f" --shard {_TASK}/{shared.shards}"
    store = f"{output}.parts"
    return {
        "submit": f"sbatch --array=1-{shared.shards} --cpus-per-task={shared.threads} --wrap={shlex.quote(run)}",
        "status": shlex.join(["stickslip", "status", store]),
        "collect": shlex.join(["stickslip", "collect", store]),
    }


def _answer(loaded: Config, whole: Estimate, shared: Nodes | None, lines: dict[str, str]) -> dict[str, Any]:
    """The estimate for programs."""
    nodes = shared and {
        "nodes": shared.nodes,
        "threads": shared.threads,
        "shards": shared.shards,
        "blocks_least": shared.least,
        "blocks_most": shared.most,
        "seconds": shared.seconds,
        "seconds_one_node": shared.seconds_of_one,
        **lines,
    }
    return {
        **study_answer(loaded.title, whole.study, whole.blocks.size),
        "cells": whole.cells,
        "blocks": whole.blocks.count,
        "block_items": whole.largest,
        "threads": whole.tried.threads,
        "bytes_per_cell": whole.each,
        "bytes_memory": whole.memory,
        "bytes_store": whole.store,
        "bytes_map": whole.whole,
        "seconds": whole.seconds,
        "cells_per_second": 1.0 / whole.tried.seconds_per_cell,
        "probed": whole.tried.cells,
        "probed_at_step_limit": whole.tried.at_step_limit,
        "output": loaded.output.file,
        "plot": loaded.output.plot,
        "nodes": nodes,
    }
