"""What may be changed of a cell, and how far: the section `margins`, the variables of its result, and the measure.

A change is the logarithm of the ratio to the value that the cell has; where that is 0, or where a parameter may change
its sign (the starting state), it is the difference over a scale of the cell.
"""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Annotated, Any

import numpy as np
from pydantic import Field, ValidationInfo, field_validator

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
from stickslip.dataset.build import of_parameter
from stickslip.engine import Scales
from stickslip.errors import ArgumentError
from stickslip.studies.lines import PARAMETER, limits
from stickslip.studies.search import Flags, Floats, Integers
from stickslip.vocabulary.cells import Parameters
from stickslip.vocabulary.models import MODELS, model_with
from stickslip.vocabulary.parameter import Parameter, Variable, table
from stickslip.vocabulary.quantities import PARAMETERS, SEARCHABLE, listed
from stickslip.vocabulary.results import DECIDED, VIBRATING
from stickslip.vocabulary.results import VARIABLES as CELL_VARIABLES

SIDES = ("below", "above")
OPPOSITE = "opposite"  # regimes, in a list of those to be entered: quiet ones of what vibrates, else vibrating ones
_QUIET = tuple(name for name in DECIDED if name not in VIBRATING)
_SIDE = ("side",)
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
_CHANGED: Schema = {"enum": list(PARAMETERS)}
_FACTOR: Schema = {"type": "number", "exclusiveMinimum": 1}
_REACHES: Schema = {
    "type": "object", "propertyNames": _CHANGED, "additionalProperties": {"anyOf": [_FACTOR, RANGE]},
}  # fmt: skip
_COSTS: Schema = {"type": "object", "propertyNames": _CHANGED, "additionalProperties": number_schema(COST)}
_SPEED = replace(PARAMETERS["belt_speed"], above=0)
_SPEEDS = 9  # looked at in a range of belt speeds


def entered(into: Sequence[str] | None, home: str) -> tuple[str, ...]:
    """The regimes, by name, that a cell is to enter. home : its own. into : as in the section."""
    if into is None:
        return tuple(name for name in DECIDED if name != home)
    other_kind = _QUIET if home in VIBRATING else VIBRATING
    return tuple(dict.fromkeys(name for wanted in into for name in (other_kind if wanted == OPPOSITE else (wanted,))))


def rows_of(section: Margins) -> dict[str, Variable]:
    """The variables of a result, of a section of which `of_cells` is known: of the cell, and of each parameter."""
    rows = {"regime": CELL_VARIABLES["regime"]}
    for name, row in VARIABLES.items():
        row = replace(row, name="regime", units="1") if row.units == "flag" else row
        if section.joint or not name.startswith("joint"):
            rows |= {name: row} if name in _OF_CELL else {f"{name}_{p}": of_parameter(row, p) for p in section.reaches}
    return rows


def _by_parameter(value: object, info: ValidationInfo) -> dict[str, Any]:
    """A mapping whose keys are among the parameters that may change."""
    if not isinstance(value, Mapping):
        raise refused("a mapping of parameters to numbers")
    known: Collection[str] = info.data.get("parameters") or SEARCHABLE
    return {choice(name, known, "a parameter that may change", inside=True): inner for name, inner in value.items()}


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
        json_schema_extra=_COSTS,
    )
    within: dict[str, float | tuple[float, float]] | float = Field(
        float(FACTOR.default or 0),
        description="how far to look: a factor, or by parameter a factor or both ends of a range",
        json_schema_extra={"anyOf": [_FACTOR, _REACHES]},
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


_CHANGEABLE = ("belt_speed", "stiffness", "damping", "normal_load", "mass", "mu_stop", "mu_static")
_IF_GIVEN = ("mu_stop", "mu_static")  # changed where a cell has them
_SIGNED = ("displacement", "velocity")  # changed by amounts, not by factors


@dataclass(frozen=True, eq=False)
class Reach:
    """One parameter in n cells: its value, how far down and up it may go, all in SI and (n,).

    by_factor : whether changes are logarithms of ratios. scale : what other changes are divided by. A value of NaN
    means that the cell does not have this parameter.
    """

    name: str
    value: Floats
    low: Floats
    high: Floats
    by_factor: Flags
    scale: Floats

    def at(self, change: Floats, cells: Integers) -> Floats:
        """Values after changes, one for each of `cells`, no further than the reach."""
        value = self.value[cells]
        with np.errstate(over="ignore"):
            changed = np.where(self.by_factor[cells], value * np.exp(change), value + change * self.scale[cells])
        return np.where(change == 0.0, value, np.clip(changed, self.low[cells], self.high[cells]))

    def change(self, value: Floats) -> Floats:
        """The changes (n,) that lead to values."""
        with np.errstate(divide="ignore", invalid="ignore"):
            return np.where(self.by_factor, np.log(value / self.value), (value - self.value) / self.scale)

    @property
    def room(self) -> tuple[Floats, Floats]:
        """The largest change against and with the sign of the value, both at least 0; 0 where there is no value."""
        ends = self.change(self.low), self.change(self.high)
        down, up = np.minimum(*ends), np.maximum(*ends)
        return np.nan_to_num(np.maximum(-down, 0.0)), np.nan_to_num(np.maximum(up, 0.0))


def reach_of(name: str, cells: Parameters, within: float | tuple[float, float]) -> Reach:
    """Return how far a parameter may be changed: within a factor or a range, and within what is possible."""
    model, by = model_with(cells), Scales(cells)
    value = np.where(np.isinf(cells[name]), np.nan, cells[name].astype(np.float64))
    if name == model.static:  # where it is not given it is that at break-away
        value = np.where(np.isnan(value), model.start_of(cells), value)
    scale = 2.0 * by.impedance if name == "damping" else model.change_scale(name, cells, by)
    scale = np.broadcast_to(scale, value.shape).astype(np.float64)
    by_factor = (value != 0) & ~np.isnan(value) & (name not in _SIGNED)
    if isinstance(within, tuple):
        low, high = (np.full_like(value, end) for end in within)
        low, high = np.minimum(low, value), np.maximum(high, value)
        low = np.where(by_factor & (value > 0), np.maximum(low, np.minimum(value, 1e-12 * np.abs(high))), low)
        high = np.where(by_factor & (value < 0), np.minimum(high, np.maximum(value, -1e-12 * np.abs(low))), high)
    else:
        ends = np.where(by_factor, value / within, value - scale), np.where(by_factor, value * within, value + scale)
        low, high = np.minimum(*ends), np.maximum(*ends)
    row, like = SEARCHABLE[name], np.ones_like(cells["mass"])
    bounds = -np.inf if row.at_least is None else row.at_least, np.inf if row.at_most is None else row.at_most
    least, most = model.within(name, cells, *(like * bound for bound in bounds))  # beside the others of the cell
    return Reach(name, value, np.minimum(np.maximum(low, least), value), np.maximum(np.minimum(high, most), value),
                 by_factor, scale)  # fmt: skip
