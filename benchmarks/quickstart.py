"""Cells per second of the quickstart map, kernels only and the whole run with its file.

    python benchmarks/quickstart.py [repeats]

Prints the best of the repeats for one thread and for all processors.
"""

from __future__ import annotations

import sys
import tempfile
from dataclasses import replace
from pathlib import Path
from time import perf_counter

import stickslip
from stickslip import engine
from stickslip.api import options_of
from stickslip.grid import build_grid
from stickslip.resources import config_path


def best(action, repeats):
    """Shortest time of several: the one the machine disturbed least."""
    times = []
    for _ in range(repeats):
        began = perf_counter()
        action()
        times.append(perf_counter() - began)
    return min(times)


def main(repeats: int = 5) -> None:
    config = stickslip.load_config(config_path("quickstart"))
    grid, options = build_grid(config), options_of(config)
    began = perf_counter()
    engine.warm_up()
    print(f"{grid.size:,} cells, rtol {options.rtol:g}; kernels ready after {perf_counter() - began:.1f} s")
    steps = engine.compute(grid.cells, grid.size, options).results["steps"].sum()
    for threads in sorted({1, engine.processors()}):
        chosen = replace(options, threads=threads)
        seconds = best(lambda chosen=chosen: engine.compute(grid.cells, grid.size, chosen), repeats)
        per_step = seconds * threads / steps * 1e9
        print(f"  {threads:2} threads {grid.size / seconds:12,.0f} cells/s  {per_step:6.1f} ns per step and thread")
    with tempfile.TemporaryDirectory() as folder:
        seconds = best(lambda: stickslip.run(config, Path(folder) / "map.nc"), repeats)
    print(f"  whole run, netCDF included {grid.size / seconds:12,.0f} cells/s")


if __name__ == "__main__":
    main(*map(int, sys.argv[1:]))
