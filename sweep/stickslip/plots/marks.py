"""What may be asked of a map and is drawn over it: scales, limits, operating points, borders of theory, exact ones.

Wishes come as Python values in SI or as texts with units (`Look.of`); they are checked against the dataset.
"""

from __future__ import annotations

import math
import re
from collections.abc import Hashable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from itertools import compress
from pathlib import Path
from string import ascii_uppercase
from typing import Any, Literal

import matplotlib.patheffects as patheffects
import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.lines import Line2D
from numpy.typing import NDArray

from stickslip.config.grid import quantity_of, shared_by
from stickslip.dataset import coarse
from stickslip.dataset.coarse import Pixel
from stickslip.dataset.display import MapAxis, border_lines, other_cells
from stickslip.dataset.selection import places, span, within
from stickslip.engine import Options, Scales, by_theory
from stickslip.errors import ConfigError, PlotError, QuantityError
from stickslip.files import tables
from stickslip.theory.curve import SHAPES, damping_ratio, weakening
from stickslip.vocabulary import units
from stickslip.vocabulary.cells import as_cells, parameters_of
from stickslip.vocabulary.models import STRIBECK, model_of
from stickslip.vocabulary.quantities import QUANTITIES, or_meant

Floats = NDArray[np.float64]
_LABELS = ("label", "name", "point")  # headings of the column of a table that names operating points
_HEADING = re.compile(r"(?P<name>[^\[(]+?)\s*(?:[\[(]\s*(?P<unit>[^\])]*?)\s*[\])])?\s*")
_POINTS = 129  # along an axis, of linear theory
_RING: dict[str, Any] = {"marker": "o", "markersize": 8, "markerfacecolor": "white", "markeredgecolor": "black",
                         "markeredgewidth": 1.6, "linestyle": "none", "clip_on": False}  # fmt: skip
LINE: dict[str, Any] = {"color": "black", "linestyle": "dashdot", "linewidth": 1.2}
_HALO = [patheffects.Stroke(linewidth=3.0, foreground="white"), patheffects.Normal()]
_MOST_LABELS, _SHORT = 3, 4  # marks in a map whose labels may be long; letters of a short one
_MIDDLE = 0.7  # of the width of the axes: beyond it a label stands at the left of its mark


@dataclass(frozen=True)
class Mark:
    """An operating point: its label, and its place by dimension, values in SI or labels."""

    label: str
    at: Mapping[str, Any]


@dataclass(frozen=True)
class Look:
    """The appearance of a map.

    log : dimensions whose axis, and variables whose colours, are logarithmic in any case.
    limits : ends in SI, of the axis of a dimension or of the colours of a variable.
    marks : operating points to draw.
    """

    log: frozenset[str] = frozenset()
    limits: Mapping[str, tuple[float, float]] = field(default_factory=dict)
    marks: tuple[Mark, ...] = ()

    @classmethod
    def of(
        cls, ds: xr.Dataset, *, log: Iterable[str] = (), limits: Iterable[str] = (), marks: Iterable[str] = ()
    ) -> Look:
        """A look from texts, as on the command line. Raises PlotError for what `ds` cannot have.

        log : names. limits : ``period=0.1..2 s``. marks : ``stiffness=5 N/mm, belt_speed=20 mm/s``, a label in front
        if need be: ``pump A: stiffness=...``. Each text may hold several names, with commas between.
        """
        names = [name.strip() for text in log for name in text.split(",") if name.strip()]
        for name in names:
            _known(ds, name)
        ends = {name: _ends(ds, name, end) for text in limits for name, end in pairs(text, "LOW..HIGH with a unit")}
        points = tuple(_mark(ds, number, text) for number, text in enumerate(marks))
        return cls(frozenset(names), ends, points)

    def part(self, ds: xr.Dataset) -> xr.Dataset:
        """The part of a dataset, its axes rising, that lies within the limits of its dimensions."""
        for name, (low, high) in self.limits.items():
            if name in ds.dims:
                ds = within(ds, name, low, high)
        return ds

    def within_limits(self) -> Look:
        """The same look with those marks only that lie within the limits."""
        ends = self.limits.items()
        inside = (all(low <= mark.at[name] <= high for name, (low, high) in ends if name in mark.at)
                  for mark in self.marks)  # fmt: skip
        return replace(self, marks=tuple(compress(self.marks, inside)))


PLAIN = Look()


def pairs(text: str, value: str) -> Iterator[tuple[str, str]]:
    """``name=value, name=value`` as pairs; `value` says what to write. Raises PlotError."""
    for part in text.split(","):
        name, equals, content = part.partition("=")
        if not (equals and name.strip() and content.strip()):
            raise PlotError(f"got {part.strip()!r}, expected NAME={value}")
        yield name.strip(), content.strip()


def _known(ds: xr.Dataset, name: str) -> xr.DataArray:
    """The variable or dimension called `name`: something with numbers that is drawn along an axis or in colours."""
    if name not in ds.data_vars and name not in ds.dims:
        raise PlotError(f"no {name!r} in this result; axes are {_listed(ds.dims)}; "
                        f"variables are {_listed(ds.data_vars)}")  # fmt: skip
    if name not in ds.variables or ds[name].dtype.kind not in "fiu":
        raise PlotError(f"{name} has labels, no numbers: it has no scale and no limits")
    return ds[name]


def _listed(names: Iterable[Any]) -> str:
    return ", ".join(map(str, names))


def _ends(ds: xr.Dataset, name: str, text: str) -> tuple[float, float]:
    """`0.1..2 s` as two numbers in SI; the unit of the upper end holds for a lower one without."""
    si = str(_known(ds, name).attrs.get("units", "1"))
    try:
        ends = units.ends_of(f"--limits {name}", text)
    except ValueError as error:
        raise PlotError(str(error)) from None
    low, high = (_number(f"--limits {name}", str(end), si) for end in ends)
    if not low < high:
        raise PlotError(f"--limits {name}={text}: expected the lower end first")
    return low, high


def _number(option: str, text: str, si: str) -> float:
    try:
        number = float(text)
    except ValueError:
        try:
            number = units.si_value(text, si)
        except QuantityError as error:
            hint = f"\nhint: {error.hint}" if error.hint else ""
            raise PlotError(f"{option}: got {text!r}, {error}{hint}") from None
    if not math.isfinite(number):
        raise PlotError(f"{option}: got {text!r}, expected a finite number")
    return number


def _mark(ds: xr.Dataset, number: int, text: str) -> Mark:
    """An operating point; without a label of its own it is A, B, C, ..."""
    label, colon, places = text.partition(":")
    if not colon or "=" in label:
        label, places = ascii_uppercase[number % len(ascii_uppercase)], text
    return Mark(label.strip(), _places(ds, pairs(places, "VALUE")))


def marks_in(ds: xr.Dataset, path: Path) -> Iterator[Mark]:
    """Operating points from a table: a column of labels, and one for each axis, with its unit in the heading.

    Raises PlotError, which names file and line; ConfigError where the file is no table.
    """
    table = tables.read_table(path, f"label, {', '.join(map(str, ds.dims))}", "operating points")
    names = [_HEADING.fullmatch(cell.text) for cell in table.heading]
    line = table.heading[0].place.line
    try:
        if not all(names):
            raise PlotError("a column without a name, or a heading that is none such as 'belt_speed [mm/s]'")
        heads = [(head["name"].strip().lower().replace(" ", "_"), head["unit"] or "") for head in names if head]
        if (label := next((i for i, (name, _) in enumerate(heads) if name in _LABELS), None)) is None:
            raise PlotError(f"no column of labels, expected one called {' or '.join(_LABELS)}")
        rows = [*tables.cells(table)]
        texts = [[cell.text for cell in row] for row in rows]
        comma = tables.has_decimal_commas(table, texts, [i for i, (name, _) in enumerate(heads) if i != label])
        for row in rows:
            line = row[0].place.line
            if len(row) != len(heads):
                raise PlotError(f"got {len(row)} values, expected {len(heads)}")
            values = [
                (name, f"{cell.text.replace(',', '.') if comma and _is_number(ds, name) else cell.text} {unit}".strip())
                for i, ((name, unit), cell) in enumerate(zip(heads, row, strict=True))
                if i != label
            ]
            yield Mark(row[label].text, _places(ds, values))
    except PlotError as error:
        raise PlotError(f"{path}:{line}: {str(error).removeprefix('--mark').lstrip(': ')}") from None


def _places(ds: xr.Dataset, values: Iterable[tuple[str, str]]) -> dict[str, Any]:
    """The place of a mark along each axis that is named."""
    at: dict[str, Any] = {}
    for name, value in values:
        if name not in ds.dims:
            known = f"axes are {_listed(ds.dims)}{or_meant(name, map(str, ds.dims))}"
            raise PlotError(f"--mark: {name!r} is no axis of this map; {known}")
        at[name] = _place(ds, name, value)
    return at


def _is_number(ds: xr.Dataset, name: str) -> bool:
    return name in ds.variables and ds[name].dtype.kind in "fiu"


def _place(ds: xr.Dataset, name: str, value: str) -> Any:
    """A value along an axis, in SI, or a label; refused beyond the axis."""
    if not _is_number(ds, name):
        labels = [*map(str, ds[name].values if name in ds.variables else range(ds.sizes[name]))]
        if value not in labels:
            raise PlotError(f"--mark {name}={value}: expected one of {', '.join(labels)}")
        return value
    number = _number(f"--mark {name}", value, str(ds[name].attrs.get("units", "1")))
    low, high, words = span(ds, name)
    if not low <= number <= high:
        raise PlotError(f"--mark {name}={value}: outside of the map; the axis {words}")
    return number


# --- operating points, drawn ------------------------------------------------------------------------------------------


def check(marks: Iterable[Mark], dims: Iterable[Any], needed: Iterable[Any]) -> None:
    """Raise PlotError for an operating point that does not say where it is along an axis that is drawn."""
    for mark in marks:
        if missing := [str(dim) for dim in needed if dim not in mark.at]:
            raise PlotError(f"--mark {mark.label}: where along {', '.join(missing)}?")
        if other := [name for name in mark.at if name not in set(map(str, dims))]:
            raise PlotError(f"--mark {mark.label}: {', '.join(other)} is fixed in this picture")


def draw(
    ax: Axes, ds: xr.Dataset, panel: Mapping[Hashable, int], marks: Sequence[Mark], x: MapAxis, y: MapAxis
) -> None:
    """Draw those marks that lie in a panel into its axes. panel : positions along the dimensions fixed in it."""
    for mark, key in zip(marks, _keys(marks), strict=True):
        at = places(ds, {str(dim): mark.at[str(dim)] for dim in panel if str(dim) in mark.at})
        if all(panel[dim] == i for dim, i in at.items()):
            place = position(x, mark.at[str(x.dim)]), position(y, mark.at[str(y.dim)])
            ax.plot(*place, zorder=5, **_RING)
            _label(ax, key, place)


def _keys(marks: Sequence[Mark]) -> list[str]:
    """The text beside each mark: its label; its number where many have long ones, which then are in the legend."""
    many = len(marks) > _MOST_LABELS and max(len(mark.label) for mark in marks) > _SHORT
    return [str(i) if many else mark.label for i, mark in enumerate(marks, 1)]


def _label(ax: Axes, label: str, place: tuple[float, float]) -> None:
    """The label, at the right of its mark, or at the left where it is near the right edge."""
    at_left = ax.transAxes.inverted().transform(ax.transData.transform(place))[0] > _MIDDLE
    words = ax.annotate(label, place, xytext=(-8 if at_left else 8, 0), textcoords="offset points", va="center",
                        ha="right" if at_left else "left", fontweight="bold", zorder=5)  # fmt: skip
    words.set(path_effects=_HALO, in_layout=False)  # the map keeps its width


def position(axis: MapAxis, value: Any) -> float:
    """The place of a value in SI, or of a label, along an axis."""
    if axis.is_numeric:
        return float(axis.unit.of(value))
    return float(next(i for i in range(axis.length) if str(value) in (axis.text(i), str(i))))


def entries(marks: Sequence[Mark], ds: xr.Dataset, line: bool = False) -> list[Line2D]:
    """Legend entries: what each label stands for.

    line : the marks are lines, over a single axis.
    """
    lines = []
    for mark, key in zip(marks, _keys(marks), strict=True):
        axes = {name: MapAxis(ds, name) for name in mark.at}
        text = ", ".join(_place_text(ds, name, axis, mark.at[name]) for name, axis in axes.items())
        text = f"{key}: {text if key == mark.label else mark.label}"
        lines.append(Line2D([], [], label=text, **(LINE if line else _RING | {"markersize": 6})))
    return lines


def _place_text(ds: xr.Dataset, name: str, axis: MapAxis, value: Any) -> str:
    if not axis.is_numeric:
        return str(value)
    return f"{axis.unit.of(value):.4g} {axis.unit.printed}".rstrip() if axis.unit.name else f"{name} = {value:.4g}"


# --- borders ----------------------------------------------------------------------------------------------------------


BORDERS: dict[float, tuple[Literal["solid", "dashed"], str]] = {
    0.0: ("solid", "damping ratio 0 (linear)"),
    1.0: ("dashed", "damping ratio 1 (linear)"),
}
_PALE_HALO = [patheffects.Stroke(linewidth=3.0, foreground="white", alpha=0.8), patheffects.Normal()]


def draw_borders(ax: Axes, panel: xr.Dataset, x: MapAxis, y: MapAxis, pixel: Pixel) -> set[float]:
    """Contours of the linear damping ratio; returns the levels that lie inside the panel.

    Of a law that has a formula, through points of their own, however few cells the map has; else through the values at
    single cells, so that pixels do not blur or shift them; none then of a refined map, most cells of which have none.
    """
    if not (x.is_numeric and y.is_numeric) or min(x.length, y.length) < 2:
        return set()
    if (known := by_formula(panel, x, y)) is not None:
        *points, ratio = known
    elif "damping_ratio" not in panel.data_vars or "refine_box" in panel.attrs:
        return set()
    else:
        ratio = coarse.centres(panel["damping_ratio"].transpose(y.dim, x.dim), pixel)
        points = [x.pixel_points(pixel[1]), y.pixel_points(pixel[0])]
    ratio = np.ma.masked_invalid(ratio)
    inside = levels_inside(ratio)
    for level in inside:
        lines = ax.contour(*points, ratio, levels=[level], colors="black", linewidths=1.2,
                           linestyles=[BORDERS[level][0]])  # fmt: skip
        lines.set_path_effects(_PALE_HALO)
    return inside


def by_formula(panel: xr.Dataset, x: MapAxis, y: MapAxis) -> tuple[Floats, Floats, Floats] | None:
    """Points along x and along y, in the units in which they are shown, and the linear damping ratio (y, x) there; None
    where it is known from cells alone, or the dataset says too little."""
    coords = {name: array for key, array in panel.coords.items() if (name := quantity_of(str(key))) in QUANTITIES}
    try:
        law = str(shared_by(panel)["law"])
        is_known = law in SHAPES or model_of(law).growth
    except (ConfigError, KeyError):
        return None
    if not is_known or any(set(array.dims) - {x.dim, y.dim} for array in coords.values()):
        return None
    try:
        values = {}
        for key, array in coords.items():
            along = _between(x if array.dims == (x.dim,) else y, array.values) if array.dims else array.values
            values[key] = np.broadcast_to(along[:, None] if array.dims == (y.dim,) else along, (_POINTS,) * 2).ravel()
        cells = as_cells(parameters_of(values), law)
    except (TypeError, ValueError):  # not all that a cell has is among the coordinates
        return None
    if law in SHAPES:
        by, (_, slope, drop, decay), speed = Scales(cells), STRIBECK.curve_of(cells), np.abs(cells["belt_speed"])
        slope = slope + drop / decay * weakening(law, speed / decay, cells.get("delta", 1.0))[1]
        ratio = damping_ratio(slope, by.mass, by.stiffness, cells["damping"], by.load)
        ratio = np.where(speed > 0, ratio, np.nan)
    else:
        ratio = by_theory("damping_ratio", cells, Options(law))
    return _between(x, x.centres), _between(y, y.centres), ratio.reshape(_POINTS, _POINTS)


def _between(axis: MapAxis, values: Floats) -> Floats:
    """Values at the points of an axis, at `_POINTS`: by ratio where the axis is."""
    at, own = np.linspace(0.0, axis.length - 1.0, _POINTS), np.arange(axis.length)
    if axis.is_log and (values > 0).all():
        return np.exp(np.interp(at, own, np.log(values)))
    return np.interp(at, own, values)


def levels_inside(ratio: NDArray[np.float64]) -> set[float]:
    """The borders between the smallest and the largest damping ratio."""
    finite = np.ma.masked_invalid(ratio).compressed()
    return {level for level in BORDERS if finite.size and finite.min() < level < finite.max()}


def border_handles(levels: set[float]) -> list[Line2D]:
    """Legend entries of the borders."""
    return [
        Line2D([], [], color="black", linewidth=1.2, linestyle=BORDERS[level][0], label=BORDERS[level][1])
        for level in sorted(levels)
    ]


def over_panel(ax: Axes, panel: xr.Dataset, lines: xr.Dataset, x: MapAxis, y: MapAxis, *, small: bool = False) -> None:
    """Draw the borders that a dataset holds for one panel of a map, labelled. Raises PlotError.

    White with a black edge: it reads on every colour of a map, in grey too, and is no line of theory.
    small : the panel is one of several.
    """
    at = {name: coordinate.values[()] for name, coordinate in panel.coords.items() if not coordinate.dims}
    if why := other_cells(lines, at):
        raise PlotError(f"the borders are those of other cells: {why}")
    inner, outer = (0.9, 2.1) if small else (1.6, 3.2)
    casing = [patheffects.Stroke(linewidth=outer, foreground="black"), patheffects.Normal()]
    for line in border_lines(lines, x, y, at):
        dot: dict[str, Any] = {"marker": "o", "markersize": 3.0} if len(line.x) == 1 else {}
        ax.plot(x.unit.of(line.x), y.unit.of(line.y), color="white", linewidth=inner, solid_capstyle="round",
                solid_joinstyle="round", path_effects=casing, zorder=3, label="border, exact", **dot)  # fmt: skip
