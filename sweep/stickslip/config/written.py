"""The units in which a configuration was written, so that its results are shown in them."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from typing import TYPE_CHECKING, Any

from stickslip.vocabulary import units
from stickslip.vocabulary.quantities import QUANTITIES

if TYPE_CHECKING:
    import xarray as xr

DISPLAY = "display_units"  # attribute of coordinates and variables, which are SI: the unit in which they are shown


def written_units(data: Any) -> dict[str, str]:
    """By quantity, the first unit it has in the plain data of a configuration that is right, as it is written there.

    A quantity is given in one place, its range may be in another (what is searched along a border, say). Plain numbers
    are SI, and in no unit of their own.
    """
    found: dict[str, str] = {}
    for name, value in _given(data):
        if name not in found and QUANTITIES[name].units != "1" and (unit := _first(value)):
            found[name] = unit
    return found


def units_shown(ds: xr.Dataset) -> dict[str, str]:
    """The units that `written_units` found for what a result was computed from, as its file has them."""
    found = {str(name): str(one.attrs[DISPLAY]) for name, one in ds.coords.items() if DISPLAY in one.attrs}
    along = ds.attrs.get("border_parameter")
    if along is not None and DISPLAY in ds["border"].attrs:
        found[str(along)] = str(ds["border"].attrs[DISPLAY])
    return found


def _given(data: Any) -> Iterator[tuple[str, Any]]:
    """Quantities by name with what is said of them, anywhere."""
    if not isinstance(data, Mapping):
        return
    for key, value in data.items():
        if key in QUANTITIES:
            yield key, value
        else:
            yield from _given(value)
    if data.get("along") in QUANTITIES:  # a border, whose range stands beside it
        yield data["along"], data.get("between")


def _first(value: Any) -> str | None:
    """The first unit in a value, a list of values, or the values of a mapping."""
    if isinstance(value, str):
        return units.unit_in(value)
    inner: Iterable[Any] = ()
    if isinstance(value, Mapping):
        inner = value.values()
    elif isinstance(value, list | tuple):
        inner = value
    return next((unit for one in inner if (unit := _first(one))), None)
