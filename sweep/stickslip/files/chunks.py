"""Values into a netCDF file chunk by chunk, compressed by threads (`filters.py`) and stored ready-made by h5py.

The file and all it says of itself are netCDF4's; only chunks are put in here, through the filters that it declares.
netCDF4 and h5py may each bring an HDF5 library of their own, or share one: so h5py, too, is used under NETCDF_LOCK
(`netcdf_lock.py`), and a file is open in one of them at a time.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Iterator, Sequence
from concurrent.futures import Future, ThreadPoolExecutor
from dataclasses import dataclass
from itertools import product
from pathlib import Path
from types import TracebackType
from typing import Any

import h5py
import numpy as np
from numpy.typing import NDArray

from stickslip.files import machine
from stickslip.files.filters import Bytes, Filter, filtered
from stickslip.files.netcdf_lock import NETCDF_LOCK, hold_while_forking

hold_while_forking()  # h5py takes its own lock then, and ours is always taken before that


@dataclass(frozen=True)
class Layout:
    """A variable as the file declares it. fill : one value, for what lies outside of the array in its last chunks."""

    dataset: Any
    dtype: np.dtype[Any]
    chunks: tuple[int, ...]
    fill: NDArray[Any]
    pipeline: tuple[Filter, ...]

    def ready(self, values: NDArray[Any]) -> Bytes:
        """The bytes of one chunk as they are in the file."""
        if values.shape != self.chunks:
            part = values
            values = np.full(self.chunks, self.fill, self.dtype)
            values[tuple(map(slice, part.shape))] = part
        plain = np.ascontiguousarray(values, self.dtype)
        return filtered(plain.reshape(-1).view(np.uint8), self.pipeline)


class ChunkFile:
    """A netCDF file that netCDF4 has created and closed, open for whole chunks. A context manager.

    threads : that compress, all processors if None. Chunks wait in memory for them, a few for each thread.
    """

    def __init__(self, path: Path, threads: int | None = None) -> None:
        self._threads = threads or machine.processors()
        self._layouts: dict[str, Layout] = {}
        self._waiting: deque[tuple[Layout, tuple[int, ...], Future[Bytes]]] = deque()
        with NETCDF_LOCK:
            self._file = h5py.File(path, "r+")
        self._pool = ThreadPoolExecutor(self._threads)

    def __enter__(self) -> ChunkFile:
        return self

    def __exit__(self, kind: type[BaseException] | None, error: BaseException | None, _: TracebackType | None) -> None:
        try:
            while self._waiting and not error:
                self._store_first()
        finally:
            self._pool.shutdown(cancel_futures=True)
            with NETCDF_LOCK:
                self._layouts.clear()
                self._file.close()

    def layout(self, name: str) -> Layout:
        """How a variable is stored."""
        if name not in self._layouts:
            with NETCDF_LOCK:
                self._layouts[name] = _layout(self._file[name])
        return self._layouts[name]

    def write(self, name: str, values: NDArray[Any], start: Sequence[int] | None = None) -> None:
        """Values of whole chunks, the first at index `start` of the variable: compressed by threads, soon stored."""
        layout = self.layout(name)
        for place, part in _cut(values, layout.chunks):
            origin = tuple(map(sum, zip(place, start, strict=True))) if start else place
            self._waiting.append((layout, origin, self._pool.submit(layout.ready, part)))
            if len(self._waiting) > 2 * self._threads:
                self._store_first()

    def __getitem__(self, name: str) -> _Target:
        return _Target(self.layout(name))

    def _store_first(self) -> None:
        layout, origin, data = self._waiting.popleft()
        _store(layout, origin, data.result())


@dataclass(frozen=True)
class _Target:
    """A variable as `dask.array.store` fills it, from threads of its own: a chunk at a time."""

    layout: Layout

    def __setitem__(self, region: tuple[slice, ...], values: NDArray[Any]) -> None:
        _store(self.layout, tuple(side.start for side in region), self.layout.ready(values))


def _store(layout: Layout, origin: tuple[int, ...], data: Bytes) -> None:
    with NETCDF_LOCK:
        layout.dataset.id.write_direct_chunk(origin, data)


def _layout(dataset: Any) -> Layout:
    declared = dataset.id.get_create_plist()
    fill = np.empty((), dataset.dtype)
    declared.get_fill_value(fill)
    filters = [declared.get_filter(i) for i in range(declared.get_nfilters())]
    pipeline = tuple((number, parameters) for number, _, parameters, _ in filters)
    return Layout(dataset, dataset.dtype, dataset.chunks, fill, pipeline)


def _cut(values: NDArray[Any], chunks: tuple[int, ...]) -> Iterator[tuple[tuple[int, ...], NDArray[Any]]]:
    """The values chunk by chunk, and where each begins."""
    for place in product(*(range(0, length, step) for length, step in zip(values.shape, chunks, strict=True))):
        yield place, values[tuple(slice(first, first + step) for first, step in zip(place, chunks, strict=True))]
