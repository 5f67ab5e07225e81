"""Options of maps: scales, limits, operating points, hatching.

Wishes come as Python values in SI or as texts with units (`Look.of`); they are checked against the dataset.
"""

from __future__ import annotations

import math
import re
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass, field, replace
from itertools import compress
from pathlib import Path
from string import ascii_uppercase
from typing import Any

import xarray as xr

from stickslip.dataset.selection import span, unit_suggestion, within
from stickslip.errors import PlotError, QuantityError
from stickslip.files import tables
from stickslip.vocabulary import units
from stickslip.vocabulary.quantities import or_meant

_LABELS = ("label", "name", "point")  # headings of the column of a table that names operating points
_INCH = 0.0254  # m
_SMALLEST, _LARGEST = 1.0, 100.0  # inches of a side of a picture
_SIZE = re.compile(r"(?P<width>[\d.]+)\s*(?P<of_width>[a-zµ]*)\s*[x×]\s*(?P<height>[\d.]+)\s*(?P<unit>[a-zµ]+)")
_HEADING = re.compile(r"(?P<name>[^\[(]+?)\s*(?:[\[(]\s*(?P<unit>[^\])]*?)\s*[\])])?\s*")


@dataclass(frozen=True)
class Mark:
    """An operating point: its label, its place by dimension, values in SI or labels, and its regime, where known."""

    label: str
    at: Mapping[str, Any]
    regime: str = ""


@dataclass(frozen=True)
class Look:
    """The appearance of a map.

    log : dimensions whose axis, and variables whose colours, are logarithmic in any case.
    limits : ends in SI, of the axis of a dimension or of the colours of a variable.
    marks : operating points to draw. hatched : whether regimes are hatched that are alike in grey.
    held : whether a note names the quantities that are held fixed.
    """

    log: frozenset[str] = frozenset()
    limits: Mapping[str, tuple[float, float]] = field(default_factory=dict)
    marks: tuple[Mark, ...] = ()
    hatched: bool = True
    held: bool = True

    @classmethod
    def of(
        cls, ds: xr.Dataset, *, log: Iterable[str] = (), limits: Iterable[str] = (), marks: Iterable[str] = (),
        hatched: bool = True, held: bool = True,
    ) -> Look:  # fmt: skip
        """A look from texts, as on the command line. Raises PlotError for what `ds` cannot have.

        log : names. limits : ``period=0.1..2 s``. marks : ``stiffness=5 N/mm, belt_speed=20 mm/s``, a label in front
        if need be: ``pump A: stiffness=...``. Each text may hold several names, with commas between.
        """
        names = [name.strip() for text in log for name in text.split(",") if name.strip()]
        for name in names:
            _known(ds, name)
        ends = {name: _ends(ds, name, end) for text in limits for name, end in pairs(text, "LOW..HIGH with a unit")}
        points = tuple(_mark(ds, number, text) for number, text in enumerate(marks))
        return cls(frozenset(names), ends, points, hatched, held)

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
        raise PlotError(f"--mark {name}={value}: outside of the map; the axis {words}"
                        f"{unit_suggestion(ds, name, value)}")  # fmt: skip
    return number
