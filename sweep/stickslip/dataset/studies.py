"""Results of studies as labelled datasets: borders, contours, margins, attractors, ramps, probabilities.

Every variable comes from its declaration in `vocabulary/results.py`. The first dimensions are those of the cells, lines
or panels; what a result has beyond these is named here (``crossing``, ``side``, ``state``, ...).

Contours are lines in the manner of CF geometries (section 7.5): `line` counts lines, `node` their nodes one line after
the other. The container ``geometry`` says which variables hold nodes and how many each line has; a closed line repeats
its first node.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from math import prod
from typing import TYPE_CHECKING, Any

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from stickslip.dataset.build import NO_FILL, attributes_of, grid_coordinates, shown_in, variable_of
from stickslip.vocabulary.flags import REGIME_MESSAGES, REGIMES
from stickslip.vocabulary.parameter import Variable
from stickslip.vocabulary.quantities import PARAMETERS, SEARCHABLE
from stickslip.vocabulary.results import (
    ATTRACTOR_VARIABLES,
    BETWEEN_VARIABLES,
    BORDER_VARIABLES,
    CONTOUR_VARIABLES,
    MARGIN_VARIABLES,
    RAMP_VARIABLES,
    STATISTICS,
    UNCERTAIN_VARIABLES,
    VARIABLES,
)

if TYPE_CHECKING:
    from stickslip.vocabulary.cells import Cells

Coordinates = Mapping[str, xr.Variable]
Arrays = Mapping[str, NDArray[Any]]
CONTAINER = "geometry"  # variable of contours
SIDES = ("below", "above")
ON_SIDES = {"border": False, "border_width": False, "beyond": True, "proposed": False, "checked": True}  # flags: True
_PER_CELL = ("undecided", "levels", "evaluations")  # probabilities; others are per state


def _over(
    dims: Sequence[str], shape: Sequence[int], declared: Variable, values: NDArray[Any], more: Sequence[str] = ()
) -> xr.Variable:
    """A variable over cells, of values (cells, ...) whose further dimensions are called `more`."""
    return variable_of(declared, (*dims, *more[: values.ndim - 1]), values.reshape((*shape, *values.shape[1:])))


def _text_index(dim: str, texts: Sequence[str], long_name: str) -> xr.Variable:
    return xr.Variable(dim, np.asarray(texts, str), {"long_name": long_name})


def border_dataset(
    along: str, dims: Sequence[str], shape: Sequence[int], coordinates: Coordinates, results: Arrays,
    attributes: Mapping[str, Any], unit: str | None = None,
) -> xr.Dataset:  # fmt: skip
    """The borders along a parameter.

    dims, shape, coordinates : of the lines. results : by names of `BORDER_VARIABLES`, each (lines,) or (lines, n);
    the latter get the dimension ``crossing``. unit : in which the parameter is shown.
    """
    variables = {}
    for name, declared in BORDER_VARIABLES.items():
        if is_place := name in ("border", "border_width"):
            declared = _of_parameter(declared, along)
        variable = _over(dims, shape, declared, results[name], ("crossing",))
        variables[name] = shown_in(variable, unit if is_place else None)
    return xr.Dataset(variables, dict(coordinates), dict(attributes))


def margin_dataset(
    parameters: Sequence[str], dims: Sequence[str], shape: Sequence[int], coordinates: Coordinates, table: Arrays,
    attributes: Mapping[str, Any],
) -> xr.Dataset:  # fmt: skip
    """The margins of cells.

    dims, shape, coordinates : of the cells. table : `regime`, and by names of `MARGIN_VARIABLES` followed by that of a
    parameter, what was found, each (cells,); those of `ON_SIDES` followed by a side as well, which becomes a dimension.
    """
    rows = {name: replace(row, name="regime", units="1") if row.units == "flag" else row
            for name, row in MARGIN_VARIABLES.items()}  # fmt: skip
    declared = {"regime": VARIABLES["regime"]} | rows
    declared |= {f"{name}_{p}": _of_parameter(row, p) for name, row in rows.items() for p in parameters}
    both = {f"{kind}_{p}": np.stack([table[f"{kind}_{p}_{side}"] for side in SIDES], axis=-1)
            for p in parameters for kind in ON_SIDES}  # fmt: skip
    single = {name: values for name, values in table.items() if name in declared and name not in both}
    variables = {
        name: _over(dims, shape, declared[name], values, ("side",)) for name, values in (single | both).items()
    }
    side = _text_index("side", SIDES, "side of the value on which the border lies")
    return xr.Dataset(variables, dict(coordinates) | {"side": side}, dict(attributes))


def _of_parameter(row: Variable, parameter: str) -> Variable:
    """A row for one parameter: in its unit where the row has none of its own, and with its long name."""
    about = SEARCHABLE[parameter]
    has_own = row.name not in ("border", "border_width") and row.units != "parameter"
    units = row.units if has_own else about.units
    return replace(row, units=units, long_name=f"{row.long_name}: {about.long_name}")


def attractor_dataset(
    dims: Sequence[str], shape: Sequence[int], coordinates: Coordinates, results: Arrays, attributes: Mapping[str, Any]
) -> xr.Dataset:
    """The attractors of cells.

    dims, shape, coordinates : of the cells. results : by names of `ATTRACTOR_VARIABLES`, flat.
    """
    variables = {name: _over(dims, shape, row, results[name]) for name, row in ATTRACTOR_VARIABLES.items()}
    coexisting, names = variables["coexisting"], REGIMES[1:]  # a bit each; the code of a regime counts them from 1
    masks = coexisting.attrs | {
        "flag_masks": (2 ** np.arange(len(names))).astype(np.int8),
        "flag_meanings": " ".join(names),
        "comment": "; ".join(f"{name}: {REGIME_MESSAGES[name]}" for name in names),
    }
    variables["coexisting"] = xr.Variable(coexisting.dims, coexisting.values.astype(np.int8), masks, NO_FILL)
    return xr.Dataset(variables, dict(coordinates), dict(attributes))


def ramp_dataset(
    along: str, values: NDArray[np.float64], dims: Sequence[str], coordinates: Coordinates, results: Arrays,
    between: Arrays, attributes: Mapping[str, Any], unit: str | None = None,
) -> xr.Dataset:  # fmt: skip
    """Attractors along a parameter that goes up and down again.

    dims, coordinates : of the lines. unit : in which the parameter is shown.
    results : by names of `RAMP_VARIABLES`, and `vibration_end`, of the shape (*lines, direction, values).
    between : by names of `BETWEEN_VARIABLES`, of the shape (*lines, values).
    """
    row, shape = PARAMETERS[along], (*dims, "direction", along)
    axis = {"units": row.units, "long_name": row.long_name, "axis_spacing": "linear"}
    own = {
        along: shown_in(xr.Variable((along,), values, axis, NO_FILL), unit),
        "direction": _text_index("direction", ("up", "down"), "direction of the ramp"),
    }
    variables = {name: variable_of(declared, shape, results[name]) for name, declared in RAMP_VARIABLES.items()}
    ends = {"units": row.units, "long_name": "where vibration ends, between this value and the next of the ramp"}
    variables["vibration_end"] = shown_in(xr.Variable(shape, results["vibration_end"], ends), unit)
    for name, declared in BETWEEN_VARIABLES.items():
        variables[name] = variable_of(declared, (*dims, along), between[name])
    return xr.Dataset(variables, dict(coordinates) | own, dict(attributes))


def uncertain_dataset(
    grid: Cells, states: Sequence[str], quantities: Sequence[str], quantiles: Sequence[float], results: Arrays,
    attributes: Mapping[str, Any],
) -> xr.Dataset:  # fmt: skip
    """Probabilities of regimes, the spread of metrics and Sobol indices.

    results : by names of `UNCERTAIN_VARIABLES`, and of metrics (``mean_period``, ``quantile_period_error``, ...); the
    first dimension is that of the cells, further ones are ``state``, ``quantity`` or ``quantile``.
    """
    variables = {}
    for name, values in results.items():
        more = ("state", "quantity") if name in UNCERTAIN_VARIABLES else ("quantile",)
        variables[name] = _over(grid.dims, grid.shape, _declared(name), values, more)
    coordinates = grid_coordinates(grid) | {"state": _text_index("state", states, "regime")}
    used = {dim for variable in variables.values() for dim in variable.dims}
    if "quantity" in used:
        coordinates["quantity"] = _text_index("quantity", quantities, "uncertain quantity")
    if "quantile" in used:
        about = {"units": "1", "long_name": "share of the draws below the quantile"}
        coordinates["quantile"] = xr.Variable("quantile", np.asarray(quantiles, np.float64), about, NO_FILL)
    return xr.Dataset(variables, coordinates, dict(attributes))


def _declared(name: str) -> Variable:
    """The declaration of a result of draws; that of a statistic is made of the metric's."""
    if name in UNCERTAIN_VARIABLES:
        return UNCERTAIN_VARIABLES[name]
    statistic, _, metric = name.removesuffix("_error").partition("_")
    kind = f"{statistic}_error" if name.endswith("_error") else statistic
    units, comment = ("1", "") if statistic == "count" else (VARIABLES[metric].units, "among the draws that have it")
    return Variable(name, units, f"{STATISTICS[kind]}: {VARIABLES[metric].long_name}", comment=comment)


# --- contours ---------------------------------------------------------------------------------------------------------


def contour_dataset(
    names: tuple[str, str], spacings: tuple[str, str], dims: Sequence[str], shape: Sequence[int],
    coordinates: Coordinates, table: Arrays, attributes: Mapping[str, Any],
    shown: tuple[str | None, str | None] = (None, None),
) -> xr.Dataset:  # fmt: skip
    """The lines of all panels.

    names, spacings, shown : of the parameters, x and y; the units in which they are shown.
    dims, shape, coordinates : of the panels.
    table : `panel` and the columns of lines by names of `CONTOUR_VARIABLES`, each (lines,); `x`, `y`, `node_width` and
    `node_along` (0: on a side along x, 1: along y, 2: junction), each (nodes,).
    """
    geometry = {"geometry_type": "line", "node_count": "node_count", "node_coordinates": " ".join(names)}
    variables = {CONTAINER: xr.Variable((), np.int8(0), geometry, NO_FILL)}
    meanings = {"closed": ("open", "closed"), "node_along": (*names, "junction")}  # flags of this dataset alone
    for name in ("node_count", "regime_left", "regime_right", "closed", "node_width", "node_along"):
        dim, row = "node" if name in ("node_width", "node_along") else "line", CONTOUR_VARIABLES[name]
        if name in meanings:
            flags = attributes_of(row, meanings[name])
            variables[name] = xr.Variable(dim, table[name].astype(np.int8), flags, NO_FILL)
        else:
            variables[name] = variable_of(row, (dim,), table[name])
    for name in ("regime_left", "regime_right"):
        variables[name].attrs[CONTAINER] = CONTAINER
    nodes = {}
    for name, axis, spacing, unit in zip(names, "xy", spacings, shown, strict=True):
        about = {"units": SEARCHABLE[name].units, "long_name": SEARCHABLE[name].long_name}
        about |= {"axis": axis.upper(), "axis_spacing": spacing}
        nodes[name] = shown_in(xr.Variable("node", table[axis], about, NO_FILL), unit)
    panels = _panels(dims, shape, coordinates, table["panel"])
    return xr.Dataset(variables, attrs=dict(attributes)).assign_coords(panels | nodes)


def _panels(
    dims: Sequence[str], shape: Sequence[int], coordinates: Coordinates, panel: NDArray[np.int64]
) -> dict[str, xr.Variable]:
    """The coordinates of the panels, by line; those that are equal in all of them stay single numbers."""
    by_line = {}
    for name, variable in coordinates.items():
        if not variable.dims or variable.size == 1:
            by_line[name] = xr.Variable((), variable.values.reshape(()), variable.attrs, variable.encoding)
            continue
        own = tuple(length if dim in variable.dims else 1 for dim, length in zip(dims, shape, strict=True))
        ordered = variable.transpose(*(dim for dim in dims if dim in variable.dims)).values.reshape(own)
        values = np.broadcast_to(ordered, tuple(shape)).ravel()[panel]
        by_line[name] = xr.Variable("line", values, variable.attrs, variable.encoding)
    if prod(shape) > 1:
        for dim, place in zip(dims, np.unravel_index(panel, tuple(shape)) if dims else (), strict=True):
            about = {"units": "1", "long_name": f"position along {dim}"}
            by_line.setdefault(dim, xr.Variable("line", np.asarray(place, np.int32), about))
    return by_line
