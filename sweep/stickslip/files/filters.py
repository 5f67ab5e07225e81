"""The filters of our netCDF files: Fletcher-32, shuffle and deflate, which the HDF5 library runs one chunk at a time.

Here they run in as many threads as one likes, since none of them holds Python's global lock for long: whoever computes
values packs them by the thread that has them. ISA-L's deflate takes a tenth of the time of zlib's, and gives ordinary
deflated data.

Specification: HDF5 File Format, Filter Pipeline Message; H5checksum.c and H5Zshuffle.c for what it leaves open.
"""

from collections.abc import Sequence
from typing import Any

import numpy as np
from isal import isal_zlib
from numpy.typing import NDArray

Bytes = NDArray[np.uint8]
Filter = tuple[int, tuple[int, ...]]  # number and parameters, as declared in the file

PLAIN, NETCDF = PACKINGS = ("plain", "netcdf")  # values of a chunk as they are, or after the filters
_DEFLATE, _SHUFFLE, _FLETCHER32 = 1, 2, 3  # numbers of filters
_NO_SHUFFLE = (_SHUFFLE, (1,))  # of single bytes: it does nothing
_LEVEL = 2  # of 0 to 3: as fast as 1, two percent smaller; 3 takes twice as long and gains nothing
_ROW = 512  # words; a chunk has about as many rows


def packing_of(pipeline: Sequence[Filter], dtype: np.dtype[Any]) -> str | None:
    """The packing whose bytes these filters make; None if they are not ours."""
    ours = [each for each in _filters(dtype) if each != _NO_SHUFFLE]
    return NETCDF if [each for each in pipeline if each != _NO_SHUFFLE] == ours else None


def _filters(dtype: np.dtype[Any]) -> tuple[Filter, ...]:
    """The filters of our netCDF files, in the order that netCDF declares, with the level of deflate that it is told."""
    return ((_FLETCHER32, ()), (_SHUFFLE, (dtype.itemsize,)), (_DEFLATE, (4,)))


def packed(values: NDArray[Any], packing: str) -> Bytes:
    """The bytes of a chunk of values, which are contiguous."""
    raw = values.reshape(-1).view(np.uint8)
    return filtered(raw, _filters(values.dtype)) if packing == NETCDF else raw


def unpacked(data: memoryview, packing: str, dtype: np.dtype[Any]) -> NDArray[Any]:
    """The values of a chunk, flat. Raises ValueError for what `packed` has not made."""
    if packing not in PACKINGS:
        raise ValueError(f"a packing {packing!r}")
    raw = np.frombuffer(data, np.uint8)
    return (unfiltered(raw, _filters(dtype)) if packing == NETCDF else raw).view(dtype)


def filtered(data: Bytes, pipeline: Sequence[Filter]) -> Bytes:
    """The bytes of a chunk after the filters that the file declares, in their order. ValueError: one we have not.

    The level of deflate that the file declares is zlib's, and says nothing to a reader.
    """
    for number, parameters in pipeline:
        if number == _FLETCHER32:
            data = np.concatenate([data, np.frombuffer(fletcher32(data).to_bytes(4, "little"), np.uint8)])
        elif number == _SHUFFLE:
            data = _shuffled(data, parameters[0])
        elif number == _DEFLATE:
            data = np.frombuffer(isal_zlib.compress(data, _LEVEL), np.uint8)
        else:
            raise ValueError(f"the filter {number} of HDF5, which is not one of ours")
    return data


def unfiltered(data: Bytes, pipeline: Sequence[Filter]) -> Bytes:
    """The bytes that `filtered` was given. Raises ValueError for what it cannot have made."""
    for number, parameters in reversed(pipeline):
        if number == _DEFLATE:
            try:
                data = np.frombuffer(isal_zlib.decompress(data), np.uint8)
            except isal_zlib.error as error:  # type: ignore[misc]
                raise ValueError(str(error)) from error
        elif number == _SHUFFLE:
            data = _shuffled(data, parameters[0], back=True)
        else:
            data, checksum = data[:-4], data[-4:]
            if checksum.size < 4 or fletcher32(data) != int.from_bytes(checksum.tobytes(), "little"):
                raise ValueError("a checksum that does not match")
    return data


def _shuffled(data: Bytes, size: int, back: bool = False) -> Bytes:
    """All first bytes of values, then all second ones, and so on; what is not a whole value stays at the end."""
    whole = data.size // size * size
    out = np.empty_like(data)
    shape = (-1, size) if back else (size, -1)
    out[:whole].reshape(shape)[...] = data[:whole].reshape(shape[::-1]).T
    out[whole:] = data[whole:]
    return out


def fletcher32(data: Bytes) -> int:
    """HDF5's checksum: Fletcher's over 16-bit big-endian words, modulo 65,535, an odd byte at the end padded with 0.

    Sums of rows and of columns give both sums. They are taken over little-endian words: modulo 65,535, swapping the
    bytes of the words swaps those of the sums.
    """
    words, whole = -(-data.size // 2), data.size // (2 * _ROW) * (2 * _ROW)
    table = data[:whole].view("<u2").reshape(-1, _ROW)
    last = np.zeros(2 * _ROW, np.uint8)
    last[: data.size - whole] = data[whole:]
    wide = np.uint32 if len(table) < 2**16 else np.uint64
    rows = np.append(table.sum(axis=1, dtype=wide), last.view("<u2").sum(dtype=wide))
    columns = table.sum(axis=0, dtype=wide) + last.view("<u2")
    simple = int(rows.sum(dtype=np.uint64))
    places = _ROW * _moment(rows) + _moment(columns)  # each word times how many are before it
    return _reduced(words * simple - places) << 16 | _reduced(simple)


def _moment(values: NDArray[Any]) -> int:
    return int(np.arange(values.size, dtype=np.uint64) @ values)


def _reduced(total: int) -> int:
    """A sum as it is stored: modulo 65,535, which stands for 0 unless all was 0; bytes swapped."""
    value = (total - 1) % 65535 + 1 if total else 0
    return (value & 0xFF) << 8 | value >> 8
