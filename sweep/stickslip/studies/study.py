"""Count of the finished items of a study, and columns of several ranges in one.

Reports of studies on their results: tables for the screen and for pages, and how a search was done.
"""

from collections.abc import Hashable, Iterator, Sequence
from itertools import islice
from threading import Lock
from typing import Any

import numpy as np
import xarray as xr

from stickslip.config.sections import StudySection
from stickslip.config.studies import Moved, ReportTable
from stickslip.dataset.display import MapAxis
from stickslip.engine import Options, Results

_MOST = 0.95  # of items that may take more cells than expected, until they are done


class Meter:
    """Count of finished items, by many threads; those under way by the share of the cells they may take.

    cells_each : as that of a study. done : items found finished.
    """

    def __init__(self, cells_each: int, done: int = 0) -> None:
        self._each, self._done, self._lock = cells_each, done, Lock()
        self._under_way: dict[int, tuple[int, int]] = {}  # items and cells, by number of the block

    def watch(self, number: int, items: int) -> Moved:
        """Return what computing a block of so many items calls with cells computed."""

        def moved(cells: int) -> None:
            with self._lock:
                self._under_way[number] = items, self._under_way.get(number, (items, 0))[1] + cells

        return moved

    def end(self, number: int, items: int) -> None:
        """Count a block as done, or with no items as none."""
        with self._lock:
            self._under_way.pop(number, None)
            self._done += items

    @property
    def items(self) -> float:
        """Items done; a whole number where no block is under way, or where an item is a cell."""
        with self._lock:
            most = 1.0 if self._each <= 1 else _MOST  # where they take more cells than expected, not yet all
            return self._done + sum(min(cells / max(self._each, 1), most * n) for n, cells in self._under_way.values())


def joined(parts: Sequence[Results]) -> Results:
    """Columns of several ranges, end to end."""
    names = dict.fromkeys(name for part in parts for name in part)
    return {name: np.concatenate([part[name] for part in parts if name in part]) for name in names}


MOST_ROWS = 30  # of a table on the screen
_SETTINGS = ("tolerance", "rtol", "scan", "points")


def shown(table: ReportTable) -> Iterator[ReportTable | str]:
    """The first rows of a table, and that there are more."""
    rows = iter(table.rows)
    yield table._replace(rows=list(islice(rows, MOST_ROWS)))
    if next(rows, None) is not None:
        yield "... and more"


def axis_names(ds: xr.Dataset, dims: Sequence[Hashable]) -> list[str]:
    """The headings of columns that say where along some dimensions a row of a table is."""
    return [MapAxis(ds, dim, plain=True).name for dim in dims]


def parts_over(ds: xr.Dataset, dims: Sequence[Hashable]) -> Iterator[tuple[list[str], xr.Dataset]]:
    """Each place along some dimensions, as the texts of such columns, and the dataset there."""
    axes = [MapAxis(ds, dim, plain=True) for dim in dims]
    for place in np.ndindex(tuple(ds.sizes[dim] for dim in dims)):
        yield [axis.text(i) for axis, i in zip(axes, place, strict=True)], ds.isel(dict(zip(dims, place, strict=True)))


def search_attributes(section: StudySection, options: Options) -> dict[str, Any]:
    """How exactly borders were looked for, as attributes of a result (``border_tolerance``)."""
    settings = section.resolved() | {"rtol": options.rtol}
    prefix = section.key.removesuffix("s")
    return {f"{prefix}_{name}": settings[name] for name in _SETTINGS if name in settings}


def search_settings(ds: xr.Dataset, prefix: str) -> str:
    """The same as a line for the screen."""
    settings = {name: ds.attrs[f"{prefix}_{name}"] for name in _SETTINGS if f"{prefix}_{name}" in ds.attrs}
    return "search   " + ", ".join(f"{name} {value:g}" for name, value in settings.items())
