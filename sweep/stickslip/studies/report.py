"""Reports of studies on their results: tables for the screen and for pages, and how a search was done."""

from collections.abc import Hashable, Iterator, Sequence
from itertools import islice
from typing import Any

import numpy as np
import xarray as xr

from stickslip.config.sections import StudySection
from stickslip.config.studies import Table
from stickslip.dataset.display import MapAxis
from stickslip.engine import Options

MOST_ROWS = 30  # of a table on the screen
_SETTINGS = ("tolerance", "rtol", "scan", "points")


def shown(table: Table) -> Iterator[Table | str]:
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
