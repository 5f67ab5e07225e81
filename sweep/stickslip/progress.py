"""Progress of a computation: a bar in a notebook or on the terminal, lines where there is neither.

The bar of a notebook is HTML that IPython replaces in place. It needs no widgets, so that it is there in every
front end and stays in the saved notebook.
"""

from __future__ import annotations

import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from importlib import import_module
from math import floor
from time import perf_counter
from typing import TYPE_CHECKING, Any, Literal

if TYPE_CHECKING:
    from rich.console import Console

Moved = Callable[[float, int], None]
Watch = Moved | bool | Literal["auto"] | None
PATIENCE = 0.5  # s before the bar of a notebook appears
REFRESH = 0.1  # s between its movements
EVERY = 60.0  # s between lines
_SOON = 1.0  # s


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

    bar = NotebookBar(counted) if in_notebook() else on_console(Console(stderr=True), counted)
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
    from stickslip.engine import compiled

    return compiled.will_compile(kernels)


def on_console(console: Console, counted: str, doing: str = "") -> Bar | Lines:
    """Return what shows how far a computation is: a bar on a terminal, lines in a file or a pipe."""
    return Bar(console, counted, doing) if console.is_terminal else Lines(console, counted, doing)


def duration_text(seconds: float) -> str:
    """A time, for people."""
    if seconds < 120:
        return f"{seconds:.2g} s" if seconds < 10 else f"{seconds:.0f} s"
    return f"{seconds / 60:.0f} min" if seconds < 7200 else f"{seconds / 3600:.1f} h"


class _Progress:
    """The progress of a computation in words.

    counted : what is counted. doing : what is done with it (" written"), besides the computation itself.
    """

    def __init__(self, counted: str, doing: str = "") -> None:
        self._counted, self._besides = f"{counted}{doing}", bool(doing)
        self._first: tuple[float, float] | None = None  # done at the first move, and its time
        self._last: tuple[float, int] = (0.0, 0)
        self._now = 0.0

    def move(self, done: float, total: int) -> None:
        """Note that so many of so many are done, and show it if it is time for that.

        What is done at the first move was finished before, and does not count for the rate.
        """
        self._now, self._last = perf_counter(), (done, total)
        self._first = self._first or (done, self._now)
        self._moved()

    def words(self, ended: bool = False) -> str:
        """`40.0 %  400 of 1,000 cells, 10/s, about 60 s left`; once it has ended, how long it took."""
        assert self._first is not None
        (before, began), (done, total) = self._first, self._last
        share = 100.0 * done / total if total else 100.0
        text = f"{share:5.1f} %  {floor(done):,} of {total:,} {self._counted}"
        seconds = max(self._now - began, 1e-9)
        if rate := (done - before) / seconds:
            text += f", {rate:,.0f}/s" if rate >= 10.0 else f", {rate:.2g}/s"
        if ended:
            return f"{text}, after {duration_text(seconds)}"
        left = (total - done) / rate if rate > 0.0 else 0.0
        return f"{text}, about {duration_text(left)} left" if left >= _SOON else text

    def _moved(self) -> None:
        raise NotImplementedError


class NotebookBar(_Progress):
    """A bar in the output of a cell, once a call has taken a moment."""

    _handle: Any = None
    _next = 0.0

    def say(self, words: str) -> None:
        """Show words where the bar will be."""
        self._show({"text/plain": words})

    def end(self) -> None:
        """Leave the bar as far as it came."""
        if self._handle is not None and self._first is not None:
            self._show_bar()

    def _moved(self) -> None:
        assert self._first is not None
        if self._now > max(self._first[1] + PATIENCE, self._next):
            self._next = self._now + REFRESH
            self._show_bar()

    def _show_bar(self) -> None:
        done, total = self._last
        words = self.words(ended=done >= total).strip()
        bar = f'<progress value="{done}" max="{total}" style="width: 20em; vertical-align: middle"></progress>'
        self._show({"text/plain": words, "text/html": f"<div>{bar} {words}</div>"})

    def _show(self, view: dict[str, str]) -> None:
        """Show one thing in several types, of which a front end chooses."""
        if self._handle is None:
            display = import_module("IPython.display").display  # of the notebook: we do not depend on it
            self._handle = display(view, raw=True, display_id=True)
        else:
            self._handle.update(view, raw=True)


class Bar(_Progress):
    """A bar on the terminal, which is shown once it moves."""

    def __init__(self, console: Console, counted: str, doing: str = "") -> None:
        from rich.progress import BarColumn, Progress, TextColumn

        super().__init__(counted, doing)
        self._bar = Progress(BarColumn(), TextColumn("{task.description}"), console=console)

    def say(self, words: str) -> None:
        """Print words above the bar."""
        self._bar.console.print(words)

    def end(self) -> None:
        """Leave the bar as it is."""
        if self._first is not None:
            self._bar.stop()

    def _moved(self) -> None:
        done, total = self._last
        if not self._bar.task_ids:
            self._bar.add_task("")
            self._bar.start()
        words = self.words(ended=done >= total)
        self._bar.update(self._bar.task_ids[0], completed=done, total=total, description=words)


class Lines(_Progress):
    """A line at the start, every now and then, and at the end; of what is done besides, only those in between."""

    _next: float | None = None  # time of the next line
    _printed: tuple[float, int] | None = None

    def __init__(self, console: Console, counted: str, doing: str = "") -> None:
        super().__init__(counted, doing)
        self._console = console

    def say(self, words: str) -> None:
        """Print words."""
        self._console.print(words, markup=False)

    def end(self) -> None:
        """Print how far it came, and in what time, unless that is printed already."""
        if self._first is not None and self._printed != self._last and (self._printed or not self._besides):
            self._print(ended=True)

    def _moved(self) -> None:
        is_first, (done, total) = self._next is None, self._last
        self._next = self._now + EVERY if self._next is None else self._next
        at_an_end = not self._besides and (is_first or done >= total and self._printed != self._last)
        if at_an_end or self._now >= self._next:
            self._print(ended=done >= total and not is_first)

    def _print(self, ended: bool) -> None:
        self.say(self.words(ended))
        self._printed, self._next = self._last, self._now + EVERY
