"""Which part of a dataset is drawn: dimensions fixed at a place, axes that rise."""

from __future__ import annotations

import math
from collections.abc import Hashable, Mapping
from typing import Any

import numpy as np
import xarray as xr

from stickslip.config.grid import quantity_of
from stickslip.config.unit_warnings import misread
from stickslip.dataset.axis import MapAxis
from stickslip.errors import PlotError, QuantityError
from stickslip.vocabulary import units
from stickslip.vocabulary.quantities import QUANTITIES
from stickslip.vocabulary.suggest import suggest

_AS_SHOWN = 1e-5  # relative; the ends of an axis may be copied from a message, which has six digits


def selected(ds: xr.Dataset, select: Mapping[str, Any]) -> tuple[xr.Dataset, list[str]]:
    """The dataset, its axes rising, at points of some dimensions, which then are scalar coordinates; and what the
    points are, as in titles.

    select : see `places`.
    """
    ds = ascending(ds)
    at = places(ds, select)
    return ds.isel(at), [MapAxis(ds, dim).heading(i) for dim, i in at.items()]


def told(ds: xr.Dataset, select: Mapping[str, Any]) -> list[str]:
    """The points that `selected` takes, as plain text, and what was asked where that is another value."""
    ds = ascending(ds)
    taken = []
    for (dim, i), wanted in zip(places(ds, select).items(), select.values(), strict=True):
        near = _is_numeric(ds, dim) and not math.isclose(_number(dim, wanted), ds[dim][i])
        taken.append(MapAxis(ds, dim, plain=True).heading(i) + f" (the point nearest to {wanted})" * near)
    return taken


def places(ds: xr.Dataset, select: Mapping[str, Any]) -> dict[Hashable, int]:
    """Positions along the dimensions to be fixed; the numeric axes of `ds` rise.

    select : by dimension, or by the quantity that varies along it: a value in SI or a text with a unit (the cell that
        holds it is taken), a label, or the position along a dimension that has neither. Raises PlotError.
    """
    found: dict[Hashable, int] = {}
    for name, wanted in select.items():
        dim = _dimension(ds, name)
        if dim in found:
            raise PlotError(f"cannot select {name!r} twice")
        found[dim] = _position(ds, dim, wanted)
    return found


def _dimension(ds: xr.Dataset, name: str) -> Hashable:
    """The dimension called `name`, or along which the quantity `name` varies by itself."""
    for dim in ds.dims:
        if name in (dim, quantity_of(str(dim)), str(dim).removesuffix("_case")):
            return dim
    dims = [str(dim) for dim in ds.dims]
    near = suggest(name, dims)
    hint = f"; did you mean {near}?" if near else ""
    raise PlotError(f"cannot select {name!r}; dimensions are {', '.join(dims)}{hint}")


def _position(ds: xr.Dataset, dim: Hashable, wanted: Any) -> int:
    """Where along `dim` the value, label or position `wanted` is."""
    if dim not in ds.coords:
        number = _number(dim, wanted)
        if number not in range(ds.sizes[dim]):
            raise PlotError(f"cannot select {dim}={wanted}; positions are 0 to {ds.sizes[dim] - 1}")
        return int(number)
    if _is_numeric(ds, dim):
        return _cell_of(ds, dim, wanted)
    labels = [str(label) for label in ds[dim].values]
    if str(wanted) not in labels:
        near = suggest(str(wanted), labels)
        hint = f"; did you mean {near}?" if near else ""
        raise PlotError(f"cannot select {dim}={wanted}; labels are {', '.join(labels)}{hint}")
    return labels.index(str(wanted))


def _cell_of(ds: xr.Dataset, dim: Hashable, wanted: Any) -> int:
    """The cell of a numeric axis in which `wanted` lies: the one that is nearest on the scale of the axis."""
    axis = MapAxis(ds, dim, plain=True)
    number, low, high = axis.unit.of(_number(dim, wanted)), axis.centres[0], axis.centres[-1]
    if not (low <= number <= high or any(math.isclose(number, end, rel_tol=_AS_SHOWN) for end in (low, high))):
        raise PlotError(f"cannot select {dim}={wanted}; the axis {_runs(axis)}{unit_meant(ds, dim, wanted)}")
    cell = int(np.searchsorted(axis.edges, number, side="right")) - 1
    return min(max(cell, 0), axis.length - 1)


def span(ds: xr.Dataset, dim: Hashable) -> tuple[float, float, str]:
    """How far the cells of a numeric axis that rises reach, in SI, and from where to where it runs, in words."""
    axis = MapAxis(ds, dim, plain=True)
    low, high = (float(axis.unit.to_si(end)) for end in (axis.edges[0], axis.edges[-1]))
    return low, high, _runs(axis)


def unit_meant(ds: xr.Dataset, dim: Hashable, wanted: Any) -> str:
    """`; 25 is read as 25 m/s; did you mean 25 mm/s?` of a number that lies on an axis only when it has its unit."""
    try:
        number = float(wanted)
    except (TypeError, ValueError):
        return ""
    low, high, _ = span(ds, dim)
    unit = MapAxis(ds, dim, plain=True).unit.name
    doubt = misread(number, low, high, quantity_of(str(dim)), unit)
    return f"; {doubt[0]}; {doubt[1]}" if doubt else ""


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


def _number(dim: Hashable, wanted: Any) -> float:
    """A number, or a text with a unit, in SI."""
    declared = QUANTITIES.get(quantity_of(str(dim)))
    try:
        number = float(wanted)
    except (TypeError, ValueError):
        number = math.nan
        if declared is not None:
            try:
                number = units.si_value(wanted, declared.units)
            except QuantityError as error:
                raise PlotError(f"cannot select {dim}={wanted}; {error}") from None
    if not math.isfinite(number):
        raise PlotError(f"cannot select {dim}={wanted}; expected a finite number in SI units")
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
    """Whether the points of `dim` are numbers, not names or places in a row."""
    return dim in ds.coords and ds[dim].dtype.kind in "fiu"
