"""Progress of a computation: a bar of Rich's on a terminal and in a notebook, lines where there is neither."""

from __future__ import annotations

import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from math import floor, inf
from typing import TYPE_CHECKING, Literal

if TYPE_CHECKING:
    from rich.console import Console
    from rich.progress import Task

Moved = Callable[[float, int], None]
Watch = Moved | bool | Literal["auto"] | None
PATIENCE = 0.5  # s before the bar of a notebook appears
EVERY = 60.0  # s between lines
_SOON = 1.0  # s
_NOTEBOOK_WIDTH = 100  # characters


@contextmanager
def watched(progress: Watch, counted: str = "cells", kernels: str | None = None) -> Iterator[Moved | None]:
    """Return what a computation is to call with (done, in all) from time to time.

    progress : a function, which is called itself; True for a bar (lines where standard error is no terminal), False or
        None for none, "auto" for one in notebooks.
    counted : what is counted, for the bar. kernels : names those needed; that they must be compiled first is shown.
    """
    if progress is None or callable(progress):
        yield progress
        return
    if progress not in (True, False, "auto"):
        raise ValueError(f"progress: got {progress!r}, expected a function, True, False or 'auto'")
    if not progress or (progress == "auto" and not in_notebook()):
        yield None
        return
    from rich.console import Console

    if in_notebook():  # one line, drawn over, which needs no widgets
        console = Console(file=sys.stdout, force_terminal=True, force_jupyter=False, width=_NOTEBOOK_WIDTH)
        bar = Bar(console, counted, patience=PATIENCE)
    else:
        bar = Bar(Console(stderr=True), counted)
    if kernels is not None and will_compile(kernels):
        bar.say("compiling the kernels for this machine, once")
    try:
        yield bar.move
    finally:
        bar.end()


def in_notebook() -> bool:
    """Return whether this process is the kernel of a notebook."""
    ipython = sys.modules.get("IPython")
    shell = ipython.get_ipython() if ipython else None
    return shell is not None and hasattr(shell, "kernel")


def will_compile(kernels: str) -> bool:
    """Return whether kernels must be compiled first; the engine is loaded when that is asked for."""
    from stickslip.engine import compiling

    return compiling.will_compile(kernels)


def duration_text(seconds: float) -> str:
    """A time, for people."""
    if seconds < 120:
        return f"{seconds:.2g} s" if seconds < 10 else f"{seconds:.0f} s"
    return f"{seconds / 60:.0f} min" if seconds < 7200 else f"{seconds / 3600:.1f} h"


class Bar:
    """A bar on a terminal; where there is none, a line at the start, every now and then, and at the end.

    counted : what is counted. doing : what is done with it (" written"), besides the computation itself, of which a log
    shows only the lines in between. patience : seconds before the bar appears.
    """

    def __init__(self, console: Console, counted: str, doing: str = "", patience: float = 0.0) -> None:
        from rich.progress import BarColumn, Progress, TextColumn

        self._console, self._counted, self._besides = console, f"{counted}{doing}", bool(doing)
        columns = BarColumn(), TextColumn("{task.description}", markup=False)
        self._progress = Progress(*columns, console=console, disable=not console.is_terminal)
        self._patience, self._printed = patience, -1.0  # what was done at the last line
        self._due = inf  # time of the bar, or of the next line

    def say(self, words: str) -> None:
        """Print words, above the bar."""
        self._console.print(words, markup=False)

    def move(self, done: float, total: int) -> None:
        """Note that so many of so many are done, and show it if it is time for that.

        What is done at the first move was finished before, and does not count for the rate.
        """
        now = self._console.get_time()
        if not self._progress.tasks:
            self._progress.add_task("", total=total, before=done)
            self._due = now + (self._patience if self._console.is_terminal else EVERY * self._besides)
        (task,) = self._progress.tasks
        self._progress.update(task.id, completed=done, total=total)
        self._progress.update(task.id, description=self._words(task, ended=done >= total))
        if now >= self._due or (done >= total and not self._besides and not self._console.is_terminal):
            self._show(task)

    def end(self) -> None:
        """Leave the bar as it is, or print how far it came."""
        if self._progress.live.is_started:
            self._progress.stop()
        elif self._progress.tasks and not self._console.is_terminal and (self._printed >= 0.0 or not self._besides):
            self._show(self._progress.tasks[0], ended=True)

    def _show(self, task: Task, ended: bool = False) -> None:
        if self._console.is_terminal:
            self._progress.start()
        elif task.completed != self._printed:
            self.say(self._words(task, ended or task.finished))
            self._printed, self._due = task.completed, self._console.get_time() + EVERY

    def _words(self, task: Task, ended: bool) -> str:
        """`40.0 %  400 of 1,000 cells, 10/s, about 60 s left`; once it has ended, how long it took."""
        text = f"{task.percentage:5.1f} %  {floor(task.completed):,} of {task.total or 0:,.0f} {self._counted}"
        seconds = task.finished_time or task.elapsed or 0.0
        if rate := (task.completed - task.fields["before"]) / max(seconds, 1e-9):
            text += f", {rate:,.0f}/s" if rate >= 10.0 else f", {rate:.2g}/s"
        if ended:
            return f"{text}, after {duration_text(seconds)}"
        left = task.remaining / rate if task.remaining and rate > 0.0 else 0.0
        return f"{text}, about {duration_text(left)} left" if left >= _SOON else text
