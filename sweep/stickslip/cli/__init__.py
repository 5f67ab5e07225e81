"""The command `stickslip`, one module per group of commands.

Everything slow is imported inside the command that needs it, so that `--help` answers at once. Results go to standard
output; progress, notices and errors to standard error.
"""

import warnings
from collections.abc import Callable, Iterable, Mapping
from functools import cache
from importlib import import_module
from typing import Any

import click

from stickslip import extensions
from stickslip._version import __version__
from stickslip.cli import screen
from stickslip.cli.params import next_step
from stickslip.vocabulary.quantities import STUDIES

Places = Mapping[str, str]  # the modules in which commands are, by name
Sections = Mapping[str, Places]  # by heading of the help


@cache
def _imported(name: str, module: str) -> click.Command:
    """The command of a module."""
    names = vars(import_module(module))
    commands = (*names.values(), *names.get("COMMANDS", {}).values())
    return next(command for command in commands if isinstance(command, click.Command) and command.name == name)


class SectionedGroup(click.Group):
    """A group whose help lists its commands under headings, in the order of a table: a run does not wait for others.

    sections : places of commands by heading. more : gives those of extensions, when they are asked for.
    default : the command of arguments that begin with none of the commands.
    """

    def __init__(
        self,
        *args: Any,
        sections: Sections,
        more: Callable[[], Iterable[tuple[str, Places]]] = tuple,
        default: str | None = None,
        **given: Any,
    ) -> None:
        super().__init__(*args, **given)
        self._own, self._more, self._default = sections, more, default

    def _sections(self) -> Sections:
        """The places of all commands, by heading."""
        sections = {heading: dict(row) for heading, row in self._own.items()}
        for heading, row in self._more():
            sections.setdefault(heading, {}).update(row)
        return sections

    def get_command(self, ctx: click.Context, cmd_name: str) -> click.Command | None:
        """The command of a name; extensions are asked where it is none of the group's own."""
        rows = self._own.values() if any(cmd_name in row for row in self._own.values()) else self._sections().values()
        place = next((row[cmd_name] for row in rows if cmd_name in row), None)
        return None if place is None else _imported(cmd_name, place)

    def list_commands(self, ctx: click.Context) -> list[str]:
        """The names that are listed, in the order of the table."""
        return [name for row in self._sections().values() for name in row]

    def parse_args(self, ctx: click.Context, args: list[str]) -> list[str]:
        """The arguments, with the command that is meant."""
        if self._default and args and args[0] not in (*self.list_commands(ctx), *ctx.help_option_names):
            args = [self._default, *args]  # here already, since options may come first
        return super().parse_args(ctx, args)

    def format_commands(self, ctx: click.Context, formatter: click.HelpFormatter) -> None:
        """The commands of the first heading with their short helps, those of others in a line."""
        (first, names), *others = self._sections().items()
        commands = {name: self.get_command(ctx, name) for name in names}
        limit = formatter.width - 6 - max(map(len, names))
        with formatter.section(first):
            formatter.write_dl(
                [(name, command.get_short_help_str(limit)) for name, command in commands.items() if command]
            )
        if others:
            with formatter.section("More, each with --help"):
                formatter.write_dl([(heading, ", ".join(row)) for heading, row in others])


_CONFIGS, _RESULTS, _STORES = (f"{__name__}.{file}" for file in ("configs", "results", "stores"))
_STUDIES = [key for key, entry in STUDIES.items() if entry.command and entry.place.startswith("stickslip.")]
SECTIONS: Sections = {  # of the help: each command with its module, a new one is an entry here
    "To begin": {"init": _CONFIGS, "run": f"{__name__}.run", "plot": _RESULTS, "help": _CONFIGS},
    "before a run": {"validate": _CONFIGS, "plan": _STORES},
    "results": {"inspect": _RESULTS, "export": _RESULTS},
    "one cell": dict.fromkeys(("simulate", "advise"), _CONFIGS),
    "studies": dict.fromkeys(_STUDIES, f"{__name__}.run"),
    "long runs": dict.fromkeys(("status", "collect", "retry-failed"), _STORES),
}


@click.group(
    cls=SectionedGroup,
    sections=SECTIONS,
    more=extensions.commands,
    invoke_without_command=True,
    context_settings={"help_option_names": ["-h", "--help"], "max_content_width": 100},
    epilog=screen.EXIT_CODES,
)
@click.version_option(__version__, prog_name="stickslip")
@click.pass_context
def main(context: click.Context) -> None:
    """Where does a friction contact stick and slip?

    A YAML file names a friction pair and what to vary; `run` computes the motion of every combination and writes a map
    of regimes: netCDF or Zarr, and a plot. `stickslip init my.yaml` writes a commented one to change.
    """
    warnings.showwarning = lambda message, *_: screen.notice(f"warning: {message}")
    if context.invoked_subcommand is None:
        screen.echo(context.get_help())
        screen.echo(f"\n{next_step()}")
