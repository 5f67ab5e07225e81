"""The calls of Python users: load, run (whole or in parts), open, evaluate, border, simulate."""

from __future__ import annotations

import json
import os
from collections.abc import Mapping
from dataclasses import replace
from math import inf, isinf
from typing import TYPE_CHECKING, Any

import numpy as np
import xarray as xr
from numpy.typing import ArrayLike

from . import borders
from .config.addresses import HERE
from .config.model import Config
from .config.options import options_of
from .config.reader import load_config
from .config.studies import Border, alone
from .dataset.build import cell_dataset, trace_dataset
from .dataset.provenance import provenance
from .engine import Options, Progress, compute, trajectory
from .errors import ClusterError, IncompleteError, Interrupted
from .files.locations import location
from .files.reading import open
from .runs import collecting, session
from .runs.blocks import parse_shard
from .runs.maps import MapStudy
from .runs.memory import compute_study
from .runs.request import OnError, Outcome, Request, request_for
from .runs.work import study_of
from .runs.workdir.lock import Notice
from .vocabulary.cells import as_cells

if TYPE_CHECKING:
    from distributed import Client

__all__ = [
    "ClusterError", "IncompleteError", "Interrupted", "border", "collect", "evaluate", "open", "options_of",
    "retry_failed", "run", "run_shard", "simulate", "status",
]  # fmt: skip


def run(
    config_or_path: Config | str | os.PathLike[str],
    output: str | os.PathLike[str] | None = None,
    *,
    store: str | os.PathLike[str] | None = None,
    fresh: bool = False,
    keep_parts: bool = False,
    on_error: OnError = "continue",
    progress: Progress | None = None,
    notice: Notice | None = None,
    dask: str | Client | None = None,
) -> xr.Dataset:
    """Compute the map a configuration asks for.

    output : file to write, .nc or .zarr; None computes in memory and writes nothing (the output section of the
        configuration is for the command line).
    store : path or URL of the working store that keeps finished blocks until the output is written; None puts it
        beside the output, as FILE.parts. The same call resumes from it, and from an output whose axes were extended.
    fresh : start over, and replace an output made from another configuration. keep_parts : leave the working store.
    on_error : whether an exception in a block ends the run ("stop") or the others are computed first ("continue").
    progress : called with (cells done, cells in all) from time to time.
    notice : called with notices, a line each: cells found finished, a damaged block, a stale lock.
    dask : computes the blocks, instead of threads here: the address of a scheduler, its file, a `distributed.Client`,
        or "local" for worker processes on this machine; "none" for threads whatever the configuration says. Needs an
        output. Scripts that say "local" need `if __name__ == "__main__":`, since the processes import them.

    Returns a dataset with a dimension per axis; with an output, the one in that file, read when it is used. Raises
    ConfigError for a bad configuration, StoreError or ClusterError for an output, a store or a cluster that cannot be
    used (before anything is computed), IncompleteError if not everything could be computed or written, and Interrupted
    on Ctrl-C.
    """
    config = _config(config_or_path)
    if output is None:
        if store is not None:
            raise ValueError("store: needs an output; run_shard computes into a store alone")
        check_in_memory(config, dask)
        return _run_in_memory(config, progress)
    request = Request(
        config, location(output), _text(store), None, fresh, keep_parts, on_error, progress,
        notice=notice or _silent, dask=dask,
    )  # fmt: skip
    session.run(request)
    return open(output)


def check_in_memory(config: Config, dask: str | Client | None) -> None:
    """Raise ClusterError if a run without output is to be computed on a cluster."""
    if (config.execution.dask if dask is None else dask) not in (None, HERE):
        raise ClusterError(
            "computing on a Dask cluster needs a place for finished blocks: name an output, or a store\n"
            "hint: dask: none computes on this machine"
        )


def _run_in_memory(config: Config, progress: Progress | None) -> xr.Dataset:
    study, attributes = study_of(config), provenance(config.to_yaml(), title=config.title, action="run")
    if not isinstance(study, MapStudy):
        return study.dataset(compute_study(study, progress), attributes)
    computed = compute(study.grid.cells, study.grid.size, study.options, progress)
    dataset = study.dataset([computed.results], attributes)
    if not computed.complete:
        raise Interrupted(computed.done, study.grid.size, dataset=dataset)
    return dataset


# --- runs in parts ----------------------------------------------------------------------------------------------------


def run_shard(
    config_or_path: Config | str | os.PathLike[str],
    shard: str,
    store: str | os.PathLike[str],
    *,
    on_error: OnError = "continue",
    progress: Progress | None = None,
    notice: Notice | None = None,
    dask: str | Client | None = None,
) -> Outcome:
    """Compute one shard of a map, "2/8" say, into a working store that all shards share; `collect` merges them.

    Raises as `run` does.
    """
    config = _config(config_or_path)
    request = Request(
        config, None, _text(store), parse_shard(shard), on_error=on_error, progress=progress,
        notice=notice or _silent, dask=dask,
    )  # fmt: skip
    return session.run(request)


def collect(
    config_or_store: str | os.PathLike[str],
    output: str | os.PathLike[str] | None = None,
    *,
    store: str | os.PathLike[str] | None = None,
    keep_parts: bool = False,
    notice: Notice | None = None,
) -> xr.Dataset:
    """Write the map from the blocks that are finished; all other cells are "not computed".

    config_or_store : a configuration file, whose store is beside its output (or at `store`), or a store itself.
    output : file to write; None takes that of the configuration. A store is removed once its map is complete.
    """
    request = request_for(config_or_store, output, _text(store))
    collected = collecting.collect(replace(request, keep=keep_parts, notice=notice or _silent))
    return open(collected.output)


def status(
    config_or_store: str | os.PathLike[str], *, store: str | os.PathLike[str] | None = None
) -> collecting.Status:
    """The progress of the run of a configuration file, or of a working store, and who works on it."""
    return collecting.status(request_for(config_or_store, None, _text(store)))


def retry_failed(
    config_or_store: str | os.PathLike[str],
    output: str | os.PathLike[str] | None = None,
    *,
    store: str | os.PathLike[str] | None = None,
    progress: Progress | None = None,
    notice: Notice | None = None,
    dask: str | Client | None = None,
) -> Outcome:
    """Compute blocks that failed again; the map is written if nothing is missing then. Raises as `run` does."""
    request = request_for(config_or_store, output, _text(store))
    return session.retry_failed(replace(request, progress=progress, notice=notice or _silent, dask=dask))


def _config(config_or_path: Config | str | os.PathLike[str]) -> Config:
    return config_or_path if isinstance(config_or_path, Config) else load_config(config_or_path)


def _text(place: str | os.PathLike[str] | None) -> str | None:
    return None if place is None else os.fspath(place)


def _silent(_: str) -> None:
    """Ignore a notice."""


# --- cells and trajectories -------------------------------------------------------------------------------------------


def evaluate(
    cells: Mapping[str, ArrayLike] | xr.Dataset,
    rtol: float = 1e-6,
    horizon: float | None = None,
    early_stop: bool = True,
    threads: int | None = None,
    law: str = "stribeck",
    max_steps: int = Options.max_steps,
) -> xr.Dataset:
    """Regime and metrics of any list of cells.

    cells : numbers or arrays in SI that broadcast against each other: mass, stiffness, damping (0), normal_load,
        belt_speed, a1, a2, a3, a4, mu_stop (NaN: no hysteresis), mu_static (NaN: a1 + a3), displacement (0), velocity
        (NaN: sticking), and for the law stribeck_delta `delta`; in brackets the defaults. Static friction grows with
        the time in contact: mu_static + ageing_rate (0) log10(1 + t/ageing_time (1 s)), counted from contact_time (0)
        before the start.
    rtol : relative tolerance of the integration. horizon : s, None for no limit.
    early_stop : False integrates every cell to the horizon and adds sticks, stick_time, displacement_end, velocity_end.
    threads : None for one per processor. law : shape of the weakening of friction, one of `vocabulary.laws.LAWS`.
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
        raise Interrupted(computed.done, size, dataset=dataset)
    return dataset


def border(
    cells_or_config: Mapping[str, ArrayLike] | xr.Dataset | Config | str | os.PathLike[str],
    along: str,
    between: tuple[float, float] | None = None,
    tolerance: float = 1e-9,
    *,
    scan: int = 64,
    rtol: float | None = None,
    horizon: float | None = None,
    threads: int | None = None,
    law: str | None = None,
    max_steps: int | None = None,
    progress: Progress | None = None,
) -> xr.Dataset:
    """Where along a parameter the regime changes, in every line of cells.

    cells_or_config : cells as `evaluate` takes them, the dimension of the result is `cell`; or a configuration, whose
        other axes are the dimensions. What they say of the searched parameter itself is left out.
    along : a parameter of a cell. between : its range (SI); None takes that of the axis of the configuration.
    tolerance : width of the last bracket over the border, or over a thousandth of the larger end of a range if
        that holds 0 and the border is closer to it.
    scan : places looked at first, evenly spaced, by ratio where the ends are a factor of 10 apart. A regime that begins
        and ends between two of them can be missed.
    rtol : of the integration; None for a hundredth of the tolerance, from 1e-12 to 1e-6.
    horizon, threads, law, max_steps : of `evaluate`; None takes the defaults, or what the configuration says. A
        configuration says its law itself. progress : called with (lines done, lines in all) from time to time.

    A configuration with a section `border` asks for the same of `run`, which resumes and uses clusters.

    Returns a dataset over the lines and `crossing`, in ascending order: border (NaN where a line has fewer),
    regime_below, regime_above, border_width, method, and scan_undecided per line. Where cells at a border are
    unresolved or failed, border_width is the stretch of them. No crossing is no error: `crossing` has length 0, and the
    attribute border_found says so. Raises TypeError or ValueError for bad input before anything is computed,
    ConfigError for a bad configuration.
    """
    limits = borders.Limits(scan, tolerance)
    title = "Borders of regimes"
    given: dict[str, Any] = {"horizon": horizon, "threads": threads, "max_steps": max_steps}
    given = {name: value for name, value in given.items() if value is not None}
    given["rtol"] = limits.rtol() if rtol is None else float(rtol)
    if isinstance(cells_or_config, Config | str | os.PathLike):
        config = _config(cells_or_config)
        if law is not None:
            raise ValueError(f"law: got {law!r}, but a configuration says its law itself: {config.friction.law}")
        options = replace(options_of(config), early_stop=True, **given)
        lines = borders.lines_of_config(config, along, between)
        asked = Border.model_construct(along=along, between=between, tolerance=tolerance, scan=scan, rtol=rtol)
        title, text = f"{title}: {config.title}", config.model_copy(update=alone("border", asked)).to_yaml()
    else:
        options = Options(law=law or Options.law, **given)
        lines = borders.lines_of_cells(cells_or_config, along, between)
        solver = {"rtol": options.rtol, "horizon": None if isinf(options.horizon) else options.horizon}
        text = json.dumps({"friction": {"law": options.law}, "solver": solver | {"max_steps": options.max_steps}})
    study = borders.BorderStudy(lines, limits, options)
    attributes = provenance(text, title=title, action=f"border along {along}")
    return study.dataset(compute_study(study, progress), attributes)


def simulate(
    *,
    duration: float,
    samples: int = 2001,
    rtol: float = 1e-6,
    law: str = "stribeck",
    max_steps: int = Options.max_steps,
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
