"""A chunk of a file, packed by threads; and the seal over what is in no chunk.

Filters. Our netCDF files have Fletcher-32, shuffle and deflate, which the HDF5 library runs one chunk at a time. Here
they run in as many threads as one likes, since none of them holds Python's global lock for long: whoever computes
values packs them by the thread that has them. ISA-L's deflate takes a tenth of the time of zlib's, and gives ordinary
deflated data. Specification: HDF5 File Format, Filter Pipeline Message; H5checksum.c and H5Zshuffle.c for what it
leaves open.

The seal. Chunks carry a checksum each (Fletcher-32 in netCDF, CRC-32C in Zarr), but names, units, texts and single
numbers are stored without. The seal is a digest over those, kept in a global attribute: a flipped bit in the
configuration or in the mass of all cells is found when the file is opened. History, title and the like may be edited
freely. What no checksum can detect is a chunk that is not there, because its place in the file's table of chunks was
damaged: it reads as fill values. So these differ from all values that are written.
"""

import hashlib
import os
from collections import deque
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import Future, ThreadPoolExecutor
from itertools import product
from typing import Any, Self

import numpy as np
import xarray as xr
from isal import isal_zlib
from numpy.typing import NDArray

from stickslip.files.locations import SEAL as SEAL

Bytes = NDArray[np.uint8]
Filter = tuple[int, tuple[int, ...]]  # number and parameters, as declared in the file
PLAIN, NETCDF = PACKINGS = ("plain", "netcdf")  # values of a chunk as they are, or after the filters
_DEFLATE, _SHUFFLE, _FLETCHER32 = 1, 2, 3  # numbers of filters
_NO_SHUFFLE = (_SHUFFLE, (1,))  # of single bytes: it does nothing
_LEVEL = 2  # of 0 to 3: as fast as 1, two percent smaller; 3 takes twice as long and gains nothing
_ROW = 512  # words; a chunk has about as many rows

NOBODY_WROTE = np.array(0x7FF8_0000_0571_C511, np.uint64).view(np.float64)[()]  # a NaN no computation ends with
NETCDF_FILL = {"i1": -127, "i4": -2147483647, "f8": 9.969209968386869e36}  # where a variable has no fill value
_SEALED_ATTRIBUTES = ("units", "axis_spacing", "flag_values", "flag_meanings")


# --- filters ----------------------------------------------------------------------------------------------------------


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
    return (_unfiltered(raw, _filters(dtype)) if packing == NETCDF else raw).view(dtype)


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


def _unfiltered(data: Bytes, pipeline: Sequence[Filter]) -> Bytes:
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


# --- the seal ---------------------------------------------------------------------------------------------------------


def sealed(ds: xr.Dataset) -> xr.Dataset:
    """The dataset as it goes into a file, with its seal."""
    return ds.assign_attrs({SEAL: digest(ds)})


def digest(ds: xr.Dataset) -> str:
    """Digest of the configuration, of names, dimensions and units of all variables, and of values without chunks."""
    hasher = hashlib.sha256()
    hasher.update(_text(ds.attrs.get("configuration", "")))
    for name in sorted(map(str, ds.variables)):
        variable = ds.variables[name]
        is_number = variable.dtype.kind in "fiu"  # texts of any length are one type, in any kind of file
        hasher.update(_text(name, *variable.dims, *variable.shape, variable.dtype.str if is_number else "text"))
        for attribute in _SEALED_ATTRIBUTES:
            if attribute in variable.attrs:
                hasher.update(_text(attribute, *np.atleast_1d(variable.attrs[attribute])))
        if variable.ndim == 0 or not is_number:  # stored without checksum
            values = np.ascontiguousarray(variable.values)
            hasher.update(values.tobytes() if is_number else _text(*values.ravel()))
    return hasher.hexdigest()


def chunks_in(shape: tuple[int, ...], lengths: tuple[int, ...]) -> Iterator[tuple[slice, ...]]:
    """The chunks of an array, each as its slices."""
    for corner in product(*map(range, (0,) * len(shape), shape, lengths)):
        yield tuple(slice(i, min(i + n, end)) for i, n, end in zip(corner, lengths, shape, strict=True))


def is_unwritten(values: NDArray[Any]) -> bool:
    """Tell whether some values are fill values, as they are where a chunk got lost."""
    fill = NETCDF_FILL.get(values.dtype.str[1:])
    if fill is not None and bool((values == fill).any()):
        return True
    return values.dtype == np.float64 and bool((values.view(np.uint64) == NOBODY_WROTE.view(np.uint64)).any())


def _text(*parts: Any) -> bytes:
    """The parts as bytes, each with its length before it, so that no two lists of parts look alike."""
    encoded = [str(part).encode("utf-8", "surrogatepass") for part in parts]
    return b"".join(len(part).to_bytes(8, "little") + part for part in encoded)


# --- written by threads -----------------------------------------------------------------------------------------------


class ChunkFile:
    """A file in which all but its chunks is written, open for these. A context manager.

    threads : that pack chunks, all processors if None; few chunks wait for them. Whoever gives chunks has them put into
    the file in their order (`_store`): equal files for any number of threads.
    """

    def __init__(self, threads: int | None) -> None:
        self._threads = threads or os.cpu_count() or 1
        self._pool, self._waiting = ThreadPoolExecutor(self._threads), deque[Future[Any]]()

    def __enter__(self) -> Self:
        return self

    def __exit__(self, _kind: Any, error: BaseException | None, _trace: Any) -> None:
        try:
            while self._waiting and not error:
                self._store(self._waiting.popleft().result())
        finally:
            self._pool.shutdown(cancel_futures=True)
            self._close()

    def _submit(self, make: Callable[..., Any], *arguments: Any) -> None:
        self._waiting.append(self._pool.submit(make, *arguments))
        if len(self._waiting) > 2 * self._threads:
            self._store(self._waiting.popleft().result())

    def _store(self, made: Any) -> None:
        """Take what `make` has given, in the order in which that was submitted."""

    def _close(self) -> None:
        """Let go of the file, whatever happened."""
