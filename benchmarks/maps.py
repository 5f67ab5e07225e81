"""Cost of maps that people compute, beside P2, whose cells nearly all close a cycle in a dozen steps.

    python benchmarks/maps.py      # half a minute

CPU time a cell on one thread, in turns, with all variables and with the regime alone.
"""

from __future__ import annotations

from dataclasses import replace
from functools import partial
from statistics import median

import numpy as np

import problem
from measure import Job, interleave
from stickslip import engine
from stickslip.config.grid import build_grid, options_of
from stickslip.config.reader import load_config
from stickslip.config.resolve import config_path
from stickslip.vocabulary.cells import Cells

SIDE, TURNS = 100, 7
ASKED = {"quickstart": 2.0, "weak damping": 2.0, "hysteretic": 2.0, "ringing": 3.0}  # times P2


def maps() -> dict[str, tuple[Cells, engine.Options]]:
    """Cells in random order, and how they are computed, by name."""
    config, plain = load_config(config_path("quickstart")), engine.Options()
    quickstart = shuffled(build_grid(config)[:])
    cases = {"P2": (problem.cells_of(problem.grid(SIDE)), plain), "quickstart": (quickstart, options_of(config))}
    ranges = {"weak damping": (0.05, 1.2, {}), "hysteretic": (0.05, 1.2, {"mu_stop": problem.MU_STOP}),
              "ringing": (0.45, 1.2, {})}  # fmt: skip
    for name, (low, high, more) in ranges.items():
        k, belt = np.meshgrid(np.logspace(-1, 2, SIDE), np.linspace(low, high, SIDE), indexing="ij")
        cases[name] = problem.cells_of(problem.Cells(k.ravel(), belt.ravel()), **more), plain
    return {name: (shuffled(cells[:]), replace(options, threads=1)) for name, (cells, options) in cases.items()}


def shuffled(parameters: dict[str, np.ndarray]) -> Cells:
    """As many of these cells as a map has, in random order."""
    order = np.random.default_rng(4).permutation(parameters["mass"].size)[: SIDE**2]
    return Cells.of({name: values[order] for name, values in parameters.items()})


def measure() -> list[dict]:
    """Rows of maps: microseconds a cell, all of it and the regime alone."""
    jobs = {}
    for name, (cells, options) in maps().items():
        for kind, some in (("all", options), ("regime", options.keeping(["regime"]))):
            jobs[name, kind] = Job(partial(engine.compute, cells, some), TURNS), cells.size
    for job, _ in jobs.values():
        job.action()
    interleave([job for job, _ in jobs.values()])
    each = {key: median(job.timings.cpu) / size * 1e6 for key, (job, size) in jobs.items()}
    rows = []
    for name in maps():
        results = jobs[name, "all"][0].result.results
        settles = np.isin(results["regime"], (2, 3))
        rows.append({
            "map": name, "us": each[name, "all"], "over_p2": each[name, "all"] / each["P2", "all"],
            "asked": ASKED.get(name), "regime_us": each[name, "regime"],
            "regime_over_p2": each[name, "regime"] / each["P2", "all"], "settle": float(settles.mean()),
            "steps": float(results["steps"].mean()),
        })  # fmt: skip
    return rows


if __name__ == "__main__":
    from tables import maps_table

    engine.warm_up()
    print(maps_table(measure()))
