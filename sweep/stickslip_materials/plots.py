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
from stickslip.plots.layout import Figure, entitle, labelled, legend
from stickslip.plots.palette import BLACK, FLAG_COLOURS, look_of
from stickslip.theory import reversal_speed
from stickslip.vocabulary import units
from stickslip.vocabulary.models import CURVE
from stickslip.vocabulary.quantities import QUIET_STATES
from stickslip_materials.compare.result import speeds_of

if TYPE_CHECKING:
    from stickslip_materials.fit import MaterialFit, MemoryFit

Floats = NDArray[np.float64]
_WIDE = 8.0  # fastest over slowest speed from which the axis is logarithmic
_DENSE = 300  # points of a curve
_ROOM = 1.6  # factor by which the axis of speeds reaches beyond what is on it
_ROW_LETTERS, _FEW = 28, 6  # of a line of a name beside its row; rows that have room for larger letters
_EDGE: dict[str, Any] = {"edgecolor": BLACK, "linewidth": 0.5}
_LOUD = _EDGE | {"facecolor": FLAG_COLOURS["regime"]["stick_slip"], "hatch": "////", "alpha": 0.75}
_CALM = _EDGE | {"facecolor": FLAG_COLOURS["regime"]["damped"], "alpha": 0.6}


class DrawnMaterial(NamedTuple):
    """A material as it is drawn, speeds in m/s: its points (sigma: their standard deviations, or None), its curve with
    the ends of its band, and its coefficients."""

    speed: Floats
    mu: Floats
    sigma: Floats | None
    grid: Floats
    middle: Floats
    low: Floats
    high: Floats
    coefficients: Mapping[str, float]

    def slowing(self) -> Floats:
        """Friction on the way down, below the minimum of a curve with mu_stop, Eq. (2a); NaN elsewhere."""
        start = np.fmin(reversal_speed(*(self.coefficients[name] for name in CURVE[1:])), self.grid[-1])
        stop = self.coefficients.get("mu_stop", math.nan)
        line = stop + (np.interp(start, self.grid, self.middle) - stop) * self.grid / start
        return np.where(self.grid <= start, line, np.nan)


# --- fits -------------------------------------------------------------------------------------------------------------


def plot_fits(fits: Sequence[MaterialFit], *, title: str | None = None) -> Figure:
    """The points of materials, their fitted curves and 95 % bands; of ageing, friction over waiting time.

    Raises PlotError where there is nothing to draw.
    """
    if not fits:
        raise PlotError("nothing to draw: no fits")
    curves, ageing = [fit for fit in fits if fit.curve], [fit for fit in fits if fit.ageing]
    panels = bool(curves) + bool(ageing)
    figure = Figure(figsize=(7.2 if panels == 1 else 12.0, 4.6), layout="constrained")
    axes = list(figure.subplots(1, panels, squeeze=False)[0])
    if curves:
        unit = next((fit.points.units["speed"] for fit in curves if "speed" in fit.points.units), "m/s")
        _draw_curves(axes[0], [_drawn(fit) for fit in curves], unit)
    if ageing:
        _draw_ageing(axes[-1], ageing)
    handles = [Line2D([], [], markersize=5, label=fit.name, **look_of(i))
               for of_kind in (curves, ageing) for i, fit in enumerate(of_kind)]  # fmt: skip
    notes = ["points, fitted curve, 95 % band; dotted: down to mu_stop"] if curves else []
    legend(figure, handles, notes)
    entitle(figure, axes[0], title or ", ".join(fit.name for fit in fits), above_all=True)
    return figure


def plot_memory_fits(fits: Mapping[str, MemoryFit]) -> Figure:
    """Records of contacts with memory, by name, and what is fitted to them; a panel each."""
    figure = Figure(figsize=(7.2, 1.2 + 3.0 * len(fits)), layout="constrained")
    for (name, fit), ax in zip(fits.items(), figure.subplots(len(fits), squeeze=False)[:, 0], strict=True):
        ax.plot(fit.time, fit.mu, ".", color="0.65", markersize=3, label="record")
        ax.plot(fit.time, fit.predicted, color="black", linewidth=1.2, label=fit.law)
        ax.set(xlabel="time (s)", ylabel="friction coefficient")
        entitle(figure, ax, name)
    legend(figure, labelled(*figure.axes))
    return figure


def _drawn(fit: MaterialFit) -> DrawnMaterial:
    assert fit.curve is not None
    slowest, fastest = fit.curve.speeds
    spaced = np.geomspace if slowest > 0 and fastest > _WIDE * slowest else np.linspace
    grid = spaced(slowest, fastest, _DENSE)
    points, curve = fit.points, fit.curve
    return DrawnMaterial(points["speed"], points["mu"], points.get("sigma"), grid, curve.predict(grid),
                 *curve.band(grid), curve.coefficients())  # fmt: skip


def _draw_curves(ax: Axes, materials: Sequence[DrawnMaterial], unit: str, *, log: bool = False) -> None:
    """Points, curves and bands. unit : of the speeds. log : whatever the speeds are."""
    factor = 1.0 / units.si_value(f"1 {unit}", "m s-1")
    for number, drawn in enumerate(materials):
        look = look_of(number)
        ax.fill_between(factor * drawn.grid, drawn.low, drawn.high, color=look["color"], alpha=0.2, linewidth=0)
        ax.plot(factor * drawn.grid, drawn.middle, **look | {"marker": ""}, linewidth=1.4)
        ax.plot(factor * drawn.grid, drawn.slowing(), color=look["color"], linewidth=1.0, linestyle=(0, (1, 1)))
        points = look | {"linestyle": "none"}
        ax.errorbar(factor * drawn.speed, drawn.mu, drawn.sigma, **points, markersize=5, capsize=2)
    speeds = np.concatenate([drawn.speed for drawn in materials])
    if log or speeds.min() > 0 and speeds.max() > _WIDE * speeds.min():
        ax.set_xscale("log")
        ax.xaxis.set_major_formatter("{x:g}")
    top = max(float(np.max(drawn.mu, initial=0.0)) or float(drawn.middle.max()) for drawn in materials)
    ax.set(xlabel=f"slip speed ({unit})", ylabel="friction coefficient", ylim=(0.0, 1.15 * top))


def _draw_ageing(ax: Axes, fits: Sequence[MaterialFit]) -> None:
    """Static friction over waiting time."""
    for number, fit in enumerate(fits):
        assert fit.ageing is not None
        look, time = look_of(number), fit.points["time"]
        begin = float(time[time > 0].min())
        grid = np.geomspace(begin, max(float(time.max()), 2 * begin), _DENSE)
        ax.plot(time, fit.points["mu"], **look | {"linestyle": "none"})
        ax.plot(grid, fit.ageing.predict(grid), **look | {"marker": ""})
    ax.set(xscale="log", xlabel="waiting time (s)", ylabel="static friction coefficient")


# --- comparisons ------------------------------------------------------------------------------------------------------


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
    _draw_curves(curves, [_compared(ds.isel(material=i), ds) for i in range(count)], unit, log=True)
    factor = 1.0 / units.si_value(f"1 {unit}", "m s-1")
    _draw_borders(bars, ds, factor)
    bars.set(xlabel=f"belt speed ({unit})")
    handles: list[Any] = [Patch(**_LOUD, label="vibrates"), Patch(**_CALM, label="quiet")]
    if "quiet_above_low" in ds:
        level = f"{100 * float(ds.attrs['confidence']):g} % interval of the border"
        handles.append(Line2D([], [], color=BLACK, linewidth=2.2, label=level))
    if speeds := [f"{factor * speed:g}" for speed in speeds_of(ds)]:
        label = f"belt speed {(' to ' if 'speed_range_from' in ds.attrs else ', ').join(speeds)} {unit}"
        handles.append(Line2D([], [], color=BLACK, linestyle="dashdot", linewidth=1.2, label=label))
    legend(figure, handles)
    entitle(figure, curves, str(ds.attrs.get("title", "")) if title is None else title, above_all=True)
    return figure


def _compared(material: xr.Dataset, ds: xr.Dataset) -> DrawnMaterial:
    """One of the materials of a dataset."""
    name = str(material["material"].values)
    own, shown = ds["point_material"].values == name, np.isfinite(material["friction"].values)
    sigma = ds["point_sigma"].values[own] if "point_sigma" in ds else np.zeros(0)
    middle, low, high = (material[f"friction{end}"].values[shown] for end in ("", "_low", "_high"))
    coefficients = {key: float(material[key]) for key in (*CURVE, "mu_stop") if key in ds}
    return DrawnMaterial(ds["point_speed"].values[own], ds["point_friction"].values[own],
                 sigma if sigma.size and np.isfinite(sigma).all() else None, ds["slip_speed"].values[shown],
                 middle, low, high, coefficients)  # fmt: skip


def _draw_borders(ax: Axes, ds: xr.Dataset, factor: float) -> None:
    """A row a material: vibration in the colour of stick-slip, quiet in that of a decay, and what lies between them."""
    left, right = ends = _ends(ds, factor)
    size = "small" if ds.sizes["material"] <= _FEW else "xx-small"
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
            interval = np.clip([factor * float(ds[f"quiet_above_{end}"].values[i]) for end in ("low", "high")], *ends)
            ax.plot(interval, [i, i], color=BLACK, linewidth=2.2, solid_capstyle="butt", zorder=4)
        mark = {"quiet_throughout": "<", "vibrates_throughout": ">"}.get(state, look["marker"])
        at = min(max(border, left), right)
        ax.plot(at, i, **look | {"marker": mark}, markersize=6, zorder=5 if mark in "<>" else 3, clip_on=False)
    for speed in speeds_of(ds):
        ax.axvline(factor * speed, color=BLACK, linestyle="dashdot", linewidth=1.2)
    ax.set(yticks=[], ylim=(ds.sizes["material"] - 0.5, -0.5), xlim=ends, xscale="log")
    ax.xaxis.set_major_formatter("{x:g}")
    ax.xaxis.set_minor_formatter(NullFormatter())


def _ends(ds: xr.Dataset, factor: float) -> tuple[float, float]:
    """The axis of speeds: what was measured, the borders and their intervals, and the belt speed."""
    names = ("point_speed", "slip_speed", "quiet_above", "quiet_above_low", "quiet_above_high")
    shown = np.concatenate([ds[name].values for name in names if name in ds] + [np.array(speeds_of(ds))])
    least, most = (factor * float(ds.attrs[f"searched_{end}"]) for end in ("from", "to"))
    inside = [value for value in (factor * shown).tolist() if value > 0 and least <= value <= most] or [least, most]
    return max(min(inside) / _ROOM, least), min(max(inside) * _ROOM, most)
