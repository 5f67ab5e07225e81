"""Borders in planes of two parameters as a labelled dataset: lines, in the manner of CF geometries (section 7.5).

`line` counts lines, `node` their nodes one line after the other. The container ``geometry`` says which variables hold
nodes and how many each line has; a closed line repeats its first node.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from math import prod
from typing import Any

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from stickslip.dataset.build import shown_in, variable_of
from stickslip.vocabulary.quantities import SEARCHABLE
from stickslip.vocabulary.results import CONTOUR_VARIABLES

Floats = NDArray[np.float64]
CONTAINER = "geometry"
_OF_LINES = ("node_count", "regime_left", "regime_right")


def contour_dataset(
    names: tuple[str, str],
    spacings: tuple[str, str],
    dims: Sequence[str],
    shape: Sequence[int],
    coordinates: Mapping[str, xr.Variable],
    table: Mapping[str, NDArray[Any]],
    attributes: Mapping[str, Any],
    shown: tuple[str | None, str | None] = (None, None),
) -> xr.Dataset:
    """The lines of all panels.

    names, spacings, shown : of the parameters, x and y; the units in which they are shown.
    dims, shape, coordinates : of the panels.
    table : `panel` and the columns of lines by names of `CONTOUR_VARIABLES`, each (lines,); `x`, `y`, `node_width` and
    `node_along` (0: on a side along x, 1: along y, 2: junction), each (nodes,).
    """
    variables = {CONTAINER: _container(names)}
    for name in _OF_LINES:
        variables[name] = variable_of(CONTOUR_VARIABLES[name], ("line",), table[name])
    for name in ("regime_left", "regime_right"):
        variables[name].attrs[CONTAINER] = CONTAINER
    variables["closed"] = _flag("closed", "line", table["closed"], ("open", "closed"))
    variables["node_width"] = variable_of(CONTOUR_VARIABLES["node_width"], ("node",), table["node_width"])
    variables["node_along"] = _flag("node_along", "node", table["node_along"], (*names, "junction"))
    ds = xr.Dataset(variables, attrs=dict(attributes))
    nodes = {name: shown_in(_nodes(name, table[column], axis, spacing), unit)
             for name, column, axis, spacing, unit in zip(names, "xy", "XY", spacings, shown, strict=True)}  # fmt: skip
    return ds.assign_coords(_of_panels(dims, shape, coordinates, table["panel"]) | nodes)


def _flag(name: str, dim: str, values: NDArray[Any], meanings: Sequence[str]) -> xr.Variable:
    """A flag whose meanings belong to this dataset."""
    row = CONTOUR_VARIABLES[name]
    attributes: dict[str, Any] = {"units": row.units, "long_name": row.long_name, "comment": row.comment}
    attributes |= {"flag_values": np.arange(len(meanings), dtype=np.int8), "flag_meanings": " ".join(meanings)}
    return xr.Variable(dim, values.astype(np.int8), attributes, {"_FillValue": None})


def _container(names: tuple[str, str]) -> xr.Variable:
    attributes = {"geometry_type": "line", "node_count": "node_count", "node_coordinates": " ".join(names)}
    return xr.Variable((), np.int8(0), attributes, {"_FillValue": None})


def _nodes(name: str, values: Floats, axis: str, spacing: str) -> xr.Variable:
    row = SEARCHABLE[name]
    attributes = {"units": row.units, "long_name": row.long_name, "axis": axis, "axis_spacing": spacing}
    return xr.Variable("node", values, attributes, {"_FillValue": None})


def _of_panels(
    dims: Sequence[str], shape: Sequence[int], coordinates: Mapping[str, xr.Variable], panel: NDArray[np.int64]
) -> dict[str, xr.Variable]:
    """What the panels are, by line; what is equal in all of them stays a single number."""
    found = {}
    for name, one in coordinates.items():
        if not one.dims or one.size == 1:
            found[name] = xr.Variable((), one.values.reshape(()), one.attrs, one.encoding)
            continue
        along = tuple(length if dim in one.dims else 1 for dim, length in zip(dims, shape, strict=True))
        ordered = one.transpose(*(dim for dim in dims if dim in one.dims)).values.reshape(along)
        whole = np.broadcast_to(ordered, tuple(shape))
        found[name] = xr.Variable("line", whole.ravel()[panel], one.attrs, one.encoding)
    if prod(shape) == 1:
        return found
    for dim, place in zip(dims, np.unravel_index(panel, tuple(shape)) if dims else (), strict=True):
        if dim not in found:
            words = {"units": "1", "long_name": f"position along {dim}"}
            found[dim] = xr.Variable("line", np.asarray(place, np.int32), words)
    return found


# --- lines out of a dataset -------------------------------------------------------------------------------------------


@dataclass(frozen=True, eq=False)
class Polyline:
    """One line: its nodes (n,), and the flags of the regimes to its left and right as x and y grow to right and up."""

    x: Floats
    y: Floats
    left: int
    right: int
    closed: bool


def is_contours(ds: xr.Dataset) -> bool:
    """Whether a dataset holds lines, as `contour_dataset` makes it."""
    return CONTAINER in ds.variables and "node_coordinates" in ds[CONTAINER].attrs


def plane_names(ds: xr.Dataset) -> tuple[str, str]:
    """The two parameters of the plane, x and y."""
    x, y = str(ds[CONTAINER].attrs["node_coordinates"]).split()
    return x, y


def polylines(ds: xr.Dataset, wanted: NDArray[np.bool_] | None = None) -> Iterator[Polyline]:
    """The lines of a dataset, or those of them that `wanted` (lines,) marks."""
    x, y = (ds[name].values for name in plane_names(ds))
    stops = np.cumsum(ds["node_count"].values)
    columns = [ds[name].values for name in ("node_count", "regime_left", "regime_right", "closed")]
    for i, (stop, count, left, right, closed) in enumerate(zip(stops, *columns, strict=True)):
        if wanted is None or wanted[i]:
            piece = slice(int(stop) - int(count), int(stop))
            yield Polyline(x[piece], y[piece], int(left), int(right), bool(closed))
