"""Bifurcation diagrams: which motions there are along a parameter, stable and unstable."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.lines import Line2D
from matplotlib.patches import Patch
from numpy.typing import NDArray

from stickslip.dataset.axis import MapAxis
from stickslip.dataset.display import unit_of
from stickslip.errors import PlotError
from stickslip.plots.attractors import BAND, edges_of, hopfs, line_of, plot_ramp, shade
from stickslip.plots.axes import apply
from stickslip.plots.figure import Figure
from stickslip.plots.page import entitle, legend
from stickslip.plots.palette import BLACK, BLUE, FLAG_COLOURS, GREEN, VERMILLION
from stickslip.vocabulary.flags import REGIMES

Floats = NDArray[np.float64]
Flags = NDArray[np.bool_]

_UNSTABLE = {"velocity_amplitude": "unstable_velocity_amplitude", "displacement_amplitude": "unstable_amplitude"}
_CYCLES = {"stick_slip": VERMILLION, "sustained": FLAG_COLOURS["regime"]["sustained"]}
_SLIDES = ("damped", "creep")
_WIDTH = 2.2
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
    if shade(ax, edges, _bistable(ds)):
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


def _bistable(ds: xr.Dataset) -> Flags:
    """Where the way up vibrates and the way down does not, or the other way round."""
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
            ax.plot(x, values, color=colour, linewidth=_WIDTH, zorder=3)
            drawn |= bool(there.any())
        if drawn:
            label = {"stick_slip": "stick-slip", "sustained": "vibration without sticking"}[name]
            handles.append(Line2D([], [], color=colour, linewidth=_WIDTH, label=label))
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
            look: dict[str, Any] = {"color": BLUE, "linestyle": style, "linewidth": _WIDTH if stable[there][0] else 1.4}
            ax.plot(x, np.where(_and_next(there), 0.0, np.nan), zorder=2, **look)
            handles.append(Line2D([], [], label=label, **look))
    if stuck.any():
        look = {"color": GREEN, "linewidth": _WIDTH, "marker": "s", "markersize": 4}
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
    """Where branches end, and the jumps there of a slow ramp: up to there they are drawn from their last point."""
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
                ax.plot([x[before], there], [start] * 2, color=colour, linewidth=_WIDTH, zorder=3)
                ax.plot(there, start, **_FOLD)
                handles = [Line2D([], [], label="vibration ends", **_FOLD)]
    if places := hopfs(ds, x):
        ax.plot(places, np.zeros(len(places)), **_HOPF)
        handles.append(Line2D([], [], label="sliding loses stability", **_HOPF))
    return handles
