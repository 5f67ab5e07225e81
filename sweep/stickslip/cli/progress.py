"""How far a computation is: a bar on a terminal, elsewhere lines that a log file can hold."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager

from stickslip.cli import screen
from stickslip.progress import on_console


@contextmanager
def progress_bar(total: int, doing: str = "", of: str = "cells") -> Iterator[Callable[[float, int], None]]:
    """A bar of cells, or what else is counted, with the rate and the time left; gives the function that moves it.

    It is shown once it moves. What is done by then was found finished, and does not count for the rate. Where standard
    error is no terminal there are lines instead of a bar.
    """
    shown = on_console(screen.terminal(stderr=True), total, doing, of)
    try:
        yield (lambda _done, _total: None) if screen.is_quiet() else shown.move
    finally:
        shown.end()
