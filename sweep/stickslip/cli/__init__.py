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
    "To begin": {"init": "configs", "run": "run", "plot": "plot", "help": "help"},
    "before a run": {"validate": "configs", "plan": "plan", "schema": "configs"},
    "results": {"inspect": "results", "export": "results"},
    "one cell": {"simulate": "simulate", "advise": "advise"},
    "studies": {
        key: "studies" for key, entry in STUDIES.items() if entry.command and entry.place.startswith("stickslip.")
    },
    "long runs": {"status": "stores", "collect": "stores", "retry-failed": "stores"},
}


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
    of regimes: netCDF or Zarr, and a plot. `stickslip init my.yaml` writes a commented one to change.
    """
    warnings.showwarning = lambda message, *_: screen.notice(f"warning: {message}")
    if context.invoked_subcommand is None:
        screen.echo(context.get_help())
        screen.echo(f"\n{next_step()}")
