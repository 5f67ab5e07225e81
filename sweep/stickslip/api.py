"""The calls of Python users: load, run, open, evaluate, simulate."""

from __future__ import annotations

import json
import os
from collections.abc import Mapping
from math import inf, isinf
from pathlib import Path

import numpy as np
import xarray as xr
from numpy.typing import ArrayLike

from . import store
from .cells import as_cells
from .config import Config, load_config
from .dataset import cell_dataset, map_dataset, provenance, trace_dataset
from .engine import Computed, Options, Progress, compute, trajectory
from .grid import Grid, build_grid

open = store.open


class Interrupted(KeyboardInterrupt):
    """Ctrl-C during a run. What was finished is in `dataset` and, if the run had an output, in the file `kept`."""

    def __init__(self, dataset: xr.Dataset, done: int, kept: Path | None):
        self.dataset, self.done, self.kept = dataset, done, kept
        where = f"kept in {kept}" if kept else "not written to a file"
        super().__init__(f"interrupted: {done:,} of {dataset['regime'].size:,} cells are finished, {where}")


def run(
    config_or_path: Config | str | os.PathLike[str],
    output: str | os.PathLike[str] | None = None,
    *,
    progress: Progress | None = None,
) -> xr.Dataset:
    """Compute the map a configuration asks for.

    output : file to write, .nc or .zarr; None writes nothing (the output section of the configuration is for the
        command line).
    progress : called with (cells done, cells in all) now and then.

    Returns a dataset with a dimension per axis. Raises ConfigError for a bad configuration, StoreError for an output
    that cannot be written (before anything is computed), and Interrupted on Ctrl-C, with what was finished by then.
    """
    config = config_or_path if isinstance(config_or_path, Config) else load_config(config_or_path)
    grid = build_grid(config)
    if output is not None:
        store.check_writable(output)
    computed = compute(grid.cells, grid.size, options_of(config), progress)
    try:
        return _finish(config, grid, computed, output)
    except Interrupted:
        raise
    except KeyboardInterrupt:  # everything is computed: keep it all the same
        _finish(config, grid, computed, output)
        raise


def _finish(config: Config, grid: Grid, computed: Computed, output: str | os.PathLike[str] | None) -> xr.Dataset:
    """The dataset of a run, written if there is an output. Raises Interrupted if not all of it was computed."""
    attributes = provenance(config.to_yaml(), title=config.title, action="run")
    dataset = map_dataset(grid, computed.results, attributes)
    if not computed.complete:
        raise _interrupted(dataset, computed, output)
    if output is not None:
        store.write(dataset, output)
    return dataset


def options_of(config: Config) -> Options:
    """How a configuration wants to be integrated."""
    solver, execution = config.solver, config.execution
    return Options(
        law=config.friction.law,
        rtol=solver.rtol,
        horizon=inf if solver.horizon is None else solver.horizon,
        max_steps=solver.max_steps,
        early_stop=solver.early_stop,
        threads=None if execution.threads == "auto" else execution.threads,
        block=execution.block,
    )


def _interrupted(dataset: xr.Dataset, computed: Computed, output: str | os.PathLike[str] | None) -> Interrupted:
    """Keep what was finished, beside the file asked for: a complete result of that name must survive."""
    kept = None
    if output is not None and computed.done:
        target = Path(output)
        kept = store.write(dataset, target.with_name(f"{target.stem}.partial{target.suffix}"))
    return Interrupted(dataset, computed.done, kept)


def evaluate(
    cells: Mapping[str, ArrayLike] | xr.Dataset,
    rtol: float = 1e-6,
    horizon: float | None = None,
    early_stop: bool = True,
    threads: int | None = None,
    law: str = "stribeck",
    max_steps: int = 1_000_000,
) -> xr.Dataset:
    """Regime and metrics of any list of cells.

    cells : numbers or arrays in SI that broadcast against each other: mass, stiffness, damping (0), normal_load,
        belt_speed, a1, a2, a3, a4, mu_stop (NaN: no hysteresis), mu_static (NaN: a1 + a3), displacement (0), velocity
        (NaN: sticking), and for the law stribeck_delta `delta`; in brackets the defaults. Static friction grows with
        the time in contact: mu_static + ageing_rate (0) log10(1 + t/ageing_time (1 s)), counted from contact_time (0)
        before the start.
    rtol : relative tolerance of the integration. horizon : s, None for no limit.
    early_stop : False integrates every cell to the horizon and adds sticks, stick_time, displacement_end, velocity_end.
    threads : None for one per processor. law : shape of the weakening of friction, one of `variables.LAWS`.
    max_steps : step budget of a cell.

    Returns a dataset over `cell`. Raises TypeError or ValueError for bad input before anything is computed.
    """
    full = as_cells(cells)
    end = inf if horizon is None else horizon
    options = Options(law, float(rtol), float(end), int(max_steps), bool(early_stop), threads)
    size = full["mass"].size
    computed = compute(lambda start, stop: {name: v[start:stop] for name, v in full.items()}, size, options)
    solver: dict[str, float | None] = {
        "rtol": options.rtol,
        "early_stop": options.early_stop,
        "max_steps": options.max_steps,
    }
    solver["horizon"] = None if isinf(end) else options.horizon
    text = json.dumps({"friction": {"law": law}, "solver": solver})
    attributes = provenance(text, title="Cells evaluated one by one", action="evaluate")
    dataset = cell_dataset(full, computed.results, attributes)
    if not computed.complete:
        raise _interrupted(dataset, computed, None)
    return dataset


def simulate(
    *,
    duration: float,
    samples: int = 2001,
    rtol: float = 1e-6,
    law: str = "stribeck",
    max_steps: int = 1_000_000,
    **cell: float,
) -> xr.Dataset:
    """One trajectory over time, by the stepping that computes maps.

    duration : s. samples : how many, evenly spaced from 0 to `duration`.
    law, cell : the law and the parameters of `evaluate`, a number each.

    Returns a dataset over `time`: displacement, velocity, relative_speed, friction_coefficient (signed, positive along
    the belt), spring_force, acceleration, mode. Raises TypeError or ValueError for bad input, and NotReachedError where
    the integration does not reach the end.
    """
    if not (np.isfinite(duration) and duration > 0):
        raise ValueError(f"duration: got {duration!r}, expected a time > 0 (s)")
    if samples < 2:
        raise ValueError(f"samples: got {samples!r}, expected at least 2")
    full = as_cells(cell)
    if full["mass"].size != 1:
        raise ValueError("simulate computes one trajectory: give every parameter one number")
    options = Options(law, float(rtol), float(duration), int(max_steps))
    times = np.linspace(0.0, duration, samples)
    motion = trajectory(full, times, options)
    text = json.dumps(
        {
            "friction": {"law": law},
            "solver": {"rtol": options.rtol, "duration": options.horizon, "samples": int(samples)},
        }
    )
    attributes = provenance(text, title="Trajectory", action="simulate")
    return trace_dataset(times, motion, {name: float(value[0]) for name, value in full.items()}, attributes)
