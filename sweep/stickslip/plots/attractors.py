"""Attractors along one parameter: what settles, what a shock may be, and ramps with both of their branches."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, Literal

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.lines import Line2D
from matplotlib.patches import Patch
from numpy.typing import NDArray

from stickslip.dataset.axis import MapAxis
from stickslip.dataset.axis import title as array_title
from stickslip.dataset.display import unit_of
from stickslip.dataset.selection import selected
from stickslip.errors import PlotError
from stickslip.plots.axes import apply
from stickslip.plots.figure import Figure
from stickslip.plots.held import held_note
from stickslip.plots.page import entitle, legend, wrapped
from stickslip.plots.palette import BLACK, BLUE, FLAG_COLOURS, GREY, SKY, VERMILLION
from stickslip.vocabulary.flags import REGIMES, flag_label

_TITLE_WIDTH, _WIDTH = 70, 60  # letters in a line of what is drawn, and of the title
BAND: dict[str, Any] = {"facecolor": GREY, "alpha": 0.35, "linewidth": 0}
_RISING = "#707070"
_NONE: dict[str, Any] = {"facecolor": "none", "edgecolor": GREY, "hatch": "////", "linewidth": 0}
_STICKS, _SETTLES = ["stick_slip", "sustained"], ["damped", "creep"]


def plot_attractors(ds: xr.Dataset, *, select: Mapping[str, Any] | None = None, title: str | None = None) -> Figure:
    """The share that settles and the critical shocks over one dimension; select fixes the others.

    Raises PlotError for a dataset that is none of attractors, or has more than one dimension left.
    """
    if "settling_share" not in ds.data_vars:
        raise PlotError("not a dataset of attractors: no settling_share")
    ds, title = line_of(ds, "settling_share", 1, select, title)
    x = MapAxis(ds, ds["settling_share"].dims[0])
    figure = Figure(figsize=(7.6, 6.2), layout="constrained")
    upper, lower = figure.subplots(2, sharex=True)
    handles: list[Any] = []
    for ax in (upper, lower):
        shaded = shade(ax, x.edges, _bistable(ds))
    share, error = ds["settling_share"].values, 3.0 * ds["share_error"].values
    low, high = ds["settling_share_low"].values, ds["settling_share_high"].values
    safe = np.isposinf(ds["critical_shock"].values)
    for part in (safe, ~safe):  # no line across the jump at the fold
        upper.plot(x.centres, np.where(part, share, np.nan), color=BLUE, linewidth=1.4)
        if (error > 0).any():
            upper.fill_between(x.centres, share - error, share + error, where=part, color=SKY, alpha=0.6, linewidth=0)
    if (error > 0).any():
        handles.append(Patch(facecolor=SKY, alpha=0.6, label="three standard errors"))
    if (high > low).any():
        upper.vlines(x.centres, low, high, color=BLACK, linewidth=1.0)
        handles.append(Line2D([], [], color=BLACK, linewidth=1.0, label="undecided starting states"))
    upper.set(ylabel="share of starting states that settle", ylim=(-0.03, 1.03))
    unit = unit_of(ds["critical_shock"])
    looks: tuple[tuple[str, str, Literal["solid", "dashed"]], ...]
    looks = ("along", VERMILLION, "solid"), ("against", BLUE, "dashed")
    for name, colour, style in looks:
        shock = unit.of(ds[f"critical_shock_{name}"].values)
        lower.plot(x.centres, np.where(np.isfinite(shock), shock, np.nan), color=colour, linestyle=style, linewidth=1.4)
        handles.append(Line2D([], [], color=colour, linestyle=style, label=f"shock {name} the belt"))
    if safe.any():
        shade(lower, x.edges, safe, _NONE)
        handles.append(Patch(**_NONE, label="no shock is enough"))
    lower.set(ylabel=f"critical shock ({unit.printed})", xlabel=x.title)
    lower.set_ylim(bottom=0.0)
    apply(x, lower, "x")
    if shaded:
        handles.append(Patch(**BAND, label="bistable"))
    legend(figure, handles, at_right=False, notes=held_note(ds))
    entitle(figure, upper, title)
    return figure


def plot_ramp(
    ds: xr.Dataset,
    variable: str = "velocity_amplitude",
    *,
    select: Mapping[str, Any] | None = None,
    attractors: xr.Dataset | None = None,
    title: str | None = None,
) -> Figure:
    """Both branches of a ramp: the amplitude while the parameter rises, and while it falls.

    variable : of the ramp. select : fixes the lines. attractors : of the same cells along the same parameter, whose
    unstable cycle is drawn between the branches. Raises PlotError.
    """
    if "direction" not in ds.dims or variable not in ds.data_vars:
        raise PlotError(f"not a ramp with {variable}")
    ds, title = line_of(ds, variable, 2, select, title)
    along = ds[variable].dims[-1]
    x, unit = MapAxis(ds, along), unit_of(ds[variable])
    figure = Figure(figsize=(7.6, 4.8), layout="constrained")
    ax = figure.subplots()
    up, down = (ds.sel(direction=name) for name in ("up", "down"))
    shaded = shade(ax, edges_of(ds, x), _kinds(up["regime"].values) != _kinds(down["regime"].values))
    handles: list[Any] = []
    for branch, name, marker, style, width in ((up, "up", ">", "solid", 2.6), (down, "down", "<", "dashed", 1.2)):
        values = unit.of(branch[variable].values)
        look: dict[str, Any] = {"color": BLACK if name == "down" else _RISING, "linestyle": style, "linewidth": width}
        ax.plot(x.centres, values, zorder=2, **look)
        _arrows(ax, x.centres, values, branch["regime"].values, marker)
        word = "rising" if name == "up" else "falling"
        handles.append(Line2D([], [], marker=marker, markerfacecolor="white", label=word, **look))
    if attractors is not None:
        cycle = {"velocity_amplitude": "unstable_velocity_amplitude", "displacement_amplitude": "unstable_amplitude"}
        if variable not in cycle:
            raise PlotError(f"the unstable cycle has no {variable}")
        unstable = x.unit.of(attractors[along].values), unit.of(attractors[cycle[variable]].values)
        ax.plot(*unstable, color=VERMILLION, linestyle="dotted", linewidth=1.8)
        handles.append(Line2D([], [], color=VERMILLION, linestyle="dotted", linewidth=1.8, label="unstable cycle"))
    drawn = np.isfinite(ds[variable].values) & (ds["regime"].values > 0)
    for code in np.unique(ds["regime"].values[drawn]):
        name = REGIMES[int(code)]
        face = FLAG_COLOURS["regime"][name]
        label = flag_label(name).replace("stick_slip", "stick-slip")
        handles.append(Line2D([], [], linestyle="none", marker="o", color=face, markeredgecolor="black", label=label))
    if shaded:
        handles.append(Patch(**BAND, label="bistable"))
    ax.set(xlabel=x.title, ylabel=wrapped(array_title(ds[variable], unit), 45))
    ax.set_ylim(bottom=min(0.0, ax.get_ylim()[0]))
    apply(x, ax, "x")
    legend(figure, handles, at_right=False, notes=held_note(ds))
    entitle(figure, ax, title)
    return figure


def line_of(
    ds: xr.Dataset, variable: str, dims: int, select: Mapping[str, Any] | None, title: str | None
) -> tuple[xr.Dataset, str]:
    """The points to draw, and the title that names them."""
    ds, places = selected(ds, select or {})
    lone = [dim for dim in ds[variable].dims if ds.sizes[dim] == 1]
    ds = ds.squeeze(lone[: max(0, ds[variable].ndim - dims)], drop=True)  # a single line needs no selecting
    if ds[variable].ndim > dims:
        more = [str(dim) for dim in ds[variable].dims if dim != "direction"]
        raise PlotError(f"more than one dimension: {', '.join(more)}\nhint: fix all but one with select")
    if ds[variable].ndim < dims:
        raise PlotError("nothing to draw a line through: no dimension is left")
    title = wrapped(str(ds.attrs.get("title", "")), _WIDTH) if title is None else title
    return ds, "\n".join(filter(None, [title, wrapped(", ".join(places), _TITLE_WIDTH)]))


def _bistable(ds: xr.Dataset) -> NDArray[np.bool_]:
    """Where sliding is reached from some states and vibration from others."""
    reached = ds["coexisting"].values

    def any_of(names: list[str]) -> NDArray[np.bool_]:
        return np.asarray((reached & sum(1 << (REGIMES.index(name) - 1) for name in names)) > 0)

    return any_of(_STICKS) & any_of(_SETTLES)


def _kinds(regimes: NDArray[np.int8]) -> NDArray[np.int64]:
    """Regimes, those that settle being one."""
    codes = regimes.astype(np.int64)
    return np.where(codes == REGIMES.index("creep"), REGIMES.index("damped"), codes)


def hopfs(ds: xr.Dataset, x: NDArray[np.float64]) -> list[float]:
    """Where the damping ratio of steady sliding passes zero."""
    if "damping_ratio" not in ds:
        return []
    ratio = ds["damping_ratio"].values
    at = np.flatnonzero(ratio[:-1] * ratio[1:] < 0)
    return [float(x[i] + (x[i + 1] - x[i]) * ratio[i] / (ratio[i] - ratio[i + 1])) for i in at]


def edges_of(ds: xr.Dataset, x: MapAxis) -> NDArray[np.float64]:
    """The edges of the points of a ramp; where vibration or the stability of sliding ends between two points, there."""
    ends = ds["vibration_end"].values if "vibration_end" in ds else np.array([])  # older files have none
    places = np.array([*hopfs(ds, x.centres), *x.unit.of(ends[np.isfinite(ends)])])
    edges = x.edges.copy()
    edges[np.searchsorted(x.centres, places)] = places
    return edges


def shade(ax: Axes, edges: NDArray[np.float64], where: NDArray[np.bool_], look: Mapping[str, Any] = BAND) -> bool:
    """Shade runs of cells between their edges; whether there are any."""
    changes = np.flatnonzero(np.diff(np.concatenate([[False], where, [False]]).astype(np.int8)))
    for first, past in zip(changes[::2], changes[1::2], strict=True):
        ax.axvspan(edges[first], edges[past], zorder=0, **look)
    return bool(where.any())


def _arrows(ax: Axes, x: NDArray[np.float64], y: NDArray[np.float64], regimes: NDArray[np.int8], marker: str) -> None:
    """A marker at every few points, in the colour of the regime."""
    few = slice(None, None, max(1, len(x) // 25))
    colours = [FLAG_COLOURS["regime"][REGIMES[int(code)]] for code in regimes[few]]
    ax.scatter(x[few], y[few], marker=marker, s=34, c=colours, edgecolors="black", linewidths=0.5, zorder=3)
