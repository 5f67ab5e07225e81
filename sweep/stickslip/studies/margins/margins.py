"""Margins of many cells: each parameter by itself, then all of them together, and every proposal simulated."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from stickslip.config.grid import build_grid
from stickslip.config.model import Config
from stickslip.config.studies import Margins
from stickslip.dataset.build import given_cells, grid_coordinates, parameter_variable
from stickslip.dataset.studies import ON_SIDES, SIDES, margin_dataset
from stickslip.engine import Options, Results, StopFlag
from stickslip.errors import StoppedError
from stickslip.studies.borders import Limits
from stickslip.studies.borders.lines import CellsOrConfig
from stickslip.studies.margins.joint import MOST_STEPS, Cheapest, cheapest
from stickslip.studies.margins.reach import FACTOR, Reach, parameters_of, reach_of, within_of
from stickslip.studies.margins.single import Borders, Floats, Labels, Search, codes, decided, nearest
from stickslip.studies.study import Finished, Moved, Study, joined
from stickslip.vocabulary.cells import Cells, Parameters
from stickslip.vocabulary.models import laws_with, model_of
from stickslip.vocabulary.parameter import NAN
from stickslip.vocabulary.quantities import MEASURED
from stickslip.vocabulary.suggest import listed

_TOGETHER = 512  # cells whose rays are held at once
_OF_JOINT_CHANGE = 20_000  # cells a joint change takes, about
_LANES_FED = 8  # blocks of so many times more cells than their work calls for: rounds have few cells each
_MOST_WEIGHT = 256  # no block has fewer than 16 cells, for the same reason
_OF_JOINT = 1e-8  # tolerance of joint changes, whose cost is known no better


@dataclass(frozen=True)
class Question:
    """What is asked of every cell.

    parameters : that may change. costs : of a change of each by itself, relative to the others; 1 unless given.
    within : how far, a factor or ranges in SI. into : names of the regimes to be entered; None for any other.
    scan : places looked at first on either side. tolerance : of borders. beyond : how far past a border a proposal is
    simulated, over the value. joint : whether the cheapest joint change is looked for. speeds : belt speeds (m/s) of
    which the worst counts for every cell; none for that of the cell.
    """

    parameters: tuple[str, ...]
    costs: Mapping[str, float]
    within: float | Mapping[str, float | tuple[float, float]] = FACTOR
    into: tuple[str, ...] | None = None
    scan: int = 32
    tolerance: float = 1e-9
    beyond: float = 0.01
    joint: bool = True
    speeds: tuple[float, ...] = ()

    def __post_init__(self) -> None:
        within_of(self.within, self.parameters)
        codes(self.into or ())
        if not self.parameters or len(set(self.parameters)) != len(self.parameters):
            raise ValueError(f"parameters: got {self.parameters!r}, expected different names, at least one")
        if self.speeds and "belt_speed" in self.parameters:
            raise ValueError("parameters: got belt_speed, which is what the range of speeds is about")
        for name, cost in self.costs.items():
            if name not in self.parameters:
                raise ValueError(f"costs: got one for {name!r}, expected {', '.join(self.parameters)}")
            if not 0 < cost < np.inf:
                raise ValueError(f"costs: got {cost!r} for {name}, expected a number above 0")
        if not 0 <= self.beyond < 1:
            raise ValueError(f"beyond: got {self.beyond!r}, expected a share from 0 to below 1")

    @property
    def of_each(self) -> Floats:
        """The cost of each parameter."""
        return np.array([self.costs.get(name, 1.0) for name in self.parameters])


class MarginStudy(Study):
    """The margins of cells, its items."""

    name, counted = "margins", "cells"

    def __init__(self, cells: Cells, question: Question, options: Options) -> None:
        self._cells, self.question = cells, question
        self.dims, self.shape = cells.dims, cells.shape
        self.options = replace(options, early_stop=True)
        self._measured = [name for name in MEASURED if name in question.parameters]
        if wrong := [name for name in self._measured if options.law not in laws_with(name)]:
            laws = listed(laws_with(wrong[0]))
            raise ValueError(f"parameters: the form of {', '.join(MEASURED)} is for the law {laws}, not {options.law}")
        speeds = max(len(question.speeds), 1)
        each = 2 * speeds * (question.scan + int(-np.log2(question.tolerance))) * len(question.parameters)
        self.cells_each = each + (_OF_JOINT_CHANGE * speeds if question.joint else 0)
        self.weight = min(max(self.cells_each // _LANES_FED, 1), _MOST_WEIGHT)
        self.columns = {name: np.dtype(np.int8 if flag else np.float64) for name, flag in _columns(question)}

    def compute(self, items: range, stop: StopFlag, moved: Moved | None = None) -> Finished:
        """The margins of a range of cells."""
        parts = []
        for start in range(items.start, items.stop, _TOGETHER):
            cells = self._parameters(start, min(start + _TOGETHER, items.stop))
            try:
                parts.append(_margins(Search(cells, self.options, stop, self.question.speeds, moved), self.question))
            except StoppedError:
                return Finished({}, False)
        whole = joined(parts) if parts else self.blank(items)
        return Finished({name: whole[name].astype(dtype) for name, dtype in self.columns.items()})

    def _parameters(self, start: int, stop: int) -> Parameters:
        """Cells, with what is measured of their curves where that is to change."""
        cells = self._cells[start:stop]
        return model_of(self.options.law).with_measured(cells) if self._measured else cells

    def blank(self, items: range) -> Results:
        """Cells of which nothing is known."""
        return {name: np.full(len(items), 0 if dtype == np.int8 else np.nan, dtype)
                for name, dtype in self.columns.items()}  # fmt: skip

    def dataset(self, parts: Sequence[Results], attributes: Mapping[str, Any]) -> xr.Dataset:
        """The margins over the cells, and ``side``."""
        whole, coordinates = joined(parts), grid_coordinates(self._cells)
        if self._measured:
            cells = self._parameters(0, self._cells.size)
            coordinates |= {name: parameter_variable(name, self.dims, cells[name].reshape(self.shape))
                            for name in MEASURED}  # fmt: skip
        attributes = dict(attributes) | _attributes(self.question, whole, self.options)
        return margin_dataset(self.question.parameters, self.dims, self.shape, coordinates, whole, attributes)


def margin_study(
    given: CellsOrConfig, section: Margins, options: Options, speeds: tuple[float, ...] = ()
) -> MarginStudy:
    """The margins that a section of a configuration asks for; `speeds` as in `Question`.

    Raises TypeError or ValueError for what cannot be.
    """
    if isinstance(given, Config) and given.drive is not None:
        raise ValueError("a configuration with a drive is that of a rig, whose cells have no regime")
    if isinstance(given, Config) and given.uncertain is not None:
        raise ValueError("a configuration with uncertain quantities has no single margin; leave uncertain out")
    limits = Limits(section.scan, section.tolerance)
    options = limits.applied(options, section.rtol)
    cells = build_grid(given) if isinstance(given, Config) else given_cells(given, options)
    names = section.parameters
    if names is None:
        names = tuple(name for name in parameters_of(cells[:]) if not (speeds and name == "belt_speed"))
    question = Question(
        names, section.costs, section.within, section.into, section.scan, section.tolerance, section.beyond,
        section.joint, speeds,
    )  # fmt: skip
    return MarginStudy(cells, question, options)


def _columns(question: Question) -> Iterator[tuple[str, bool]]:
    """Names of the columns, and whether they are flags."""
    yield "regime", True
    for name in question.parameters:
        yield from ((f"margin_{name}", False), (f"ratio_{name}", False))
        for side in SIDES:
            yield from ((f"{kind}_{name}_{side}", flag) for kind, flag in ON_SIDES.items())
    if question.joint:
        yield from (("joint_cost", False), ("joint_checked", True), ("joint_ended", True))
        for name in question.parameters:
            yield from ((f"joint{kind}_{name}", False) for kind in ("", "_share", "_proposed"))


def _margins(search: Search, question: Question) -> Results:
    """The columns of some cells. Raises StoppedError."""
    cells, size = search.cells, search.steps.size
    home = search.regimes(np.arange(size), {})
    into = None if question.into is None else codes(question.into)
    within = within_of(question.within, question.parameters)
    reaches = [reach_of(name, cells, within[name]) for name in question.parameters]
    table: Results = {"regime": home}
    cheapest_single = np.full(size, np.inf)
    for reach, cost in zip(reaches, question.of_each, strict=True):
        found = nearest(search, reach, home, into, question.scan, question.tolerance)
        table |= _single(search, reach, found, question)
        cheapest_single = np.fmin(cheapest_single, cost * np.fmin(*np.abs(found.change.T)))
    if question.joint:
        tolerance = max(question.tolerance, _OF_JOINT)
        best = cheapest(search, reaches, question.of_each, home, into, question.scan, tolerance, cheapest_single)
        table |= _joint(search, reaches, best, question)
    return table


def _single(search: Search, reach: Reach, found: Borders, question: Question) -> Results:
    """The columns of one parameter: both borders, the nearer of them as distance and as factor, and the checks."""
    size = reach.value.size
    middle = found.low + (found.high - found.low) / 2
    nearer = np.argmin(np.where(np.isnan(found.change), np.inf, np.abs(found.change)), axis=1)
    border = middle[np.arange(size), nearer]
    with np.errstate(divide="ignore", invalid="ignore"):
        ratio = np.where(reach.by_factor, border / reach.value, NAN)
    name = reach.name
    table = {f"margin_{name}": border - reach.value, f"ratio_{name}": ratio}
    for i, side in enumerate(SIDES):
        regimes, values = _checked(search, [reach], found.change[:, [i]], question.beyond)
        on_side = {
            "border": middle[:, i], "border_width": found.high[:, i] - found.low[:, i], "beyond": found.beyond[:, i],
            "proposed": values[:, 0], "checked": regimes,
        }  # fmt: skip
        table |= {f"{kind}_{name}_{side}": on_side[kind] for kind in ON_SIDES}
    return table


def _joint(search: Search, reaches: Sequence[Reach], best: Cheapest, question: Question) -> Results:
    """Return what is said of the cheapest joint change."""
    found = {"joint_cost": np.where(np.isfinite(best.cost), best.cost, NAN)}
    everywhere = np.arange(best.cost.size)
    known = np.isfinite(best.cost)
    for i, reach in enumerate(reaches):
        values = reach.at(np.nan_to_num(best.changes[:, i]), everywhere)
        found[f"joint_{reach.name}"] = np.where(known, values, NAN)
        cost = question.of_each[i] * best.changes[:, i]
        found[f"joint_share_{reach.name}"] = np.where(known, (cost / best.cost) ** 2, NAN)
    regimes, values = _checked(search, reaches, best.changes, question.beyond)
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


def _attributes(question: Question, table: Mapping[str, NDArray[Any]], options: Options) -> dict[str, str | float]:
    """Return what was done and what it cannot see, as global attributes."""
    open_cells = int(np.count_nonzero(~decided(table["regime"])))
    none = [name for name in question.parameters if np.isnan(table[f"margin_{name}"]).all()]
    within = within_of(question.within, question.parameters)
    attributes: dict[str, str | float] = {
        "margin_within": _all_spelled(within),
        "margin_into": ", ".join(question.into) if question.into else "any other regime",
        "margin_scan": f"{question.scan} places on either side, evenly spaced in the change: what begins and ends "
        "between two of them can be missed",
        "margin_tolerance": question.tolerance,
        "margin_rtol": options.rtol,
        "margin_check": f"proposals were simulated {100 * question.beyond:g} % past the border",
        "margin_found": f"no border within reach along {', '.join(none)}" if none else "a border along each parameter",
    }
    if question.speeds:
        low, *_, high = question.speeds
        attributes["margin_speeds"] = f"the worst of {len(question.speeds)} belt speeds from {low:g} to {high:g} m/s"
    if open_cells:
        attributes["margin_undecided"] = f"{open_cells} cells are unresolved or failed and have no margin"
    if question.joint:
        costs = ", ".join(f"{name}: {cost:g}" for name, cost in zip(question.parameters, question.of_each, strict=True))
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
