"""Attractors along one parameter: what settles, what a shock may be, ramps, and bifurcation diagrams."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, Literal

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.lines import Line2D
from matplotlib.patches import Patch
from numpy.typing import NDArray

from stickslip.dataset.display import MapAxis, unit_of
from stickslip.dataset.display import title as array_title
from stickslip.dataset.selection import selected
from stickslip.errors import PlotError
from stickslip.plots.axes import apply, shade
from stickslip.plots.fixed_values import fixed_note
from stickslip.plots.layout import Figure, entitle, legend, wrapped
from stickslip.plots.palette import BLACK, BLUE, FLAG_COLOURS, GREEN, GREY, SKY, VERMILLION, regime_label
from stickslip.vocabulary.flags import REGIMES

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
        shaded = shade(ax, x.edges, _bistable(ds), BAND)
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
    legend(figure, handles, at_right=False, notes=fixed_note(ds))
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
    shaded = shade(ax, edges_of(ds, x), _kinds(up["regime"].values) != _kinds(down["regime"].values), BAND)
    handles: list[Any] = []
    for branch, name, marker, style, width in ((up, "up", ">", "solid", 2.6), (down, "down", "<", "dashed", 1.2)):
        values = unit.of(branch[variable].values)
        look: dict[str, Any] = {"color": BLACK if name == "down" else _RISING, "linestyle": style, "linewidth": width}
        ax.plot(x.centres, values, zorder=2, **look)
        _arrows(ax, x.centres, values, branch["regime"].values, marker)
        word = "rising" if name == "up" else "falling"
        handles.append(Line2D([], [], marker=marker, markerfacecolor="white", label=word, **look))
    if attractors is not None:
        if variable not in _UNSTABLE:
            raise PlotError(f"the unstable cycle has no {variable}")
        unstable = x.unit.of(attractors[along].values), unit.of(attractors[_UNSTABLE[variable]].values)
        ax.plot(*unstable, color=VERMILLION, linestyle="dotted", linewidth=1.8)
        handles.append(Line2D([], [], color=VERMILLION, linestyle="dotted", linewidth=1.8, label="unstable cycle"))
    drawn = np.isfinite(ds[variable].values) & (ds["regime"].values > 0)
    for code in np.unique(ds["regime"].values[drawn]):
        name = REGIMES[int(code)]
        face = FLAG_COLOURS["regime"][name]
        handles.append(
            Line2D([], [], linestyle="none", marker="o", color=face, markeredgecolor="black", label=regime_label(name))
        )
    if shaded:
        handles.append(Patch(**BAND, label="bistable"))
    ax.set(xlabel=x.title, ylabel=wrapped(array_title(ds[variable], unit), 45))
    ax.set_ylim(bottom=min(0.0, ax.get_ylim()[0]))
    apply(x, ax, "x")
    legend(figure, handles, at_right=False, notes=fixed_note(ds))
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
    """Cells where sliding is reached from some states and vibration from others."""
    reached = ds["coexisting"].values

    def any_of(names: list[str]) -> NDArray[np.bool_]:
        return np.asarray((reached & sum(1 << (REGIMES.index(name) - 1) for name in names)) > 0)

    return any_of(_STICKS) & any_of(_SETTLES)


def _kinds(regimes: NDArray[np.int8]) -> NDArray[np.int64]:
    """Regimes, those that settle being one."""
    codes = regimes.astype(np.int64)
    return np.where(codes == REGIMES.index("creep"), REGIMES.index("damped"), codes)


def hopfs(ds: xr.Dataset, x: NDArray[np.float64]) -> list[float]:
    """Places where the damping ratio of steady sliding passes zero."""
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


def _arrows(ax: Axes, x: NDArray[np.float64], y: NDArray[np.float64], regimes: NDArray[np.int8], marker: str) -> None:
    """A marker at every few points, in the colour of the regime."""
    few = slice(None, None, max(1, len(x) // 25))
    colours = [FLAG_COLOURS["regime"][REGIMES[int(code)]] for code in regimes[few]]
    ax.scatter(x[few], y[few], marker=marker, s=34, c=colours, edgecolors="black", linewidths=0.5, zorder=3)


Floats = NDArray[np.float64]
Flags = NDArray[np.bool_]

_UNSTABLE = {"velocity_amplitude": "unstable_velocity_amplitude", "displacement_amplitude": "unstable_amplitude"}
_CYCLES = {"stick_slip": VERMILLION, "sustained": FLAG_COLOURS["regime"]["sustained"]}
_SLIDES = ("damped", "creep")
_LINE_WIDTH = 2.2
_JUMP: dict[str, Any] = {"color": BLACK, "linewidth": 0.9, "linestyle": "dotted", "markersize": 6, "zorder": 4}
_LIMIT: dict[str, Any] = {"linestyle": "none", "marker": "o", "markersize": 6.5, "markeredgecolor": BLACK, "zorder": 5}
_HOPF, _FOLD = {**_LIMIT, "markerfacecolor": "white"}, {**_LIMIT, "markerfacecolor": BLACK}


def plot_branches(
    ds: xr.Dataset,
    variable: str = "velocity_amplitude",
    *,
    select: Mapping[str, Any] | None = None,
    title: str | None = None,
) -> Figure:
    """The amplitude of every motion along the parameter of a ramp: cycles, steady sliding at zero, stuck.

    Solid lines are stable, dashed ones are not: the unstable cycle, where it is known exactly, and steady sliding where
    its damping ratio is negative. Circles mark where steady sliding loses its stability (a Hopf bifurcation) and where
    vibration ends on the way up; arrows are the jumps of a slow ramp, between which both motions are possible.

    ds : what `ramp` returns. variable : velocity_amplitude or displacement_amplitude. select : fixes the lines.
    Raises PlotError.
    """
    if variable not in _UNSTABLE:
        raise PlotError(f"no branches of {variable}; there are those of {' and '.join(_UNSTABLE)}")
    if "direction" not in ds.dims or variable not in ds.data_vars:
        raise PlotError("not a ramp, of which branches are drawn\nhint: stickslip.ramp follows them up and down")
    ds, title = line_of(ds, variable, 2, select, title)
    x, unit = MapAxis(ds, ds[variable].dims[-1]), unit_of(ds[variable])
    amplitudes = [name for name in (variable, _UNSTABLE[variable]) if name in ds]
    ds = ds.assign({name: ds[name].copy(data=unit.of(ds[name].values)) for name in amplitudes})
    figure = Figure(figsize=(7.6, 4.8), layout="constrained")
    ax = figure.subplots()
    handles: list[Any] = _cycles(ax, ds, variable, x.centres)
    handles += _resting(ax, ds, x.centres)
    edges = edges_of(ds, x)
    handles += _unstable(ax, ds, variable, x.centres)
    handles += _limits(ax, ds, variable, x.centres, edges)
    if shade(ax, edges, _branches_differ(ds), BAND):
        handles.append(Patch(**BAND, label="bistable"))
    ax.set(xlabel=x.title, ylabel=f"amplitude of {variable.removesuffix('_amplitude')} ({unit.printed})")
    apply(x, ax, "x")
    ax.margins(y=0.08)
    legend(figure, handles, at_right=False)
    entitle(figure, ax, title)
    return figure


def plot_of_ramp(ds: xr.Dataset, variable: str | None = None, **how: Any) -> Figure:
    """The plot of a ramp: its branches for an amplitude, and unless another variable is named; else both ways of that.

    how : select and title. Raises PlotError.
    """
    if variable is None or variable in _UNSTABLE:
        return plot_branches(ds, variable or "velocity_amplitude", **how)
    return plot_ramp(ds, variable, **how)


def _is(ds: xr.Dataset, direction: str, *names: str) -> Flags:
    codes = [REGIMES.index(name) for name in names]
    return np.asarray(np.isin(ds["regime"].sel(direction=direction).values, codes))


def _branches_differ(ds: xr.Dataset) -> Flags:
    """Cells where the way up vibrates and the way down does not, or the other way round."""
    up, down = (_is(ds, direction, *_CYCLES) for direction in ("up", "down"))
    return np.asarray(up != down)


def _cycles(ax: Axes, ds: xr.Dataset, variable: str, x: Floats) -> list[Line2D]:
    """Stable cycles of either way, by kind."""
    handles = []
    for name, colour in _CYCLES.items():
        drawn = False
        for direction in ("up", "down"):
            there = _is(ds, direction, name)
            values = np.where(there, ds[variable].sel(direction=direction).values, np.nan)
            ax.plot(x, values, color=colour, linewidth=_LINE_WIDTH, zorder=3)
            drawn |= bool(there.any())
        if drawn:
            label = {"stick_slip": "stick-slip", "sustained": "vibration without sticking"}[name]
            handles.append(Line2D([], [], color=colour, linewidth=_LINE_WIDTH, label=label))
    return handles


def _resting(ax: Axes, ds: xr.Dataset, x: Floats) -> list[Line2D]:
    """Motions of no amplitude: steady sliding, stable where the damping ratio says so, and sticking for ever."""
    handles = []
    stuck = _is(ds, "up", "stuck") | _is(ds, "down", "stuck")
    slides = _is(ds, "up", *_SLIDES) | _is(ds, "down", *_SLIDES)
    ratio = ds["damping_ratio"].values if "damping_ratio" in ds else np.where(slides, 1.0, -1.0)
    stable = np.where(np.isnan(ratio), slides, ratio > 0)
    for there, style, label in (
        (stable & ~stuck, "solid", "steady sliding"),
        (~stable & ~stuck, "dashed", "steady sliding, unstable"),
    ):
        if there.any():
            look: dict[str, Any] = {
                "color": BLUE,
                "linestyle": style,
                "linewidth": _LINE_WIDTH if stable[there][0] else 1.4,
            }
            ax.plot(x, np.where(_and_next(there), 0.0, np.nan), zorder=2, **look)
            handles.append(Line2D([], [], label=label, **look))
    if stuck.any():
        look = {"color": GREEN, "linewidth": _LINE_WIDTH, "marker": "s", "markersize": 4}
        ax.plot(x, np.where(stuck, 0.0, np.nan), zorder=3, clip_on=False, **look)
        handles.append(Line2D([], [], label="stuck", **look))
    return handles


def _and_next(there: Flags) -> Flags:
    """Runs, each with the point after it, so that the next begins where one ends."""
    return np.asarray(there | np.concatenate([[False], there[:-1]]))


def _unstable(ax: Axes, ds: xr.Dataset, variable: str, x: Floats) -> list[Line2D]:
    """The unstable cycle, from the Hopf bifurcation on."""
    if _UNSTABLE[variable] not in ds:
        return []
    values = ds[_UNSTABLE[variable]].values
    if not np.isfinite(values).any():
        return []
    places, amplitudes = x[np.isfinite(values)], values[np.isfinite(values)]
    for hopf in hopfs(ds, x):
        places, amplitudes = np.append(places, hopf), np.append(amplitudes, 0.0)
    order = np.argsort(places)
    look: dict[str, Any] = {"color": VERMILLION, "linestyle": "dashed", "linewidth": 1.6}
    ax.plot(places[order], amplitudes[order], zorder=3, **look)
    return [Line2D([], [], label="unstable cycle", **look)]


def _limits(ax: Axes, ds: xr.Dataset, variable: str, x: Floats, edges: Floats) -> list[Line2D]:
    """Draw where branches end, and the jumps there of a slow ramp: up to there they are drawn from their last point."""
    handles = []
    for direction, step in (("up", 1), ("down", -1)):
        amplitude = ds[variable].sel(direction=direction).values
        vibrates, slides = _is(ds, direction, *_CYCLES)[::step], _is(ds, direction, *_SLIDES)[::step]
        for i in np.flatnonzero((vibrates[:-1] & slides[1:]) | (slides[:-1] & vibrates[1:])):
            before, after = (i, i + 1) if step == 1 else (x.size - 1 - i, x.size - 2 - i)
            start = amplitude[before] if np.isfinite(amplitude[before]) else 0.0
            end = amplitude[after] if np.isfinite(amplitude[after]) else 0.0
            there, towards = edges[max(before, after)], "^" if end > start else "v"
            ax.plot([there] * 3, [start, 0.5 * (start + end), end], marker=towards, markevery=[1], **_JUMP)
            if vibrates[i]:
                colour = _CYCLES[REGIMES[int(ds["regime"].sel(direction=direction).values[before])]]
                ax.plot([x[before], there], [start] * 2, color=colour, linewidth=_LINE_WIDTH, zorder=3)
                ax.plot(there, start, **_FOLD)
                handles = [Line2D([], [], label="vibration ends", **_FOLD)]
    if places := hopfs(ds, x):
        ax.plot(places, np.zeros(len(places)), **_HOPF)
        handles.append(Line2D([], [], label="sliding loses stability", **_HOPF))
    return handles
