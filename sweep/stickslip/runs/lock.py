"""Who works on a store: a file per run or shard, refreshed while it works.

A whole run wants the store for itself; shards share it, each with its own file. A lock is stale once its process is
gone from this machine, or once it has not been refreshed for `PATIENCE`: then it is taken over. A run that finds its
lock taken over (after suspension, say) stops. Should two ever work at once nevertheless, they write the same bits.
"""

from __future__ import annotations

import getpass
import json
import os
import re
import threading
import time
import uuid
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from dataclasses import asdict, dataclass
from datetime import datetime

from stickslip.errors import StoreError, visible
from stickslip.files.targets import Folder, host, is_alive, space
from stickslip.runs.work import Shard

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
