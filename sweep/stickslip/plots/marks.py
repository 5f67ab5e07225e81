"""Operating points over maps: a ring at the place, its label beside it."""

from __future__ import annotations

from collections.abc import Hashable, Iterable, Mapping
from typing import Any

import matplotlib.patheffects as patheffects
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.lines import Line2D

from stickslip.dataset.axis import MapAxis
from stickslip.dataset.select import places
from stickslip.errors import PlotError
from stickslip.plots.look import Mark

_RING: dict[str, Any] = {"marker": "o", "markersize": 8, "markerfacecolor": "white", "markeredgecolor": "black",
                         "markeredgewidth": 1.6, "linestyle": "none"}  # fmt: skip
LINE: dict[str, Any] = {"color": "black", "linestyle": "dashdot", "linewidth": 1.2}
_HALO = [patheffects.Stroke(linewidth=3.0, foreground="white"), patheffects.Normal()]
_MIDDLE = 0.7  # of the width of the axes: beyond it a label stands at the left of its mark


def check(marks: Iterable[Mark], dims: Iterable[Any], needed: Iterable[Any]) -> None:
    """Raise PlotError for an operating point that does not say where it is along an axis that is drawn."""
    for mark in marks:
        if missing := [str(dim) for dim in needed if dim not in mark.at]:
            raise PlotError(f"--mark {mark.label}: where along {', '.join(missing)}?")
        if other := [name for name in mark.at if name not in set(map(str, dims))]:
            raise PlotError(f"--mark {mark.label}: {', '.join(other)} is fixed in this picture")


def in_panel(mark: Mark, ds: xr.Dataset, panel: Mapping[Hashable, int]) -> bool:
    """Whether a mark lies in a panel, or in all. panel : positions along the dimensions that are fixed in it."""
    at = places(ds, {str(dim): mark.at[str(dim)] for dim in panel if str(dim) in mark.at})
    return all(panel[dim] == i for dim, i in at.items())


def draw(ax: Axes, marks: Iterable[Mark], x: MapAxis, y: MapAxis) -> None:
    """Draw marks into the axes of a map."""
    for mark in marks:
        place = position(x, mark.at[str(x.dim)]), position(y, mark.at[str(y.dim)])
        ax.plot(*place, zorder=5, **_RING)
        _label(ax, mark.label, place)


def _label(ax: Axes, label: str, place: tuple[float, float]) -> None:
    """The label, on the side where there is room."""
    across = ax.transAxes.inverted().transform(ax.transData.transform(place))[0]
    left = across > _MIDDLE
    words = ax.annotate(label, place, xytext=(-8 if left else 8, 0), textcoords="offset points", fontweight="bold",
                        ha="right" if left else "left", va="center", zorder=5)  # fmt: skip
    words.set_path_effects(_HALO)


def position(axis: MapAxis, value: Any) -> float:
    """Where along an axis a value in SI, or a label, is."""
    if axis.is_numeric:
        return float(axis.unit.of(value))
    return float(next(i for i in range(axis.length) if str(value) in (axis.text(i), str(i))))


def entries(marks: Iterable[Mark], ds: xr.Dataset, line: bool = False) -> list[Line2D]:
    """Legend entries: what each label stands for. line : the marks are lines, over a single axis."""
    looks = LINE if line else _RING | {"markersize": 6}
    found = []
    for mark in marks:
        axes = {name: MapAxis(ds, name) for name in mark.at}
        told = ", ".join(_told(ds, name, axis, mark.at[name]) for name, axis in axes.items())
        found.append(Line2D([], [], label=f"{mark.label}: {told}", **looks))
    return found


def _told(ds: xr.Dataset, name: str, axis: MapAxis, value: Any) -> str:
    if not axis.is_numeric:
        return str(value)
    return f"{axis.unit.of(value):.4g} {axis.unit.printed}".rstrip() if axis.unit.name else f"{name} = {value:.4g}"
