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

DPI = 150  # of pictures unless asked for
_NOTE_COLOUR = "#555555"
_MADE_BY = "stickslip plot"
_KEPT_AS = {".png": "Description", ".svg": "Description", ".pdf": "Subject"}  # the keys that the formats have


def legend(
    figure: Figure, handles: Sequence[Artist | tuple[Artist, ...]], *, at_right: bool,
    notes: Sequence[str | None] = (),
) -> None:  # fmt: skip
    """The legend, outside the axes: at the right of a lone map, else below. The notes, lines, are below the plot."""
    note = "\n".join(filter(None, notes))
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
        legend = figure.legend(shown, labels, loc="outside lower center", ncols=columns, title=note or None, **looks)
        legend.get_title().set(fontsize="x-small", color=_NOTE_COLOUR)


def entitle(figure: Figure, top: Axes, title: str, *, above_all: bool = False) -> None:
    """The title, over the axes it belongs to: over the figure it would be centred on a legend at the side as well."""
    if above_all:
        figure.suptitle(title, fontsize="large")
    else:
        top.set_title(title, fontsize="large")


def save(figure: Figure, path: str | os.PathLike[str], dpi: float = DPI, request: str = "") -> None:
    """Write a plot; its format is that of the name (.png, .svg, .pdf). Raises PlotError.

    request : what was asked of the picture besides what it shows by itself; kept in it, so that `request_of` tells
    pictures apart.
    """
    where = _KEPT_AS.get(os.path.splitext(path)[1].lower())
    try:
        figure.savefig(path, dpi=dpi, metadata={where: f"{_MADE_BY} {request}".rstrip()} if where else None)
    except (OSError, ValueError) as error:
        raise PlotError(f"{os.fspath(path)}: cannot be written ({reason(error)})") from error


def request_of(path: str | os.PathLike[str]) -> str | None:
    """The request a PNG was made for (`save`); None if it is no PNG, or not one of ours."""
    from PIL import Image  # matplotlib writes with it

    try:
        with Image.open(path) as image:
            said = str(image.info.get(_KEPT_AS[".png"], ""))
    except (OSError, ValueError):
        return None
    return said.removeprefix(_MADE_BY).strip() if said.startswith(_MADE_BY) else None
