"""Plots of goals: the region that is quiet, its borders, and what panels have and would need."""

from collections.abc import Mapping
from dataclasses import replace
from typing import Any

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.lines import Line2D

from stickslip.dataset.display import unit_of
from stickslip.dataset.polylines import plane_names
from stickslip.dataset.selection import selected
from stickslip.plots.layout import Figure, legend
from stickslip.plots.maps import plot_map
from stickslip.plots.options import PLAIN, Look
from stickslip.vocabulary.flags import VERDICTS

_MAP = "quiet_probability"
_RING: dict[str, Any] = {"marker": "o", "markersize": 7, "markerfacecolor": "white", "markeredgecolor": "black",
                         "markeredgewidth": 1.6, "linestyle": "none", "zorder": 5}  # fmt: skip
_END: dict[str, Any] = _RING | {"marker": "D", "markersize": 4.5, "markeredgewidth": 1.2}


def plot_goal(ds: xr.Dataset, select: Mapping[str, Any], *, title: str | None = None, look: Look = PLAIN) -> Figure:
    """The probability of being quiet over the plane of each panel, the borders of the goal, a ring at what the panel
    has, and diamonds at the nearest changes of the verdict. Raises PlotError."""
    if title is None:
        title = "\n".join(filter(None, (str(ds.attrs.get("title", "")), str(ds.attrs.get("goal", "")))))
    look = replace(look, limits={_MAP: (0.0, 1.0), **look.limits})
    lines = _lines(ds)
    figure = plot_map(ds, _MAP, select=select, borders=False, lines=lines, title=title, look=look)
    part, _ = selected(ds, select)
    *outer, y, x = map(str, ds[_MAP].dims)
    outer = [dim for dim in outer if dim in part["verdict"].dims]
    panels = np.ndindex(*(part.sizes[dim] for dim in outer))
    for ax, place in zip(figure.axes, panels, strict=False):
        panel = part.isel(dict(zip(outer, place, strict=True)))
        _marks(ax, panel, y, x)
    if not figure.legends:
        return figure
    handles, notes = figure.entries
    if part[f"here_{x}"].notnull().any() and part[f"here_{y}"].notnull().any():
        marked = ("as it is", _RING), ("nearest change", _END)
        handles = [*handles, *(Line2D([], [], label=label, **look) for label, look in marked)]
    legend(figure, handles, notes)
    return figure


def _lines(ds: xr.Dataset) -> xr.Dataset:
    """The borders of what is quiet as those of a map with the dimensions of the panels: without those of what cells
    cannot be."""
    impossible = VERDICTS.index("impossible")
    possible = (ds["verdict_left"].values != impossible) & (ds["verdict_right"].values != impossible)
    nodes = np.repeat(possible, ds["node_count"].values)
    lines = ds.drop_dims([dim for dim in ds.dims if dim not in ("line", "node")]).isel(line=possible, node=nodes)
    dims = [str(dim) for dim in ds["verdict"].dims]
    places = np.unravel_index(lines["panel"].values, ds["verdict"].shape) if dims else ()
    beside = {
        dim: ("line", ds[dim].values[at] if dim in ds.coords else at) for dim, at in zip(dims, places, strict=True)
    }
    names = {name: name.removeprefix("border_") for name in plane_names(ds)}
    lines = lines.rename(names).assign_coords(beside)
    lines["geometry"].attrs["node_coordinates"] = " ".join(names.values())
    return lines


def _marks(ax: Axes, panel: xr.Dataset, y: str, x: str) -> None:
    """A ring at what a panel has, and a line from there to each nearest change."""
    here, units = (float(panel[f"here_{x}"]), float(panel[f"here_{y}"])), (unit_of(panel[x]), unit_of(panel[y]))
    if not np.isfinite(here).all():
        return
    ends = [(float(panel[f"alone_{x}"]), here[1]), (here[0], float(panel[f"alone_{y}"])),
            (float(panel[f"together_{x}"]), float(panel[f"together_{y}"]))]  # fmt: skip
    for end in ends:
        if np.isfinite(end).all():
            way = [unit.of(np.array(pair)) for unit, pair in zip(units, zip(here, end, strict=True), strict=True)]
            ax.plot(*way, color="black", linewidth=2.2, zorder=4)
            ax.plot(*way, color="white", linewidth=1.0, zorder=4)
            ax.plot(*(pair[1:] for pair in way), **_END)
    ax.plot(*(unit.of(value) for unit, value in zip(units, here, strict=True)), **_RING)
