"""What happens in processes of their own: start-up, first compilation, peak memory."""

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
from stickslip import engine
finished = engine.to_si
def leave(*arguments):
    finished(*arguments)
    os._exit(0)
engine.to_si = leave
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

MEMORY = """
import sys
sys.path.insert(0, {here!r})
import problem
from startup import peak_memory
problem.compute(problem.grid(16), rtol=1e-6)
before = peak_memory()
problem.compute(problem.grid({n}), rtol=1e-6)
print(before, peak_memory())
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
    from stickslip.resources import config_path

    seconds = []
    with tempfile.TemporaryDirectory() as folder:
        script = FIRST_BLOCK.format(config=str(config_path("quickstart")))
        python(script, folder)  # compiles, if nobody has
        for _ in range(repeats):
            began = time.perf_counter()
            python(script, folder)
            seconds.append(time.perf_counter() - began)
    return {"seconds": median(seconds), "worst": max(seconds)}


def first_compile() -> dict[str, float]:
    """Seconds of import, and of compiling the kernels into an empty cache."""
    with tempfile.TemporaryDirectory() as folder:
        imported, compiled = map(float, python(COMPILE, NUMBA_CACHE_DIR=folder).split())
        again = float(python(COMPILE, NUMBA_CACHE_DIR=folder).split()[1])
    return {"import": imported, "compile": compiled, "load_from_cache": again}


def memory(n: int) -> dict[str, float]:
    """Peak memory of a P2 map of n x n cells: all of the process, and what the cells added."""
    before, after = map(float, python(MEMORY.format(here=str(HERE), n=n)).split())
    cells = n * n
    return {"cells": cells, "peak_bytes": after, "bytes_per_cell": (after - before) / cells}


if __name__ == "__main__":
    print(json.dumps([first_block(), first_compile(), memory(1000)], indent=1))
