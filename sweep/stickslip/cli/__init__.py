"""The command `stickslip`, one module per group of commands.

Everything slow is imported inside the command that needs it, so that `--help` answers at once. Results go to standard
output; progress, notices and errors to standard error.
"""

import warnings

import click

from stickslip import extensions
from stickslip._version import __version__
from stickslip.cli import screen
from stickslip.cli.exits import EXIT_CODES
from stickslip.cli.groups import SectionedGroup
from stickslip.cli.params import next_step
from stickslip.vocabulary.studies import STUDIES

SECTIONS = {  # of the help: each command with its file, a new one is an entry here
    "To begin": {"init": "configs", "validate": "configs", "schema": "configs", "help": "help"},
    "Maps": {
        "plan": "plan", "run": "run", "plot": "plot", "inspect": "results", "export": "results",
    },
    "One cell, and what a designer asks": {
        "simulate": "simulate",
        **{key: "studies" for key, entry in STUDIES.items() if entry.command and entry.place.startswith("stickslip.")},
        "advise": "advise",
    },
    "Long runs and clusters": {"status": "stores", "collect": "stores", "retry-failed": "stores"},
}  # fmt: skip


def _places(files: dict[str, str]) -> dict[str, str]:
    return {name: f"{__name__}.{file}" for name, file in files.items()}


@click.group(
    cls=SectionedGroup,
    sections={heading: _places(row) for heading, row in SECTIONS.items()},
    more=extensions.commands,
    invoke_without_command=True,
    context_settings={"help_option_names": ["-h", "--help"], "max_content_width": 100},
    epilog=EXIT_CODES,
)
@click.version_option(__version__, prog_name="stickslip")
@click.pass_context
def main(context: click.Context) -> None:
    """Where does a friction contact stick and slip?

    A YAML file names a friction pair and what to vary; `run` computes the motion of every combination and writes a map
    of regimes: netCDF or Zarr, and a plot.

    \b
    Start here:
      stickslip init my.yaml            a commented configuration to change
      stickslip plan my.yaml            how many cells, how long
      stickslip run my.yaml             compute it
      stickslip simulate my.yaml ...    one cell over time
      stickslip help                    what there is to read; each command has --help
    """
    warnings.showwarning = lambda message, *_: screen.notice(f"warning: {message}")
    if context.invoked_subcommand is None:
        screen.echo(context.get_help())
        screen.echo(f"\n{next_step()}")
