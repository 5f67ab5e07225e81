"""`points`: friction over slip speed from a record at steps of speed and load."""

from __future__ import annotations

from pathlib import Path

import click

from stickslip.cli import screen
from stickslip.cli.common import Target, reports_wrong_input


@click.command(
    epilog="""\b
Examples:
  stickslip points disc.csv -o points.csv     # columns: time, speed, force, load
  stickslip points disc.csv -o points.csv --radius "20 mm" --load "10 N"
  stickslip points cof.csv -o points.csv --plan plan.csv    # begin, end, speed, load
  stickslip fit points.csv"""
)
@click.argument("record", type=click.Path(path_type=Path))
@click.option("-o", "--output", type=Target("points"), required=True, help="Table of points to write: .csv.")
@click.option("--plan", type=click.Path(path_type=Path), help="Table of steps: begin, end, speed, load.")
@click.option("--radius", metavar="LENGTH", help='Of the track ("20 mm"), where speeds are those of rotation.')
@click.option("--load", metavar="FORCE", help='Normal load ("10 N"), where no column tells it.')
@click.option("--settle", metavar="TIME", help="Left out at the beginning of each step.  [default: what runs in]")
@reports_wrong_input
def points(
    record: Path, output: Path, plan: Path | None, radius: str | None, load: str | None, settle: str | None
) -> None:
    """Points of friction from a record at steps of speed and load.

    RECORD is a CSV file of a pin-on-disc or block-on-ring test: time, speed, and friction or its force. Each step gives
    a point: the mean friction behind running-in, with the standard deviation that samples which follow each other
    leave. `stickslip fit` and `stickslip compare` read what is written.
    """
    from stickslip.fit import read_steps, write_points
    from stickslip.fit.report import describe_steps

    length, force, time = _si("--radius", radius, "m"), _si("--load", load, "N"), _si("--settle", settle, "s")
    found = read_steps(record, plan, radius=length, load=force, settle=time)
    write_points(found, output)
    screen.echo(describe_steps(found))
    screen.echo(f"points   {output}")


def _si(option: str, text: str | None, unit: str) -> float | None:
    """A quantity above 0 with its unit, in SI. Raises ConfigError."""
    from stickslip.errors import ConfigError, Problem, QuantityError
    from stickslip.files.tables import NUMBER
    from stickslip.vocabulary import units

    if text is None:
        return None
    try:
        value = units.si_value(float(text) if NUMBER.fullmatch(text) else text, unit)
        if not value >= 0 or (value == 0 and unit != "s"):
            raise QuantityError("a value above 0")
    except QuantityError as error:
        raise ConfigError(option, [Problem((), f"got {text!r}, {error}")]) from None
    return value
