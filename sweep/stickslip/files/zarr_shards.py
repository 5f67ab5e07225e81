"""Shards of a Zarr store that is written into a folder: files of many chunks, so that a map of any size has few files.

Each chunk is appended to its shard, then noted in a journal. A writer that is killed leaves both, and the next one of
the same store goes on where they agree: a write may take longer than a job.

Zarr sharding codec, version 1: chunks in any order; then, for each place in the shard, offset and length, or twice
2^64 - 1 beyond the end of the array; then the CRC-32C of these numbers.
"""

from __future__ import annotations

import json
import os
import threading
from collections.abc import Mapping
from dataclasses import dataclass
from math import prod
from pathlib import Path

import google_crc32c
import numpy as np

from stickslip.files.chunks import Contents, Origin, Packed
from stickslip.files.targets import JOURNAL

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
