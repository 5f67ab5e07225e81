"""What all commands share: exit codes, errors for people, compiling the kernels, names of files."""

from __future__ import annotations

import json
import os
import sys
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager, nullcontext, redirect_stdout
from functools import wraps
from math import isfinite
from pathlib import Path
from time import perf_counter
from typing import TYPE_CHECKING, Any, NoReturn

import click
from click.shell_completion import CompletionItem

from stickslip.cli import screen

if TYPE_CHECKING:
    from stickslip.config.model import Config
    from stickslip.config.overrides import Setting
    from stickslip.files.locations import Location


class _Place(click.ParamType):  # type: ignore[type-arg]
    """A place in the file system, or a URL."""

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> Location:
        """What a text on the command line names."""
        from stickslip.files.locations import location

        return location(value)

    def shell_complete(self, ctx: click.Context, param: click.Parameter, incomplete: str) -> list[CompletionItem]:
        """Files, as the shell finds them."""
        return [CompletionItem(incomplete, type="file")]


class _Where(_Place):
    """A path, or the URL of a Zarr store, which a `Path` would spoil."""

    name = "path_or_url"

    def __init__(self, or_configuration: bool = False) -> None:
        self._or_configuration = or_configuration

    def get_missing_message(self, param: click.Parameter, ctx: click.Context | None = None) -> str:
        """What could have been named."""
        from stickslip.files.sniff import RESULTS, names_in

        if self._or_configuration:
            return next_step()
        here = names_in(Path(), RESULTS)
        return f"Results in this folder: {', '.join(here)}" if here else "No result (.nc, .zarr) is in this folder."


class Target(_Place):
    """A file to be written (`targets.check_target`), refused before anything is computed if it cannot be."""

    name = "path"

    def __init__(self, *kinds: str) -> None:
        self._kinds = kinds

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> Location:
        """The place that a text names."""
        from stickslip.files.targets import KINDS

        place = super().convert(value, param, ctx)
        ends = [end for kind in self._kinds if kind in KINDS for end in KINDS[kind].suffixes]
        there = place.suffix.lower() in ends and os.path.isfile(str(place))
        if ctx is not None and not ctx.resilient_parsing and not (there and ctx.info_name == "run"):
            checked(place, *self._kinds)
        return place  # if there, maybe of a finished run, which writes nothing; else a run looks itself


class ConfigPath(click.Path):
    """The file of a configuration; where none is named, the ones of this folder are."""

    name = "configuration"

    def __init__(self) -> None:
        super().__init__(path_type=Path)

    def get_missing_message(self, param: click.Parameter, ctx: click.Context | None = None) -> str:
        """What could have been named."""
        return next_step()


class _Threads(click.IntRange):
    """How many threads, or auto."""

    name = "threads"

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> Any:
        """A number, or auto as it is."""
        return value if value == "auto" else super().convert(value, param, ctx)


PAGES = (".html", ".htm")
DONE, INCOMPLETE, WRONG_INPUT = 0, 1, 2
WHERE = _Where()
Command = Callable[..., None]
_SETTINGS, _THREADS, _STDOUT = (f"stickslip.{name}" for name in ("settings", "threads", "stdout"))  # of a call
_UNDRAWN = "stickslip.undrawn"  # of a call: whether a picture failed
_TABLE = "stickslip.table"  # of a call: the table to be made of its result
_KNOWS_ITS_OWN = ("run", "border", "contours", "attractors", "collect", "retry-failed")  # and replace no other result
SET = click.option(
    "--set",
    "settings",
    multiple=True,
    metavar="KEY=VALUE",
    expose_value=False,
    callback=lambda context, _option, texts: _remember(context, texts),
    help="Set a key of CONFIG, as axes.belt_speed.num=50 or 'system.mass=200 g'; KEY= removes it. Repeatable.",
)
THREADS = click.option(
    "--threads",
    type=_Threads(1),
    metavar="N|auto",
    expose_value=False,
    callback=lambda context, _option, threads: context.meta.__setitem__(_THREADS, threads),
    help="Threads to compute on, whatever CONFIG says.  [default: one per processor]",
)
QUIET = click.option(
    "-q",
    "--quiet",
    is_flag=True,
    expose_value=False,
    callback=lambda context, _option, quiet: context.meta.__setitem__(screen.QUIET, quiet),
    help="Print nothing but warnings and errors.",
)


def CONFIG(command: Command) -> Command:  # noqa: N802, a decorator as those above
    """The argument `config`, and `--set` with it; `configuration` reads both."""
    path = click.argument("config", type=ConfigPath(), callback=lambda _context, _parameter, path: config_file(path))
    return path(SET(command))


def CONFIG_OR_RESULT(command: Command) -> Command:  # noqa: N802
    """The same where a result, which holds its configuration, will do as well."""
    place = click.argument(
        "config",
        type=_Where(or_configuration=True),
        callback=lambda _context, _parameter, path: config_file(path) if isinstance(path, Path) else path,
    )
    return place(SET(command))


OUTPUT = click.option(
    "-o",
    "--output",
    type=Target("result", "table"),
    callback=lambda context, _option, output: kept_output(context, output),
    help="File to write, .nc or .zarr, or the URL of a .zarr; .csv or .xlsx writes the .nc and a table made of it.",
)
DASK = click.option(
    "--dask",
    metavar="ADDRESS",
    callback=lambda _context, _option, value: _dask(value),
    help="Dask scheduler that computes blocks, its file, local (processes here), or none.",
)
JSON = click.option("--json", "as_json", is_flag=True, help="Say it as JSON: all that goes to standard output.")
EXIT_CODES = """\b
Exit codes:
  0  done
  1  computed, but not to the end (Ctrl-C, a full disk, a failed block), or a bug (a traceback)
  2  the input is wrong or the cluster is not there, and nothing was computed"""


def next_step() -> str:
    """What can be done in this folder."""
    from stickslip.files.sniff import CONFIGURATIONS, names_in

    if here := names_in(Path(), CONFIGURATIONS):
        return f"Configurations in this folder: {', '.join(here)}"
    return "No configuration is in this folder; `stickslip init my.yaml` writes one to start from."


def config_file(path: Path) -> Path:
    """The file of a configuration: the one named or, which is said, the one of the package that is called so."""
    from stickslip.config.examples import existing_config

    file = existing_config(path)
    if file != path:
        screen.echo(f"{path}: no such file here, taken from those that come with stickslip: {file}", err=True)
    return file


def configuration(path: Path) -> Config:
    """The configuration in a file, with `--set` and `--threads` put in. Raises ConfigError."""
    from stickslip.config.reader import load_config

    return load_config(path, settings())


def settings() -> tuple[Setting, ...]:
    """What `--set` and `--threads` of this call say of its configuration."""
    from stickslip.config.overrides import Setting

    given = click.get_current_context().meta
    threads = given.get(_THREADS)
    of_threads = [] if threads is None else [Setting(f"--threads {threads}", "execution.threads", str(threads))]
    return (*given.get(_SETTINGS, ()), *of_threads)


def settings_again() -> list[str]:
    """The words of `--set` and `--threads`, for a command that is to be called in the same way."""
    return [word for given in settings() for word in given.option.split(" ", 1)]


def _remember(context: click.Context, texts: tuple[str, ...]) -> None:
    """Keep what `--set` says for `settings`."""
    from stickslip.config.overrides import setting

    try:
        context.meta[_SETTINGS] = tuple(setting(text) for text in texts)
    except ValueError as error:
        raise click.BadParameter(str(error)) from None


def points_file(path: Path) -> Path:
    """A table of measured points: the file named or, which is said, the one of the package that is called so."""
    from stickslip.config.examples import points_path

    file = points_path(path)
    if file != path:
        screen.echo(f"{path}: no such file here, taken from those that come with stickslip: {file}", err=True)
    return file


def fail(message: object) -> NoReturn:
    """End with the exit code for wrong input."""
    text, here = str(getattr(message, "on_command_line", message)), click.get_current_context(silent=True)
    if here and not any("--fresh" in option.opts for option in here.command.params):  # the remedy of another command
        text = text.replace("--fresh", "stickslip run --fresh")
    screen.echo(text, err=True)
    sys.exit(WRONG_INPUT)


def incomplete(message: object) -> NoReturn:
    """End with the exit code for what was computed, but not to the end."""
    screen.echo(getattr(message, "on_command_line", message), err=True)
    sys.exit(INCOMPLETE)


def tell_json(answer: Mapping[str, Any]) -> None:
    """Print an answer for programs: numbers and arrays of NumPy as numbers and lists, what is not finite as null."""
    context = click.get_current_context(silent=True)
    stdout = context.meta.get(_STDOUT) if context else None
    screen.echo(json.dumps(_plain(answer), indent=2, allow_nan=False), file=stdout)


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


def reports_wrong_input(command: Callable[..., None]) -> Callable[..., None]:
    """Turn the errors meant for people into their text and an exit code; all others are bugs and show a traceback.

    With `--quiet` and `--json` nothing that is for people goes to standard output.
    """

    @wraps(command)
    def guarded(*args: Any, **kwargs: Any) -> None:
        from stickslip.errors import (
            ClusterError,
            ConfigError,
            IncompleteError,
            NotReachedError,
            PlotError,
            StoreError,
        )

        meta = click.get_current_context().meta
        silent = meta.get(screen.QUIET) or kwargs.get("as_json")
        meta[_STDOUT] = sys.stdout  # for `tell_json`; all else that is printed there is for people
        try:
            with _nowhere() if silent else nullcontext():
                command(*args, **kwargs)
                write_table_asked_for(kwargs)
        except (IncompleteError, NotReachedError, PlotError) as error:
            incomplete(error)
        except (ClusterError, ConfigError, StoreError) as error:
            fail(error)
        if meta.get(_UNDRAWN):
            sys.exit(INCOMPLETE)

    return guarded


@contextmanager
def drawing(target: object) -> Iterator[None]:
    """What is computed is there, and is told of, though its picture or page fails: this says so, and the command ends
    with the exit code for what is not complete."""
    from stickslip.errors import PlotError, StoreError

    try:
        yield
    except (PlotError, StoreError) as error:
        screen.echo(f"{target}: not drawn: {error}", err=True)
        click.get_current_context().meta[_UNDRAWN] = True


@contextmanager
def _nowhere() -> Iterator[None]:
    """Standard output goes nowhere."""
    with open(os.devnull, "w", encoding="utf-8") as nowhere, redirect_stdout(nowhere):
        yield


def _dask(value: str | None) -> str | None:
    from stickslip.config.sections import ADDRESS, is_address

    if value is not None and not is_address(value):
        raise click.BadParameter(f"got {value!r}, expected {ADDRESS}")
    return value


def prepare_kernels(law: str, signals: bool = False) -> None:
    """Compile the kernels if need be, and say so."""
    from stickslip import engine

    if not engine.will_compile(law, signals):
        return engine.warm_up(law, signals)
    if screen.is_quiet():
        return engine.warm_up(law, signals)
    console = screen.terminal(stderr=True)
    began = perf_counter()
    notice = "Compiling the kernels for this machine, once ..."
    if not console.is_terminal:
        console.print(notice)
    with console.status(notice):
        engine.warm_up(law, signals)
    seconds = screen.duration_text(perf_counter() - began)
    loads = "; later runs load them" * engine.is_cached(law, signals)  # a warning has said why not
    console.print(f"Compiled the kernels in {seconds}{loads}.")


def kept_output(context: click.Context, output: Location | None) -> Location | None:
    """Where a result is kept, if a table is asked for: beside it, as netCDF, which can be resumed and read again."""
    if not isinstance(output, Path) or output.suffix.lower() not in (".csv", ".xlsx"):
        return output
    kept: Path = checked(output.with_suffix(".nc"), "result")
    if context.command.name not in _KNOWS_ITS_OWN and kept.exists():
        fail(f"{output}: its numbers are kept in {kept}, which exists: choose another name, or remove that file")
    context.meta[_TABLE] = output
    return kept


def write_table_asked_for(options: Mapping[str, Any]) -> None:
    """Write the table of the result that this call wrote, if one is asked for; a shard has no result yet."""
    table, output = click.get_current_context().meta.get(_TABLE), options.get("output")
    if table is None or options.get("shard") or not isinstance(output, Path) or not output.exists():
        return
    from stickslip.cli.tables import tell_table, write_table
    from stickslip.files import reading

    with reading.look_into(output) as ds:
        tell_table(write_table(ds, table), table)


def pairs(texts: tuple[str, ...]) -> dict[str, str]:
    """NAME=VALUE texts as a mapping."""
    found = {}
    for text in texts:
        name, equals, value = text.partition("=")
        if not equals:
            fail(f"got {text!r}, expected NAME=VALUE")
        found[name.strip()] = value.strip()
    return found


def location_or_none(name: str | None, *kinds: str) -> Any:
    """A name in a configuration as the place of a file to be written, of these kinds, for a run (`Target`)."""
    return None if name is None else Target(*kinds).convert(name, None, click.get_current_context())


def checked(place: Location, *kinds: str) -> Any:
    """The place itself; ends the command if no file of these kinds can be written there."""
    from stickslip.errors import StoreError
    from stickslip.files import targets

    try:
        targets.check_target(place, *kinds)
    except StoreError as error:
        fail(error)
    return place
