"""Values of maps as pixels with colours, the same in all panels of a figure."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from stickslip.dataset import coarse
from stickslip.dataset.coarse import Pixel
from stickslip.dataset.display import Unit, unit_of
from stickslip.errors import PlotError
from stickslip.plots.look import Look
from stickslip.plots.palette import FLAG_COLOURS, Paint, marked, paint


def painted(
    arrays: Sequence[xr.DataArray], variable: str, pixel: Pixel, look: Look
) -> tuple[list[NDArray[np.generic]], Paint, Unit]:
    """The values of every panel, by pixels and in the unit in which they are shown; one paint for all of them.

    Raises PlotError for codes of a newer version, and for colours that numbers cannot have.
    """
    if variable not in FLAG_COLOURS:
        numbers = [coarse.numbers(array, pixel).values for array in arrays]
        unit = unit_of(arrays[0], np.concatenate(numbers, axis=None))
        shown: list[NDArray[np.generic]] = [unit.of(values) for values in numbers]
        limits = look.limits.get(variable)
        ends = None if limits is None else (unit.of(limits[0]), unit.of(limits[1]))
        return shown, paint(variable, np.concatenate(shown, axis=None), limits=ends, log=variable in look.log), unit
    if variable in look.log or variable in look.limits:
        raise PlotError(f"{variable} has names, no numbers: its colours have no scale and no limits")
    reduced = [coarse.flags(array, pixel) for array in arrays]
    present = {code for one in reduced for code in one.present}
    if unknown := present - set(range(len(FLAG_COLOURS[variable]))):
        raise PlotError(f"{variable} has codes that this version does not know: {sorted(unknown)}")
    shown = [marked(variable, one) for one in reduced]
    return shown, paint(variable, np.concatenate(shown, axis=None), present), Unit()


def note(pixel: Pixel, is_flag: bool) -> str | None:
    """How many cells a pixel shows, unless it is one."""
    if pixel == (1, 1):
        return None
    rows, columns = pixel
    cells = f"{columns} x {rows} cells" if rows > 1 and columns > 1 else f"{rows * columns} cells"
    what = "their most frequent value" if is_flag else "the mean of those that have a value"
    return f"each pixel shows {cells}: {what}"
