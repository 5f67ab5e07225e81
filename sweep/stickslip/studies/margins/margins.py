"""Margins of many cells: each parameter by itself, then all of them together, and every proposal simulated."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import replace
from typing import Any

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from stickslip.config.grid import build_grid
from stickslip.config.model import Config
from stickslip.config.problems import ProblemCollector
from stickslip.config.studies import Moved, Study, Table
from stickslip.dataset import build
from stickslip.engine import Options, Results, StopFlag
from stickslip.errors import ArgumentError
from stickslip.studies.borders.lines import CellsOrConfig, fine_enough, search_options
from stickslip.studies.margins import words
from stickslip.studies.margins.joint import MOST_STEPS, Cheapest, cheapest
from stickslip.studies.margins.reach import Reach, reach_of
from stickslip.studies.margins.section import ON_SIDES, OPPOSITE, SIDES, VARIABLES, Margins
from stickslip.studies.margins.single import Borders, Floats, Labels, Search, decided, nearest
from stickslip.studies.report import attributes
from stickslip.studies.study import joined
from stickslip.vocabulary.cells import Cells, Parameters
from stickslip.vocabulary.flags import REGIMES
from stickslip.vocabulary.models import LAWS, laws_with, model_of
from stickslip.vocabulary.parameter import NAN
from stickslip.vocabulary.quantities import MEASURED
from stickslip.vocabulary.results import VARIABLES as CELL_VARIABLES
from stickslip.vocabulary.suggest import listed

_TOGETHER = 512  # cells whose rays are held at once
_OF_JOINT_CHANGE = 20_000  # cells a joint change takes, about
_LANES_FED = 8  # blocks of so many times more cells than their work calls for: rounds have few cells each
_MOST_WEIGHT = 256  # no block has fewer than 16 cells, for the same reason
_OF_JOINT = 1e-8  # tolerance of joint changes, whose cost is known no better


class MarginStudy(Study):
    """The margins of cells, its items."""

    section, variables, title = Margins, VARIABLES, "Margins"
    name, counted = "margins", "cells"

    def __init__(self, cells: Cells, section: Margins, options: Options) -> None:
        self._cells, self._section = cells, section
        self.dims, self.shape = cells.dims, cells.shape
        self.options = search_options(options)
        self._measured = [name for name in MEASURED if name in section.reaches]
        if why := _not_of(options.law, section.reaches):
            raise ArgumentError("parameters", why)
        speeds = max(len(section.speeds), 1)
        each = 2 * speeds * (section.scan + int(-np.log2(section.tolerance))) * len(section.reaches)
        self.cells_each = each + (_OF_JOINT_CHANGE * speeds if section.joint else 0)
        self.weight = min(max(self.cells_each // _LANES_FED, 1), _MOST_WEIGHT)
        self.columns = {name: np.dtype(np.int8 if flag else np.float64) for name, flag in _columns(section)}

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
        if why := _not_of(config.friction.law, section.parameters or ()):
            problems.add((section.key, "parameters"), why)

    @classmethod
    def mapped(cls, ds: xr.Dataset) -> list[str]:
        """The margins."""
        return [name for name in map(str, ds.data_vars) if name.startswith("margin_")]

    @classmethod
    def report(cls, ds: xr.Dataset) -> Iterator[str | Table]:
        """Of one cell which changes take it over a border; of several, how many each parameter leads there, how far."""
        if ds["regime"].size == 1:
            yield from words.advice(ds)
            return
        rows = [_distances(ds, name.removeprefix("margin_")) for name in cls.mapped(ds)]
        yield Table("", ("parameter",), ("cells with a border", "nearest", "median", "farthest"), rows)
        yield from attributes(ds, found="margin_found", within="margin_within", scan="margin_scan")

    def compute(self, items: range, stop: StopFlag, moved: Moved | None = None) -> Results:
        """The margins of a range of cells."""
        parts = []
        for start in range(items.start, items.stop, _TOGETHER):
            cells = self._parameters(start, min(start + _TOGETHER, items.stop))
            parts.append(_margins(Search(cells, self.options, stop, self._section.speeds, moved), self._section))
        whole = joined(parts) if parts else self.blank(items)
        return {name: whole[name].astype(dtype) for name, dtype in self.columns.items()}

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
        flags = {name: replace(row, name="regime", units="1") if row.units == "flag" else row
                 for name, row in VARIABLES.items()}  # fmt: skip
        rows = {"regime": CELL_VARIABLES["regime"]} | flags
        rows |= {
            f"{name}_{p}": build.of_parameter(row, p) for name, row in flags.items() for p in self._section.reaches
        }
        both = {f"{kind}_{p}": np.stack([whole[f"{kind}_{p}_{side}"] for side in SIDES], axis=-1)
                for p in self._section.reaches for kind in ON_SIDES}  # fmt: skip
        values = {name: array for name, array in whole.items() if name in rows and name not in both} | both
        coordinates["side"] = build.text_index("side", SIDES, "side of the value on which the border lies")
        attributes = dict(attributes) | _attributes(self._section, whole, self.options)
        return build.study_dataset("margins", rows, values, self.dims, self.shape, coordinates, attributes)


def _not_of(law: str, names: Iterable[str]) -> str | None:
    """Return why not all parameters of these names are of a law."""
    wrong = next((name for name in names if law not in laws_with(name)), None)
    if wrong is None:
        return None
    laws = listed(one for one in laws_with(wrong) if one in LAWS)
    what = f"the form of {', '.join(MEASURED)}" if wrong in MEASURED else wrong
    return f"{what} is for the law {laws}, not {law}"


def _distances(ds: xr.Dataset, name: str) -> list[str]:
    """A row of the table of parameters."""
    ratio, margin = ds[f"ratio_{name}"].values.ravel(), ds[f"margin_{name}"].values.ravel()
    by_factor = bool(np.isfinite(ratio).any())
    sizes = np.sort(np.exp(np.abs(np.log(ratio[ratio > 0]))) if by_factor else np.abs(margin[~np.isnan(margin)]))
    texts = [f"x {size:.3g}" if by_factor else f"{size:.3g}" for size in sizes]
    three = [texts[0], texts[len(texts) // 2], texts[-1]] if texts else ["-"] * 3
    return [name, f"{np.count_nonzero(~np.isnan(margin)):,} of {margin.size:,}", *three]


def _columns(section: Margins) -> Iterator[tuple[str, bool]]:
    """Names of the columns, and whether they are flags."""
    yield "regime", True
    for name in section.reaches:
        yield from ((f"margin_{name}", False), (f"ratio_{name}", False))
        for side in SIDES:
            yield from ((f"{kind}_{name}_{side}", flag) for kind, flag in ON_SIDES.items())
    if section.joint:
        yield from (("joint_cost", False), ("joint_checked", True), ("joint_ended", True))
        for name in section.reaches:
            yield from ((f"joint{kind}_{name}", False) for kind in ("", "_share", "_proposed"))


def _margins(search: Search, section: Margins) -> Results:
    """The columns of some cells. Raises StoppedError."""
    cells, size = search.cells, search.steps.size
    home = search.regimes(np.arange(size), {})
    into = None if section.into is None else [REGIMES.index(name) for name in section.into if name != OPPOSITE]
    search = replace(search, home=home) if OPPOSITE in (section.into or ()) else search
    reaches = [reach_of(name, cells, within) for name, within in section.reaches.items()]
    table: Results = {"regime": home}
    cheapest_single = np.full(size, np.inf)
    for reach, cost in zip(reaches, section.of_each, strict=True):
        found = nearest(search, reach, home, into, section.scan, section.tolerance)
        table |= _single(search, reach, found, section)
        cheapest_single = np.fmin(cheapest_single, cost * np.fmin(*np.abs(found.change.T)))
    if section.joint:
        tolerance = max(section.tolerance, _OF_JOINT)
        best = cheapest(search, reaches, section.of_each, home, into, section.scan, tolerance, cheapest_single)
        table |= _joint(search, reaches, best, section)
    return table


def _single(search: Search, reach: Reach, found: Borders, section: Margins) -> Results:
    """The columns of one parameter: both borders, the nearer of them as distance and as factor, and the checks."""
    size = reach.value.size
    nearer = np.argmin(np.where(np.isnan(found.change), np.inf, np.abs(found.change)), axis=1)
    border = found.border[np.arange(size), nearer]
    with np.errstate(divide="ignore", invalid="ignore"):
        ratio = np.where(reach.by_factor, border / reach.value, NAN)
    name = reach.name
    table = {f"margin_{name}": border - reach.value, f"ratio_{name}": ratio}
    for i, side in enumerate(SIDES):
        regimes, values = _checked(search, [reach], found.change[:, [i]], section.beyond)
        on_side = {
            "border": found.border[:, i], "border_width": found.high[:, i] - found.low[:, i],
            "beyond": found.beyond[:, i],
            "proposed": values[:, 0], "checked": regimes,
        }  # fmt: skip
        table |= {f"{kind}_{name}_{side}": on_side[kind] for kind in ON_SIDES}
    return table


def _joint(search: Search, reaches: Sequence[Reach], best: Cheapest, section: Margins) -> Results:
    """Return what is said of the cheapest joint change."""
    found = {"joint_cost": np.where(np.isfinite(best.cost), best.cost, NAN)}
    everywhere = np.arange(best.cost.size)
    known = np.isfinite(best.cost)
    for i, reach in enumerate(reaches):
        values = reach.at(np.nan_to_num(best.changes[:, i]), everywhere)
        found[f"joint_{reach.name}"] = np.where(known, values, NAN)
        cost = section.of_each[i] * best.changes[:, i]
        found[f"joint_share_{reach.name}"] = np.where(known, (cost / best.cost) ** 2, NAN)
    regimes, values = _checked(search, reaches, best.changes, section.beyond)
    found["joint_checked"], found["joint_ended"] = regimes, best.ended
    return found | {f"joint_proposed_{reach.name}": values[:, i] for i, reach in enumerate(reaches)}


def _checked(search: Search, reaches: Sequence[Reach], changes: Floats, beyond: float) -> tuple[Labels, Floats]:
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


def _attributes(section: Margins, table: Mapping[str, NDArray[Any]], options: Options) -> dict[str, str | float]:
    """Return what was done and what it cannot see, as global attributes."""
    open_cells = int(np.count_nonzero(~decided(table["regime"])))
    none = [name for name in section.reaches if np.isnan(table[f"margin_{name}"]).all()]
    attributes: dict[str, str | float] = {
        "margin_within": _all_spelled(section.reaches),
        "margin_into": ", ".join(section.into) if section.into else "any other regime",
        "margin_scan": f"{section.scan} places on either side, evenly spaced in the change: what begins and ends "
        "between two of them can be missed",
        "margin_tolerance": section.tolerance,
        "margin_rtol": options.rtol,
        "margin_check": f"proposals were simulated {100 * section.beyond:g} % past the border",
        "margin_found": f"no border within reach along {', '.join(none)}" if none else "a border along each parameter",
    }
    if section.speeds:
        low, *_, high = section.speeds
        attributes["margin_speeds"] = f"the worst of {len(section.speeds)} belt speeds from {low:g} to {high:g} m/s"
    if open_cells:
        attributes["margin_undecided"] = f"{open_cells} cells are unresolved or failed and have no margin"
    if section.joint:
        costs = ", ".join(f"{name}: {cost:g}" for name, cost in zip(section.reaches, section.of_each, strict=True))
        if ended := int(np.count_nonzero(table["joint_ended"])):
            after = f"searches that ended after {MOST_STEPS:,.0f} steps of integration: {ended}"
            attributes["joint_ended"] = f"{after}; there may be a cheaper joint change"
        attributes["joint_costs"] = f"{costs}; of a change by the factor e, or by its scale where the value is 0"
    return attributes


def _all_spelled(within: Mapping[str, float | tuple[float, float]]) -> str:
    """Return how far each parameter may go; one factor for all of them where it is."""
    if len(set(within.values())) == 1 and isinstance(first := next(iter(within.values())), float):
        return f"{_spelled(first)}, along {', '.join(within)}"
    return ", ".join(f"{name}: {_spelled(one)}" for name, one in within.items())


def _spelled(within: float | tuple[float, float]) -> str:
    return f"{within[0]!r} to {within[1]!r}" if isinstance(within, tuple) else f"a factor of {within:g}"
