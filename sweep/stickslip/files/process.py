"""This machine and its processes: who wrote these files, and whether they still run."""

from __future__ import annotations

import os
import socket


def host() -> str:
    """Name of this machine."""
    return socket.gethostname()


def space() -> str:
    """Within which process numbers mean something: containers may share the name of their host."""
    try:
        return os.readlink("/proc/self/ns/pid")
    except OSError:
        return ""


def is_alive(pid: int) -> bool:
    """Tell whether a process of this machine runs; True where that cannot be asked without harm (Windows)."""
    if os.name == "nt":
        return True
    if pid <= 0:  # to the system a group of processes
        return False
    try:
        os.kill(pid, 0)
    except (ProcessLookupError, OverflowError):
        return False
    except OSError:
        return True
    return True


def processors() -> int:
    """Processors this process may use."""
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1
