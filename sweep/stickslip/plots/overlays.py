"""Exact borders over maps."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import matplotlib.patheffects as patheffects
import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.lines import Line2D
from matplotlib.patches import Polygon

from stickslip.dataset.axis import MapAxis
from stickslip.dataset.polylines import Polyline, border_lines, other_cells
from stickslip.errors import PlotError

_LABEL = "border, exact"


def over_panel(ax: Axes, panel: xr.Dataset, lines: xr.Dataset, x: MapAxis, y: MapAxis, *, small: bool = False) -> bool:
    """Draw the borders that a dataset holds for one panel of a map; whether there were any. Raises PlotError.

    small : the panel is one of several.
    """
    at = {name: one.values[()] for name, one in panel.coords.items() if not one.dims}
    if why := other_cells(lines, at):
        raise PlotError(f"the borders are those of other cells: {why}")
    found = list(border_lines(lines, x, y, at))
    for line in found:
        _draw(ax, replace(line, x=x.unit.of(line.x), y=y.unit.of(line.y)), _looks(small))
    return bool(found)


def entry() -> Line2D:
    """The entry of the legend."""
    return Line2D([], [], label=_LABEL, **_looks(False))


def _draw(ax: Axes, line: Polyline, looks: dict[str, Any]) -> None:
    """One line; a loop without a seam, a single point as a dot."""
    if line.closed:
        looks = {"edgecolor" if key == "color" else key: value for key, value in looks.items()}
        caps = {"joinstyle": looks.pop("solid_joinstyle"), "capstyle": looks.pop("solid_capstyle")}
        ax.add_patch(Polygon(np.stack([line.x, line.y], axis=1)[:-1], fill=False, zorder=3, **looks, **caps))
        return
    dot: dict[str, Any] = {"marker": "o", "markersize": 3.0} if len(line.x) == 1 else {}
    ax.plot(line.x, line.y, zorder=3, **looks, **dot)


def _looks(small: bool) -> dict[str, Any]:
    """White with a black edge: it reads on every colour of a map, in grey too, and is no line of theory."""
    inner, outer = (0.9, 2.1) if small else (1.6, 3.2)
    casing = [patheffects.Stroke(linewidth=outer, foreground="black"), patheffects.Normal()]
    return {"color": "white", "linewidth": inner, "solid_capstyle": "round", "solid_joinstyle": "round",
            "path_effects": casing}  # fmt: skip
