"""Borders of regimes: lines of cells, searched through the engine, and labelled."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from numbers import Integral
from typing import Any

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from stickslip.config.studies import Border
from stickslip.dataset.build import grid_coordinates
from stickslip.dataset.studies import border_dataset
from stickslip.engine import Options, Results, StopFlag, solve
from stickslip.errors import StoppedError
from stickslip.studies.borders.lines import CellsOrConfig, Side, lines_along
from stickslip.studies.borders.search import Brackets, Floats, Integers, Labels, Looked, search_lines
from stickslip.studies.study import Finished, Moved, Study, joined
from stickslip.vocabulary import units
from stickslip.vocabulary.cells import Cells
from stickslip.vocabulary.flags import METHODS, UNDECIDED
from stickslip.vocabulary.quantities import QUANTITIES
from stickslip.vocabulary.settings import BORDER

_OPEN = -1  # in place of the regime throughout of a line that has borders, or no decided place
_LANES_FED = 8  # blocks of so many times more lines than their cells call for: a round of bisection has one cell a line
_METHOD = METHODS.index("bisection"), METHODS.index("restick_margin")  # by whether the margin led to the border


@dataclass(frozen=True)
class Limits:
    """How finely to look: places of the scan of each line, and the width, relative to the border, to stop at."""

    scan: int = 64
    tolerance: float = 1e-9

    def __post_init__(self) -> None:
        for name in ("scan", "tolerance"):
            row, value = BORDER[name], getattr(self, name)
            if isinstance(value, bool) or row.whole and not isinstance(value, Integral) or not row.allows(value):
                raise ValueError(f"{name}: got {value!r}, expected {row.expected}")

    def applied(self, options: Options, rtol: float | None) -> Options:
        """Return how to integrate; `rtol` is None for a tolerance that leaves borders their digits."""
        rtol = float(np.clip(self.tolerance / 100, 1e-12, 1e-6)) if rtol is None else float(rtol)
        return replace(options, rtol=rtol, early_stop=True)


class BorderStudy(Study):
    """The borders of lines; its items are the lines."""

    name, counted, ragged = "borders", "lines", True
    columns: Mapping[str, np.dtype[Any]] = {
        "found": np.dtype(np.int32), "undecided": np.dtype(np.int32), "throughout": np.dtype(np.int8),  # by line ...
        "low": np.dtype(np.float64), "high": np.dtype(np.float64),  # ... and the others by border
        "below": np.dtype(np.int8), "above": np.dtype(np.int8), "guided": np.dtype(np.int8),
    }  # fmt: skip

    def __init__(self, cells: Cells, side: Side, limits: Limits, options: Options) -> None:
        self._cells, self._side, self._limits = cells, side, limits
        self.dims, self.shape = cells.dims, cells.shape
        self.cells_each = limits.scan + int(-np.log2(limits.tolerance))
        self.weight = max(limits.scan // _LANES_FED, 1)
        self.options = replace(options, early_stop=True)

    def compute(self, items: range, stop: StopFlag, moved: Moved | None = None) -> Finished:
        """The borders of a range of lines."""
        try:
            brackets, undecided, regime = self._search(items, stop, moved)
        except StoppedError:
            return Finished({}, False)
        counts = np.bincount(brackets["line"], minlength=len(items))
        throughout = np.where(counts == 0, regime, _OPEN)
        results = {"found": counts, "undecided": undecided, "throughout": throughout} | {
            name: brackets[name] for name in ("low", "high", "below", "above", "guided")
        }
        return Finished({name: results[name].astype(dtype) for name, dtype in self.columns.items()})

    def _search(self, items: range, stop: StopFlag, moved: Moved | None) -> tuple[Brackets, Integers, Labels]:
        """The brackets of some lines, counted from the first; by line how many places of the scan were undecided, and
        the regime of the first that was decided. Raises StoppedError.
        """
        scanned: list[Looked] = []

        def regimes(line: Integers, place: Floats) -> Looked:
            cells = self._cells.take(line + items.start, **{self._side.name: place})
            results = solve(cells, self.options, stop, moved)
            regime = results["regime"]
            answer = Looked(regime, ~np.isin(regime, UNDECIDED), results["restick_margin"])
            if not scanned:
                scanned.append(answer)
            return answer

        brackets, undecided = search_lines(len(items), self._side, self._limits.tolerance, regimes)
        labels, decided = (values.reshape(len(items), self._side.points) for values in scanned[0][:2])
        first = labels[np.arange(len(items)), np.argmax(decided, axis=1)]
        return brackets, undecided, np.where(decided.any(axis=1), first, _OPEN).astype(np.int8)

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
        results = _table(whole) | {"regime_throughout": throughout, "scan_undecided": whole["undecided"]}
        return border_dataset(
            side.name, self.dims, self.shape, grid_coordinates(self._cells), results,
            dict(attributes) | _attributes(whole, side, self._limits, self.options), side.written_in,
        )  # fmt: skip


def border_study(given: CellsOrConfig, section: Border, options: Options) -> BorderStudy:
    """The borders that a section of a configuration asks for. Raises TypeError or ValueError for what cannot be."""
    limits = Limits(section.scan, section.tolerance)
    options = limits.applied(options, section.rtol)
    return BorderStudy(*lines_along(given, section.along, section.between, limits.scan, options), limits, options)


def _table(found: Results) -> dict[str, NDArray[np.float64]]:
    """Borders as tables (line, crossing), NaN where a line has fewer."""
    counts = found["found"].astype(np.int64)
    line = np.repeat(np.arange(counts.size), counts)
    crossing = np.arange(line.size) - np.repeat(np.cumsum(counts) - counts, counts)
    low, high = found["low"], found["high"]
    columns = {
        "border": low + (high - low) / 2, "regime_below": found["below"], "regime_above": found["above"],
        "border_width": high - low, "method": np.take(_METHOD, found["guided"]),
    }  # fmt: skip
    tables = {name: np.full((counts.size, int(counts.max(initial=0))), np.nan) for name in columns}
    for name, values in columns.items():
        tables[name][line, crossing] = values
    return tables


def _attributes(found: Results, scan: Side, limits: Limits, options: Options) -> dict[str, str | float]:
    """Return what was done and what it cannot see, as global attributes."""
    row = QUANTITIES[scan.name]
    places, unit = scan.places, units.spelled(row.units)
    apart = f"{places[1] - places[0]:.6g} {unit}".rstrip()
    if scan.spacing == "log":
        apart = f"a factor of {places[1] / places[0]:.6g}"
    low, high = found["low"], found["high"]
    wide = int(np.count_nonzero(high - low > scan.width(limits.tolerance, low, high)))
    undecided = int(found["undecided"].sum(dtype=np.int64))
    result = f"{low.size} on {np.count_nonzero(found['found'])} of {found['found'].size} lines"
    if not low.size:
        result = f"none: no change of regime was found on {found['found'].size} lines"
    if wide:
        result += f"; {wide} wider than the tolerance, around cells that are undecided or of a third regime"
    if undecided:
        result += f"; {undecided} cells of the scan were unresolved or failed and say nothing"
    return {
        "border_parameter": scan.name,
        "border_range": f"{scan.low!r} to {scan.high!r} {unit}".rstrip(),
        "border_scan": f"{scan.points} points, {scan.spacing} spacing, {apart} apart: a regime that begins and ends "
        "between two of them can be missed",
        "border_scan_points": scan.points,
        "border_method": "restick_margin where it passes zero at the border, by a bracketed secant (ITP), else "
        "bisection of the regime: see `method`",
        "border_tolerance": limits.tolerance,
        "border_rtol": options.rtol,
        "border_found": result,
    }
