"""How far a call of Python is: a bar in a notebook, one on the terminal if asked for.

The bar of a notebook is HTML that IPython replaces in place. It needs no widgets, so that it is there in every
front end and stays in the saved notebook. It appears once a call has taken a moment.
"""

from __future__ import annotations

import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from importlib import import_module
from time import perf_counter
from typing import Any, Literal

from .engine import will_compile

Moved = Callable[[int, int], None]
Watch = Moved | bool | Literal["auto"] | None
_PATIENCE = 0.5  # s before a bar appears
_EVERY = 0.1  # s between its movements


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
    bar = _NotebookBar(counted) if in_notebook() else _TerminalBar(counted)
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


class _NotebookBar:
    """A bar in the output of a cell."""

    def __init__(self, counted: str) -> None:
        self._counted, self._began, self._shown = counted, perf_counter(), 0.0
        self._last: tuple[int, int] | None = None
        self._handle: Any = None

    def say(self, words: str) -> None:
        """Show words where the bar will be."""
        self._replace(_Words(words))

    def move(self, done: int, total: int) -> None:
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

    def __init__(self, done: int, total: int, counted: str, seconds: float) -> None:
        self._done, self._total = done, total
        self._words = f"{done:,} of {total:,} {counted}, {seconds:.0f} s"

    def __repr__(self) -> str:
        return self._words

    def _repr_html_(self) -> str:
        bar = f'<progress value="{self._done}" max="{self._total}" style="width: 20em; vertical-align: middle">'
        return f"<div>{bar}</progress> {self._words}</div>"


class _TerminalBar:
    """A bar on the terminal."""

    def __init__(self, counted: str) -> None:
        from rich.console import Console
        from rich.progress import BarColumn, Progress, TextColumn, TimeRemainingColumn

        counts = TextColumn(f"{{task.completed:,.0f}} of {{task.total:,.0f}} {counted}")
        self._bar = Progress(BarColumn(), counts, TimeRemainingColumn(), console=Console(stderr=True))
        self._task = self._bar.add_task(counted, total=0)
        self._is_shown = False

    def say(self, words: str) -> None:
        """Print words above the bar."""
        self._bar.console.print(words)

    def move(self, done: int, total: int) -> None:
        """Show that so many are done."""
        self._bar.update(self._task, completed=done, total=total)
        if not self._is_shown:
            self._is_shown = True
            self._bar.start()

    def end(self) -> None:
        """Leave the bar as far as it came."""
        if self._is_shown:
            self._bar.stop()
