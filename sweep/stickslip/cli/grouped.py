"""Groups of commands: listed in sections, and forgiving where a file is named instead of a command."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import click

Sections = Mapping[str, Sequence[click.Command]]
_COMMANDS_FOR = {
    ".yaml": ("run", "validate", "rig"), ".yml": ("run", "validate", "rig"),
    ".nc": ("inspect", "plot"), ".zarr": ("inspect", "plot"), ".parts": ("status", "collect"), ".csv": ("fit",),
}  # fmt: skip


class SectionedGroup(click.Group):
    """A group whose help lists its commands under headings, in the order of a table.

    sections : commands by heading. old : commands under spellings that go on working, and are not listed.
    """

    def __init__(self, *args: Any, sections: Sections, old: Sequence[click.Command] = (), **given: Any) -> None:
        super().__init__(*args, **given)
        self._sections = {heading: [str(command.name) for command in row] for heading, row in sections.items()}
        for row in sections.values():
            for command in row:
                self.add_command(command)
        for command in old:
            self.add_command(command)

    def list_commands(self, ctx: click.Context) -> list[str]:
        """The names that are listed, in the order of the table."""
        listed = [name for row in self._sections.values() for name in row]
        return [*listed, *(name for name in sorted(self.commands) if name not in listed)]

    def format_commands(self, ctx: click.Context, formatter: click.HelpFormatter) -> None:
        """The commands with their short helps, a list for each heading."""
        width = max(len(name) for row in self._sections.values() for name in row)
        for heading, names in self._sections.items():
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
        found = super().resolve_command(ctx, args)
        if found[1] is not None:
            _refuse_repeated(found[1], ctx, found[2])
        return found


def _refuse_repeated(command: click.Command, ctx: click.Context, args: Sequence[str]) -> None:
    """End where an option that takes one value is given several: click would take the last without a word."""
    own = click.Context(command, ctx, command.name, ignore_unknown_options=True)
    try:  # what else is wrong is said when the command reads its options
        given = command.make_parser(own).parse_args(list(args))[2]
    except click.UsageError:
        return
    for one in given:
        single = isinstance(one, click.Option) and not (one.is_flag or one.multiple or one.count)
        if single and given.count(one) > 1:
            name = max(one.opts, key=len)
            raise click.UsageError(f"{name} is given {given.count(one)} times, and takes one value", own)


class GroupWithDefault(SectionedGroup):
    """A group that was a command once: arguments that begin with none of its commands are those of `default`."""

    def __init__(self, *args: Any, default: str, **given: Any) -> None:
        super().__init__(*args, **given)
        self._default = default

    def parse_args(self, ctx: click.Context, args: list[str]) -> list[str]:
        """The arguments, with the command that is meant."""
        if args and args[0] not in (*self.commands, *ctx.help_option_names):
            args = [self._default, *args]  # here already, since options may come first
        return super().parse_args(ctx, args)

    def resolve_command(
        self, ctx: click.Context, args: list[str]
    ) -> tuple[str | None, click.Command | None, list[str]]:
        """The command that is named, else the default one with all arguments."""
        return super().resolve_command(ctx, args if args[0] in self.commands else [self._default, *args])


def renamed(command: click.Command, name: str, hidden: bool = False) -> click.Command:
    """The same command under another name."""
    same = click.Command(
        name, callback=command.callback, params=command.params, help=command.help, epilog=command.epilog,
        hidden=hidden, context_settings=command.context_settings,
    )  # fmt: skip
    return same
