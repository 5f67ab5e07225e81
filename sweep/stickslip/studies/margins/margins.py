"""Margins of many cells: each parameter by itself, then all of them together, and every proposal simulated."""

from __future__ import annotations

from collections.abc import Collection, Iterator, Mapping, Sequence
from dataclasses import replace
from typing import Annotated, Any

import numpy as np
import xarray as xr
from numpy.typing import NDArray
from pydantic import Field, ValidationInfo, field_validator

from stickslip.config.grid import build_grid
from stickslip.config.model import Config
from stickslip.config.sections import (
    BOOLEAN,
    RANGE,
    Read,
    Schema,
    StudySection,
    choice,
    interval,
    list_of,
    number,
    number_schema,
    of_row,
    one_of,
    refused,
)
from stickslip.config.studies import Finished, Moved, Study
from stickslip.dataset.build import grid_coordinates, of_parameter, parameter_variable, study_dataset, text_index
from stickslip.dataset.given import given_cells
from stickslip.engine import Options, Results, StopFlag
from stickslip.errors import ArgumentError, StoppedError
from stickslip.studies.borders.lines import PARAMETER, CellsOrConfig, fine_enough, limits
from stickslip.studies.margins.joint import MOST_STEPS, Cheapest, cheapest
from stickslip.studies.margins.reach import Reach, parameters_of, reach_of, with_measured
from stickslip.studies.margins.single import Borders, Floats, Labels, Search, decided, nearest
from stickslip.studies.study import joined
from stickslip.vocabulary.cells import Cells, Parameters
from stickslip.vocabulary.flags import DECIDED, REGIMES
from stickslip.vocabulary.parameter import NAN, Parameter
from stickslip.vocabulary.quantities import MEASURED, PARAMETERS, REPLACED, SEARCHABLE
from stickslip.vocabulary.results import VARIABLES, Variable, by_name
from stickslip.vocabulary.suggest import listed

_TOGETHER = 512  # cells whose rays are held at once
_OF_JOINT_CHANGE = 20_000  # cells a joint change takes, about
_LANES_FED = 8  # blocks of so many times more cells than their work calls for: rounds have few cells each
_MOST_WEIGHT = 256  # no block has fewer than 16 cells, for the same reason
_OF_JOINT = 1e-8  # tolerance of joint changes, whose cost is known no better


SIDES = ("below", "above")
_SIDE = ("side",)
# Of cells, most of them once per parameter: `margin_stiffness`.
_VARIABLES = by_name(
    Variable("margin", "parameter", "distance to the nearest border", comment="border minus value, with its sign"),
    Variable("ratio", "1", "nearest border over the value", comment="NaN where the value is 0 or may change its sign"),
    Variable("border", "parameter", "nearest border on either side", dims=_SIDE),
    Variable("border_width", "parameter", "width of the last bracket of the border", dims=_SIDE),
    Variable("beyond", "flag", "regime just past the border", dims=_SIDE),
    Variable("proposed", "parameter", "value past the border that was simulated", dims=_SIDE),
    Variable("checked", "flag", "regime of the simulation past the border", dims=_SIDE),
    Variable("joint_cost", "1", "cost of the cheapest joint change", comment="root of the sum of (cost x change)^2; "
             "changes are logarithms of ratios, or over a scale where the value is 0 or may change its sign"),
    Variable("joint", "parameter", "value after the cheapest joint change"),
    Variable("joint_share", "1", "share of the change in the square of the cost of the cheapest joint change"),
    Variable("joint_proposed", "parameter", "value past the border that was simulated, of the cheapest joint change"),
    Variable("joint_checked", "flag", "regime of the simulation past the border, of the cheapest joint change"),
    Variable("joint_ended", "1", "whether the search of the joint change ended at its limit, 1 or 0",
             comment="1: after so many steps of integration that there may be a cheaper joint change"),
)  # fmt: skip
_ON_SIDES = {name: row.units == "flag" for name, row in _VARIABLES.items() if row.dims}  # flags: True
COST = Parameter("cost", "1", "cost of changing a parameter by a factor", "margins", above=0)
FACTOR = Parameter("within", "1", "factor up to which parameters are changed", "margins", default=10.0, above=1)
_CHANGED: Schema = {"enum": list(PARAMETERS)}
_FACTOR: Schema = {"type": "number", "exclusiveMinimum": 1}
_REACHES: Schema = {
    "type": "object", "propertyNames": _CHANGED, "additionalProperties": {"anyOf": [_FACTOR, RANGE]},
}  # fmt: skip
_COSTS: Schema = {"type": "object", "propertyNames": _CHANGED, "additionalProperties": number_schema(COST)}
_SPEED = replace(PARAMETERS["belt_speed"], above=0)
_SPEEDS = 9  # looked at in a range of belt speeds


def _by_parameter(value: object, info: ValidationInfo) -> dict[str, Any]:
    """A mapping whose keys are among the parameters that may change."""
    if not isinstance(value, Mapping):
        raise refused("a mapping of parameters to numbers")
    known: Collection[str] = info.data.get("parameters") or SEARCHABLE
    return {choice(name, known, "a parameter that may change", inside=True): inner for name, inner in value.items()}


class Margins(StudySection):
    """How far each cell is from a border along single parameters, and by the cheapest change of several."""

    key = "margins"
    rows = limits(
        key,
        "a border",
        Parameter("scan", "1", "places on either side of a cell that are looked at first", key,
                  default=32, at_least=2, at_most=65_536, whole=True),
        Parameter("beyond", "1", "how far past a border each proposal is simulated, over the value", key,
                  default=0.01, at_least=0.0, at_most=0.5),
    )  # fmt: skip
    parameters: Annotated[
        tuple[Annotated[str, PARAMETER], ...] | None,
        list_of(PARAMETERS, "a list of different parameters", unique=True),
    ] = Field(None, description="parameters that may change; all that a designer chooses unless given")
    costs: dict[str, float] = Field(
        {},
        description="by parameter, what changing it by a factor costs relative to the others; 1 unless given",
        json_schema_extra=_COSTS,
    )
    within: dict[str, float | tuple[float, float]] | float = Field(
        float(FACTOR.default or 0),
        description="how far to look: a factor, or by parameter a factor or both ends of a range",
        json_schema_extra={"anyOf": [_FACTOR, _REACHES]},
    )
    into: Annotated[tuple[Annotated[str, one_of(DECIDED, "a regime")], ...] | None,
                    list_of(DECIDED, "a list of regimes")] = Field(
        None, description="regimes that count; any other unless given"
    )  # fmt: skip
    speed_range: Annotated[tuple[float, float] | None, Read(lambda value: interval(_SPEED, value), RANGE)] = Field(
        None,
        description=f"both ends of a range of belt speeds, of {_SPEEDS} of which the worst counts; that of the cell "
        "unless given",
    )
    joint: Annotated[bool, BOOLEAN] = Field(
        False,
        description="whether the cheapest joint change is looked for, which takes a second per cell, rarely more",
    )
    scan: int = of_row(rows["scan"])
    tolerance: float = of_row(rows["tolerance"])
    beyond: float = of_row(rows["beyond"])
    rtol: float | None = of_row(rows["rtol"])

    @field_validator("parameters")
    @classmethod
    def _one_form(cls, value: tuple[str, ...] | None) -> tuple[str, ...] | None:
        if value and set(MEASURED) & set(value) and set(REPLACED) & set(value):
            raise refused(f"one form of the curve: {listed(MEASURED, 'and')}, or {listed(REPLACED, 'and')}")
        return value

    @field_validator("costs", mode="before")
    @classmethod
    def _costs(cls, value: object, info: ValidationInfo) -> object:
        return {name: number(COST, cost) for name, cost in _by_parameter(value, info).items()}

    @field_validator("within", mode="before")
    @classmethod
    def _within(cls, value: object, info: ValidationInfo) -> object:
        if not isinstance(value, Mapping):
            return number(FACTOR, value)
        return {
            name: interval(SEARCHABLE[name], reach) if isinstance(reach, list | tuple) else number(FACTOR, reach)
            for name, reach in _by_parameter(value, info).items()
        }

    @field_validator("speed_range")
    @classmethod
    def _no_speed(cls, value: tuple[float, float] | None, info: ValidationInfo) -> tuple[float, float] | None:
        if value is not None and "belt_speed" in (info.data.get("parameters") or ()):
            raise refused("none beside the parameter belt_speed, which is what the range of speeds is about")
        return value

    @property
    def of_each(self) -> Floats:
        """The cost of each parameter."""
        return np.array([self.costs.get(name, 1.0) for name in self.reaches])

    @property
    def speeds(self) -> tuple[float, ...]:
        """The belt speeds (m/s) of the range, by equal ratios, both ends among them; none for that of the cell."""
        return () if self.speed_range is None else tuple(map(float, np.geomspace(*self.speed_range, _SPEEDS)))

    def of_cells(self, cells: Parameters) -> Margins:
        """The section with its parameters named, those that cells have, and how far each may go.

        Raises ArgumentError for costs and reaches of others.
        """
        names = self.parameters
        if names is None:
            names = tuple(name for name in parameters_of(cells) if not (self.speed_range and name == "belt_speed"))
        within = self.within if isinstance(self.within, dict) else dict.fromkeys(names, self.within)
        for key, given in (("costs", self.costs), ("within", within)):
            if unknown := [name for name in given if name not in names]:
                raise ArgumentError(key, f"got one for {unknown[0]!r}, expected {', '.join(names)}")
        reaches = {name: within.get(name, FACTOR.default) for name in names}
        return self.model_copy(update={"parameters": names, "within": reaches})

    @property
    def reaches(self) -> dict[str, float | tuple[float, float]]:
        """How far each parameter may go, of a section of which `of_cells` is known."""
        assert isinstance(self.within, dict)
        return self.within


class MarginStudy(Study):
    """The margins of cells, its items."""

    section, variables, title = Margins, _VARIABLES, "Margins"
    name, counted = "margins", "cells"

    def __init__(self, cells: Cells, section: Margins, options: Options) -> None:
        self._cells, self._section = cells, section
        self.dims, self.shape = cells.dims, cells.shape
        self.options = replace(options, early_stop=True)
        self._measured = bool(set(MEASURED) & set(section.reaches))
        if self._measured and options.law != "stribeck":
            form = ", ".join(MEASURED)
            raise ArgumentError("parameters", f"the form of {form} is for the law stribeck, not {options.law}")
        speeds = max(len(section.speeds), 1)
        each = 2 * speeds * (section.scan + int(-np.log2(section.tolerance))) * len(section.reaches)
        self.cells_each = each + (_OF_JOINT_CHANGE * speeds if section.joint else 0)
        self.weight = min(max(self.cells_each // _LANES_FED, 1), _MOST_WEIGHT)
        self.columns = {name: np.dtype(np.int8 if flag else np.float64) for name, flag in _columns(section)}

    @classmethod
    def of(cls, given: CellsOrConfig, section: Margins, options: Options) -> MarginStudy:
        """The margins of the cells of a configuration, or of those that are listed."""
        if isinstance(given, Config) and given.drive is not None:
            raise ValueError("a configuration with a drive is that of a rig, whose cells have no regime")
        if isinstance(given, Config) and given.uncertain is not None:
            raise ValueError("a configuration with uncertain quantities has no single margin; leave uncertain out")
        options = fine_enough(section, options)
        cells = build_grid(given) if isinstance(given, Config) else given_cells(given, options.law)
        return cls(cells, section.of_cells(cells[:]), options)

    @classmethod
    def explain(cls, section: Margins, config: Config) -> Iterator[tuple[str, str, str]]:
        """The parameters that may change."""
        along = ", ".join(section.parameters or ("what a designer chooses",))
        yield "margins along", along, "with the cheapest joint change" if section.joint else "one by one"

    @property
    def action(self) -> str:
        """What is done, for the history."""
        return f"margins along {', '.join(self._section.reaches)}"

    def compute(self, items: range, stop: StopFlag, moved: Moved | None = None) -> Finished:
        """The margins of a range of cells."""
        parts = []
        for start in range(items.start, items.stop, _TOGETHER):
            cells = self._parameters(start, min(start + _TOGETHER, items.stop))
            try:
                parts.append(_margins(Search(cells, self.options, stop, self._section.speeds, moved), self._section))
            except StoppedError:
                return Finished({}, False)
        whole = joined(parts) if parts else self.blank(items)
        return Finished({name: whole[name].astype(dtype) for name, dtype in self.columns.items()})

    def _parameters(self, start: int, stop: int) -> Parameters:
        """Cells, with what is measured of their curves where that is to change."""
        cells = self._cells[start:stop]
        return with_measured(cells) if self._measured else cells

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
        flags = {name: replace(row, name="regime", units="1") if row.units == "flag" else row
                 for name, row in _VARIABLES.items()}  # fmt: skip
        rows = {"regime": VARIABLES["regime"]} | flags
        rows |= {f"{name}_{p}": of_parameter(row, p) for name, row in flags.items() for p in self._section.reaches}
        both = {f"{kind}_{p}": np.stack([whole[f"{kind}_{p}_{side}"] for side in SIDES], axis=-1)
                for p in self._section.reaches for kind in _ON_SIDES}  # fmt: skip
        values = {name: array for name, array in whole.items() if name in rows and name not in both} | both
        coordinates["side"] = text_index("side", SIDES, "side of the value on which the border lies")
        attributes = dict(attributes) | _attributes(self._section, whole, self.options)
        return study_dataset("margins", rows, values, self.dims, self.shape, coordinates, attributes)


def _columns(section: Margins) -> Iterator[tuple[str, bool]]:
    """Names of the columns, and whether they are flags."""
    yield "regime", True
    for name in section.reaches:
        yield from ((f"margin_{name}", False), (f"ratio_{name}", False))
        for side in SIDES:
            yield from ((f"{kind}_{name}_{side}", flag) for kind, flag in _ON_SIDES.items())
    if section.joint:
        yield from (("joint_cost", False), ("joint_checked", True), ("joint_ended", True))
        for name in section.reaches:
            yield from ((f"joint{kind}_{name}", False) for kind in ("", "_share", "_proposed"))


def _margins(search: Search, section: Margins) -> Results:
    """The columns of some cells. Raises StoppedError."""
    cells, size = search.cells, search.steps.size
    home = search.regimes(np.arange(size), {})
    into = None if section.into is None else [REGIMES.index(name) for name in section.into]
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
    middle = found.low + (found.high - found.low) / 2
    nearer = np.argmin(np.where(np.isnan(found.change), np.inf, np.abs(found.change)), axis=1)
    border = middle[np.arange(size), nearer]
    with np.errstate(divide="ignore", invalid="ignore"):
        ratio = np.where(reach.by_factor, border / reach.value, NAN)
    name = reach.name
    table = {f"margin_{name}": border - reach.value, f"ratio_{name}": ratio}
    for i, side in enumerate(SIDES):
        regimes, values = _checked(search, [reach], found.change[:, [i]], section.beyond)
        on_side = {
            "border": middle[:, i], "border_width": found.high[:, i] - found.low[:, i], "beyond": found.beyond[:, i],
            "proposed": values[:, 0], "checked": regimes,
        }  # fmt: skip
        table |= {f"{kind}_{name}_{side}": on_side[kind] for kind in _ON_SIDES}
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
