"""Figure, title, legend, notes and file of a plot, and axes as the dimensions of a dataset require them.

Texts are shown as they are, in as many lines as they need.
"""

import os
import re
from collections.abc import Mapping, Sequence
from io import BytesIO
from pathlib import Path
from textwrap import fill
from typing import Any

import numpy as np
import xarray as xr
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.figure import Figure as PlainFigure
from matplotlib.legend_handler import HandlerTuple
from matplotlib.text import Text
from matplotlib.ticker import FixedFormatter, FuncFormatter, LogLocator, MaxNLocator, NullFormatter
from numpy.typing import NDArray

from stickslip.dataset.display import MapAxis, short_name, unit_of
from stickslip.errors import PlotError, QuantityError, StoreError, reason, visible
from stickslip.files.targets import NO_FILE_NAME, check_target, replaced
from stickslip.plots.marks import PLAIN, Look
from stickslip.vocabulary import units
from stickslip.vocabulary.display_units import Unit
from stickslip.vocabulary.quantities import QUANTITIES

BESIDE = 15  # letters in a line beside one of several axes
DPI = 150  # of pictures unless asked for
_NOTEBOOK_DPI = 100
_LEGEND_SIZE, _SMALL_SIZE = 8.3, 7.0  # points, of the letters of a legend, and of one of many entries and of notes
_MANY, _MOST_COLUMNS = 6, 4
_LETTER, _HANDLE = 0.6, 8  # width of a letter in sizes; letters as wide as what stands beside a label
_INCH = 0.0254  # m
_SMALLEST, _LARGEST = 1.0, 100.0  # inches of a side of a picture
_SIZE = re.compile(r"(?P<width>[\d.]+)\s*(?P<of_width>[a-zµ]*)\s*[x×]\s*(?P<height>[\d.]+)\s*(?P<unit>[a-zµ]+)")
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
        """Draw, texts as they are, in lines that fit: where they are is known once the axes are laid out."""
        show_verbatim(self)
        texts = [*self.texts, *(text for ax in self.axes for text in (ax.title, ax.xaxis.label, ax.yaxis.label))]
        for wraps in (False, True):
            for text in texts:
                text.set_wrap(wraps and "$" not in text.get_text())  # matplotlib measures formulas, which it may not
            if (engine := self.get_layout_engine()) is not None:
                engine.execute(self)
        super().draw(renderer)

    def _repr_png_(self) -> bytes:
        picture = BytesIO()
        self.savefig(picture, format="png", dpi=_NOTEBOOK_DPI)
        return picture.getvalue()


# --- texts ------------------------------------------------------------------------------------------------------------


def wrapped(text: str, width: int) -> str:
    """Text in lines of about `width` letters; a value stays with its name, and so does what is in brackets."""
    joined = re.sub(r"\([^)]*\)|[^\s,=][^,=]* = [^,]+", lambda part: part[0].replace(" ", _FIRM_SPACE), text)
    return "\n".join(fill(line, width) for line in joined.splitlines()).replace(_FIRM_SPACE, " ")


def annotate(figure: PlainFigure, notes: Sequence[str | None]) -> None:
    """Lines in small print below a plot without a legend there."""
    if note := "\n".join(filter(None, notes)):
        figure.supxlabel(note, fontsize="x-small", color=_NOTE_COLOUR)


def fixed_values(ds: xr.Dataset) -> list[tuple[str, str]]:
    """Quantities that are equal in all cells and matter, with their values as people write them.

    Those at their default are left out (no damper, a start at rest).
    """
    rows = []
    for name, coordinate in ds.coords.items():
        declared = QUANTITIES.get(str(name))
        if declared is None or coordinate.dims or not np.isfinite(value := float(coordinate)):
            continue
        if name == "ageing_time" and "ageing_rate" in ds.coords and not ds["ageing_rate"].values.any():
            continue  # says nothing
        if value != declared.default or name == "damping":  # none decides everything
            unit = unit_of(coordinate)
            rows.append((short_name(coordinate), f"{unit.of(value):.4g} {unit.printed}".rstrip()))
    return rows


def fixed_note(ds: xr.Dataset, first: Sequence[str] = ()) -> list[str]:
    """The note below a plot of what is held fixed, a line or none. first : what is chosen for this plot."""
    fixed = [*first, *(f"{name} = {value}" for name, value in fixed_values(ds))]
    return [f"held fixed: {', '.join(fixed)}"] if fixed else []


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
    letters = 72 * figure.get_figwidth() / _LETTER
    room = int(letters / size) - _HANDLE
    firsts = [handle if hasattr(handle, "get_label") else handle[0] for handle in handles]
    labels = [wrapped(str(first.get_label()), room) for first in firsts]
    longest = max(map(len, "\n".join(labels).splitlines()))
    columns = max(1, min(_MOST_COLUMNS, len(labels), (room + _HANDLE) // (longest + _HANDLE)))
    drawn = figure.legend(handles, labels, loc="outside lower center", ncols=columns, frameon=False, fontsize=size,
                          handler_map={tuple: HandlerTuple(ndivide=None, pad=0.0)})  # fmt: skip
    if note := "\n".join(filter(None, notes)):
        drawn.set_title(wrapped(note, int(letters / _SMALL_SIZE)))
        drawn.get_title().set(fontsize=_SMALL_SIZE, color=_NOTE_COLOUR, multialignment="center")


# --- title, size and fit ----------------------------------------------------------------------------------------------


def entitle(figure: PlainFigure, top: Axes, title: str, *, above_all: bool = False) -> None:
    """The title, over the axes it belongs to, or over the whole figure."""
    (figure.suptitle if above_all else top.set_title)(title, fontsize="large")


def resize(figure: PlainFigure, width: float, height: float) -> None:
    """Give a figure another size, in inches. Letters keep theirs; lines of titles, notes and labels fit the width."""
    figure.set_size_inches(width, height)
    if isinstance(figure, Figure) and figure.legends:
        legend(figure, *figure.entries)


def inches(text: str, dpi: float) -> tuple[float, float]:
    """`16 cm x 9 cm` or `1920 px x 1080 px` as width and height; a width without a unit has that of the height."""
    example = "such as '16 cm x 9 cm' or '1920 px x 1080 px'"
    sides = _SIZE.fullmatch(text.strip())
    try:
        if sides is None:
            raise QuantityError("two lengths")
        width, height = (
            float(number) / dpi if unit == "px" else units.si_value(f"{number} {unit}", "m") / _INCH
            for number, unit in ((sides["width"], sides["of_width"] or sides["unit"]), (sides["height"], sides["unit"]))
        )
    except QuantityError:
        raise PlotError(f"--size: got {text!r}, expected a width and a height {example}") from None
    if not (_SMALLEST <= width <= _LARGEST and _SMALLEST <= height <= _LARGEST):
        raise PlotError(f"--size: got {text!r}, expected sides between 2.54 cm and 2.54 m, {example}")
    return width, height


def save(figure: PlainFigure, path: str | os.PathLike[str], dpi: float = DPI, size: str | None = None) -> None:
    """Write a plot; its format is that of the name (.png, .svg, .pdf). Raises PlotError.

    size : as text, "16 cm x 9 cm" or "1920 px x 1080 px"; None for its own.
    """
    if size is not None:
        resize(figure, *inches(size, dpi))
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
