"""What is around the axes of a figure, the title and the legend, and the file it goes to."""

from __future__ import annotations

import os
import re
from collections.abc import Sequence
from textwrap import fill
from typing import Any

from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.legend_handler import HandlerTuple
from matplotlib.text import Text

from stickslip.errors import PlotError, reason

DPI = 150  # of pictures unless asked for
TITLE_WIDTH = 70  # letters in a line above a plot
NOTE_WIDTH = 110  # in small print
_PANEL_TITLE = 10.0  # points; titles of panels are not larger
_SMALLEST_TITLE = 0.7  # times its usual size: over a narrow figure
_LETTERS_PER_INCH = 9.5  # of a title over a whole figure
BESIDE_LEGEND = 54  # and above one with a legend at its side
_NOTE_COLOUR = "#555555"
_FIRM_SPACE = "\N{NO-BREAK SPACE}"
_MADE_BY = "stickslip plot"
_KEPT_AS = {".png": "Description", ".svg": "Description", ".pdf": "Subject"}  # the keys that the formats have


def wrapped(text: str, width: int) -> str:
    """`text` in lines of about `width` letters; a value stays with its name, and so does what is in brackets."""
    kept = re.sub(r"\([^)]*\)|[^\s,=][^,=]* = [^,]+", lambda found: found[0].replace(" ", _FIRM_SPACE), text)
    return fill(kept, width).replace(_FIRM_SPACE, " ")


def annotate(figure: Figure, notes: Sequence[str | None]) -> None:
    """Lines in small print below a plot without a legend there."""
    if note := "\n".join(filter(None, notes)):
        figure.supxlabel(note, fontsize="x-small", color=_NOTE_COLOUR)


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
    if at_right or not shown:
        annotate(figure, notes)
    if shown and at_right:
        figure.legend(shown, labels, loc="outside right upper", **looks)
    elif shown:
        columns = min(4, len(shown))
        legend = figure.legend(shown, labels, loc="outside lower center", ncols=columns, title=note or None, **looks)
        legend.get_title().set(fontsize="x-small", color=_NOTE_COLOUR, multialignment="center")


def entitle(figure: Figure, top: Axes, title: str, *, above_all: bool = False, width: int = TITLE_WIDTH) -> None:
    """The title, over the axes it belongs to: over the figure it would be centred on a legend at the side as well.

    width : letters of a line over single axes.
    """
    width = int(_LETTERS_PER_INCH * figure.get_figwidth()) if above_all else width
    title = folded(title, width)
    if above_all:
        figure.suptitle(title, fontsize="large")
    else:
        top.set_title(title, fontsize="large")


def resize(figure: Figure, width: float, height: float) -> None:
    """Give a figure another size, in inches. Letters keep theirs but for titles over narrow figures, and the lines of
    titles and notes fit the width."""
    narrower = min(1.0, width / figure.get_figwidth())
    smaller = max(narrower, _SMALLEST_TITLE)
    figure.set_size_inches(width, height)
    for text in (ax.title for ax in figure.axes if float(ax.title.get_fontsize()) > _PANEL_TITLE):
        text.set_fontsize(smaller * float(text.get_fontsize()))
        _refit(text, BESIDE_LEGEND * narrower / smaller)
    for text in (*figure.texts, *(legend.get_title() for legend in figure.legends)):
        _refit(text, NOTE_WIDTH * narrower)


def _refit(text: Text, letters: float) -> None:
    text.set_text(folded(text.get_text(), int(letters)))


def folded(text: str, width: int) -> str:
    """Lines of text, those that are too long broken, and those broken before joined again: a break leaves its space."""
    lines = text.replace(" \n", " ").splitlines()
    return "\n".join(wrapped(line, width).replace("\n", " \n") for line in lines)


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
