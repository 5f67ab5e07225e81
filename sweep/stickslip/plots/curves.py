"""Plots of friction over slip speed: measured points, the fitted curves, and the bands in which these may lie."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.lines import Line2D
from matplotlib.ticker import FuncFormatter
from numpy.typing import NDArray

from stickslip.errors import PlotError
from stickslip.plots.figure import Figure
from stickslip.plots.page import entitle, legend
from stickslip.plots.palette import BLACK, BLUE, GREEN, ORANGE, PURPLE, SKY, VERMILLION
from stickslip.vocabulary import units

if TYPE_CHECKING:
    from stickslip.fit import MaterialFit

Floats = NDArray[np.float64]
# Ten of each; with the marks and lines materials are told apart without colours.
COLOURS = (BLUE, VERMILLION, BLACK, ORANGE, PURPLE, GREEN, "#542788", SKY, "#8c510a", "#7f7f7f")
MARKS = "os^DvPX*<>"
STYLES: tuple[Any, ...] = (
    "solid", (0, (6, 2)), (0, (1.5, 1.5)), (0, (7, 2, 1.5, 2)), (0, (3, 1.5)), (0, (1, 3)), (0, (12, 2)),
    (0, (6, 1.5, 1.5, 1.5, 1.5, 1.5)), (0, (2, 4)), (0, (10, 2, 3, 2)),
)  # fmt: skip
_WIDE = 8.0  # fastest over slowest speed from which the axis is logarithmic
_DENSE = 300  # points of a curve


@dataclass(frozen=True)
class Drawn:
    """A material as it is drawn, speeds in m/s: its points (sigma: their standard deviations, or None), its curve, and
    the ends of its band."""

    name: str
    speed: Floats
    mu: Floats
    sigma: Floats | None
    grid: Floats
    middle: Floats
    low: Floats
    high: Floats


def look_of(number: int) -> dict[str, Any]:
    """The colour, mark and line of a material, by its place in the order they came in."""
    colour = COLOURS[number % len(COLOURS)]
    return {
        "color": colour, "marker": MARKS[number % len(MARKS)], "linestyle": STYLES[number % len(STYLES)],
        "markerfacecolor": colour if number % 2 else "white",
    }  # fmt: skip


def speed_grid(slowest: float, fastest: float) -> Floats:
    """Slip speeds at which a curve is drawn between two speeds (m/s): by ratio where they are far apart."""
    if slowest > 0 and fastest > _WIDE * slowest:
        return np.geomspace(slowest, fastest, _DENSE)
    return np.linspace(slowest, fastest, _DENSE)


def plot_fits(fits: Sequence[MaterialFit], *, title: str | None = None) -> Figure:
    """The points of materials, their fitted curves and 95 % bands; of ageing, friction over waiting time.

    Raises PlotError where there is nothing to draw.
    """
    curves = [one for one in fits if one.curve is not None]
    ageing = [one for one in fits if one.ageing is not None]
    if not fits:
        raise PlotError("nothing to draw: no fits")
    panels = bool(curves) + bool(ageing)
    figure = Figure(figsize=(7.2 if panels == 1 else 12.0, 4.6), layout="constrained")
    axes = list(figure.subplots(1, panels, squeeze=False)[0])
    handles: list[Line2D] = []
    if curves:
        unit = next((one.points.units["speed"] for one in curves if "speed" in one.points.units), "m/s")
        handles += draw_materials(axes[0], [_drawn(one) for one in curves], unit)
    if ageing:
        handles += _draw_ageing(axes[-1], ageing)
    legend(figure, handles, at_right=panels == 1, notes=["points, fitted curve, 95 % band"] if curves else [])
    entitle(figure, axes[0], title or ", ".join(one.name for one in fits), above_all=True)
    return figure


def draw_materials(ax: Axes, materials: Sequence[Drawn], unit: str, *, log: bool | None = None) -> list[Line2D]:
    """Points, curves and bands; the entries of a legend. unit : of the speeds. log : None decides by the speeds."""
    factor = 1.0 / units.si_value(f"1 {unit}", "m s-1")
    for number, one in enumerate(materials):
        look = look_of(number)
        ax.fill_between(factor * one.grid, one.low, one.high, color=look["color"], alpha=0.2, linewidth=0)
        ax.plot(factor * one.grid, one.middle, **look | {"marker": ""}, linewidth=1.4)
        ax.errorbar(factor * one.speed, one.mu, one.sigma, **look | {"linestyle": "none"}, markersize=5, capsize=2)
    speeds = np.concatenate([one.speed for one in materials])
    if log if log is not None else speeds.min() > 0 and speeds.max() > _WIDE * speeds.min():
        ax.set_xscale("log")
        ax.xaxis.set_major_formatter(FuncFormatter(lambda value, _: f"{value:g}"))
    top = max(float(one.mu.max()) for one in materials)
    ax.set(xlabel=f"slip speed ({unit})", ylabel="friction coefficient", ylim=(0.0, 1.15 * top))
    return entries([one.name for one in materials])


def entries(names: Sequence[str]) -> list[Line2D]:
    """What a legend says of materials."""
    return [Line2D([], [], markersize=5, label=name, **look_of(i)) for i, name in enumerate(names)]


def _drawn(one: MaterialFit) -> Drawn:
    """A fitted curve as it is drawn."""
    assert one.curve is not None
    grid = speed_grid(*one.curve.speeds)
    low, high = one.curve.band(grid)
    points = one.points
    return Drawn(one.name, points["speed"], points["mu"], points.get("sigma"), grid, one.curve.predict(grid), low, high)


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
