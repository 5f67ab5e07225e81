"""The page of all commands: what `--help` says of each, from click itself."""

from collections.abc import Iterator

import click

from stickslip.cli import main

WIDTH = 100
HEAD = """# Every command

What `stickslip COMMAND --help` prints, for all of them.
"""


def page() -> str:
    """The whole page, in Markdown."""
    return "\n".join([HEAD, *_entries(main.context_class(main, info_name="stickslip", **main.context_settings))])


def _entries(context: click.Context) -> Iterator[str]:
    """A command and, of a group, those below it, by name."""
    context.terminal_width = context.max_content_width = WIDTH
    yield f"## {context.command_path}\n\n```text\n{context.command.get_help(context).rstrip()}\n```\n"
    if isinstance(context.command, click.Group):
        for name in context.command.list_commands(context):
            command = context.command.get_command(context, name)
            if command is not None and not command.hidden:
                yield from _entries(type(context)(command, parent=context, info_name=name))
