"""The files of a working store: its manifest, the blocks, which a reader accepts only after checking them, and locks.

The manifest says what is computed, cut how, by what. It is JSON with a checksum of its own, written before the first
block and changed only when other kernels resume the run. All in it but the versions follows from the configuration.

A block is

    a line that names the format | header, a line of JSON | columns | SHA-256 of all before

Everything is little-endian; a column is one value that all cells share (NaN, mostly), or packed as the header says: as
a chunk of the file that is to be written, so that it goes there as it is (`files/chunks.py`).

A lock says who works on a store: a file per run or shard, refreshed while it works. A whole run wants the store for
itself; shards share it, each with its own file. A lock is stale once its process is gone from this machine, or once it
has not been refreshed for `PATIENCE`: then it is taken over. A run that finds its lock taken over (after suspension,
say) stops. Should two ever work at once nevertheless, they write the same bits.
"""

from __future__ import annotations

import getpass
import hashlib
import json
import os
import re
import threading
import time
import uuid
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager, suppress
from dataclasses import asdict, astuple, dataclass, fields
from datetime import UTC, datetime
from typing import Any

import numpy as np
from numpy.typing import NDArray

from stickslip._version import __version__
from stickslip.engine import kernels_digest
from stickslip.errors import DamagedBlockError, DamagedManifestError, StoreError, visible
from stickslip.files.chunks import PLAIN, packed, unpacked
from stickslip.files.targets import Folder, host, is_alive, space
from stickslip.runs.work import Blocks, Shard, Work, fingerprint

MANIFEST = "manifest.json"
FORMAT = 2
_MAGIC = b"stickslip block 2\n"
_TYPES = ("|i1", "<i4", "<f8")  # of columns; nothing else is read
_DIGEST = 32
_ONE = "one value"
Header = dict[str, Any]


# --- the manifest -----------------------------------------------------------------------------------------------------


@dataclass(frozen=True)
class Manifest:
    """The manifest of a store.

    fingerprint : of everything that the numbers depend on. configuration : resolved, as YAML text. cut : into blocks,
    as arguments of `Blocks`. kernels : digests of those that computed blocks, in the order they came.
    written_in : units of the configuration. fresh : begun to replace whatever result there is, and not finished.
    shards : into how many the blocks are dealt, by the last who worked on them; 0 for a whole run.
    """

    fingerprint: str
    configuration: str
    cut: tuple[int, int, int]
    kernels: tuple[str, ...]
    stickslip: str
    created: str
    written_in: Mapping[str, str]
    fresh: bool = False
    shards: int = 0
    format: int = FORMAT

    @classmethod
    def of(cls, work: Work, fresh: bool = False) -> Manifest:
        """That of a store which this process begins."""
        config, created = work.config, datetime.now(UTC).strftime("%Y-%m-%dT%H:%M:%SZ")
        return cls(
            fingerprint(config), config.to_yaml(), astuple(work.blocks), (kernels_digest(),), __version__, created,
            config.written_in, fresh,
        )  # fmt: skip

    @property
    def blocks(self) -> Blocks:
        """The cells, cut into blocks."""
        return Blocks(*self.cut)

    def encoded(self) -> bytes:
        """Its bytes."""
        plain = asdict(self)
        return json.dumps({**plain, "checksum": _checksum(plain)}, indent=1, ensure_ascii=False).encode()


def decoded(data: bytes) -> Manifest:
    """The manifest these bytes are. Raises DamagedManifestError; other formats are read as far as they say so."""
    try:
        plain = json.loads(data.decode())
        is_whole = plain.pop("checksum") == _checksum(plain)
        known = {field.name: plain[field.name] for field in fields(Manifest) if field.name in plain}
        manifest = Manifest(**known | {name: tuple(known[name]) for name in ("cut", "kernels")})
    except (ValueError, KeyError, TypeError, AttributeError, RecursionError):
        raise DamagedManifestError("it is not whole") from None
    if not is_whole:
        raise DamagedManifestError("its checksum does not match")
    return manifest


def _checksum(plain: Mapping[str, Any]) -> str:
    text = json.dumps(plain, sort_keys=True, ensure_ascii=False)
    return hashlib.sha256(text.encode()).hexdigest()


# --- blocks -----------------------------------------------------------------------------------------------------------


@dataclass(frozen=True)
class StoredColumn:
    """A column as it is stored. packing : of `data`, which may hold more than the values of its `cells`."""

    dtype: np.dtype[Any]
    cells: int
    packing: str
    data: memoryview

    def is_one_value(self) -> bool:
        """Tell whether all cells share one value, and `data` is that."""
        return self.packing == _ONE

    def values(self) -> NDArray[Any]:
        """One value per cell. Raises ValueError for data that are not of that kind."""
        if self.is_one_value():
            return np.broadcast_to(np.frombuffer(self.data, self.dtype), self.cells)
        values = unpacked(self.data, self.packing, self.dtype)[: self.cells]
        if values.size < self.cells:
            raise ValueError("more cells than data")
        return values


def column(values: NDArray[Any], packing: str = PLAIN, length: int = 0) -> StoredColumn:
    """Values as they are stored; those of a chunk are filled up to `length`."""
    plain = np.ascontiguousarray(values, values.dtype.newbyteorder("<"))
    bits = plain.view(f"u{plain.itemsize}")  # NaN may be shared
    if plain.size > 1 and bits[0] == bits[-1] and (bits == bits[0]).all():
        return StoredColumn(plain.dtype, plain.size, _ONE, memoryview(plain[:1].tobytes()))
    whole = plain
    if packing != PLAIN and plain.size < length:
        whole = np.concatenate([plain, np.zeros(length - plain.size, plain.dtype)])
    return StoredColumn(plain.dtype, plain.size, packing, memoryview(packed(whole, packing)))  # type: ignore[arg-type]


def block_bytes(
    header: Mapping[str, Any], results: Mapping[str, NDArray[Any]], packing: str = PLAIN, length: int = 0
) -> bytes:
    """The bytes of a block file: `header` as JSON, columns of results, packed as chunks of `length` cells."""
    stored = {name: column(values, packing, length) for name, values in results.items()}
    about = [
        {"name": name, "type": c.dtype.str, "cells": c.cells, "packing": c.packing, "bytes": c.data.nbytes}
        for name, c in stored.items()
    ]
    text = json.dumps({**header, "columns": about}).encode()
    whole = b"".join([_MAGIC, text, b"\n", *(c.data for c in stored.values())])
    return whole + hashlib.sha256(whole).digest()


def opened_block(data: bytes) -> tuple[Header, dict[str, StoredColumn]]:
    """Header and columns of a block file, checked. Raises DamagedBlockError."""
    if not data.startswith(_MAGIC):
        raise DamagedBlockError("it is not a block file")
    body = memoryview(data)[:-_DIGEST]
    if hashlib.sha256(body).digest() != data[-_DIGEST:]:
        raise DamagedBlockError("its checksum does not match")
    try:
        begin = data.index(b"\n", len(_MAGIC)) + 1
        header = json.loads(data[len(_MAGIC) : begin])
        return header, _columns(header.pop("columns"), body[begin:])
    except (ValueError, KeyError, TypeError, AttributeError, ArithmeticError, RecursionError) as error:
        raise DamagedBlockError(f"its header is invalid ({error})") from None


def _columns(described: list[Header], data: memoryview) -> dict[str, StoredColumn]:
    stored, place = {}, 0
    for about in described:
        if about["type"] not in _TYPES:
            raise ValueError(f"a column of type {about['type']!r}")
        dtype, end = np.dtype(about["type"]), place + int(about["bytes"])
        if not place <= end <= len(data):
            raise ValueError("more columns than data")
        packing, cells = str(about["packing"]), int(about["cells"])
        stored[str(about["name"])] = StoredColumn(dtype, cells, packing, data[place:end])
        place = end
    if place != len(data):
        raise ValueError("more data than columns")
    return stored


# --- locks ------------------------------------------------------------------------------------------------------------


WHOLE = "lock.json"
REFRESH, PATIENCE = 10.0, 120.0  # s
_LONGEST = 100  # characters of a name that is shown
Notice = Callable[[str], None]


@dataclass(frozen=True)
class Holder:
    """Who holds a lock. `seen` and `since` count seconds since 1970, by the clock of its machine."""

    token: str
    host: str
    space: str
    pid: int
    user: str
    since: float
    seen: float

    @property
    def stale(self) -> bool:
        """Tell whether no process can be working under this lock any more."""
        here = (self.host, self.space) == (host(), space())
        return (here and not is_alive(self.pid)) or abs(time.time() - self.seen) > PATIENCE

    def __str__(self) -> str:
        since = datetime.fromtimestamp(self.since).astimezone().strftime("%Y-%m-%d %H:%M:%S")
        age = max(0.0, time.time() - self.seen)
        who = f"{self.user!s:.{_LONGEST}} on {self.host!s:.{_LONGEST}}"
        return visible(f"{who}, process {self.pid}, since {since} (last seen {age:.0f} s ago)")


def name_of(shard: Shard | None) -> str:
    """The name of the lock of a shard, or of a whole run."""
    return WHOLE if shard is None else f"lock-{shard.number}-of-{shard.count}.json"


def shard_of(name: str) -> Shard | None:
    """The shard whose lock has this name; None for a whole run."""
    match = re.fullmatch(r"lock-(\d+)-of-(\d+)\.json", name)
    shard = Shard(int(match[1]), int(match[2])) if match else None
    return shard if shard and 1 <= shard.number <= shard.count else None


def is_lock(name: str) -> bool:
    """Tell whether a file of this name is a lock."""
    return name == WHOLE or shard_of(name) is not None


def holders(folder: Folder) -> dict[str, Holder]:
    """Who holds what, stale locks included."""
    locks = {name: _read(folder, name) for name in folder.names() if is_lock(name)}
    return {name: holder for name, holder in locks.items() if holder}


@contextmanager
def hold_lock(folder: Folder, shard: Shard | None, lost: Callable[[], None], notice: Notice) -> Iterator[Lock]:
    """Hold the lock of a whole run or of a shard. Raises StoreError if another run works there.

    lost : called from another thread if the lock is taken over.
    """
    lock = Lock(folder, name_of(shard), lost)
    _make_room(folder, lock, notice)
    try:
        folder.create(lock.name, lock.content())
    except FileExistsError:
        _make_room(folder, lock, notice)
        raise StoreError(f"{folder.where}: another run has just begun there\nhint: see stickslip status") from None
    try:
        _make_room(folder, lock, notice)  # whoever came in between sees this lock as well, and one of both gives way
        with lock.refreshed():
            yield lock
    finally:
        lock.release()
        folder.rmdir()  # nothing is left of a run that was refused


class Lock:
    """The lock of this process."""

    def __init__(self, folder: Folder, name: str, lost: Callable[[], None]) -> None:
        now = time.time()
        self.folder, self.name, self._lost = folder, name, lost
        self.holder = Holder(uuid.uuid4().hex, host(), space(), os.getpid(), _user(), now, now)

    def content(self) -> bytes:
        """The bytes of the file, as of now."""
        return json.dumps({**asdict(self.holder), "seen": time.time()}).encode()

    @property
    def ours(self) -> bool:
        """Tell whether the file still names this process."""
        holder = _read(self.folder, self.name)
        return holder is not None and holder.token == self.holder.token

    @contextmanager
    def refreshed(self) -> Iterator[None]:
        """Refresh the file from a thread."""
        over = threading.Event()

        def refresh() -> None:
            while not over.wait(REFRESH):
                with suppress(OSError):  # a full disk, a network that is away: the blocks will tell
                    if not self.ours:
                        return self._lost()
                    self.folder.write(self.name, self.content())

        thread = threading.Thread(target=refresh, name="lock", daemon=True)
        thread.start()
        try:
            yield
        finally:
            over.set()
            thread.join()

    def release(self) -> None:
        """Remove the file, if it is still ours."""
        with suppress(StoreError):
            if self.ours:
                self.folder.remove(self.name)


def _make_room(folder: Folder, lock: Lock, notice: Notice) -> None:
    """Refuse if others work there that exclude this lock; remove stale locks."""
    for name in filter(is_lock, folder.names()):
        if (name != lock.name and WHOLE not in (name, lock.name)) or (name == lock.name and lock.ours):
            continue
        holder = _read(folder, name)
        if holder and not holder.stale:
            raise StoreError(
                f"{folder.where}: another run works there: {holder}\n"
                "hint: wait for it or stop it; a run that has died is noticed at once on its machine, "
                f"elsewhere {PATIENCE / 60:.0f} minutes after its last heartbeat"
            )
        if holder:  # else gone in between, or not whole: a power cut, since locks are written at once
            notice(f"took over from a run that has died: {holder}")
        folder.remove(name)


def _read(folder: Folder, name: str) -> Holder | None:
    """The holder of a lock; None if there is none or it cannot be read."""
    try:
        plain = json.loads(folder.read(name))
        numbers = {"pid": int(plain["pid"]), "since": float(plain["since"]), "seen": float(plain["seen"])}
        for name in ("since", "seen"):
            datetime.fromtimestamp(numbers[name]).astimezone()  # raises for what is no time
        return Holder(**{**plain, **numbers})
    except StoreError:
        raise
    except (OSError, ValueError, TypeError, KeyError, ArithmeticError, RecursionError):
        return None


def _user() -> str:
    try:
        return getpass.getuser()
    except (KeyError, OSError):  # a container without a list of users
        return f"user {os.getuid()}" if hasattr(os, "getuid") else "somebody"
