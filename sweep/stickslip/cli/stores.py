"""`collect`, `status` and `retry-failed`: runs in parts."""

from __future__ import annotations

import shlex
from dataclasses import asdict, replace
from math import prod
from typing import TYPE_CHECKING, Any

import click

from stickslip.cli import params, screen
from stickslip.cli.exits import JSON, QUIET, fail, incomplete, print_json, reports_errors
from stickslip.cli.outputs import Outputs, save_table, show_file
from stickslip.cli.run import execute, report_result, study_answer

if TYPE_CHECKING:
    from stickslip.config.model import Config
    from stickslip.files.locations import Location
    from stickslip.runs.collecting import Collected, Status
    from stickslip.runs.session import Request


def STORE(command: params.Command) -> params.Command:  # noqa: N802, a decorator
    """The argument `config_or_store` with the option `--set` for the former, and the option `--store`."""
    text = "Store of the configuration, if it is not OUTPUT.parts."
    option = click.option("--store", metavar="PATH_OR_URL", help=text)
    return params.decorated(command, click.argument("config_or_store"), params.SET, option)


@click.command(
    epilog="""\b
Examples:
  stickslip collect my.yaml
  stickslip collect map.nc.parts -o so_far.nc"""
)
@STORE
@params.OUTPUT
@params.KEEP_PARTS
@QUIET
@JSON
@reports_errors
def collect(config_or_store: str, store: str | None, output: Location | None, keep_parts: bool) -> dict[str, Any]:
    """Write the map from the blocks that are finished.

    Shards are merged; cells of blocks that are missing are "not computed", and those blocks can still be computed
    later: then the exit code is 1. Names a configuration, or the folder or URL of a store.
    """
    from stickslip.errors import StoreError
    from stickslip.files import reading
    from stickslip.runs import collecting
    from stickslip.runs.session import request_for

    request = request_for(config_or_store, output, store, params.settings())
    request = replace(request, keep=keep_parts, notice=screen.notice)
    try:
        collected = collecting.collect(request)
    except StoreError as error:
        fail(f"{error.on_command_line}{_where_blocks_are(request, config_or_store)}")
    study = collected.study
    if collected.up_to_date:
        screen.echo(f"{study.name:8} {collected.output} is complete already, and there is no store beside it")
    else:
        show_file(study.name, collected.output)
    if collected.where:
        screen.echo(f"blocks   kept in {collected.where}")
    if table := params.requested_table():
        with reading.look_into(collected.output) as ds:
            save_table(ds, table)
    answer = _collected_answer(request, collected)
    if collected.missing:
        print_json(answer)
        incomplete(
            f"{collected.output}: incomplete: {collected.missing:,} of {collected.cells:,} {study.counted} are not "
            "computed; stickslip run computes them"
        )
    return answer


def _where_blocks_are(request: Request, named: str) -> str:
    """The command that collects, where there is no store beside the output that is named and one beside the usual."""
    from stickslip.files.locations import location

    usual = request.config.output.file
    if request.place is not None or usual is None or request.folder().names():
        return ""
    there = replace(request, output=location(usual)).folder()
    if not there.names() or there.where == request.folder().where:
        return ""
    command = shlex.join(["stickslip", "collect", there.where, "-o", str(request.output)])
    return f"\nhint: the blocks of {named} are in {there.where}: {command}"


@click.command()
@STORE
@JSON
@reports_errors
def status(config_or_store: str, store: str | None) -> dict[str, Any]:
    """Show the progress of a run, and who works on it.

    Names a configuration, or the folder or URL of a store.
    """
    from stickslip.runs import collecting
    from stickslip.runs.session import request_for
    from stickslip.runs.workdir.block_store import is_empty

    request = request_for(config_or_store, None, store, params.settings())
    output = request.output if request.place is None else None
    if output is not None and output.exists() and is_empty(request.folder()):
        screen.echo(f"map      {output} is there, and no unfinished run beside it")
        return _finished_answer(request.config, output)
    progress = collecting.status(request)
    _show(progress)
    return _status_answer(progress)


def _show(progress: Status) -> None:
    failures, blocks, finished = progress.failures, progress.blocks, progress.blocks_finished
    share = f"{progress.cells_finished / max(progress.cells, 1):.1%}"
    begun = f"{progress.begun} by stickslip {progress.version}"
    screen.echo(progress.title)
    screen.echo(f"store     {progress.where} ({screen.memory(progress.size)}), begun {begun}")
    screen.echo(f"finished  {progress.cells_finished:,} of {progress.cells:,} {progress.counted} ({share})")
    missing = blocks - finished - len(failures)
    screen.echo(f"blocks    {finished:,} finished, {missing:,} missing, {len(failures):,} failed, of {blocks:,}")
    for shard in progress.shards:
        died = "its process has died" + ": submit it again" * bool(shard.missing)
        state = died if shard.holder is None else f"held by {shard.holder}"
        screen.echo(f"shard     {shard.shard}: {len(shard.missing):,} of {shard.blocks:,} blocks missing; {state}")
    of_shards = [shard.holder for shard in progress.shards]
    for holder in progress.holders:
        if holder not in of_shards:
            screen.echo(f"held      by {holder}")
    if not progress.holders:
        next_command = "collect writes the result" if finished == blocks else "run resumes it"
        screen.echo(f"held      by no process: stickslip {next_command}")
    for failure in failures:
        screen.echo(f"failed    block {failure.block}: {failure.message}")
    if failures and failures[0].traceback:
        screen.echo(f"\nWhat happened in block {failures[0].block}:\n{failures[0].traceback.rstrip()}")


@click.command("retry-failed")
@STORE
@params.OUTPUT
@params.DASK
@params.THREADS
@QUIET
@reports_errors
def retry_failed(config_or_store: str, store: str | None, output: Location | None, dask: str | None) -> None:
    """Retry the blocks that failed.

    The map is written if nothing is missing then. Names a configuration, or the folder or URL of a store.
    """
    from stickslip.runs import session
    from stickslip.runs.session import request_for
    from stickslip.runs.work import study_of

    request = replace(request_for(config_or_store, output, store, params.settings()), dask=dask)
    study = study_of(request.config)
    outcome, seconds = execute(session.retry_failed, request, study)
    if outcome.output is not None:
        report_result(outcome, seconds, request, Outputs())
    else:
        screen.echo(f"blocks   {outcome.computed:,} {study.counted} computed into {outcome.where}")


# --- for programs -----------------------------------------------------------------------------------------------------


def _collected_answer(request: Request, collected: Collected) -> dict[str, Any]:
    return {
        **study_answer(request.config.title, collected.study, collected.cells),
        "items_finished": collected.cells - collected.missing,
        "items_missing": collected.missing,
        "up_to_date": collected.up_to_date,
        "output": collected.output,
        "store": collected.where,
    }


_STATUS_KEYS = (
    *("title", "store", "counted", "items", "items_finished", "blocks", "blocks_finished", "blocks_failed", "failures"),
    *("holders", "shards", "begun", "version", "bytes", "output", "finished"),
)


def _finished_answer(config: Config, output: Location) -> dict[str, Any]:
    from stickslip.dataset.summary import summary
    from stickslip.files import reading
    from stickslip.runs.work import study_of

    study = study_of(config)
    with reading.look_into(output) as ds:
        missing = summary(ds).get("not_computed") if "regime" in ds else None
    items = prod(study.shape)
    known = {"counted": study.counted, "items": items, "items_finished": items - (missing.cells if missing else 0)}
    return {**dict.fromkeys(_STATUS_KEYS), **known, "title": config.title, "output": output, "finished": True}


def _status_answer(progress: Status) -> dict[str, Any]:
    alike = ("title", "counted", "blocks", "blocks_finished", "begun", "version")
    of_holder = ("user", "host", "pid", "since", "seen")
    return {
        **{name: getattr(progress, name) for name in alike},
        "store": progress.where,
        "items": progress.cells,
        "items_finished": progress.cells_finished,
        "blocks_failed": len(progress.failures),
        "failures": [asdict(failure) for failure in progress.failures],
        "holders": [{name: getattr(holder, name) for name in of_holder} for holder in progress.holders],
        "shards": [
            {"shard": shard.shard, "blocks": shard.blocks, "missing": shard.missing, "held": shard.holder is not None}
            for shard in progress.shards
        ],
        "bytes": progress.size,
        "output": None,
        "finished": False,
    }
