"""Groups of commands: the first ones with what they do, the others a line a group; imported when they are called."""

from collections.abc import Callable, Iterable, Mapping
from functools import cache
from importlib import import_module
from pathlib import Path
from typing import Any

import click

Places = Mapping[str, str]  # the modules in which commands are, by name
Sections = Mapping[str, Places]  # by heading of the help
_COMMANDS_FOR = {
    ".yaml": ("run", "validate"), ".yml": ("run", "validate"),
    ".nc": ("inspect", "plot"), ".zarr": ("inspect", "plot"), ".parts": ("status", "collect"),
}  # fmt: skip


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

    def resolve_command(
        self, ctx: click.Context, args: list[str]
    ) -> tuple[str | None, click.Command | None, list[str]]:
        """The command that is named; where a file is named instead, which commands take it."""
        name = args[0]
        known = _COMMANDS_FOR.get(Path(name).suffix.lower(), ())
        if known and known[0] in self.list_commands(ctx) and self.get_command(ctx, name) is None:
            lines = "\n".join(f"  {ctx.command_path} {command} {name}" for command in known)
            ctx.fail(f"{name!r} is a file, not a command. What takes it:\n{lines}")
        return super().resolve_command(ctx, args)
