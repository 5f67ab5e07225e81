"""Margins of many cells: each parameter by itself, then all of them together, and every proposal simulated."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import replace
from math import isfinite
from typing import Any

import numpy as np
import xarray as xr

from stickslip.config.grid import build_grid
from stickslip.config.model import Config
from stickslip.config.problems import ProblemCollector
from stickslip.config.studies import Moved, Regime, ReportTable, Study
from stickslip.dataset import build
from stickslip.dataset.display import unit_of
from stickslip.engine import Options, Results, StopFlag
from stickslip.errors import ArgumentError
from stickslip.studies.changes import OPPOSITE, SIDES, VARIABLES, Margins, Reach, entered, reach_of, rows_of
from stickslip.studies.lines import CellsOrConfig, fine_enough, search_options
from stickslip.studies.margin_search import Borders, MarginSearch, cheapest, nearest
from stickslip.studies.search import Flags, Floats, Labels
from stickslip.studies.study import joined, search_attributes, search_settings
from stickslip.vocabulary.cells import Cells, Parameters
from stickslip.vocabulary.models import LAWS, laws_with, model_of
from stickslip.vocabulary.parameter import NAN
from stickslip.vocabulary.quantities import MEASURED, listed
from stickslip.vocabulary.results import REGIMES

_TOGETHER = 512  # cells whose rays are held at once
_OF_JOINT_CHANGE = 20_000  # cells a joint change takes, about
_LANES_FED = 8  # blocks of so many times more cells than their work calls for: rounds have few cells each
_MOST_WEIGHT = 256  # no block has fewer than 16 cells, for the same reason
_OF_JOINT = 1e-8  # tolerance of joint changes, whose cost is known no better
_DIGITS = 4
_LEAST_SHARE = 0.01  # %, of the cost of a change, that is shown


class MarginStudy(Study):
    """The margins of cells, its items."""

    section, variables, title = Margins, VARIABLES, "Margins"
    name, counted, ragged = "margins", "cells", True

    def __init__(self, cells: Cells, section: Margins, options: Options) -> None:
        self._cells, self._section = cells, section
        self.dims, self.shape = cells.dims, cells.shape
        self.options = search_options(options)
        self._measured = [name for name in MEASURED if name in section.reaches]
        if why := _misfit(section.reaches, options):
            raise ArgumentError("parameters", why)
        speeds = max(len(section.speeds), 1)
        each = 2 * speeds * (section.scan + int(-np.log2(section.tolerance))) * len(section.reaches)
        self.cells_each = each + (_OF_JOINT_CHANGE * speeds if section.joint else 0)
        self.weight = min(max(self.cells_each // _LANES_FED, 1), _MOST_WEIGHT)
        self._rows = rows_of(section)
        self.columns = {name: np.dtype(np.int8 if row.name == "regime" else np.float64)
                        for name, row in self._rows.items()}  # fmt: skip

    @classmethod
    def of(cls, given: CellsOrConfig, section: Margins, options: Options) -> MarginStudy:
        """The margins of the cells of a configuration, or of those that are listed."""
        if isinstance(given, Config) and not given.has_cells:
            raise ValueError("a configuration with a drive is that of a rig, whose cells have no regime")
        if isinstance(given, Config) and given.uncertain is not None:
            raise ValueError("a configuration with uncertain quantities has no single margin; leave uncertain out")
        section, options = fine_enough(section, options)
        cells = build_grid(given) if isinstance(given, Config) else build.given_cells(given, options)
        return cls(cells, section.of_cells(cells[:]), options)

    @classmethod
    def check(cls, section: Margins, config: Config, problems: ProblemCollector) -> None:
        """Note a parameter of another law."""
        if why := _misfit(section.parameters or (), Options(config.friction.law)):
            problems.add((section.key, "parameters"), why)

    @classmethod
    def mapped(cls, ds: xr.Dataset) -> list[str]:
        """The margins."""
        return [name for name in map(str, ds.data_vars) if name.startswith("margin_")]

    @classmethod
    def report(cls, ds: xr.Dataset) -> Iterator[str | ReportTable]:
        """Of one cell which changes take it over a border; of several, how many each parameter leads there, how far."""
        parameters = [name.removeprefix("margin_") for name in cls.mapped(ds)]
        if ds["regime"].size == 1:
            yield from _of_cell(ds.squeeze(), parameters)
        else:
            rows = [_distances(ds, name) for name in parameters]
            yield ReportTable("", ("parameter",), ("cells with a border", "nearest", "median", "farthest"), rows)
        if (speeds := ds.attrs.get("margin_speeds")) is not None:
            yield f"speeds   the worst of {len(speeds)} from {speeds[0]:g} to {speeds[-1]:g} m/s counts"
        if "joint_ended" in ds and (ended := int(ds["joint_ended"].sum())):
            yield f"ended    joint searches of {ended:,} cells, before they were done; there may be cheaper changes"
        yield search_settings(ds, "margin")

    def compute(self, items: range, stop: StopFlag, moved: Moved | None = None) -> Results:
        """The margins of a range of cells."""
        parts = []
        for start in range(items.start, items.stop, _TOGETHER):
            cells = self._parameters(start, min(start + _TOGETHER, items.stop))
            parts.append(_margins(MarginSearch(cells, self.options, stop, self._section.speeds, moved), self._section))
        whole = joined(parts) if parts else self.blank(items)
        return {name: whole[name].ravel().astype(dtype) for name, dtype in self.columns.items()}

    def blank(self, items: range) -> Results:
        """Cells without margins."""
        whole = super().blank(items)
        return {name: np.repeat(values, len(SIDES) if self._rows[name].dims else 1) for name, values in whole.items()}

    def _parameters(self, start: int, stop: int) -> Parameters:
        """Cells, with what is measured of their curves where that is to change."""
        cells = self._cells[start:stop]
        return model_of(self.options.law).with_measured(cells) if self._measured else cells

    def dataset(self, parts: Sequence[Results], attributes: Mapping[str, Any]) -> xr.Dataset:
        """The margins over the cells, and ``side``."""
        whole, coordinates = joined(parts), build.grid_coordinates(self._cells)
        if self._measured:
            cells = self._parameters(0, self._cells.size)
            coordinates |= {name: build.parameter_variable(name, self.dims, cells[name].reshape(self.shape))
                            for name in MEASURED}  # fmt: skip
        values = {name: whole[name].reshape(self._cells.size, -1) if row.dims else whole[name]
                  for name, row in self._rows.items()}  # fmt: skip
        coordinates["side"] = build.text_index("side", SIDES, "side of the value on which the border lies")
        attributes = dict(attributes) | search_attributes(self._section, self.options)
        if self._section.into:
            attributes["margin_into"] = ", ".join(self._section.into)
        if self._section.speeds:
            attributes["margin_speeds"] = np.array(self._section.speeds)
        return build.study_dataset("margins", self._rows, values, self.dims, self.shape, coordinates, attributes)


def _misfit(names: Iterable[str], options: Options) -> str | None:
    """Return why not all parameters of these names are of the law."""
    wrong = next((name for name in names if options.law not in laws_with(name)), None)
    if wrong is None:
        return None
    laws = listed(other for other in laws_with(wrong) if other in LAWS)
    what = f"the form of {', '.join(MEASURED)}" if wrong in MEASURED else wrong
    return f"{what} is for the law {laws}, not {options.law}"


# --- on screen --------------------------------------------------------------------------------------------------------


def _distances(ds: xr.Dataset, name: str) -> list[str]:
    """A row of the table of parameters."""
    ratio, margin = ds[f"ratio_{name}"].values.ravel(), ds[f"margin_{name}"].values.ravel()
    by_factor = bool(np.isfinite(ratio).any())
    sizes = np.sort(np.exp(np.abs(np.log(ratio[ratio > 0]))) if by_factor else np.abs(margin[~np.isnan(margin)]))
    texts = [f"x {size:.3g}" if by_factor else f"{size:.3g}" for size in sizes]
    three = [texts[0], texts[len(texts) // 2], texts[-1]] if texts else ["-"] * 3
    return [name, f"{np.count_nonzero(~np.isnan(margin)):,} of {margin.size:,}", *three]


def _of_cell(cell: xr.Dataset, parameters: Sequence[str]) -> Iterator[str | ReportTable]:
    """The borders about one cell, and its cheapest joint change, with what the simulations past them came to."""
    home, into = REGIMES[int(cell["regime"])], cell.attrs.get("margin_into")
    goals = entered(into.split(", ") if into else None, home)
    yield f"regime   {home}; wanted: {listed(goals)}"
    rows = [row for name in parameters for row in _borders(cell, name, goals)]
    yield ReportTable("", ("parameter", "value", "border", "by", "into", "simulated"), ("width",), rows)
    if "joint_cost" in cell and isfinite(cost := float(cell["joint_cost"])):
        yield f"cheapest joint change: cost {cost:.3g}, simulated: {_simulated(cell['joint_checked'], goals)}"
        shares = {name: 100.0 * float(cell[f"joint_share_{name}"]) for name in parameters}
        changed = [name for name in parameters if shares[name] >= _LEAST_SHARE]
        values = ([unit_of(cell[name]).text(float(cell[key]), _DIGITS) for key in (name, f"joint_proposed_{name}")]
                  for name in changed)  # fmt: skip
        rows = [(name, *both, f"{shares[name]:.3g} %") for name, both in zip(changed, values, strict=True)]
        yield ReportTable("", ("parameter", "value", "to"), ("share of cost",), rows)


def _borders(cell: xr.Dataset, name: str, goals: Sequence[str]) -> Iterator[tuple[str, ...]]:
    """Rows of a parameter: one for each border, or that there is none."""
    unit, value = unit_of(cell[name]), float(cell[name])
    start = unit.text(value, _DIGITS) if isfinite(value) else "none"
    sides = [cell.sel(side=side) for side in SIDES]
    borders = [place for place in sides if isfinite(float(place[f"border_{name}"]))]
    if not borders:
        yield name, start, "none within reach", "", "", "", ""
    for place in borders:
        border, width = (float(place[f"{kind}_{name}"]) for kind in ("border", "border_width"))
        ratio = border / value if value else NAN
        by = f"x {ratio:.3g}" if ratio > 0 else f"{unit.of(border - value):+.{_DIGITS}g} {unit.name}".rstrip()
        into, simulated = REGIMES[int(place[f"beyond_{name}"])], _simulated(place[f"checked_{name}"], goals)
        yield name, start, f"{place['side'].item()} {unit.text(border, 9)}", by, into, simulated, f"{width:.2g}"


def _simulated(checked: xr.DataArray, goals: Sequence[str]) -> str:
    """The regime past a border; a change that does not hold there is no cure."""
    regime = REGIMES[int(checked)]
    if regime == "not_computed":
        return "not possible, just past the border"
    return Regime(regime) if regime in goals else f"{regime}: no cure"


# --- computing --------------------------------------------------------------------------------------------------------


def _margins(search: MarginSearch, section: Margins) -> Results:
    """The columns of some cells. Raises StoppedError."""
    cells, size = search.cells, search.steps.size
    home = search.regimes(np.arange(size), {})
    into = None if section.into is None else [REGIMES.index(name) for name in section.into if name != OPPOSITE]
    search = replace(search, home=home) if OPPOSITE in (section.into or ()) else search
    reaches = [reach_of(name, cells, within) for name, within in section.reaches.items()]
    costs = np.array([section.costs.get(reach.name, 1.0) for reach in reaches])
    columns: Results = {"regime": home}
    cheapest_single = np.full(size, np.inf)
    for reach, cost in zip(reaches, costs, strict=True):
        borders = nearest(search, reach, home, into, section.scan, section.tolerance)
        columns |= _single(search, reach, borders, section)
        cheapest_single = np.fmin(cheapest_single, cost * np.fmin(*np.abs(borders.change.T)))
    if section.joint:
        tolerance = max(section.tolerance, _OF_JOINT)
        best = cheapest(search, reaches, costs, home, into, section.scan, tolerance, cheapest_single)
        columns |= _joint(search, reaches, costs, section.beyond, *best)
    return columns


def _single(search: MarginSearch, reach: Reach, borders: Borders, section: Margins) -> Results:
    """The columns of one parameter: both borders, the nearer of them as distance and as factor, and the checks."""
    nearer = np.argmin(np.where(np.isnan(borders.change), np.inf, np.abs(borders.change)), axis=1)
    border = borders.border[np.arange(reach.value.size), nearer]
    with np.errstate(divide="ignore", invalid="ignore"):
        ratio = np.where(reach.by_factor, border / reach.value, NAN)
    sides = [_checked(search, [reach], borders.change[:, [i]], section.beyond) for i in range(len(SIDES))]
    columns = {
        "margin": border - reach.value, "ratio": ratio,
        "border": borders.border, "border_width": borders.high - borders.low, "beyond": borders.beyond,
        "proposed": np.concatenate([values for _, values in sides], axis=1),
        "checked": np.stack([regimes for regimes, _ in sides], axis=1),
    }  # fmt: skip
    return {f"{name}_{reach.name}": values for name, values in columns.items()}


def _joint(
    search: MarginSearch, reaches: Sequence[Reach], costs: Floats, beyond: float, cost: Floats, changes: Floats,
    ended: Flags,
) -> Results:  # fmt: skip
    """The columns of the cheapest joint change, from what `cheapest` says of it."""
    regimes, proposed = _checked(search, reaches, changes, beyond)
    columns: Results = {"joint_cost": cost, "joint_checked": regimes, "joint_ended": ended}
    for i, reach in enumerate(reaches):
        values = reach.at(np.nan_to_num(changes[:, i]), np.arange(cost.size))
        columns[f"joint_{reach.name}"] = np.where(np.isnan(cost), NAN, values)
        columns[f"joint_share_{reach.name}"] = (costs[i] * changes[:, i] / cost) ** 2
        columns[f"joint_proposed_{reach.name}"] = proposed[:, i]
    return columns


def _checked(search: MarginSearch, reaches: Sequence[Reach], changes: Floats, beyond: float) -> tuple[Labels, Floats]:
    """Regimes of cells a little past the border, and the values there; 0 and NaN where there is none.

    changes : (n, k) up to the border. The length of the change grows by the share `beyond`, or by as much as a single
    parameter has to change by that share of its value, if that is more.
    """
    there = np.flatnonzero(~np.isnan(changes).any(axis=1))
    regimes = np.zeros(len(changes), np.int8)
    values = np.full(changes.shape, NAN)
    length = np.linalg.norm(changes[there], axis=1, keepdims=True)
    by_factor = np.stack([reach.by_factor[there] for reach in reaches], axis=1).any(axis=1, keepdims=True)
    more = np.where(by_factor, np.maximum(beyond * length, np.log1p(beyond)), beyond * length)
    further = changes[there] * (1 + more / np.where(length > 0, length, 1.0))
    for i, reach in enumerate(reaches):
        values[there, i] = reach.at(further[:, i], there)
    regimes[there] = search.regimes(there, {reach.name: values[there, i] for i, reach in enumerate(reaches)})
    return regimes, values
