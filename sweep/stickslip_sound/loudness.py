"""Levels of cells: the time-average A-weighted level of the acceleration, from one period of their cycles.

The mean square of a periodic acceleration is the sum of those of its harmonics, each weighted by its frequency: no more
than one period has to be sampled. Where the mass sticks for long, even less: the weighting has forgotten a slip after
a quarter of a second, so that the slip alone is sampled, and the rest of the period is silence.

A-weighting, how much less the ear hears of low and very high tones, is the analytic formula of IEC 61672-1:2013,
Annex E: four poles at 20.6 and 12194 Hz, one each at 107.7 and 737.9 Hz, and 0 dB at 1 kHz.
"""

from collections.abc import Iterator, Mapping, Sequence
from math import isfinite
from typing import Any, Unpack, cast

import numpy as np
import xarray as xr
from numpy.typing import ArrayLike, NDArray

from stickslip.config.grid import build_grid, quantity_of
from stickslip.config.model import Config
from stickslip.config.reader import as_config, is_config
from stickslip.config.select import recipe_of
from stickslip.config.studies import Moved, Study
from stickslip.dataset.build import given_cells, grid_coordinates, variable_of
from stickslip.dataset.provenance import provenance
from stickslip.engine import Options, Results, Scales, SolverKeywords, StopFlag, sampled, solve, stop_flag, warm_up
from stickslip.errors import StoppedError
from stickslip.progress import Watch, watched
from stickslip.runs.memory import CellsOrConfig, compute_study
from stickslip.studies.study import joined
from stickslip.vocabulary.cell_values import as_cells
from stickslip.vocabulary.cells import Cells, Parameters, taken
from stickslip.vocabulary.flags import STATUSES
from stickslip.vocabulary.quantities import PARAMETERS, QUANTITIES
from stickslip_sound.cycles import RTOL, Cycles, cycles_of
from stickslip_sound.series import HIGHEST, samples_for, series_of
from stickslip_sound.variables import LEVEL, LEVEL_VARIABLES

Floats = NDArray[np.float64]
_POLES = 20.598997, 107.65265, 737.86223, 12194.217  # Hz
REFERENCE = 1e-6  # m/s2, ISO 1683
OVERSAMPLING = 2  # folds a little onto the highest harmonics: less than 0.01 dB in all
FORGOTTEN = 0.25  # s after which the weighting, whose slowest poles lie at 20.6 Hz, has fallen by exp(-32)
MOST_HARMONICS = 2**17  # of a slip: one that takes longer than 6.5 s is summed up to less than 20 kHz
CLEAR = 100.0  # what is less than so many times the rounding of the samples, in its square, is none
_MOST_SAMPLES = 2**20  # at once
_REACHED = STATUSES.index("horizon_reached")
_BLOCK = 256  # cells


def _unscaled(frequency: NDArray[np.float64]) -> NDArray[np.float64]:
    f2 = frequency * frequency
    p1, p2, p3, p4 = (pole * pole for pole in _POLES)
    return np.asarray(p4 * f2 * f2 / ((f2 + p1) * np.sqrt((f2 + p2) * (f2 + p3)) * (f2 + p4)))


_AT_1_KHZ = float(_unscaled(np.array(1000.0)))


def a_weighting(frequency: ArrayLike) -> NDArray[np.float64]:
    """The factor on the amplitude of a tone of a frequency (Hz): 1 at 1 kHz, 0 at 0."""
    return _unscaled(np.asarray(frequency, np.float64)) / _AT_1_KHZ


def decibels(factor: ArrayLike) -> NDArray[np.float64]:
    """A ratio of amplitudes in dB; -inf for 0."""
    with np.errstate(divide="ignore"):
        return np.asarray(20.0 * np.log10(np.asarray(factor, np.float64)))


def levels_of(cells: Parameters, options: Options, stop: StopFlag) -> tuple[Results, Floats]:
    """Return what becomes of some cells, by names of `VARIABLES`, and their levels in dB, in this thread.

    NaN where there is no cycle, or its integration failed; -inf where nothing of it is heard: it is all above 20 kHz,
    or a vibration so slow and smooth that its audible harmonics are lost in rounding. The numbers of a cell do not
    depend on the others. Raises StoppedError once `stop` is raised.
    """
    size = cells["mass"].size
    results = solve(cells, options, stop)
    cycles, level = cycles_of(cells, results, options), np.full(size, np.nan)
    windows = np.minimum(cycles.moving + FORGOTTEN, cycles.period)
    harmonics = np.minimum((HIGHEST * windows).astype(np.int64), MOST_HARMONICS)
    intervals = samples_for(windows, HIGHEST, Scales(cycles.cells).natural_frequency, OVERSAMPLING)
    for some in _together(intervals):
        if stop[0]:
            raise StoppedError
        level[cycles.which[some]] = _sampled_levels(cycles, some, windows, harmonics, intervals, options)
    return results, level


def _together(intervals: NDArray[np.int64]) -> Iterator[slice]:
    """Neighbours that are sampled at once."""
    first, total = 0, 0
    for i, number in enumerate(intervals.tolist()):
        if total and total + number > _MOST_SAMPLES:
            yield slice(first, i)
            first, total = i, 0
        total += number
    if total:
        yield slice(first, intervals.size)


def _sampled_levels(
    cycles: Cycles,
    some: slice,
    windows: Floats,
    harmonics: NDArray[np.int64],
    intervals: NDArray[np.int64],
    options: Options,
) -> Floats:
    """The levels of the cycles in a slice, dB."""
    own = taken(cycles.cells, some)
    window, count = windows[some], intervals[some]
    motions, ends, status = sampled(own, window / count, count + 1, options, cycles.begin[some])
    squares = np.full(window.size, np.nan)
    for i in np.flatnonzero(status == _REACHED).tolist():
        series = series_of(motions[i], ends[i], float(window[i]), int(harmonics[some][i]))
        weights = a_weighting(series.frequencies) ** 2
        rounding = np.finfo(float).eps * np.abs(motions[i]).max() * (2.0 * np.pi * series.frequencies) ** 2
        noise = 2.0 * (weights * rounding**2).sum() / count[i]
        heard = (series.mean_squares * weights).sum()
        squares[i] = heard if heard > CLEAR * noise else 0.0
    return decibels(np.sqrt(squares * window / cycles.period[some]) / REFERENCE)


# --- of whatever has cells --------------------------------------------------------------------------------------------


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


def summary(ds: xr.Dataset) -> dict[str, Any]:
    """Numbers of cells with and without a level, and the range of levels (dB), of what `levels` gives."""
    level = ds[LEVEL.name]
    known = level.values[np.isfinite(level.values)]
    ends = (float(known.min()), float(np.median(known)), float(known.max())) if known.size else (None, None, None)
    return {
        "cells": level.size, "without_cycle": int(np.isnan(level.values).sum()),
        "not_heard": int(np.isneginf(level.values).sum()), "with_level": int(known.size),
        **dict(zip(("lowest", "median", "highest"), ends, strict=True)), "long_name": level.attrs["long_name"],
    }  # fmt: skip


class LevelStudy(Study):
    """Levels of cells (dB), its items, over that of a reference."""

    name, counted, weight = "levels", "cells", 4096 // _BLOCK
    columns: Mapping[str, np.dtype[Any]] = dict.fromkeys(LEVEL_VARIABLES, np.dtype(np.float64))

    def __init__(self, cells: Cells, options: Options, reference: float) -> None:
        self._cells, self._reference = cells, reference
        self.dims, self.shape, self.options = cells.dims, cells.shape, options

    def compute(self, items: range, stop: StopFlag, moved: Moved | None = None) -> Results:
        """The levels of a range of cells."""
        parts = [self.blank(range(0))]
        for start in range(items.start, items.stop, _BLOCK):
            part = self._cells[start : min(start + _BLOCK, items.stop)]
            cells = as_cells({name: part[name] for name in PARAMETERS if name in part}, self.options.law)
            results, level = levels_of(cells, self.options, stop)
            results[LEVEL.name] = level - self._reference
            parts.append({name: results[name].astype(np.float64) for name in self.columns})
            if moved:
                moved(level.size)
        return joined(parts)

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
    cell = as_cells(reference, options.law)
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
    options = Options.of(solver).for_contact(cast(Mapping[str, Any], given))
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
