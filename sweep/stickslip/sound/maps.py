"""How loud the cells of a configuration, of a result or of a list are."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from math import isfinite
from typing import Any, Unpack, cast

import numpy as np
import xarray as xr

from stickslip.config.grid import build_grid, quantity_of
from stickslip.config.model import Config
from stickslip.config.reader import as_config, is_config
from stickslip.config.select import recipe_of
from stickslip.config.studies import Finished, Moved, Study
from stickslip.dataset.build import grid_coordinates, variable_of
from stickslip.dataset.given import given_cells
from stickslip.dataset.provenance import provenance
from stickslip.engine import Options, Results, SolverKeywords, StopFlag, stop_flag, warm_up
from stickslip.errors import StoppedError
from stickslip.progress import Watch, watched
from stickslip.runs.memory import CellsOrConfig, compute_study
from stickslip.sound.loudness import levels_of
from stickslip.sound.making import RTOL
from stickslip.studies.study import joined
from stickslip.vocabulary.cell_values import as_cells
from stickslip.vocabulary.cells import Cells
from stickslip.vocabulary.quantities import PARAMETERS, QUANTITIES
from stickslip.vocabulary.results import LEVEL, LEVEL_VARIABLES

_TOGETHER = 256  # cells


def levels(
    cells_or_config: CellsOrConfig,
    reference: Mapping[str, float] | None = None,
    *,
    progress: Watch = None,
    **solver: Unpack[SolverKeywords],
) -> xr.Dataset:
    """Compute how loud cells are, compared with each other or with a reference.

    Every cell is computed again, at a tolerance of 1e-9, and one period is sampled: milliseconds a cell, the longer the
    slower the vibration.

    Parameters
    ----------
    cells_or_config : Mapping, Dataset, DataFrame, Config or path
        Cells as `evaluate` takes them; a result of `run` or `evaluate`; a configuration, or its file. The dimensions of
        what comes back are theirs.
    reference : Mapping of str to float, optional
        A cell, with the same law, whose level becomes 0 dB; by default that is 1e-6 m/s2.
    progress : bool, "auto" or callable, optional
        As for `run`.
    **solver
        law (of cells that are listed; all others know theirs), max_steps, rtol and threads; or options.

    Returns
    -------
    Dataset
        regime, status, period, frequency, damping_ratio and acceleration_level_a (dB).

    Raises
    ------
    TypeError, ValueError, ConfigError
        For bad input, among it a reference without a cycle, before anything is computed.
    """
    solver = SolverKeywords(**{"rtol": RTOL, **solver})
    cells, law, text, title = _cells(cells_or_config, solver)
    options = Options.of(SolverKeywords(**{**solver, "law": law}))
    study = LevelStudy(cells, options, _level_of(reference, options))
    warm_up(law, signals=True)
    attributes = provenance(text or options.described(), title=title, action="levels of the acceleration")
    with watched(progress, study.counted, law) as moved:
        dataset = study.dataset(compute_study(study, moved), attributes)
    if reference is not None:
        dataset[LEVEL.name].attrs |= {
            "long_name": "time-average A-weighted level of the acceleration, dB re a reference cell",
            "reference_cell": ", ".join(f"{name} = {value:g}" for name, value in reference.items()),
        }
    return dataset


class LevelStudy(Study):
    """Levels of cells (dB), its items, over that of a reference."""

    name, counted, weight = "levels", "cells", 4096 // _TOGETHER
    columns: Mapping[str, np.dtype[Any]] = dict.fromkeys(LEVEL_VARIABLES, np.dtype(np.float64))

    def __init__(self, cells: Cells, options: Options, reference: float) -> None:
        self._cells, self._reference = cells, reference
        self.dims, self.shape, self.options = cells.dims, cells.shape, options

    def compute(self, items: range, stop: StopFlag, moved: Moved | None = None) -> Finished:
        """The levels of a range of cells."""
        parts = [self.blank(range(0))]
        for start in range(items.start, items.stop, _TOGETHER):
            part = self._cells[start : min(start + _TOGETHER, items.stop)]
            cells = as_cells({name: part[name] for name in PARAMETERS if name in part})
            try:
                results, level = levels_of(cells, self.options, stop)
            except StoppedError:
                return Finished({}, False)
            results[LEVEL.name] = level - self._reference
            parts.append({name: results[name].astype(np.float64) for name in self.columns})
            if moved:
                moved(level.size)
        return Finished(joined(parts))

    def blank(self, items: range) -> Results:
        """Cells of which nothing is known."""
        return {name: np.full(len(items), np.nan) for name in self.columns}

    def dataset(self, parts: Sequence[Results], attributes: Mapping[str, Any]) -> xr.Dataset:
        """The levels with the dimensions of the cells."""
        whole = joined(parts)
        variables = {
            name: variable_of(declared, self.dims, whole[name].reshape(self.shape))
            for name, declared in LEVEL_VARIABLES.items()
        }
        return xr.Dataset(variables, grid_coordinates(self._cells), dict(attributes))


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


def _cells(given: CellsOrConfig, solver: SolverKeywords) -> tuple[Cells, str, str, str]:
    """The cells, their friction law, their configuration as text where there is one, and a title."""
    if is_config(given):
        config = as_config(given)
        if config.uncertain is not None:
            raise ValueError("uncertain: levels are those of known cells; leave the section out")
        config = config.plain_map()
        return build_grid(config), config.friction.law, config.to_yaml(), f"Levels: {config.title}"
    if isinstance(given, xr.Dataset):
        cells, law = _of_result(given)
        title = f"Levels: {given.attrs.get('title', 'a map')}"
        return cells, law, str(given.attrs.get("configuration", "")), title
    options = Options.of(solver)
    return given_cells(cast(Mapping[str, Any], given), options), options.law, "", "Levels of cells"


def _of_result(ds: xr.Dataset) -> tuple[Cells, str]:
    """The cells of a result, or of a part of one, from its coordinates; and their friction law."""
    recipe, regime = recipe_of(ds, "the dataset"), ds["regime"].variable
    if isinstance(recipe, Config):
        shared, law = recipe.fixed(), recipe.friction.law
    else:
        shared, law = {}, str(recipe["friction"]["law"])
    known = {name: xr.Variable((), value) for name, value in shared.items()}
    known |= {quantity_of(str(name)): values.variable for name, values in ds.coords.items()}
    known = {name: values for name, values in known.items() if name in QUANTITIES}
    listed = {name: np.ravel(xr.broadcast(xr.DataArray(values), ds["regime"])[0].transpose(*regime.dims).values)
              for name, values in known.items() if values.ndim}  # fmt: skip
    fixed = {name: float(values) for name, values in known.items() if not values.ndim}
    coordinates = {str(name): values.variable for name, values in ds.coords.items()}
    return Cells(tuple(map(str, regime.dims)), regime.shape, fixed, listed=listed, labelled=lambda: coordinates), law
