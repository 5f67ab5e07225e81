"""Maps of regimes and of metrics.

A map may have any number of dimensions: the last is the x axis, the last but one the y axis, the others become panels.
Colours are in `palette.py`, axes in `axes.py`.
"""

from __future__ import annotations

from collections.abc import Hashable, Mapping, Sequence
from itertools import product
from math import ceil, prod
from textwrap import fill
from typing import Any, Literal

import matplotlib.patheffects as patheffects
import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.cm import ScalarMappable
from matplotlib.lines import Line2D
from numpy.typing import NDArray

from stickslip.dataset import coarse
from stickslip.dataset.axis import MapAxis
from stickslip.dataset.axis import title as array_title
from stickslip.dataset.coarse import Pixel, pixel_for
from stickslip.dataset.select import selected
from stickslip.errors import PlotError
from stickslip.plots import overlays
from stickslip.plots.axes import apply, wrapped
from stickslip.plots.figure import Figure
from stickslip.plots.page import entitle, legend
from stickslip.plots.palette import BLUE, FLAG_COLOURS, UNDEFINED_COLOUR, Entry, Paint, marked, paint

BORDERS: dict[float, tuple[Literal["solid", "dashed"], str]] = {
    0.0: ("solid", "damping ratio 0 (linear)"),
    1.0: ("dashed", "damping ratio 1 (linear)"),
}
MAX_PANELS = 16

_MAX_PANEL_COLUMNS = 4
_TITLE_WIDTH = 70  # letters in a line above the plot
_BAR_WIDTH = 45  # letters along a colour bar
_PANEL_WIDTH, _PANEL_HEIGHT = 36, 30  # letters along the sides of one of several panels
_PIXELS = (540, 720)  # rows and columns a lone map has on a page of 150 dpi
_PANEL_PIXELS = (270, 340)  # and one of several
_ROW = "row of a strip"  # the second dimension of a map that has one
_HALO = [patheffects.Stroke(linewidth=3.0, foreground="white", alpha=0.8), patheffects.Normal()]


# --- maps -------------------------------------------------------------------------------------------------------------


def plot_map(
    ds: xr.Dataset,
    variable: str = "regime",
    *,
    select: Mapping[str, Any] | None = None,
    borders: bool = True,
    lines: xr.Dataset | None = None,
    title: str | None = None,
) -> Figure:
    """One variable of a map over its last two dimensions, small multiples over the others.

    select : fixes dimensions (`select.places` says how); the title names the points that are drawn.
    borders : draw the borders of linear theory: of stability, and of overshoot. lines : exact borders to draw over maps
        of two dimensions and more, what `border` or `contours` returned for the same cells.
    A map of one dimension becomes a strip of regimes with the variable below it (for a flag, the damping ratio).
    Maps of more cells than pixels are reduced to pixels (`coarse.py`), which a note below says; no cell is skipped,
    and memory stays small. Raises PlotError; StoreError where a file turns out to be damaged.
    """
    if variable not in ds.data_vars:
        raise PlotError(f"no variable {variable!r}; there are {', '.join(map(str, ds.data_vars))}")
    ds, places = selected(ds, select or {})
    title = str(ds.attrs.get("title", "")) if title is None else title
    title = "\n".join(filter(None, [title, wrapped(", ".join(places), _TITLE_WIDTH)]))
    dims = ds[variable].dims
    if not dims:
        raise PlotError("nothing to map: every parameter is fixed\nhint: look at one cell over time with `simulate`")
    if len(dims) == 1:
        return _strip(ds, variable, title)
    return _panels(ds, variable, title, borders, lines)


def _panels(ds: xr.Dataset, variable: str, title: str, borders: bool, lines: xr.Dataset | None) -> Figure:
    """One panel for each combination of the leading dimensions; a single one if there are none."""
    *outer, y_dim, x_dim = ds[variable].dims
    x, y = MapAxis(ds, x_dim), MapAxis(ds, y_dim)
    combinations = list(product(*(range(ds.sizes[dim]) for dim in outer)))
    rows, columns = _panel_layout(ds, outer)
    is_flag = variable in FLAG_COLOURS
    figure = Figure(figsize=(1.3 + 2.6 * columns, 1.6 + 2.3 * rows) if outer else (7.6, 4.6), layout="constrained")
    grid = figure.subplots(rows, columns, sharex=True, sharey=True, squeeze=False)

    panels = [ds.isel(dict(zip(outer, combination, strict=True))) for combination in combinations]
    pixel = pixel_for((y.length, x.length), _PANEL_PIXELS if outer else _PIXELS)
    values, painted = _painted([panel[variable].transpose(y_dim, x_dim) for panel in panels], variable, pixel)
    edges = x.pixel_edges(pixel[1]), y.pixel_edges(pixel[0])
    headings = [MapAxis(ds, dim) for dim in outer]
    drawn: set[float] = set()
    exact = False
    for ax, panel, cells, combination in zip(grid.flat, panels, values, combinations, strict=False):
        ax.set_facecolor(UNDEFINED_COLOUR)
        ax.pcolormesh(*edges, np.ma.masked_invalid(cells), cmap=painted.colours, norm=painted.norm, rasterized=True)
        if borders:
            drawn |= _draw_borders(ax, panel, x, y, pixel)
        exact |= lines is not None and overlays.over_panel(ax, panel, lines, x, y, small=bool(outer))
        if outer:
            words = (wrapped(h.heading(i), _PANEL_WIDTH) for h, i in zip(headings, combination, strict=True))
            ax.set_title("\n".join(words), fontsize="small")
        apply(x, ax, "x")
        apply(y, ax, "y")
    _name_outer_axes(grid, len(combinations), x.title, y.title)

    if not is_flag:
        bar = figure.colorbar(ScalarMappable(painted.norm, painted.colours), ax=grid, pad=0.02)
        bar.set_label(fill(array_title(ds[variable]), _BAR_WIDTH))
    handles = [*painted.handles(), *_border_handles(drawn), *([overlays.entry()] if exact else [])]
    legend(figure, handles, at_right=is_flag and not outer, note=_note(pixel, is_flag))
    entitle(figure, grid.flat[0], title, above_all=bool(outer))
    return figure


def _painted(arrays: Sequence[xr.DataArray], variable: str, pixel: Pixel) -> tuple[list[NDArray[np.generic]], Paint]:
    """The values of every panel, by pixels, and one paint for all of them."""
    if variable not in FLAG_COLOURS:
        values: list[NDArray[np.generic]] = [coarse.numbers(array, pixel).values for array in arrays]
        return values, paint(variable, np.concatenate(values, axis=None))
    reduced = [coarse.flags(array, pixel) for array in arrays]
    present = {code for one in reduced for code in one.present}
    if unknown := present - set(range(len(FLAG_COLOURS[variable]))):
        raise PlotError(f"{variable} has codes that this version does not know: {sorted(unknown)}")
    values = [marked(variable, one) for one in reduced]
    return values, paint(variable, np.concatenate(values, axis=None), present)


def _note(pixel: Pixel, is_flag: bool) -> str | None:
    """How many cells a pixel shows, unless it is one."""
    if pixel == (1, 1):
        return None
    rows, columns = pixel
    cells = f"{columns} x {rows} cells" if rows > 1 and columns > 1 else f"{rows * columns} cells"
    what = "their most frequent value" if is_flag else "the mean of those that have a value"
    return f"each pixel shows {cells}: {what}"


def _panel_layout(ds: xr.Dataset, outer: Sequence[Hashable]) -> tuple[int, int]:
    """Rows and columns of panels: two outer dimensions span a table if it is not too wide, others are wrapped."""
    lengths = [ds.sizes[dim] for dim in outer]
    count = prod(lengths)
    if count > MAX_PANELS:
        dims = ", ".join(f"{dim} ({length})" for dim, length in zip(outer, lengths, strict=True))
        raise PlotError(
            f"{count} panels over {dims}; at most {MAX_PANELS} fit on a page\n"
            f"hint: fix a dimension with select, such as {outer[0]}"
        )
    if len(outer) == 2 and lengths[1] <= _MAX_PANEL_COLUMNS:
        return lengths[0], lengths[1]
    columns = 3 if count in (5, 6, 9) else min(count, _MAX_PANEL_COLUMNS)
    return ceil(count / columns), columns


def _name_outer_axes(grid: NDArray[Any], count: int, x_title: str, y_title: str) -> None:
    """Axis titles at the left and at the bottom of each column, whose last panel may be above an empty place."""
    rows, columns = grid.shape
    size = "medium" if count == 1 else "small"
    if count > 1:
        x_title, y_title = wrapped(x_title, _PANEL_WIDTH), wrapped(y_title, _PANEL_HEIGHT)
    for i, ax in enumerate(grid.flat):
        if i >= count:
            ax.set_axis_off()
            continue
        if i % columns == 0:
            ax.set_ylabel(y_title, fontsize=size)
        if i + columns >= count:
            ax.set_xlabel(x_title, fontsize=size)
            ax.tick_params(labelbottom=True)


def _strip(ds: xr.Dataset, variable: str, title: str) -> Figure:
    """A map of one dimension: the flag as a strip of colours, below it a number as points of the same colours."""
    flag = variable if variable in FLAG_COLOURS else "regime"
    number = "damping_ratio" if variable in FLAG_COLOURS else variable
    x = MapAxis(ds, ds[variable].dims[0])
    shown = [name for name in (flag, number) if name in ds.data_vars]
    heights = [1 if name == flag else 5 for name in shown]
    figure = Figure(figsize=(7.6, 1.2 + 0.6 * sum(heights)), layout="constrained")
    grid = figure.subplots(len(shown), sharex=True, squeeze=False, height_ratios=heights)
    axes: dict[str, Axes] = dict(zip(shown, grid.flat, strict=True))

    handles: list[Entry | Line2D] = []
    colours: dict[str, Any] = {"color": BLUE}
    pixel = pixel_for((1, x.length), _PIXELS)
    rows = {name: ds[name].expand_dims(_ROW) for name in shown}
    if flag in axes:
        (codes,), painted = _painted([rows[flag]], flag, pixel)
        handles += painted.handles()
        colours = {
            "c": np.ma.filled(codes[0].astype(np.float64), np.nan),
            "cmap": painted.colours,
            "norm": painted.norm,
        }
        edges = x.pixel_edges(pixel[1]), [0.0, 1.0]
        axes[flag].pcolormesh(*edges, codes, cmap=painted.colours, norm=painted.norm)
        axes[flag].set_yticks([])
        axes[flag].set_ylabel(flag, rotation=0, ha="right", va="center")
    if number in axes:
        values, points = coarse.numbers(rows[number], pixel).values[0], x.pixel_points(pixel[1])
        axes[number].plot(points, values, color="#888888", linewidth=0.8, zorder=1)
        axes[number].scatter(points, values, s=18, zorder=2, edgecolors="black", linewidths=0.3, **colours)
        axes[number].set_ylabel(array_title(ds[number]))
        if number == "damping_ratio":
            inside = _levels_inside(values)
            for level in inside:
                axes[number].axhline(level, color="black", linestyle=BORDERS[level][0], linewidth=1.0, zorder=0)
            handles += _border_handles(inside)
    for ax in axes.values():
        apply(x, ax, "x")
    axes[shown[-1]].set_xlabel(x.title)
    legend(figure, handles, at_right=True, note=_note(pixel, variable in FLAG_COLOURS))
    entitle(figure, axes[shown[0]], title)
    return figure


def _draw_borders(ax: Axes, panel: xr.Dataset, x: MapAxis, y: MapAxis, pixel: Pixel) -> set[float]:
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
    inside = _levels_inside(ratio)
    for level in inside:
        lines = ax.contour(*points, ratio, levels=[level], colors="black", linewidths=1.2,
                           linestyles=[BORDERS[level][0]])  # fmt: skip
        lines.set_path_effects(_HALO)
    return inside


def _levels_inside(ratio: NDArray[np.float64]) -> set[float]:
    """The borders between the smallest and the largest damping ratio."""
    finite = np.ma.masked_invalid(ratio).compressed()
    return {level for level in BORDERS if finite.size and finite.min() < level < finite.max()}


def _border_handles(levels: set[float]) -> list[Line2D]:
    """Legend entries of the borders."""
    return [
        Line2D([], [], color="black", linewidth=1.2, linestyle=BORDERS[level][0], label=BORDERS[level][1])
        for level in sorted(levels)
    ]
