"""The contents of a map: shares of its regimes, cells that need attention, variables that it does not hold.

Flags are counted in one pass, a chunk at a time, whatever the size of the map.
"""

import shlex
from collections.abc import Collection, Mapping
from typing import Any, NamedTuple

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from stickslip.config.reader import parse_config
from stickslip.dataset.coarse import chunks
from stickslip.errors import ConfigError
from stickslip.vocabulary.models import MODELS
from stickslip.vocabulary.own_laws import beyond_points
from stickslip.vocabulary.quantities import did_you_mean, listed
from stickslip.vocabulary.results import FLAGS, REGIMES, VARIABLES, VARIABLES_OF

BAD_REGIMES = ("failed", "unresolved", "not_computed")  # cells that say nothing about the contact
NOT_KEPT = "not kept"  # in place of a status
_CODES = 256  # what fits in the byte of a flag


class Share(NamedTuple):
    """Number of cells, and their part of all cells."""

    cells: int
    fraction: float


def summary(ds: xr.Dataset) -> dict[str, Share]:
    """The regimes that occur, in the order of `REGIMES`, with their number of cells and their share of the dataset."""
    cells = flag_counts(ds["regime"])
    total = max(1, sum(cells.values()))
    return {name: Share(n, n / total) for name, n in cells.items() if n}


def flag_counts(flags: xr.DataArray) -> dict[str, int]:
    """Number of cells with each value of a flag, by name, in one pass that holds little in memory.

    Codes without a name, which a newer version may have written, are counted as ``code_9``.
    """
    counts, flag = np.zeros(_CODES, np.int64), str(flags.name)
    for chunk in chunks(flags):
        part = flags.isel(chunk).values
        counts += np.bincount(_codes(part[~np.isnan(part)] if part.dtype.kind == "f" else part), minlength=_CODES)
    return {_name(flag, code): int(n) for code, n in enumerate(counts) if n or code < len(FLAGS[flag])}


def _codes(flags: NDArray[Any]) -> NDArray[np.uint8]:
    """The values of a flag as unsigned bytes in one row."""
    return np.ascontiguousarray(flags, np.int8).view(np.uint8).ravel()


def remark(parts: Mapping[str, Share], file: str | None = None, bad: Collection[str] = BAD_REGIMES) -> str | None:
    """A line about cells without a result; None if there are none.

    parts : as `summary` gives them. file : of the map, for the command that lists them.
    """
    counts = [f"{parts[name].cells:,} {name.replace('_', ' ')}" for name in REGIMES if name in bad and name in parts]
    if not counts:
        return None
    cells = sum(parts[name].cells for name in bad if name in parts)
    text = f"{listed(counts, 'and')} cell{'s' * (cells != 1)}"
    return text if file is None else f"{text}: stickslip inspect {shlex.quote(file)}"


def table_remark(ds: xr.Dataset) -> str | None:
    """A sentence on slip that is faster than the fastest point of the table that a map was computed with."""
    text, speeds = str(ds.attrs.get("configuration", "")), ds.get("slip_speed_max")
    if speeds is None or "law: table_" not in text:
        return None
    law, known = parse_config(text).friction.law, ds["a4"]
    parts = ((speeds.isel(chunk), known.isel(chunk, missing_dims="ignore")) for chunk in chunks(speeds))
    beyond = (beyond_points(law, *(array.values for array in xr.broadcast(*part))) for part in parts)
    return next(filter(None, beyond), None)


def step_limit_remark(ds: xr.Dataset, file: str | None = None) -> str | None:
    """A line about cells that ran out of steps; None if there are none. file : as for `remark`.

    Of a map that does not keep `status`, that it could tell why cells are unresolved.
    """
    if "status" not in ds:
        open_cells = flag_counts(ds["regime"])["unresolved"]
        return "why cells are unresolved is in status, which output.variables leaves out" if open_cells else None
    limited = flag_counts(ds["status"])["step_limit"]
    if not limited:
        return None
    text = f"{limited:,} cell{'s' * (limited != 1)} ended at the step limit; solver: {{max_steps: ...}} raises it"
    return text if file is None else f"{text}: stickslip inspect {shlex.quote(file)} --status step_limit"


def why_absent(ds: xr.Dataset, *names: str) -> str | None:
    """The reason why a map lacks the variables `names`, and how to get them; None if it holds them or never would.

    Two lines: `holds no damping_ratio, ...` and the hint. `output: {variables: [...]}` may leave variables out; a map
    to the horizon (early_stop: false) has some that no other has.
    """
    there = [str(name) for name in ds.data_vars if name in VARIABLES]
    absent = [name for name in names if name in VARIABLES and name not in there]
    if not absent or "regime" not in there:
        return None
    to_horizon = [name for name in absent if VARIABLES[name].when == "full"]
    full = {row.name for row in VARIABLES.values() if row.when == "full"}
    if to_horizon and any(VARIABLES_OF[model].keys() - set(there) == full for model in MODELS):
        return (
            f"holds no {listed(absent, 'and')}, which only a run to a horizon defines\n"
            "hint: solver: {early_stop: false, horizon: ...} computes to a horizon"
        )
    variables = ", ".join(name for name in VARIABLES if name in there or name in absent)
    return (
        f"holds no {listed(absent, 'and')}, since output.variables kept {listed(there, 'and')} alone\n"
        f"hint: stickslip run CONFIG --set 'output.variables=[{variables}]' -o other.nc computes the map with "
        f"{'it' if len(absent) == 1 else 'them'}"
    )


# --- cells one by one -------------------------------------------------------------------------------------------------


class MapCell(NamedTuple):
    """One cell: its number in the map, its position by dimension, and what became of it."""

    number: int
    position: dict[str, int]
    regime: str
    status: str


class Survey(NamedTuple):
    """The contents of a map.

    counts : cells by (regime, status), the most frequent first; the status is NOT_KEPT where the map holds none.
    wanted : how many cells were asked for.
    cells : the first of those.
    """

    counts: dict[tuple[str, str], int]
    wanted: int
    cells: list[MapCell]


def survey(ds: xr.Dataset, *, regimes: Collection[str] = (), statuses: Collection[str] = (), limit: int = 20) -> Survey:
    """Count the cells of a map by what became of them, and list the first `limit` of some.

    regimes, statuses : which cells to list, by names; without any, those that failed, are unresolved or were not
        computed.
    Raises ConfigError for names that do not exist, and where statuses are asked of a map that does not hold them.
    """
    chosen_regimes = _chosen("regime", regimes or (() if statuses else BAD_REGIMES))
    chosen = np.logical_and.outer(chosen_regimes, _chosen("status", statuses))
    has_status = "status" in ds.data_vars
    if statuses and not has_status:
        reason, _, hint = str(why_absent(ds, "status")).partition("\nhint: ")
        raise ConfigError.of("--status", f"the map {reason}", hint)

    def names(regime: int, status: int) -> tuple[str, str]:
        return _name("regime", regime), _name("status", status) if has_status else NOT_KEPT

    counts, cells = np.zeros(chosen.size, np.int64), list[MapCell]()
    for chunk in chunks(ds["regime"]):
        regime = _codes(ds["regime"].isel(chunk).values)
        status = _codes(ds["status"].isel(chunk).values) if has_status else np.zeros_like(regime)
        counts += np.bincount(regime.astype(np.intp) * _CODES + status, minlength=chosen.size)
        for i in np.flatnonzero(chosen[regime, status])[: limit - len(cells)]:
            inside = np.unravel_index(i, [part.stop - part.start for part in chunk.values()])
            place = [int(part.start + j) for part, j in zip(chunk.values(), inside, strict=True)]
            number = int(np.ravel_multi_index(place, ds["regime"].shape))
            position = dict(zip(map(str, chunk), place, strict=True))
            cells.append(MapCell(number, position, *names(regime[i], status[i])))
    present = np.flatnonzero(counts)
    ranked = present[np.argsort(-counts[present], kind="stable")]
    counted = {names(*divmod(int(code), _CODES)): int(counts[code]) for code in ranked}
    return Survey(counted, int(counts[chosen.ravel()].sum()), cells)


def _chosen(flag: str, names: Collection[str]) -> NDArray[np.bool_]:
    """Marks of the codes of a flag that have these names; of all, without any names."""
    known = list(FLAGS[flag])
    chosen = np.full(_CODES, not names)
    for name in names:
        if name not in known:
            raise ConfigError.of(f"--{flag}", f"got {name!r}, expected {listed(known)}", did_you_mean(name, known))
        chosen[known.index(name)] = True
    return chosen


def _name(flag: str, code: int) -> str:
    names = list(FLAGS[flag])
    return names[code] if code < len(names) else f"code_{code}"
