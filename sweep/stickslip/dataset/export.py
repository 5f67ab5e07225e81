"""Results as tables for other programs: CSV and Excel, one row a cell, a column for every coordinate and variable.

Numbers are in the units in which people see them, with nine digits; headings carry these units (``belt_speed [mm/s]``),
flags are words, values that are not defined are empty, and no text is a formula. Rows are written a chunk at a time, so
that a file may be larger than memory; the table appears whole or not at all.
"""

from __future__ import annotations

import os
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from math import prod
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
import xarray as xr

from stickslip.config.studies import result_class
from stickslip.dataset.coarse import chunks
from stickslip.dataset.display import CONTAINER, unit_of
from stickslip.errors import StoreError, visible
from stickslip.files.targets import check_target, replaced
from stickslip.files.texts import inert, is_live
from stickslip.vocabulary.display_units import DISPLAY, Unit
from stickslip.vocabulary.quantities import listed, or_meant

if TYPE_CHECKING:
    import pandas as pd

_ROWS_OF_SHEET = 2**20 - 1  # and the headings
_MOST_ROWS = 2**17  # put together at once
_LONGEST_CELL = 32_767  # characters of a cell of Excel
_NUMBER = "%.9g"  # nine digits keep neighbours on an axis apart
_OF_BORDERS = ("regime_below", "regime_above", "regime_throughout", "method")
_ABOUT = ("title", "source", "history", "date_created", "references", "configuration")


@dataclass(frozen=True)
class ResultTable:
    """Columns of a result that become a table. sizes : of the dimensions of its rows, the last one running fastest.

    columns : coordinates first; none has other dimensions. left_out : variables that have, and are in no column.
    """

    sizes: Mapping[str, int]
    columns: Mapping[str, xr.DataArray]
    left_out: tuple[str, ...] = ()

    @property
    def rows(self) -> int:
        """The number of rows, without the headings."""
        return prod(self.sizes.values())

    def frames(self) -> Iterator[pd.DataFrame]:
        """The rows as people read them, under headings with units, a chunk at a time, in the order of the cells."""
        import pandas as pd

        units = {name: _unit(array) for name, array in self.columns.items()}
        written = {name: _written(array, units[name]) for name, array in self.columns.items()}
        headings = {name: visible(f"{name} [{unit.name}]" if unit.name else name) for name, unit in units.items()}
        ds = xr.Dataset({name: array.variable for name, array in self.columns.items()})
        ds = ds if self.sizes else ds.expand_dims("row")
        largest = max(self.columns.values(), key=lambda array: (array.ndim, array.size))
        for chunk in [*chunks(largest, _MOST_ROWS)] or [{}]:
            values = ds.isel(chunk).to_dataframe([*self.sizes] or None).reset_index()
            yield pd.DataFrame({headings[name]: written[name](values[name]) for name in self.columns})


def table_of(ds: xr.Dataset, variables: Sequence[str] = ()) -> ResultTable:
    """The table of a result: all its variables that share the dimensions of the largest, or those that are named.

    Of contours a row is a node, with what is known of its line. Raises StoreError for variables there are not, or whose
    dimensions do not fit together.
    """
    kind = result_class(ds)
    ds = _by_node(ds) if CONTAINER in ds else ds if kind is None else kind.tabular(ds, bool(variables))
    known = [str(name) for name in ds.data_vars]
    for name in variables:
        if name not in known:
            meant = or_meant(name, known, "\nhint: ")
            raise StoreError(f"no variable is called {name!r}, expected {listed(known)}{meant}")
    whole = {"node"} if CONTAINER in ds else {*ds.dims}
    usual = (name for name in known if ds[name].dtype.kind != "S" and {*ds[name].dims} <= whole)
    chosen = [*dict.fromkeys(variables or usual)]
    if not chosen:
        raise StoreError("nothing to write: the result holds no variables")
    rows = max((ds[name] for name in chosen), key=lambda array: (array.ndim, array.size))
    fitting = [name for name in chosen if {*ds[name].dims} <= {*rows.dims}]
    left_out = tuple(name for name in chosen if name not in fitting)
    if variables and left_out:
        over = [f"{name} is over {listed(map(str, ds[name].dims), 'and')}" for name in (str(rows.name), left_out[0])]
        hint = "hint: write a table for each"
        raise StoreError(f"these variables have no table in common: {', '.join(over)}\n{hint}")
    along = {dim: [name for name in ds.coords if ds[name].dims == (dim,)] for dim in rows.dims}
    numbered = [dim for dim, names in along.items() if dim not in names and (dim == "cell" or not names)]
    ds = ds.assign_coords({dim: np.arange(ds.sizes[dim]) for dim in numbered})
    beside = [name for name in ds.coords if ds[name].ndim > 1 and {*ds[name].dims} <= {*rows.dims}]
    names = [name for dim in rows.dims for name in (dim, *along[dim]) if name in ds.coords]
    columns = {str(name): ds[name] for name in (*names, *beside, *fitting)}
    return ResultTable({str(dim): size for dim, size in rows.sizes.items()}, columns, left_out)


def _by_node(ds: xr.Dataset) -> xr.Dataset:
    """Contours with what is known of lines at each of their nodes, and the number of the line."""
    number = np.repeat(np.arange(ds.sizes["line"]), ds["node_count"].values)
    nodes = ds.drop_vars("node_count").isel(line=xr.DataArray(number, dims="node"))
    return nodes.assign_coords(line=("node", number, {"long_name": "number of the line"}))


def write_table(ds: xr.Dataset, path: str | os.PathLike[str], variables: Sequence[str] = ()) -> ResultTable:
    """Write a result as CSV or Excel, by the suffix of the path, replacing the file only once the new one is whole.

    Returns the table, which knows what was left out. Raises StoreError.
    """
    target = Path(path)
    check_target(target, "table")
    table = table_of(ds, variables)
    is_workbook = target.suffix.lower() == ".xlsx"
    if is_workbook and table.rows > _ROWS_OF_SHEET:
        raise StoreError(
            f"{target}: {table.rows:,} rows, and a sheet of Excel holds {_ROWS_OF_SHEET:,}\n"
            "hint: write .csv, or a part of the result (stickslip export --select)"
        )
    with replaced(target) as temporary:
        if is_workbook:
            _write_excel(ds, table.frames(), temporary)
        else:
            _write_csv(table.frames(), temporary)
    return table


def _write_csv(frames: Iterator[pd.DataFrame], path: Path) -> None:
    with path.open("w", encoding="utf-8-sig", newline="") as file:  # without the mark Excel reads Windows-1252
        for number, frame in enumerate(frames):
            for name in frame.select_dtypes(exclude=["number", "bool"]):
                frame[name] = _each(lambda value: inert(str(value)), frame[name])
            frame.rename(columns=inert).to_csv(file, header=number == 0, index=False, lineterminator="\n",
                                               float_format=_NUMBER)  # fmt: skip


def _write_excel(ds: xr.Dataset, frames: Iterator[pd.DataFrame], path: Path) -> None:
    """The table in one sheet, and where it comes from in another."""
    import pandas as pd

    about = {name: visible(str(ds.attrs[name]))[:_LONGEST_CELL] for name in _ABOUT if name in ds.attrs}
    about |= {str(name): unit_of(c).text(c.item()) if c.dtype.kind in "fiu" else str(c.item())
              for name, c in ds.coords.items() if not c.ndim}  # fmt: skip
    with path.open("wb") as file, pd.ExcelWriter(file, engine="openpyxl") as writer:
        rows = pd.concat(frames, ignore_index=True)
        rows.to_excel(writer, sheet_name="data", index=False, freeze_panes=(1, 0), float_format=_NUMBER)
        pd.DataFrame(about.items(), columns=["what", "value"]).to_excel(writer, sheet_name="about", index=False)
        for sheet in writer.sheets.values():
            _write_texts_as_texts(sheet)


def _write_texts_as_texts(sheet: Any) -> None:
    """No cell of a sheet is a formula, or an error: openpyxl takes any text that begins with = for one."""
    for row in sheet.iter_rows():
        for cell in row:
            if isinstance(cell.value, str):
                cell.data_type = "s"
                if is_live(cell.value):
                    cell.quotePrefix = True  # stays a text where somebody edits it


# --- columns ----------------------------------------------------------------------------------------------------------


def _written(array: xr.DataArray, unit: Unit) -> Callable[[pd.Series], Any]:
    """What makes of the values of a column those that are written: flags and texts as words, numbers in their unit."""
    if "flag_meanings" in array.attrs:
        meaning = _meaning(array)
        return lambda values: _each(meaning, values)
    if array.dtype.kind in "OUT":
        return lambda values: _each(lambda text: visible(str(text)), values)
    if array.dtype.kind != "f" and not unit.name:
        return lambda values: values
    return lambda values: unit.of(values.to_numpy())


def _each(text_of: Callable[[Any], str], values: pd.Series) -> pd.Series:
    """A text for each value of a column, in which few differ."""
    return values.map({value: text_of(value) for value in values.unique()}, na_action="ignore")


def _meaning(flags: xr.DataArray) -> Callable[[Any], str]:
    """What tells the meaning of a flag, several at once joined by a plus; of a code without one, its number."""
    words = str(flags.attrs["flag_meanings"]).split()
    if "flag_masks" in flags.attrs:
        masks = dict(zip(words, np.atleast_1d(flags.attrs["flag_masks"]).tolist(), strict=True))
        return lambda code: " + ".join(word for word, mask in masks.items() if int(code) & mask)
    names = dict(zip(np.atleast_1d(flags.attrs["flag_values"]).tolist(), words, strict=True))
    if flags.name in _OF_BORDERS:
        names[0] = ""  # a line has fewer borders, or has some
    return lambda code: names.get(code, str(code))


def _unit(array: xr.DataArray) -> Unit:
    """The unit in which a column is shown: of times by the largest, which is read a chunk at a time."""
    if array.dtype.kind not in "fiu" or "flag_meanings" in array.attrs:
        return Unit()
    if array.attrs.get("units") != "s" or DISPLAY in array.attrs:
        return unit_of(array, np.zeros(1))
    parts = (array.isel(chunk).values for chunk in chunks(array))
    return unit_of(array, np.array([np.abs(part[np.isfinite(part)]).max(initial=0.0) for part in parts]))
