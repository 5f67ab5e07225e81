"""`plan`: what a run takes, on this machine and on many."""

from __future__ import annotations

import shlex
from pathlib import Path
from typing import TYPE_CHECKING

import click

from stickslip.cli import answers, screen, shown
from stickslip.cli.carried import keeping
from stickslip.cli.common import (
    CONFIG,
    JSON,
    THREADS,
    configuration,
    prepare_kernels,
    reports_wrong_input,
    settings_again,
    tell_json,
)

if TYPE_CHECKING:
    from rich.console import Console

    from stickslip.config.model import Config
    from stickslip.runs.estimate import Estimate, Nodes

TASK = "$SLURM_ARRAY_TASK_ID"


@click.command(
    epilog="""\b
Examples:
  stickslip plan configs/quickstart.yaml
  stickslip plan my.yaml --nodes 40 --threads 64"""
)
@CONFIG
@click.option("--nodes", type=click.IntRange(1), metavar="N", help="Plan for N nodes too, each with --threads threads.")
@THREADS
@JSON
@reports_wrong_input
def plan(config: Path, nodes: int | None, as_json: bool) -> None:
    """Estimate what a run takes: time, memory, disk space.

    Times a few cells spread over the map. Nothing is written. With --nodes it says how shards share the work, and how
    they are submitted.
    """
    from stickslip.runs.estimate import estimate

    loaded = configuration(config)
    prepare_kernels(loaded.friction.law)
    found = estimate(loaded)
    many = None if nodes is None else found.on(nodes, loaded.execution.threads or found.tried.threads)
    lines = {} if many is None else _to_submit(config, loaded, many)
    _show(config, loaded, found)
    if many is not None:
        _show_nodes(found, many, lines)
    if as_json:
        tell_json(answers.of_plan(loaded, found, many, lines))


def _show(config: Path, loaded: Config, found: Estimate) -> None:
    """For this machine."""
    console, study, tried = screen.terminal(), found.study, found.tried
    console.print(f"{loaded.title}\n{study.described()}", markup=False)
    console.print(
        f"blocks   {found.blocks.count:,} of up to {found.largest:,} {study.counted}, {found.at_once} at a time"
    )
    if found.map_cells:
        _show_space(console, loaded, found)
    console.print(
        f"time     about {screen.duration_text(found.seconds)} "
        f"({1 / tried.seconds_per_cell:,.0f} cells/s, from {tried.cells:,} cells spread over the map)"
    )
    if tried.at_step_limit:
        share = screen.share_text(tried.at_step_limit / tried.cells)
        console.print(
            f"steps    {tried.at_step_limit:,} of these cells ({share}) ended at the step limit: unresolved "
            f"with solver: {{max_steps: {study.options.max_steps}}}",
            markup=False,
        )
    for name, target in ((study.name, loaded.output.file), ("plot", loaded.output.plot)):
        if target is not None:
            console.print(f"{name:8} {target}", markup=False)
    if loaded.output.plot is not None and (part := shown.will_be_drawn(loaded)):
        console.print(f"         {part}", markup=False)
    if loaded.output.file is None:
        command = keeping(["run", str(config), "-o", f"{config.stem}.nc"])
        console.print(f"{study.name:8} not kept, no output is named; to keep it: {command}", markup=False)


def _show_space(console: Console, loaded: Config, found: Estimate) -> None:
    """Memory and disk space of a map."""
    whole, stored = screen.memory(found.whole), screen.memory(found.store)
    if loaded.refine is not None:
        console.print(f"cells    about {found.cells:,} are computed; more if the borders between regimes are long")
    console.print(f"memory   about {screen.memory(found.memory)} besides the program ({whole} without a file)")
    map_size = "as much" if stored == whole else f"{whole}, before compression,"
    console.print(f"disk     up to {stored} for finished blocks, and {map_size} for the map")
    if found.each > 1:
        names = loaded.output.variables
        held = f"{len(names)} variables" if names else "all variables"
        console.print(f"         {found.each} bytes a cell for {held}; output.variables chooses", markup=False)


def _show_nodes(found: Estimate, many: Nodes, lines: dict[str, str]) -> None:
    """For many machines."""
    share = f"{many.most:,}" if many.least == many.most else f"{many.least:,} or {many.most:,}"
    threads = f"{many.threads} thread{'s' * (many.threads != 1)} each"
    screen.echo(f"nodes    {many.nodes:,} of {threads}, if a thread there is as fast as one here")
    screen.echo(f"shards   {many.shards:,} of {share} blocks")
    screen.echo(
        f"lasts    about {screen.duration_text(many.seconds)} for the longest shard, "
        f"{screen.duration_text(many.seconds_of_one)} on one node"
    )
    if found.blocks.count < many.nodes:
        screen.echo(f"         there are only {found.blocks.count:,} blocks: further nodes have nothing to compute")
    elif many.most < many.threads:
        screen.echo(f"         a shard has fewer blocks than a node has threads: only {many.most} of them will compute")
    screen.echo(f"submit   {lines['submit']}")
    screen.echo(f"status   {lines['status']}")
    screen.echo(f"collect  {lines['collect']}    # once all are done")


def _to_submit(config: Path, loaded: Config, many: Nodes) -> dict[str, str]:
    """The lines for the shell; shards are counted from 1."""
    output = loaded.output.file or f"{config.stem}.nc"
    named = [] if loaded.output.file else ["-o", output]
    again = settings_again()
    threads = [] if "--threads" in again else ["--threads", str(many.threads)]
    run = shlex.join(["stickslip", "run", str(config), *named, *again, *threads])
    run += f" --shard {TASK}/{many.shards}"
    store = f"{output}.parts"
    return {
        "submit": f"sbatch --array=1-{many.shards} --cpus-per-task={many.threads} --wrap={shlex.quote(run)}",
        "status": shlex.join(["stickslip", "status", store]),
        "collect": shlex.join(["stickslip", "collect", store]),
    }
