"""The borders of linear theory over maps: where the damping ratio of steady sliding is 0, and where it is 1."""

from __future__ import annotations

from typing import Literal

import matplotlib.patheffects as patheffects
import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.lines import Line2D
from numpy.typing import NDArray

from stickslip.dataset import coarse
from stickslip.dataset.axis import MapAxis
from stickslip.dataset.coarse import Pixel

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
