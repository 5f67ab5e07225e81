"""Zarr stores by zarr-python: values into arrays that xarray has declared, then what the root says of them."""

from __future__ import annotations

import json
import os
from collections import deque
from collections.abc import Sequence
from concurrent.futures import Future, ThreadPoolExecutor
from pathlib import Path
from typing import Any

import fsspec
import numpy as np
import zarr
from numpy.typing import NDArray
from zarr.codecs import BloscCodec, Crc32cCodec, ZstdCodec

from stickslip.files.locations import ROOT, UNCACHED, Url
from stickslip.files.seal import GROUP, SEAL, TABLE, Contents, chunks_in, content_of, marks_of

_LEVEL = 3  # of zstd: 5 takes nearly three times as long, for stores that are 7 % smaller


class ZarrChunks:
    """A Zarr store in which all but its chunks is written, open for these. A context manager.

    names : of the arrays, in the order in which libraries are to list them. Only at the end the root lists them:
    before that, nobody takes it for a store. threads : that compress and write, all processors if None; few chunks wait
    for them.
    """

    def __init__(self, store: Path | Url, names: Sequence[str], threads: int | None = None) -> None:
        self._options = UNCACHED if isinstance(store, Url) else None
        self._store, self._names = str(store), names
        self._contents: Contents = {}
        self._threads = threads or os.cpu_count() or 1
        self._pool, self._waiting = ThreadPoolExecutor(self._threads), deque[Future[None]]()
        with zarr.config.set({"array.write_empty_chunks": True}):  # a chunk that is not there got lost
            self._group: Any = zarr.open_group(self._store, mode="r+", storage_options=self._options)
            self._arrays: dict[str, Any] = {name: self._group[name] for name in names}

    def __enter__(self) -> ZarrChunks:
        return self

    def __exit__(self, _kind: Any, error: BaseException | None, _trace: Any) -> None:
        try:
            while self._waiting and not error:
                self._waiting.popleft().result()
        finally:
            self._pool.shutdown(cancel_futures=True)
        if not error:
            self._mark()
            self._consolidate()

    def chunks(self, name: str) -> tuple[int, ...]:
        """The lengths of the chunks of a variable."""
        lengths: tuple[int, ...] = self._arrays[name].chunks
        return lengths

    def write(self, name: str, values: NDArray[Any], start: Sequence[int] | None = None) -> None:
        """Values of whole chunks, the first at index `start` of the variable."""
        self._waiting.append(self._pool.submit(self._write, name, values, np.asarray(start or (0,) * values.ndim)))
        if len(self._waiting) > 2 * self._threads:
            self._waiting.popleft().result()

    def _write(self, name: str, values: NDArray[Any], begin: NDArray[np.intp]) -> None:
        array = self._arrays[name]
        array[tuple(map(slice, begin, begin + values.shape))] = values
        first = begin // array.chunks
        for number, part in chunks_in(values.shape, array.chunks):
            self._contents[name, tuple(map(int, first + number))] = content_of(values[part])

    def _mark(self) -> None:
        """Add the table that binds chunks to their places."""
        numbers = {name: a for name, a in self._arrays.items() if a.ndim and a.dtype.kind in "fiu"}
        marks = marks_of(self._group.attrs[SEAL], {name: (a.shape, a.chunks) for name, a in numbers.items()})
        table = marks.noted(self._contents)
        self._group.create_group(GROUP).create_array(TABLE, data=table, chunks=table.shape, dimension_names=("chunk",))

    def _consolidate(self) -> None:
        """Have the root say what its arrays say of themselves, as xarray looks for it first, and warns where it is not.

        By hand, because zarr warns in turn that its third format knows no such thing (`must_understand` says that), and
        lists arrays at random.
        """
        files = fsspec.get_mapper(self._store, **(self._options or {}))
        root = json.loads(files[ROOT])
        arrays = {name: json.loads(files[f"{name}/{ROOT}"]) for name in self._names}
        root["consolidated_metadata"] = {"kind": "inline", "must_understand": False, "metadata": arrays}
        files[ROOT] = json.dumps(root, indent=2).encode()


def compressors(dtype: np.dtype[Any]) -> tuple[Any, ...]:
    """The codecs of an array, with a checksum over what they made."""
    if dtype.kind not in "fiu":
        return ZstdCodec(), Crc32cCodec()
    shuffle: Any = "shuffle" if dtype.itemsize > 1 else "bitshuffle"
    return BloscCodec(cname="zstd", clevel=_LEVEL, typesize=dtype.itemsize, shuffle=shuffle), Crc32cCodec()
