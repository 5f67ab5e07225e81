"""What a command says, and how it ends: lines, tables, numbers for people, progress; exit codes, and answers as JSON.

Rich is imported when it is needed, so that `--help` answers at once.
"""

from __future__ import annotations

import io
import json
import os
import sys
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager, redirect_stdout
from functools import wraps
from math import isfinite
from pathlib import Path
from typing import IO, TYPE_CHECKING, Any, NoReturn

import click

from stickslip import errors
from stickslip.errors import visible
from stickslip.progress import Bar
from stickslip.progress import duration_text as duration_text

if TYPE_CHECKING:
    from rich.console import Console
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


# --- the end of a command: exceptions become exit codes, an answer becomes JSON ---------------------------------------

Answer = Mapping[str, Any] | Callable[[], Mapping[str, Any]] | None
DONE, INCOMPLETE, WRONG_INPUT = 0, 1, 2
EXIT_CODES = """\b
Exit codes:
  0  done
  1  computed, but not to the end (Ctrl-C, a full disk, a failed block), or a bug (a traceback)
  2  the input is wrong or the cluster is not there, and nothing was computed"""
_STDOUT, _INCOMPLETE = "stickslip.stdout", "stickslip.incomplete"  # of a call
JSON = remembered_option("--json", is_flag=True, help="Say it as JSON: all that goes to standard output.")
QUIET = remembered_option("-q", "--quiet", is_flag=True, help="Print nothing but warnings and errors.")


def reports_errors(command: Callable[..., Answer]) -> Callable[..., None]:
    """Turn the errors meant for people into their text and an exit code; all others are bugs and show a traceback.

    With `--json` what the command returns, or the function that it returns gives, is printed. With that and `--quiet`
    nothing that is for people goes to standard output.
    """

    @wraps(command)
    def guarded(*args: Any, **kwargs: Any) -> None:
        meta = click.get_current_context().meta
        meta[_STDOUT] = sys.stdout
        try:
            with _log_on_screen(), redirect_stdout(io.StringIO() if is_quiet() or is_for_programs() else sys.stdout):
                print_json(command(*args, **kwargs))
        except (errors.IncompleteError, errors.Interrupted, errors.NotReachedError, errors.PlotError) as error:
            incomplete(error)
        except (errors.ClusterError, errors.ConfigError, errors.StoreError) as error:
            fail(error)
        except KeyboardInterrupt:
            incomplete("interrupted: nothing more was written")
        if meta.get(_INCOMPLETE):
            sys.exit(INCOMPLETE)

    return guarded


@contextmanager
def _log_on_screen() -> Iterator[None]:
    """Print what the engine logs: mostly that it compiles the kernels, which takes a minute."""
    import logging

    class Screen(logging.Handler):
        def emit(self, record: logging.LogRecord) -> None:
            notice(self.format(record))

    logger, handler = logging.getLogger("stickslip"), Screen(logging.WARNING if is_quiet() else logging.INFO)
    level = logger.level
    logger.addHandler(handler)
    logger.setLevel(logging.INFO)
    try:
        yield
    finally:
        logger.removeHandler(handler)
        logger.setLevel(level)


def fail(message: object) -> NoReturn:
    """End with the exit code for wrong input."""
    text, here = str(getattr(message, "on_command_line", message)), click.get_current_context(silent=True)
    if here and not any("--fresh" in option.opts for option in here.command.params):  # the remedy of another command
        text = text.replace("--fresh", "stickslip run --fresh")
    notice(text)
    sys.exit(WRONG_INPUT)


def incomplete(message: object) -> NoReturn:
    """End with the exit code for what was computed, but not to the end."""
    notice(str(getattr(message, "on_command_line", message)))
    sys.exit(INCOMPLETE)


def remark_incomplete(message: object) -> None:
    """Say what is not as asked; the command goes on, and ends with the exit code for what is not complete."""
    notice(str(message))
    click.get_current_context().meta[_INCOMPLETE] = True


@contextmanager
def refuses_bad_input(place: object) -> Iterator[None]:
    """Values that are refused before anything is computed, with the file or option they are of, are wrong input."""
    try:
        yield
    except errors.ConfigError:
        raise
    except (TypeError, ValueError) as error:
        fail(f"{place}: {error}" if place else error)


@contextmanager
def drawing(target: object) -> Iterator[None]:
    """Say that a picture or page fails and go on; the command ends with the exit code for what is not complete."""
    try:
        yield
    except (errors.PlotError, errors.StoreError) as error:
        remark_incomplete(f"{target}: not drawn: {error}")


def fields(thing: object, *names: str, **keys: str) -> dict[str, Any]:
    """Attributes of something by their names, and by other keys."""
    return {key: getattr(thing, name) for key, name in (dict(zip(names, names, strict=True)) | keys).items()}


def is_for_programs() -> bool:
    """True if `--json` is given."""
    return bool(remembered("json"))


def print_json(answer: Answer) -> None:
    """Print an answer if `--json` is given: numbers and arrays of NumPy as numbers and lists, what is not finite as
    null."""
    if answer is not None and is_for_programs():
        plain = _plain(answer() if callable(answer) else answer)
        echo(json.dumps(plain, indent=2, allow_nan=False), file=click.get_current_context().meta[_STDOUT])


def _plain(value: Any) -> Any:
    """A value in the types that JSON has."""
    if isinstance(value, Mapping):
        return {str(key): _plain(inner) for key, inner in value.items()}
    if isinstance(value, list | tuple):
        return [_plain(inner) for inner in value]
    if hasattr(value, "tolist"):  # NumPy's numbers and arrays, without importing it
        return _plain(value.tolist())
    if isinstance(value, float):
        return value if isfinite(value) else None
    return value if value is None or isinstance(value, bool | int | str) else str(value)
