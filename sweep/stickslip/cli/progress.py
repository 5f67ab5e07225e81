"""How far a computation is: a bar on a terminal, elsewhere lines that a log file can hold."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from math import floor
from time import perf_counter
from typing import TYPE_CHECKING

from stickslip.cli import screen
from stickslip.progress import Bar

if TYPE_CHECKING:
    from rich.console import Console

EVERY = 60.0  # s between lines


@contextmanager
def progress_bar(total: int, doing: str = "", of: str = "cells") -> Iterator[Callable[[float, int], None]]:
    """A bar of cells, or what else is counted, with the rate and the time left; gives the function that moves it.

    It is shown once it moves. What is done by then was found finished, and does not count for the rate. Where standard
    error is no terminal there are lines instead of a bar.
    """
    console = screen.terminal(stderr=True)
    shown = Bar(console, total, doing, of) if console.is_terminal else Lines(console, doing, of)
    try:
        yield (lambda _done, _total: None) if screen.is_quiet() else shown.move
    finally:
        shown.end()


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
            text += f", after {screen.duration_text(now - began)}"
        elif done > found and done < total:
            text += f", about {screen.duration_text((total - done) / rate)} left"
        self._console.print(text, markup=False)
        self._told, self._next = self._last, now + self._every
