"""A checksum over what the checksums of chunks do not cover.

Chunks carry a checksum each (Fletcher-32 in netCDF, CRC-32C in Zarr), but names, units, texts and single numbers are
stored without. The seal is a digest over those, kept in a global attribute: a flipped bit in the configuration or in
the mass of all cells is found when the file is opened. History, title and the like may be edited freely.

What no checksum can detect is a chunk that is not there, because its place in the file's table of chunks was damaged:
it reads as fill values. So these differ from all values that are written.
"""

from __future__ import annotations

import hashlib
from typing import Any

import numpy as np
import xarray as xr
from numpy.typing import NDArray

SEAL = "header_sha256"
NOBODY_WROTE = np.array(0x7FF8_0000_0571_C511, np.uint64).view(np.float64)[()]  # a NaN no computation ends with
_NETCDF_FILL = {"i1": -127, "i4": -2147483647, "f8": 9.969209968386869e36}  # where a variable has no fill value
_SEALED_ATTRIBUTES = ("units", "axis_spacing", "flag_values", "flag_meanings")


def sealed(ds: xr.Dataset) -> xr.Dataset:
    """The dataset as it goes into a file, with its seal."""
    return ds.assign_attrs({SEAL: digest(ds)})


def digest(ds: xr.Dataset) -> str:
    """Digest of the configuration, of names, dimensions and units of all variables, and of values without chunks."""
    found = hashlib.sha256()
    found.update(_text(ds.attrs.get("configuration", "")))
    for name in sorted(map(str, ds.variables)):
        variable = ds.variables[name]
        found.update(_text(name, *variable.dims, *variable.shape, _type(variable)))
        for attribute in _SEALED_ATTRIBUTES:
            if attribute in variable.attrs:
                found.update(_text(attribute, *np.atleast_1d(variable.attrs[attribute])))
        if has_bare_values(variable):
            found.update(_values(variable))
    return found.hexdigest()


def has_bare_values(variable: xr.Variable) -> bool:
    """Whether the values are stored without checksum: single numbers, and text."""
    return variable.ndim == 0 or variable.dtype.kind not in "fiu"


def is_unwritten(values: NDArray[Any]) -> bool:
    """Whether some values are fill values, as they are where a chunk got lost."""
    fill = _NETCDF_FILL.get(values.dtype.str[1:])
    if fill is not None and bool((values == fill).any()):
        return True
    return values.dtype == np.float64 and bool((values.view(np.uint64) == NOBODY_WROTE.view(np.uint64)).any())


def _type(variable: xr.Variable) -> str:
    """The type as it is in any kind of file: texts of any length are one type."""
    return variable.dtype.str if variable.dtype.kind in "fiu" else "text"


def _values(variable: xr.Variable) -> bytes:
    if variable.dtype.kind in "fiu":
        return np.ascontiguousarray(variable.values).tobytes()
    return _text(*variable.values.ravel())


def _text(*parts: Any) -> bytes:
    """The parts as bytes, each with its length before it, so that no two lists of parts look alike."""
    encoded = [str(part).encode("utf-8", "surrogatepass") for part in parts]
    return b"".join(len(part).to_bytes(8, "little") + part for part in encoded)
