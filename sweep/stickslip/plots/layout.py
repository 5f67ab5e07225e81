"""Figure, title, legend and file of a plot; texts are shown as they are."""

import os
import re
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from io import BytesIO
from pathlib import Path
from textwrap import fill
from typing import Any

from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.figure import Figure as PlainFigure
from matplotlib.layout_engine import ConstrainedLayoutEngine
from matplotlib.legend_handler import HandlerTuple
from matplotlib.text import Text
from matplotlib.ticker import FixedFormatter, FuncFormatter

from stickslip.errors import PlotError, StoreError, reason, visible
from stickslip.files.targets import NO_FILE_NAME, check_target, replaced
from stickslip.plots import marks
from stickslip.plots.options import inches

DPI = 150  # of pictures unless asked for
_NOTEBOOK_DPI = 100
TITLE_WIDTH = 70  # letters in a line above a plot
NOTE_WIDTH = 110  # in small print
_PANEL_TITLE = 10.0  # points; titles of panels are not larger
_SMALLEST_TITLE = 0.7  # times its usual size: over a narrow figure
_LETTERS_PER_INCH = 9.5  # of a title over a whole figure
BESIDE_LEGEND = 54  # and above one with a legend at its side
_QUARTER = 0.25  # of a figure, what a legend takes at most
_NAMES = 0.19  # of it, what the names of rows take
_LEGEND_SIZES = (8.3, 7.0, 6.0, 5.0)  # points
_HANDLE, _LETTER = 4.0, 0.55  # widths beside the words of a legend, and of a letter, in sizes of its letters
ROW = "name of a row"  # of texts at the right of axes, which are a legend
_BESIDE_AXES = 1.1  # times the height of axes: how long the words along them are
_FEWEST_LETTERS = 8  # in a line
_NOTE_COLOUR = "#555555"
_FIRM_SPACE = "\N{NO-BREAK SPACE}"


@dataclass(frozen=True)
class _Legend:
    """The content and the place of a legend, so that it can be placed again in a figure of another size."""

    handles: list[Any]
    at_right: bool
    note: str


class Figure(PlainFigure):
    """matplotlib's `Figure`, shown by a notebook whose cell ends with it.

    IPython shows figures once pyplot or `%matplotlib inline` have told it how, which plots without pyplot do not. What
    they tell it goes first, with the format and resolution that the user has chosen.

    formulas : whether texts may hold formulas between dollars, which those of people must not.
    """

    formulas = False
    legend_outside: _Legend | None = None

    def draw(self, renderer: Any) -> None:
        """Draw, texts as they are; what matplotlib draws before it saves, without ink, is only laid out."""
        show_verbatim(self)
        engine = self.get_layout_engine()
        if isinstance(engine, ConstrainedLayoutEngine) and self.axes and self.canvas.is_saving():
            engine.execute(self)  # once saved in earnest, it has another
        else:
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


def legend(
    figure: Figure, handles: Sequence[Artist | tuple[Artist, ...]], *, at_right: bool, notes: Sequence[str | None] = (),
) -> None:  # fmt: skip
    """The legend, outside the axes: at the right of a lone map, else below. The notes, lines, are below the plot."""
    if not handles:
        return annotate(figure, notes)
    figure.legend_outside = _Legend(list(handles), at_right, "\n".join(filter(None, notes)))
    _place_legend(figure, figure.legend_outside)


def _place_legend(figure: PlainFigure, entries: _Legend) -> None:
    """The legend where it takes no more than a quarter of the figure: at the right, there in broken lines, or below; in
    smaller letters where it must be."""
    for old in list(figure.legends):
        old.remove()
    figure.supxlabel("")
    width, height = figure.bbox.width, figure.bbox.height
    candidates = [*_candidates(entries, 72 * figure.get_figwidth())]
    for number, (labels, size, columns) in enumerate(candidates, 1):
        where: dict[str, Any] = {"loc": "outside lower center", "ncols": columns}
        drawn = figure.legend(entries.handles, labels, frameon=False, fontsize=size,
                              handler_map={tuple: HandlerTuple(ndivide=None, pad=0.0)},
                              **where if columns else {"loc": "outside right upper"})  # fmt: skip
        show_verbatim(figure, drawn)
        box, wide, high = drawn.get_window_extent(), width, _QUARTER * height
        if not columns:
            wide, high = _QUARTER * width, height
        elif size == _LEGEND_SIZES[-1]:
            high = height
        if (box.width <= wide and box.height <= high) or number == len(candidates):
            break
        drawn.remove()
    if not columns:
        annotate(figure, [entries.note])
    elif entries.note:
        drawn.set_title(entries.note)
        show_verbatim(figure, drawn)
        drawn.get_title().set(fontsize="x-small", color=_NOTE_COLOUR, multialignment="center")
        _fit(drawn.get_title(), width)


def _candidates(entries: _Legend, width: float) -> Iterator[tuple[list[str], float, int]]:
    """The forms of a legend, the best first: labels, size of letters, columns below the plot (none: at the right).

    width : of the figure (points).
    """
    labels = [str((one[0] if isinstance(one, tuple) else one).get_label()) for one in entries.handles]
    for size in _LEGEND_SIZES:
        beside, below = (int((share * width - _HANDLE * size) / (_LETTER * size)) for share in (_QUARTER, 1.0))
        if entries.at_right and beside > _FEWEST_LETTERS:
            yield labels, size, 0
            yield [folded(one, beside) for one in labels], size, 0
        for columns in range(min(4, len(labels)), 1, -1):
            yield labels, size, columns
        yield [folded(one, max(_FEWEST_LETTERS, below)) for one in labels], size, 1


# --- title, size and fit ----------------------------------------------------------------------------------------------


def entitle(figure: PlainFigure, top: Axes, title: str, *, above_all: bool = False, width: int = TITLE_WIDTH) -> None:
    """The title, over the axes it belongs to: over the figure it would be centred on a legend at the side as well.

    width : letters of a line over single axes.
    """
    width = int(_LETTERS_PER_INCH * figure.get_figwidth()) if above_all else width
    title = folded(title, width)
    if above_all:
        figure.suptitle(title, fontsize="large")
    else:
        top.set_title(title, fontsize="large")


def resize(figure: PlainFigure, width: float, height: float) -> None:
    """Give a figure another size, in inches. Letters keep theirs but for titles over narrow figures, and the lines of
    titles and notes fit the width."""
    narrower = min(1.0, width / figure.get_figwidth())
    smaller = max(narrower, _SMALLEST_TITLE)
    figure.set_size_inches(width, height)
    for text in (ax.title for ax in figure.axes if float(ax.title.get_fontsize()) > _PANEL_TITLE):
        text.set_fontsize(smaller * float(text.get_fontsize()))
        text.set_text(folded(text.get_text(), int(BESIDE_LEGEND * narrower / smaller)))
    if isinstance(figure, Figure) and figure.legend_outside:
        _place_legend(figure, figure.legend_outside)
    fit(figure)


def fit(figure: PlainFigure) -> None:
    """Break what is written along axes and over them so that nothing of it is cut off at the edges of the figure."""
    show_verbatim(figure)
    for text in figure.texts:
        _fit(text, figure.bbox.width)
    if (engine := figure.get_layout_engine()) is None:
        return
    engine.execute(figure)
    if _fit_rows(figure):
        engine.execute(figure)
    for ax in figure.axes:
        box = ax.get_window_extent()
        upright = 2.0 * min(0.5 * (box.y0 + box.y1), figure.bbox.y1 - 0.5 * (box.y0 + box.y1))
        _fit(ax.yaxis.label, min(upright, _BESIDE_AXES * box.height))
        across = 2.0 * min(0.5 * (box.x0 + box.x1), figure.bbox.x1 - 0.5 * (box.x0 + box.x1))
        for text in (ax.xaxis.label, ax.title):
            _fit(text, across)
        marks.turn_labels(ax)


def _fit_rows(figure: PlainFigure) -> bool:
    """Break the names at the right of rows, and make them smaller, so that each has room in its row; whether there are
    any."""
    rows = [(text, ax) for ax in figure.axes for text in ax.texts if text.get_gid() == ROW]
    for size in _LEGEND_SIZES if rows else ():
        letters = int(_NAMES * 72 * figure.get_figwidth() / (_LETTER * size))
        for text, _ in rows:
            text.set(text=fill(str(text.get_label()), letters), fontsize=size)
        tallest = max(text.get_window_extent().height for text, _ in rows)
        if all(tallest * len(rows) <= ax.get_window_extent().height for _, ax in rows):
            break
    return bool(rows)


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


def show_verbatim(figure: PlainFigure, part: Artist | None = None) -> None:
    """Have matplotlib show all texts of a figure, or of a part of it, as they are, unless the figure has `formulas`.

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
    for text in (part or figure).findobj(Text):
        if isinstance(text, Text) and text not in own:
            text.set_parse_math(False)
            text.set_text(visible(text.get_text()))
