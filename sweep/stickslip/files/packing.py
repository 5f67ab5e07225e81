"""What is made of the values of a chunk before they are stored: the bytes that the file has, and values again.

    plain    the values as they are
    netcdf   HDF5's filters: Fletcher-32, shuffle, deflate (`filters.py`)

Whoever computes values can pack them by the thread that has them; the file is then put together without another look.
None of it holds Python's global lock for long.

Zarr has no packing: there a chunk is a file, of which one cannot have thousands (each waits for the disk), so that its
chunks are made of many blocks and packed when they are whole.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from stickslip.files.filters import Bytes, Filter, filtered, unfiltered

PLAIN, NETCDF = PACKINGS = ("plain", "netcdf")


def netcdf_filters(dtype: np.dtype[Any]) -> tuple[Filter, ...]:
    """The filters of our netCDF files, in the order that netCDF declares, with the level of deflate that it is told."""
    return ((3, ()), (2, (dtype.itemsize,)), (1, (4,)))


def packed(values: NDArray[Any], packing: str) -> Bytes:
    """The bytes of a chunk. values : contiguous, as they are to be read."""
    raw = values.reshape(-1).view(np.uint8)
    return filtered(raw, netcdf_filters(values.dtype)) if packing == NETCDF else raw


def unpacked(data: memoryview, packing: str, dtype: np.dtype[Any]) -> NDArray[Any]:
    """The values of a chunk, flat. Raises ValueError for what `packed` has not made."""
    if packing not in PACKINGS:
        raise ValueError(f"a packing {packing!r}")
    raw = np.frombuffer(data, np.uint8)
    return (unfiltered(raw, netcdf_filters(dtype)) if packing == NETCDF else raw).view(dtype)
