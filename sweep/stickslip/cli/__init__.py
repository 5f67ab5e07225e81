"""The command `stickslip`, one module per group of commands.

Everything slow is imported inside the command that needs it, so that `--help` answers at once. Results go to standard
output; progress, notices and errors to standard error.
"""

from __future__ import annotations

import warnings

import click

from stickslip._version import __version__
from stickslip.cli import (
    advice,
    attractors,
    borders,
    configs,
    contours,
    explore,
    exporting,
    fits,
    inspection,
    maps,
    planning,
    results,
    rig,
    rig_tests,
    science,
    stores,
    trajectories,
)
from stickslip.cli.common import EXIT_CODES

COMMANDS = (
    *(configs.init, configs.schema, configs.validate),
    *(planning.plan, maps.run),
    *(stores.collect, stores.retry_failed, stores.status),
    *(results.plot, exporting.export, inspection.inspect, trajectories.simulate, explore.explore),
    *(borders.border, contours.contours, advice.advise),
    *(attractors.attractors, attractors.ramp),
    *(science.article, fits.fit),
    *(rig_tests.rig, rig.rig_features, rig.calibrate),
)


@click.group(context_settings={"help_option_names": ["-h", "--help"], "max_content_width": 100}, epilog=EXIT_CODES)
@click.version_option(__version__, prog_name="stickslip")
def main() -> None:
    """Where does a friction contact stick and slip?

    A YAML file names a friction pair and what to vary; `run` computes the motion of every combination and writes a map
    of regimes: netCDF or Zarr, and a plot.

    \b
    Start here:
      stickslip init my.yaml            a commented configuration to change
      stickslip plan my.yaml            how many cells, how long
      stickslip run my.yaml             compute it
      stickslip simulate my.yaml ...    one cell over time
    """
    warnings.showwarning = lambda message, *_: click.echo(f"warning: {message}", err=True)


for command in COMMANDS:
    main.add_command(command)
