"""What the plots of the article's figures have in common. No pyplot: they belong to the caller."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import FigureBase
from numpy.typing import ArrayLike, NDArray

from stickslip.dataset.display import si_unit, title
from stickslip.plots.layout import Figure as Plot
from stickslip.plots.palette import BLACK, BLUE, GREEN, GREY, ORANGE, PURPLE, VERMILLION
from stickslip.vocabulary.quantities import MODES

SERIES = (BLUE, VERMILLION, GREEN, PURPLE, ORANGE)  # of cases side by side, in this order
DPI = 110
_WORDS = {"stick_slip": "stick-slip"}


def blank_plot(width: float, height: float, heading: str) -> Plot:
    """An empty plot with a heading, in inches."""
    made = Plot(figsize=(width, height), layout="constrained")
    made.formulas = True
    made.suptitle(heading, fontsize="large")
    return made


def axes_of(made: FigureBase, rows: int, columns: int, **how: Any) -> NDArray[Any]:
    """Axes in `rows` by `columns`, always as a table."""
    found: NDArray[Any] = made.subplots(rows, columns, squeeze=False, **how)
    return found


def in_words(regime: str) -> str:
    """A regime as it is written in a sentence."""
    return _WORDS.get(regime, regime.replace("_", " "))


def name_axes(ax: Axes, x: xr.DataArray | str | None, y: xr.DataArray | str | None) -> None:
    """Titles of the axes, from the names and units of what is drawn."""
    if x is not None:
        ax.set_xlabel(x if isinstance(x, str) else title(x, si_unit(x)))
    if y is not None:
        ax.set_ylabel(y if isinstance(y, str) else title(y, si_unit(y)))


def shade_sticks(ax: Axes, trace: xr.Dataset) -> None:
    """Grey where the mass sticks."""
    inside = trace["mode"].values == MODES.index("stick")
    across = ax.get_xaxis_transform()
    ax.fill_between(trace["time"].values, 0, 1, where=inside.tolist(), transform=across, color=GREY, alpha=0.45,
                    linewidth=0, zorder=0, label="sticking")  # fmt: skip


def belt_line(ax: Axes, speed: float, *, along: str = "x") -> None:
    """The belt speed, dashed; `along` the x axis (a horizontal line) or the y axis."""
    draw = ax.axhline if along == "x" else ax.axvline
    draw(speed, color=BLACK, linewidth=0.9, linestyle="dashed", zorder=1, label="belt speed")


def mark(ax: Axes, x: float, y: float, words: str, offset: tuple[float, float] = (8, 10), **how: Any) -> None:
    """A point with words beside it."""
    ax.plot([x], [y], color=BLACK, marker="o", markersize=4, linestyle="none", zorder=5)
    ax.annotate(words, (x, y), xytext=offset, textcoords="offset points", fontsize="small", zorder=6, **how)


def legend(ax: Axes, **how: Any) -> None:
    """A legend of each label once."""
    handles, labels = ax.get_legend_handles_labels()
    once = dict(zip(labels, handles, strict=True))
    looks: dict[str, Any] = {"frameon": False, "fontsize": "small", "loc": "best"} | how
    ax.legend(once.values(), once.keys(), **looks)


def write_table(ax: Axes, values: NDArray[np.float64], form: str, dark: NDArray[np.bool_]) -> None:
    """Numbers in the fields of an image, white where the field is `dark`."""
    for (row, column), value in np.ndenumerate(values):
        colour = "white" if dark[row, column] else BLACK
        ax.text(column, row, form.format(value), ha="center", va="center", fontsize="small", color=colour)


def tick_values(ax: Axes, x: ArrayLike, y: ArrayLike, form: str = "{:g}") -> None:
    """The values of rows and columns of an image as its ticks."""
    for axis, values in ((ax.xaxis, np.asarray(x)), (ax.yaxis, np.asarray(y))):
        words: Sequence[str] = [form.format(value) for value in values]
        axis.set_ticks(range(len(words)), labels=words)
        axis.set_tick_params(length=0)
