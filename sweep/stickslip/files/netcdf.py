"""netCDF-4 files: one thread at a time in their library, their filters, and their chunks stored ready-made by h5py.

netCDF and HDF5 are not safe for more than one thread. xarray locks reading and writing of values, but not what it asks
a file for when it opens, describes or closes it. So whatever of ours touches a netCDF file holds NETCDF_LOCK, and what
xarray does later with a file of ours (a lazy chunk, closing, the garbage collector) takes the same lock, because it was
given to it. Holding it includes holding xarray's own lock: plain xarray in another thread waits wherever it locks at
all. Never wait for other threads while holding it: dask's read our files. `os.fork` waits for it, so that the child
finds the libraries idle and the lock free.

netCDF4 and h5py may each bring an HDF5 library of their own, or share one: so h5py, too, is used under NETCDF_LOCK, and
a file is open in one of them at a time. h5py has a lock of its own, which is always taken after this one.

The HDF5 library runs its filters one chunk at a time, and zlib's deflate takes ten times as long as that of ISA-L,
which gives ordinary deflated data. The filters here (Fletcher-32, shuffle and deflate, which our files have) run in as
many threads as one likes, since none of them holds Python's global lock for long: whoever computes values packs them by
the thread that has them, and the file is then put together without another look. Zarr has no packing: there a chunk is
a file, of which one cannot have thousands (each waits for the disk), so that its chunks are made of many blocks and
packed when they are whole.

Specification: HDF5 File Format, Filter Pipeline Message; H5checksum.c and H5Zshuffle.c for what it leaves open.
"""

import os
import threading
from collections.abc import Callable, Sequence
from functools import cache, partial
from pathlib import Path
from typing import Any

import numpy as np
from isal import isal_zlib
from numpy.typing import NDArray
from xarray.backends.netCDF4_ import NETCDF4_PYTHON_LOCK

from stickslip.files.chunks import Chunks, Contents, Layout, Origin, Packed
from stickslip.files.seal import GROUP, SEAL, TABLE, marks_of

Bytes = NDArray[np.uint8]
Filter = tuple[int, tuple[int, ...]]  # number and parameters, as declared in the file

PLAIN, NETCDF = PACKINGS = ("plain", "netcdf")  # values of a chunk as they are, or after the filters
_DEFLATE, _SHUFFLE, _FLETCHER32 = 1, 2, 3  # numbers of filters
_NO_SHUFFLE = (_SHUFFLE, (1,))  # of single bytes: it does nothing
_LEVEL = 2  # of 0 to 3: as fast as 1, two percent smaller; 3 takes twice as long and gains nothing
_ROW = 512  # words; a chunk has about as many rows


class _NetcdfLock:
    """A re-entrant lock with the interface xarray asks for; a pickled one is that of the process that unpickles it."""

    def __init__(self) -> None:
        self._ours, self._xarrays, self._depth = threading.RLock(), NETCDF4_PYTHON_LOCK, 0

    def acquire(self, blocking: bool = True) -> bool:
        """Tell whether this thread holds the lock now; the garbage collector asks without blocking."""
        if not self._ours.acquire(blocking):
            return False
        try:
            free = self._depth > 0 or bool(self._xarrays.acquire(blocking))
        except BaseException:  # Ctrl-C while waiting
            self._ours.release()
            raise
        if free:
            self._depth += 1
        else:
            self._ours.release()
        return free

    def release(self) -> None:
        """Give up what one `acquire` took."""
        self._depth -= 1
        if self._depth == 0:
            self._xarrays.release()
        self._ours.release()

    def locked(self) -> bool:
        """Tell whether any thread holds it."""
        return self._depth > 0

    def __enter__(self) -> None:
        self.acquire()

    def __exit__(self, *_: Any) -> None:
        self.release()

    def __reduce__(self) -> str:
        return "NETCDF_LOCK"


NETCDF_LOCK = _NetcdfLock()


def _hold_while_forking() -> None:
    """Have `os.fork` wait for the lock. What is registered last is taken first, so again after libraries with locks."""
    if hasattr(os, "register_at_fork"):
        os.register_at_fork(
            before=NETCDF_LOCK.acquire, after_in_parent=NETCDF_LOCK.release, after_in_child=NETCDF_LOCK.release
        )


_hold_while_forking()


@cache
def load_h5py() -> Any:
    """The module h5py, whose import takes its time: for whoever writes a file."""
    import h5py

    _hold_while_forking()
    return h5py


# --- chunks -----------------------------------------------------------------------------------------------------------


class NetcdfChunks(Chunks):
    """A netCDF file. Chunks are stored by the thread that gives them, in their order: equal files for any threads."""

    def __init__(self, path: Path, threads: int | None = None) -> None:
        super().__init__(threads)
        h5py = load_h5py()
        with NETCDF_LOCK:
            self._file = h5py.File(path, "r+")

    def _declared(self, name: str) -> Layout:
        with NETCDF_LOCK:
            dataset = self._file[name]
            declared = dataset.id.get_create_plist()
            fill = np.empty((), dataset.dtype)
            declared.get_fill_value(fill)
            filters = [declared.get_filter(i) for i in range(declared.get_nfilters())]
            pipeline = tuple((number, parameters) for number, _, parameters, _ in filters)
            ours = [f for f in _filters(dataset.dtype) if f != _NO_SHUFFLE]
            packing = NETCDF if [f for f in pipeline if f != _NO_SHUFFLE] == ours else None
            return Layout(dataset.dtype, dataset.chunks, fill, partial(_packed, pipeline), packing, dataset)

    def _place(self, layout: Layout, origin: Origin, data: Packed) -> Callable[[], None]:
        def store() -> None:
            with NETCDF_LOCK:
                layout.target.id.write_direct_chunk(origin, data)

        return store

    def _mark(self, contents: Contents) -> None:
        with NETCDF_LOCK:
            if GROUP not in self._file:
                return
            arrays = {name: array for name, array in self._file.items() if getattr(array, "chunks", None)}
            layouts = {name: (a.shape, a.chunks) for name, a in arrays.items() if a.dtype.kind in "fiu"}
            table, seal = self._file[GROUP][TABLE], np.bytes_(self._file.attrs[SEAL]).decode()  # text or bytes
            table[...] = marks_of(seal, layouts, table[...]).noted(contents)

    def _close(self) -> None:
        with NETCDF_LOCK:
            self._file.close()


def _packed(pipeline: tuple[Filter, ...], values: NDArray[Any]) -> Bytes:
    return filtered(values.reshape(-1).view(np.uint8), pipeline)


# --- filters ----------------------------------------------------------------------------------------------------------


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
