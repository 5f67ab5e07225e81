"""`export`: results as tables."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import click

from stickslip.cli import params, screen
from stickslip.cli.exits import fail, reports_errors
from stickslip.cli.outputs import save_table

if TYPE_CHECKING:
    from stickslip.files.locations import Location


@click.command(
    epilog="""\b
Examples:
  stickslip export quickstart.nc -o quickstart.csv
  stickslip export quickstart.nc --variable regime --variable period -o periods.xlsx
  stickslip export map.nc --select stiffness="5 N/mm" -o line.csv --decimal-comma"""
)
@click.argument("file", type=params.Place())
@click.option("-o", "--output", type=params.Target("table"), help="Table to write, .csv or .xlsx.  [default: FILE.csv]")
@click.option("--variable", "variables", multiple=True, metavar="NAME", help="Variable to write.  [default: all]")
@click.option(
    "--select", multiple=True, metavar="DIM=VALUE", help="Take only cells with this value, or label, of a dimension."
)
@click.option("--decimal-comma", is_flag=True, help="Write decimal commas, and semicolons between columns.")
@reports_errors
def export(
    file: Location, output: Path | None, variables: tuple[str, ...], select: tuple[str, ...], decimal_comma: bool
) -> None:
    """Write a result as a table, CSV or Excel: one row a cell.

    Headings carry units, flags are words, what is not defined is empty. FILE may be larger than memory. A sheet of
    Excel holds 1,048,575 cells. (pip install "stickslip[excel]")
    """
    from stickslip.dataset import select as selection
    from stickslip.errors import PlotError
    from stickslip.files import reading

    target = output or params.checked(Path(file.name).with_suffix(".csv"), "table")
    with reading.look_into(file) as ds:
        places = params.pairs(select)
        try:
            part = selection.selected(ds, places)[0] if places else ds
        except PlotError as error:
            fail(f"{file}: {error}")
        for point in selection.told(ds, places) if places else ():
            screen.echo(f"taken    {point}")
        save_table(part, target, variables, decimal_comma)
