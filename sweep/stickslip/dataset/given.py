"""Cells that people give, with the dimensions and coordinates that a result over them has.

Plain numbers and arrays are a list of cells, over the dimension ``cell``. Arrays of xarray keep their dimensions: those
of different ones are broadcast by name, and their coordinates come with them.
"""

from __future__ import annotations

from collections.abc import Hashable, Mapping
from dataclasses import replace
from math import prod
from typing import Any

import numpy as np
import xarray as xr

from stickslip.dataset.build import cell_coordinates, parameter_variable
from stickslip.engine import Options
from stickslip.vocabulary import units
from stickslip.vocabulary.cell_values import as_cells, check_names, numbers_of
from stickslip.vocabulary.cells import Cells, Parameters
from stickslip.vocabulary.display_units import DISPLAY
from stickslip.vocabulary.quantities import PARAMETERS
from stickslip.vocabulary.results import VARIABLES
from stickslip.vocabulary.suggest import listed

Coordinates = dict[str, xr.Variable]
_ABOUT_AXES = ("axis_spacing", DISPLAY)  # attributes of an axis, which stay


def given_cells(given: Mapping[str, Any] | xr.Dataset, options: Options) -> Cells:
    """Cells as `evaluate` takes them. Raises TypeError and ValueError as `as_cells` does, and ValueError for arrays of
    xarray whose indices differ or whose units are not those of their parameter.
    """
    if hasattr(given, "columns") and hasattr(given, "to_xarray"):  # a table of pandas, whose index is the dimension
        check_names(given.columns)
        given = given.to_xarray()
    if isinstance(given, xr.Dataset):
        named = {str(name): given[name] for name in given.variables if name in PARAMETERS}
        return _labelled(named, dict(given.coords), options)
    if not any(type(value) is xr.DataArray for value in given.values()):
        _check_indices(given)
        cells = Cells.of(as_cells(given, options.law))
        return replace(cells, labelled=lambda: cell_coordinates(cells.listed, cells.size))
    beside: dict[Hashable, xr.DataArray] = {}
    for value in given.values():
        if isinstance(value, xr.DataArray):
            beside |= {name: c for name, c in value.coords.items() if name not in beside}
    return _labelled(dict(given), beside, options)


def _labelled(given: Mapping[str, Any], beside: Mapping[Hashable, xr.DataArray], options: Options) -> Cells:
    """Cells of arrays with names of dimensions; `beside` are all their coordinates."""
    arrays = {name: _in_si(name, value) for name, value in given.items() if isinstance(value, xr.DataArray)}
    plain = {name: value for name, value in given.items() if name not in arrays}
    if loose := [name for name, value in plain.items() if np.ndim(value)]:
        first = next(iter(arrays))
        raise TypeError(f"{listed(loose, 'and')}: got an array without dimensions beside {first}, which has them; "
                        "expected a number or a DataArray")  # fmt: skip
    try:
        same = xr.broadcast(*xr.align(*arrays.values(), join="exact"))
    except ValueError as error:
        raise ValueError(f"{listed(arrays, 'and')} do not fit together: {error}") from None
    dims, shape = tuple(map(str, same[0].dims)), same[0].shape
    _check_dims(dims, arrays)
    cells = as_cells({name: one.values for name, one in zip(arrays, same, strict=True)} | plain, options.law)
    if cells["mass"].size != prod(shape):  # there are none, or no dimensions
        cells = {name: np.broadcast_to(values, prod(shape)) for name, values in cells.items()}
    return Cells(dims, shape, listed=cells, labelled=lambda: _coordinates(cells, arrays, beside, dims))


def _coordinates(
    cells: Parameters,
    arrays: Mapping[str, xr.DataArray],
    beside: Mapping[Hashable, xr.DataArray],
    dims: tuple[str, ...],
) -> Coordinates:
    """Every parameter with the dimensions it was given with, and what else came with the arrays."""
    found = {}
    for name, values in cells.items():
        if (array := arrays.get(name)) is not None:
            found[name] = parameter_variable(name, tuple(map(str, array.dims)), array.values)
            found[name].attrs |= {key: array.attrs[key] for key in _ABOUT_AXES if key in array.attrs}
        elif values.size:
            found[name] = parameter_variable(name, (), values[0])
    for other, one in beside.items():
        if other not in found and set(one.dims) <= set(dims):
            found[str(other)] = one.variable.to_base_variable()
    return found


def _in_si(name: str, array: xr.DataArray) -> xr.DataArray:
    """The array in the units of its parameter; names of none are left to `as_cells`."""
    if name not in PARAMETERS:
        return array
    unit, row = units.said_by(array), PARAMETERS[name]
    if isinstance(array.data, np.ndarray) and array.dtype.kind in "iuf" and unit in (None, row.units):
        return array
    in_other = {} if unit in (None, row.units) else {DISPLAY: unit}
    return array.copy(data=numbers_of(row, array)).assign_attrs({"units": row.units, **in_other})


def _check_indices(given: Mapping[str, Any]) -> None:
    """Columns of pandas belong together by their index, which arrays have not."""
    columns = {name: value for name, value in given.items() if hasattr(value, "index") and hasattr(value, "array")}
    for name, column in columns.items():
        first = next(iter(columns))
        if not column.index.equals(columns[first].index):
            raise ValueError(f"{first} and {name}: got columns of pandas with different indices; align them first")


def _check_dims(dims: tuple[str, ...], arrays: Mapping[str, xr.DataArray]) -> None:
    """No dimension is called what something else in the result is called."""
    for dim in dims:
        if dim in VARIABLES or (dim in PARAMETERS and (dim not in arrays or arrays[dim].dims != (dim,))):
            what = "a result" if dim in VARIABLES else "a parameter whose values are others"
            raise ValueError(f"got a dimension called {dim}, which is the name of {what}; rename it")
