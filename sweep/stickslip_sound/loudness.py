"""Levels of cells: the time-average A-weighted level of the acceleration, from one period of their cycles.

The mean square of a periodic acceleration is the sum of those of its harmonics, each weighted by its frequency: no more
than one period has to be sampled. Where the mass sticks for long, even less: the weighting has forgotten a slip after
a quarter of a second, so that the slip alone is sampled, and the rest of the period is silence.

A-weighting, how much less the ear hears of low and very high tones, is the analytic formula of IEC 61672-1:2013,
Annex E: four poles at 20.6 and 12194 Hz, one each at 107.7 and 737.9 Hz, and 0 dB at 1 kHz.
"""

from collections.abc import Mapping
from typing import Any, Unpack, cast

import numpy as np
import xarray as xr
from numpy.typing import ArrayLike, NDArray

from stickslip import engine
from stickslip.config.grid import build_grid, quantity_of, recipe_of, shared_by
from stickslip.config.model import Config
from stickslip.config.reader import as_config
from stickslip.config.studies import is_config
from stickslip.dataset.build import given_cells, grid_coordinates, provenance, variable_of
from stickslip.engine import Options, Results, Scales, SolverKeywords, joined
from stickslip.progress import Watch, watched
from stickslip.runs.threads import CellsOrConfig
from stickslip.vocabulary.cells import Cells, Parameters, as_cells, taken
from stickslip.vocabulary.parameter import Variable
from stickslip.vocabulary.quantities import PARAMETERS, QUANTITIES, VARIABLES
from stickslip_sound.series import HIGHEST, REACHED, RTOL, Series, cycles_of, samples_for, series_of

LEVEL = Variable(
    "acceleration_level_a", "1", "time-average A-weighted level of the acceleration, dB re 1e-6 m/s2",
    comment="Of the limit cycle, from the Fourier series of one period, up to 20 kHz; IEC 61672-1, ISO 1683. No level "
    "of sound pressure: levels of cells can be compared with each other. NaN where there is no cycle; -inf where "
    "nothing of it is heard.",
)  # fmt: skip
LEVEL_VARIABLES: dict[str, Variable] = {
    name: VARIABLES[name] for name in ("regime", "status", "period", "frequency", "damping_ratio")
} | {LEVEL.name: LEVEL}

Floats = NDArray[np.float64]
_POLES = 20.598997, 107.65265, 737.86223, 12194.217  # Hz
REFERENCE = 1e-6  # m/s2, ISO 1683
OVERSAMPLING = 2  # folds a little onto the highest harmonics: less than 0.01 dB in all
FORGOTTEN = 0.25  # s after which the weighting, whose slowest poles lie at 20.6 Hz, has fallen by exp(-32)
MOST_HARMONICS = 2**17  # of a slip: one that takes longer than 6.5 s is summed up to less than 20 kHz
CLEAR = 100.0  # what is less than so many times the rounding of the samples, in its square, is none
_TOGETHER = 2**20  # samples, about
_BLOCK = 256  # cells


def a_weighting(frequency: ArrayLike) -> NDArray[np.float64]:
    """The factor on the amplitude of a tone of a frequency (Hz): 1 at 1 kHz, 0 at 0."""

    def unscaled(f: Floats) -> Floats:
        f2 = f * f
        p1, p2, p3, p4 = (pole * pole for pole in _POLES)
        return np.asarray(p4 * f2 * f2 / ((f2 + p1) * np.sqrt((f2 + p2) * (f2 + p3)) * (f2 + p4)))

    return unscaled(np.asarray(frequency, np.float64)) / float(unscaled(np.array(1000.0)))


def decibels(factor: ArrayLike) -> NDArray[np.float64]:
    """A ratio of amplitudes in dB; -inf for 0."""
    with np.errstate(divide="ignore"):
        return np.asarray(20.0 * np.log10(np.asarray(factor, np.float64)))


def levels_of(cells: Parameters, options: Options) -> Results:
    """`LEVEL_VARIABLES` of some cells, in this thread; the numbers of a cell do not depend on the others."""
    results = engine.solve(cells, options, engine.stop_flag())
    cycles, level = cycles_of(cells, results, options), np.full(cells["mass"].size, np.nan)
    windows = np.minimum(cycles.moving + FORGOTTEN, cycles.period)
    harmonics = np.minimum((HIGHEST * windows).astype(np.int64), MOST_HARMONICS)
    intervals = samples_for(windows, HIGHEST, Scales(cycles.cells).natural_frequency, OVERSAMPLING)
    ends_of_parts = np.flatnonzero(np.diff(np.cumsum(intervals) // _TOGETHER)) + 1
    for part in np.split(np.arange(intervals.size), ends_of_parts) if intervals.size else ():
        own, count, window = taken(cycles.cells, part), intervals[part], windows[part]
        motions, ends, status = engine.sampled(own, window / count, count + 1, options, cycles.begin[part])
        squares = np.full(part.size, np.nan)
        for i in np.flatnonzero(status == REACHED).tolist():
            series = series_of(motions[i], ends[i], float(window[i]), int(harmonics[part][i]))
            squares[i] = _heard(series, float(np.abs(motions[i]).max()), int(count[i]))
        level[cycles.which[part]] = decibels(np.sqrt(squares * window / cycles.period[part]) / REFERENCE)
    results[LEVEL.name] = level
    return {name: results[name].astype(np.float64) for name in LEVEL_VARIABLES}


def _heard(series: Series, largest: float, count: int) -> float:
    """The weighted mean square of a series (m/s2)^2; 0 where it is lost in the rounding of `count` displacements."""
    weights = a_weighting(series.frequencies) ** 2
    rounding = np.finfo(float).eps * largest * (2.0 * np.pi * series.frequencies) ** 2
    noise = 2.0 * (weights * rounding**2).sum() / count
    heard = float((series.mean_squares * weights).sum())
    return heard if heard > CLEAR * noise else 0.0


# --- of whatever has cells --------------------------------------------------------------------------------------------


def levels(
    cells_or_config: CellsOrConfig,
    *,
    progress: Watch = None,
    **solver: Unpack[SolverKeywords],
) -> xr.Dataset:
    """Compute how loud cells are, to be compared with each other: differences are those of the decibels.

    Every cell is computed again, at a tolerance of 1e-9, and one period is sampled: milliseconds a cell.

    Parameters
    ----------
    cells_or_config : Mapping, Dataset, DataFrame, Config or path
        Cells as `evaluate` takes them; a result of `run` or `evaluate`; a configuration, or its file.
    progress, **solver
        As for `run`; law (of cells that are listed; all others know theirs), max_steps, rtol and threads; or options.

    Returns
    -------
    Dataset
        regime, status, period, frequency, damping_ratio and acceleration_level_a (dB).

    Raises
    ------
    TypeError, ValueError, ConfigError
        For bad input, before anything is computed.
    """
    solver = SolverKeywords(**{"rtol": RTOL, **solver})
    cells, law, text, title = _cells(cells_or_config, solver)
    options = Options.of(SolverKeywords(**{**solver, "law": law}))
    for signals in (False, True):
        engine.warm_up(law, signals)

    def computed(first: int) -> Results:
        part = cells[first : min(first + _BLOCK, cells.size)]
        return levels_of(as_cells({name: part[name] for name in PARAMETERS if name in part}, law), options)

    columns: list[Results] = []
    with watched(progress, "cells", law) as moved:
        for block in engine.in_order(computed, range(0, cells.size, _BLOCK), options.threads):
            columns.append(block)
            if moved:
                moved(min(len(columns) * _BLOCK, cells.size), cells.size)
    whole = joined(columns)
    variables = {name: variable_of(row, cells.dims, whole[name].reshape(cells.shape))
                 for name, row in LEVEL_VARIABLES.items()}  # fmt: skip
    attributes = provenance(text or options.described(), title=title, action="levels of the acceleration")
    return xr.Dataset(variables, grid_coordinates(cells), attributes)


def _cells(given: CellsOrConfig, solver: SolverKeywords) -> tuple[Cells, str, str, str]:
    """The cells, their friction law, their configuration as text where there is one, and a title."""
    if is_config(given):
        config = as_config(given)
        if config.uncertain is not None:
            raise ValueError("uncertain: levels are those of known cells; leave the section out")
        config = config.plain_map()
        return build_grid(config), config.friction.law, config.to_yaml(), f"Levels: {config.title}"
    if isinstance(given, xr.Dataset):
        title = f"Levels: {given.attrs.get('title', 'a map')}"
        return _of_result(given), shared_by(given)["law"], str(given.attrs["configuration"]), title
    options = Options.of(solver).for_contact(cast(Mapping[str, Any], given))
    return given_cells(cast(Mapping[str, Any], given), options), options.law, "", "Levels of cells"


def _of_result(ds: xr.Dataset) -> Cells:
    """The cells of a result, or of a part of one, from its coordinates and what its configuration fixes."""
    recipe, regime = recipe_of(ds, "the dataset"), ds["regime"]
    numbers = {quantity_of(str(name)): values for name, values in ds.coords.items() if values.dtype.kind in "fiu"}
    listed = {name: values.broadcast_like(regime).transpose(*regime.dims).values.ravel()
              for name, values in numbers.items() if name in QUANTITIES}  # fmt: skip
    fixed = recipe.fixed() if isinstance(recipe, Config) else {}
    fixed = {name: value for name, value in fixed.items() if name not in listed}
    coordinates = {str(name): values.variable for name, values in ds.coords.items()}
    return Cells(tuple(map(str, regime.dims)), regime.shape, fixed, listed=listed, labelled=lambda: coordinates)
