"""Text on the screen: lines, tables, numbers for people, progress.

Rich is imported when it is needed, so that `--help` answers at once.
"""

from __future__ import annotations

import os
import sys
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import IO, TYPE_CHECKING, Any

import click

from stickslip.errors import visible
from stickslip.progress import Bar
from stickslip.progress import duration_text as duration_text

if TYPE_CHECKING:
    from rich.console import Console
    from rich.table import Table
    from rich.text import Text

    from stickslip.files.locations import Location

_WIDE = 1000  # characters, wider than any table
_LABEL = 7  # characters, at least: `map`, `blocks` and `collect` have what follows in one column


def echo(text: object = "", *, err: bool = False, file: IO[str] | None = None) -> None:
    """Print a line, with control characters written out: titles, labels and names of files may come from anybody."""
    click.echo(visible(str(text)), err=err, file=file)


def row(label: str, text: object) -> None:
    """Print a line of text behind its label."""
    echo(f"{label:{_LABEL}}  {text}")


def notice(text: str) -> None:
    """Print something worth knowing on standard error."""
    echo(text, err=True)


def info(text: str) -> None:
    """Print what is no warning on standard error, unless the call is quiet."""
    if not is_quiet():
        notice(text)


def remembered_option(*names: str, read: Callable[..., Any] | None = None, **attributes: Any) -> Callable[[Any], Any]:
    """An option that no command takes as an argument: `remembered` gives its value. read : a callback of click's."""

    def remember(context: click.Context, option: click.Parameter, value: Any) -> None:
        context.meta[f"stickslip.{option.name}"] = read(context, option, value) if read else value

    return click.option(*names, expose_value=False, callback=remember, **attributes)


def remembered(name: str) -> Any:
    """The value of a `remembered_option` of this call, None outside a call."""
    context = click.get_current_context(silent=True)
    return context and context.meta.get(f"stickslip.{name}")


def is_quiet() -> bool:
    """True if nothing but warnings and errors is to be printed."""
    return bool(remembered("quiet"))


def terminal(stderr: bool = False) -> Console:
    """The terminal. Colours only where it shows them, and with NO_COLOR no bold type either; numbers and paths are
    not decorated.

    A file or a pipe has no width, so nothing that is printed there is cut to that of a terminal.
    """
    from rich.console import Console

    class Plain(Console):
        """One that writes control characters out, which a terminal might obey."""

        def render_str(self, text: str, **how: Any) -> Text:
            """Whatever is printed comes through here."""
            return super().render_str(visible(text), **how)

    stream = sys.stderr if stderr else sys.stdout
    return Plain(
        stderr=stderr,
        highlight=False,
        soft_wrap=True,
        width=None if stream.isatty() else _WIDE,
        color_system=None if os.environ.get("NO_COLOR") else "auto",
    )


def new_table() -> Table:
    """An empty table of Rich."""
    from rich.table import Table

    return Table(box=None, pad_edge=False, header_style="bold")


def print_rows(rows: Sequence[tuple[str, ...]], indent: str = "") -> None:
    """Print rows of texts as columns, labels first; the last is as wide as it is."""
    widths = [max(_LABEL, *map(len, column)) for column in list(zip(*rows, strict=True))[:-1]]
    for *cells, last in rows:
        padded = (f"{cell:{width}}  " for cell, width in zip(cells, widths, strict=True))
        echo(f"{indent}{''.join(padded)}{last}".rstrip())


def size_of(path: Location) -> str:
    """Size of a file or of all files in a folder, for people."""
    if not isinstance(path, Path):
        return memory(sum(path.keys().values()))
    count = sum(p.stat().st_size for p in path.rglob("*")) if path.is_dir() else path.stat().st_size
    return memory(count)


def memory(count: float) -> str:
    """A number of bytes, for people."""
    sizes = ((1.0, "B"), (1e3, "kB"), (1e6, "MB"), (1e9, "GB"))
    size, unit = next((row for row in sizes if count < 999.5 * row[0]), sizes[-1])
    return f"{count / size:.3g} {unit}"


def share_text(fraction: float) -> str:
    """A share, for people; a few cells of very many are not "0.0%"."""
    return "<0.1%" if 0.0 < fraction < 0.0005 else f"{fraction:.1%}"


@contextmanager
def progress_bar(counted: str = "cells", doing: str = "") -> Iterator[Callable[[float, int], None]]:
    """A bar of cells, or what else is counted, with the rate and the time left; gives the function that moves it."""
    bar = Bar(terminal(stderr=True), counted, doing)
    try:
        yield (lambda _done, _total: None) if is_quiet() else bar.move
    finally:
        bar.end()
