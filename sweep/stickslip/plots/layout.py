"""Figure, title, legend and file of a plot; texts are shown as they are.

Axes of plots, drawn as the dimensions of a dataset require.
"""

import os
import re
from collections.abc import Mapping, Sequence
from io import BytesIO
from pathlib import Path
from textwrap import fill
from typing import Any

import numpy as np
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.figure import Figure as PlainFigure
from matplotlib.legend_handler import HandlerTuple
from matplotlib.text import Text
from matplotlib.ticker import FixedFormatter, FuncFormatter, LogLocator, MaxNLocator, NullFormatter
from numpy.typing import NDArray

from stickslip.dataset.display import MapAxis
from stickslip.errors import PlotError, StoreError, reason, visible
from stickslip.files.targets import NO_FILE_NAME, check_target, replaced
from stickslip.plots.options import PLAIN, Look, inches
from stickslip.vocabulary.display_units import Unit

DPI = 150  # of pictures unless asked for
_NOTEBOOK_DPI = 100
TITLE_WIDTH = 70  # letters in a line above a plot
NOTE_WIDTH = 110  # in small print
_LETTERS_PER_INCH = 9.5  # of a title over a whole figure
_LEGEND_SIZE, _SMALL_SIZE = 8.3, 7.0  # points, of the letters of a legend, and of one of many entries and of notes
_MANY, _MOST_COLUMNS = 6, 4
_LETTER, _HANDLE = 0.6, 8  # width of a letter in sizes; letters as wide as what stands beside a label
_BESIDE_AXES = 1.1  # times the height of axes: how long the words along them are
_FEWEST_LETTERS = 8  # in a line
_NOTE_COLOUR = "#555555"
_FIRM_SPACE = "\N{NO-BREAK SPACE}"


class Figure(PlainFigure):
    """matplotlib's `Figure`, shown by a notebook whose cell ends with it.

    IPython shows figures once pyplot or `%matplotlib inline` have told it how, which plots without pyplot do not. What
    they tell it goes first, with the format and resolution that the user has chosen.

    formulas : whether texts may hold formulas between dollars, which those of people must not.
    """

    formulas = False
    entries: tuple[Sequence[Any], Sequence[str | None]] = (), ()  # handles and notes of the legend

    def draw(self, renderer: Any) -> None:
        """Draw, texts as they are."""
        show_verbatim(self)
        super().draw(renderer)

    def _repr_png_(self) -> bytes:
        fit(self)
        picture = BytesIO()
        self.savefig(picture, format="png", dpi=_NOTEBOOK_DPI)
        return picture.getvalue()


# --- texts ------------------------------------------------------------------------------------------------------------


def wrapped(text: str, width: int) -> str:
    """`text` in lines of about `width` letters; a value stays with its name, and so does what is in brackets."""
    joined = re.sub(r"\([^)]*\)|[^\s,=][^,=]* = [^,]+", lambda part: part[0].replace(" ", _FIRM_SPACE), text)
    return fill(joined, width).replace(_FIRM_SPACE, " ")


def folded(text: str, width: int) -> str:
    """Lines of text, those that are too long broken, and those broken before joined again: a break leaves its space."""
    lines = text.replace(" \n", " ").splitlines()
    return "\n".join(wrapped(line, width).replace("\n", " \n") for line in lines)


def annotate(figure: PlainFigure, notes: Sequence[str | None]) -> None:
    """Lines in small print below a plot without a legend there."""
    if note := "\n".join(filter(None, notes)):
        figure.supxlabel(note, fontsize="x-small", color=_NOTE_COLOUR)


# --- legend -----------------------------------------------------------------------------------------------------------


def labelled(*axes: Axes) -> list[Any]:
    """The artists of axes that have a label, one for each label."""
    artists: dict[str, Artist] = {}
    for ax in axes:
        for artist, label in zip(*ax.get_legend_handles_labels(), strict=True):
            artists.setdefault(label, artist)
    return [*artists.values()]


def legend(figure: Figure, handles: Sequence[Any], notes: Sequence[str | None] = ()) -> None:
    """The legend below the axes, in as many columns as its labels have room for, under the notes, lines."""
    if not handles:
        return annotate(figure, notes)
    for old in [*figure.legends]:
        old.remove()
    figure.entries = handles, notes
    size = _LEGEND_SIZE if len(handles) <= _MANY else _SMALL_SIZE
    room = int(72 * figure.get_figwidth() / (_LETTER * size)) - _HANDLE
    labels = [folded(str((handle[0] if isinstance(handle, tuple) else handle).get_label()), room) for handle in handles]
    longest = max(map(len, "\n".join(labels).splitlines()))
    columns = max(1, min(_MOST_COLUMNS, len(labels), (room + _HANDLE) // (longest + _HANDLE)))
    drawn = figure.legend(handles, labels, loc="outside lower center", ncols=columns, frameon=False, fontsize=size,
                          handler_map={tuple: HandlerTuple(ndivide=None, pad=0.0)})  # fmt: skip
    if note := "\n".join(filter(None, notes)):
        drawn.set_title(folded(note, int(72 * figure.get_figwidth() / (_LETTER * _SMALL_SIZE))))
        drawn.get_title().set(fontsize=_SMALL_SIZE, color=_NOTE_COLOUR, multialignment="center")


# --- title, size and fit ----------------------------------------------------------------------------------------------


def entitle(figure: PlainFigure, top: Axes, title: str, *, above_all: bool = False) -> None:
    """The title, over the axes it belongs to, or over the whole figure."""
    if above_all:
        figure.suptitle(folded(title, int(_LETTERS_PER_INCH * figure.get_figwidth())), fontsize="large")
    else:
        top.set_title(folded(title, TITLE_WIDTH), fontsize="large")


def resize(figure: PlainFigure, width: float, height: float) -> None:
    """Give a figure another size, in inches. Letters keep theirs; lines of titles, notes and labels fit the width."""
    figure.set_size_inches(width, height)
    if isinstance(figure, Figure) and figure.legends:
        legend(figure, *figure.entries)
    fit(figure)


def fit(figure: PlainFigure) -> None:
    """Break what is written along axes and over them so that nothing of it is cut off at the edges of the figure."""
    show_verbatim(figure)
    for text in figure.texts:
        _fit(text, figure.bbox.width)
    if (engine := figure.get_layout_engine()) is None:
        return
    for _ in range(2):  # names of axes in several lines move the axes
        engine.execute(figure)
        for ax in figure.axes:
            box = ax.get_window_extent()
            upright = 2.0 * min(0.5 * (box.y0 + box.y1), figure.bbox.y1 - 0.5 * (box.y0 + box.y1))
            _fit(ax.yaxis.label, min(upright, _BESIDE_AXES * box.height))
            across = 2.0 * min(0.5 * (box.x0 + box.x1), figure.bbox.x1 - 0.5 * (box.x0 + box.x1))
            for text in (ax.xaxis.label, ax.title):
                _fit(text, across)


def _fit(text: Text, room: float) -> None:
    """Break a text into lines that are no longer than `room`, in pixels; what fits already stays as it is."""
    if not text.get_text():
        return
    for _ in range(3):  # letters are not equally wide
        box = text.get_window_extent()
        length = box.height if text.get_rotation() == 90.0 else box.width
        if length <= room:
            return
        letters = max(map(len, text.get_text().splitlines()))
        text.set_text(folded(text.get_text(), max(_FEWEST_LETTERS, int(0.97 * letters * room / length))))


def save(figure: PlainFigure, path: str | os.PathLike[str], dpi: float = DPI, size: str | None = None) -> None:
    """Write a plot; its format is that of the name (.png, .svg, .pdf). Raises PlotError.

    size : as text, "16 cm x 9 cm" or "1920 px x 1080 px"; None for its own.
    """
    if size is not None:
        resize(figure, *inches(size, dpi))
    fit(figure)
    try:
        check_target(path, "plot")
        with replaced(path) as temporary:
            figure.savefig(temporary, dpi=dpi, format=os.path.splitext(path)[1][1:].lower())
    except StoreError as error:
        raise PlotError(str(error)) from error
    except ValueError as error:
        raise PlotError(f"{os.fspath(path)}: cannot be written ({reason(error)})") from error


def name_of(stem: Path, variable: str | None, places: Mapping[str, str]) -> Path:
    """The name of a picture nobody named: FILE.png, FILE-VARIABLE.png, FILE-VARIABLE-DIM-VALUE.png.

    stem : FILE, without suffix. variable : unless it is what the file shows by itself.
    """
    words = [*filter(None, [variable]), *(f"{name}-{value}" for name, value in places.items())]
    return stem.with_name(f"{NO_FILE_NAME.sub('_', '-'.join([stem.name, *words])) if words else stem.name}.png")


def show_verbatim(figure: PlainFigure) -> None:
    """Have matplotlib show all texts of a figure as they are, unless the figure has `formulas`.

    Ticks that matplotlib labels by itself keep their powers of ten.
    """
    if getattr(figure, "formulas", False):
        return
    own = set[Artist]()
    for ax in figure.axes:
        for axis in (ax.xaxis, ax.yaxis):
            if isinstance(axis.get_major_formatter(), FixedFormatter | FuncFormatter):  # labels that are given
                axis.get_majorticklabels()  # which makes them
            else:
                own.update(set(axis.findobj(Text)) - {axis.label})
    for text in figure.findobj(Text):
        if isinstance(text, Text) and text not in own:
            text.set_parse_math(False)
            text.set_text(visible(text.get_text()))


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
