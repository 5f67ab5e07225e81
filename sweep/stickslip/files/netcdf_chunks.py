"""The chunks of a netCDF-4 file, stored ready-made by h5py.

netCDF4 and h5py may each bring an HDF5 library of their own, or share one: so h5py, too, is used under NETCDF_LOCK
(`netcdf_lock.py`), and a file is open in one of them at a time.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from pathlib import Path
from typing import Any

import h5py
import numpy as np
from numpy.typing import NDArray

from stickslip.files.chunks import Chunks, Contents, Layout, Origin, Packed
from stickslip.files.netcdf_lock import NETCDF_LOCK, hold_while_forking
from stickslip.files.packing import NETCDF, Bytes, Filter, filtered, netcdf_filters
from stickslip.files.seal import GROUP, SEAL, TABLE, marks_of

hold_while_forking()  # h5py takes its own lock then, and ours is always taken before that


_NO_SHUFFLE = (2, (1,))  # of single bytes: it does nothing


class NetcdfChunks(Chunks):
    """A netCDF file. Chunks are stored by the thread that gives them, in their order: equal files for any threads."""

    def __init__(self, path: Path, threads: int | None = None) -> None:
        super().__init__(threads)
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
            ours = [f for f in netcdf_filters(dataset.dtype) if f != _NO_SHUFFLE]
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
            marks = marks_of(seal, layouts, table[...])
            for (name, number), content in contents.items():
                marks.note(name, number, content)
            table[...] = marks.table

    def _close(self) -> None:
        with NETCDF_LOCK:
            self._file.close()


def _packed(pipeline: tuple[Filter, ...], values: NDArray[Any]) -> Bytes:
    return filtered(values.reshape(-1).view(np.uint8), pipeline)
