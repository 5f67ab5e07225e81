"""`inspect`: what is in a map, and its cells one by one."""

from __future__ import annotations

from itertools import groupby
from typing import TYPE_CHECKING

import click

from stickslip.cli import answers, comparing, screen, shown
from stickslip.cli.common import JSON, WHERE, fail, reports_wrong_input, tell_json

_UNDECIDED = ("failed", "unresolved")
_WHY_NOT_KEPT = "for a reason that is in status, which output.variables leaves out"

if TYPE_CHECKING:
    from stickslip.dataset.survey import Survey
    from stickslip.files.locations import Location


@click.command(
    epilog="""\b
Examples:
  stickslip inspect map.nc
  stickslip inspect map.nc --regime sustained --limit 5
  stickslip inspect map.zarr --status step_limit"""
)
@click.argument("file", type=WHERE)
@click.option("--regime", "regimes", multiple=True, metavar="NAME", help="List cells of this regime.")
@click.option("--status", "statuses", multiple=True, metavar="NAME", help="List cells of this status.")
@click.option("--limit", type=click.IntRange(0), default=20, show_default=True, help="Largest number of cells to list.")
@JSON
@reports_wrong_input
def inspect(file: Location, regimes: tuple[str, ...], statuses: tuple[str, ...], limit: int, as_json: bool) -> None:
    """Count the cells of a result, and list problem cells.

    These are cells that failed, are unresolved or were not computed, unless --regime or --status say which to list.
    Each is listed as a command that computes it over time, ready to paste. Of results that are no maps it
    says what was found.
    """
    from stickslip.config.select import recipe_of
    from stickslip.dataset import survey as inspection
    from stickslip.files import reading

    ds = reading.look_into(file)
    if "quiet_above" in ds:
        return comparing.tell(ds, as_json)
    if "status" not in ds and (tell := shown.teller(ds)):
        if regimes or statuses:
            fail(f"{file}: --regime and --status list the cells of a map; this file holds none")
        if as_json:
            fail(f"{file}: --json tells of the cells of a map; this file holds none")
        return tell(ds)
    found = inspection.survey(ds, recipe_of(ds, str(file)), regimes=regimes, statuses=statuses, limit=limit)
    _table(found)
    what = "such cells" if regimes or statuses else "cells failed, are unresolved or were not computed"
    if not found.cells:
        screen.echo(f"\n{found.wanted:,} {what}")
    elif found.wanted > len(found.cells):
        screen.echo(f"\nThe first {len(found.cells):,} of {found.wanted:,} {what}:")
    else:
        screen.echo(f"\n{found.wanted:,} {what}:")
    _lines(found, str(file))
    if as_json:
        tell_json(answers.of_survey(str(file), found))


def _table(found: Survey) -> None:
    """Numbers of cells by regime and status."""
    from rich.table import Table

    from stickslip.vocabulary.flags import flag_label

    table = Table("regime", "status", box=None, pad_edge=False, header_style="bold")
    table.add_column("cells", justify="right")
    table.add_column("share", justify="right")
    total = max(1, sum(found.counts.values()))
    for (regime, status), cells in found.counts.items():
        table.add_row(flag_label(regime), status, f"{cells:,}", screen.share_text(cells / total))
    screen.print_table(table)


def _lines(found: Survey, file: str) -> None:
    """A command for each cell, under its regime and status."""
    from stickslip.dataset.survey import NOT_KEPT
    from stickslip.vocabulary.flags import STATUS_MESSAGES

    by_fate = sorted(found.cells, key=lambda cell: (cell.regime, cell.status))
    for (regime, status), cells in groupby(by_fate, key=lambda cell: (cell.regime, cell.status)):
        unknown = "a code that this version does not know"
        message = f"{status}: {STATUS_MESSAGES.get(status, unknown)}"
        if status != NOT_KEPT:
            screen.echo(f"\n{regime}, {message}")
        elif regime in _UNDECIDED:
            screen.echo(f"\n{regime}, {_WHY_NOT_KEPT}")
        else:  # a regime that was found needs no reason
            screen.echo(f"\n{regime}" + ": no run has computed these cells" * (regime == "not_computed"))
        for cell in cells:
            screen.echo(cell.command(file))
