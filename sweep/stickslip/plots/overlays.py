"""Lines over maps: borders of linear theory, and exact ones."""

from __future__ import annotations

from typing import Any, Literal

import matplotlib.patheffects as patheffects
import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.lines import Line2D
from numpy.typing import NDArray

from stickslip.dataset import coarse
from stickslip.dataset.coarse import Pixel
from stickslip.dataset.display import MapAxis
from stickslip.dataset.polylines import border_lines, other_cells
from stickslip.errors import PlotError

BORDERS: dict[float, tuple[Literal["solid", "dashed"], str]] = {
    0.0: ("solid", "damping ratio 0 (linear)"),
    1.0: ("dashed", "damping ratio 1 (linear)"),
}
_HALO = [patheffects.Stroke(linewidth=3.0, foreground="white", alpha=0.8), patheffects.Normal()]


def draw_borders(ax: Axes, panel: xr.Dataset, x: MapAxis, y: MapAxis, pixel: Pixel) -> set[float]:
    """Contours of the linear damping ratio; returns the levels that lie inside the panel.

    They go through the values at single cells, so that pixels do not blur or shift them; if the map is refined, between
    those that are computed in any case.
    """
    if not (x.is_numeric and y.is_numeric and "damping_ratio" in panel.data_vars):
        return set()
    if min(x.length, y.length) < 2:
        return set()
    cells, box = panel["damping_ratio"].transpose(y.dim, x.dim), panel.attrs.get("refine_box")
    ratio = np.ma.masked_invalid(coarse.between(cells, pixel, box) if box else coarse.centres(cells, pixel))
    points = x.pixel_points(pixel[1]), y.pixel_points(pixel[0])
    inside = levels_inside(ratio)
    for level in inside:
        lines = ax.contour(*points, ratio, levels=[level], colors="black", linewidths=1.2,
                           linestyles=[BORDERS[level][0]])  # fmt: skip
        lines.set_path_effects(_HALO)
    return inside


def levels_inside(ratio: NDArray[np.float64]) -> set[float]:
    """The borders between the smallest and the largest damping ratio."""
    finite = np.ma.masked_invalid(ratio).compressed()
    return {level for level in BORDERS if finite.size and finite.min() < level < finite.max()}


def border_handles(levels: set[float]) -> list[Line2D]:
    """Legend entries of the borders."""
    return [
        Line2D([], [], color="black", linewidth=1.2, linestyle=BORDERS[level][0], label=BORDERS[level][1])
        for level in sorted(levels)
    ]


def over_panel(ax: Axes, panel: xr.Dataset, lines: xr.Dataset, x: MapAxis, y: MapAxis, *, small: bool = False) -> None:
    """Draw the borders that a dataset holds for one panel of a map, labelled. Raises PlotError.

    White with a black edge: it reads on every colour of a map, in grey too, and is no line of theory.
    small : the panel is one of several.
    """
    at = {name: one.values[()] for name, one in panel.coords.items() if not one.dims}
    if why := other_cells(lines, at):
        raise PlotError(f"the borders are those of other cells: {why}")
    inner, outer = (0.9, 2.1) if small else (1.6, 3.2)
    casing = [patheffects.Stroke(linewidth=outer, foreground="black"), patheffects.Normal()]
    for line in border_lines(lines, x, y, at):
        dot: dict[str, Any] = {"marker": "o", "markersize": 3.0} if len(line.x) == 1 else {}
        ax.plot(x.unit.of(line.x), y.unit.of(line.y), color="white", linewidth=inner, solid_capstyle="round",
                solid_joinstyle="round", path_effects=casing, zorder=3, label="border, exact", **dot)  # fmt: skip
