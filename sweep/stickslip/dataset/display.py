"""The units in which people see what a dataset holds in SI: on axes, colour bars, screens and pages.

The rule, in this order:

1. a variable or coordinate with the attribute `display_units` is shown in that unit. Coordinates have it where the
   configuration was written with a unit; `with_units` sets it where people ask for one;
2. a speed is shown as the belt speed is, a force as the normal load, a length in the length of the speeds (mm where
   they are in mm/s): outputs follow inputs;
3. a time is shown in ms where all of it is below 0.1 s, and in microseconds below 0.1 ms; a rate in Hz;
4. everything else is shown in SI.

Files and Python stay SI.
"""

from __future__ import annotations

import re
from collections.abc import Mapping
from typing import Any

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from stickslip.errors import PlotError, QuantityError
from stickslip.vocabulary import units
from stickslip.vocabulary.display_units import DISPLAY, Unit

_LEADERS = {"m s-1": ("belt_speed", "velocity"), "N": ("normal_load",), "m": ("displacement", "stroke")}
_SPEED = re.compile(r"\s*([A-Za-zµμ]+)\s*/\s*[A-Za-z]+\s*")  # a unit of speed as a length over a time
_FINER_BELOW = 100.0  # of the finer unit of time: 0.1 s are 100 ms


def unit_of(array: xr.DataArray, values: NDArray[Any] | None = None) -> Unit:
    """The unit in which a variable or coordinate is shown.

    values : those that are shown, where they are not all; of times, their size decides.
    """
    si, name = str(array.attrs.get("units", "1")), array.attrs.get(DISPLAY)
    if si == "1":
        return Unit()
    if name is None:
        name = _unit_of_leader(array, si) or _unit_of_time(array, si, values)
    try:
        return Unit(str(name), units.factor(str(name), si)) if name else si_unit(array)
    except QuantityError:  # not in a file of ours
        return si_unit(array)


def si_unit(array: xr.DataArray) -> Unit:
    """The unit of the file, where numbers are to be shown as they are there."""
    return Unit(units.spelled(str(array.attrs.get("units", "1"))))


def displayed(array: xr.DataArray) -> tuple[NDArray[np.float64], str]:
    """The values of an array as people see them, and their unit as people type it."""
    values = np.asarray(array.values, np.float64)
    unit = unit_of(array, values)
    return unit.of(values), unit.name


def with_units(ds: xr.Dataset, chosen: Mapping[str, str]) -> xr.Dataset:
    """The dataset, whose named variables and coordinates are shown in other units. Raises PlotError."""
    ds = ds.copy()
    for name, unit in chosen.items():
        if name not in ds.variables:
            raise PlotError(f"no {name!r} to show in {unit}; there are {', '.join(map(str, ds.variables))}")
        si = str(ds[name].attrs.get("units", "1"))
        try:
            if si == "1":
                raise QuantityError("no unit")
            units.factor(unit, si)
        except QuantityError as error:
            hint = f"\nhint: {error.hint}" if error.hint else ""
            raise PlotError(f"cannot show {name} in {unit!r}, expected {_expected(si)}{hint}") from None
        ds[name].attrs[DISPLAY] = unit
    return ds


def shown_as_written(ds: xr.Dataset, written_in: Mapping[str, str]) -> xr.Dataset:
    """The dataset, whose coordinates are shown in the units in which a configuration has them (`Config.written_in`)."""
    return with_units(ds, {name: unit for name, unit in written_in.items() if name in ds.coords})


def _expected(si: str) -> str:
    if si == "1":
        return "none: it is a pure number"
    try:
        return f"a unit of {units.kind(si).split(' ', 1)[1]}, such as {units.unit_in(units.example(si))}"
    except KeyError:
        return f"a unit like {units.spelled(si)}"


def _unit_of_leader(array: xr.DataArray, si: str) -> str | None:
    """The unit of the coordinate that quantities of this kind follow."""

    def first(names: tuple[str, ...]) -> str | None:
        known = (array.coords[name].attrs.get(DISPLAY) for name in names if name in array.coords)
        return next((unit for unit in known if unit is not None), None)

    unit = first(_LEADERS.get(si, ()))
    if unit is None and si == "m":
        speed = _SPEED.fullmatch(first(_LEADERS["m s-1"]) or "")
        return speed[1] if speed else None
    return unit


def _unit_of_time(array: xr.DataArray, si: str, values: NDArray[Any] | None) -> str | None:
    """Seconds, or a part of them, by the largest; a rate in Hz."""
    if si == "s-1":
        return "Hz"
    if si != "s":
        return None
    shown = np.abs(np.asarray(array.values if values is None else values, np.float64))
    largest = float(np.max(shown, where=np.isfinite(shown), initial=0.0))
    if largest == 0.0 or largest >= _FINER_BELOW * 1e-3:
        return "s"
    return "ms" if largest >= _FINER_BELOW * 1e-6 else "µs"
