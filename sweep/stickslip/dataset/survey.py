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
from stickslip.dataset.coarse import Chunk, chunks
from stickslip.dataset.summary import BAD_REGIMES, codes, why_absent
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
    """The contents of a map.

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
    chosen_regimes = _chosen("regime", regimes or (() if statuses else BAD_REGIMES))
    chosen_statuses = _chosen("status", statuses)
    if "regime" not in ds.data_vars:
        raise ConfigError("inspect", [Problem((), "no regime, expected a map")])
    has_status = "status" in ds.data_vars
    if statuses and not has_status:
        reason, _, hint = str(why_absent(ds, "status")).partition("\nhint: ")
        raise ConfigError("--status", [Problem((), f"the map {reason}", hint=hint)])
    counts = np.zeros(_CODES * _CODES, np.int64)
    places: list[tuple[int, ...]] = []
    for chunk in chunks(ds["regime"]):
        regime = codes(ds["regime"].isel(chunk))
        status = codes(ds["status"].isel(chunk)) if has_status else np.zeros_like(regime)
        counts += np.bincount(regime.astype(np.intp) * _CODES + status, minlength=_CODES * _CODES)
        if len(places) < limit:
            inside = np.flatnonzero(chosen_regimes[regime] & chosen_statuses[status])
            places += _places(inside[: limit - len(places)], chunk)
    table = counts.reshape(_CODES, _CODES)
    pairs = sorted(np.argwhere(table), key=lambda pair: -table[tuple(pair)])
    counted = {(_name("regime", r), _name("status", s) if has_status else NOT_KEPT): int(table[r, s]) for r, s in pairs}
    return Survey(counted, int(table[np.ix_(chosen_regimes, chosen_statuses)].sum()), tuple(_cells(ds, recipe, places)))


def _chosen(flag: str, names: Collection[str]) -> NDArray[np.bool_]:
    """Marks of the codes of a flag that have these names; of all, without any names."""
    known = list(FLAGS[flag])
    chosen = np.full(_CODES, not names)
    for name in names:
        if name not in known:
            near = nearest(name, known)
            hint = f"did you mean {near}?" if near else None
            raise ConfigError(f"--{flag}", [Problem((), f"got {name!r}, expected {listed(known)}", hint=hint)])
        chosen[known.index(name)] = True
    return chosen


def _name(flag: str, code: int) -> str:
    names = list(FLAGS[flag])
    return names[code] if code < len(names) else f"code_{code}"


def _places(inside: NDArray[np.intp], chunk: Chunk) -> list[tuple[int, ...]]:
    """Positions in the map of some cells of a chunk."""
    shape = tuple(part.stop - part.start for part in chunk.values())
    places = np.stack(np.unravel_index(inside, shape), axis=1) if shape else np.zeros((inside.size, 0), np.intp)
    return [tuple(int(i) for i in row) for row in places + [part.start for part in chunk.values()]]


def _cells(ds: xr.Dataset, recipe: Recipe, places: list[tuple[int, ...]]) -> list[Cell]:
    """The cells at some positions."""
    if not places:
        return []
    dims = [str(dim) for dim in ds["regime"].dims]
    picked = {dim: xr.DataArray([place[i] for place in places], dims="picked") for i, dim in enumerate(dims)}
    known = ds[[name for name in ("regime", "status", *_LOOK) if name in ds.variables]].isel(picked).load()
    cells = []
    for i, place in enumerate(places):
        values = known.isel(picked=i) if "picked" in known.dims else known
        position = dict(zip(dims, place, strict=True))
        number = int(np.ravel_multi_index(place, ds["regime"].shape)) if place else 0
        regime, status = (
            _name(flag, int(codes(values[flag])[0])) if flag in values else NOT_KEPT for flag in ("regime", "status")
        )
        settings = tuple(settings_at(recipe, ds, position))
        cells.append(Cell(number, position, regime, status, settings, duration_of(recipe, values)))
    return cells


def duration_of(recipe: Recipe, cell: xr.Dataset) -> float:
    """The time worth looking at a cell, in s: to the horizon, or some cycles, or some oscillations after break-away."""
    solver = recipe.get("solver", {}) if isinstance(recipe, dict) else dict(recipe.solver)  # type: ignore[union-attr]
    known = {name: float(cell[name]) for name in _LOOK if name in cell.variables}
    oscillation = 2.0 * math.pi * math.sqrt(known.get("mass", 1.0) / known.get("stiffness", 1.0))
    begin = known.get("breakaway_time", math.nan)
    cycle = known.get("period", math.nan)
    seen = _CYCLES * cycle if math.isfinite(cycle) else _OSCILLATIONS * oscillation
    duration = seen + (begin if math.isfinite(begin) else 0.0)
    return float(f"{min(duration, solver.get('horizon') or math.inf):.3g}")
