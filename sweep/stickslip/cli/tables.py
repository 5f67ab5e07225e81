"""Tables on their way to a file, with a bar where they are long, and what is said of them."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

from stickslip.cli import screen
from stickslip.cli.progress import progress_bar

if TYPE_CHECKING:
    import xarray as xr

    from stickslip.dataset.export import Table

_LONG = 500_000  # rows from which a bar tells how far it is


def write_table(ds: xr.Dataset, target: Path, variables: tuple[str, ...] = (), decimal: str = ".") -> Table:
    """Write a table; a long one with a bar. The workbook of a comparison begins with the table that is printed."""
    from stickslip.dataset import export

    rows = export.table_of(ds, variables).rows
    if rows < _LONG:
        front = None
        if "quiet_above" in ds and not variables and target.suffix.lower() == ".xlsx":
            from stickslip.materials.table import RankTable

            front = RankTable(ds).sheet()
        return export.write_table(ds, target, variables, decimal=decimal, front=front)
    with progress_bar(rows, " written", "rows") as move:
        return export.write_table(ds, target, variables, decimal=decimal, progress=move)


def tell_table(table: Table, target: Path) -> None:
    """Say what was written, and what was not."""
    screen.echo(f"table    {target} ({table.rows:,} rows, {len(table.columns)} columns, {screen.size_of(target)})")
    if table.left_out:
        names = ", ".join(table.left_out)
        screen.echo(f"left out {names}: of other dimensions; write them with stickslip export --variable")
