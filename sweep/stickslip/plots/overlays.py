"""Exact borders over maps, and by themselves."""

from __future__ import annotations

import matplotlib.patheffects as patheffects
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.lines import Line2D

from stickslip.dataset.axis import MapAxis
from stickslip.dataset.polylines import border_lines, other_cells
from stickslip.errors import PlotError

# White with a black edge: it reads on every colour of a map, in grey too, and is no line of theory, which is black.
_CASING = [patheffects.Stroke(linewidth=3.2, foreground="black"), patheffects.Normal()]
_LOOKS = {"color": "white", "linewidth": 1.6, "solid_capstyle": "round", "solid_joinstyle": "round"}
_LABEL = "border, exact"


def over_panel(ax: Axes, panel: xr.Dataset, lines: xr.Dataset, x: MapAxis, y: MapAxis) -> bool:
    """Draw the borders that a dataset holds for one panel of a map; whether there were any. Raises PlotError."""
    at = {name: one.values[()] for name, one in panel.coords.items() if not one.dims}
    if why := other_cells(lines, at):
        raise PlotError(f"the borders are those of other cells: {why}")
    found = list(border_lines(lines, x, y, at))
    for line in found:
        shape = {"marker": "o", "markersize": 3.0} if len(line.x) == 1 else {}
        ax.plot(line.x, line.y, path_effects=_CASING, zorder=3, **_LOOKS, **shape)  # type: ignore[arg-type]
    return bool(found)


def entry() -> Line2D:
    """The entry of the legend."""
    return Line2D([], [], label=_LABEL, path_effects=_CASING, **_LOOKS)  # type: ignore[arg-type]
