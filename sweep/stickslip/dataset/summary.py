"""The contents of a map: shares of its regimes, cells that need attention.

Flags are counted in one pass, a chunk at a time, whatever the size of the map.
"""

import shlex
from collections.abc import Collection, Mapping
from typing import NamedTuple

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from stickslip.config.reader import parse_config
from stickslip.dataset.coarse import chunks
from stickslip.errors import ConfigError
from stickslip.vocabulary.own_laws import beyond_points
from stickslip.vocabulary.quantities import did_you_mean, listed
from stickslip.vocabulary.results import FLAGS

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
        counts += np.bincount(part[~np.isnan(part)].astype(np.uint8), minlength=_CODES)
    return {_name(flag, code): int(n) for code, n in enumerate(counts) if n or code < len(FLAGS[flag])}


def remark(parts: Mapping[str, Share], file: str) -> str | None:
    """A line about cells without a result, and the command that lists them; None if there are none.

    parts : as `summary` gives them. file : of the map.
    """
    counts = [f"{parts[name].cells:,} {name.replace('_', ' ')}" for name in BAD_REGIMES if name in parts]
    return f"{listed(counts, 'and')} cells: stickslip inspect {shlex.quote(file)}" if counts else None


def table_remark(ds: xr.Dataset) -> str | None:
    """A sentence on slip that is faster than the fastest point of the table that a map was computed with."""
    text, speeds = str(ds.attrs.get("configuration", "")), ds.get("slip_speed_max")
    if speeds is None or "law: table_" not in text:
        return None
    law, known = parse_config(text).friction.law, ds["a4"]
    parts = ((speeds.isel(chunk), known.isel(chunk, missing_dims="ignore")) for chunk in chunks(speeds))
    beyond = (beyond_points(law, *(array.values for array in xr.broadcast(*part))) for part in parts)
    return next(filter(None, beyond), None)


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
        raise ConfigError.of("--status", "the map holds no status", "output.variables says what a map holds")

    def names(regime: int, status: int) -> tuple[str, str]:
        return _name("regime", regime), _name("status", status) if has_status else NOT_KEPT

    counts, cells = np.zeros(chosen.size, np.int64), list[MapCell]()
    for chunk in chunks(ds["regime"]):
        regime = ds["regime"].isel(chunk).values.astype(np.uint8)
        status = ds["status"].isel(chunk).values.astype(np.uint8) if has_status else np.zeros_like(regime)
        counts += np.bincount(regime.ravel().astype(np.intp) * _CODES + status.ravel(), minlength=chosen.size)
        for inside in np.argwhere(chosen[regime, status])[: limit - len(cells)].tolist():
            place = [part.start + i for part, i in zip(chunk.values(), inside, strict=True)]
            position, at = dict(zip(map(str, chunk), place, strict=True)), tuple(inside)
            number = int(np.ravel_multi_index(place, ds["regime"].shape))
            cells.append(MapCell(number, position, *names(regime[at], status[at])))
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
