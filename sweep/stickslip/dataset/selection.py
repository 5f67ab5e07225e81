"""Parts of a dataset: dimensions fixed at a place, axes that rise, as many panels as fit, one cell.

The last two dimensions of a result are the axes of a picture, the others become panels.
"""

import math
from collections.abc import Hashable, Mapping, Sequence
from math import prod
from typing import Any

import numpy as np
import xarray as xr

from stickslip.config.grid import quantity_of, shared_by
from stickslip.dataset.display import MapAxis
from stickslip.errors import ConfigError, PlotError, QuantityError
from stickslip.vocabulary import units
from stickslip.vocabulary.cells import as_cells, parameters_of
from stickslip.vocabulary.models import MODELS, model_with
from stickslip.vocabulary.own_laws import is_law
from stickslip.vocabulary.quantities import PARAMETERS, QUANTITIES, listed, or_meant

MAX_PANELS = 16
_NO_PANELS = ("state",)  # one of it is drawn
_AS_SHOWN = 1e-5  # relative; the ends of an axis may be copied from a message, which has six digits


def selected(ds: xr.Dataset, select: Mapping[str, Any]) -> tuple[xr.Dataset, list[str]]:
    """The dataset, its axes rising, at points of some dimensions, which then are scalar coordinates; and what the
    points are, as in titles.

    select : see `places`.
    """
    ds = ascending(ds)
    at = places(ds, select)
    return ds.isel(at), [MapAxis(ds, dim).heading(i) for dim, i in at.items()]


def places(ds: xr.Dataset, select: Mapping[str, Any]) -> dict[Hashable, int]:
    """Positions along the dimensions to be fixed; the numeric axes of `ds` rise.

    select : by dimension, or by the quantity that varies along it: a value in SI or a text with a unit (the cell that
        holds it is taken), a label, or the position along a dimension that has neither. Raises PlotError.
    """
    positions: dict[Hashable, int] = {}
    for name, value in select.items():
        dim = _dimension(ds, name)
        if dim in positions:
            raise PlotError(f"cannot select {name!r} twice")
        positions[dim] = _position(ds, dim, value)
    return positions


def _dimension(ds: xr.Dataset, name: str) -> Hashable:
    """The dimension called `name`, or along which the quantity `name` varies by itself."""
    for dim in ds.dims:
        if name in (dim, quantity_of(str(dim)), str(dim).removesuffix("_case")):
            return dim
    raise _unknown(repr(name), name, "dimensions", [str(dim) for dim in ds.dims])


def _unknown(what: str, name: str, kind: str, known: Sequence[str]) -> PlotError:
    """The error of a dimension or label that there is not."""
    return PlotError(f"cannot select {what}; {kind} are {', '.join(known)}{or_meant(name, known)}")


def _position(ds: xr.Dataset, dim: Hashable, value: Any) -> int:
    """The position along `dim` of a value, label or position."""
    if dim not in ds.coords:
        number = _number(dim, value)
        if number not in range(ds.sizes[dim]):
            raise PlotError(f"cannot select {dim}={value}; positions are 0 to {ds.sizes[dim] - 1}")
        return int(number)
    if _is_numeric(ds, dim):
        return _cell_of(ds, dim, value)
    labels = [str(label) for label in ds[dim].values]
    if str(value) not in labels:
        raise _unknown(f"{dim}={value}", str(value), "labels", labels)
    return labels.index(str(value))


def _cell_of(ds: xr.Dataset, dim: Hashable, value: Any) -> int:
    """The cell of a numeric axis in which a value lies: the one that is nearest on the scale of the axis."""
    axis = MapAxis(ds, dim, plain=True)
    number, low, high = axis.unit.of(_number(dim, value)), axis.centres[0], axis.centres[-1]
    if not (low <= number <= high or any(math.isclose(number, end, rel_tol=_AS_SHOWN) for end in (low, high))):
        raise PlotError(f"cannot select {dim}={value}; the axis {_runs(axis)}")
    cell = int(np.searchsorted(axis.edges, number, side="right")) - 1
    return min(max(cell, 0), axis.length - 1)


def span(ds: xr.Dataset, dim: Hashable) -> tuple[float, float, str]:
    """The range that the cells of a numeric axis that rises cover, in SI, and its first and last point in words."""
    axis = MapAxis(ds, dim, plain=True)
    low, high = (float(axis.unit.to_si(end)) for end in (axis.edges[0], axis.edges[-1]))
    return low, high, _runs(axis)


def _runs(axis: MapAxis) -> str:
    last = axis.length - 1
    return f"is {axis.text(0)} only" if last == 0 else f"runs from {axis.text(0)} to {axis.text(last)}"


def within(ds: xr.Dataset, dim: Hashable, low: float, high: float) -> xr.Dataset:
    """The part of a dataset whose cells along a numeric axis that rises reach into a range in SI. Raises PlotError."""
    axis = MapAxis(ds, dim, plain=True)
    edges = axis.unit.to_si(axis.edges)
    inside = np.flatnonzero((edges[1:] > low) & (edges[:-1] < high))
    if not inside.size:
        raise PlotError(f"nothing of the map lies within the limits of {dim}; the axis {_runs(axis)}")
    return ds.isel({dim: slice(int(inside[0]), int(inside[-1]) + 1)})


def _number(dim: Hashable, value: Any) -> float:
    """A number, or a text with a unit, in SI."""
    declared = QUANTITIES.get(quantity_of(str(dim)))
    try:
        number = float(value)
    except (TypeError, ValueError):
        number = math.nan
        if declared is not None:
            try:
                number = units.si_value(value, declared.units)
            except QuantityError as error:
                raise PlotError(f"cannot select {dim}={value}; {error}") from None
    if not math.isfinite(number):
        raise PlotError(f"cannot select {dim}={value}; expected a finite number in SI units")
    return number


def ascending(ds: xr.Dataset) -> xr.Dataset:
    """Numeric axes sorted, so that cells do not overlap. What rises already is not touched, lazy data stay lazy."""
    for dim in ds.dims:
        if _is_numeric(ds, dim):
            steps = np.diff(ds[dim].values)
            if (steps < 0).all():
                ds = ds.isel({dim: slice(None, None, -1)})
            elif not (steps > 0).all():
                ds = ds.sortby(dim)
    return ds


def _is_numeric(ds: xr.Dataset, dim: Hashable) -> bool:
    """Tell a dimension whose points are numbers from names and places in a row."""
    return dim in ds.coords and ds[dim].dtype.kind in "fiu"


# --- panels -----------------------------------------------------------------------------------------------------------


def part_that_fits(ds: xr.Dataset, dims: Sequence[Hashable]) -> tuple[xr.Dataset, list[str]]:
    """The dataset at the middle of the longest dimensions that would be too many panels, which its title then says; and
    these points, as plain text.

    dims : of what is drawn.
    """
    outer = [dim for dim in dims if dim not in _NO_PANELS][:-2]
    longest, at = sorted(outer, key=lambda dim: -ds.sizes[dim]), dict[Hashable, int]()
    while prod(ds.sizes[dim] for dim in longest) > MAX_PANELS:
        at[longest[0]] = ds.sizes[longest.pop(0)] // 2
    if not at:
        return ds, []
    ds = ascending(ds)
    headings, points = ([MapAxis(ds, dim, plain).heading(i) for dim, i in at.items()] for plain in (False, True))
    title = f"{ds.attrs.get('title', '')}\n{', '.join(headings)}"
    return ds.isel(at).assign_attrs(title=title.strip()), points


# --- what is given ----------------------------------------------------------------------------------------------------


def check_dataset(ds: object) -> None:
    """Raise PlotError for anything but a dataset."""
    if not isinstance(ds, xr.Dataset):
        raise PlotError(f"got a value of type {type(ds).__name__}, expected a dataset, as run, evaluate, ... return")


# --- one cell ---------------------------------------------------------------------------------------------------------


def one_cell(ds: xr.Dataset, at: Mapping[str, Any]) -> dict[str, float]:
    """The parameters of a cell, complete and checked, in SI; `at` as for `StickslipAccessor.cell`.

    Raises ValueError.
    """
    placed = {name: value for name, value in at.items() if name in ds.dims and quantity_of(name) not in QUANTITIES}
    try:
        ds = ds.isel(places(ds, placed))
    except PlotError as error:
        raise ValueError(str(error)) from None
    named = {quantity_of(str(name)): values for name, values in ds.coords.items()}
    coords = {name: values for name, values in named.items() if name in QUANTITIES}
    known = {name: float(v) for name, v in coords.items() if v.ndim == 0 and v.dtype.kind in "iuf"}
    known |= {name: _read(name, value, coords) for name, value in at.items() if name not in placed}
    if missing := [name for name in coords if name not in known]:
        dims = dict.fromkeys(str(coords[name].dims[0]).removesuffix("_case") for name in missing)
        raise ValueError(f"which cell? give {listed(dims, 'and')}: a value, or a label or position where it has none")
    arrays = parameters_of({name: np.array([value]) for name, value in known.items()})
    try:
        law = str(shared_by(ds)["law"])
    except ConfigError:
        law = ""
    if not is_law(law):  # any law of the model, whose quantities are the same
        whole = any(all(name in arrays for name in model.needed) for model in MODELS)
        law = next(iter((model_with(arrays) if whole else MODELS[0]).laws))
    cells = as_cells({name: arrays[name] for name in PARAMETERS if name in arrays}, law)
    return {name: float(values[0]) for name, values in cells.items()}


def _read(name: str, value: Any, coords: Mapping[str, Any]) -> float:
    if name not in QUANTITIES or name not in {*coords, *PARAMETERS}:
        raise ValueError(f"{name}: unknown here, expected {listed(coords)}{or_meant(name, coords)}")
    row = QUANTITIES[name]
    try:
        return row.read(value.item() if isinstance(value, np.generic | np.ndarray | xr.DataArray) else value)
    except QuantityError as error:
        if row.may_be_absent and value != value:
            return float("nan")
        raise ValueError(f"{name}: got {value!r}, {error}") from None
