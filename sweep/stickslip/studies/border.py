"""Borders of regimes: lines of cells, searched through the engine, and labelled."""

from __future__ import annotations

from collections.abc import Hashable, Iterator, Mapping, Sequence
from typing import Any

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from stickslip.config.sections import of_row
from stickslip.config.studies import Moved, Regime, ReportTable, search_attributes, search_settings, shown
from stickslip.dataset.build import grid_coordinates, of_parameter, shown_in, study_dataset
from stickslip.dataset.display import axis_names, parts_over, unit_of
from stickslip.engine import Options, Results, StopFlag, joined, solve
from stickslip.studies.lines import (
    CellsOrConfig,
    LineSection,
    OpenStudy,
    Side,
    decided,
    fine_enough,
    growth_of,
    guide_of,
    limits,
    opened,
    search_options,
)
from stickslip.studies.search import Floats, Integers, Looked, search_lines
from stickslip.vocabulary.cells import Cells, Parameters
from stickslip.vocabulary.models import model_of
from stickslip.vocabulary.parameter import Parameter, Variable, table
from stickslip.vocabulary.quantities import METHODS, REGIMES

_OPEN = -1  # in place of the regime throughout of a line that has borders, or no decided place
_LANES_FED = 8  # blocks of so many times more lines than their cells call for: a round of bisection has one cell a line

_EACH = ("crossing",)
_VARIABLES = table(
    Variable("border", "parameter", "where the regime changes", comment="the middle of the last bracket", dims=_EACH),
    Variable("regime_below", "1", "regime just below the border", dims=_EACH),
    Variable("regime_above", "1", "regime just above the border", dims=_EACH),
    Variable("border_width", "parameter", "width of the last bracket of the border", dims=_EACH),
    Variable("method", "1", "how the border was found", dims=_EACH),
    Variable("regime_throughout", "1", "regime all along a line without borders", comment="as far as the scan sees"),
    Variable("scan_undecided", "1", "cells of the scan that were unresolved or failed"),
)


class Border(LineSection):
    """Border of the regimes along a parameter; the other axes are the lines that are searched."""

    key = "border"
    rows = limits(
        key,
        "a border",
        Parameter("scan", "1", "places of each line that are looked at first", key,
                  default=64, at_least=2, at_most=10_000_000, whole=True),
    )  # fmt: skip
    tolerance: float = of_row(rows["tolerance"])  # None until `fine_enough`
    scan: int = of_row(rows["scan"])
    rtol: float | None = of_row(rows["rtol"])


class BorderStudy(OpenStudy):
    """The borders of lines; its items are the lines."""

    section, variables = Border, _VARIABLES
    title, subject, places, over_map = "Borders of regimes", "border", "lines", True
    about = "The other axes of CONFIG are the lines that are searched, but those that --at gives a value."
    examples = (
        "configs/quickstart.yaml --along belt_speed",
        'configs/quickstart.yaml --along belt_speed --at stiffness="5 N/mm"',
        'configs/quickstart.yaml --along belt_speed --between 1 "1.2 m/s" -o top.nc',
    )
    name, counted, ragged = "borders", "lines", True
    columns: Mapping[str, np.dtype[Any]] = {
        "found": np.dtype(np.int32), "undecided": np.dtype(np.int32), "throughout": np.dtype(np.int8),  # by line ...
        "low": np.dtype(np.float64), "high": np.dtype(np.float64),  # ... and the others by border
        "below": np.dtype(np.int8), "above": np.dtype(np.int8), "guided": np.dtype(np.int8),
        "place": np.dtype(np.float64),
    }  # fmt: skip

    def __init__(self, cells: Cells, side: Side, section: Border, options: Options) -> None:
        self._cells, self._side, self._section = cells, side, section
        self.dims, self.shape = cells.dims, cells.shape
        self.cells_each = section.scan + int(-np.log2(section.tolerance))
        self.weight = max(section.scan // _LANES_FED, 1)
        self.options = search_options(options)

    @classmethod
    def of(cls, given: CellsOrConfig, section: Border, options: Options) -> BorderStudy:
        """The borders along the parameter of the section."""
        section, options = fine_enough(section, options)
        cells, (side,) = opened(given, section.ranges(given), section.scan, options)
        return cls(cells, side, section, options)

    @classmethod
    def report(cls, ds: xr.Dataset) -> Iterator[str | ReportTable]:
        """The first borders, how many there are, and how they were looked for."""
        yield from shown(cls.table(ds))
        on_line = ds["border"].notnull().sum("crossing")
        yield f"borders  {int(on_line.sum()):,} on {int((on_line > 0).sum()):,} of {on_line.size:,} lines"
        if undecided := int(ds["scan_undecided"].sum()):
            yield f"scan     {undecided:,} cells unresolved or failed, which say nothing"
        yield search_settings(ds, "border")

    @classmethod
    def table(cls, ds: xr.Dataset) -> ReportTable:
        """The borders along each line, with the regimes on either side; and lines without a border."""
        ds = ds.transpose(..., "crossing")
        dims = ds["border"].dims[:-1]
        along = str(ds.attrs.get("border_parameter", "border")).replace("_", " ")
        words = [*axis_names(ds, dims), along, "below it", "above it", "by"]
        return ReportTable("The borders", words, ["known within"], _rows(ds, dims))

    @classmethod
    def is_drawn(cls, ds: xr.Dataset) -> bool:
        """True for borders of many lines of a configuration."""
        return ds["border"].ndim > 1 and "configuration" in ds.attrs and "cell" not in ds.dims

    def compute(self, items: range, stop: StopFlag, moved: Moved | None = None) -> Results:
        """The borders of a range of lines; by line how many places of the scan were undecided, and where there is no
        border the regime of the first that was decided."""
        scanned: list[Looked] = []

        def cells(line: Integers, place: Floats) -> Parameters:
            return self._cells.take(line + items.start, **{self._side.name: place})

        def regimes(line: Integers, place: Floats) -> Looked:
            results = solve(cells(line, place), self.options, stop, moved)
            looked = Looked(results["regime"], decided(results["regime"]), guide_of(results, self.options))
            if not scanned:
                scanned.append(looked)
            return looked

        guide = growth_of(cells, self.options)
        brackets, undecided = search_lines(len(items), self._side, self._section.tolerance, regimes, guide)
        labels, known = (values.reshape(len(items), self._side.points) for values in scanned[0][:2])
        counts = np.bincount(brackets["line"], minlength=len(items))
        first = labels[np.arange(len(items)), np.argmax(known, axis=1)]
        results = {name: brackets[name] for name in ("low", "high", "below", "above", "guided", "place")} | {
            "found": counts, "undecided": undecided,
            "throughout": np.where((counts == 0) & known.any(axis=1), first, _OPEN),
        }  # fmt: skip
        return {name: results[name].astype(dtype) for name, dtype in self.columns.items()}

    def blank(self, items: range) -> Results:
        """Lines without borders, no place of which was decided."""
        blank = {name: np.zeros(0, dtype) for name, dtype in self.columns.items()}
        undecided = np.full(len(items), self._side.points, np.int32)
        return blank | {"found": np.zeros(len(items), np.int32), "undecided": undecided,
                        "throughout": np.full(len(items), _OPEN, np.int8)}  # fmt: skip

    def dataset(self, parts: Sequence[Results], attributes: Mapping[str, Any]) -> xr.Dataset:
        """The borders with the dimensions of the lines and ``crossing``."""
        whole, side = joined(parts), self._side
        throughout = np.where(whole["throughout"] == _OPEN, np.nan, whole["throughout"])
        results = _columns(whole, self.options)
        results |= {"regime_throughout": throughout, "scan_undecided": whole["undecided"]}
        rows = _VARIABLES | {name: of_parameter(_VARIABLES[name], side.name) for name in ("border", "border_width")}
        values = {name: results[name] for name in rows}
        settings = search_attributes(self._section, self.options) | {"border_parameter": side.name}
        coordinates, attributes = grid_coordinates(self._cells), {**attributes, **settings}
        ds = study_dataset("border", rows, values, self.dims, self.shape, coordinates, attributes)
        for name in ("border", "border_width"):
            shown_in(ds[name].variable, side.written_in)
        return ds


def _rows(ds: xr.Dataset, dims: Sequence[Hashable]) -> Iterator[list[str]]:
    """A row of a table per border, or per line without any."""
    unit = unit_of(ds["border"])
    for where, line in parts_over(ds, dims):
        crossings = np.flatnonzero(np.isfinite(line["border"].values))
        for crossing in (line.isel(crossing=int(i)) for i in crossings):
            border, width = float(crossing["border"]), float(crossing["border_width"])
            below, above = (Regime(REGIMES[int(crossing[name])]) for name in ("regime_below", "regime_above"))
            how = METHODS[int(crossing["method"])]
            yield [*where, unit.text(border, 12), below, above, how, f"{unit.of(width):.2g} {unit.name}"]
        if not crossings.size:
            code = int(line["regime_throughout"]) if "regime_throughout" in line else 0
            yield [*where, f"none: {REGIMES[code]} throughout" if code else "none", "", "", "", ""]


def _columns(whole: Results, options: Options) -> dict[str, NDArray[np.float64]]:
    """Borders as tables (line, crossing), NaN where a line has fewer."""
    counts = whole["found"].astype(np.int64)
    line = np.repeat(np.arange(counts.size), counts)
    crossing = np.arange(line.size) - np.repeat(np.cumsum(counts) - counts, counts)
    bisection, guide = (METHODS.index(name) for name in ("bisection", model_of(options.law).guide))
    columns = {
        "border": whole["place"], "regime_below": whole["below"], "regime_above": whole["above"],
        "border_width": whole["high"] - whole["low"], "method": np.where(whole["guided"] == 1, guide, bisection),
    }  # fmt: skip
    tables = {name: np.full((counts.size, int(counts.max(initial=0))), np.nan) for name in columns}
    for name, values in columns.items():
        tables[name][line, crossing] = values
    return tables
