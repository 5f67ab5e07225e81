"""Hatching, so that regimes whose colours are alike in grey are told apart on a printed page.

One patch per regime and panel: its cells as rectangles, runs of a row with the equal runs of the rows below. So it is
drawn in milliseconds, and ends where the cells do.
"""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from matplotlib.axes import Axes
from matplotlib.patches import PathPatch
from matplotlib.path import Path
from numpy.typing import NDArray

from stickslip.plots.palette import FLAG_COLOURS, HATCHES, ink
from stickslip.vocabulary.flags import FLAGS

Floats = NDArray[np.float64]
_MOST = 5000  # rectangles of a regime; more are single cells here and there, on which no hatching shows
_RECTANGLE = [Path.MOVETO, Path.LINETO, Path.LINETO, Path.LINETO, Path.CLOSEPOLY]


def hatch(ax: Axes, variable: str, codes: NDArray[np.generic], x_edges: Floats, y_edges: Floats) -> None:
    """Hatch the cells of those flags that have a pattern. codes : (rows, columns), edges one longer."""
    for name, pattern in patterns(variable).items():
        found = rectangles(np.asarray(codes == list(FLAGS[variable]).index(name)))
        if 0 < len(found) <= _MOST:
            corners = np.stack([x_edges[found[:, 2]], x_edges[found[:, 3]], y_edges[found[:, 0]], y_edges[found[:, 1]]])
            ax.add_patch(_patch(corners.T, pattern, ink(FLAG_COLOURS[variable][name])))


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


def _patch(corners: Floats, pattern: str, colour: str) -> PathPatch:
    """Rectangles (left, right, bottom, top) as one patch."""
    left, right, bottom, top = corners.T
    points = (left, bottom), (right, bottom), (right, top), (left, top), (left, bottom)
    around = np.stack([np.stack(point, axis=1) for point in points], axis=1)
    path = Path(around.reshape(-1, 2), np.tile(np.array(_RECTANGLE, np.uint8), len(corners)))
    return PathPatch(path, facecolor="none", edgecolor=colour, hatch=pattern, linewidth=0.0, zorder=1.5)
