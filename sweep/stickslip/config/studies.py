"""The sections that ask for something else than a map. A configuration has at most one of them."""

from __future__ import annotations

import math
from collections.abc import Collection, Mapping
from typing import Annotated, Any

from pydantic import BeforeValidator, Field, ValidationInfo, field_validator

from stickslip.config.sections import (
    BOOLEAN,
    RANGE,
    Read,
    Schema,
    Section,
    choice,
    finite,
    interval,
    list_of,
    number,
    number_schema,
    of_row,
    one_of,
    refused,
)
from stickslip.config.uncertain import Uncertain
from stickslip.vocabulary.flags import DECIDED
from stickslip.vocabulary.quantities import PARAMETERS, QUANTITIES, SEARCHABLE
from stickslip.vocabulary.settings import (
    ATTRACTORS,
    BORDER,
    CONTOURS,
    COST,
    FACTOR,
    MARGINS,
    RANDOMISATIONS,
    REFINE,
)

Reach = float | tuple[float, float]
_PARAMETER = one_of(SEARCHABLE, "a parameter of a cell")
_CHANGED: Schema = {"enum": list(PARAMETERS)}
_FACTOR: Schema = {"type": "number", "exclusiveMinimum": 1}
_REACHES: Schema = {
    "type": "object", "propertyNames": _CHANGED, "additionalProperties": {"anyOf": [_FACTOR, RANGE]},
}  # fmt: skip
_COSTS: Schema = {"type": "object", "propertyNames": _CHANGED, "additionalProperties": number_schema(COST)}


def _two_axes(value: Any) -> Any:
    if not isinstance(value, list | tuple) or len(value) != 2 or value[0] == value[1]:
        raise refused("a list of two different parameters, y and x")
    return value


def _ranges(value: object) -> object:
    """Ranges by parameter."""
    if not isinstance(value, Mapping):
        raise refused("a range for each of the two parameters: {belt_speed: [0.1, 1]}")
    names = [choice(name, SEARCHABLE, "a parameter of a cell", inside=True) for name in value]
    return {name: interval(QUANTITIES[name], value[name]) for name in names}


def _end(value: object, info: ValidationInfo) -> float:
    """One end of a range of the parameter `along`, unless that is refused already."""
    return finite(QUANTITIES[info.data["along"]], value) if "along" in info.data else math.nan


class Border(Section):
    """Where along a parameter the regime changes; the other axes are the lines that are searched."""

    rows = BORDER
    along: Annotated[str, _PARAMETER] = Field(description="parameter of a cell to search along")
    between: tuple[Annotated[float, BeforeValidator(_end)], Annotated[float, BeforeValidator(_end)]] | None = Field(
        None,
        description="both ends of the range to search, the lower one first; those of the axis unless given",
        json_schema_extra=RANGE,
    )
    tolerance: float = of_row(BORDER["tolerance"])
    scan: int = of_row(BORDER["scan"])
    rtol: float | None = of_row(BORDER["rtol"])

    @field_validator("between", mode="before")
    @classmethod
    def _between(cls, value: object) -> object:
        if not isinstance(value, list | tuple) or len(value) != 2:
            raise refused("a list of two values, the lower end first")
        return value

    @field_validator("between")
    @classmethod
    def _order(cls, value: tuple[float, float] | None) -> tuple[float, float] | None:
        if value is not None and not value[0] < value[1] and not math.isnan(value[0]):
            hint = "swap the ends" if value[0] > value[1] else None
            raise refused("the lower end first and the upper above it", hint)
        return value


class Refine(Section):
    """A map of which cells are computed only where regimes meet, and at few points elsewhere."""

    rows = REFINE
    depth: int = of_row(REFINE["depth"])
    audit: float = of_row(REFINE["audit"])
    interpolate: Annotated[bool, BOOLEAN] = Field(
        False, description="whether cells that are not computed get metrics between others"
    )


class Contours(Section):
    """Where in planes of two parameters the regime changes, as lines; the other axes are the panels."""

    rows = CONTOURS
    axes: Annotated[
        tuple[Annotated[str, _PARAMETER], Annotated[str, _PARAMETER]] | None,
        Read(_two_axes, {"type": "array", "minItems": 2, "maxItems": 2, "uniqueItems": True,
                         "items": _PARAMETER.schema}),
    ] = Field(None, description="the two parameters, y and x; the last two axes unless given")  # fmt: skip
    between: Annotated[
        dict[str, tuple[float, float]] | None,
        Read(_ranges, {"type": "object", "propertyNames": _PARAMETER.schema, "additionalProperties": RANGE}),
    ] = Field(
        None, description="by parameter, both ends of its range, the lower one first; those of its axis unless given"
    )
    points: int = of_row(CONTOURS["points"])
    tolerance: float = of_row(CONTOURS["tolerance"])
    scan: int = of_row(CONTOURS["scan"])
    rtol: float | None = of_row(CONTOURS["rtol"])


class Margins(Section):
    """How far each cell is from a border along single parameters, and by the cheapest change of several."""

    rows = MARGINS
    parameters: Annotated[
        tuple[Annotated[str, _PARAMETER], ...] | None,
        list_of(PARAMETERS, "a list of different parameters", unique=True),
    ] = Field(None, description="parameters that may change; all that a designer chooses unless given")
    costs: dict[str, float] = Field(
        {},
        description="by parameter, what changing it by a factor costs relative to the others; 1 unless given",
        json_schema_extra=_COSTS,
    )
    within: dict[str, Reach] | float = Field(
        float(FACTOR.default or 0),
        description="how far to look: a factor, or by parameter a factor or both ends of a range",
        json_schema_extra={"anyOf": [_FACTOR, _REACHES]},
    )
    into: Annotated[tuple[Annotated[str, one_of(DECIDED, "a regime")], ...] | None,
                    list_of(DECIDED, "a list of regimes")] = Field(
        None, description="regimes that count; any other unless given"
    )  # fmt: skip
    joint: Annotated[bool, BOOLEAN] = Field(
        False,
        description="whether the cheapest joint change is looked for, which takes a second per cell, rarely more",
    )
    scan: int = of_row(MARGINS["scan"])
    tolerance: float = of_row(MARGINS["tolerance"])
    beyond: float = of_row(MARGINS["beyond"])
    rtol: float | None = of_row(MARGINS["rtol"])

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


def _by_parameter(value: object, info: ValidationInfo) -> dict[str, Any]:
    """A mapping whose keys are among the parameters that may change."""
    if not isinstance(value, Mapping):
        raise refused("a mapping of parameters to numbers")
    known: Collection[str] = info.data.get("parameters") or SEARCHABLE
    return {choice(name, known, "a parameter that may change", inside=True): inner for name, inner in value.items()}


class Attractors(Section):
    """Which attractors cells have: regimes by starting state, and the share of a box of states that settles."""

    rows = ATTRACTORS
    displacement: Annotated[
        tuple[float, float], Read(lambda value: interval(QUANTITIES["displacement"], value), RANGE)
    ] = Field(description="displacements of the box of starting states, [low, high]")
    velocity: Annotated[tuple[float, float], Read(lambda value: interval(QUANTITIES["velocity"], value), RANGE)] = (
        Field(description="velocities of the box of starting states, [low, high]")
    )
    samples: int = of_row(ATTRACTORS["samples"])
    seed: int = of_row(ATTRACTORS["seed"])

    @field_validator("samples")
    @classmethod
    def _samples(cls, value: int) -> int:
        points, rest = divmod(value, RANDOMISATIONS)
        if rest or points & (points - 1):
            raise refused(f"{RANDOMISATIONS} times a power of 2")
        return value


STUDIES: dict[str, type[Section]] = {
    "border": Border, "contours": Contours, "margins": Margins, "attractors": Attractors, "refine": Refine,
    "uncertain": Uncertain,
}  # fmt: skip


def alone(key: str, section: Section) -> dict[str, Section | None]:
    """The update of a configuration after which it asks for this section and for nothing else.

    What is uncertain stays: without it quantities would be missing, and whoever needs known ones says so.
    """
    return {**dict.fromkeys(study for study in STUDIES if study != "uncertain"), key: section}
