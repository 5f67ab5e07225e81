"""`collect`, `status` and `retry-failed`: runs in parts."""

from __future__ import annotations

from dataclasses import asdict, replace
from math import prod
from typing import TYPE_CHECKING, Any

import click

from stickslip.cli import params, screen
from stickslip.cli.exits import JSON, fields, incomplete, print_json, reports_errors
from stickslip.cli.outputs import Outputs, save_table, show_file
from stickslip.cli.run import execute, report_result, study_answer

if TYPE_CHECKING:
    from stickslip.config.model import Config
    from stickslip.files.locations import Location
    from stickslip.runs.collecting import Status


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
    from stickslip.runs import collecting
    from stickslip.runs.session import request_for

    request = request_for(config_or_store, output, None, params.settings())
    collected = collecting.collect(replace(request, notice=screen.notice))
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
    from stickslip.runs import collecting
    from stickslip.runs.block_store import is_empty
    from stickslip.runs.session import request_for

    request = request_for(config_or_store, None, None, params.settings())
    output = request.output if request.place is None else None
    if output is not None and output.exists() and is_empty(request.folder()):
        screen.row("map", f"{output} is there, and no unfinished run beside it")
        return _finished_answer(request.config, output)
    progress = collecting.status(request)
    _show(progress)
    return _status_answer(progress)


def _show(progress: Status) -> None:
    failures, blocks, finished = progress.failures, progress.blocks, progress.blocks_finished
    share, missing = f"{progress.cells_finished / max(progress.cells, 1):.1%}", blocks - finished - len(failures)
    begun = f"begun {progress.begun} by stickslip {progress.version}"
    rows = [
        ("store", f"{progress.where} ({screen.memory(progress.size)}), {begun}"),
        ("finished", f"{progress.cells_finished:,} of {progress.cells:,} {progress.counted} ({share})"),
        ("blocks", f"{finished:,} finished, {missing:,} missing, {len(failures):,} failed, of {blocks:,}"),
    ]
    for shard in progress.shards:
        nobody = "its process has died" if shard.died else "no process works on it"
        again = ": submit it again" if shard.missing else ""
        state = f"{nobody}{again}" if shard.holder is None else f"held by {shard.holder}"
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
_OTHERWISE = {"store": "where", "items": "cells", "items_finished": "cells_finished", "bytes": "size"}
_LISTS = ("blocks_failed", "failures", "holders", "shards")


def _finished_answer(config: Config, output: Location) -> dict[str, Any]:
    from stickslip.dataset.summary import summary
    from stickslip.files import reading
    from stickslip.runs.work import study_of

    study = study_of(config)
    with reading.look_into(output) as ds:
        missing = summary(ds).get("not_computed") if "regime" in ds else None
    items = prod(study.shape)
    return dict.fromkeys((*_SAME, *_OTHERWISE, *_LISTS)) | {
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
