"""Values of maps as pixels with colours and hatching, the same in all panels of a figure.

Maps of regimes and of metrics.
"""

from collections.abc import Hashable, Mapping, Sequence
from itertools import product
from math import ceil, prod
from typing import Any

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.cm import ScalarMappable
from matplotlib.colors import AsinhNorm
from matplotlib.lines import Line2D
from matplotlib.ticker import AsinhLocator
from numpy.typing import NDArray

from stickslip.dataset import coarse
from stickslip.dataset.coarse import Pixel, pixel_for, pixel_note
from stickslip.dataset.display import MapAxis, unit_of
from stickslip.dataset.display import title as array_title
from stickslip.dataset.selection import MAX_PANELS, check_dataset, selected
from stickslip.dataset.summary import summary
from stickslip.errors import PlotError
from stickslip.plots import marks
from stickslip.plots.layout import (
    BESIDE,
    Figure,
    apply,
    entitle,
    fixed_note,
    labelled,
    legend,
    plain_numbers,
    scaled,
    wrapped,
)
from stickslip.plots.marks import BORDERS, PLAIN, Look, border_handles, draw_borders, levels_inside, over_panel
from stickslip.plots.palette import (
    BLUE,
    FLAG_COLOURS,
    HATCHES,
    UNDEFINED_COLOUR,
    UNDEFINED_HATCH,
    Entry,
    Paint,
    ink,
    marked,
    paint,
    regime_label,
)
from stickslip.vocabulary.display_units import Unit
from stickslip.vocabulary.quantities import listed, or_meant


def painted(
    arrays: Sequence[xr.DataArray], variable: str, pixel: Pixel, look: Look
) -> tuple[list[NDArray[np.generic]], Paint, Unit]:
    """The values of every panel, by pixels and in the unit in which they are shown; one paint for all of them.

    Raises PlotError for codes of a newer version, and for colours that numbers cannot have.
    """
    if variable not in FLAG_COLOURS:
        numbers = [coarse.numbers(array, pixel).values for array in arrays]
        unit = unit_of(arrays[0], np.concatenate(numbers, axis=None))
        shown: list[NDArray[np.generic]] = [unit.of(values) for values in numbers]
        limits = look.limits.get(variable)
        ends = None if limits is None else (unit.of(limits[0]), unit.of(limits[1]))
        return shown, paint(variable, np.concatenate(shown, axis=None), limits=ends, log=variable in look.log), unit
    if variable in look.log or variable in look.limits:
        raise PlotError(f"{variable} has names, no numbers: its colours have no scale and no limits")
    reduced = [coarse.flags(array, pixel) for array in arrays]
    present = {code for panel in reduced for code in panel.present}
    if unknown := present - set(range(len(FLAG_COLOURS[variable]))):
        raise PlotError(f"{variable} has codes that this version does not know: {sorted(unknown)}")
    shown = [marked(variable, panel) for panel in reduced]
    return shown, paint(variable, np.concatenate(shown, axis=None), present), Unit()


Floats = NDArray[np.float64]
_MOST = 50_000  # changes along rows of a regime; more are single cells here and there, on which no hatching shows


def hatch(ax: Axes, variable: str, codes: NDArray[np.generic], x_edges: Floats, y_edges: Floats) -> None:
    """Hatch the cells of those flags that have a pattern. codes : (rows, columns), edges one longer."""
    for code, colour in enumerate(FLAG_COLOURS.get(variable, {}).values()):
        if pattern := HATCHES.get(colour):
            hatch_cells(ax, np.asarray(codes == code), pattern, colour, x_edges, y_edges)


def hatch_cells(
    ax: Axes, inside: NDArray[np.bool_], pattern: str, colour: str, x_edges: Floats, y_edges: Floats
) -> None:
    """Hatch the cells of a colour that are `inside`, (rows, columns); edges one longer."""
    if not 0 < np.count_nonzero(inside[:, 1:] != inside[:, :-1]) + inside.any() <= _MOST:
        return
    sides = (np.repeat(edges, 2)[1:-1] for edges in (x_edges, y_edges))  # each cell twice: no slopes between cells
    area = ax.contourf(*sides, np.kron(inside, np.ones((2, 2))), levels=[0.5, 1.5], colors="none", hatches=[pattern])
    area.set(edgecolor=ink(colour), linewidth=0.0, zorder=1.5)


_MAX_PANEL_COLUMNS = 4
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
    look : scales, limits, operating points.
    A map of one dimension becomes a strip of regimes with the variable below it (for a flag, the damping ratio).
    Maps of more cells than pixels are reduced to pixels (`coarse.py`), which a note below says; no cell is skipped,
    and memory stays small. Raises PlotError, also where the variable has no value at all, saying why; StoreError where
    a file turns out to be damaged.
    """
    check_dataset(ds)
    if variable not in ds.data_vars:
        known = [str(name) for name in ds.data_vars]
        raise PlotError(f"no variable {variable!r}; there are {', '.join(known)}{or_meant(variable, known)}")
    whole = ds
    ds, places = selected(ds, select or {})
    ds, look = look.part(ds), look.within_limits()
    if title is None:
        title = "\n".join(filter(None, [str(ds.attrs.get("title", "")), ", ".join(places)]))
        places = []
    dims = ds[variable].dims
    if not dims:
        raise PlotError("nothing to map: every parameter is fixed\nhint: look at one cell over time with `simulate`")
    marks.check(look.marks, dims, dims[-2:])
    notes = fixed_note(whole, places)
    if len(dims) == 1:
        return _strip(ds, variable, title, look, notes)
    return _panels(ds, variable, title, borders, lines, look, notes)


def _panels(
    ds: xr.Dataset, variable: str, title: str, borders: bool, lines: xr.Dataset | None, look: Look, notes: Sequence[str]
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
        raise _nothing(ds, variable)
    edges = x.pixel_edges(pixel[1]), y.pixel_edges(pixel[0])
    headings = [MapAxis(ds, dim) for dim in outer]
    drawn: set[float] = set()
    for ax, panel, cells, combination in zip(grid.flat, panels, values, combinations, strict=False):
        ax.set_facecolor(UNDEFINED_COLOUR)
        if paint.has_gaps:
            ax.patch.set(hatch=UNDEFINED_HATCH, edgecolor=ink(UNDEFINED_COLOUR), linewidth=0.0)
        ax.pcolormesh(*edges, np.ma.masked_invalid(cells), cmap=paint.colours, norm=paint.norm, rasterized=True)
        hatch(ax, variable, cells, *edges)
        if borders:
            drawn |= draw_borders(ax, panel, x, y, pixel)
        if lines is not None:
            over_panel(ax, panel, lines, x, y, small=bool(outer))
        if outer:
            words = (wrapped(h.heading(i), _PANEL_WIDTH) for h, i in zip(headings, combination, strict=True))
            ax.set_title("\n".join(words), fontsize="small")
        apply(x, ax, "x", look)
        apply(y, ax, "y", look)
        marks.draw(ax, ds, dict(zip(outer, combination, strict=True)), look.marks, x, y)
    _name_outer_axes(grid, len(combinations), x.title, y.title)

    if not is_flag:
        bar = figure.colorbar(ScalarMappable(paint.norm, paint.colours), ax=grid, pad=0.02, extend=paint.beyond)
        if isinstance(paint.norm, AsinhNorm):
            bar.locator = AsinhLocator(5.0 * paint.norm.linear_width, numticks=7)  # apart near 0
        bar.ax.set_ylim(*paint.span)
        plain_numbers(bar.ax, "y")
        bar.set_label(array_title(ds[variable], unit))
    handles = [*paint.handles(), *border_handles(drawn)]
    handles += [*labelled(*grid.flat), *marks.entries(look.marks, ds)]
    legend(figure, handles, [pixel_note(pixel, is_flag), *notes])
    entitle(figure, grid.flat[0], title, above_all=bool(outer))
    return figure


def _nothing(ds: xr.Dataset, variable: str) -> PlotError:
    """The error of a variable that has no value in any cell."""
    regimes = listed([*map(regime_label, summary(ds))], "and") if "regime" in ds else "not told"
    return PlotError(f"no cell has a value of {variable}: nothing to draw (regimes: {regimes})")


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


PIXELS = (540, 720)  # rows and columns a lone map has on a page of 150 dpi
_ROW = "row of a strip"  # the second dimension of a map that has one


def _strip(ds: xr.Dataset, variable: str, title: str, look: Look, notes: Sequence[str]) -> Figure:
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
        handles += paint.handles()
        colours = {"c": np.ma.filled(codes[0].astype(np.float64), np.nan), "cmap": paint.colours, "norm": paint.norm}
        edges = x.pixel_edges(pixel[1]), np.array([0.0, 1.0])
        axes[flag].pcolormesh(*edges, codes, cmap=paint.colours, norm=paint.norm)
        hatch(axes[flag], flag, codes, *edges)
        axes[flag].set_yticks([])
        axes[flag].set_ylabel(flag.replace("_", " "), rotation=0, ha="right", va="center")
    if number in axes and number == variable and not np.isfinite(ds[number].values).any():
        raise _nothing(ds, variable)
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
    legend(figure, handles, [pixel_note(pixel, variable in FLAG_COLOURS), *notes])
    entitle(figure, axes[shown[0]], title)
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
    ax.set_ylabel(wrapped(array_title(row, unit), BESIDE))
    scaled(ax, "y", name, unit, look)
    if name != "damping_ratio":
        return []
    inside = levels_inside(values)
    for level in inside:
        ax.axhline(level, color="black", linestyle=BORDERS[level][0], linewidth=1.0, zorder=0)
    return border_handles(inside)
