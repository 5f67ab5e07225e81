"""Cells of a map that need attention: how many, which, and how to simulate one of them.

One pass over the flags, a chunk at a time, whatever the size of the map.
"""

from __future__ import annotations

import math
import shlex
from collections.abc import Collection
from dataclasses import dataclass

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from stickslip.config.select import Recipe, settings_at
from stickslip.dataset.chunks import Chunk, chunks
from stickslip.dataset.kept import why_absent
from stickslip.dataset.summary import BAD_REGIMES, codes
from stickslip.errors import ConfigError, Problem
from stickslip.vocabulary.flags import FLAGS
from stickslip.vocabulary.suggest import listed, nearest

NOT_KEPT = "not kept"  # in place of a status
_CODES = 256  # what fits in the byte of a flag
_CYCLES = 5  # of stick-slip that are worth seeing
_OSCILLATIONS = 20  # of the undamped oscillator, where nothing else is known
_LOOK = ("breakaway_time", "period", "mass", "stiffness")  # what tells how long to look


@dataclass(frozen=True)
class Cell:
    """One cell: its number in the map and its position by dimension, what became of it, and how to pick it.

    settings : what `stickslip simulate --at` takes. duration : s, long enough to see what happens.
    """

    number: int
    position: dict[str, int]
    regime: str
    status: str
    settings: tuple[str, ...]
    duration: float

    def command(self, file: str) -> str:
        """The line for the shell that simulates this cell of `file`, the same to the last bit."""
        at = [word for setting in self.settings for word in ("--at", setting)]
        words = ["stickslip", "simulate", file, *at, "-t", f"{self.duration:g}", "--plot", f"cell-{self.number}.png"]
        return shlex.join(words)


@dataclass(frozen=True)
class Survey:
    """What is in a map.

    counts : cells by (regime, status), the most frequent first; the status is NOT_KEPT where the map holds none.
    wanted : how many cells were asked for.
    cells : the first of those.
    """

    counts: dict[tuple[str, str], int]
    wanted: int
    cells: tuple[Cell, ...]


def survey(
    ds: xr.Dataset, recipe: Recipe, *, regimes: Collection[str] = (), statuses: Collection[str] = (), limit: int = 20
) -> Survey:
    """Count the cells of a map by what became of them, and describe the first `limit` of some.

    recipe : what the map was computed from (`pick.recipe_of`).
    regimes, statuses : which cells to describe, by names; without any, those that failed, are unresolved or were not
        computed.
    Raises ConfigError for names that do not exist, for a dataset that is no map, and where statuses are asked of a map
    that does not hold them.
    """
    wanted_regimes = _wanted("regime", regimes or (() if statuses else BAD_REGIMES))
    wanted_statuses = _wanted("status", statuses)
    if "regime" not in ds.data_vars:
        raise ConfigError("inspect", [Problem((), "no regime, expected a map")])
    has_status = "status" in ds.data_vars
    if statuses and not has_status:
        what, _, hint = str(why_absent(ds, "status")).partition("\nhint: ")
        raise ConfigError("--status", [Problem((), f"the map {what}", hint=hint)])
    counts = np.zeros(_CODES * _CODES, np.int64)
    places: list[tuple[int, ...]] = []
    for chunk in chunks(ds["regime"]):
        regime = codes(ds["regime"].isel(chunk))
        status = codes(ds["status"].isel(chunk)) if has_status else np.zeros_like(regime)
        counts += np.bincount(regime.astype(np.intp) * _CODES + status, minlength=_CODES * _CODES)
        if len(places) < limit:
            found = np.flatnonzero(wanted_regimes[regime] & wanted_statuses[status])
            places += _places(found[: limit - len(places)], chunk)
    table = counts.reshape(_CODES, _CODES)
    wanted = int(table[np.ix_(wanted_regimes, wanted_statuses)].sum())
    counted = _by_name(table)
    if not has_status:
        counted = {(regime, NOT_KEPT): cells for (regime, _), cells in counted.items()}
    return Survey(counted, wanted, tuple(_cells(ds, recipe, places)))


def _wanted(flag: str, names: Collection[str]) -> NDArray[np.bool_]:
    """Which codes of a flag are asked for; all, without any names."""
    known = list(FLAGS[flag])
    wanted = np.full(_CODES, not names)
    for name in names:
        if name not in known:
            near = nearest(name, known)
            hint = f"did you mean {near}?" if near else None
            raise ConfigError(f"--{flag}", [Problem((), f"got {name!r}, expected {listed(known)}", hint=hint)])
        wanted[known.index(name)] = True
    return wanted


def _by_name(table: NDArray[np.int64]) -> dict[tuple[str, str], int]:
    """The pairs of regime and status that occur."""
    pairs = sorted(np.argwhere(table), key=lambda pair: -table[tuple(pair)])
    return {(_name("regime", r), _name("status", s)): int(table[r, s]) for r, s in pairs}


def _name(flag: str, code: int) -> str:
    names = list(FLAGS[flag])
    return names[code] if code < len(names) else f"code_{code}"


def _places(found: NDArray[np.intp], chunk: Chunk) -> list[tuple[int, ...]]:
    """Positions in the map of some cells of a chunk."""
    shape = tuple(part.stop - part.start for part in chunk.values())
    inside = np.stack(np.unravel_index(found, shape), axis=1) if shape else np.zeros((found.size, 0), np.intp)
    return [tuple(int(i) for i in row) for row in inside + [part.start for part in chunk.values()]]


def _cells(ds: xr.Dataset, recipe: Recipe, places: list[tuple[int, ...]]) -> list[Cell]:
    """The cells at some positions."""
    if not places:
        return []
    dims = [str(dim) for dim in ds["regime"].dims]
    picked = {dim: xr.DataArray([place[i] for place in places], dims="picked") for i, dim in enumerate(dims)}
    known = ds[[name for name in ("regime", "status", *_LOOK) if name in ds.variables]].isel(picked).load()
    found = []
    for i, place in enumerate(places):
        one = known.isel(picked=i) if "picked" in known.dims else known
        position = dict(zip(dims, place, strict=True))
        number = int(np.ravel_multi_index(place, ds["regime"].shape)) if place else 0
        regime, status = (
            _name(flag, int(codes(one[flag])[0])) if flag in one else NOT_KEPT for flag in ("regime", "status")
        )
        settings = tuple(settings_at(recipe, ds, position))
        found.append(Cell(number, position, regime, status, settings, duration_of(recipe, one)))
    return found


def duration_of(recipe: Recipe, cell: xr.Dataset) -> float:
    """How long to look at a cell, in s: to the horizon, or some cycles, or some oscillations after break-away."""
    solver = recipe.get("solver", {}) if isinstance(recipe, dict) else dict(recipe.solver)  # type: ignore[union-attr]
    known = {name: float(cell[name]) for name in _LOOK if name in cell.variables}
    oscillation = 2.0 * math.pi * math.sqrt(known.get("mass", 1.0) / known.get("stiffness", 1.0))
    begin = known.get("breakaway_time", math.nan)
    cycle = known.get("period", math.nan)
    seen = _CYCLES * cycle if math.isfinite(cycle) else _OSCILLATIONS * oscillation
    duration = seen + (begin if math.isfinite(begin) else 0.0)
    return float(f"{min(duration, solver.get('horizon') or math.inf):.3g}")
