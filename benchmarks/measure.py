"""Timing: CPU and wall seconds of one call, repetitions interleaved, medians with spread; and what machine this is."""

from __future__ import annotations

import os
import platform
import time
from collections.abc import Callable
from dataclasses import dataclass, field
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path
from statistics import median
from typing import Any

import llvmlite.binding as llvm

from stickslip_kernels import objects


@dataclass
class Timings:
    """Seconds of each repetition. `cpu` adds up over threads: on one thread it leaves out other processes."""

    wall: list[float] = field(default_factory=list)
    cpu: list[float] = field(default_factory=list)

    def rate(self, count: int, threads: int = 1) -> float:
        return count / median(self.cpu if threads == 1 else self.wall)

    def spread(self, threads: int = 1) -> float:
        """Half the range of the repetitions over their median."""
        seconds = self.cpu if threads == 1 else self.wall
        return (max(seconds) - min(seconds)) / 2 / median(seconds)


def timed(action: Callable[[], Any], timings: Timings) -> Any:
    wall, cpu = time.perf_counter(), time.process_time()
    result = action()
    timings.cpu.append(time.process_time() - cpu)
    timings.wall.append(time.perf_counter() - wall)
    return result


@dataclass
class Job:
    """Something to time `repeats` times. result : what its last call returned."""

    action: Callable[[], Any]
    repeats: int
    timings: Timings = field(default_factory=Timings)
    result: Any = None


def interleave(jobs: list[Job], tell: Callable[[str], None] = lambda text: None) -> None:
    """Every job once, then every job again: a temporary disturbance of the machine affects all alike."""
    for turn in range(max((job.repeats for job in jobs), default=0)):
        tell(f"  repetition {turn + 1}")
        for job in jobs:
            if turn < job.repeats:
                job.result = timed(job.action, job.timings)
                stated = getattr(job.result, "seconds", None)
                if stated is not None:  # computed in another process
                    job.timings.cpu[-1] = job.timings.wall[-1] = stated


def machine() -> dict[str, Any]:
    names = {}
    info = Path("/proc/cpuinfo")
    if info.exists():
        for line in info.read_text().splitlines():
            key, _, value = line.partition(":")
            names.setdefault(key.strip(), value.strip())
    family = ", family {cpu family} model {model}".format_map(names) if "cpu family" in names else ""
    vectors = [flag for flag in ("avx512f", "avx2", "fma") if flag in names.get("flags", "").split()]
    packages = {}
    for package in ("numba", "numpy", "scipy", "heyoka", "numbalsoda", "jax", "diffrax", "emcee", "stickslip"):
        try:
            packages[package] = version(package)
        except PackageNotFoundError:
            continue
    return {
        "processor": names.get("model name", platform.processor() or platform.machine()) + family,
        "vector_instructions": vectors,
        "kernels": objects.shipped_kind() or os.environ.get("NUMBA_CPU_NAME") or llvm.get_host_cpu_name(),
        "cores": len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count(),
        "load_at_start": round(os.getloadavg()[0], 2) if hasattr(os, "getloadavg") else None,
        "python": platform.python_version(),
        "packages": packages,
        "date": time.strftime("%Y-%m-%d %H:%M UTC", time.gmtime()),
    }
