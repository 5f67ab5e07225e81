"""A test matrix as a heat map, like the table of a printed test report: one cell for each test, its number in it.

Leading dimensions run down the rows, the others along the columns, the last of each fastest; the labels are nested.
Sizes are in inches, and the figure is as large as its cells and labels need.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import lru_cache
from itertools import accumulate
from math import ceil, log, prod
from textwrap import fill, shorten
from typing import Any, Literal

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.cm import ScalarMappable
from matplotlib.colors import BoundaryNorm, Colormap, ListedColormap, Normalize
from matplotlib.patches import Patch
from matplotlib.textpath import TextPath
from numpy.typing import NDArray

from stickslip.errors import PlotError, visible
from stickslip.plots.layout import Figure
from stickslip.plots.palette import FLAG_COLOURS, UNDEFINED_COLOUR, paint
from stickslip.rig.quantities import EXACT, FEATURES
from stickslip.rig.report.traces import LIGHTS
from stickslip.rig.risk import BANDS, RPN_NAME, UNDEFINED, number_text
from stickslip.rig.words import Along, along, number, unit_for

RPN = "model_rpn"
BAND = "model_rpn_band"
MEANINGS = {  # the article's, page 4
    "green": "low noise, no stick-slip",
    "yellow": "noise and stick-slip can occur",
    "red": "bad noise and stick-slip",
}

_POINT = 1 / 72
_CELL = (0.46, 0.29)  # width and height of a cell where there is room
_LARGEST = (10.0, 10.5)  # of all cells together
_ASPECT = 0.8  # width over height of all cells that fits a page
_FONT, _SMALLEST_NUMBER = 8.5, 4.0  # points
_BOLD = 1.15  # times the width of plain letters
_LONGEST_LABEL = 30  # letters
_GAP, _MARGIN = 0.1, 0.12


def plot_matrix(ds: xr.Dataset, variable: str = RPN) -> Figure:
    """One number of every test of a matrix (`run_matrix`) of any number of dimensions.

    The model RPN, and its band, in the colours of the traffic light, "?" where it is not known; how the integration
    ended in the colours of maps; everything else from dark to light with a colour bar. Numbers are left out where cells
    are too small for them. Raises PlotError.
    """
    array = _checked(ds, variable)
    rows, columns = _split([along(ds, dim) for dim in array.dims])
    cells = array.values.reshape(_size(rows), _size(columns))
    look = _lights(ds, cells.shape) if variable in (RPN, BAND) else _numbers(array, cells)
    page = _Page(_Side.of(rows), _Side.of(columns))
    figure, ax = page.figure(str(ds.attrs.get("title", "")), look.heading, legend=look.height)
    mesh = ax.pcolormesh(look.values, cmap=look.colours, norm=look.norm, edgecolors="white", linewidth=page.line)
    page.label(figure, ax)
    written = _write_numbers(ax, look.texts, mesh.to_rgba(look.values), page.cell)
    _explain(figure, ax, look, "" if written else "numbers are left out, the cells are too small")
    return figure


def _checked(ds: xr.Dataset, variable: str) -> xr.DataArray:
    known = [name for name in (*FEATURES, *EXACT, RPN, "model_rpn_level", BAND) if name in ds]
    if variable not in known:
        raise PlotError(f"no variable {variable!r} of a test matrix; there are {', '.join(known)}")
    if "peak" in ds[variable].dims:
        raise PlotError(f"{variable} has several values in each test\nhint: choose one, as ds.isel(peak=0)")
    if not ds[variable].size:
        raise PlotError("nothing to draw: the matrix has no tests")
    return ds[variable]


# --- what cells look like ---------------------------------------------------------------------------------------------


@dataclass(frozen=True)
class _Look:
    """The cells: values that `colours` and `norm` paint, what is written in them, and how that is explained.

    legend : entries for what the colours mean; none: a colour bar. height : of legend or colour bar.
    """

    heading: str
    values: NDArray[Any]
    colours: Colormap
    norm: Normalize
    texts: NDArray[np.str_]
    legend: Sequence[Patch] = ()
    unit: str = ""
    height: float = 0.75


def _lights(ds: xr.Dataset, shape: tuple[int, ...]) -> _Look:
    """The model RPN in its traffic-light colours."""
    bands = ("unknown", *BANDS)
    band = ds[BAND].values.reshape(shape)
    rpn = ds[RPN].values.reshape(shape)
    texts = np.array([number_text(n) for n in rpn.ravel().tolist()]).reshape(shape)
    shown = [*BANDS, *(["unknown"] if (band == UNDEFINED).any() else [])]
    legend = [Patch(facecolor=LIGHTS[name], edgecolor="white", label=_band_words(name)) for name in shown]
    norm = BoundaryNorm(np.arange(len(bands) + 1) - 0.5, len(bands))
    colours = ListedColormap([LIGHTS[name] for name in bands])
    return _Look(RPN_NAME, band, colours, norm, texts, legend, height=0.3 + 0.19 * len(legend))


def _band_words(name: str) -> str:
    """`4-5: noise and stick-slip can occur`."""
    if name not in BANDS:
        return "?: not known"
    low, high = BANDS[name]
    return f"{low}–{high}: {MEANINGS[name]}"


def _numbers(array: xr.DataArray, cells: NDArray[Any]) -> _Look:
    """A feature, or how the integration ended."""
    name, said = str(array.name), str(array.attrs.get("long_name", array.name))
    if name in FLAG_COLOURS:
        painted = paint(name, cells)
        legend = [entry for entry in painted.handles() if isinstance(entry, Patch)]
        blank = np.full(cells.shape, "")
        return _Look(said, cells, painted.colours, painted.norm, blank, legend, height=0.15 + 0.19 * len(legend))
    unit, factor = unit_for(str(array.attrs.get("units", "1")), cells)
    values = cells.astype(np.float64) * factor
    painted = paint(name, values)
    colours = painted.colours.with_extremes(bad=UNDEFINED_COLOUR)
    texts = np.vectorize(number, otypes=[str])(values)
    return _Look(said, np.ma.masked_invalid(values), colours, painted.norm, texts, unit=unit)


def _write_numbers(ax: Axes, texts: NDArray[np.str_], colours: NDArray[Any], cell: tuple[float, float]) -> bool:
    """Every text in its cell, black or white, whichever is easier to read; False if they would be too small."""
    widest = max((_width(str(text), 1.0) for text in np.unique(texts)), default=0.0)
    if widest == 0.0:
        return True
    size = min(_FONT, 0.62 * cell[1] / _POINT, 0.76 * cell[0] / widest)
    if size < _SMALLEST_NUMBER:
        return False
    for (i, j), text in np.ndenumerate(texts):
        ink = "black" if _luminance(colours[i, j]) > 0.18 else "white"  # where both have the same contrast
        ax.text(j + 0.5, i + 0.5, text, ha="center", va="center", color=ink, fontsize=size)
    return True


def _luminance(colour: NDArray[np.float64]) -> float:
    """Relative luminance as the web defines it, 0 to 1."""
    linear = np.where(colour[:3] <= 0.04045, colour[:3] / 12.92, ((colour[:3] + 0.055) / 1.055) ** 2.4)
    return float(linear @ (0.2126, 0.7152, 0.0722))


def _explain(figure: Figure, ax: Axes, look: _Look, note: str) -> None:
    """The legend or the colour bar below the cells, and a note."""
    width, height = figure.get_size_inches()
    if look.legend:
        title = RPN_NAME if look.heading == RPN_NAME else None
        place: dict[str, Any] = {"loc": "lower center", "bbox_to_anchor": (0.5, _MARGIN / height)}
        legend = figure.legend(handles=list(look.legend), title=title, frameon=False, fontsize=_FONT, **place)
        legend.set_title(title, prop={"size": _FONT, "weight": "bold"})  # type: ignore[arg-type]
    else:
        long = min(width - 4 * _MARGIN, 4.0)
        bar_ax = figure.add_axes(((width - long) / 2 / width, 0.52 / height, long / width, 0.12 / height))
        bar = figure.colorbar(ScalarMappable(look.norm, look.colours), cax=bar_ax, orientation="horizontal")
        bar.ax.tick_params(labelsize=_FONT - 1)
        bar.set_label(f"{look.heading} ({look.unit})" if look.unit else look.heading, fontsize=_FONT)
    if note:
        ax.text(0.5, -_GAP / (ax.get_position().height * height), note, transform=ax.transAxes, ha="center", va="top",
                fontsize="x-small", color="#555555")  # fmt: skip


# --- where dimensions go ----------------------------------------------------------------------------------------------


def _split(dims: Sequence[Along]) -> tuple[list[Along], list[Along]]:
    """Dimensions of the rows and of the columns: a page's shape, both of them used from two dimensions on."""
    if len(dims) < 2:
        return (list(dims), []) if dims and dims[0].is_text else ([], list(dims))

    def misfit(rows: int) -> float:
        width, height = _CELL[0] * _size(dims[rows:]), _CELL[1] * _size(dims[:rows])
        return abs(log(width / height / _ASPECT))

    best = min(range(1, len(dims)), key=misfit)
    return list(dims[:best]), list(dims[best:])


def _size(dims: Sequence[Along]) -> int:
    return prod(len(d.points) for d in dims)


@dataclass(frozen=True)
class _Level:
    """The labels of one dimension along a side. span : cells that a label stands for. repeats : of all labels."""

    title: str
    labels: tuple[str, ...]
    span: int
    repeats: int

    @property
    def width(self) -> float:
        """Of the widest label."""
        return max(_width(label, _FONT) for label in self.labels)

    def places(self) -> list[tuple[float, str]]:
        """The middle of each group of cells, and its label."""
        total = len(self.labels) * self.repeats
        return [((i + 0.5) * self.span, self.labels[i % len(self.labels)]) for i in range(total)]


@dataclass(frozen=True)
class _Side:
    """The levels of labels along the rows or along the columns, outermost first, and the number of cells."""

    levels: tuple[_Level, ...]
    size: int

    @staticmethod
    def of(dims: Sequence[Along]) -> _Side:
        """The side that these dimensions run along."""
        lengths = [len(d.points) for d in dims]
        before = [1, *accumulate(lengths, lambda a, b: a * b)]
        size = before[-1]
        return _Side(
            tuple(
                _Level(_short(d.title), tuple(map(_short, d.points)), size // after, repeats)
                for d, repeats, after in zip(dims, before, before[1:], strict=False)
            ),
            size,
        )

    def group_ends(self) -> list[int]:
        """Where groups of the dimensions but the last end."""
        span = self.levels[-2].span if len(self.levels) > 1 else self.size
        return list(range(span, self.size, span))


@dataclass(frozen=True)
class _Page:
    """Where everything stands."""

    rows: _Side
    columns: _Side

    @property
    def cell(self) -> tuple[float, float]:
        """Width and height of a cell."""
        return (min(_CELL[0], _LARGEST[0] / self.columns.size), min(_CELL[1], _LARGEST[1] / self.rows.size))

    @property
    def line(self) -> float:
        """Width of the lines between cells, in points."""
        return min(1.0, 0.04 * min(self.cell) / _POINT)

    @property
    def left(self) -> float:
        """Room for the labels of the rows, and for the names of the columns."""
        names = max((_width(level.title, _FONT * _BOLD) for level in self.columns.levels), default=0.0)
        return _MARGIN + max(sum(self._widths()), names + _GAP)

    def _widths(self) -> list[float]:
        """Of each level of row labels, outermost first, the gap to the next included."""
        return [max(level.width, _width(level.title, _FONT * _BOLD)) + _GAP for level in self.rows.levels]

    def _heights(self) -> list[float]:
        """Of each level of column labels, outermost first."""
        return [(level.width if self._upright(level) else _FONT * _POINT) + _GAP for level in self.columns.levels]

    def _upright(self, level: _Level) -> bool:
        """Whether column labels are too wide for their groups, and are turned."""
        return level.width > level.span * self.cell[0] - 0.5 * _GAP

    def figure(self, title: str, heading: str, legend: float) -> tuple[Figure, Axes]:
        """An empty figure of the right size, and the axes of the cells."""
        across, down = self.cell[0] * self.columns.size, self.cell[1] * self.rows.size
        width = max(self.left + across + 2 * _MARGIN, 3.8)
        titles = [fill(title, max(int(width / 0.085), 20)), fill(heading, max(int(width / 0.068), 20))]
        above = sum(0.2 * (text.count("\n") + 1) for text in titles if text) + 2 * _MARGIN
        top = above + sum(self._heights())
        below = legend + (0.32 if self.rows.levels else 0.22) + _MARGIN
        height = top + down + below
        figure = Figure(figsize=(width, height))
        figure.text(0.5, 1 - _MARGIN / height, titles[0], ha="center", va="top", fontsize=11, weight="bold")
        figure.text(0.5, 1 - (above - _MARGIN) / height, titles[1], ha="center", va="bottom", fontsize=9)
        left = max(self.left, (width - across) / 2 if not self.rows.levels else 0.0)
        ax = figure.add_axes((left / width, below / height, across / width, down / height))
        return figure, ax

    def label(self, figure: Figure, ax: Axes) -> None:
        """Labels and names of all dimensions, and lines between groups."""
        ax.set(xlim=(0, self.columns.size), ylim=(self.rows.size, 0), xticks=[], yticks=[])
        ax.spines[:].set_visible(False)
        for end in self.columns.group_ends():
            ax.axvline(end, color="white", linewidth=3.5 * self.line)
        for end in self.rows.group_ends():
            ax.axhline(end, color="white", linewidth=3.5 * self.line)
        self._label_rows(ax)
        self._label_columns(ax)

    def _label_rows(self, ax: Axes) -> None:
        inch = self.columns.size / (self.cell[0] * self.columns.size)  # in units of the axis
        at = -_GAP
        for level, width in zip(reversed(self.rows.levels), reversed(self._widths()), strict=True):
            for y, label in _thinned(level, self.cell[1]):
                self._text(ax, at * inch, y, label, "right", "center")
            below = self.rows.size + 0.12 / self.cell[1]
            self._text(ax, at * inch, below, level.title, "right", "top", weight="bold")
            at -= width

    def _label_columns(self, ax: Axes) -> None:
        at = -0.5 * _GAP
        for level, height in zip(reversed(self.columns.levels), reversed(self._heights()), strict=True):
            upright = self._upright(level)
            for x, label in _thinned(level, self.cell[0]) if upright else level.places():
                self._text(ax, x, at / self.cell[1], label, "center", "bottom", rotation=90 if upright else 0)
            self._text(ax, -_GAP / self.cell[0], at / self.cell[1], level.title, "right", "bottom", weight="bold")
            at -= height

    def _text(
        self, ax: Axes, x: float, y: float, text: str, ha: Literal["right", "center"], va: str, **looks: Any
    ) -> None:
        ax.text(x, y, text, ha=ha, va=va, fontsize=_FONT, clip_on=False, **looks)


def _thinned(level: _Level, cell: float) -> list[tuple[float, str]]:
    """Labels that stand one below the other, as many as there is room for."""
    step = ceil(1.15 * _FONT * _POINT / (level.span * cell))
    return level.places()[::step]


def _short(text: str) -> str:
    """A label of one line."""
    return shorten(text, _LONGEST_LABEL, placeholder=" …") if " " in text else _cut(text)


def _cut(text: str) -> str:
    return text if len(text) <= _LONGEST_LABEL else text[: _LONGEST_LABEL - 1] + "…"


@lru_cache(maxsize=4096)
def _width(text: str, size: float) -> float:
    """Width of a text in inches."""
    return (
        float(TextPath((0.0, 0.0), visible(text).replace("$", "S"), size=size).get_extents().width) * _POINT
        if text
        else 0.0
    )
