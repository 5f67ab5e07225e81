"""How the commands carry out a run: with a progress bar, notices, a word on Ctrl-C, and the outcome."""

from __future__ import annotations

import shlex
import signal
from collections.abc import Callable
from contextlib import suppress
from dataclasses import replace
from importlib import import_module
from math import prod
from pathlib import Path
from threading import Thread
from time import perf_counter
from typing import TYPE_CHECKING, Any

from stickslip.cli import answers, screen, shown
from stickslip.cli.backdrop import Extras
from stickslip.cli.common import drawing, fail, incomplete, prepare_kernels, settings_again
from stickslip.cli.progress import progress_bar

if TYPE_CHECKING:
    import xarray as xr

    from stickslip.files.locations import Location
    from stickslip.runs.request import Outcome, Request
    from stickslip.study import Study


_LONG = 300_000  # cells that take so long that something can be done beside; with fewer, all else would wait as long


def run_request(request: Request, plot: Path | None, keep: list[str], extras: Extras | None = None) -> dict[str, Any]:
    """Carry out a run, or compute in memory what has no place to be kept, and tell the outcome; for programs, too.

    keep : the words of the command that writes such a result to a file. extras : of borders.
    """
    from stickslip.runs import session
    from stickslip.runs.work import Work

    work = Work(request.config)
    if (plot or (extras and extras.page)) and request.shard is None and (part := shown.will_be_drawn(request.config)):
        notice(f"plot: {part}")
    part = f"\nshard {request.shard}" if request.shard else ""
    screen.terminal().print(f"{request.config.title}\n{work.study.described()}{part}", markup=False)
    if request.output is None and request.place is None:
        if request.shard is not None:
            fail("a shard needs a place for its blocks: --store, or an output beside which they are kept")
        return _run_in_memory(request, work.study, plot, keeping(keep), extras or Extras())
    outcome, seconds = carried_out(session.run, request, work.study, drawn=plot is not None)
    answer = answers.of_run(request, work.study, outcome, seconds)
    if outcome.output is not None:
        return answer | report(outcome, seconds, request, plot, extras or Extras())
    _tell_blocks(outcome, request, work.study)
    return answer


def keeping(words: list[str]) -> str:
    """The command that writes a result to a file here."""
    return shlex.join(["stickslip", *words, *settings_again()])


def _tell_blocks(outcome: Outcome, request: Request, study: Study) -> None:
    """The outcome of a run that left its blocks in a store."""
    of = f"shard {request.shard}: " if request.shard else ""
    place = str(outcome.where)  # the store itself: what the configuration names may not be what was asked for
    screen.echo(f"blocks   {of}{outcome.computed:,} {study.counted} computed into {place}")
    screen.echo(f"next     {shlex.join(['stickslip', 'status', place])}    # progress of the {study.name}")
    screen.echo(f"         {shlex.join(['stickslip', 'collect', place, *_named_output(request)])}    # writes it")


def _named_output(request: Request) -> list[str]:
    """The option that names the result where `collect` could not tell from the store alone."""
    if request.place is None:  # then the store is beside the result, and named after it
        return []
    return ["-o", str(request.output or "map.nc")]


def _run_in_memory(request: Request, study: Study, plot: Path | None, keep: str, extras: Extras) -> dict[str, Any]:
    """A run that writes no file, and says so; `keep` is the command that does."""
    from stickslip import api
    from stickslip.errors import Interrupted
    from stickslip.runs.request import Outcome

    api.check_in_memory(request.config, request.dask)
    them = "it" if study.name == "map" else "them"
    notice(f"no output is named: the {study.name} will be shown and then discarded; to keep {them}: {keep}")
    for law in study.kernels:
        prepare_kernels(law)
    began = finished = perf_counter()

    def note(done: float, of: int) -> None:
        nonlocal finished
        finished = perf_counter()
        move(done, of)

    try:
        with progress_bar(prod(study.shape), of=study.counted) as move:
            ds = api.run(request.config, progress=note, dask=request.dask)
    except Interrupted as interrupted:
        incomplete(interrupted)
    done = screen.Done(prod(study.shape), study.counted, finished - began, screen.threads(study.options))
    drawn = plot if save_plot(ds, plot, extras) else None
    shown.show(ds, done, None, drawn)
    _write(extras, ds)
    news(f"the {study.name} {'was' if study.name == 'map' else 'were'} not kept; to keep {them}: {keep}")
    outcome = Outcome(prod(study.shape), computed=prod(study.shape))
    return answers.of_run(request, study, outcome, finished - began) | answers.of_result(ds, drawn)


def carried_out(
    action: Callable[[Request], Outcome], request: Request, study: Study, drawn: bool = False
) -> tuple[Outcome, float]:
    """The outcome of `action`, and the seconds it computed. Ctrl-C and SIGTERM end the command.

    drawn : whether a plot will follow.
    """
    from stickslip.errors import Interrupted

    signal.signal(signal.SIGTERM, signal.default_int_handler)  # what schedulers send before they kill
    began = finished = perf_counter()
    moving = False

    def prepare(law: str) -> None:
        nonlocal began, finished
        prepare_kernels(law)
        if size * study.cells_each >= _LONG:
            Thread(target=_import_what_follows, args=(request.output, drawn)).start()
        began = finished = perf_counter()

    try:
        size, of = prod(study.shape), study.counted
        with progress_bar(size, of=of) as move, progress_bar(size, " written") as write:

            def note(done: float, of: int) -> None:
                nonlocal began, finished, moving
                finished = perf_counter()
                if not moving and request.cluster is not None:
                    began = finished  # connecting is not computing
                moving = True
                move(done, of)

            told = replace(request, progress=note, assembling=write, notice=notice, news=news, prepare=prepare)
            outcome = action(told)
    except Interrupted as interrupted:
        incomplete(interrupted)
    return outcome, finished - began


def _import_what_follows(output: Location | None, drawn: bool) -> None:
    """What writes and draws, imported while the kernels compute: half a second."""
    of_file = "zarr_chunks" if output is not None and output.suffix == ".zarr" else "netcdf_chunks"
    with suppress(ImportError):  # whoever needs it will say so
        import_module(f"stickslip.files.{of_file}")
        if drawn:
            import_module("stickslip.plots")


def notice(text: str) -> None:
    """Something worth knowing, on standard error."""
    screen.echo(text, err=True)


def news(text: str) -> None:
    """The same for what is no warning."""
    if not screen.is_quiet():
        notice(text)


def save_plot(ds: xr.Dataset, plot: Path | None, extras: Extras) -> bool:
    """Draw a result, if it can be drawn and a plot is asked for; whether it was."""
    if plot is None or not shown.is_drawn(ds):
        return False
    from stickslip import plots

    drawn = False
    with drawing(plot):
        plots.save(shown.figure(ds, extras), plot)
        drawn = True
    return drawn


def _write(extras: Extras, ds: xr.Dataset) -> None:
    """Write what is wanted besides a result and its plot, and say so."""
    extras.write_table(ds)
    if extras.page is not None:
        with drawing(extras.page):
            shown.write_page(ds, extras.page, extras)


def report(
    outcome: Outcome, seconds: float, request: Request, plot: Path | None, extras: Extras | None = None
) -> dict[str, Any]:
    """The plot and the summary of a run that wrote its result; of one that had nothing to do, a missing plot.

    Returns what programs are told of the result.
    """
    from stickslip.files import reading
    from stickslip.runs.work import study_of

    if outcome.output is None:
        return {}
    extras = extras or Extras()
    study = study_of(request.config)
    if outcome.up_to_date:
        screen.echo(f"{study.name:8} {outcome.output} is complete already; --fresh computes it again")
    with reading.look_into(outcome.output) as ds:
        if outcome.up_to_date and (plot is None or plot.exists()) and not extras.any:
            return answers.of_result(ds, plot)
        drawn = plot if save_plot(ds, plot, extras) else None
        answer = answers.of_result(ds, drawn)
        if outcome.up_to_date:
            _write(extras, ds)
            if drawn:
                screen.echo(f"plot     {plot}")
            return answer
        machines = outcome.machines or screen.threads(study.options)
        done = screen.Done(outcome.computed, study.counted, seconds, machines)
        shown.show(ds, done, outcome.output, drawn)
        _write(extras, ds)
    if outcome.reused:
        screen.echo(f"reused   {outcome.reused:,} {study.counted} of the earlier {study.name}")
    if outcome.where:
        screen.echo(f"blocks   kept in {outcome.where}")
    return answer
