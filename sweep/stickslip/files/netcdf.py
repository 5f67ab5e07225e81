"""netCDF-4 files: one thread at a time in their library, and their chunks stored ready-made by h5py.

netCDF and HDF5 are not safe for more than one thread. xarray locks reading and writing of values, but not what it asks
a file for when it opens, describes or closes it. So whatever of ours touches a netCDF file holds NETCDF_LOCK, and what
xarray does later with a file of ours (a lazy chunk, closing, the garbage collector) takes the same lock, because it was
given to it. Holding it includes holding xarray's own lock: plain xarray in another thread waits wherever it locks at
all. Never wait for other threads while holding it: dask's read our files. `os.fork` waits for it, so that the child
finds the libraries idle and the lock free.

netCDF4 and h5py may each bring an HDF5 library of their own, or share one: so h5py, too, is used under NETCDF_LOCK, and
a file is open in one of them at a time. h5py has a lock of its own, which is always taken after this one.
"""

from __future__ import annotations

import os
import threading
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray
from xarray.backends.netCDF4_ import NETCDF4_PYTHON_LOCK

from stickslip.files.chunks import (
    GROUP,
    SEAL,
    TABLE,
    ChunkFile,
    Filter,
    Marks,
    chunks_in,
    content_of,
    filtered,
    packing_of,
)

Packed = Any  # bytes, or an array or view of them
Origin = tuple[int, ...]


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


@dataclass(frozen=True)
class Layout:
    """A variable as the file declares it.

    fill : one value, for what lies outside of the array in its last chunks. packing : the name in `chunks.py` of what
    its filters make; None for what is not there.
    """

    variable: Any
    dtype: np.dtype[Any]
    chunks: tuple[int, ...]
    fill: NDArray[Any]
    pipeline: tuple[Filter, ...]
    packing: str | None

    def packed(self, values: NDArray[Any]) -> Packed:
        """The bytes of one chunk as they are in the file."""
        whole = np.ascontiguousarray(values, self.dtype)
        if values.shape != self.chunks:
            whole = np.full(self.chunks, self.fill, self.dtype)
            whole[tuple(map(slice, values.shape))] = values
        return filtered(whole.reshape(-1).view(np.uint8), self.pipeline)


class NetcdfChunks(ChunkFile):
    """The chunks of a netCDF file: packed by threads, stored by the thread that gives them."""

    def __init__(self, path: Path, threads: int | None = None) -> None:
        super().__init__(threads)
        self._layouts: dict[str, Layout] = {}
        h5py = load_h5py()
        with NETCDF_LOCK:
            self._file = h5py.File(path, "r+")

    def _close(self) -> None:
        self._layouts.clear()
        with NETCDF_LOCK:
            self._file.close()

    def layout(self, name: str) -> Layout:
        """The layout of a variable in the file."""
        if name not in self._layouts:
            with NETCDF_LOCK:
                variable = self._file[name]
                declared = variable.id.get_create_plist()
                fill = np.empty((), variable.dtype)
                declared.get_fill_value(fill)
                filters = [declared.get_filter(i) for i in range(declared.get_nfilters())]
                pipeline = tuple((number, parameters) for number, _, parameters, _ in filters)
                packing = packing_of(pipeline, variable.dtype)
                layout = Layout(variable, variable.dtype, variable.chunks, fill, pipeline, packing)
            self._layouts[name] = layout
        return self._layouts[name]

    def chunks(self, name: str) -> tuple[int, ...]:
        """The lengths of the chunks of a variable."""
        return self.layout(name).chunks

    def write(self, name: str, values: NDArray[Any], start: Sequence[int] | None = None) -> None:
        """Values of whole chunks, the first at index `start` of the variable."""
        layout = self.layout(name)

        def made(origin: Origin, part: NDArray[Any]) -> tuple[str, Origin, Packed, bytes]:
            return name, origin, layout.packed(part), content_of(np.asarray(part, layout.dtype))

        for _, part in chunks_in(values.shape, layout.chunks):
            origin = tuple(side.start + first for side, first in zip(part, start or (0,) * values.ndim, strict=True))
            self._submit(made, origin, values[part])

    def put(self, name: str, origin: Sequence[int], data: Packed, content: bytes) -> None:
        """A chunk that is packed as the file has it. content : of its values, by `content_of`."""
        self._submit(lambda: (name, tuple(origin), data, content))

    def _store(self, made: tuple[Any, ...]) -> None:
        name, origin, data, content = made
        layout = self.layout(name)
        number = tuple(first // length for first, length in zip(origin, layout.chunks, strict=True))
        self._contents[name, number] = content
        with NETCDF_LOCK:
            layout.variable.id.write_direct_chunk(origin, data)

    def _complete(self) -> None:
        """Have the seal of the file cover the chunks that were stored."""
        with NETCDF_LOCK:
            if GROUP not in self._file:
                return
            arrays = {name: array for name, array in self._file.items() if getattr(array, "chunks", None)}
            shapes = {name: (a.shape, a.chunks) for name, a in arrays.items() if a.dtype.kind in "fiu"}
            table, seal = self._file[GROUP][TABLE], np.bytes_(self._file.attrs[SEAL]).decode()  # text or bytes
            table[...] = Marks.of(seal, shapes, table[...]).noted(self._contents)
