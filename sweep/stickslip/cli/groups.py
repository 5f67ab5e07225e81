"""Groups of commands: listed in sections, forgiving where a file is named instead of a command; names to complete."""

from collections import UserDict
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from functools import partial
from importlib import import_module
from pathlib import Path
from typing import Any

import click
from click.shell_completion import CompletionItem

Places = Mapping[str, str]  # the modules in which commands are, by name
Sections = Mapping[str, Places]  # by heading of the help
_COMMANDS_FOR = {
    ".yaml": ("run", "validate"), ".yml": ("run", "validate"),
    ".nc": ("inspect", "plot"), ".zarr": ("inspect", "plot"), ".parts": ("status", "collect"),
}  # fmt: skip


class _Commands(UserDict[str, Any]):
    """Commands by name, each imported when it is asked for: a run does not wait for what the others need.

    Those of extensions join when one is asked for that is not among the group's own, or all are.
    """

    def __init__(self, places: Places, sections: Callable[[], Sections]) -> None:
        super().__init__(places)
        self._sections, self._joined = sections, False

    def _join(self) -> None:
        if not self._joined:
            self._joined = True
            self.data = {name: place for row in self._sections().values() for name, place in row.items()} | self.data

    def __contains__(self, name: object) -> bool:
        if name not in self.data:
            self._join()
        return name in self.data

    def __iter__(self) -> Iterator[str]:
        self._join()
        return iter(self.data)

    def __getitem__(self, name: str) -> click.Command:
        if name not in self:
            raise KeyError(name)
        command = self.data[name]
        if isinstance(command, str):
            command = self.data[name] = _imported(name, command)
        return command  # type: ignore[no-any-return]


def _imported(name: str, module: str) -> click.Command:
    """The command of a module."""
    names = vars(import_module(module))
    commands = (*names.values(), *names.get("COMMANDS", {}).values())
    command = next(c for c in commands if isinstance(c, click.Command) and c.name == name)
    complete_names(command)
    return command


class SectionedGroup(click.Group):
    """A group whose help lists its commands under headings, in the order of a table.

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
        places = {name: place for row in sections.values() for name, place in row.items()}
        super().__init__(*args, **given)
        self.commands = _Commands(places, self._all_sections)
        self._own, self._more, self._default = sections, more, default

    def _all_sections(self) -> Sections:
        """The places of all commands, by heading."""
        sections = {heading: dict(row) for heading, row in self._own.items()}
        for heading, row in self._more():
            sections.setdefault(heading, {}).update(row)
        return sections

    def parse_args(self, ctx: click.Context, args: list[str]) -> list[str]:
        """The arguments, with the command that is meant."""
        if self._default and args and args[0] not in (*self.commands, *ctx.help_option_names):
            args = [self._default, *args]  # here already, since options may come first
        return super().parse_args(ctx, args)

    def list_commands(self, ctx: click.Context) -> list[str]:
        """The names that are listed, in the order of the table."""
        return [name for row in self._all_sections().values() for name in row]

    def format_commands(self, ctx: click.Context, formatter: click.HelpFormatter) -> None:
        """The commands with their short helps, a list for each heading."""
        sections = self._all_sections()
        width = max(len(name) for row in sections.values() for name in row)
        for heading, names in sections.items():
            limit = formatter.width - 6 - width
            rows = [(name.ljust(width), self.commands[name].get_short_help_str(limit)) for name in names]
            with formatter.section(heading):
                formatter.write_dl(rows)

    def resolve_command(
        self, ctx: click.Context, args: list[str]
    ) -> tuple[str | None, click.Command | None, list[str]]:
        """The command that is named; where a file is named instead, which commands take it."""
        name = args[0]
        if name not in self.commands and Path(name).suffix.lower() in _COMMANDS_FOR:
            known = [c for c in _COMMANDS_FOR[Path(name).suffix.lower()] if c in self.commands]
            if known:
                lines = "\n".join(f"  {ctx.command_path} {command} {name}" for command in known)
                ctx.fail(f"{name!r} is a file, not a command. What takes it:\n{lines}")
        resolved = super().resolve_command(ctx, args)
        if resolved[1] is not None:
            _refuse_repeated(resolved[1], ctx, resolved[2])
        return resolved


def _refuse_repeated(command: click.Command, ctx: click.Context, args: Sequence[str]) -> None:
    """End where an option that takes one value is given several: click would take the last without a word."""
    own = click.Context(command, ctx, command.name, ignore_unknown_options=True)
    try:  # what else is wrong is said when the command reads its options
        given = command.make_parser(own).parse_args(list(args))[2]
    except click.UsageError:
        return
    for option in given:
        single = isinstance(option, click.Option) and not (option.is_flag or option.multiple or option.count)
        if single and given.count(option) > 1:
            name = max(option.opts, key=len)
            raise click.UsageError(f"{name} is given {given.count(option)} times, and takes one value", own)


# --- names that shells propose after an option ------------------------------------------------------------------------

_PARAMETERS = ("vocabulary.quantities", "PARAMETERS")
_NAMES = {  # by option, in whatever command it is: the table, or the function that gives it
    "--variable": ("vocabulary.results", "MAP_VARIABLES"), "--along": ("vocabulary.quantities", "SEARCHABLE"),
    "--at": _PARAMETERS, "--select": _PARAMETERS, "--mark": _PARAMETERS,
    "--regime": ("vocabulary.flags", "REGIMES"), "--status": ("vocabulary.flags", "STATUSES"),
    "--from": ("config.examples", "config_names"),
}  # fmt: skip


def complete_names(command: click.Command) -> None:
    """Let the shell complete the names that options of a command take."""
    for parameter in command.params:
        for option in parameter.opts:
            if option in _NAMES and isinstance(parameter, click.Option) and parameter.metavar != "TIME":
                setattr(parameter, "shell_complete", partial(_proposed, option))  # noqa: B010 - a method of click's, replaced


def _proposed(option: str, _context: click.Context, typed: str) -> list[CompletionItem]:
    """The names that begin with what was typed so far."""
    module, table = _NAMES[option]
    names = getattr(import_module(f"stickslip.{module}"), table)
    names = names() if callable(names) else [f"{name}=" for name in names] if table == "PARAMETERS" else names
    return [CompletionItem(name) for name in names if name.startswith(typed)]
