"""The end of a command: exceptions become exit codes, an answer becomes JSON."""

from __future__ import annotations

import json
import os
import sys
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager, nullcontext, redirect_stdout
from functools import wraps
from math import isfinite
from typing import Any, NoReturn

import click

from stickslip import errors
from stickslip.cli import screen

Answer = Mapping[str, Any] | Callable[[], Mapping[str, Any]] | None
DONE, INCOMPLETE, WRONG_INPUT = 0, 1, 2
EXIT_CODES = """\b
Exit codes:
  0  done
  1  computed, but not to the end (Ctrl-C, a full disk, a failed block), or a bug (a traceback)
  2  the input is wrong or the cluster is not there, and nothing was computed"""
_STDOUT, _INCOMPLETE = "stickslip.stdout", "stickslip.incomplete"  # of a call
JSON = screen.remembered_option("--json", is_flag=True, help="Say it as JSON: all that goes to standard output.")
QUIET = screen.remembered_option("-q", "--quiet", is_flag=True, help="Print nothing but warnings and errors.")


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
            with _log_on_screen(), _nowhere() if screen.is_quiet() or is_for_programs() else nullcontext():
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
            screen.notice(self.format(record))

    logger, handler = logging.getLogger("stickslip"), Screen(logging.WARNING if screen.is_quiet() else logging.INFO)
    level = logger.level
    logger.addHandler(handler)
    logger.setLevel(logging.INFO)
    try:
        yield
    finally:
        logger.removeHandler(handler)
        logger.setLevel(level)


@contextmanager
def _nowhere() -> Iterator[None]:
    with open(os.devnull, "w", encoding="utf-8") as nowhere, redirect_stdout(nowhere):
        yield


def fail(message: object) -> NoReturn:
    """End with the exit code for wrong input."""
    text, here = str(getattr(message, "on_command_line", message)), click.get_current_context(silent=True)
    if here and not any("--fresh" in option.opts for option in here.command.params):  # the remedy of another command
        text = text.replace("--fresh", "stickslip run --fresh")
    screen.notice(text)
    sys.exit(WRONG_INPUT)


def incomplete(message: object) -> NoReturn:
    """End with the exit code for what was computed, but not to the end."""
    screen.notice(str(getattr(message, "on_command_line", message)))
    sys.exit(INCOMPLETE)


def remark_incomplete(message: object) -> None:
    """Say what is not as asked; the command goes on, and ends with the exit code for what is not complete."""
    screen.notice(str(message))
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
    return bool(screen.remembered("json"))


def print_json(answer: Answer) -> None:
    """Print an answer if `--json` is given: numbers and arrays of NumPy as numbers and lists, what is not finite as
    null."""
    if answer is not None and is_for_programs():
        plain = _plain(answer() if callable(answer) else answer)
        screen.echo(json.dumps(plain, indent=2, allow_nan=False), file=click.get_current_context().meta[_STDOUT])


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
