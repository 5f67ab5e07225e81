"""What the command says on screen: numbers for people, the summary of a run.

Rich is imported when it is needed, so that `--help` answers at once.
"""

from __future__ import annotations

import os
import sys
from dataclasses import dataclass
from pathlib import Path
from typing import IO, TYPE_CHECKING, Any

import click

from stickslip.errors import visible
from stickslip.progress import duration_text as duration_text

if TYPE_CHECKING:
    import xarray as xr
    from rich.console import Console
    from rich.table import Table
    from rich.text import Text

    from stickslip.engine import Options
    from stickslip.files.locations import Location

QUIET = "stickslip.quiet"  # in what click knows of a call
_WIDE = 1000  # characters, wider than any table


def echo(text: object = "", *, err: bool = False, file: IO[str] | None = None) -> None:
    """Print a line, with control characters written out: titles, labels and names of files may come from anybody."""
    click.echo(visible(str(text)), err=err, file=file)


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


def print_table(table: Table, console: Console | None = None) -> None:
    """Print a table with all it says: on a screen that is too narrow its lines run on, and no number is cut."""
    console = console or terminal()
    needed = console.measure(table, options=console.options.update(width=_WIDE)).maximum
    console.print(table, width=max(needed, min(console.width, _WIDE)), crop=False)


def size_of(path: Location) -> str:
    """Size of a file or of all files in a folder, for people."""
    if not isinstance(path, Path):
        return memory(path.folder().size())
    count = sum(p.stat().st_size for p in path.rglob("*")) if path.is_dir() else path.stat().st_size
    return memory(count)


def memory(count: float) -> str:
    """A number of bytes, for people."""
    for unit in ("B", "kB", "MB"):
        if count < 999.5:
            return f"{count:.3g} {unit}"
        count /= 1000
    return f"{count:.3g} GB"


def share_text(fraction: float) -> str:
    """A share, for people; a few cells of very many are not "0.0%"."""
    return "<0.1%" if 0.0 < fraction < 0.0005 else f"{fraction:.1%}"


def is_quiet() -> bool:
    """Whether nothing but warnings and errors is to be printed."""
    context = click.get_current_context(silent=True)
    return bool(context and context.meta.get(QUIET))


def threads(options: Options) -> str:
    """`2 threads`: what a computation with these options runs on."""
    from stickslip import engine

    count = options.threads or engine.processors()
    return f"{count} thread{'s' if count != 1 else ''}"


@dataclass(frozen=True)
class Done:
    """How many items a run computed, what they are called, in how many seconds, and on which machines."""

    computed: int
    counted: str
    seconds: float
    machines: str


def rate(done: Done) -> str:
    """`57,600 cells in 0.1 s, 576,000 cells/s on 2 threads`."""
    per_second = done.computed / max(done.seconds, 1e-9)
    each = f"{per_second:,.0f} {done.counted}/s" if per_second >= 10.0 else f"{per_second:.2g} {done.counted}/s"
    counted = done.counted if done.computed != 1 else done.counted.removesuffix("s")
    return f"{done.computed:,} {counted} in {duration_text(done.seconds)}, {each} on {done.machines}"


def show_map(ds: xr.Dataset, output: Location | None) -> None:
    """The regimes of a map, and remarks on cells that have none."""
    from rich.table import Table

    from stickslip.dataset.summary import one_regime_remark, remark, step_limit_remark, summary
    from stickslip.vocabulary.flags import flag_label

    found = summary(ds)
    table = Table("regime", box=None, pad_edge=False, header_style="bold")
    table.add_column("cells", justify="right")
    table.add_column("share", justify="right")
    for name, share in found.items():
        table.add_row(flag_label(name), f"{share.cells:,}", share_text(share.fraction))
    console = terminal()
    print_table(table, console)
    if words := remark(found, None if output is None else str(output)):
        console.print(words, markup=False)
    if words := one_regime_remark(ds, found):
        console.print(words, markup=False)
    if words := step_limit_remark(ds, None if output is None else str(output)):
        console.print(words, markup=False)
