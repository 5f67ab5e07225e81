"""Values of maps as pixels with colours and hatching, the same in all panels of a figure."""

from collections.abc import Mapping, Sequence

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.patches import PathPatch
from matplotlib.path import Path
from numpy.typing import NDArray

from stickslip.dataset import coarse
from stickslip.dataset.coarse import Pixel
from stickslip.dataset.display import unit_of
from stickslip.errors import PlotError
from stickslip.plots.options import Look
from stickslip.plots.palette import FLAG_COLOURS, HATCHES, Paint, ink, marked, paint
from stickslip.vocabulary.display_units import Unit
from stickslip.vocabulary.flags import FLAGS


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
    present = {code for panel in reduced for code in panel.present}
    if unknown := present - set(range(len(FLAG_COLOURS[variable]))):
        raise PlotError(f"{variable} has codes that this version does not know: {sorted(unknown)}")
    shown = [marked(variable, panel) for panel in reduced]
    return shown, paint(variable, np.concatenate(shown, axis=None), present), Unit()


Floats = NDArray[np.float64]
_MOST = 5000  # rectangles of a regime; more are single cells here and there, on which no hatching shows


def hatch(ax: Axes, variable: str, codes: NDArray[np.generic], x_edges: Floats, y_edges: Floats) -> None:
    """Hatch the cells of those flags that have a pattern. codes : (rows, columns), edges one longer."""
    for name, pattern in patterns(variable).items():
        inside = np.asarray(codes == list(FLAGS[variable]).index(name))
        hatch_cells(ax, inside, pattern, FLAG_COLOURS[variable][name], x_edges, y_edges)


def hatch_cells(
    ax: Axes, inside: NDArray[np.bool_], pattern: str, colour: str, x_edges: Floats, y_edges: Floats
) -> None:
    """Hatch the cells of a colour that are `inside`, (rows, columns); edges one longer."""
    low, high, left, right = rectangles(inside).T
    if not 0 < low.size <= _MOST:
        return
    x, y = x_edges[np.stack([left, right, right, left, left])], y_edges[np.stack([low, low, high, high, low])]
    closed = [Path.MOVETO, *[Path.LINETO] * 3, Path.CLOSEPOLY]
    path = Path(np.stack([x.T, y.T], axis=-1).reshape(-1, 2), np.tile(np.array(closed, np.uint8), low.size))
    ax.add_patch(PathPatch(path, facecolor="none", edgecolor=ink(colour), hatch=pattern, linewidth=0.0, zorder=1.5))


def patterns(variable: str) -> Mapping[str, str]:
    """Matplotlib's patterns by flag, of a variable that has some."""
    return HATCHES if FLAG_COLOURS.get(variable) is FLAG_COLOURS["regime"] else {}


def rectangles(inside: NDArray[np.bool_]) -> NDArray[np.int64]:
    """Rectangles that cover what is inside: rows from and to, columns from and to, (n, 4), the ends excluded."""
    padded = np.zeros((inside.shape[0], inside.shape[1] + 2), np.int8)
    padded[:, 1:-1] = inside
    change = np.diff(padded, axis=1)
    (rows, begins), (_, ends) = np.nonzero(change == 1), np.nonzero(change == -1)
    if not rows.size:
        return np.zeros((0, 4), np.int64)
    order = np.lexsort((rows, ends, begins))
    rows, begins, ends = rows[order], begins[order], ends[order]
    new = np.ones(rows.size, np.bool_)
    new[1:] = (np.diff(rows) != 1) | (np.diff(begins) != 0) | (np.diff(ends) != 0)
    first = np.flatnonzero(new)
    last = np.append(first[1:], rows.size) - 1
    return np.stack([rows[first], rows[last] + 1, begins[first], ends[first]], axis=1).reshape(-1, 4)
