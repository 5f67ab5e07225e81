"""One cell of a result: its parameters, from the coordinates of the dataset and from what is asked."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
import xarray as xr

from stickslip.config.grid import quantity_of
from stickslip.dataset.select import places
from stickslip.errors import PlotError, QuantityError
from stickslip.vocabulary.cell_values import as_cells
from stickslip.vocabulary.cells import parameters_of
from stickslip.vocabulary.quantities import PARAMETERS, QUANTITIES
from stickslip.vocabulary.suggest import listed, nearest


def one_cell(ds: xr.Dataset, at: Mapping[str, Any]) -> dict[str, float]:
    """The parameters of a cell, complete and checked, in SI; `at` as for `StickslipAccessor.cell`.

    Raises ValueError.
    """
    placed = {name: value for name, value in at.items() if name in ds.dims and quantity_of(name) not in QUANTITIES}
    try:
        ds = ds.isel(places(ds, placed))
    except PlotError as error:
        raise ValueError(str(error)) from None
    found = {
        quantity_of(str(name)): values for name, values in ds.coords.items() if quantity_of(str(name)) in QUANTITIES
    }
    known = {name: float(values) for name, values in found.items() if values.ndim == 0 and _is_number(values)}
    known |= {name: _read(name, value, found) for name, value in at.items() if name not in placed}
    if missing := [name for name in found if name not in known]:
        dims = dict.fromkeys(str(found[name].dims[0]).removesuffix("_case") for name in missing)
        raise ValueError(f"which cell? give {listed(dims, 'and')}: a value, or a label or position where it has none")
    arrays = parameters_of({name: np.array([value]) for name, value in known.items()})
    cells = as_cells({name: arrays[name] for name in PARAMETERS if name in arrays})
    return {name: float(values[0]) for name, values in cells.items()}


def _read(name: str, value: Any, found: Mapping[str, Any]) -> float:
    """A value that was given for a quantity of the dataset."""
    if name not in QUANTITIES or name not in {*found, *PARAMETERS}:
        hint = f"; did you mean {near}?" if (near := nearest(name, found)) else ""
        raise ValueError(f"{name}: unknown here, expected {listed(found)}{hint}")
    row = QUANTITIES[name]
    try:
        return row.read(value.item() if isinstance(value, np.generic | np.ndarray | xr.DataArray) else value)
    except QuantityError as error:
        if row.may_be_absent and value != value:
            return float("nan")
        raise ValueError(f"{name}: got {value!r}, {error}") from None


def _is_number(values: xr.DataArray) -> bool:
    return bool(values.dtype.kind in "iuf")
