"""The plot of materials compared: points, curves and bands, and beside them the speeds above which they are quiet."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.lines import Line2D
from matplotlib.patches import Patch
from matplotlib.ticker import FuncFormatter, NullFormatter

from stickslip.dataset.materials import speeds_of
from stickslip.plots.curves import Drawn, draw_materials, look_of
from stickslip.plots.figure import Figure
from stickslip.plots.page import ROW, entitle, legend
from stickslip.plots.palette import BLACK, FLAG_COLOURS
from stickslip.vocabulary import units
from stickslip.vocabulary.flags import QUIET_STATES

_ROOM = 1.6  # factor by which the axis of speeds reaches beyond what is on it
_INSET = 0.015  # of the axis of speeds
_LOUD, _CALM = FLAG_COLOURS["regime"]["stick_slip"], FLAG_COLOURS["regime"]["damped"]


def plot_materials(ds: xr.Dataset, *, title: str | None = None) -> Figure:
    """What `stickslip.compare` returned: friction over slip speed, and for each material where vibration ends.

    Materials are in their order, the best on top; their names, at the right of the bars, are the legend of both sides.
    Bars say what is known of the border.
    """
    unit = str(ds["quiet_above"].attrs.get("display_units", "m/s"))
    count = ds.sizes["material"]
    figure = Figure(figsize=(9.6, max(5.4, 1.8 + 0.32 * count)), layout="constrained")
    curves, bars = figure.subplots(1, 2, width_ratios=[1.2, 1])
    draw_materials(curves, [_drawn(ds, i) for i in range(count)], unit, log=True)
    _draw_borders(bars, ds, unit)
    _legend(figure, ds, unit)
    text = str(ds.attrs.get("title", "")) if title is None else title
    entitle(figure, curves, text, above_all=True)
    return figure


def _drawn(ds: xr.Dataset, i: int) -> Drawn:
    """A material as its curve is drawn."""
    name = str(ds["material"].values[i])
    own = ds["point_material"].values == name
    shown = np.isfinite(ds["friction"].values[i])
    sigma = ds["point_sigma"].values[own] if "point_sigma" in ds else None
    grid, speed = ds["slip_speed"].values[shown], ds["point_speed"].values[own]
    curve = [ds[column].values[i][shown] for column in ("friction", "friction_low", "friction_high")]
    known = sigma is not None and bool(np.isfinite(sigma).all()) and sigma.size > 0
    return Drawn(name, speed, ds["point_friction"].values[own], sigma if known else None, grid, *curve)


def _draw_borders(ax: Axes, ds: xr.Dataset, unit: str) -> None:
    """A row a material: vibration in the colour of stick-slip, quiet in that of a decay, and what lies between them."""
    factor = 1.0 / units.si_value(f"1 {unit}", "m s-1")
    least, most = factor * float(ds.attrs["searched_from"]), factor * float(ds.attrs["searched_to"])
    ends = _ends(ds, factor, least, most)
    for i in range(ds.sizes["material"]):
        border, state = factor * float(ds["quiet_above"].values[i]), QUIET_STATES[int(ds["quiet_state"].values[i])]
        look = look_of(i)
        ax.plot([1.04, 1.09, 1.14], [i] * 3, **look, markevery=[1], transform=ax.get_yaxis_transform(), clip_on=False)
        name = str(ds["material"].values[i])
        ax.text(1.18, i, name, label=name, transform=ax.get_yaxis_transform(), va="center", gid=ROW)
        if state == "not_determined":
            ax.text(ends[0] * 1.05, i, "not determined", va="center", fontsize="small")
            continue
        bar: dict[str, Any] = {"height": 0.62, "edgecolor": BLACK, "linewidth": 0.5}
        begin = ends[0] if state == "quiet_throughout" else border
        ax.barh(i, begin - ends[0], left=ends[0], color=_LOUD, hatch="////", alpha=0.75, **bar)
        ax.barh(i, ends[1] - begin, left=begin, color=_CALM, alpha=0.6, **bar)
        if "quiet_above_low" in ds:
            _draw_interval(ax, i, [factor * float(ds[f"quiet_above_{end}"].values[i]) for end in ("low", "high")], ends)
        mark = {"quiet_throughout": "<", "vibrates_throughout": ">"}.get(state, look["marker"])
        inset = (ends[1] / ends[0]) ** _INSET  # an arrow at the edge of the axes points out of it, and stays whole
        place = min(max(border, ends[0] * inset), ends[1] / inset)
        ax.plot(place, i, **look | {"marker": mark}, markersize=6, zorder=5 if mark in "<>" else 3)
    for speed in speeds_of(ds):
        ax.axvline(factor * speed, color=BLACK, linestyle="dashdot", linewidth=1.2)
    ax.set_yticks([])
    ax.set_ylim(ds.sizes["material"] - 0.5, -0.5)
    ax.set(xlim=ends, xlabel=f"belt speed ({unit})", xscale="log")
    ax.xaxis.set_major_formatter(FuncFormatter(lambda value, _: f"{value:g}"))
    ax.xaxis.set_minor_formatter(NullFormatter())


def _draw_interval(ax: Axes, i: int, interval: list[float], ends: tuple[float, float]) -> None:
    """The interval of a border, as far as the axis goes."""
    if any(map(math.isnan, interval)):
        return
    low, high = (min(max(end, ends[0]), ends[1]) for end in interval)
    ax.plot([low, high], [i, i], color=BLACK, linewidth=2.2, solid_capstyle="butt", zorder=4)
    for place, end in ((low, interval[0]), (high, interval[1])):
        if ends[0] < end < ends[1]:
            ax.plot([place, place], [i - 0.2, i + 0.2], color=BLACK, linewidth=1.6, zorder=4)


def _ends(ds: xr.Dataset, factor: float, least: float, most: float) -> tuple[float, float]:
    """The axis of speeds: what was measured, the borders and their intervals, and the belt speed."""
    shown = [factor * float(value) for value in ds["point_speed"].values if value > 0]
    shown += [factor * float(value) for value in ds["slip_speed"].values if value > 0]
    for name in ("quiet_above", "quiet_above_low", "quiet_above_high"):
        if name in ds:
            shown += [factor * float(value) for value in ds[name].values if value > 0 and math.isfinite(value)]
    shown += [factor * speed for speed in speeds_of(ds)]
    inside = [value for value in shown if least <= value <= most] or [least, most]
    return max(min(inside) / _ROOM, least), min(max(inside) * _ROOM, most)


def _legend(figure: Figure, ds: xr.Dataset, unit: str) -> None:
    level = f"{100 * float(ds.attrs['confidence']):g} % interval of the border"
    handles: list[Any] = [
        Patch(facecolor=_LOUD, hatch="////", alpha=0.75, edgecolor=BLACK, linewidth=0.5, label="vibrates"),
        Patch(facecolor=_CALM, alpha=0.6, edgecolor=BLACK, linewidth=0.5, label="quiet"),
    ]
    if "quiet_above_low" in ds:
        handles.append(Line2D([], [], color=BLACK, linewidth=2.2, label=level))
    if asked := speeds_of(ds):
        speeds = [f"{speed / units.si_value(f'1 {unit}', 'm s-1'):g}" for speed in asked]
        label = f"belt speed {(' to ' if 'speed_range_from' in ds.attrs else ', ').join(speeds)} {unit}"
        handles.append(Line2D([], [], color=BLACK, linestyle="dashdot", linewidth=1.2, label=label))
    legend(figure, handles, at_right=False)
