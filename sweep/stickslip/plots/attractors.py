"""Attractors along one parameter: what settles, what a shock may be, ramps, and bifurcation diagrams."""

from collections.abc import Mapping
from itertools import product
from typing import Any

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from numpy.typing import NDArray

from stickslip.dataset.display import MapAxis, unit_of
from stickslip.dataset.display import title as array_title
from stickslip.dataset.selection import check_dataset, selected
from stickslip.errors import PlotError
from stickslip.plots.layout import Figure, apply, entitle, fixed_note, labelled, legend, shade
from stickslip.plots.palette import BLACK, BLUE, FLAG_COLOURS, GREEN, GREY, SKY, VERMILLION
from stickslip.vocabulary.quantities import REGIMES

BAND: dict[str, Any] = {"facecolor": GREY, "alpha": 0.35, "linewidth": 0, "label": "bistable"}
_WAYS: dict[str, dict[str, Any]] = {
    "up": {"label": "rising", "color": "#707070", "linewidth": 2.6, "marker": ">"},
    "down": {"label": "falling", "color": BLACK, "linewidth": 1.2, "linestyle": "dashed", "marker": "<"},
}
_ERRORS: dict[str, Any] = {"color": SKY, "alpha": 0.6, "linewidth": 0, "label": "three standard errors"}
_NONE: dict[str, Any] = {"facecolor": "none", "edgecolor": GREY, "hatch": "////", "linewidth": 0,
                         "label": "no shock is enough"}  # fmt: skip
_UNSTABLE = {"velocity_amplitude": "unstable_velocity_amplitude", "displacement_amplitude": "unstable_amplitude"}
_CYCLES = {
    "stick_slip": (VERMILLION, "stick-slip"),
    "sustained": (FLAG_COLOURS["regime"]["sustained"], "vibration without sticking"),
}
_SLIDES = ("damped", "creep")
_LINE_WIDTH = 2.2
_JUMP: dict[str, Any] = {"color": BLACK, "linewidth": 0.9, "linestyle": "dotted", "markersize": 6, "zorder": 4}
_LIMIT: dict[str, Any] = {"linestyle": "none", "marker": "o", "markersize": 6.5, "markeredgecolor": BLACK, "zorder": 5}
_HOPF = _LIMIT | {"markerfacecolor": "white", "label": "sliding loses stability"}
_FOLD = _LIMIT | {"markerfacecolor": BLACK, "label": "vibration ends"}

Floats = NDArray[np.float64]
Flags = NDArray[np.bool_]


def plot_attractors(ds: xr.Dataset, *, select: Mapping[str, Any] | None = None, title: str | None = None) -> Figure:
    """The share that settles and the critical shocks over one dimension; select fixes the others.

    Raises PlotError for a dataset that is none of attractors, or has more than one dimension left.
    """
    check_dataset(ds)
    if "settling_share" not in ds.data_vars:
        raise PlotError("not a dataset of attractors: no settling_share")
    ds, title = line_of(ds, "settling_share", 1, select, title)
    x = MapAxis(ds, ds["settling_share"].dims[0])
    joined: dict[str, Any] = {"linewidth": 1.4} if x.is_numeric else {"marker": "o", "linestyle": "none"}
    figure = Figure(figsize=(7.6, 6.2), layout="constrained")
    upper, lower = figure.subplots(2, sharex=True)
    share, error = ds["settling_share"].values, 3.0 * ds["share_error"].values
    low, high = ds["settling_share_low"].values, ds["settling_share_high"].values
    safe = np.isposinf(ds["critical_shock"].values)
    for part in (safe, ~safe):  # no line across the jump at the fold
        upper.plot(x.centres, np.where(part, share, np.nan), color=BLUE, **joined)
        if (error > 0).any() and x.is_numeric:
            upper.fill_between(x.centres, share - error, share + error, where=part, **_ERRORS)
    if (high > low).any():
        upper.vlines(x.centres, low, high, color=BLACK, linewidth=1.0, label="undecided starting states")
    upper.set(ylabel="share of\nstarting states\nthat settle", ylim=(-0.03, 1.03))
    unit = unit_of(ds["critical_shock"])
    for name, colour, style in (("along", VERMILLION, "solid"), ("against", BLUE, "dashed")):
        shock = unit.of(ds[f"critical_shock_{name}"].values)
        shock = np.where(np.isfinite(shock), shock, np.nan)
        look = {"linestyle": style, **joined}
        lower.plot(x.centres, shock, color=colour, label=f"shock {name} the belt", **look)
    lower.set(ylabel=f"critical shock\n({unit.printed})", xlabel=x.title)
    lower.set_ylim(bottom=0.0)
    shade(lower, x.edges, safe, _NONE)
    for ax in (upper, lower):
        shade(ax, x.edges, _bistable(ds), BAND)
    apply(x, lower, "x")
    legend(figure, labelled(lower, upper), fixed_note(ds))
    entitle(figure, upper, title)
    return figure


# --- ramps ------------------------------------------------------------------------------------------------------------


def plot_of_ramp(ds: xr.Dataset, variable: str | None = None, **how: Any) -> Figure:
    """The plot of a ramp: its branches for an amplitude, and unless another variable is named; else both ways of that.

    how : select and title. Raises PlotError.
    """
    if variable is None or variable in _UNSTABLE:
        return plot_branches(ds, variable or "velocity_amplitude", **how)
    return plot_ramp(ds, variable, **how)


def plot_ramp(
    ds: xr.Dataset,
    variable: str = "velocity_amplitude",
    *,
    select: Mapping[str, Any] | None = None,
    title: str | None = None,
) -> Figure:
    """A variable of a ramp while the parameter rises, and while it falls.

    variable : of the ramp. select : fixes the lines. Raises PlotError.
    """
    check_dataset(ds)
    if "direction" not in ds.dims or variable not in ds.data_vars:
        raise PlotError(f"not a ramp with {variable}")
    ds, title = line_of(ds, variable, 2, select, title)
    x, unit = MapAxis(ds, ds[variable].dims[-1]), unit_of(ds[variable])
    figure = Figure(figsize=(7.6, 4.8), layout="constrained")
    ax = figure.subplots()
    for name, look in _WAYS.items():
        values = unit.of(ds[variable].sel(direction=name).values)
        ax.plot(x.centres, values, markevery=max(1, x.length // 25), markerfacecolor="white", **look)
    settles = ds["regime"].where(ds["regime"] != REGIMES.index("creep"), REGIMES.index("damped"))  # one as the other
    up, down = (settles.sel(direction=name).values for name in ("up", "down"))
    shade(ax, edges_of(ds, x), up != down, BAND)
    ax.set(xlabel=x.title, ylabel=array_title(ds[variable], unit))
    ax.set_ylim(bottom=min(0.0, ax.get_ylim()[0]))
    apply(x, ax, "x")
    legend(figure, labelled(ax), fixed_note(ds))
    entitle(figure, ax, title)
    return figure


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
    check_dataset(ds)
    if "direction" not in ds.dims or variable not in ds.data_vars:
        raise PlotError("not a ramp, of which branches are drawn\nhint: stickslip.ramp follows them up and down")
    ds, title = line_of(ds, variable, 2, select, title)
    x, unit = MapAxis(ds, ds[variable].dims[-1]), unit_of(ds[variable])
    amplitudes = [name for name in (variable, _UNSTABLE[variable]) if name in ds]
    ds = ds.assign({name: ds[name].copy(data=unit.of(ds[name].values)) for name in amplitudes})
    figure = Figure(figsize=(7.6, 4.8), layout="constrained")
    ax = figure.subplots()
    edges = edges_of(ds, x)
    _draw_cycles(ax, ds, variable, x.centres)
    _draw_rest(ax, ds, x.centres)
    _draw_unstable_cycle(ax, ds, variable, x.centres)
    _draw_ends(ax, ds, variable, x.centres, edges)
    vibrates_up, vibrates_down = (_is(ds, direction, *_CYCLES) for direction in ("up", "down"))
    shade(ax, edges, vibrates_up != vibrates_down, BAND)
    ax.set(xlabel=x.title, ylabel=f"amplitude of {variable.removesuffix('_amplitude')} ({unit.printed})")
    apply(x, ax, "x")
    ax.margins(y=0.08)
    legend(figure, labelled(ax))
    entitle(figure, ax, title)
    return figure


def _draw_cycles(ax: Axes, ds: xr.Dataset, variable: str, x: Floats) -> None:
    """Stable cycles of either way, by kind."""
    for (name, (colour, label)), direction in product(_CYCLES.items(), ("up", "down")):
        there, values = _is(ds, direction, name), ds[variable].sel(direction=direction).values
        if there.any():
            beside = np.pad(there, 1)
            lone = there & ~beside[:-2] & ~beside[2:]  # through which there is no line
            look: dict[str, Any] = {"color": colour, "zorder": 3, "label": label}
            ax.plot(x, np.where(there, values, np.nan), linewidth=_LINE_WIDTH, **look)
            dot = look | {"marker": "o", "markersize": 2.0 * _LINE_WIDTH, "linestyle": "none", "label": None}
            ax.plot(x[lone], values[lone], **dot)


def _draw_rest(ax: Axes, ds: xr.Dataset, x: Floats) -> None:
    """Motions of no amplitude: steady sliding, stable where the damping ratio says so, and sticking for ever."""
    stuck = _is(ds, "up", "stuck") | _is(ds, "down", "stuck")
    slides = _is(ds, "up", *_SLIDES) | _is(ds, "down", *_SLIDES)
    ratio = ds["damping_ratio"].values if "damping_ratio" in ds else np.where(slides, 1.0, -1.0)
    stable = np.where(np.isnan(ratio), slides, ratio > 0)
    for there, style, width, label in (
        (stable & ~stuck, "solid", _LINE_WIDTH, "steady sliding"),
        (~stable & ~stuck, "dashed", 1.4, "steady sliding, unstable"),
    ):
        if there.any():
            run = there | np.concatenate([[False], there[:-1]])  # to the next point, where the other begins
            line = np.where(run, 0.0, np.nan)
            ax.plot(x, line, color=BLUE, linestyle=style, linewidth=width, zorder=2, label=label)
    if stuck.any():
        look: dict[str, Any] = {"color": GREEN, "linewidth": _LINE_WIDTH, "marker": "s", "markersize": 4}
        ax.plot(x, np.where(stuck, 0.0, np.nan), zorder=3, clip_on=False, label="stuck", **look)


def _draw_unstable_cycle(ax: Axes, ds: xr.Dataset, variable: str, x: Floats) -> None:
    """The unstable cycle, from the Hopf bifurcation on."""
    values = ds[_UNSTABLE[variable]].values if _UNSTABLE[variable] in ds else np.zeros(0)
    if not np.isfinite(values).any():
        return
    starts = hopfs(ds, x)
    places = np.append(x[np.isfinite(values)], starts)
    amplitudes = np.append(values[np.isfinite(values)], np.zeros(len(starts)))
    order = np.argsort(places)
    ax.plot(places[order], amplitudes[order], color=VERMILLION, linestyle="dashed", linewidth=1.6, zorder=3,
            label="unstable cycle")  # fmt: skip


def _draw_ends(ax: Axes, ds: xr.Dataset, variable: str, x: Floats, edges: Floats) -> None:
    """Draw the ends of branches, and the jumps there of a slow ramp, from the last point of a branch on."""
    for direction, step in (("up", 1), ("down", -1)):
        amplitude = ds[variable].sel(direction=direction).values
        vibrates, slides = _is(ds, direction, *_CYCLES)[::step], _is(ds, direction, *_SLIDES)[::step]
        for i in np.flatnonzero((vibrates[:-1] & slides[1:]) | (slides[:-1] & vibrates[1:])):
            before, after = (i, i + 1) if step == 1 else (x.size - 1 - i, x.size - 2 - i)
            start, end = (float(np.nan_to_num(amplitude[j])) for j in (before, after))
            there, towards = edges[max(before, after)], "^" if end > start else "v"
            ax.plot([there] * 3, [start, 0.5 * (start + end), end], marker=towards, markevery=[1], **_JUMP)
            if vibrates[i]:
                colour, _ = _CYCLES[REGIMES[int(ds["regime"].sel(direction=direction).values[before])]]
                ax.plot([x[before], there], [start] * 2, color=colour, linewidth=_LINE_WIDTH, zorder=3)
                ax.plot(there, start, **_FOLD)
    if places := hopfs(ds, x):
        ax.plot(places, np.zeros(len(places)), **_HOPF)


# --- parts of both ----------------------------------------------------------------------------------------------------


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
    title = str(ds.attrs.get("title", "")) if title is None else title
    return ds, "\n".join(filter(None, [title, ", ".join(places)]))


def _bistable(ds: xr.Dataset) -> Flags:
    """Cells where sliding is reached from some states and vibration from others."""
    reached = ds["coexisting"].values
    vibrates, settles = (
        (reached & sum(1 << (REGIMES.index(name) - 1) for name in names)) > 0 for names in (_CYCLES, _SLIDES)
    )
    return np.asarray(vibrates & settles)


def _is(ds: xr.Dataset, direction: str, *names: str) -> Flags:
    codes = [REGIMES.index(name) for name in names]
    return np.asarray(np.isin(ds["regime"].sel(direction=direction).values, codes))


def hopfs(ds: xr.Dataset, x: NDArray[np.float64]) -> list[float]:
    """Places where the damping ratio of steady sliding passes zero."""
    if "damping_ratio" not in ds:
        return []
    ratio = ds["damping_ratio"].values
    at = np.flatnonzero(ratio[:-1] * ratio[1:] < 0)
    return [float(x[i] + (x[i + 1] - x[i]) * ratio[i] / (ratio[i] - ratio[i + 1])) for i in at]


def edges_of(ds: xr.Dataset, x: MapAxis) -> NDArray[np.float64]:
    """The edges of the points of a ramp; where vibration or the stability of sliding ends between two points, there."""
    ends = ds["vibration_end"].values
    places = np.array([*hopfs(ds, x.centres), *x.unit.of(ends[np.isfinite(ends)])])
    edges = x.edges.copy()
    edges[np.searchsorted(x.centres, places)] = places
    return edges
