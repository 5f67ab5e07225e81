"""Calls of the command line within the process of the test."""

import click
from click.testing import CliRunner

from stickslip.cli import main


def call(*arguments):
    """What the command says to these arguments."""
    return CliRunner().invoke(main, [str(argument) for argument in arguments])


def invoke(*arguments):
    """The same; an exception that is no exit is raised."""
    done = call(*arguments)
    if done.exception and not isinstance(done.exception, SystemExit):
        raise done.exception
    return done


def commands_of(group=main, before=""):
    """All commands by their words, those of groups too."""
    context, commands = click.Context(group), {}
    for name in group.list_commands(context):
        commands[f"{before}{name}"] = command = group.get_command(context, name)
        if isinstance(command, click.Group):
            commands |= commands_of(command, f"{before}{name} ")
    return commands


def told(*arguments: object, code: int = 0) -> str:
    """All that a command prints that ends with this code."""
    done = call(*arguments)
    assert done.exit_code == code, done.output
    return done.output
