"""The chunks of a Zarr store: each is a file or an object, `NAME/c/2/0`; in a folder many share a shard, so that a map
of any size has few files.

Each chunk is appended to its shard, then noted in a journal. A writer that is killed leaves both, and the next one of
the same store goes on where they agree: a write may take longer than a job.

Zarr core specification, version 3: "default" chunk keys; codecs `bytes` (little-endian), `blosc`, `crc32c`. Sharding
codec, version 1: chunks in any order; then, for each place in the shard, offset and length, or twice 2^64 - 1 beyond
the end of the array; then the CRC-32C of these numbers.
"""

from __future__ import annotations

import json
import os
import threading
from collections.abc import Callable, Iterable, Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, field
from functools import partial
from math import prod
from pathlib import Path
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
from stickslip.files.targets import JOURNAL

LEVEL = 3  # of zstd: 5 takes nearly three times as long, for stores that are 7 % smaller
_AT_ONCE = 8  # objects that are put while others wait for an answer


@dataclass(frozen=True)
class NewZarr:
    """A Zarr store that is being written.

    put : stores bytes under a key, by any thread.
    shards : in a folder; None behind a URL, where each chunk is an object of its own.

    Chunks are put as they come. What the store says of itself is kept in memory until `finish` puts it, the root last:
    before that, nobody takes it for a store.
    """

    put: Callable[[str, Packed], None]
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
        group.create_group(GROUP).create_array(
            TABLE, data=table, chunks=(max(table.size, 1),), dimension_names=("chunk",)
        )

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
        super().__init__(threads if store.shards else max(threads or os.cpu_count() or 1, _AT_ONCE))
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


# --- shards -----------------------------------------------------------------------------------------------------------


_NOTHING = 2**64 - 1
_CHECKSUM = 4  # bytes: CRC-32C, little-endian


@dataclass(frozen=True)
class Sharding:
    """The shards of a variable. chunks : of the variable along each dimension. together : of a shard, likewise."""

    name: str
    chunks: tuple[int, ...]
    together: tuple[int, ...]

    def key(self, number: Origin) -> str:
        """The shard of a chunk."""
        return "/".join((self.name, "c", *(str(i // n) for i, n in zip(number, self.together, strict=True))))

    def slot(self, number: Origin) -> int:
        """The place of a chunk in the index of its shard."""
        inside = tuple(i % n for i, n in zip(number, self.together, strict=True))
        return int(np.ravel_multi_index(inside, self.together))

    def filled(self, number: Origin) -> int:
        """The number of chunks in the shard of this one: fewer at the end of the array."""
        sides = zip(number, self.together, self.chunks, strict=True)
        return prod(min(n, count - i // n * n) for i, n, count in sides)


class Shards:
    """The shards of a store in a folder; chunks are appended by any thread.

    of : what identifies the values that are written. contents : of all chunks that are there.
    """

    def __init__(self, folder: Path, of: str) -> None:
        self.contents: Contents = {}
        self._folder, self._journal, self._lock = folder, folder / JOURNAL, threading.Lock()
        self._shards: dict[str, dict[int, tuple[int, int]]] = {}  # by key and slot: offset and length
        if not is_begun(folder, of):
            folder.mkdir(exist_ok=True)
            self._journal.write_text(json.dumps(of) + "\n")

    def go_on(self, shardings: Mapping[str, Sharding]) -> None:
        """Take over the chunks that an earlier writer left, as far as notes and checksums go."""
        with open(self._journal, "r+b") as journal:
            journal.readline()
            good = journal.tell()
            while (line := journal.readline()).endswith(b"\n"):
                try:
                    name, number, offset, length, content = json.loads(line)
                    of, number = shardings[name], tuple(number)
                    data = self._read(of.key(number), offset, length)
                except (ValueError, KeyError, TypeError):  # a note that a power failure spoiled
                    break
                if int.from_bytes(data[-_CHECKSUM:], "little") != google_crc32c.value(data[:-_CHECKSUM]):
                    break
                self._enter(of, number, offset, length, bytes.fromhex(content))
                good = journal.tell()
            journal.truncate(good)

    def append(self, of: Sharding, number: Origin, data: Packed, content: bytes) -> None:
        """Store a packed chunk at the end of its shard, and after the last one the index of the shard."""
        with self._lock:
            end = _end(self._shards.get(of.key(number), {}))
            self._write(of.key(number), end, data)
            with open(self._journal, "a", encoding="utf-8") as journal:
                journal.write(json.dumps([of.name, number, end, len(data), content.hex()]) + "\n")
            self._enter(of, number, end, len(data), content)

    def _enter(self, of: Sharding, number: Origin, offset: int, length: int, content: bytes) -> None:
        entries = self._shards.setdefault(of.key(number), {})
        entries[of.slot(number)] = offset, length
        self.contents[of.name, number] = content
        if len(entries) == of.filled(number):
            index = np.full((prod(of.together), 2), _NOTHING, "<u8")
            index[[*entries]] = [*entries.values()]
            checksum = int(google_crc32c.value(index.tobytes())).to_bytes(_CHECKSUM, "little")
            self._write(of.key(number), _end(entries), index.tobytes() + checksum)

    def _write(self, key: str, offset: int, data: Packed) -> None:
        """Write the end of a shard, whatever was there: of a writer that was killed before it noted that."""
        path = self._folder / key
        path.parent.mkdir(parents=True, exist_ok=True)
        with open(os.open(path, os.O_RDWR | os.O_CREAT | getattr(os, "O_BINARY", 0), 0o666), "r+b") as file:
            file.truncate(offset)
            file.seek(offset)
            file.write(data)

    def _read(self, key: str, offset: int, length: int) -> bytes:
        try:
            with open(self._folder / key, "rb") as file:
                file.seek(offset)
                return file.read(length)
        except FileNotFoundError:
            return b"no chunk"


def is_begun(folder: Path, of: str) -> bool:
    """Tell whether a folder holds the beginning of a store."""
    try:
        with open(folder / JOURNAL, encoding="utf-8") as journal:
            return journal.readline() == json.dumps(of) + "\n"
    except (OSError, ValueError):
        return False


def _end(entries: Mapping[int, tuple[int, int]]) -> int:
    return max((offset + length for offset, length in entries.values()), default=0)
