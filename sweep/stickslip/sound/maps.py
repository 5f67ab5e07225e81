"""How loud the cells of a configuration, of a result or of a list are."""

from __future__ import annotations

import json
import os
from collections.abc import Callable, Hashable, Mapping
from dataclasses import dataclass
from math import isfinite, prod
from typing import Any

import numpy as np
import xarray as xr
from numpy.typing import ArrayLike, NDArray

from stickslip.config.grid import build_grid, parameters_of, quantity_of
from stickslip.config.model import Config
from stickslip.config.reader import load_config
from stickslip.config.select import recipe_of
from stickslip.config.studies import STUDIES
from stickslip.dataset.build import cell_coordinates, grid_coordinates, variable_of
from stickslip.dataset.provenance import provenance
from stickslip.engine import Options, Progress, spread, stop_flag, warm_up
from stickslip.sound.loudness import levels_of
from stickslip.sound.making import RTOL
from stickslip.vocabulary.cells import Cells, as_cells
from stickslip.vocabulary.quantities import QUANTITIES
from stickslip.vocabulary.results import LEVEL, LEVEL_VARIABLES

Floats = NDArray[np.float64]
Asked = Mapping[str, ArrayLike] | xr.Dataset | Config | str | os.PathLike[str]

_TOGETHER = 256  # cells


@dataclass(frozen=True)
class _Cells:
    """The cells whose levels are asked for, numbered with the last dimension running fastest."""

    dims: tuple[Hashable, ...]
    shape: tuple[int, ...]
    coordinates: Mapping[Any, Any]
    cells: Callable[[int, int], Cells]
    law: str
    text: str
    title: str


def levels(
    cells_or_config: Asked,
    reference: Mapping[str, float] | None = None,
    *,
    law: str = "stribeck",
    max_steps: int = Options.max_steps,
    threads: int | None = None,
    progress: Progress | None = None,
) -> xr.Dataset:
    """How loud cells are, compared with each other or with a reference.

    cells_or_config : cells as `evaluate` takes them; a result of `run` or `evaluate`; a configuration, or its file.
        The dimensions of what comes back are theirs.
    reference : a cell, with the same law, whose level becomes 0 dB; None for 1e-6 m/s2.
    law : of cells that are given as a mapping; all others know theirs. threads : None for one per processor.
    progress : called with (cells done, cells in all) from time to time.

    Every cell is computed again, at a tolerance of 1e-9, and one period is sampled: milliseconds a cell, the longer the
    slower the vibration.

    Returns regime, status, period, frequency, damping_ratio and acceleration_level_a (dB). Raises TypeError or
    ValueError for bad input, among them a reference without a cycle, and ConfigError for a bad configuration.
    """
    asked = _asked(cells_or_config, law)
    options, stop = Options(asked.law, RTOL, max_steps=int(max_steps), threads=threads), stop_flag()
    zero = _level_of(reference, options)
    warm_up(asked.law, signals=True)
    size = prod(asked.shape)
    found = {name: np.full(size, np.nan) for name in LEVEL_VARIABLES}
    done = 0

    def compute_piece(start: int) -> int:
        part = asked.cells(start, min(start + _TOGETHER, size))
        results, level = levels_of(part, options, stop)
        for name, values in (results | {LEVEL.name: level - zero}).items():
            if name in found:
                found[name][start : start + _TOGETHER] = values
        return level.size

    def count(finished: list[int]) -> None:
        nonlocal done
        done += sum(finished)
        if progress:
            progress(done, size)

    spread(compute_piece, range(0, size, _TOGETHER), threads, stop, count)
    variables = {
        name: variable_of(declared, asked.dims, found[name].reshape(asked.shape))
        for name, declared in LEVEL_VARIABLES.items()
    }
    if reference is not None:
        words = ", ".join(f"{name} = {value:g}" for name, value in reference.items())
        variables[LEVEL.name].attrs |= {
            "long_name": "time-average A-weighted level of the acceleration, dB re a reference cell",
            "reference_cell": words,
        }
    attributes = provenance(asked.text, title=asked.title, action="levels of the acceleration")
    return xr.Dataset(variables, asked.coordinates, attributes)


def _level_of(reference: Mapping[str, float] | None, options: Options) -> float:
    """The level of the reference (dB), 0 without one. Raises ValueError."""
    if reference is None:
        return 0.0
    cell = as_cells(reference)
    if cell["mass"].size != 1:
        raise ValueError("reference: expected one cell, every parameter one number")
    level = float(levels_of(cell, options, stop_flag())[1][0])
    if not isfinite(level):
        raise ValueError("reference: this cell has no cycle that is heard, and so no level to compare with")
    return level


def _asked(cells_or_config: Asked, law: str) -> _Cells:
    if isinstance(cells_or_config, str | os.PathLike):
        cells_or_config = load_config(cells_or_config)
    if isinstance(cells_or_config, Config):
        if cells_or_config.uncertain is not None:
            raise ValueError("uncertain: levels are those of known cells; leave the section out")
        config = cells_or_config.model_copy(update=dict.fromkeys(STUDIES))
        grid = build_grid(config)
        title, text = f"Levels: {config.title}", config.to_yaml()
        return _Cells(grid.dims, grid.shape, grid_coordinates(grid), grid.cells, config.friction.law, text, title)
    if isinstance(cells_or_config, xr.Dataset):
        return _of_dataset(cells_or_config)
    full = as_cells(cells_or_config)
    size, text = full["mass"].size, json.dumps({"friction": {"law": law}})
    coordinates = cell_coordinates(full, size)
    return _Cells(("cell",), (size,), coordinates, _taking(full), law, text, "Levels of cells")


def _of_dataset(ds: xr.Dataset) -> _Cells:
    """The cells of a result, or of a part of one: from its coordinates."""
    recipe = recipe_of(ds, "the dataset")
    law = recipe.friction.law if isinstance(recipe, Config) else str(recipe["friction"]["law"])
    regime = ds["regime"]
    shared = recipe.fixed() if isinstance(recipe, Config) else {}
    known = {name: xr.Variable((), value) for name, value in shared.items()}
    known |= {quantity_of(str(name)): values.variable for name, values in ds.coords.items()}
    known = {name: values for name, values in known.items() if name in QUANTITIES}

    def cells(start: int, stop: int) -> Cells:
        points = np.unravel_index(np.arange(start, stop), regime.shape) if regime.ndim else ()
        place = dict(zip(regime.dims, points, strict=True))
        each = {n: c.values[tuple(place[d] for d in c.dims)] * np.ones(stop - start) for n, c in known.items()}
        return as_cells(parameters_of(each))

    title, text = str(ds.attrs.get("title", "a map")), str(ds.attrs.get("configuration", ""))
    return _Cells(regime.dims, regime.shape, dict(ds.coords), cells, law, text, f"Levels: {title}")


def _taking(cells: Cells) -> Callable[[int, int], Cells]:
    def some(start: int, stop: int) -> Cells:
        return {name: values[start:stop] for name, values in cells.items()}

    return some
