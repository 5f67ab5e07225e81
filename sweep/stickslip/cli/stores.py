"""`collect`, `status` and `retry-failed`: runs in parts."""

from __future__ import annotations

import shlex
import signal
from collections.abc import Iterator
from dataclasses import asdict, replace
from math import ceil, prod
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from stickslip.cli import params, screen
from stickslip.cli.outputs import Outputs, save_table, show_file
from stickslip.cli.run import execute, report_result, study_answer
from stickslip.cli.screen import JSON, fields, incomplete, print_json, reports_errors

if TYPE_CHECKING:
    from stickslip.config.model import Config
    from stickslip.files.locations import Location
    from stickslip.runs.report import Estimate, NodeEstimate, Status


def STORE(command: params.Command) -> params.Command:  # noqa: N802, a decorator
    """The argument `config_or_store` with the option `--set` for the former."""
    return params.decorated(command, click.argument("config_or_store"), params.SET)


@click.command(
    epilog="""\b
Examples:
  stickslip collect my.yaml
  stickslip collect map.nc.parts -o so_far.nc"""
)
@STORE
@params.OUTPUT
@JSON
@reports_errors
def collect(config_or_store: str, output: Location | None) -> dict[str, Any]:
    """Write the map from the blocks that are finished.

    Shards are merged; cells of blocks that are missing are "not computed", and those blocks can still be computed
    later: then the exit code is 1. Names a configuration, or the folder of a store.
    """
    from stickslip.files import reading
    from stickslip.runs import report
    from stickslip.runs.session import request_for

    request = request_for(config_or_store, output, None, params.settings())
    collected = report.collect(replace(request, notice=screen.notice))
    study = collected.study
    if collected.up_to_date:
        screen.row(study.name, f"{collected.output} is complete already, and there is no store beside it")
    else:
        show_file(study.name, collected.output)
    if collected.where:
        screen.row("blocks", f"kept in {collected.where}")
    if table := params.requested_table():
        with reading.look_into(collected.output) as ds:
            save_table(ds, table)
    answer = study_answer(request.config.title, study, collected.cells) | {
        "items_finished": collected.cells - collected.missing,
        **fields(collected, "up_to_date", "output", items_missing="missing", store="where"),
    }
    if collected.missing:
        print_json(answer)
        incomplete(
            f"{collected.output}: incomplete: {collected.missing:,} of {collected.cells:,} {study.counted} are not "
            "computed; stickslip run computes them"
        )
    return answer


@click.command("retry-failed")
@STORE
@params.OUTPUT
@reports_errors
def retry_failed(config_or_store: str, output: Location | None) -> None:
    """Retry the blocks that failed.

    The map is written if nothing is missing then. Names a configuration, or the folder of a store.
    """
    from stickslip.runs import session
    from stickslip.runs.session import request_for
    from stickslip.runs.work import study_of

    signal.signal(signal.SIGTERM, signal.default_int_handler)
    request = replace(request_for(config_or_store, output, None, params.settings()), notice=screen.notice)
    study = study_of(request.config)
    outcome, seconds = execute(session.retry_failed, request, study)
    if outcome.output is not None:
        report_result(outcome, seconds, request, Outputs())
    else:
        screen.row("blocks", f"{outcome.computed:,} {study.counted} computed into {outcome.where}")


@click.command()
@STORE
@JSON
@reports_errors
def status(config_or_store: str) -> dict[str, Any]:
    """Show the progress of a run, and who works on it.

    Names a configuration, or the folder of a store.
    """
    from stickslip.runs import report
    from stickslip.runs.block_store import is_empty
    from stickslip.runs.session import request_for

    request = request_for(config_or_store, None, None, params.settings())
    output = request.output if request.place is None else None
    if output is not None and output.exists() and is_empty(request.folder()):
        screen.row("map", f"{output} is there, and no unfinished run beside it")
        return _finished_answer(request.config, output)
    progress = report.status(request)
    _show(progress)
    return _status_answer(progress)


def _show(progress: Status) -> None:
    failures, blocks, finished = progress.failures, progress.blocks, progress.blocks_finished
    share, missing = f"{progress.cells_finished / max(progress.cells, 1):.1%}", blocks - finished - len(failures)
    begun = f"begun {progress.begun} by stickslip {progress.version}"
    rows = [
        ("store", f"{progress.where}, {begun}"),
        ("finished", f"{progress.cells_finished:,} of {progress.cells:,} {progress.counted} ({share})"),
        ("blocks", f"{finished:,} finished, {missing:,} missing, {len(failures):,} failed, of {blocks:,}"),
    ]
    for shard in progress.shards:
        state = f"held by {shard.holder}" if shard.holder else "no process works on it: submit it again"
        rows.append(("shard", f"{shard.shard}: {len(shard.missing):,} of {shard.blocks:,} blocks missing; {state}"))
    of_shards = [shard.holder for shard in progress.shards]
    rows += [("held", f"by {holder}") for holder in progress.holders if holder not in of_shards]
    if not progress.holders:
        next_command = "collect writes the result" if finished == blocks else "run resumes it"
        rows.append(("held", f"by no process: stickslip {next_command}"))
    rows += [("failed", f"block {failure.block}: {failure.message}") for failure in failures]
    screen.echo(progress.title)
    screen.print_rows(rows)
    if failures and failures[0].traceback:
        screen.echo(f"\nWhat happened in block {failures[0].block}:\n{failures[0].traceback.rstrip()}")


# --- for programs -----------------------------------------------------------------------------------------------------

_SAME = ("title", "counted", "blocks", "blocks_finished", "begun", "version")
_OTHERWISE = {"store": "where", "items": "cells", "items_finished": "cells_finished"}


def _finished_answer(config: Config, output: Location) -> dict[str, Any]:
    from stickslip.dataset.summary import summary
    from stickslip.files import reading
    from stickslip.runs.work import study_of

    study = study_of(config)
    with reading.look_into(output) as ds:
        missing = summary(ds).get("not_computed") if "regime" in ds else None
    items = prod(study.shape)
    return dict.fromkeys((*_SAME, *_OTHERWISE, "blocks_failed", "failures", "holders", "shards")) | {
        "title": config.title, "counted": study.counted, "items": items,
        "items_finished": items - (missing.cells if missing else 0), "output": output, "finished": True,
    }  # fmt: skip


def _status_answer(progress: Status) -> dict[str, Any]:
    return fields(progress, *_SAME, **_OTHERWISE) | {
        "blocks_failed": len(progress.failures),
        "failures": [asdict(failure) for failure in progress.failures],
        "holders": [fields(holder, "user", "host", "pid", "since", "seen") for holder in progress.holders],
        "shards": [
            {"shard": str(shard.shard)} | fields(shard, "blocks", "missing") | {"held": shard.holder is not None}
            for shard in progress.shards
        ],
        "output": None,
        "finished": False,
    }


_MARGIN, _START = 1.5, 10  # of what is resources of sbatch: a factor, and minutes to load, or to compile
_TASK = "$SLURM_ARRAY_TASK_ID"


@click.command(
    epilog="""\b
Examples:
  stickslip plan configs/quickstart.yaml
  stickslip plan my.yaml --nodes 40 --set execution.threads=64"""
)
@params.CONFIG
@click.option("--nodes", type=click.IntRange(1), metavar="N", help="Plan for N nodes too, each with execution.threads.")
@JSON
@reports_errors
def plan(config: Path, nodes: int | None) -> dict[str, Any]:
    """Estimate what a run takes: time, memory, disk space.

    Times a few cells spread over the map. Nothing is written. With --nodes it says how shards share the work, and how
    they are submitted.
    """
    from stickslip.runs.report import estimate

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
    study, tried, blocks = whole.study, whole.tried, whole.blocks
    largest = f"of up to {len(blocks.cells(0)):,} {study.counted}"
    yield "blocks", f"{blocks.count:,} {largest}, {whole.at_once} at a time"
    if whole.map_cells:
        yield from _space(loaded, whole)
    rate = f"{1 / tried.seconds_per_cell:,.0f} cells/s, from {tried.cells:,} cells spread over the map"
    yield "time", f"about {screen.duration_text(whole.seconds)} ({rate})"
    yield study.name, loaded.output.file or "not kept, no output is named: run -o FILE.nc writes a file"


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
    threads = f"{shared.threads} thread{'s' * (shared.threads != 1)} each"
    yield "nodes", f"{shared.nodes:,} of {threads}, if a thread there is as fast as one here"
    yield "shards", f"{shared.shards:,} of up to {shared.most:,} blocks"
    yield "lasts", f"about {screen.duration_text(shared.seconds)} for the longest shard"
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
    again = [given.option.removeprefix("--set ") for given in params.settings()]
    again += [] if loaded.execution.threads else [f"execution.threads={shared.threads}"]
    sets = [word for given in again for word in ("--set", given)]
    run = f"{shlex.join(['stickslip', 'run', str(config), *named, *sets])} --shard {_TASK}/{shared.shards}"
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
        shared, "nodes", "threads", "shards", "seconds", blocks_most="most", bytes_memory="memory"
    )
    return (
        study_answer(loaded.title, whole.study, whole.blocks.size)
        | fields(whole, "cells", "seconds", bytes_per_cell="each", bytes_memory="memory", bytes_store="store",
                 bytes_map="whole")
        | fields(whole.tried, "threads", probed="cells")
        | fields(loaded.output, "plot", output="file")
        | {"blocks": whole.blocks.count, "block_items": len(whole.blocks.cells(0)),
           "cells_per_second": 1.0 / whole.tried.seconds_per_cell, "nodes": nodes}
    )  # fmt: skip
