"""Pictures of maps and of trajectories.

Every function returns a matplotlib Figure and touches no global state: no pyplot, no window, safe in threads.

A map may have any number of dimensions: the last is the x axis, the last but one the y axis, the others become panels.
Colours are in `palette.py`, axes in `mapaxis.py`.
"""

from __future__ import annotations

import os
from collections.abc import Hashable, Iterator, Mapping, Sequence
from itertools import product
from math import ceil, prod
from typing import Any, Literal

import matplotlib.patheffects as patheffects
import numpy as np
import xarray as xr
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.cm import ScalarMappable
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Patch
from numpy.typing import NDArray

from .mapaxis import MapAxis
from .mapaxis import title as array_title
from .palette import BLACK, BLUE, FLAG_COLOURS, GREY, UNDEFINED_COLOUR, VERMILLION, paint
from .variables import MODES

BORDERS: dict[float, tuple[Literal["solid", "dashed"], str]] = {
    0.0: ("solid", "damping ratio 0 (linear)"),
    1.0: ("dashed", "damping ratio 1 (linear)"),
}
MAX_PANELS = 16

_MAX_PANEL_COLUMNS = 4
_MAX_DRAWN = 2000  # cells along an axis; a page cannot show more
_HALO = [patheffects.Stroke(linewidth=3.0, foreground="white", alpha=0.8), patheffects.Normal()]


class PlotError(ValueError):
    """This dataset cannot be drawn as asked; the message says what is possible."""


# --- maps -------------------------------------------------------------------------------------------------------------


def plot_map(
    ds: xr.Dataset,
    variable: str = "regime",
    *,
    select: Mapping[str, Any] | None = None,
    borders: bool = True,
    title: str | None = None,
) -> Figure:
    """One variable of a map over its last two dimensions, small multiples over the others.

    select : fixes dimensions, each at a value (the nearest grid point is taken), at a label, or at the position along a
    dimension that has neither.
    borders : draw where linear theory puts the border of stability and that of overshoot.
    A map of one dimension becomes a strip of regimes with the variable below it (for a flag, the damping ratio).
    Axes of more than 2000 points are thinned evenly, so a picture is no proof that a thin regime is absent.
    Raises PlotError.
    """
    if variable not in ds.data_vars:
        raise PlotError(f"no variable {variable!r}; there are {', '.join(map(str, ds.data_vars))}")
    ds = _thinned(_ascending(_selected(ds, select or {})))
    title = str(ds.attrs.get("title", "")) if title is None else title
    dims = ds[variable].dims
    if not dims:
        raise PlotError("nothing to map: every parameter is fixed\nhint: look at one cell over time with `simulate`")
    if len(dims) == 1:
        return _strip(ds, variable, title)
    return _panels(ds, variable, title, borders)


def _panels(ds: xr.Dataset, variable: str, title: str, borders: bool) -> Figure:
    """One panel for each combination of the leading dimensions; a single one if there are none."""
    *outer, y_dim, x_dim = ds[variable].dims
    x, y = MapAxis(ds, x_dim), MapAxis(ds, y_dim)
    combinations = list(product(*(range(ds.sizes[dim]) for dim in outer)))
    rows, columns = _panel_layout(ds, outer)
    is_flag = variable in FLAG_COLOURS
    figure = Figure(figsize=(1.3 + 2.6 * columns, 1.6 + 2.3 * rows) if outer else (7.6, 4.6), layout="constrained")
    grid = figure.subplots(rows, columns, sharex=True, sharey=True, squeeze=False)

    painted = paint(variable, ds[variable].values)
    headings = [MapAxis(ds, dim) for dim in outer]
    drawn: set[float] = set()
    for ax, combination in zip(grid.flat, combinations, strict=False):
        panel = ds.isel(dict(zip(outer, combination, strict=True)))
        values = np.ma.masked_invalid(panel[variable].transpose(y_dim, x_dim).values)
        ax.set_facecolor(UNDEFINED_COLOUR)
        ax.pcolormesh(x.edges, y.edges, values, cmap=painted.colours, norm=painted.norm, rasterized=True)
        if borders:
            drawn |= _draw_borders(ax, panel, x, y)
        if outer:
            ax.set_title("\n".join(h.heading(i) for h, i in zip(headings, combination, strict=True)), fontsize="small")
        x.apply(ax, "x")
        y.apply(ax, "y")
    _name_outer_axes(grid, len(combinations), x.title, y.title)

    if not is_flag:
        bar = figure.colorbar(ScalarMappable(painted.norm, painted.colours), ax=grid, pad=0.02)
        bar.set_label(array_title(ds[variable]))
    _legend(figure, [*painted.handles(), *_border_handles(drawn)], at_right=is_flag and not outer)
    _entitle(figure, grid.flat[0], title, above_all=bool(outer))
    return figure


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
    """Axis titles at the left and at the bottom of each column, whose last panel may lie above an empty place."""
    rows, columns = grid.shape
    size = "medium" if count == 1 else "small"
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

    handles: list[Artist] = []
    colours: dict[str, Any] = {"color": BLUE}
    if flag in axes:
        flags = ds[flag].values
        painted = paint(flag, flags)
        handles += painted.handles()
        colours = {"c": flags, "cmap": painted.colours, "norm": painted.norm}
        axes[flag].pcolormesh(x.edges, [0.0, 1.0], flags[np.newaxis], cmap=painted.colours, norm=painted.norm)
        axes[flag].set_yticks([])
        axes[flag].set_ylabel(flag, rotation=0, ha="right", va="center")
    if number in axes:
        values = ds[number].values
        axes[number].plot(x.centres, values, color="#888888", linewidth=0.8, zorder=1)
        axes[number].scatter(x.centres, values, s=18, zorder=2, edgecolors="black", linewidths=0.3, **colours)
        axes[number].set_ylabel(array_title(ds[number]))
        if number == "damping_ratio":
            inside = _levels_inside(values)
            for level in inside:
                axes[number].axhline(level, color="black", linestyle=BORDERS[level][0], linewidth=1.0, zorder=0)
            handles += _border_handles(inside)
    for ax in axes.values():
        x.apply(ax, "x")
    axes[shown[-1]].set_xlabel(x.title)
    _legend(figure, handles, at_right=True)
    _entitle(figure, axes[shown[0]], title)
    return figure


def _draw_borders(ax: Axes, panel: xr.Dataset, x: MapAxis, y: MapAxis) -> set[float]:
    """Contours of the linear damping ratio; returns the levels that lie inside the panel."""
    if not (x.is_numeric and y.is_numeric and "damping_ratio" in panel.data_vars):
        return set()
    ratio = np.ma.masked_invalid(panel["damping_ratio"].transpose(y.dim, x.dim).values)
    if min(ratio.shape) < 2:
        return set()
    inside = _levels_inside(ratio)
    for level in inside:
        lines = ax.contour(x.centres, y.centres, ratio, levels=[level], colors="black", linewidths=1.2,
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


def _legend(figure: Figure, handles: Sequence[Artist], *, at_right: bool) -> None:
    """The legend, outside the axes: at the right of a lone map, else below."""
    if not handles:
        return
    looks: dict[str, Any] = {"frameon": False, "fontsize": "small"}
    if at_right:
        figure.legend(handles=handles, loc="outside right upper", **looks)
    else:
        figure.legend(handles=handles, loc="outside lower center", ncols=min(4, len(handles)), **looks)


def _entitle(figure: Figure, top: Axes, title: str, *, above_all: bool = False) -> None:
    """The title, over the axes it belongs to: over the figure it would be centred on a legend at the side as well."""
    if above_all:
        figure.suptitle(title, fontsize="large")
    else:
        top.set_title(title, fontsize="large")


# --- which part of a dataset is drawn ---------------------------------------------------------------------------------


def _selected(ds: xr.Dataset, select: Mapping[str, Any]) -> xr.Dataset:
    """The dataset at the given places of some dimensions, which then are scalar coordinates."""
    for dim, wanted in select.items():
        if dim not in ds.dims:
            raise PlotError(f"cannot select {dim!r}; dimensions are {', '.join(map(str, ds.dims))}")
        ds = ds.isel({dim: _position(ds, dim, wanted)})
    return ds


def _position(ds: xr.Dataset, dim: str, wanted: Any) -> int:
    """Where along `dim` the value, label or position `wanted` is."""
    labels = [str(label) for label in ds[dim].values]
    if dim in ds.coords and ds[dim].dtype.kind not in "fiu":
        if str(wanted) not in labels:
            raise PlotError(f"cannot select {dim}={wanted}; labels are {', '.join(labels)}")
        return labels.index(str(wanted))
    try:
        number = float(wanted)
    except (TypeError, ValueError) as error:
        raise PlotError(f"cannot select {dim}={wanted}; expected a number in SI units") from error
    if dim in ds.coords:
        return int(np.abs(ds[dim].values - number).argmin())
    if number not in range(ds.sizes[dim]):
        raise PlotError(f"cannot select {dim}={wanted}; positions are 0 to {ds.sizes[dim] - 1}")
    return int(number)


def _ascending(ds: xr.Dataset) -> xr.Dataset:
    """Numeric axes sorted, so that cells do not overlap."""
    return ds.sortby([ds[dim] for dim in ds.dims if dim in ds.coords and ds[dim].dtype.kind in "fiu"])


def _thinned(ds: xr.Dataset) -> xr.Dataset:
    """Every n-th point of axes longer than can be seen."""
    return ds.isel({dim: slice(None, None, ceil(n / _MAX_DRAWN)) for dim, n in ds.sizes.items()})


# --- trajectories -----------------------------------------------------------------------------------------------------


def plot_trace(ds: xr.Dataset, *, title: str | None = None) -> Figure:
    """A trajectory: displacement and velocity over time with the stick phases shaded, and the phase portrait.

    The line of the belt speed appears in the phase portrait only while that speed is constant. Raises PlotError.
    """
    if missing := {"displacement", "velocity", "relative_speed", "mode"} - set(ds.data_vars):
        raise PlotError(f"not a trajectory: no {', '.join(sorted(missing))}")
    time, displacement, velocity = (ds[name].values for name in ("time", "displacement", "velocity"))
    belt = ds["relative_speed"].values + velocity
    sticks = ds["mode"].values == MODES.index("stick")
    figure = Figure(figsize=(10.0, 4.6), layout="constrained")
    places = figure.add_gridspec(2, 2, width_ratios=[3, 2])
    upper = figure.add_subplot(places[0, 0])
    lower = figure.add_subplot(places[1, 0], sharex=upper)
    phase = figure.add_subplot(places[:, 1])
    upper.tick_params(labelbottom=False)
    mass_line: dict[str, Any] = {"color": BLUE, "linewidth": 1.2}
    belt_line: dict[str, Any] = {"color": VERMILLION, "linewidth": 1.0, "linestyle": "dashed"}
    shade: dict[str, Any] = {"facecolor": GREY, "alpha": 0.45, "linewidth": 0}
    start: dict[str, Any] = {"color": BLACK, "marker": "o", "markersize": 4, "linestyle": "none"}

    upper.plot(time, displacement, **mass_line)
    lower.plot(time, velocity, **mass_line)
    lower.plot(time, belt, **belt_line)
    for ax in (upper, lower):
        for begin, end in _spans(time, sticks):
            ax.axvspan(begin, end, zorder=0, **shade)
        ax.margins(x=0)
    phase.plot(displacement, velocity, **mass_line)
    phase.plot(displacement[:1], velocity[:1], **start)
    if np.ptp(belt) <= 1e-9 * np.abs(belt).max():
        phase.axhline(belt[0], zorder=0, **belt_line)

    upper.set_ylabel(array_title(ds["displacement"]))
    lower.set(xlabel=array_title(ds["time"]), ylabel=array_title(ds["velocity"]))
    phase.set(xlabel=array_title(ds["displacement"]), ylabel=array_title(ds["velocity"]))
    for ax in (upper, lower, phase):
        ax.ticklabel_format(style="sci", scilimits=(-3, 4), useMathText=True)
    handles: list[Artist] = [
        Line2D([], [], label="mass", **mass_line),
        Line2D([], [], label="belt", **belt_line),
        Line2D([], [], label="start", **start),
    ]
    if sticks.any():
        handles.append(Patch(label="sticking", **shade))
    _legend(figure, handles, at_right=False)
    _entitle(figure, upper, str(ds.attrs.get("title", "")) if title is None else title, above_all=True)
    return figure


def _spans(time: NDArray[np.float64], inside: NDArray[np.bool_]) -> Iterator[tuple[float, float]]:
    """Start and end of the stretches where `inside` holds; a stretch ends where the next sample begins."""
    changes = np.flatnonzero(np.diff(np.concatenate([[False], inside, [False]]).astype(np.int8)))
    for first, past in zip(changes[::2], changes[1::2], strict=True):
        yield float(time[first]), float(time[min(past, len(time) - 1)])


# --- files ------------------------------------------------------------------------------------------------------------


def save(figure: Figure, path: str | os.PathLike[str], dpi: float = 150) -> None:
    """Write a picture; its kind is that of the name (.png, .svg, .pdf). Raises PlotError."""
    try:
        figure.savefig(path, dpi=dpi)
    except (OSError, ValueError) as error:
        reason = error.strerror if isinstance(error, OSError) and error.strerror else error
        raise PlotError(f"{os.fspath(path)}: cannot be written ({reason})") from error
