"""The chunks of a Zarr store: each is a file or an object, `NAME/c/2/0`, or many are (`zarr_shards.py`).

Zarr core specification, version 3: "default" chunk keys; codecs `bytes` (little-endian), `blosc`, `crc32c`.
"""

from __future__ import annotations

import json
import os
from collections.abc import Callable, Iterable, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, field
from functools import partial
from typing import Any

import google_crc32c
import numpy as np
import zarr
from numcodecs import blosc  # type: ignore[import-untyped]
from numpy.typing import NDArray
from zarr.core.buffer import default_buffer_prototype
from zarr.storage import MemoryStore

from stickslip.files.chunks import Chunks, Contents, Layout, Origin, Packed, Rest
from stickslip.files.locations import ROOT
from stickslip.files.seal import GROUP, SEAL, TABLE, marks_of
from stickslip.files.zarr_shards import Sharding, Shards

LEVEL = 3  # of zstd: 5 takes nearly three times as long, for stores that are 7 % smaller
_AT_ONCE = 8  # objects that are put while others wait for an answer


@dataclass(frozen=True)
class NewZarr:
    """A Zarr store that is being written.

    put : stores bytes under a key, by any thread. waits : whether that waits for a service, so that more threads pay.
    shards : in a folder; where None, each chunk is a file or an object of its own.

    Chunks are put as they come. What the store says of itself is kept in memory until `finish` puts it, the root last:
    before that, nobody takes it for a store.
    """

    put: Callable[[str, Packed], None]
    waits: bool = False
    shards: Shards | None = None
    contents: Contents = field(default_factory=dict)
    shardings: dict[str, Sharding] = field(default_factory=dict)
    _metadata: dict[str, Any] = field(default_factory=dict)

    @property
    def metadata(self) -> MemoryStore:
        """The metadata of the store, for xarray and zarr."""
        return MemoryStore(self._metadata)

    def declared(self) -> None:
        """All arrays are declared: go on where an earlier writer of their shards was."""
        if self.shards is None:
            return
        group: Any = zarr.open_group(self.metadata, mode="r")
        for name, array in group.arrays():
            if array.shards:
                counts = tuple(-(-length // chunk) for length, chunk in zip(array.shape, array.chunks, strict=True))
                together = tuple(shard // chunk for shard, chunk in zip(array.shards, array.chunks, strict=True))
                self.shardings[name] = Sharding(name, counts, together)
        self.shards.go_on(self.shardings)
        self.contents.update(self.shards.contents)

    def finish(self, names: Iterable[str]) -> None:
        """Put what is left. names : of the arrays, in the order in which libraries are to list them."""
        self._mark()
        self._consolidate(names)
        root = self._metadata.pop(ROOT)
        with ThreadPoolExecutor(_AT_ONCE) as pool:
            for _ in pool.map(self.put, self._metadata, [data.to_bytes() for data in self._metadata.values()]):
                pass
        self.put(ROOT, root.to_bytes())

    def _mark(self) -> None:
        """Add the table that binds chunks to their places."""
        group: Any = zarr.open_group(self.metadata, mode="r+")
        arrays = {name: a for name, a in group.arrays() if a.ndim and a.dtype.kind in "fiu"}
        marks = marks_of(group.attrs[SEAL], {name: (a.shape, a.chunks) for name, a in arrays.items()})
        table = marks.noted(self.contents)
        group.create_group(GROUP).create_array(TABLE, data=table, dimension_names=("chunk",))

    def _consolidate(self, names: Iterable[str]) -> None:
        """Have the root say what its arrays say of themselves, as xarray looks for it first, and warns where it is not.

        By hand, because zarr warns in turn that its third format knows no such thing: `must_understand` says that.
        """
        arrays = {name: self._json(f"{name}/{ROOT}") for name in names}
        root = self._json(ROOT)
        root["consolidated_metadata"] = {"kind": "inline", "must_understand": False, "metadata": arrays}
        self._metadata[ROOT] = default_buffer_prototype().buffer.from_bytes(json.dumps(root, indent=2).encode())

    def _json(self, key: str) -> Any:
        return json.loads(self._metadata[key].to_bytes())


class ZarrChunks(Chunks):
    """The chunks of a store that is being written, put by the threads that compress."""

    def __init__(self, store: NewZarr, threads: int | None = None) -> None:
        super().__init__(max(threads or os.cpu_count() or 1, _AT_ONCE) if store.waits else threads)
        self._group, self._store = zarr.open_group(store.metadata, mode="r"), store

    def _declared(self, name: str) -> Layout:
        array = self._group[name]
        assert isinstance(array, zarr.Array)
        fill = np.asarray(array.fill_value, array.dtype)
        return Layout(array.dtype, array.chunks, fill, pack, None, name)

    def _place(self, layout: Layout, origin: Origin, data: Packed) -> Rest:
        number, name = layout.number(origin), layout.target
        if self._store.shards and (of := self._store.shardings.get(name)):
            return partial(self._store.shards.append, of, number, data, self._contents[name, number])
        self._store.put("/".join((name, "c", *map(str, number))), data)
        return None

    def holds(self, name: str, origin: Sequence[int]) -> bool:
        """Tell whether an earlier writer has stored a chunk."""
        return (name, self.layout(name).number(origin)) in self._store.contents

    def _mark(self, contents: Contents) -> None:
        self._store.contents.update(contents)

    def _close(self) -> None:
        """There is nothing open."""


def pack(values: NDArray[Any]) -> bytes:
    """A chunk as zarr's own codecs pack it: Blosc's zstd of shuffled bytes, CRC-32C."""
    shuffle = blosc.SHUFFLE if values.dtype.itemsize > 1 else blosc.BITSHUFFLE
    data = bytes(blosc.compress(values, b"zstd", LEVEL, shuffle))
    return data + int(google_crc32c.value(data)).to_bytes(4, "little")
