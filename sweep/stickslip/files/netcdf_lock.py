"""One thread at a time in netCDF and HDF5, which are not safe for more.

xarray locks reading and writing of values, but not what it asks a file for when it opens, describes or closes it. So
whatever of ours touches a netCDF file holds NETCDF_LOCK, and what xarray does later with a file of ours (a lazy chunk,
closing, the garbage collector) takes the same lock, because it was given to it. Holding it includes holding xarray's
own lock: plain xarray in another thread waits wherever it locks at all.

Never wait for other threads while holding it: dask's read our files. `os.fork` waits for it, so that the child finds
the libraries idle and the lock free. h5py has a lock of its own, which is always taken after this one.
"""

from __future__ import annotations

import os
import threading
from typing import Any

from xarray.backends.netCDF4_ import NETCDF4_PYTHON_LOCK


class _NetcdfLock:
    """A re-entrant lock with the interface xarray asks for; a pickled one is that of the process that unpickles it."""

    def __init__(self) -> None:
        self._ours, self._xarrays, self._depth = threading.RLock(), NETCDF4_PYTHON_LOCK, 0

    def acquire(self, blocking: bool = True) -> bool:
        """Tell whether this thread holds the lock now; the garbage collector asks without blocking."""
        if not self._ours.acquire(blocking):
            return False
        try:
            free = self._depth > 0 or bool(self._xarrays.acquire(blocking))
        except BaseException:  # Ctrl-C while waiting
            self._ours.release()
            raise
        if free:
            self._depth += 1
        else:
            self._ours.release()
        return free

    def release(self) -> None:
        """Give up what one `acquire` took."""
        self._depth -= 1
        if self._depth == 0:
            self._xarrays.release()
        self._ours.release()

    def locked(self) -> bool:
        """Tell whether any thread holds it."""
        return self._depth > 0

    def __enter__(self) -> None:
        self.acquire()

    def __exit__(self, *_: Any) -> None:
        self.release()

    def __reduce__(self) -> str:
        return "NETCDF_LOCK"


NETCDF_LOCK = _NetcdfLock()


def hold_while_forking() -> None:
    """Have `os.fork` wait for the lock. What is registered last is taken first, so again after libraries with locks."""
    if hasattr(os, "register_at_fork"):
        os.register_at_fork(
            before=NETCDF_LOCK.acquire, after_in_parent=NETCDF_LOCK.release, after_in_child=NETCDF_LOCK.release
        )


hold_while_forking()
