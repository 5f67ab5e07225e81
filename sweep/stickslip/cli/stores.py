"""`collect`, `status` and `retry-failed`: runs in parts."""

from __future__ import annotations

import shlex
from dataclasses import replace
from typing import TYPE_CHECKING

import click

from stickslip.cli import answers, screen
from stickslip.cli.carried import carried_out, notice, report
from stickslip.cli.common import (
    DASK,
    JSON,
    OUTPUT,
    QUIET,
    SET,
    THREADS,
    Command,
    fail,
    incomplete,
    reports_wrong_input,
    settings,
    tell_json,
    write_table_asked_for,
)

if TYPE_CHECKING:
    from stickslip.files.locations import Location
    from stickslip.runs.collecting import Status
    from stickslip.runs.request import Request

STORE = click.option("--store", metavar="PATH_OR_URL", help="Store of the configuration, if it is not OUTPUT.parts.")


def PLACE(command: Command) -> Command:  # noqa: N802, a decorator
    """The argument `config_or_store`, and `--set` for the former."""
    return click.argument("config_or_store")(SET(command))


@click.command(
    epilog="""\b
Examples:
  stickslip collect my.yaml
  stickslip collect map.nc.parts -o so_far.nc"""
)
@PLACE
@STORE
@OUTPUT
@click.option("--keep-parts", is_flag=True, help="Leave the finished blocks where they are.")
@QUIET
@JSON
@reports_wrong_input
def collect(config_or_store: str, store: str | None, output: Location | None, keep_parts: bool, as_json: bool) -> None:
    """Write the map from the blocks that are finished.

    Shards are merged; cells of blocks that are missing are "not computed", and those blocks can still be computed
    later: then the exit code is 1. Names a configuration, or the folder or URL of a store.
    """
    from stickslip.errors import StoreError
    from stickslip.runs import collecting
    from stickslip.runs.request import request_for

    request = replace(request_for(config_or_store, output, store, settings()), keep=keep_parts, notice=notice)
    try:
        collected = collecting.collect(request)
    except StoreError as error:
        fail(f"{error.on_command_line}{_where_blocks_are(request, config_or_store)}")
    study = collected.study
    if collected.up_to_date:
        screen.echo(f"{study.name:8} {collected.output} is complete already, and there is no store beside it")
    else:
        screen.echo(f"{study.name:8} {collected.output} ({screen.size_of(collected.output)})")
    if collected.where:
        screen.echo(f"blocks   kept in {collected.where}")
    if as_json:
        tell_json(answers.of_collected(request, collected))
    if collected.missing:
        write_table_asked_for({"output": output})
        incomplete(
            f"{collected.output}: incomplete: {collected.missing:,} of {collected.cells:,} {study.counted} are not "
            "computed; stickslip run computes them"
        )


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
@PLACE
@STORE
@JSON
@reports_wrong_input
def status(config_or_store: str, store: str | None, as_json: bool) -> None:
    """Show the progress of a run, and who works on it.

    Names a configuration, or the folder or URL of a store.
    """
    from stickslip.runs import collecting
    from stickslip.runs.request import request_for
    from stickslip.runs.workdir.block_store import is_empty

    request = request_for(config_or_store, None, store, settings())
    output = request.output if request.place is None else None
    if output is not None and output.exists() and is_empty(request.folder()):
        screen.echo(f"map      {output} is there, and no unfinished run beside it")
        if as_json:
            tell_json(answers.of_finished(request.config, output))
        return
    found = collecting.status(request)
    _show(found)
    if as_json:
        tell_json(answers.of_status(found))


def _show(found: Status) -> None:
    missing = found.blocks - found.blocks_finished - len(found.failures)
    share = f"{found.cells_finished:,} of {found.cells:,} {found.counted}"
    share += f" ({found.cells_finished / max(found.cells, 1):.1%})"
    screen.echo(found.title)
    begun = f"{found.begun} by stickslip {found.version}"
    screen.echo(f"store     {found.where} ({screen.memory(found.size)}), begun {begun}")
    screen.echo(f"finished  {share}")
    screen.echo(
        f"blocks    {found.blocks_finished:,} finished, {missing:,} missing, {len(found.failures):,} failed, "
        f"of {found.blocks:,}"
    )
    for one in found.shards:
        who = (
            "its process has died" + ": submit it again" * bool(one.missing)
            if one.holder is None
            else f"held by {one.holder}"
        )
        screen.echo(f"shard     {one.shard}: {len(one.missing):,} of {one.blocks:,} blocks missing; {who}")
    of_shards = [one.holder for one in found.shards]
    for holder in found.holders:
        if holder not in of_shards:
            screen.echo(f"held      by {holder}")
    if not found.holders:
        whole = found.blocks_finished == found.blocks
        screen.echo(f"held      by no process: stickslip {'collect writes the result' if whole else 'run resumes it'}")
    for failure in found.failures:
        screen.echo(f"failed    block {failure.block}: {failure.message}")
    if found.failures and found.failures[0].traceback:
        lines = found.failures[0].traceback.splitlines()
        screen.echo("\n".join([f"\nWhat happened in block {found.failures[0].block}:", *lines]))


@click.command("retry-failed")
@PLACE
@STORE
@OUTPUT
@DASK
@THREADS
@QUIET
@reports_wrong_input
def retry_failed(config_or_store: str, store: str | None, output: Location | None, dask: str | None) -> None:
    """Retry the blocks that failed.

    The map is written if nothing is missing then. Names a configuration, or the folder or URL of a store.
    """
    from stickslip.runs import session
    from stickslip.runs.request import request_for
    from stickslip.runs.work import study_of

    request = replace(request_for(config_or_store, output, store, settings()), dask=dask)
    study = study_of(request.config)
    outcome, seconds = carried_out(session.retry_failed, request, study)
    if outcome.output is not None:
        report(outcome, seconds, request, None)
    else:
        screen.echo(f"blocks   {outcome.computed:,} {study.counted} computed into {outcome.where}")
