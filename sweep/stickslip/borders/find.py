"""Borders of regimes: lines of cells, searched through the engine, and labelled."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from numbers import Integral

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from stickslip.borders.lines import Lines
from stickslip.borders.search import Brackets, Floats, Integers, Labels, Scan, search_lines
from stickslip.dataset.borders import border_dataset
from stickslip.engine import Options, compute
from stickslip.errors import Interrupted
from stickslip.vocabulary import units
from stickslip.vocabulary.cells import Cells, as_cells
from stickslip.vocabulary.flags import REGIMES
from stickslip.vocabulary.quantities import PARAMETERS
from stickslip.vocabulary.settings import AXIS

UNDECIDED = [REGIMES.index(name) for name in ("not_computed", "unresolved", "failed")]
_TOGETHER = 2**18  # cells of a scan that are held at once
_SMALLEST_TOLERANCE = 1e-15  # neighbours among floating-point numbers are 1e-16 apart


@dataclass(frozen=True)
class Limits:
    """How finely to look: points of the scan of each line, and the width, relative to the border, to stop at."""

    scan: int
    tolerance: float

    def __post_init__(self) -> None:
        row = AXIS["num"]
        scan: object = self.scan
        if isinstance(scan, bool) or not isinstance(scan, Integral) or not row.allows(int(scan)):
            raise ValueError(f"scan: got {self.scan!r}, expected {row.expected}")
        if not _SMALLEST_TOLERANCE <= self.tolerance < 1:
            raise ValueError(
                f"tolerance: got {self.tolerance!r}, expected a number from {_SMALLEST_TOLERANCE:g} to below 1"
            )

    def rtol(self) -> float:
        """A tolerance of the integration that leaves the border its digits."""
        return float(np.clip(self.tolerance / 100, 1e-12, 1e-6))


def find_borders(lines: Lines, limits: Limits, options: Options, attributes: Mapping[str, str]) -> xr.Dataset:
    """The borders of all lines as a dataset.

    Raises ValueError before anything is computed if a cell on a line is impossible, Interrupted on Ctrl-C.
    """
    low, high = lines.between
    scan = Scan.over(low, high, limits.scan)
    if lines.spacing is not None:
        scan = Scan(low, high, limits.scan, lines.spacing)
    each = max(1, _TOGETHER // limits.scan)
    parts = [(start, min(start + each, lines.size)) for start in range(0, lines.size, each)]
    for start, stop in parts:
        for end in lines.between:
            as_cells(lines.others(start, stop) | {lines.along: np.array([end])})
    found, undecided = [], [np.zeros(0, np.int64)]
    for start, stop in parts:
        brackets, missing = _search(lines.others(start, stop), stop - start, lines.along, scan, limits, options)
        brackets["line"] += start
        found.append(brackets)
        undecided.append(missing)
    together = np.concatenate(found)
    told = dict(attributes) | _told(together, lines, scan, limits, options, int(np.concatenate(undecided).sum()))
    results = _table(together, lines.size) | {"scan_undecided": np.concatenate(undecided)}
    return border_dataset(lines.along, lines.dims, lines.shape, lines.coordinates, results, told)


def _search(
    others: Cells, size: int, along: str, scan: Scan, limits: Limits, options: Options
) -> tuple[Brackets, Integers]:
    """The brackets of some lines."""

    def regimes(line: Integers, place: Floats) -> tuple[Labels, NDArray[np.bool_]]:
        def cells(start: int, stop: int) -> Cells:
            taken = {name: values[line[start:stop]] for name, values in others.items()}
            return taken | {along: place[start:stop]}

        computed = compute(cells, line.size, options)
        if not computed.complete:
            raise Interrupted(computed.done, line.size)
        found = computed.results["regime"]
        return found, ~np.isin(found, UNDECIDED)

    return search_lines(size, scan, limits.tolerance, regimes)


def _table(found: Brackets, lines: int) -> dict[str, NDArray[np.float64]]:
    """Brackets as tables (line, crossing), NaN where a line has fewer."""
    counts = np.bincount(found["line"], minlength=lines)
    most = int(counts.max(initial=0))
    crossing = np.arange(found.size) - np.repeat(np.cumsum(counts) - counts, counts)
    low, high = found["low"], found["high"]
    columns = {
        "border": low + (high - low) / 2, "regime_below": found["below"], "regime_above": found["above"],
        "border_width": high - low,
    }  # fmt: skip
    tables = {name: np.full((lines, most), np.nan) for name in columns}
    for name, values in columns.items():
        tables[name][found["line"], crossing] = values
    return tables


def _told(
    found: Brackets, lines: Lines, scan: Scan, limits: Limits, options: Options, undecided: int
) -> dict[str, str | float]:
    """What was done and what it cannot see, as global attributes."""
    row = PARAMETERS[lines.along]
    places, unit = scan.places, units.spelled(row.units)
    apart = f"{places[1] - places[0]:.6g} {unit}".rstrip()
    if scan.spacing == "log":
        apart = f"a factor of {places[1] / places[0]:.6g}"
    wide = int(np.count_nonzero(found["high"] - found["low"] > scan.width(limits.tolerance, found)))
    with_borders = np.unique(found["line"]).size
    result = f"{found.size} on {with_borders} of {lines.size} lines"
    if not found.size:
        result = f"none: no change of regime was found on {lines.size} lines"
    if wide:
        result += f"; {wide} wider than the tolerance, around cells that are undecided or of a third regime"
    if undecided:
        result += f"; {undecided} cells of the scan were unresolved or failed and say nothing"
    return {
        "border_parameter": lines.along,
        "border_range": f"{scan.low!r} to {scan.high!r} {unit}".rstrip(),
        "border_scan": f"{scan.points} points, {scan.spacing} spacing, {apart} apart: a regime that begins and ends "
        "between two of them can be missed",
        "border_scan_points": scan.points,
        "border_method": "bisection of the regime",
        "border_tolerance": limits.tolerance,
        "border_rtol": options.rtol,
        "border_found": result,
    }
