"""Cells that people give, and their results as labelled datasets.

Plain numbers and arrays are a list of cells, over the dimension ``cell``. Arrays of xarray keep their dimensions: those
of different ones are broadcast by name, and their coordinates come with them.

Four shapes of result: a map over a grid, cells one by one, one trajectory, and what a study says of cells. Every
variable and coordinate gets its units and long name from the vocabulary; flags become int8 with their meanings beside
them, so that the dataset is self-describing. `provenance` gives the global attributes.

The conventions are CF. They shape two things here: neither flags nor coordinates have a `_FillValue` (on flags it would
also make xarray read floats), and attributes are text, numbers or arrays of one type.
"""

import os
import platform
import subprocess
from collections.abc import Hashable, Mapping, Sequence
from contextlib import suppress
from dataclasses import replace
from functools import cache
from importlib.metadata import PackageNotFoundError, version
from math import prod
from pathlib import Path
from time import gmtime, strftime
from typing import Any

import numpy as np
import xarray as xr
from numpy.typing import ArrayLike, NDArray

from stickslip._version import __version__
from stickslip.config.grid import quantity_of
from stickslip.engine import Options
from stickslip.vocabulary import units
from stickslip.vocabulary.cells import Cells, Coordinate, Parameters, as_cells, check_names, numbers_of
from stickslip.vocabulary.display_units import DISPLAY
from stickslip.vocabulary.parameter import Variable
from stickslip.vocabulary.quantities import (
    FLAGS,
    MAP_VARIABLES,
    PARAMETERS,
    QUANTITIES,
    SEARCHABLE,
    TRACE_VARIABLES,
    VARIABLES,
    listed,
)

CONVENTIONS = "CF-1.11"  # a test holds the compliance checker to it
REFERENCES = (
    "Controlling Stick-Slip Noise Generation with Lubricants, Sound & Vibration, June 2016: equation of motion, "
    "Eq. (1); Stribeck curve, Eq. (2); hysteretic curve, Eq. (2a); stick-slip tendency, Eq. (3)"
)
INCOMPLETE = "incomplete"  # attribute of a result that lacks blocks, unless its cells say so themselves
_REPORTED_PACKAGES = ("numba", "llvmlite", "numpy", "xarray", "netCDF4")

NO_FILL = {"_FillValue": None}
_OF_AXES = ("axis_spacing", DISPLAY)  # attributes of an axis that is given, which stay
_COUNTS = ("steps", "scan_undecided", "node_count", "rank", "points", "fit_good")
# whole numbers defined in every cell; other counts are NaN where nothing was counted


# --- cells ------------------------------------------------------------------------------------------------------------


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
    cells = as_cells({name: array.values for name, array in zip(arrays, same, strict=True)} | plain, options.law)
    if cells["mass"].size != prod(shape):  # there are none, or no dimensions
        cells = {name: np.broadcast_to(values, prod(shape)) for name, values in cells.items()}
    return Cells(dims, shape, listed=cells, labelled=lambda: _coordinates(cells, arrays, beside, dims))


def _coordinates(
    cells: Parameters, arrays: Mapping[str, xr.DataArray], beside: Mapping[Hashable, xr.DataArray],
    dims: tuple[str, ...],
) -> dict[str, xr.Variable]:  # fmt: skip
    """Every parameter with the dimensions it was given with, and what else came with the arrays."""
    coordinates = {}
    for name, values in cells.items():
        if (array := arrays.get(name)) is not None:
            coordinates[name] = parameter_variable(name, tuple(map(str, array.dims)), array.values)
            coordinates[name].attrs |= {key: array.attrs[key] for key in _OF_AXES if key in array.attrs}
        elif values.size:
            coordinates[name] = parameter_variable(name, (), values[0])
    for other, array in beside.items():
        if other not in coordinates and set(array.dims) <= set(dims):
            coordinates[str(other)] = array.variable.to_base_variable()
    return coordinates


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


# --- datasets ---------------------------------------------------------------------------------------------------------


def map_dataset(grid: Cells, results: Mapping[str, ArrayLike], attributes: Mapping[str, Any]) -> xr.Dataset:
    """The map over a grid.

    results : by names of `MAP_VARIABLES`, each of length grid.size with the last dimension running fastest.
    Axes become coordinates, and so do the parameters that are equal in every cell (scalar coordinates). Axes that vary
    together share a dimension; if they have labels, the labels are its index.
    """
    variables = {
        variable.name: variable_of(variable, grid.dims, np.asarray(results[variable.name]).reshape(grid.shape))
        for variable in _declared(results, MAP_VARIABLES)
    }
    return xr.Dataset(variables, grid_coordinates(grid), dict(attributes))


def map_template(grid: Cells, columns: Mapping[str, np.dtype[Any]], attributes: Mapping[str, Any]) -> xr.Dataset:
    """The dataset `map_dataset` would make, with one value in place of all: they are to be written piece by piece.

    columns : names of `MAP_VARIABLES` and their types.
    """
    zeros = {name: np.broadcast_to(np.zeros((), dtype), grid.size) for name, dtype in columns.items()}
    return map_dataset(grid, zeros, attributes)


def evaluated_dataset(
    dims: tuple[str, ...], shape: tuple[int, ...], coordinates: dict[str, xr.Variable],
    results: Mapping[str, NDArray[Any]], attributes: Mapping[str, Any],
) -> xr.Dataset:  # fmt: skip
    """Cells evaluated one by one, over any dimensions.

    dims, shape, coordinates : of the cells.
    results : by names of `VARIABLES`, each flat, of the types that `engine.columns` says.
    """
    variables = {v.name: variable_of(v, dims, results[v.name].reshape(shape)) for v in _declared(results, VARIABLES)}
    return xr.Dataset(variables, coordinates, dict(attributes))


def trace_dataset(
    time: ArrayLike, samples: Mapping[str, ArrayLike], cell: Mapping[str, float], attributes: Mapping[str, Any]
) -> xr.Dataset:
    """One trajectory over the dimension ``time`` (s since the start).

    samples : by names of `TRACE_VARIABLES`, each as long as `time`.
    cell : the parameters, which become scalar coordinates; `displacement` and `velocity`, the state at the start, as
    ``displacement_start`` and ``velocity_start``, because the trajectory itself owns the plain names.
    CF wants a date in a coordinate called time; ours counts from the start, so a trajectory does not claim CF.
    """
    since = {"units": "s", "long_name": "time since the start"}
    coordinates = {"time": xr.Variable("time", np.asarray(time, np.float64), since, NO_FILL)}
    for name, value in cell.items():
        coordinates[f"{name}_start" if name in TRACE_VARIABLES else name] = parameter_variable(name, (), value)
    variables = {
        v.name: variable_of(v, ("time",), np.asarray(samples[v.name])) for v in _declared(samples, TRACE_VARIABLES)
    }
    return xr.Dataset(variables, coordinates, {k: value for k, value in attributes.items() if k != "Conventions"})


def study_dataset(
    key: str, rows: Mapping[str, Variable], values: Mapping[str, NDArray[Any]], dims: Sequence[str],
    shape: Sequence[int], coordinates: Mapping[str, xr.Variable], attributes: Mapping[str, Any],
) -> xr.Dataset:  # fmt: skip
    """The result of a study, whose key becomes the attribute `result`.

    rows : the declarations of its variables, whose own dimensions follow those of the cells. values : by the names of
    some of them, each flat over the cells, with further dimensions as declared. dims, shape, coordinates : of the
    cells, and whatever coordinates its own dimensions have.
    """
    variables = {
        name: variable_of(rows[name], (*dims, *rows[name].dims), array.reshape((*shape, *array.shape[1:])))
        for name, array in values.items()
    }
    return xr.Dataset(variables, dict(coordinates), {**attributes, "result": key})


def of_parameter(row: Variable, parameter: str) -> Variable:
    """A row for one parameter, with its long name, and with its unit where that is what the row says."""
    about = SEARCHABLE[parameter]
    units = about.units if row.units == "parameter" else row.units
    return replace(row, units=units, long_name=f"{row.long_name}: {about.long_name}")


def text_index(dim: str, texts: Sequence[str], long_name: str) -> xr.Variable:
    """The index of a dimension whose points have names."""
    return xr.Variable(dim, np.asarray(texts, str), {"long_name": long_name})


def _declared(results: Mapping[str, Any], table: Mapping[str, Variable]) -> list[Variable]:
    """The declarations of `results`, in the order of `table`. A name without declaration is a bug."""
    if unknown := set(results) - set(table):
        raise KeyError(f"not declared in vocabulary/quantities.py: {', '.join(sorted(unknown))}")
    return [variable for name, variable in table.items() if name in results]


# --- coordinates ------------------------------------------------------------------------------------------------------


def grid_coordinates(grid: Cells) -> dict[str, xr.Variable]:
    """Coordinates: axes, labels of points, and what is equal in every cell."""
    if grid.labelled is not None:
        return grid.labelled()
    coordinates = {c.name: shown_in(axis_variable(c), grid.written_in.get(quantity_of(c.name))) for c in grid.coords}
    for c in grid.coords:
        if c.labels is not None and c.dim not in coordinates:  # values of one quantity, or points of a group
            names = [other.long_name for other in grid.coords if other.dim == c.dim]
            long_name = names[0] if len(names) == 1 else c.dim.replace("_", " ")
            coordinates[c.dim] = xr.Variable((c.dim,), np.asarray(c.labels, str), {"long_name": long_name})
    for name, value in grid.fixed.items():
        coordinates[name] = shown_in(parameter_variable(name, (), value), grid.written_in.get(name))
    return coordinates


def cell_coordinates(cells: Mapping[str, ArrayLike], size: int) -> dict[str, xr.Variable]:
    """The parameters of a list of cells, each a number or of length `size`; arrays that are whole are not copied."""
    coordinates = {}
    for name, given in cells.items():
        values = np.asarray(given, np.float64)
        if values.shape != (size,) or not values.flags.writeable:
            values = np.array(np.broadcast_to(values, size))
        coordinates[name] = xr.Variable("cell", values, _attributes_of_parameter(name), NO_FILL)
    return coordinates


def axis_variable(c: Coordinate) -> xr.Variable:
    """A coordinate of a grid; `axis_spacing` tells a plot how the values were laid out."""
    attributes = {"units": c.units, "long_name": c.long_name, "axis_spacing": c.spacing} | _comment(c.name)
    return xr.Variable((c.dim,), np.asarray(c.values, np.float64), attributes, NO_FILL)


def parameter_variable(name: str, dims: Sequence[Hashable], values: ArrayLike) -> xr.Variable:
    """A coordinate that holds a parameter."""
    return xr.Variable(dims, np.array(values, np.float64), _attributes_of_parameter(name), NO_FILL)


@cache
def _attributes_of_parameter(name: str) -> dict[str, Any]:
    declared = QUANTITIES[name]
    return {"units": declared.units, "long_name": declared.long_name} | _comment(name)


def _comment(name: str) -> dict[str, str]:
    """The meaning of NaN, where it has one."""
    declared = PARAMETERS.get(name)
    return {"comment": f"NaN: {declared.absent}"} if declared and declared.absent else {}


def shown_in(variable: xr.Variable, unit: str | None) -> xr.Variable:
    """The variable, which is in SI, with the unit in which it is shown (`display.py`), if there is one."""
    if unit is not None:
        variable.attrs[DISPLAY] = unit
    return variable


# --- variables --------------------------------------------------------------------------------------------------------


def variable_of(declared: Variable, dims: Sequence[Hashable], values: NDArray[Any]) -> xr.Variable:
    """A data variable of its final type: int8 flags, int32 counts (NaN: 0), float64 the rest."""
    attributes = dict(attributes_of(declared))
    if declared.name not in FLAGS and declared.name not in _COUNTS:
        return xr.Variable(dims, np.asarray(values, np.float64), attributes)
    kind = np.int8 if declared.name in FLAGS else np.int32
    whole = values if values.dtype == kind else np.nan_to_num(values).astype(kind)
    return xr.Variable(dims, whole, attributes, NO_FILL)


@cache
def attributes_of(declared: Variable, meanings: tuple[str, ...] = ()) -> dict[str, Any]:
    """Units, long name and comment of a variable; of a flag its meanings. meanings : of a flag of one dataset alone."""
    attributes: dict[str, Any] = {"units": declared.units, "long_name": declared.long_name}
    if declared.comment:
        attributes["comment"] = declared.comment
    messages = FLAGS.get(declared.name, {})
    if names := meanings or tuple(messages):
        attributes["flag_values"] = np.arange(len(names), dtype=np.int8)
        attributes["flag_values"].flags.writeable = False  # all datasets have it in common
        attributes["flag_meanings"] = " ".join(names)
    if messages:
        attributes["comment"] = "; ".join(f"{name}: {message}" for name, message in messages.items())
    return attributes


# --- the global attributes: what made the numbers, from what, when ----------------------------------------------------


def provenance(configuration: str, *, title: str, action: str = "computed") -> dict[str, str]:
    """The global attributes of a dataset.

    configuration : the resolved configuration as text, everything needed to compute the dataset again.
    action : what was done, for the history line (a command, say).
    """
    now, revision = strftime("%Y-%m-%dT%H:%M:%SZ", gmtime()), git_revision()
    return {
        "Conventions": CONVENTIONS,
        "title": title,
        "source": f"stickslip {__version__}" + (f", git {revision}" if revision else ""),
        "history": f"{now} stickslip {__version__}: {action}",
        "references": REFERENCES,
        "date_created": now,
        "software": software(),
        "configuration": configuration,
    }


def git_revision() -> str | None:
    """Commit of the checkout this file is in, "-dirty" appended if tracked files differ; None outside a checkout."""
    return _revision(__file__)


@cache  # a process runs the files it has loaded, whatever becomes of them
def _revision(file: str) -> str | None:
    root = Path(file).resolve().parents[3]
    if not (root / ".git").exists():  # an installed package: do not report the repository of whoever uses it
        return None
    environment = {name: value for name, value in os.environ.items() if not name.startswith("GIT_")}
    command = ["git", "-C", str(root), "describe", "--always", "--dirty", "--abbrev=40", "--exclude=*"]
    try:
        done = subprocess.run(command, capture_output=True, text=True, timeout=10, check=True, env=environment)
    except (OSError, subprocess.SubprocessError):
        return None
    return done.stdout.strip() or None


@cache  # read from the files of the packages, a millisecond
def software() -> str:
    """Versions of what the numbers depend on, and the kind of machine."""
    versions = [f"Python {platform.python_version()}"]
    for package in _REPORTED_PACKAGES:
        with suppress(PackageNotFoundError):
            versions.append(f"{package} {version(package)}")
    return ", ".join([*versions, f"{platform.system()} {platform.machine()}"])
