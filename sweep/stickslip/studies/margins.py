"""Margins of many cells: each parameter by itself, then all of them together, and every proposal simulated."""

from __future__ import annotations

from collections.abc import Collection, Iterator, Mapping, Sequence
from dataclasses import replace
from math import isfinite
from typing import Annotated, Any

import numpy as np
import xarray as xr
from pydantic import Field, ValidationInfo, field_validator

from stickslip.config.grid import build_grid
from stickslip.config.model import Config
from stickslip.config.problems import ProblemCollector
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
from stickslip.config.studies import Moved, Regime, ReportTable, Study, search_attributes, search_settings
from stickslip.dataset import build
from stickslip.dataset.display import unit_of
from stickslip.engine import Options, Results, StopFlag, joined
from stickslip.errors import ArgumentError
from stickslip.studies.changes import (
    OPPOSITE,
    Borders,
    MarginSearch,
    Reach,
    cheapest,
    checked,
    entered,
    misfit,
    nearest,
    reach_of,
)
from stickslip.studies.lines import PARAMETER, CellsOrConfig, fine_enough, limits, search_options
from stickslip.vocabulary.cells import Cells, Parameters
from stickslip.vocabulary.models import MODELS, model_of
from stickslip.vocabulary.parameter import NAN, Parameter, Variable, table
from stickslip.vocabulary.quantities import DECIDED, MEASURED, PARAMETERS, REGIMES, SEARCHABLE, listed
from stickslip.vocabulary.quantities import VARIABLES as CELL_VARIABLES

SIDES, _SIDE = ("below", "above"), ("side",)
# Of cells, most of them once per parameter: `margin_stiffness`.
VARIABLES = table(
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
_OF_CELL = ("joint_cost", "joint_checked", "joint_ended")  # not of single parameters
COST = Parameter("cost", "1", "cost of changing a parameter by a factor", "margins", above=0)
FACTOR = Parameter("within", "1", "factor up to which parameters are changed", "margins", default=10.0, above=1)
_FACTOR: Schema = {"type": "number", "exclusiveMinimum": 1}


def _per_parameter(of_each: Schema) -> Schema:
    return {"type": "object", "propertyNames": {"enum": list(PARAMETERS)}, "additionalProperties": of_each}


_SPEED = replace(PARAMETERS["belt_speed"], above=0)
_SPEEDS = 9  # looked at in a range of belt speeds


def rows_of(section: Margins) -> dict[str, Variable]:
    """The variables of a result, of a section of which `of_cells` is known: of the cell, and of each parameter."""
    rows = {"regime": CELL_VARIABLES["regime"]}
    for name, row in VARIABLES.items():
        row = replace(row, name="regime", units="1") if row.units == "flag" else row
        if not section.joint and name.startswith("joint"):
            continue
        rows |= {name: row} if name in _OF_CELL else {}
        rows |= {f"{name}_{p}": build.of_parameter(row, p) for p in section.reaches if name not in _OF_CELL}
    return rows


class Margins(StudySection):
    """Distances of each cell from a border, along single parameters, and by the cheapest change of several."""

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
        tuple[Annotated[str, PARAMETER], ...] | None, list_of(PARAMETERS, "a list of different parameters", unique=True)
    ] = Field(None, description="parameters that may change; all that a designer chooses unless given")
    costs: dict[str, float] = Field(
        {},
        description="by parameter, what changing it by a factor costs relative to the others; 1 unless given",
        json_schema_extra=_per_parameter(number_schema(COST)),
    )
    within: dict[str, float | tuple[float, float]] | float = Field(
        float(FACTOR.default or 0),
        description="how far to look: a factor, or by parameter a factor or both ends of a range",
        json_schema_extra={"anyOf": [_FACTOR, _per_parameter({"anyOf": [_FACTOR, RANGE]})]},
    )
    into: Annotated[tuple[Annotated[str, one_of((*DECIDED, OPPOSITE), "a regime")], ...] | None,
                    list_of((*DECIDED, OPPOSITE), "a list of regimes")] = Field(
        None, description="regimes that count, opposite for quiet ones of what vibrates and the reverse; any other "
        "unless given"
    )  # fmt: skip
    speed_range: Annotated[tuple[float, float] | None, Read(lambda value: interval(_SPEED, value), RANGE)] = Field(
        None,
        description=f"both ends of a range of belt speeds, of {_SPEEDS} of which the worst counts; that of the cell "
        "unless given",
    )
    joint: Annotated[bool, BOOLEAN] = Field(
        False, description="whether the cheapest joint change is looked for, which takes a second per cell, rarely more"
    )
    scan: int = of_row(rows["scan"])
    tolerance: float = of_row(rows["tolerance"])  # None until `fine_enough`
    beyond: float = of_row(rows["beyond"])
    rtol: float | None = of_row(rows["rtol"])

    @field_validator("parameters")
    @classmethod
    def _one_form(cls, value: tuple[str, ...] | None) -> tuple[str, ...] | None:
        for model in MODELS:
            if set(model.measured) & set(value or ()) and set(model.replaced) & set(value or ()):
                forms = (listed(form, "and") for form in (model.measured, model.replaced))
                raise refused(f"one form of the curve: {', or '.join(forms)}")
        return value

    @field_validator("costs", "within", mode="before")
    @classmethod
    def _by_parameter(cls, value: object, info: ValidationInfo) -> object:
        row = COST if info.field_name == "costs" else FACTOR
        if not isinstance(value, Mapping) and row is COST:
            raise refused("a mapping of parameters to numbers")
        if not isinstance(value, Mapping):
            return number(FACTOR, value)
        known: Collection[str] = info.data.get("parameters") or SEARCHABLE
        names = [choice(name, known, "a parameter that may change", inside=True) for name in value]
        return {
            name: interval(SEARCHABLE[name], inner) if row is FACTOR and isinstance(inner, list | tuple)
            else number(row, inner) for name, inner in zip(names, value.values(), strict=True)
        }  # fmt: skip

    @field_validator("speed_range")
    @classmethod
    def _no_speed(cls, value: tuple[float, float] | None, info: ValidationInfo) -> tuple[float, float] | None:
        if value is not None and "belt_speed" in (info.data.get("parameters") or ()):
            raise refused("none beside the parameter belt_speed, which is what the range of speeds is about")
        return value

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
            own = [name for name in _CHANGEABLE if name in cells and not (self.speed_range and name == "belt_speed")]
            names = tuple(name for name in own if name not in _IF_GIVEN or not np.isnan(cells[name]).all())
        within = self.within if isinstance(self.within, dict) else dict.fromkeys(names, self.within)
        for key, given in (("costs", self.costs), ("within", within)):
            if unknown := [name for name in given if name not in names]:
                raise ArgumentError(key, f"got one for {unknown[0]!r}, expected {', '.join(names)}")
        reaches = {name: within.get(name, FACTOR.default) for name in names}
        return self.model_copy(update={"parameters": names, "within": reaches})

    @property
    def reaches(self) -> dict[str, float | tuple[float, float]]:
        """Reach of each parameter, of a section of which `of_cells` is known."""
        assert isinstance(self.within, dict)
        return self.within


_IF_GIVEN = ("mu_stop", "mu_static")  # changed where a cell has them
_CHANGEABLE = ("belt_speed", "stiffness", "damping", "normal_load", "mass", *_IF_GIVEN)

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
        if why := misfit(section.reaches, options):
            raise ArgumentError("parameters", why)
        each = 2 * (section.scan + int(-np.log2(section.tolerance))) * len(section.reaches)
        self.cells_each = (each + _OF_JOINT_CHANGE * section.joint) * max(len(section.speeds), 1)
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
        if why := misfit(section.parameters or (), Options(config.friction.law)):
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
        cells = self._parameters(items.start, items.stop)
        whole = _margins(MarginSearch(cells, self.options, stop, self._section.speeds, moved), self._section)
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


def _distances(ds: xr.Dataset, name: str) -> list[str]:
    """A row of the table of parameters."""
    ratio, margin = (ds[f"{what}_{name}"].values.ravel() for what in ("ratio", "margin"))
    by_factor = bool(np.isfinite(ratio).any())
    sizes = np.sort(np.exp(np.abs(np.log(ratio[ratio > 0]))) if by_factor else np.abs(margin[~np.isnan(margin)]))
    three = [f"{'x ' * by_factor}{size:.3g}" for size in sizes[[0, sizes.size // 2, -1]]] if sizes.size else "---"
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
        rows = [
            (name, *(unit_of(cell[name]).text(float(cell[key]), _DIGITS) for key in (name, f"joint_proposed_{name}")),
             f"{shares[name]:.3g} %") for name in parameters if shares[name] >= _LEAST_SHARE
        ]  # fmt: skip
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


def _simulated(past: xr.DataArray, goals: Sequence[str]) -> str:
    """The regime past a border; a change that does not hold there is no cure."""
    regime = REGIMES[int(past)]
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
        cost, changes, ended = cheapest(search, reaches, costs, home, into, section.scan, tolerance, cheapest_single)
        regimes, proposed = checked(search, reaches, changes, section.beyond)
        columns |= {"joint_cost": cost, "joint_checked": regimes, "joint_ended": ended}
        for i, reach in enumerate(reaches):
            values = reach.at(np.nan_to_num(changes[:, i]), np.arange(size))
            columns[f"joint_{reach.name}"] = np.where(np.isnan(cost), NAN, values)
            columns[f"joint_share_{reach.name}"] = (costs[i] * changes[:, i] / cost) ** 2
            columns[f"joint_proposed_{reach.name}"] = proposed[:, i]
    return columns


def _single(search: MarginSearch, reach: Reach, borders: Borders, section: Margins) -> Results:
    """The columns of one parameter: both borders, the nearer of them as distance and as factor, and the checks."""
    nearer = np.argmin(np.where(np.isnan(borders.change), np.inf, np.abs(borders.change)), axis=1)
    border = borders.border[np.arange(reach.value.size), nearer]
    with np.errstate(divide="ignore", invalid="ignore"):
        ratio = np.where(reach.by_factor, border / reach.value, NAN)
    sides = [checked(search, [reach], borders.change[:, [i]], section.beyond) for i in range(len(SIDES))]
    columns = {
        "margin": border - reach.value, "ratio": ratio,
        "border": borders.border, "border_width": borders.high - borders.low, "beyond": borders.beyond,
        "proposed": np.concatenate([values for _, values in sides], axis=1),
        "checked": np.stack([regimes for regimes, _ in sides], axis=1),
    }  # fmt: skip
    return {f"{name}_{reach.name}": values for name, values in columns.items()}
