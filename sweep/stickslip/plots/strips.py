"""Maps of one dimension: regimes as a strip of colours, and a number as points below."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.lines import Line2D

from stickslip.dataset import coarse
from stickslip.dataset.axis import MapAxis
from stickslip.dataset.axis import title as array_title
from stickslip.dataset.coarse import pixel_for
from stickslip.dataset.display import unit_of
from stickslip.errors import PlotError
from stickslip.plots import marks
from stickslip.plots.axes import apply, scaled
from stickslip.plots.figure import Figure
from stickslip.plots.hatching import hatch, patterns
from stickslip.plots.held import why_nothing
from stickslip.plots.linear import BORDERS, border_handles, levels_inside
from stickslip.plots.look import Look
from stickslip.plots.page import BESIDE_LEGEND, entitle, legend
from stickslip.plots.painting import note, painted
from stickslip.plots.palette import BLUE, FLAG_COLOURS, Entry

PIXELS = (540, 720)  # rows and columns a lone map has on a page of 150 dpi
_ROW = "row of a strip"  # the second dimension of a map that has one


def plot_strip(ds: xr.Dataset, variable: str, title: str, look: Look, notes: Sequence[str]) -> Figure:
    """A map of one dimension: the flag as a strip of colours, below it a number as points of the same colours.

    The number is `variable`, or the damping ratio where that is a flag. notes : lines below the plot.
    """
    flag = variable if variable in FLAG_COLOURS else "regime"
    number = "damping_ratio" if variable in FLAG_COLOURS else variable
    x = MapAxis(ds, ds[variable].dims[0], log=str(ds[variable].dims[0]) in look.log)
    shown = [name for name in (flag, number) if name in ds.data_vars]
    heights = [1 if name == flag else 5 for name in shown]
    figure = Figure(figsize=(7.6, 1.2 + 0.6 * sum(heights)), layout="constrained")
    grid = figure.subplots(len(shown), sharex=True, squeeze=False, height_ratios=heights)
    axes: dict[str, Axes] = dict(zip(shown, grid.flat, strict=True))

    handles: list[Entry | Line2D] = []
    colours: dict[str, Any] = {"color": BLUE}
    pixel = pixel_for((1, x.length), PIXELS)
    rows = {name: ds[name].expand_dims(_ROW) for name in shown}
    if flag in axes:
        (codes,), paint, _ = painted([rows[flag]], flag, pixel, look)
        handles += paint.handles(patterns(flag) if look.hatched else None)
        colours = {"c": np.ma.filled(codes[0].astype(np.float64), np.nan), "cmap": paint.colours, "norm": paint.norm}
        edges = x.pixel_edges(pixel[1]), np.array([0.0, 1.0])
        axes[flag].pcolormesh(*edges, codes, cmap=paint.colours, norm=paint.norm)
        if look.hatched:
            hatch(axes[flag], flag, codes, *edges)
        axes[flag].set_yticks([])
        axes[flag].set_ylabel(flag.replace("_", " "), rotation=0, ha="right", va="center")
    if number in axes and number == variable and not np.isfinite(ds[number].values).any():
        raise PlotError(why_nothing(ds, variable))
    if number in axes:
        handles += _points(axes[number], rows[number], x, pixel, colours, look)
    for ax in axes.values():
        apply(x, ax, "x", look)
        for mark in look.marks:
            ax.axvline(marks.position(x, mark.at[str(x.dim)]), **marks.LINE)
    for mark in look.marks:
        place = marks.position(x, mark.at[str(x.dim)])
        axes[shown[0]].annotate(mark.label, (place, 1.0), xycoords=("data", "axes fraction"), xytext=(0, 2),
                                textcoords="offset points", ha="center", fontweight="bold")  # fmt: skip
    axes[shown[-1]].set_xlabel(x.title)
    handles += marks.entries(look.marks, ds, line=True)
    legend(figure, handles, at_right=True, notes=[note(pixel, variable in FLAG_COLOURS), *notes])
    entitle(figure, axes[shown[0]], title, width=BESIDE_LEGEND)
    return figure


def _points(
    ax: Axes, row: xr.DataArray, x: MapAxis, pixel: tuple[int, int], colours: dict[str, Any], look: Look
) -> list[Line2D]:
    """A number over the axis as points; the entries of the legend."""
    values, points = coarse.numbers(row, pixel).values[0], x.pixel_points(pixel[1])
    unit, name = unit_of(row, values), str(row.name)
    values = unit.of(values)
    if x.is_numeric:  # between named points there is nothing
        ax.plot(points, values, color="#888888", linewidth=0.8, zorder=1)
    ax.scatter(points, values, s=18, zorder=2, edgecolors="black", linewidths=0.3, **colours)
    ax.set_ylabel(array_title(row, unit))
    scaled(ax, "y", name, unit, look)
    if name != "damping_ratio":
        return []
    inside = levels_inside(values)
    for level in inside:
        ax.axhline(level, color="black", linestyle=BORDERS[level][0], linewidth=1.0, zorder=0)
    return border_handles(inside)
