"""What goes with borders on the command line: the map behind them, and a table of their points."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

import click

from stickslip.cli.common import WHERE

if TYPE_CHECKING:
    import xarray as xr

    from stickslip.files.locations import Location

MAP = click.option(
    "--map", "map_file", type=WHERE,
    help="Map to draw the borders over, of the same cells.  [default: a coarse one is computed]",
)  # fmt: skip


@dataclass(frozen=True)
class Extras:
    """What is wanted besides a result and its plot: the file of the map behind it, a table to write, a page."""

    map: Location | None = None
    table: Path | None = None
    page: Path | None = None

    @property
    def any(self) -> bool:
        """Whether there is something to write."""
        return self.table is not None or self.page is not None

    def write_table(self, ds: xr.Dataset) -> None:
        """Write the table, if one is wanted, and say so."""
        if self.table is None:
            return
        from stickslip.cli.tables import tell_table, write_table

        tell_table(write_table(ds, self.table), self.table)

    def map_behind(self, ds: xr.Dataset) -> xr.Dataset:
        """The map over which the borders of a dataset are drawn. Raises StoreError for a file that is none."""
        if self.map is not None:
            from stickslip.files import reading

            return reading.look_into(self.map)
        from stickslip.accessor import map_behind

        return map_behind(ds)
