"""Arguments and options that commands share, and the configuration they name."""

from __future__ import annotations

import os
from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from stickslip.cli import screen
from stickslip.cli.screen import fail
from stickslip.vocabulary.quantities import STUDIES

if TYPE_CHECKING:
    from stickslip.config.grid import Recipe
    from stickslip.config.model import Config
    from stickslip.config.yaml import Setting
    from stickslip.files.locations import Location
    from stickslip.files.targets import Kind

Command = Callable[..., Any]
PAGES = (".html", ".htm")
_TABLE = "stickslip.table"  # of a call
_RESUMING = ("run", *STUDIES, "collect")  # know their own result

# --- places -----------------------------------------------------------------------------------------------------------


class PathOrUrl(click.Path):
    """A file, or the URL of a Zarr store, which a `Path` would spoil.

    expected : what is named where it is missing, a `result` or a `configuration`.
    """

    def __init__(self, expected: str = "result") -> None:
        super().__init__()
        self.name, self._expected = "path_or_url", expected

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> Location:
        """The place that a text names."""
        from stickslip.files.locations import location

        return location(value)

    def get_missing_message(self, param: click.Parameter, ctx: click.Context | None = None) -> str:
        """Files of this folder that could have been named."""
        if self._expected == "configuration":
            return next_step()
        here = names_here("*.nc", "*.zarr")
        return f"Results in this folder: {', '.join(here)}" if here else "No result (.nc, .zarr) is in this folder."


class Target(PathOrUrl):
    """A file to be written (`targets.check_target`), refused before anything is computed if it cannot be."""

    def __init__(self, *kinds: str | Kind) -> None:
        super().__init__()
        self.name, self._kinds = "path", kinds

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> Location:
        """The place that a text names."""
        place = super().convert(value, param, ctx)
        if ctx is not None and not ctx.resilient_parsing and not (ctx.info_name == "run" and self._is_there(place)):
            checked(place, *self._kinds)
        return place  # if there, maybe of a finished run, which writes nothing; else a run looks itself

    def _is_there(self, place: Location) -> bool:
        from stickslip.files.targets import kinds_of

        suffixes = [suffix for kind in kinds_of(self._kinds) for suffix in kind.suffixes]
        return place.suffix.lower() in suffixes and os.path.isfile(str(place))


def checked(place: Location, *kinds: str | Kind) -> Any:
    """The place itself; ends the command if no file of these kinds can be written there."""
    from stickslip.errors import StoreError
    from stickslip.files import targets

    try:
        targets.check_target(place, *kinds)
    except StoreError as error:
        fail(error)
    return place


def configured_target(name: str | None, *kinds: str) -> Any:
    """A name in a configuration as the place of a file to be written, of these kinds, for a run (`Target`)."""
    return None if name is None else Target(*kinds).convert(name, None, click.get_current_context())


def configured_targets(config: Config) -> tuple[Any, Any, Any]:
    """Result, plot and page that a configuration names, for a run (`configured_target`)."""
    names, kinds = (config.output.file, config.output.plot, config.output.report), ("result", "plot", "page")
    result, plot, page = map(configured_target, names, kinds)
    return result, plot, page


def _result_beside(context: click.Context, _option: click.Parameter, output: Location | None) -> Location | None:
    """The output or, of a table, the netCDF file beside it, which can be resumed and read again."""
    if not isinstance(output, Path) or output.suffix.lower() not in (".csv", ".xlsx"):
        return output
    result: Path = checked(output.with_suffix(".nc"), "result")
    if context.command.name not in _RESUMING and result.exists():
        fail(f"{output}: its numbers are kept in {result}, which exists: choose another name, or remove that file")
    context.meta[_TABLE] = output
    return result


def requested_table() -> Path | None:
    """The table that `--output` names instead of a result."""
    return click.get_current_context().meta.get(_TABLE)


def names_here(*patterns: str) -> list[str]:
    """Names of files in this folder, the first eight."""
    return sorted(path.name for pattern in patterns for path in Path().glob(pattern))[:8]


def next_step() -> str:
    """Text on the next thing to do in this folder."""
    if here := names_here("*.yaml", "*.yml"):
        return f"Configurations in this folder: {', '.join(here)}"
    return "No configuration is in this folder; `stickslip init my.yaml` writes one to start from."


# --- options ----------------------------------------------------------------------------------------------------------


def _setting(_context: click.Context, _option: click.Parameter, texts: tuple[str, ...]) -> tuple[Setting, ...]:
    from stickslip.config.yaml import setting

    try:
        return tuple(map(setting, texts))
    except ValueError as error:
        raise click.BadParameter(str(error)) from None


SET = screen.remembered_option(
    "--set", "settings", multiple=True, metavar="KEY=VALUE", read=_setting,
    help="Set a key of CONFIG, as axes.belt_speed.num=50 or 'system.mass=200 g'; KEY= removes it. Repeatable.",
)  # fmt: skip
THREADS = screen.remembered_option(
    "--threads", metavar="N|auto", help="Threads to compute on; short for --set execution.threads=N."
)
DASK = screen.remembered_option(
    "--dask", metavar="ADDRESS", help="Dask scheduler, its file, or local; short for --set execution.dask=ADDRESS."
)
OUTPUT = click.option(
    "-o", "--output", type=Target("result", "table"), callback=_result_beside,
    help="File to write, .nc or .zarr, or the URL of a .zarr; .csv or .xlsx writes the .nc and a table made of it.",
)  # fmt: skip
AT = click.option("--at", multiple=True, metavar="NAME=VALUE", help="Value of an axis, or of any other quantity.")
RECORDS = click.argument("files", type=click.Path(path_type=Path), nargs=-1, required=True)


def plot_option(text: str = "Plot to write: .png, .svg or .pdf.") -> Callable[[Command], Command]:
    """The option `--plot`."""
    return click.option("--plot", type=Target("plot"), help=text)


def decorated(command: Command, *options: Callable[[Command], Command]) -> Command:
    """A command with several options, in this order."""
    for option in reversed(options):
        command = option(command)
    return command


def CONFIG(command: Command) -> Command:  # noqa: N802, a decorator as those above
    """The argument `config`, and `--set` with it, which `configuration` reads; `recipe_in` also where it is a result,
    which holds its configuration."""
    path = click.argument(
        "config", type=PathOrUrl("configuration"), callback=lambda _context, _parameter, path: config_file(path)
    )
    return decorated(command, path, SET)


# --- what they name ---------------------------------------------------------------------------------------------------


def config_file(path: Location) -> Any:
    """The file of a configuration: the one named or, with a notice, the one of the package that is called so."""
    from stickslip.config.resolve import existing_config

    return _noticed(path, existing_config(path)) if isinstance(path, Path) else path


def points_file(path: Path) -> Path:
    """A table of measured points: the file named or, with a notice, the one of the package that is called so."""
    from stickslip.config.resolve import points_path

    return _noticed(path, points_path(path))


def _noticed(path: Path, file: Path) -> Path:
    if file != path:
        screen.notice(f"{path}: no such file here, taken from those that come with stickslip: {file}")
    return file


def configuration(path: Location) -> Config:
    """The configuration in a file, with `--set` put in. Raises ConfigError."""
    from stickslip.config.reader import load_config

    return load_config(str(path), settings())


def recipe_in(path: Location) -> Recipe:
    """The configuration in a YAML file, or the one in a result. Raises ConfigError, StoreError."""
    from stickslip.config.grid import recipe_of
    from stickslip.config.sections import OUTPUT_SUFFIXES
    from stickslip.files import reading

    if path.suffix.lower() not in OUTPUT_SUFFIXES:
        return configuration(path)
    with reading.look_into(path) as ds:
        return recipe_of(ds, str(path), settings())


def settings() -> tuple[Setting, ...]:
    """Settings of the configuration that `--set` of this call gives, and the options that are short for it."""
    from stickslip.config.yaml import setting

    given = {key: screen.remembered(key) for key in ("threads", "dask")}
    short = (setting(f"execution.{key}={value}") for key, value in given.items() if value is not None)
    return (*(screen.remembered("settings") or ()), *short)


def pairs(texts: tuple[str, ...]) -> dict[str, str]:
    """NAME=VALUE texts as a mapping."""
    for text in texts:
        if "=" not in text:
            fail(f"got {text!r}, expected NAME=VALUE")
    parts = (text.partition("=") for text in texts)
    return {name.strip(): value.strip() for name, _, value in parts}


def numbers(option: str, texts: tuple[str, ...], unit: str = "") -> dict[str, float]:
    """NAME=NUMBER texts as a mapping. unit : of the numbers, which may be left out."""
    try:
        return {name: float(number.removesuffix(unit)) for name, number in pairs(texts).items()}
    except ValueError as error:
        fail(f"{option}: {error}, expected NAME=NUMBER")


def si_quantity(option: str, text: str, unit: str, expected: str, or_zero: bool = False) -> float:
    """A quantity above 0 with or without its unit, in SI. Raises ConfigError, which says what is `expected`."""
    from stickslip.errors import ConfigError, QuantityError
    from stickslip.vocabulary import units

    try:
        value = units.si_value(units.number_or_text(text), unit)
        if value < 0 or (value == 0 and not or_zero):
            raise QuantityError(expected)
    except QuantityError as error:
        raise ConfigError.of(option, f"got {text!r}, {error}") from None
    return value
