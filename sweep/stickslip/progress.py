"""How far a call of Python is: a bar in a notebook, one on the terminal if asked for.

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
_STEADY = 120.0  # s over which the time left is estimated: blocks end in bursts


@contextmanager
def watched(progress: Watch, counted: str = "cells", law: str | None = None) -> Iterator[Moved | None]:
    """What a computation is to call with (done, in all) from time to time.

    progress : a function, which is called itself; True for a bar, False or None for none, "auto" for one in notebooks.
    counted : what is counted, for the bar. law : whose kernels are needed; that they must be compiled first is shown.
    """
    if progress is None or callable(progress):
        yield progress
        return
    if progress not in (True, False, "auto"):
        raise ValueError(f"progress: got {progress!r}, expected a function, True, False or 'auto'")
    if not progress or (progress == "auto" and not in_notebook()):
        yield None
        return
    bar = _NotebookBar(counted) if in_notebook() else _terminal_bar(counted)
    if law is not None and will_compile(law):
        bar.say("compiling the kernels for this machine: once, about twenty seconds")
    try:
        yield bar.move
    finally:
        bar.end()


def in_notebook() -> bool:
    """Whether this process is the kernel of a notebook."""
    ipython = sys.modules.get("IPython")
    shell = ipython.get_ipython() if ipython else None
    return shell is not None and hasattr(shell, "kernel")


def will_compile(law: str) -> bool:
    """Whether kernels must be compiled first; the engine is loaded when that is asked for."""
    from .engine import will_compile as asked

    return asked(law)


def _terminal_bar(counted: str) -> Bar:
    from rich.console import Console

    return Bar(Console(stderr=True), 0, "", counted)


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
