"""The exact borders of a view, as lines in the coordinates of its picture."""

from __future__ import annotations

from dataclasses import replace
from math import prod

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from stickslip import borders
from stickslip.config.model import Config, Range
from stickslip.config.options import options_of
from stickslip.dataset.axis import MapAxis
from stickslip.dataset.contours import polylines
from stickslip.engine import Options, StopFlag
from stickslip.explore.maps import Picture
from stickslip.study import Study

Line = tuple[NDArray[np.float64], NDArray[np.float64]]
# To a hundredth of a pixel. What is undecided after so many steps is so close to a border that it does not show:
# a quarter of a pixel at most in the maps tried, where all the steps of maps take six times as long.
_POINTS, _SCAN, _TOLERANCE, _STEPS = 128, 64, 1e-5, 10_000


def border_lines(config: Config, shown: Picture, stop: StopFlag) -> list[Line] | None:
    """Where the regime changes in the map of a configuration: x and y of each line; None if the flag was raised.

    In a plane of two numbers lines with loops; between listed points the crossings of each, as strokes across it.
    """
    y, x = config.axes
    if isinstance(y, Range) and isinstance(x, Range):
        found = _of(_contours(config), stop)
        return None if found is None else _lines(found, shown)
    along = next((axis for axis in (x, y) if isinstance(axis, Range)), None)
    if along is None:
        return []
    found = _of(_crossings(config, along), stop)
    return None if found is None else _strokes(found, shown, along.name == shown.x.name)


def _contours(config: Config) -> Study:
    (y, x), options = config.axes, _options(config)
    plane = borders.plane_over(config, (y.name, x.name), {}, _POINTS, options)
    return borders.ContourStudy(*plane, borders.Limits(_SCAN, _TOLERANCE), options)


def _crossings(config: Config, along: Range) -> Study:
    options = _options(config)
    lines = borders.lines_along(config, along.name, None, _SCAN, options)
    return borders.BorderStudy(*lines, borders.Limits(_SCAN, _TOLERANCE), options)


def _options(config: Config) -> Options:
    options = options_of(config)
    return replace(options, early_stop=True, max_steps=min(options.max_steps, _STEPS))


def _of(study: Study, stop: StopFlag) -> xr.Dataset | None:
    finished = study.compute(range(prod(study.shape)), stop)
    return study.dataset([finished.results], {}) if finished.complete else None


def _lines(found: xr.Dataset, shown: Picture) -> list[Line]:
    return [(shown.x.places(line.x), shown.y.places(line.y)) for line in polylines(found)]


def _strokes(found: xr.Dataset, shown: Picture, along_x: bool) -> list[Line]:
    """The crossings of lines side by side, each as a stroke as wide as its pixel."""
    (across,) = (dim for dim in found["border"].dims if dim != "crossing")
    if MapAxis(found, across).is_numeric:
        found = found.sortby(across)  # as pictures are
    crossings = found["border"].transpose(across, "crossing").values
    beside, along = (shown.y, shown.x) if along_x else (shown.x, shown.y)
    half = 0.5 * (beside.ends[1] - beside.ends[0]) / len(beside.centres)
    strokes: list[Line] = []
    for middle, row in zip(beside.centres, crossings, strict=True):
        for value in row[np.isfinite(row)]:
            ends, level = np.array([middle - half, middle + half]), along.places(np.full(2, value))
            strokes.append((level, ends) if along_x else (ends, level))
    return strokes
