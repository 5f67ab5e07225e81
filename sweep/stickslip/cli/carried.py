"""How the commands carry out a run in parts: with a progress bar, notices, and a word on Ctrl-C."""

from __future__ import annotations

import signal
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from time import perf_counter
from typing import TYPE_CHECKING

import click

from stickslip.cli import screen
from stickslip.cli.common import incomplete, prepare_kernels

if TYPE_CHECKING:
    from stickslip.runs.request import Outcome, Request


def carried_out(action: Callable[[Request], Outcome], request: Request, cells: int) -> tuple[Outcome, float]:
    """The outcome of `action`, and the seconds it computed. Ctrl-C and SIGTERM end the command."""
    from stickslip.errors import Interrupted

    signal.signal(signal.SIGTERM, signal.default_int_handler)  # what schedulers send before they kill
    began = finished = perf_counter()
    moving = False

    def prepare(law: str) -> None:
        nonlocal began, finished
        prepare_kernels(law)
        began = finished = perf_counter()

    try:
        with screen.progress_bar(cells) as move, screen.progress_bar(cells, " written") as write:

            def note(done: int, of: int) -> None:
                nonlocal began, finished, moving
                finished = perf_counter()
                if not moving and request.cluster is not None:
                    began = finished  # connecting is not computing
                moving = True
                move(done, of)

            told = replace(request, progress=note, assembling=write, notice=notice, prepare=prepare)
            outcome = action(told)
    except Interrupted as interrupted:
        incomplete(interrupted)
    return outcome, finished - began


def notice(text: str) -> None:
    """Something worth knowing, on standard error."""
    click.echo(text, err=True)


def report(outcome: Outcome, seconds: float, request: Request, plot: Path | None) -> None:
    """The plot and the summary of a run that wrote its map; of one that had nothing to do, a missing plot."""
    from stickslip.files import reading
    from stickslip.runs.work import options_of

    if outcome.output is None:
        return
    if outcome.up_to_date:
        click.echo(f"map      {outcome.output} is complete already; --fresh computes it again")
        if plot is None or plot.exists():
            return
    with reading.open(outcome.output) as ds:
        if plot is not None and ds["regime"].ndim:
            from stickslip import plots

            plots.save(plots.plot_map(ds), plot)
        if outcome.up_to_date:
            return click.echo(f"plot     {plot}")
        machines = outcome.machines or screen.threads(options_of(request.config))
        screen.report(ds, outcome.computed, seconds, machines, outcome.output, plot)
    if outcome.reused:
        click.echo(f"reused   {outcome.reused:,} cells of the earlier map")
    if outcome.where:
        click.echo(f"blocks   kept in {outcome.where}")
