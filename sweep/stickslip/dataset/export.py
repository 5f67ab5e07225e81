"""Results as tables for other programs: CSV and Excel, one row a cell, a column for every coordinate and variable.

Numbers are in the units in which people see them, with six digits; headings carry these units (``belt_speed [mm/s]``),
flags are words, values that are not defined are empty, and no text is a formula. Rows are written a chunk at a time, so
that a file may be larger than memory; the table appears whole or not at all.
"""

from __future__ import annotations

import os
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from math import ceil, log10, prod
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from stickslip.config.studies import result_class
from stickslip.dataset.coarse import Chunk, chunks
from stickslip.dataset.display import unit_of
from stickslip.dataset.polylines import CONTAINER
from stickslip.errors import StoreError, visible
from stickslip.files.targets import check_target, replaced
from stickslip.files.texts import inert, is_live
from stickslip.vocabulary.display_units import DISPLAY, Unit
from stickslip.vocabulary.suggest import listed, or_meant

if TYPE_CHECKING:
    import pandas as pd

_ROWS_OF_SHEET = 2**20 - 1  # and the headings
_MOST_ROWS = 2**17  # put together at once
_LONGEST_CELL = 32_767  # characters of a cell of Excel
_DIGITS, _ALL_DIGITS = 6, 17  # of numbers; more where neighbours on an axis would be the same number
_OF_BORDERS = ("regime_below", "regime_above", "regime_throughout", "method")
Progress = Callable[[int, int], None]
_ABOUT = ("title", "source", "history", "date_created", "references", "configuration")


@dataclass(frozen=True)
class Table:
    """Columns of a result that become a table. dims, shape : of its rows, the last dimension running fastest.

    columns : coordinates first; none has other dimensions. left_out : variables that have, and are in no column.
    """

    dims: tuple[str, ...]
    shape: tuple[int, ...]
    columns: Mapping[str, xr.DataArray]
    left_out: tuple[str, ...] = ()

    @property
    def rows(self) -> int:
        """The number of rows, without the headings."""
        return prod(self.shape)

    @cached_property
    def units(self) -> dict[str, Unit]:
        """The unit in which each column is written."""
        return {name: _unit(array) for name, array in self.columns.items()}

    @property
    def headings(self) -> list[str]:
        """The names of the columns, with their units in brackets."""
        return [visible(f"{name} [{unit.name}]" if unit.name else name) for name, unit in self.units.items()]


def table_of(ds: xr.Dataset, variables: Sequence[str] = ()) -> Table:
    """The table of a result: all its variables that share the dimensions of the largest, or those that are named.

    Of contours a row is a node, with what is known of its line. Raises StoreError for variables there are not, or whose
    dimensions do not fit together.
    """
    kind = result_class(ds)
    ds = _by_node(ds) if CONTAINER in ds else ds if kind is None else kind.tabular(ds, bool(variables))
    chosen = _named(ds, variables) if variables else _usual(ds)
    if not chosen:
        raise StoreError("nothing to write: the result holds no variables")
    rows = max((ds[name] for name in chosen), key=lambda array: (array.ndim, array.size))
    dims = tuple(map(str, rows.dims))
    fitting = [name for name in chosen if set(ds[name].dims) <= set(dims)]
    left_out = tuple(name for name in chosen if name not in fitting)
    if variables and left_out:
        over = [f"{name} is over {listed(map(str, ds[name].dims), 'and')}" for name in (str(rows.name), left_out[0])]
        hint = "hint: write a table for each"
        raise StoreError(f"these variables have no table in common: {', '.join(over)}\n{hint}")
    columns = {name: array for name, array in _coordinates(ds, dims)}
    columns |= {name: ds[name] for name in fitting}
    return Table(dims, tuple(ds.sizes[dim] for dim in dims), columns, left_out)


def write_table(
    ds: xr.Dataset, path: str | os.PathLike[str], variables: Sequence[str] = (), *, progress: Progress | None = None,
) -> Table:  # fmt: skip
    """Write a result as CSV or Excel, by the suffix of the path, replacing the file only once the new one is whole.

    progress : called with (rows done, rows in all) from time to time. Returns the table, which knows what was left out.
    Raises StoreError.
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
            _write_excel(ds, table, temporary, progress)
        else:
            _write_csv(table, temporary, progress)
    return table


def _write_csv(table: Table, path: Path, progress: Progress | None) -> None:
    import pandas as pd

    with path.open("w", encoding="utf-8-sig", newline="") as file:  # without the mark Excel reads Windows-1252
        for number, frame in enumerate(_frames(table, progress)):
            for place in (i for i, kind in enumerate(frame.dtypes) if kind.kind not in "biuf"):
                codes, texts = pd.factorize(frame.iloc[:, place])
                frame.isetitem(place, np.array([*map(inert, map(str, texts)), ""], object)[codes])
            frame.columns = [inert(name) for name in frame.columns]
            frame.to_csv(file, header=number == 0, index=False, lineterminator="\n")


def _write_excel(ds: xr.Dataset, table: Table, path: Path, progress: Progress | None) -> None:
    """The table in one sheet, and where it comes from in another."""
    import pandas as pd

    about = [(name, visible(str(ds.attrs[name]))[:_LONGEST_CELL]) for name in _ABOUT if name in ds.attrs]
    about += [(str(name), unit_of(c).text(c.item()) if c.dtype.kind in "fiu" else str(c.item()))
              for name, c in ds.coords.items() if not c.ndim]  # fmt: skip
    whole = pd.concat(list(_frames(table, progress)), ignore_index=True)
    with path.open("wb") as file, pd.ExcelWriter(file, engine="openpyxl") as writer:
        whole.to_excel(writer, sheet_name="data", index=False, freeze_panes=(1, 0))
        pd.DataFrame(about, columns=["what", "value"]).to_excel(writer, sheet_name="about", index=False)
        widths = {"data": [min(max(len(str(name)) + 2, 10), 40) for name in whole.columns], "about": [30, 100]}
        for name, sheet in writer.sheets.items():
            for number, width in enumerate(widths.get(name, ()), 1):
                sheet.column_dimensions[sheet.cell(1, number).column_letter].width = width
            _write_texts_as_texts(sheet)


def _write_texts_as_texts(sheet: Any) -> None:
    """No cell of a sheet is a formula, or an error: openpyxl takes any text that begins with = for one."""
    for row in sheet.iter_rows():
        for cell in row:
            if isinstance(cell.value, str):
                cell.data_type = "s"
                if is_live(cell.value):
                    cell.quotePrefix = True  # stays a text where somebody edits it


# --- rows -------------------------------------------------------------------------------------------------------------


def _frames(table: Table, progress: Progress | None) -> Iterator[pd.DataFrame]:
    """The rows, a chunk of cells at a time, in the order of the cells."""
    import pandas as pd

    largest = max(table.columns.values(), key=lambda array: (array.ndim, array.size))
    done, digits = 0, {name: _digits(array) for name, array in table.columns.items()}
    whole: Chunk = {dim: slice(None) for dim in table.dims}
    for chunk in chunks(largest, _MOST_ROWS) if table.dims and table.rows else [whole]:
        columns = {}
        for (name, array), heading in zip(table.columns.items(), table.headings, strict=True):
            values = _column(array, table, chunk)
            is_number = values.dtype.kind == "f" or table.units[name].name
            columns[heading] = _rounded(table.units[name].of(values), digits[name]) if is_number else values
        frame = pd.DataFrame(columns)
        yield frame
        done += len(frame)
        if progress:
            progress(done, table.rows)


def _column(array: xr.DataArray, table: Table, chunk: Chunk) -> NDArray[Any]:
    """The values of a column in the rows of a chunk; flags as words."""
    part = array.isel({dim: chunk[dim] for dim in array.dims})
    values = part.values
    if values.dtype.kind in "OUT":
        values = np.array([visible(str(text)) for text in values.ravel()], object).reshape(values.shape)
    if "flag_meanings" in array.attrs:
        values = _words(values, array.attrs)
        if array.name in _OF_BORDERS:  # code 0 says that a line has fewer borders, or has some
            values = np.where(values == "not_computed", "", values)
    shape = [len(range(*chunk[dim].indices(length))) for dim, length in zip(table.dims, table.shape, strict=True)]
    spread = values.reshape([n if dim in array.dims else 1 for dim, n in zip(table.dims, shape, strict=True)])
    return np.broadcast_to(spread, shape).reshape(-1)


def _words(codes: NDArray[Any], attributes: Mapping[str, Any]) -> NDArray[Any]:
    """Flags by their meanings, several at once joined by a plus; a code without one as a number."""
    meanings = str(attributes["flag_meanings"]).split()
    if "flag_masks" in attributes:
        masks = dict(zip(np.atleast_1d(attributes["flag_masks"]).tolist(), meanings, strict=True))
        names = {code: " + ".join(word for mask, word in masks.items() if code & mask) for code in range(256)}
    else:
        names = dict(zip(np.atleast_1d(attributes["flag_values"]).tolist(), meanings, strict=True))
    present, place = np.unique(codes, return_inverse=True)
    words = np.array([names.get(code, str(code)) for code in present.tolist()], object)
    return np.asarray(words[place.reshape(-1)].reshape(codes.shape))


def _unit(array: xr.DataArray) -> Unit:
    """The unit in which a column is shown: of times by the largest, which is read a chunk at a time."""
    if array.dtype.kind not in "fiu" or "flag_meanings" in array.attrs:
        return Unit()
    largest = 0.0
    if array.attrs.get("units") == "s" and DISPLAY not in array.attrs:
        for chunk in chunks(array) if array.ndim else ({},):
            values = np.abs(array.isel(chunk).values)
            largest = max(largest, float(np.max(values, where=np.isfinite(values), initial=0.0)))
    return unit_of(array, np.array([largest]))


def _digits(array: xr.DataArray) -> int:
    """The number of digits of a column: six, more where neighbours on an axis lie closer."""
    if array.dims != (array.name,) or array.dtype.kind != "f" or array.size < 2:
        return _DIGITS
    step = float(np.min(np.abs(np.diff(array.values)), where=np.diff(array.values) != 0, initial=np.inf))
    most = float(np.max(np.abs(array.values)))
    return min(max(_DIGITS, ceil(log10(most / step)) + 3), _ALL_DIGITS) if 0 < step < np.inf else _DIGITS


def _rounded(values: NDArray[Any], digits: int) -> NDArray[np.float64]:
    """Numbers with so many significant digits, each the nearest double to that decimal number."""
    values = np.asarray(values, np.float64)
    with np.errstate(all="ignore"):
        places = digits - 1 - np.floor(np.log10(np.abs(values)))
        places = np.where(np.isfinite(places), np.clip(places, -300, 300), 0.0)
        up, down = 10.0 ** np.maximum(places, 0), 10.0 ** np.maximum(-places, 0)
        return np.where(np.isfinite(values), np.round(values * up / down) * down / up, values)


# --- columns ----------------------------------------------------------------------------------------------------------


def _coordinates(ds: xr.Dataset, dims: tuple[str, ...]) -> Iterator[tuple[str, xr.DataArray]]:
    """Columns that tell rows apart: for each dimension its index, or a number, and coordinates along it."""
    for dim in dims:
        beside = [str(name) for name in ds.coords if ds[name].dims == (dim,) and name != dim]
        if dim in ds.coords:
            yield dim, ds[dim]
        elif dim == "cell" or not beside:
            yield dim, xr.DataArray(np.arange(ds.sizes[dim]), dims=dim, name=dim)
        for name in beside:
            yield name, ds[name]
    for known, array in ds.coords.items():
        if array.ndim > 1 and set(array.dims) <= set(dims):
            yield str(known), array


def _named(ds: xr.Dataset, variables: Sequence[str]) -> list[str]:
    known = [str(name) for name in ds.data_vars]
    for name in variables:
        if name not in known:
            meant = or_meant(name, known, "\nhint: ")
            raise StoreError(f"no variable is called {name!r}, expected {listed(known)}{meant}")
    return list(dict.fromkeys(variables))


def _usual(ds: xr.Dataset) -> list[str]:
    """The variables that are written unless others are named."""
    names = [str(name) for name in ds.data_vars if ds[name].dtype.kind != "S"]
    if CONTAINER in ds:
        return [name for name in names if {*ds[name].dims} <= {"node"}]
    return names


def _by_node(ds: xr.Dataset) -> xr.Dataset:
    """Contours with what is known of lines at each of their nodes, and the number of the line."""
    times = ds["node_count"].values
    of_lines = {name: variable for name, variable in ds.variables.items() if variable.dims == ("line",)}
    repeated = {name: xr.Variable("node", np.repeat(v.values, times), v.attrs) for name, v in of_lines.items()}
    number = xr.Variable("node", np.repeat(np.arange(times.size), times), {"long_name": "number of the line"})
    coordinates = {name: variable for name, variable in repeated.items() if name in ds.coords}
    variables = {name: v for name, v in repeated.items() if name not in ds.coords and name != "node_count"}
    return ds.drop_dims("line").assign_coords({"line": number, **coordinates}).assign(variables)
