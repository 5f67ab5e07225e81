"""What happens in separate processes: start-up, first compilation, peak memory."""

from __future__ import annotations

import json
import os
import subprocess
import sys
import tempfile
import time
from pathlib import Path
from statistics import median

HERE = Path(__file__).parent

# The command `stickslip run configs/quickstart.yaml`, left when its first block is finished.
FIRST_BLOCK = """
import os, sys
from stickslip.engine import cells
finished = cells.to_si
def leave(*arguments):
    finished(*arguments)
    os._exit(0)
cells.to_si = leave
from stickslip.cli import main
sys.argv = ["stickslip", "run", {config!r}]
main()
"""

COMPILE = """
import time
began = time.perf_counter()
from stickslip import engine
imported = time.perf_counter()
engine.warm_up()
print(imported - began, time.perf_counter() - imported)
"""

# A map as a user computes it: from a configuration into a file.
MEMORY = """
import sys
sys.path.insert(0, {here!r})
import stickslip
from startup import map_config, peak_memory
from stickslip.config.reader import parse_config
for n in (16, {n}):
    before = peak_memory()
    config = parse_config(map_config(n))
    stickslip.run(config, "map%d.nc" % n)
print(before, peak_memory())
"""


def map_config(n: int) -> str:
    """The plain map of P2, n x n cells, as a configuration."""
    from problem import A1, A2, A3, A4

    return f"""
title: Plain map
system: {{mass: 1, normal_load: 1}}
friction: {{a1: {A1}, a2: {A2}, a3: {A3}, a4: {A4}}}
axes:
  stiffness: {{start: 0.1, stop: 100, num: {n}, spacing: log}}
  belt_speed: {{start: 0.02, stop: 0.6, num: {n}}}
"""


def peak_memory() -> int:
    """Most bytes this process has held. On Linux not by getrusage, which counts the parent before exec."""
    try:
        for line in Path("/proc/self/status").read_text().splitlines():
            if line.startswith("VmHWM"):
                return 1024 * int(line.split()[1])
    except OSError:
        pass
    import resource

    most = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    return most if sys.platform == "darwin" else 1024 * most


def python(script: str, folder: str | None = None, **environment: str) -> str:
    path = os.pathsep.join(
        os.path.abspath(entry) for entry in sys.path if entry
    )  # a relative PYTHONPATH must hold there too
    full = os.environ | {"PYTHONPATH": path} | environment
    return subprocess.run(
        [sys.executable, "-c", script], env=full, cwd=folder, check=True, capture_output=True, text=True
    ).stdout


def first_block(repeats: int = 3) -> dict[str, float]:
    """Seconds from the shell to the first block of a quickstart whose kernels are compiled."""
    from stickslip.config.resolve import config_path

    seconds = []
    script = FIRST_BLOCK.format(config=str(config_path("quickstart")))
    for _ in range(repeats + 1):
        with tempfile.TemporaryDirectory() as folder:
            began = time.perf_counter()
            python(script, folder)
            seconds.append(time.perf_counter() - began)
    seconds.pop(0)  # may have compiled
    return {"seconds": median(seconds), "worst": max(seconds)}


def first_compile() -> dict[str, float]:
    """Seconds of import, and of compiling the kernels into an empty cache."""
    with tempfile.TemporaryDirectory() as folder:
        imported, compiled = map(float, python(COMPILE, NUMBA_CACHE_DIR=folder).split())
        again = float(python(COMPILE, NUMBA_CACHE_DIR=folder).split()[1])
    return {"import": imported, "compile": compiled, "load_from_cache": again}


def memory(n: int) -> dict[str, float]:
    """Peak memory of a run of n x n cells into a file: all of the process, and what the cells added."""
    with tempfile.TemporaryDirectory() as folder:
        before, after = map(float, python(MEMORY.format(here=str(HERE), n=n), folder).split())
    cells = n * n
    return {"cells": cells, "peak_bytes": after, "bytes_per_cell": (after - before) / cells}


if __name__ == "__main__":
    print(json.dumps([first_block(), first_compile(), memory(1000)], indent=1))
