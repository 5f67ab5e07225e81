"""Calls of the command line within the process of the test."""

from click.testing import CliRunner

from stickslip.cli import main


def invoke(*arguments):
    """What a command says, and its exit code; an exception that is no exit is raised."""
    done = CliRunner().invoke(main, [str(a) for a in arguments])
    if done.exception and not isinstance(done.exception, SystemExit):
        raise done.exception
    return done
