"""Whole commands, from the shell to the prompt, beside the time the kernels take: what a user waits for.

    python benchmarks/whole.py [--large]      # about a minute; with maps of 1e7 cells, and Dask, about three

Kernels are in the cache, and modules compiled, as `pip` and a first run leave them. The kernels' time is that of
`engine.compute` for the same cells on all threads, in turns with the commands; what is asked of maps, and of the CPU
time of nine cells, is a ratio to its CPU time on one thread (P2's, for a million cells).
"""

from __future__ import annotations

import json
import os
import re
import resource
import subprocess
import sys
import tempfile
from collections.abc import Callable, Iterator
from functools import partial
from itertools import count as naturals
from pathlib import Path
from statistics import median
from time import perf_counter

import numpy as np

import problem
from measure import Job, interleave
from startup import map_config
from stickslip.config.resolve import config_path

OF_MAP, OF_NINE = 2.0, 0.6  # times P2, asked
QUICKSTART, HELP, LOOK, CALL = 1.2, 0.15, 1.0, 200e-6  # s, asked
FEW = 10  # cells of a call

LOOK_INTO = """
import sys, time
from stickslip import plots
from stickslip.files import reading
began = time.perf_counter()
with reading.look_into(sys.argv[1]) as ds:
    plots.save(plots.plot_map(ds), "look.png")
print(time.perf_counter() - began)
"""


def command(folder: str, *words: str) -> str:
    """Run a command in a process of its own; what it prints."""
    path = os.pathsep.join(os.path.abspath(entry) for entry in sys.path if entry)
    environment = {name: value for name, value in os.environ.items() if name != "PYTHONDONTWRITEBYTECODE"}
    environment |= {"PYTHONPATH": path}
    done = subprocess.run([sys.executable, *words], cwd=folder, env=environment, capture_output=True, text=True)
    if done.returncode:
        raise RuntimeError(f"{' '.join(words)}\n{done.stdout}{done.stderr}")
    return done.stdout


def stickslip(folder: str, *words: str) -> str:
    return command(folder, "-m", "stickslip", *words)


def cpu_seconds(folder: str, *words: str) -> float:
    """CPU time of a command, processes it started included."""
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    stickslip(folder, *words)
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    return after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime


def maps(folder: str, side: int, repeats: int) -> Iterator[dict]:
    """A map of side x side cells into both kinds of files, with its plot; one of nine cells."""
    (Path(folder) / "map.yaml").write_text(map_config(side))
    (Path(folder) / "nine.yaml").write_text(map_config(3))
    cells, nine = problem.grid(side), []
    jobs = {
        "kernels": Job(partial(problem.compute, cells, rtol=1e-6), repeats),
        "alone": Job(partial(problem.compute, cells, rtol=1e-6, threads=1), repeats),
        "nine": Job(lambda: nine.append(cpu_seconds(folder, "run", "nine.yaml", "-o", "nine.nc", "--fresh")), repeats),
    }
    for kind in ("nc", "zarr"):
        words = ("run", "map.yaml", "-o", f"map.{kind}", "--plot", "map.png", "--fresh")
        jobs[kind] = Job(partial(stickslip, folder, *words), repeats)
    interleave(list(jobs.values()))
    kernels, alone = median(jobs["kernels"].timings.wall), median(jobs["alone"].timings.cpu)
    if len(cells) == 1_000_000:  # P2
        yield row("nine cells, .nc, CPU time", nine, OF_NINE * alone)
    for kind in ("nc", "zarr"):
        what = f"map of {len(cells):,} cells, .{kind} and plot"
        yield row(what, jobs[kind].timings.wall, OF_MAP * alone, kernels)


def row(what: str, seconds: list[float], asked: float | None, kernels: float | None = None) -> dict:
    return {"what": what, "seconds": median(seconds), "most": max(seconds), "asked": asked, "kernels": kernels}


def timed(action: Callable[[], object], repeats: int) -> list[float]:
    action()  # caches of the file system
    job = Job(action, repeats)
    interleave([job])
    return job.timings.wall


def call() -> dict:
    """`evaluate` of a few cells."""
    import stickslip

    speeds = np.linspace(0.05, 0.5, FEW)
    cells = {"mass": 1.0, "stiffness": 1.0, "normal_load": 1.0, "belt_speed": speeds}
    cells |= {"a1": problem.A1, "a2": problem.A2, "a3": problem.A3, "a4": problem.A4}
    several = timed(lambda: [stickslip.evaluate(cells) for _ in range(100)], 7)
    return row(f"evaluate, {FEW} cells", [seconds / 100 for seconds in several], CALL)


def dask(folder: str) -> dict:
    """Cells a second on two workers of one thread each over those on two threads, both as the command says."""
    rates = {}
    for name, words in {"threads": (), "dask": ("--dask", "local")}.items():
        said = stickslip(folder, "run", "map.yaml", "-o", f"{name}.nc", "--fresh", *words)
        rates[name] = float(re.search(r"([\d,]+) cells/s", said)[1].replace(",", ""))
    return rates | {"ratio": rates["dask"] / rates["threads"]}


def measure(large: bool = False, repeats: int = 5) -> dict:
    """Rows of what was waited for, and of Dask if `large`."""
    found: dict = {"rows": [], "dask": None}
    with tempfile.TemporaryDirectory() as folder:
        fresh = naturals()
        quick = str(config_path("quickstart"))
        rows = found["rows"]
        rows.append(row("stickslip --help", timed(partial(stickslip, folder, "--help"), repeats), HELP))
        words = lambda: ("run", quick, "-o", f"quick{next(fresh)}.nc")  # noqa: E731
        rows.append(row("quickstart", timed(lambda: stickslip(folder, *words()), repeats), QUICKSTART))
        rows += maps(folder, 1000, repeats)
        rows.append(call())
        if large:
            rows += maps(folder, 3162, 2)
            looks = [float(command(folder, "-c", LOOK_INTO, "map.nc")) for _ in range(3)]
            rows.append(row("opening a map of 9,998,244 cells and drawing it", looks, LOOK))
            found["dask"] = dask(folder)
    return found


def main() -> None:
    began = perf_counter()
    print(json.dumps(measure("--large" in sys.argv[1:]), indent=1))
    print(f"{perf_counter() - began:.0f} s", file=sys.stderr)


if __name__ == "__main__":
    main()
