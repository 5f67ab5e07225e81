"""What is around the axes of a figure, the title and the legend, and the file it goes to."""

from __future__ import annotations

import os
from collections.abc import Sequence
from typing import Any

from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.legend_handler import HandlerTuple

from stickslip.errors import PlotError, reason

_NOTE_COLOUR = "#555555"


def legend(
    figure: Figure, handles: Sequence[Artist | tuple[Artist, ...]], *, at_right: bool, note: str | None = None
) -> None:
    """The legend, outside the axes: at the right of a lone map, else below. The note is below the plot."""
    shown: list[Any] = list(handles)  # matplotlib's types know nothing of several artists for one label
    labels = [str((handle[0] if isinstance(handle, tuple) else handle).get_label()) for handle in handles]
    looks: dict[str, Any] = {"frameon": False, "fontsize": "small"}
    looks["handler_map"] = {tuple: HandlerTuple(ndivide=None, pad=0.0)}
    if note and (at_right or not shown):
        figure.supxlabel(note, fontsize="x-small", color=_NOTE_COLOUR)
    if shown and at_right:
        figure.legend(shown, labels, loc="outside right upper", **looks)
    elif shown:
        columns = min(4, len(shown))
        legend = figure.legend(shown, labels, loc="outside lower center", ncols=columns, title=note, **looks)
        legend.get_title().set(fontsize="x-small", color=_NOTE_COLOUR)


def entitle(figure: Figure, top: Axes, title: str, *, above_all: bool = False) -> None:
    """The title, over the axes it belongs to: over the figure it would be centred on a legend at the side as well."""
    if above_all:
        figure.suptitle(title, fontsize="large")
    else:
        top.set_title(title, fontsize="large")


def save(figure: Figure, path: str | os.PathLike[str], dpi: float = 150) -> None:
    """Write a plot; its format is that of the name (.png, .svg, .pdf). Raises PlotError."""
    try:
        figure.savefig(path, dpi=dpi)
    except (OSError, ValueError) as error:
        raise PlotError(f"{os.fspath(path)}: cannot be written ({reason(error)})") from error
