"""Calls of the command line within the process of the test."""

import os
import subprocess
import sys
from pathlib import Path

import click
from click.testing import CliRunner

from stickslip.cli import main

ROOT = Path(__file__).parents[2]


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


def completed(words, incomplete=""):
    """What is proposed after some words, by the process that a shell starts, which leaves by os._exit."""
    line = " ".join(["stickslip", *words, incomplete])
    paths = os.pathsep.join(str(ROOT / root) for root in ("sweep", "kernels"))
    variables = {"_STICKSLIP_COMPLETE": "bash_complete", "COMP_WORDS": line, "COMP_CWORD": str(len(words) + 1)}
    done = subprocess.run(
        [sys.executable, "-m", "stickslip"], env=os.environ | {"PYTHONPATH": paths} | variables, capture_output=True,
        text=True, check=False,
    )  # fmt: skip
    return [row.partition(",")[2] for row in done.stdout.splitlines()]
