"""Replacing a Zarr store behind a URL. Services that keep objects have no rename (`atomic.py`), but copy by themselves.

A new store is written beside its place, under `.NAME.new`. Once it is whole, its objects are copied to its place: the
root, without which nobody sees a store there, is removed first and written last. Whoever is killed in between leaves
the new one whole, and `finish` goes on from there. One process at a time writes (`runs/workdir/lock.py`).
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress

from stickslip.errors import StoreError
from stickslip.files.locations import ROOT, Url
from stickslip.files.remote import RemoteFolder


@contextmanager
def replaced_store(target: Url) -> Iterator[Callable[[str, bytes], None]]:
    """What puts the bytes of a new store, to be written inside `with`, its root last; at the end it replaces `target`.

    Whatever goes wrong leaves `target` alone, but for what goes wrong while objects are copied. Raises StoreError.
    """
    _check(target)
    if is_unfinished(target):
        finish(target)
    new = _new(target)
    _clear(new)
    keys = set[str]()

    def put(key: str, data: bytes) -> None:
        new.write(key, bytes(data))
        keys.add(key)

    try:
        yield put
    except BaseException:
        with suppress(StoreError):  # of what went wrong, the first is told
            _clear(new)
        raise
    _swap(new, target.folder(), keys)


def check_writable(target: Url) -> None:
    """Raise StoreError now if `replaced_store` would fail later."""
    _check(target)
    probe, new = "probe", _new(target)
    new.write(probe, b"")
    new.remove(probe)


def is_unfinished(target: Url) -> bool:
    """Whether a writer was killed, or is at work, when its new store was whole and not yet in its place."""
    return _new(target).has(ROOT) and not target.exists()


def finish(target: Url) -> None:
    """Put a new store in its place that is whole."""
    new = _new(target)
    _swap(new, target.folder(), set(new.keys()))


def _swap(new: RemoteFolder, target: RemoteFolder, keys: set[str]) -> None:
    target.remove(ROOT)
    new.copy(sorted(keys - {ROOT}), target)
    if older := set(target.keys()) - keys:
        target.remove(*older)
    new.copy([ROOT], target)
    _clear(new)


def _clear(folder: RemoteFolder) -> None:
    """Remove all objects, the root first: what is left is not whole."""
    folder.remove(ROOT)
    if keys := folder.keys():
        folder.remove(*keys)


def _check(target: Url) -> None:
    """Raise StoreError if something else than a store of ours, or a part of one, has the name of the target."""
    if not target.exists() and target.folder().keys() and not _new(target).has(ROOT):
        raise StoreError(f"{target}: exists and is not a Zarr store, so it is left alone")


def _new(target: Url) -> RemoteFolder:
    return target.with_name(f".{target.name}.new").folder()
