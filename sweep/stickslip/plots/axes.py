"""Axes of plots, drawn as the dimensions of a dataset require."""

from collections.abc import Mapping
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.ticker import FuncFormatter, LogLocator, MaxNLocator, NullFormatter
from numpy.typing import NDArray

from stickslip.dataset.display import MapAxis
from stickslip.errors import PlotError, visible
from stickslip.plots.options import PLAIN, Look
from stickslip.vocabulary.display_units import Unit

_PLAIN = 0.005, 2e4  # between them numbers are written without powers of ten
_FEW_DECADES = 100.0
_MOST_TICKS = 12  # labels side by side
_CROWDED = 45  # characters of all tick labels of an x axis, from which on they are written at a slant


def scaled(ax: Axes, which: str, name: str, unit: Unit, look: Look) -> None:
    """Give the axis `which` ("x" or "y") the scale and the limits that are wished for what it shows."""
    if name in look.log:
        ax.set(**{f"{which}scale": "log"})
    if name in look.limits:
        ax.set(**{f"{which}lim": tuple(unit.of(end) for end in look.limits[name])})
    plain_numbers(ax, which)


def plain_numbers(ax: Axes, which: str) -> None:
    """Ticks of a logarithmic axis as 1, 10, 100 where they are short so, and 2 and 5 between if they are few."""
    drawn = ax.xaxis if which == "x" else ax.yaxis
    low, high = sorted(drawn.get_view_interval())
    if drawn.get_scale() != "log" or not _PLAIN[0] <= low < high <= _PLAIN[1]:
        return
    drawn.set_major_locator(LogLocator(subs=(1.0, 2.0, 5.0) if high < _FEW_DECADES * low else (1.0,)))
    drawn.set_major_formatter(FuncFormatter(lambda tick, _: f"{tick:g}"))
    drawn.set_minor_formatter(NullFormatter())


def apply(axis: MapAxis, ax: Axes, which: str, look: Look = PLAIN) -> None:
    """Give `ax` the scale, limits and ticks of a dimension, as its axis `which` ("x" or "y"). Raises PlotError."""
    if str(axis.dim) in look.log and not axis.is_log:
        raise PlotError(f"{axis.dim} is not positive everywhere: its axis cannot be logarithmic\n"
                        f"hint: limits that are positive: --limits {axis.dim}=LOW..HIGH")  # fmt: skip
    if axis.is_log:
        ax.set(**{f"{which}scale": "log"})
    ax.set(**{f"{which}lim": (axis.edges[0], axis.edges[-1])})
    scaled(ax, which, str(axis.dim), axis.unit, look)
    if axis.is_numeric:
        return
    places = MaxNLocator(_MOST_TICKS, integer=True).tick_values(0, axis.length - 1)
    ticks = [int(tick) for tick in places if 0 <= tick < axis.length]
    words = [visible(axis.text(tick)) for tick in ticks]
    slanted = which == "x" and sum(map(len, words)) > _CROWDED
    drawn = ax.xaxis if which == "x" else ax.yaxis
    drawn.set_ticks(ticks, labels=words)
    drawn.set_tick_params(length=0)
    if slanted:
        for word in drawn.get_ticklabels():
            word.set(rotation=30, ha="right", rotation_mode="anchor")


def shade(ax: Axes, edges: NDArray[np.float64], where: NDArray[np.bool_], look: Mapping[str, Any]) -> bool:
    """Shade runs of cells between their edges; whether there are any."""
    changes = np.flatnonzero(np.diff(np.concatenate([[False], where, [False]]).astype(np.int8)))
    for first, past in zip(changes[::2], changes[1::2], strict=True):
        ax.axvspan(edges[first], edges[past], zorder=0, **look)
    return bool(where.any())
