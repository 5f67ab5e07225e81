"""Friction over slip speed: measured points, fitted curves, and materials compared."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from textwrap import fill
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.lines import Line2D
from matplotlib.patches import Patch
from matplotlib.ticker import NullFormatter
from numpy.typing import NDArray

from stickslip.dataset.selection import check_dataset
from stickslip.errors import PlotError
from stickslip.plots.layout import Figure, entitle, legend
from stickslip.plots.palette import BLACK, FLAG_COLOURS, look_of
from stickslip.theory import reversal_speed
from stickslip.vocabulary import units
from stickslip.vocabulary.flags import QUIET_STATES
from stickslip.vocabulary.models import CURVE
from stickslip_materials.compare.dataset import speeds_of
from stickslip_materials.fit.memory import BRISTLES

if TYPE_CHECKING:
    from stickslip_materials.fit import MaterialFit, MemoryFit

Floats = NDArray[np.float64]
_WIDE = 8.0  # fastest over slowest speed from which the axis is logarithmic
_DENSE = 300  # points of a curve


class Drawn(NamedTuple):
    """A material as it is drawn, speeds in m/s: its points (sigma: their standard deviations, or None), its curve, and
    the ends of its band. falls : points measured while the speed fell, or None. slowing : where friction goes then, a
    line from its fastest speed on; NaN elsewhere."""

    name: str
    speed: Floats
    mu: Floats
    sigma: Floats | None
    grid: Floats
    middle: Floats
    low: Floats
    high: Floats
    slowing: Floats
    falls: NDArray[np.bool_] | None = None


def _plain(value: float, _: float) -> str:
    return f"{value:g}"


def speed_grid(slowest: float, fastest: float) -> Floats:
    """Slip speeds at which a curve is drawn between two speeds (m/s): by ratio where they are far apart."""
    if slowest > 0 and fastest > _WIDE * slowest:
        return np.geomspace(slowest, fastest, _DENSE)
    return np.linspace(slowest, fastest, _DENSE)


def plot_fits(fits: Sequence[MaterialFit], *, title: str | None = None) -> Figure:
    """The points of materials, their fitted curves and 95 % bands; of ageing, friction over waiting time.

    Raises PlotError where there is nothing to draw.
    """
    curves, ageing = [one for one in fits if one.curve], [one for one in fits if one.ageing]
    if not fits:
        raise PlotError("nothing to draw: no fits")
    panels = bool(curves) + bool(ageing)
    figure = Figure(figsize=(7.2 if panels == 1 else 12.0, 4.6), layout="constrained")
    axes = list(figure.subplots(1, panels, squeeze=False)[0])
    handles: list[Line2D] = []
    if curves:
        unit = next((one.points.units["speed"] for one in curves if "speed" in one.points.units), "m/s")
        handles += draw_materials(axes[0], [_fitted(one) for one in curves], unit)
    if ageing:
        handles += _draw_ageing(axes[-1], ageing)
    notes = ["points, fitted curve, 95 % band"] if curves else []
    if any("direction" in one.points for one in curves):
        notes.append("of the other fill: measured as the speed fell")
    if any("mu_stop" in one.curve.coefficients() for one in curves if one.curve):
        notes.append("dotted: down to mu_stop")
    legend(figure, handles, notes)
    entitle(figure, axes[0], title or ", ".join(one.name for one in fits), above_all=True)
    return figure


def plot_memory_fits(fits: Mapping[str, MemoryFit]) -> Figure:
    """Records of contacts with memory, by name, and what is fitted to them; a panel each."""
    figure = Figure(figsize=(7.2, 1.2 + 3.0 * len(fits)), layout="constrained")
    for (name, fit), ax in zip(fits.items(), figure.subplots(len(fits), squeeze=False)[:, 0], strict=True):
        is_loop = fit.law == BRISTLES
        factor, label = (1e6, "displacement (µm)") if is_loop else (1.0, "time (s)")
        ax.plot(factor * fit.along, fit.mu, ".", color="0.65", markersize=3, label="record")
        ax.plot(factor * fit.along, fit.predicted, color="black", linewidth=1.2, label=fit.law)
        ax.set(xlabel=label, ylabel="friction coefficient")
        ax.legend(frameon=False)
        entitle(figure, ax, name)
    return figure


def draw_materials(ax: Axes, materials: Sequence[Drawn], unit: str, *, log: bool | None = None) -> list[Line2D]:
    """Points, curves and bands; the entries of a legend. unit : of the speeds. log : None decides by the speeds."""
    factor = 1.0 / units.si_value(f"1 {unit}", "m s-1")
    for number, one in enumerate(materials):
        look = look_of(number)
        ax.fill_between(factor * one.grid, one.low, one.high, color=look["color"], alpha=0.2, linewidth=0)
        ax.plot(factor * one.grid, one.middle, **look | {"marker": ""}, linewidth=1.4)
        ax.plot(factor * one.grid, one.slowing, color=look["color"], linewidth=1.0, linestyle=(0, (1, 1)))
        falls = np.zeros(one.speed.size, bool) if one.falls is None else one.falls
        other = "white" if number % 2 else look["color"]
        for which, face in ((~falls, look["markerfacecolor"]), (falls, other)):
            sigma = None if one.sigma is None else one.sigma[which]
            look |= {"linestyle": "none", "markerfacecolor": face}
            ax.errorbar(factor * one.speed[which], one.mu[which], sigma, **look, markersize=5, capsize=2)
    speeds = np.concatenate([one.speed for one in materials])
    if log if log is not None else speeds.min() > 0 and speeds.max() > _WIDE * speeds.min():
        ax.set_xscale("log")
        ax.xaxis.set_major_formatter(_plain)
    top = max(float(np.max(one.mu, initial=0.0)) or float(one.middle.max()) for one in materials)
    ax.set(xlabel=f"slip speed ({unit})", ylabel="friction coefficient", ylim=(0.0, 1.15 * top))
    return entries([one.name for one in materials])


def entries(names: Sequence[str]) -> list[Line2D]:
    """Legend entries of materials."""
    return [Line2D([], [], markersize=5, label=name, **look_of(i)) for i, name in enumerate(names)]


def _fitted(one: MaterialFit) -> Drawn:
    assert one.curve is not None
    grid = speed_grid(*one.curve.speeds)
    low, high = one.curve.band(grid)
    points, middle, falls = one.points, one.curve.predict(grid), one.points.get("direction", np.zeros(0)) < 0
    slowing = _slowing(one.curve.coefficients(), grid, middle)
    return Drawn(one.name, points["speed"], points["mu"], points.get("sigma"), grid, middle, low, high, slowing,
                 falls if falls.any() else None)  # fmt: skip


def _slowing(curve: Mapping[str, float], grid: Floats, friction: Floats) -> Floats:
    """Friction over slip speeds on the way down, below the minimum of a curve with mu_stop, Eq. (2a); NaN elsewhere."""
    start = np.fmin(reversal_speed(*(curve[name] for name in CURVE[1:])), grid[-1])
    reversal = np.interp(start, grid, friction)
    stop = curve.get("mu_stop", math.nan)
    return np.where(grid <= start, stop + (reversal - stop) * grid / start, np.nan)


def _draw_ageing(ax: Axes, fits: Sequence[MaterialFit]) -> list[Line2D]:
    """Static friction over waiting time; the entries of a legend."""
    for number, one in enumerate(fits):
        assert one.ageing is not None
        look, time = look_of(number), one.points["time"]
        begin = float(time[time > 0].min())
        grid = np.geomspace(begin, max(float(time.max()), 2 * begin), _DENSE)
        ax.plot(time, one.points["mu"], **look | {"linestyle": "none"})
        ax.plot(grid, one.ageing.predict(grid), **look | {"marker": ""})
    ax.set(xscale="log", xlabel="waiting time (s)", ylabel="static friction coefficient")
    return entries([one.name for one in fits])


_ROOM = 1.6  # factor by which the axis of speeds reaches beyond what is on it
_INSET = 0.015  # of the axis of speeds
_ROW_LETTERS, _FEW = 28, 6  # of a line of a name beside its row; rows that have room for larger letters
_EDGE: dict[str, Any] = {"edgecolor": BLACK, "linewidth": 0.5}
_LOUD = _EDGE | {"facecolor": FLAG_COLOURS["regime"]["stick_slip"], "hatch": "////", "alpha": 0.75}
_CALM = _EDGE | {"facecolor": FLAG_COLOURS["regime"]["damped"], "alpha": 0.6}


def plot_materials(ds: xr.Dataset, *, title: str | None = None) -> Figure:
    """A comparison (`stickslip.compare`): friction over slip speed, and for each material where vibration ends.

    Materials are in their order, the best on top; their names, at the right of the bars, are the legend of both sides.
    Bars say what is known of the border.
    """
    check_dataset(ds)
    if "quiet_above" not in ds:
        raise PlotError("not a comparison of materials: no quiet_above\nhint: stickslip.compare returns one")
    unit = str(ds["quiet_above"].attrs.get("display_units", "m/s"))
    count = ds.sizes["material"]
    figure = Figure(figsize=(9.6, max(5.4, 1.8 + 0.32 * count)), layout="constrained")
    curves, bars = figure.subplots(1, 2, width_ratios=[1.2, 1])
    draw_materials(curves, [_compared(ds, i) for i in range(count)], unit, log=True)
    _draw_borders(bars, ds, unit)
    _legend(figure, ds, unit)
    text = str(ds.attrs.get("title", "")) if title is None else title
    entitle(figure, curves, text, above_all=True)
    return figure


def _compared(ds: xr.Dataset, i: int) -> Drawn:
    name = str(ds["material"].values[i])
    own = ds["point_material"].values == name
    shown = np.isfinite(ds["friction"].values[i])
    sigma = ds["point_sigma"].values[own] if "point_sigma" in ds else None
    grid, speed = ds["slip_speed"].values[shown], ds["point_speed"].values[own]
    middle, low, high = (ds[column].values[i][shown] for column in ("friction", "friction_low", "friction_high"))
    known = sigma is not None and bool(np.isfinite(sigma).all()) and sigma.size > 0
    coefficients = {key: float(ds[key].values[i]) for key in (*CURVE, "mu_stop") if key in ds}
    slowing = _slowing(coefficients, grid, middle)
    mu = ds["point_friction"].values[own]
    return Drawn(name, speed, mu, sigma if known else None, grid, middle, low, high, slowing)


def _draw_borders(ax: Axes, ds: xr.Dataset, unit: str) -> None:
    """A row a material: vibration in the colour of stick-slip, quiet in that of a decay, and what lies between them."""
    factor = 1.0 / units.si_value(f"1 {unit}", "m s-1")
    left, right = ends = _ends(ds, factor)
    size = "small" if ds.sizes["material"] <= _FEW else "xx-small"
    inset = (right / left) ** _INSET  # an arrow at the edge of the axes points out of it, and stays whole
    for i, name in enumerate(map(str, ds["material"].values)):
        border, state = factor * float(ds["quiet_above"].values[i]), QUIET_STATES[int(ds["quiet_state"].values[i])]
        look, outside = look_of(i), ax.get_yaxis_transform()
        ax.plot([1.04, 1.09, 1.14], [i] * 3, **look, markevery=[1], transform=outside, clip_on=False)
        ax.text(1.18, i, fill(name, _ROW_LETTERS), transform=outside, va="center", fontsize=size)
        if state == "not_determined":
            ax.text(left * 1.05, i, "not determined", va="center", fontsize="small")
            continue
        begin = left if state == "quiet_throughout" else border
        ax.barh(i, begin - left, left=left, height=0.62, **_LOUD)
        ax.barh(i, right - begin, left=begin, height=0.62, **_CALM)
        if "quiet_above_low" in ds:
            _draw_interval(ax, i, [factor * float(ds[f"quiet_above_{end}"].values[i]) for end in ("low", "high")], ends)
        mark = {"quiet_throughout": "<", "vibrates_throughout": ">"}.get(state, look["marker"])
        place = min(max(border, left * inset), right / inset)
        ax.plot(place, i, **look | {"marker": mark}, markersize=6, zorder=5 if mark in "<>" else 3)
    for speed in speeds_of(ds):
        ax.axvline(factor * speed, color=BLACK, linestyle="dashdot", linewidth=1.2)
    ax.set(yticks=[], ylim=(ds.sizes["material"] - 0.5, -0.5), xlim=ends, xlabel=f"belt speed ({unit})", xscale="log")
    ax.xaxis.set_major_formatter(_plain)
    ax.xaxis.set_minor_formatter(NullFormatter())


def _draw_interval(ax: Axes, i: int, interval: list[float], ends: tuple[float, float]) -> None:
    """The interval of a border, as far as the axis goes."""
    if any(map(math.isnan, interval)):
        return
    places = [min(max(end, ends[0]), ends[1]) for end in interval]
    ax.plot(places, [i, i], color=BLACK, linewidth=2.2, solid_capstyle="butt", zorder=4)
    for place, end in zip(places, interval, strict=True):
        if ends[0] < end < ends[1]:
            ax.plot([place, place], [i - 0.2, i + 0.2], color=BLACK, linewidth=1.6, zorder=4)


def _ends(ds: xr.Dataset, factor: float) -> tuple[float, float]:
    """The axis of speeds: what was measured, the borders and their intervals, and the belt speed."""
    names = ("point_speed", "slip_speed", "quiet_above", "quiet_above_low", "quiet_above_high")
    shown = np.concatenate([ds[name].values for name in names if name in ds] + [np.array(speeds_of(ds))])
    least, most = (factor * float(ds.attrs[f"searched_{end}"]) for end in ("from", "to"))
    inside = [value for value in (factor * shown).tolist() if value > 0 and least <= value <= most] or [least, most]
    return max(min(inside) / _ROOM, least), min(max(inside) * _ROOM, most)


def _legend(figure: Figure, ds: xr.Dataset, unit: str) -> None:
    handles: list[Any] = [Patch(**_LOUD, label="vibrates"), Patch(**_CALM, label="quiet")]
    if "quiet_above_low" in ds:
        level = f"{100 * float(ds.attrs['confidence']):g} % interval of the border"
        handles.append(Line2D([], [], color=BLACK, linewidth=2.2, label=level))
    if belt_speeds := speeds_of(ds):
        speeds = [f"{speed / units.si_value(f'1 {unit}', 'm s-1'):g}" for speed in belt_speeds]
        label = f"belt speed {(' to ' if 'speed_range_from' in ds.attrs else ', ').join(speeds)} {unit}"
        handles.append(Line2D([], [], color=BLACK, linestyle="dashdot", linewidth=1.2, label=label))
    legend(figure, handles)
