"""How far a computation is: a bar in a notebook or on the terminal, lines where there is neither.

The bar of a notebook is HTML that IPython replaces in place. It needs no widgets, so that it is there in every
front end and stays in the saved notebook. It appears once a call has taken a moment.
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
_PATIENCE = 0.5  # s before a bar appears
_EVERY = 0.1  # s between its movements
EVERY = 60.0  # s between lines
_STEADY = 120.0  # s over which the time left is estimated: blocks end in bursts


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
    bar = _NotebookBar(counted) if in_notebook() else _on_standard_error(counted)
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
    from .engine import will_compile as asked

    return asked(kernels)


def _on_standard_error(counted: str) -> Bar | Lines:
    from rich.console import Console

    return on_console(Console(stderr=True), 0, "", counted)


def on_console(console: Console, total: int, doing: str, of: str) -> Bar | Lines:
    """Return what shows how far a computation of `total` is: `of` what, `doing` what with them."""
    return Bar(console, total, doing, of) if console.is_terminal else Lines(console, doing, of)


def duration_text(seconds: float) -> str:
    """A time, for people."""
    if seconds < 120:
        return f"{seconds:.2g} s" if seconds < 10 else f"{seconds:.0f} s"
    return f"{seconds / 60:.0f} min" if seconds < 7200 else f"{seconds / 3600:.1f} h"


class _NotebookBar:
    """A bar in the output of a cell."""

    def __init__(self, counted: str) -> None:
        self._counted, self._began, self._shown = counted, perf_counter(), 0.0
        self._last: tuple[float, int] | None = None
        self._handle: Any = None

    def say(self, words: str) -> None:
        """Show words where the bar will be."""
        self._replace(_Words(words))

    def move(self, done: float, total: int) -> None:
        """Show that so many are done, unless the bar moved just now."""
        now = perf_counter()
        self._last = done, total
        if now - self._began > _PATIENCE and now - self._shown > _EVERY:
            self._shown = now
            self._show()

    def end(self) -> None:
        """Leave the bar as far as it came."""
        if self._handle is not None:
            self._show()

    def _show(self) -> None:
        if self._last is not None:
            self._replace(_View(*self._last, self._counted, perf_counter() - self._began))

    def _replace(self, view: _View | _Words) -> None:
        display = import_module("IPython.display").display  # of the notebook: we do not depend on it
        if self._handle is None:
            self._handle = display(view, display_id=True)
        else:
            self._handle.update(view)


class _Words:
    """A line of words, as IPython shows it."""

    def __init__(self, words: str) -> None:
        self._words = words

    def __repr__(self) -> str:
        return self._words


class _View:
    """A bar at one moment, as IPython shows it."""

    def __init__(self, done: float, total: int, counted: str, seconds: float) -> None:
        self._done, self._total = done, total
        self._words = f"{floor(done):,} of {total:,} {counted}, {seconds:.0f} s"
        if 0 < done < total:
            self._words += f", about {seconds * (total - done) / done:.0f} s left"

    def __repr__(self) -> str:
        return self._words

    def _repr_html_(self) -> str:
        bar = f'<progress value="{self._done}" max="{self._total}" style="width: 20em; vertical-align: middle">'
        return f"<div>{bar}</progress> {self._words}</div>"


class Bar:
    """A bar on the terminal with percentage, counts, rate and the time left, which is shown once it moves."""

    def __init__(self, console: Console, total: int, doing: str, of: str) -> None:
        from rich.progress import BarColumn, Progress, TextColumn, TimeRemainingColumn

        counts = "{task.percentage:3.0f} %  {task.fields[whole]:,} of {task.total:,.0f} "
        text = TextColumn(f"{counts}{of}{doing}{{task.fields[rate]}}")
        columns = BarColumn(), text, TimeRemainingColumn(elapsed_when_finished=True)
        self._bar = Progress(*columns, console=console, speed_estimate_period=_STEADY)
        self._task = self._bar.add_task(of, total=total, whole=0, rate="")
        self._first: tuple[float, float] | None = None

    def say(self, words: str) -> None:
        """Print words above the bar."""
        self._bar.console.print(words)

    def move(self, done: float, total: int) -> None:
        """Show that so many of so many are done."""
        if self._first is None:
            self._first = done, perf_counter()
            self._bar.reset(self._task, completed=floor(done), total=total, whole=floor(done), rate="")
            self._bar.start()
        found, began = self._first
        rate = (done - found) / max(perf_counter() - began, 1e-9)
        text = f", {rate:,.0f} per second" if rate >= 1 else ""
        self._bar.update(self._task, completed=done, total=total, whole=floor(done), rate=text)

    def end(self) -> None:
        """Leave the bar as it is."""
        if self._first is not None:
            self._bar.stop()


class Lines:
    """A line at the start, every now and then, and at the end.

    doing : of something besides the computation itself there are only the lines in between.
    every : s; EVERY unless given. clock : s, of any beginning.
    """

    def __init__(
        self,
        console: Console,
        doing: str,
        of: str,
        every: float | None = None,
        clock: Callable[[], float] = perf_counter,
    ) -> None:
        self._console, self._doing, self._of, self._clock = console, doing, of, clock
        self._every = EVERY if every is None else every
        self._first: tuple[float, float] | None = None
        self._last: tuple[float, int] = (0, 0)
        self._told: tuple[float, int] | None = None
        self._moved = self._next = 0.0

    def say(self, words: str) -> None:
        """Print words."""
        self._console.print(words, markup=False)

    def move(self, done: float, total: int) -> None:
        """Note that so many of so many are done; tell, if it is time for that."""
        now = self._moved = self._clock()
        self._last = done, total
        if self._first is None:
            self._first, self._next = (done, now), now + self._every
            if not self._doing:
                self._tell()
        elif now >= self._next or done >= total and not self._doing and self._told != self._last:
            self._tell(ended=done >= total)

    def end(self) -> None:
        """Tell how far it came, and in what time, unless that was told already."""
        if self._first is not None and self._told != self._last and (self._told or not self._doing):
            self._tell(ended=True)

    def _tell(self, ended: bool = False) -> None:
        assert self._first is not None
        (found, began), (done, total), now = self._first, self._last, self._moved
        share = 100.0 * done / total if total else 100.0
        text = f"{share:5.1f} %  {floor(done):,} of {total:,} {self._of}{self._doing}"
        rate = (done - found) / max(now - began, 1e-9)
        if done > found:
            text += f", {rate:,.0f} per second" if rate >= 10.0 else f", {rate:.2g} per second"
        if ended:
            text += f", after {duration_text(now - began)}"
        elif done > found and done < total:
            text += f", about {duration_text((total - done) / rate)} left"
        self._console.print(text, markup=False)
        self._told, self._next = self._last, now + self._every
