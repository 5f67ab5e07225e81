"""Maps of regimes and of metrics.

A map may have any number of dimensions: the last is the x axis, the last but one the y axis, the others become panels.
Colours are in `palette.py`, axes in `axes.py`, what may be wished besides in `look.py`. Numbers are in the units in
which they are shown (`dataset/display.py`).
"""

from __future__ import annotations

from collections.abc import Hashable, Mapping, Sequence
from itertools import product
from math import ceil, prod
from typing import Any

import numpy as np
import xarray as xr
from matplotlib.cm import ScalarMappable
from numpy.typing import NDArray

from stickslip.dataset.axis import MapAxis
from stickslip.dataset.axis import title as array_title
from stickslip.dataset.coarse import pixel_for
from stickslip.dataset.kept import why_absent
from stickslip.dataset.panels import MAX_PANELS
from stickslip.dataset.select import selected
from stickslip.errors import PlotError
from stickslip.plots import marks, overlays
from stickslip.plots.axes import apply, plain_numbers
from stickslip.plots.figure import Figure
from stickslip.plots.hatching import hatch, patterns
from stickslip.plots.held import held_note, why_nothing
from stickslip.plots.linear import border_handles, draw_borders
from stickslip.plots.look import PLAIN, Look
from stickslip.plots.page import BESIDE_LEGEND, TITLE_WIDTH, entitle, folded, legend, wrapped
from stickslip.plots.painting import note, painted
from stickslip.plots.palette import FLAG_COLOURS, UNDEFINED_COLOUR, UNDEFINED_HATCH, ink
from stickslip.plots.strips import PIXELS, plot_strip
from stickslip.vocabulary.suggest import nearest

_MAX_PANEL_COLUMNS = 4
_BAR_WIDTH = 45  # letters along a colour bar
_PANEL_WIDTH, _PANEL_HEIGHT = 36, 30  # letters along the sides of one of several panels
_PANEL_PIXELS = (270, 340)  # rows and columns of one of several panels


def plot_map(
    ds: xr.Dataset,
    variable: str = "regime",
    *,
    select: Mapping[str, Any] | None = None,
    borders: bool = True,
    lines: xr.Dataset | None = None,
    title: str | None = None,
    look: Look = PLAIN,
) -> Figure:
    """One variable of a map over its last two dimensions, small multiples over the others.

    select : fixes dimensions (`select.places` says how). title : that of the dataset with the points that are selected,
        unless given; then the note below says them.
    borders : draw the borders of linear theory: of stability, and of overshoot. lines : exact borders to draw over maps
        of two dimensions and more, what `border` or `contours` returned for the same cells.
    look : scales, limits, operating points, hatching.
    A map of one dimension becomes a strip of regimes with the variable below it (for a flag, the damping ratio).
    Maps of more cells than pixels are reduced to pixels (`coarse.py`), which a note below says; no cell is skipped,
    and memory stays small. Raises PlotError, also where the variable has no value at all, saying why; StoreError where
    a file turns out to be damaged.
    """
    if variable not in ds.data_vars:
        absent = why_absent(ds, variable)
        near = nearest(variable, map(str, ds.data_vars))
        hint = f"; did you mean {near}?" if near else ""
        raise PlotError(absent or f"no variable {variable!r}; there are {', '.join(map(str, ds.data_vars))}{hint}")
    whole = ds
    ds, places = selected(ds, select or {})
    ds = look.part(ds)
    if title is None:
        title = "\n".join(filter(None, [str(ds.attrs.get("title", "")), ", ".join(places)]))
        places = []
    dims = ds[variable].dims
    if not dims:
        raise PlotError("nothing to map: every parameter is fixed\nhint: look at one cell over time with `simulate`")
    marks.check(look.marks, dims, dims[-2:])
    held = held_note(whole, places) if look.held else []
    if len(dims) == 1:
        figure = plot_strip(ds, variable, title, look, held)
    else:
        figure = _panels(ds, variable, title, borders, lines, look, held)
    return figure


def _panels(
    ds: xr.Dataset, variable: str, title: str, borders: bool, lines: xr.Dataset | None, look: Look, held: Sequence[str]
) -> Figure:
    """One panel for each combination of the leading dimensions; a single one if there are none."""
    *outer, y_dim, x_dim = ds[variable].dims
    x, y = (MapAxis(ds, dim, log=str(dim) in look.log) for dim in (x_dim, y_dim))
    combinations = list(product(*(range(ds.sizes[dim]) for dim in outer)))
    rows, columns = _panel_layout(ds, outer)
    is_flag = variable in FLAG_COLOURS
    figure = Figure(figsize=(1.3 + 2.6 * columns, 1.6 + 2.3 * rows) if outer else (7.6, 4.6), layout="constrained")
    grid = figure.subplots(rows, columns, sharex=True, sharey=True, squeeze=False)

    panels = [ds.isel(dict(zip(outer, combination, strict=True))) for combination in combinations]
    pixel = pixel_for((y.length, x.length), _PANEL_PIXELS if outer else PIXELS)
    arrays = [panel[variable].transpose(y_dim, x_dim) for panel in panels]
    values, paint, unit = painted(arrays, variable, pixel, look)
    if not is_flag and not any(np.isfinite(cells).any() for cells in values):
        raise PlotError(why_nothing(ds, variable))
    edges = x.pixel_edges(pixel[1]), y.pixel_edges(pixel[0])
    headings = [MapAxis(ds, dim) for dim in outer]
    drawn: set[float] = set()
    exact = False
    for ax, panel, cells, combination in zip(grid.flat, panels, values, combinations, strict=False):
        ax.set_facecolor(UNDEFINED_COLOUR)
        if paint.has_gaps and look.hatched:
            ax.patch.set(hatch=UNDEFINED_HATCH, edgecolor=ink(UNDEFINED_COLOUR), linewidth=0.0)
        ax.pcolormesh(*edges, np.ma.masked_invalid(cells), cmap=paint.colours, norm=paint.norm, rasterized=True)
        if look.hatched:
            hatch(ax, variable, cells, *edges)
        if borders:
            drawn |= draw_borders(ax, panel, x, y, pixel)
        exact |= lines is not None and overlays.over_panel(ax, panel, lines, x, y, small=bool(outer))
        if outer:
            words = (wrapped(h.heading(i), _PANEL_WIDTH) for h, i in zip(headings, combination, strict=True))
            ax.set_title("\n".join(words), fontsize="small")
        apply(x, ax, "x", look)
        apply(y, ax, "y", look)
        marks.draw(ax, ds, dict(zip(outer, combination, strict=True)), look.marks, x, y)
    _name_outer_axes(grid, len(combinations), x.title, y.title)

    if not is_flag:
        bar = figure.colorbar(ScalarMappable(paint.norm, paint.colours), ax=grid, pad=0.02, extend=paint.beyond)
        bar.ax.set_ylim(*paint.span)
        if paint.ticks is not None:
            bar.set_ticks(paint.ticks, labels=[f"{tick:g}" for tick in paint.ticks])
            bar.minorticks_off()
        plain_numbers(bar.ax, "y")
        bar.set_label(folded(array_title(ds[variable], unit), _BAR_WIDTH))
    handles = [*paint.handles(patterns(variable) if look.hatched else None), *border_handles(drawn)]
    handles += [*([overlays.entry()] if exact else []), *marks.entries(look.marks, ds)]
    legend(figure, handles, at_right=is_flag and not outer, notes=[note(pixel, is_flag), *held])
    beside = is_flag and not outer
    entitle(figure, grid.flat[0], title, above_all=bool(outer), width=BESIDE_LEGEND if beside else TITLE_WIDTH)
    return figure


def _panel_layout(ds: xr.Dataset, outer: Sequence[Hashable]) -> tuple[int, int]:
    """Rows and columns of panels: two outer dimensions span a table if it is not too wide, others are wrapped."""
    lengths = [ds.sizes[dim] for dim in outer]
    count = prod(lengths)
    if count > MAX_PANELS:
        dims = ", ".join(f"{dim} ({length})" for dim, length in zip(outer, lengths, strict=True))
        raise PlotError(
            f"{count} panels over {dims}; at most {MAX_PANELS} fit on a page\n"
            f"hint: fix a dimension: --select {outer[0]}=VALUE on the command line, "
            f"select={{{str(outer[0])!r}: VALUE}} in Python"
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
