"""A result file, in which all but its chunks is written: chunks compressed by threads and put where they belong.

The file and all it says of itself are made by xarray with netCDF4 or Zarr; only chunks are put in here, as the file
declares them. A chunk that is packed already (`netcdf.py`) goes in as it is.
"""

from __future__ import annotations

import os
from abc import ABC, abstractmethod
from collections import deque
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import Future, ThreadPoolExecutor
from dataclasses import dataclass
from itertools import product
from types import TracebackType
from typing import Any

import numpy as np
from numpy.typing import NDArray

from stickslip.files.seal import content_of

Packed = Any  # bytes, or an array or view of them
Origin = tuple[int, ...]
Rest = Callable[[], None] | None  # of storing a chunk
Contents = dict[tuple[str, Origin], bytes]  # what identifies chunks (`seal.content_of`), by variable and number


@dataclass(frozen=True)
class Layout:
    """A variable as the file declares it.

    fill : one value, for what lies outside of the array in its last chunks. pack : the bytes of the values of a chunk.
    packing : the name of that in `netcdf.py`, None for what is not there. target : the variable, for who stores.
    """

    dtype: np.dtype[Any]
    chunks: tuple[int, ...]
    fill: NDArray[Any]
    pack: Callable[[NDArray[Any]], Packed]
    packing: str | None
    target: Any

    def number(self, origin: Sequence[int]) -> Origin:
        """The number of a chunk along each dimension."""
        return tuple(first // length for first, length in zip(origin, self.chunks, strict=True))

    def ready(self, values: NDArray[Any]) -> Packed:
        """The bytes of one chunk as they are in the file."""
        if values.shape != self.chunks:
            part = values
            values = np.full(self.chunks, self.fill, self.dtype)
            values[tuple(map(slice, part.shape))] = part
        return self.pack(np.ascontiguousarray(values, self.dtype))


class Chunks(ABC):
    """A result file that was created and closed, open for whole chunks. A context manager.

    threads : that compress, all processors if None. Chunks wait in memory for them, a few for each thread.
    """

    def __init__(self, threads: int | None = None) -> None:
        self._threads = threads or os.cpu_count() or 1
        self._layouts: dict[str, Layout] = {}
        self._contents: Contents = {}
        self._waiting: deque[Future[Rest]] = deque()
        self._pool = ThreadPoolExecutor(self._threads)

    def __enter__(self) -> Chunks:
        return self

    def __exit__(self, kind: type[BaseException] | None, error: BaseException | None, _: TracebackType | None) -> None:
        try:
            while self._waiting and not error:
                self._finish_first()
            if not error:
                self._mark(self._contents)
        finally:
            self._pool.shutdown(cancel_futures=True)
            self._layouts.clear()
            self._close()

    def layout(self, name: str) -> Layout:
        """The layout of a variable in the file."""
        if name not in self._layouts:
            self._layouts[name] = self._declared(name)
        return self._layouts[name]

    def write(self, name: str, values: NDArray[Any], start: Sequence[int] | None = None) -> None:
        """Values of whole chunks, the first at index `start` of the variable: compressed by threads, soon stored."""
        layout = self.layout(name)
        for place, part in _cut(values, layout.chunks):
            origin = tuple(map(sum, zip(place, start, strict=True))) if start else place
            self._submit(self.fill, name, origin, part)

    def put(self, name: str, origin: Sequence[int], data: Packed, content: bytes) -> None:
        """A chunk that is packed as the file has it. content : of its values, by `seal.content_of`."""
        self.layout(name)
        self._submit(self._put, name, tuple(origin), data, content)

    def holds(self, name: str, origin: Sequence[int]) -> bool:
        """Tell whether a chunk is stored already, by a writer that was killed."""
        return False

    def __getitem__(self, name: str) -> _Target:
        self.layout(name)
        return _Target(name, self.fill)

    def fill(self, name: str, origin: Origin, values: NDArray[Any]) -> Rest:
        """Store the values of a chunk, by any thread; returns what `_place` does."""
        layout = self._layouts[name]
        return self._put(name, origin, layout.ready(values), content_of(np.asarray(values, layout.dtype)))

    def _put(self, name: str, origin: Origin, data: Packed, content: bytes) -> Rest:
        layout = self._layouts[name]
        self._contents[name, layout.number(origin)] = content
        return self._place(layout, origin, data)

    def _submit(self, store: Callable[..., Rest], *chunk: Any) -> None:
        self._waiting.append(self._pool.submit(store, *chunk))
        if len(self._waiting) > 2 * self._threads:
            self._finish_first()

    def _finish_first(self) -> None:
        if store := self._waiting.popleft().result():
            store()

    @abstractmethod
    def _declared(self, name: str) -> Layout:
        """The layout that the file declares."""

    @abstractmethod
    def _place(self, layout: Layout, origin: Origin, data: Packed) -> Rest:
        """Store a chunk, by any thread. Returns what is to be done in the order in which chunks were given, if any."""

    @abstractmethod
    def _mark(self, contents: Contents) -> None:
        """Have the seal of the file cover the chunks that were stored."""

    @abstractmethod
    def _close(self) -> None:
        """Close the file."""


@dataclass(frozen=True)
class _Target:
    """A variable as `dask.array.store` fills it, from threads of its own: a chunk at a time."""

    name: str
    fill: Callable[[str, Origin, NDArray[Any]], Rest]

    def __setitem__(self, region: tuple[slice, ...], values: NDArray[Any]) -> None:
        if store := self.fill(self.name, tuple(side.start for side in region), values):
            store()


def _cut(values: NDArray[Any], chunks: tuple[int, ...]) -> Iterator[tuple[Origin, NDArray[Any]]]:
    """The values chunk by chunk, and where each begins."""
    for place in product(*(range(0, length, step) for length, step in zip(values.shape, chunks, strict=True))):
        yield place, values[tuple(slice(first, first + step) for first, step in zip(place, chunks, strict=True))]
