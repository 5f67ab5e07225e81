"""The calls that run a configuration, whole or in parts: run, sweep, run_shard, collect, status, retry_failed."""

from __future__ import annotations

import inspect
import os
import warnings
from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING, Any

import xarray as xr

from stickslip.config.model import Config
from stickslip.config.reader import Given, as_config, make_config
from stickslip.config.sections import HERE
from stickslip.dataset.build import provenance
from stickslip.dataset.coarse import table_remark
from stickslip.engine import Progress, compute
from stickslip.errors import ClusterError, ExtrapolationWarning, Interrupted
from stickslip.files.locations import location
from stickslip.files.reading import open
from stickslip.progress import Watch, watched
from stickslip.runs import report, session
from stickslip.runs.formats import Notice
from stickslip.runs.session import Outcome, Request, request_for
from stickslip.runs.threads import compute_study
from stickslip.runs.work import MapStudy, parse_shard, study_of
from stickslip.vocabulary.quantities import STUDIES, or_meant

if TYPE_CHECKING:
    from distributed import Client

Section = Mapping[str, Any]

__all__ = ["collect", "retry_failed", "run", "run_shard", "status", "sweep"]


def run(
    config_or_path: Given,
    output: str | os.PathLike[str] | None = None,
    *,
    store: str | os.PathLike[str] | None = None,
    fresh: bool = False,
    keep_parts: bool = False,
    progress: Watch = "auto",
    notice: Notice | None = None,
    dask: str | Client | None = None,
    variables: str | Sequence[str] | None = None,
) -> xr.Dataset:
    """Compute the map a configuration asks for.

    config_or_path : a YAML file; or what it would say as a mapping, with numbers in SI, texts with units, lists and
        arrays (`load_config`); or a Config.
    output : file to write, .nc or .zarr; None computes in memory and writes nothing (the output section of the
        configuration is for the command line).
    store : folder of the working store that keeps finished blocks until the output is written; None puts it beside
        the output, as FILE.parts, or into the current folder for an output behind a URL. The same call resumes from it,
        and from an output whose axes were extended.
    fresh : start over, and replace an output made from another configuration. keep_parts : leave the working store.
    progress : "auto" shows a bar in a notebook, True anywhere, False nowhere; a function is called with (cells done,
        cells in all) from time to time.
    notice : called with notices, a line each: cells found finished, a damaged block, a stale lock.
    dask : computes the blocks, instead of threads here: the address of a scheduler, its file, a `distributed.Client`,
        or "local" for worker processes on this machine; "none" for threads whatever the configuration says. Needs an
        output. Scripts that say "local" need `if __name__ == "__main__":`, since the processes import them.
    variables : of a map that are kept, the others are neither stored nor written; regime always is. None keeps what the
        configuration says (`output: {variables: [...]}`), else all.

    Returns a dataset with a dimension per axis; with an output, the one in that file, read when it is used. Raises
    ConfigError for a bad configuration, StoreError or ClusterError for an output, a store or a cluster that cannot be
    used (before anything is computed), IncompleteError if not everything could be computed or written, and Interrupted
    on Ctrl-C.
    """
    config = as_config(config_or_path, apart=None)
    if variables is not None:
        plain = config.resolved()
        config = make_config({**plain, "output": {**plain["output"], "variables": variables}}, "")
    if output is None:
        if store is not None:
            raise ValueError("store: needs an output; run_shard computes into a store alone")
        check_in_memory(config, dask)
        return _with_remark(run_in_memory(config, progress))
    with watched(progress) as moved:
        session.run(Request(
            config, location(output), store, None, fresh, keep_parts, moved, notice=notice or _silent, dask=dask
        ))  # fmt: skip
    return _with_remark(open(output))


def _with_remark(ds: xr.Dataset) -> xr.Dataset:
    if text := table_remark(ds):
        warnings.warn(text, ExtrapolationWarning, stacklevel=3)
    return ds


def sweep(
    *,
    system: Section | None = None,
    friction: Section | None = None,
    axes: Section | Sequence[xr.DataArray | xr.Dataset] | None = None,
    start: Section | None = None,
    solver: Section | None = None,
    title: str | None = None,
    execution: Section | None = None,
    output: str | os.PathLike[str] | Section | None = None,
    **how: Any,
) -> xr.Dataset:
    """Compute a map, or another study, from the sections of a configuration given one by one.

    system, ..., execution : the sections of a YAML file as mappings. A number is in SI, a text carries a unit
        ("5 N/mm"). An axis is a list, an array (`axes={"belt_speed": np.linspace(0.01, 1.2, 300)}`), a mapping with
        start, stop and num, a DataArray with its units in the attributes, or a Dataset over one dimension, along which
        its quantities vary together, with its text coordinate as labels. An empty section, `refine={}`, is one that
        is given.
    output : file to write, .nc or .zarr; or the section of that name, {"file": "map.nc", "variables": ["regime"]}, of
        which the file may be left out. None computes in memory.
    how : the section of a study (border, contours, margins, attractors, ramp, refine or uncertain), and further
        arguments of `run`.

    Returns what `run` does, and raises as it does: ConfigError lists everything that is wrong, each with its key.
    """
    sections = {
        "title": title, "system": system, "friction": friction, "axes": axes, "start": start, "solver": solver,
        "execution": execution, "output": output if isinstance(output, Mapping) else None,
    } | {key: how.pop(key, None) for key in STUDIES}  # fmt: skip
    if unknown := [name for name in how if name not in _HOW]:
        hint = or_meant(unknown[0], [*sections, *_HOW], otherwise=f"; sections are {', '.join(sections)}")
        raise TypeError(f"sweep() got an unexpected keyword argument {unknown[0]!r}{hint}")
    file = output.get("file") if isinstance(output, Mapping) else output
    return run({name: given for name, given in sections.items() if given is not None}, file, **how)


_HOW = tuple(inspect.signature(run).parameters)[2:]  # of `run`, besides the configuration and its output


def check_in_memory(config: Config, dask: str | Client | None) -> None:
    """Raise ClusterError if a run without output is to be computed on a cluster."""
    if (config.execution.dask if dask is None else dask) not in (None, HERE):
        raise ClusterError(
            "computing on a Dask cluster needs a place for finished blocks: name an output, or a store\n"
            "hint: dask: none computes on this machine"
        )


def run_in_memory(config: Config, progress: Watch) -> xr.Dataset:
    """The dataset of a configuration, without a file, and without remarks."""
    study, attributes = study_of(config), provenance(config.to_yaml(), title=config.title, action="run")
    with watched(progress, study.counted, config.friction.law) as moved:
        if not isinstance(study, MapStudy):
            return study.dataset(compute_study(study, moved), attributes)
        computed = compute(study.grid, study.options, moved)
    dataset = study.dataset([computed.results], attributes)
    if not computed.complete:
        raise Interrupted(computed.done, study.grid.size, dataset=dataset)
    return dataset


# --- runs in parts ----------------------------------------------------------------------------------------------------


def run_shard(
    config_or_path: Given,
    shard: str,
    store: str | os.PathLike[str],
    *,
    progress: Progress | None = None,
    notice: Notice | None = None,
    dask: str | Client | None = None,
) -> Outcome:
    """Compute one shard of a map, "2/8" say, into a working store that all shards share; `collect` merges them.

    Raises as `run` does.
    """
    config, part = as_config(config_or_path, apart=None), parse_shard(shard)
    return session.run(Request(config, None, store, part, progress=progress, notice=notice or _silent, dask=dask))


def collect(
    config_or_store: Given,
    output: str | os.PathLike[str] | None = None,
    *,
    store: str | os.PathLike[str] | None = None,
    keep_parts: bool = False,
    notice: Notice | None = None,
) -> xr.Dataset:
    """Write the map from the blocks that are finished; all other cells are "not computed".

    config_or_store : a configuration, as `run` takes it, whose store is beside its output (or at `store`), or a store
        itself.
    output : file to write; None takes that of the configuration. A store is removed once its map is complete.
    """
    request = request_for(config_or_store, output, store)
    collected = report.collect(replace(request, keep=keep_parts, notice=notice or _silent))
    return open(collected.output)


def status(config_or_store: Given, *, store: str | os.PathLike[str] | None = None) -> report.Status:
    """The progress of the run of a configuration, or of a working store, and who works on it."""
    return report.status(request_for(config_or_store, None, store))


def retry_failed(
    config_or_store: Given,
    output: str | os.PathLike[str] | None = None,
    *,
    store: str | os.PathLike[str] | None = None,
    progress: Progress | None = None,
    notice: Notice | None = None,
    dask: str | Client | None = None,
) -> Outcome:
    """Compute blocks that failed again; the map is written if nothing is missing then. Raises as `run` does."""
    request = request_for(config_or_store, output, store)
    return session.retry_failed(replace(request, progress=progress, notice=notice or _silent, dask=dask))


def _silent(_: str) -> None:
    """Ignore a notice."""
