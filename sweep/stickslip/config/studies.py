"""The sections that ask for something else than a map. A configuration has at most one of them."""

from __future__ import annotations

import math
from typing import Annotated, Any

from pydantic import BeforeValidator, Field, ValidationInfo, field_validator

from stickslip.config.scatter import Uncertain
from stickslip.config.sections import Section, number, of_row, refused
from stickslip.vocabulary.quantities import PARAMETERS, QUANTITIES, SEARCHABLE
from stickslip.vocabulary.settings import ATTRACTORS, BORDER, RANDOMISATIONS, REFINE
from stickslip.vocabulary.words import listed, nearest


def _end(value: object, info: ValidationInfo) -> float:
    """One end of a range of the parameter `along`."""
    if "along" not in info.data:  # which is refused already
        return math.nan
    row = QUANTITIES[info.data["along"]]
    found = number(row, value)
    if math.isnan(found):
        raise refused(row.expected.removesuffix(row.otherwise))
    return found


def pair(value: object) -> object:
    """A list of two values."""
    if not isinstance(value, list | tuple) or len(value) != 2:
        raise refused("a list of two values, the lower end first")
    return value


def in_order(value: tuple[float, float]) -> tuple[float, float]:
    """A range whose lower end comes first."""
    if not value[0] < value[1]:
        raise refused("the lower end first and the upper above it", "swap the ends" if value[0] > value[1] else None)
    return value


End = Annotated[float, BeforeValidator(_end)]


class Border(Section):
    """Where along a parameter the regime changes; the other axes are the lines that are searched."""

    rows = BORDER
    along: str = Field(description="parameter of a cell to search along")
    between: tuple[End, End] | None = Field(
        None, description="both ends of the range to search, the lower one first; those of the axis unless given"
    )
    tolerance: float = of_row(BORDER["tolerance"])
    scan: int = of_row(BORDER["scan"])
    rtol: float | None = of_row(BORDER["rtol"])

    @field_validator("along", mode="before")
    @classmethod
    def _along(cls, value: object) -> str:
        return parameter(value)

    @field_validator("between", mode="before")
    @classmethod
    def _between(cls, value: object) -> object:
        return pair(value)

    @field_validator("between")
    @classmethod
    def _order(cls, value: tuple[float, float] | None) -> tuple[float, float] | None:
        return value if value is None or math.isnan(value[0]) else in_order(value)

    def resolved(self) -> dict[str, Any]:
        """The section as plain data."""
        plain = super().resolved()
        return plain if self.between is None else plain | {"between": list(self.between)}


def _state(value: object, info: ValidationInfo) -> float:
    """One end of an interval of starting states."""
    row = PARAMETERS[str(info.field_name)]
    found = number(row, value)
    if math.isnan(found):
        raise refused(row.expected.removesuffix(row.otherwise))
    return found


State = Annotated[float, BeforeValidator(_state)]


class Attractors(Section):
    """Which attractors cells have: regimes by starting state, and the share of a box of states that settles."""

    rows = ATTRACTORS
    displacement: tuple[State, State] = Field(description="displacements of the box of starting states, [low, high]")
    velocity: tuple[State, State] = Field(description="velocities of the box of starting states, [low, high]")
    samples: int = of_row(ATTRACTORS["samples"])
    seed: int = of_row(ATTRACTORS["seed"])

    @field_validator("displacement", "velocity", mode="before")
    @classmethod
    def _interval(cls, value: object) -> object:
        return pair(value)

    @field_validator("displacement", "velocity")
    @classmethod
    def _order(cls, value: tuple[float, float]) -> tuple[float, float]:
        return in_order(value)

    @field_validator("samples")
    @classmethod
    def _samples(cls, value: int) -> int:
        points, rest = divmod(value, RANDOMISATIONS)
        if rest or points & (points - 1):
            raise refused(f"{RANDOMISATIONS} times a power of 2")
        return value

    def resolved(self) -> dict[str, Any]:
        """The section as plain data."""
        return super().resolved() | {"displacement": list(self.displacement), "velocity": list(self.velocity)}


class Refine(Section):
    """A map of which cells are computed only where regimes meet, and at few points elsewhere."""

    rows = REFINE
    depth: int = of_row(REFINE["depth"])
    audit: float = of_row(REFINE["audit"])
    interpolate: bool = Field(False, description="whether cells that are not computed get metrics between others")

    @field_validator("interpolate", mode="before")
    @classmethod
    def _interpolate(cls, value: object) -> bool:
        if not isinstance(value, bool):
            raise refused("true or false")
        return value


STUDIES: dict[str, type[Section]] = {
    "border": Border,
    "attractors": Attractors,
    "refine": Refine,
    "uncertain": Uncertain,
}


def parameter(value: object) -> str:
    """The name of a parameter of a cell, or of what is measured of its curve."""
    if value not in SEARCHABLE:
        near = nearest(str(value), SEARCHABLE)
        raise refused(f"a parameter of a cell: {listed(SEARCHABLE)}", f"did you mean {near}?" if near else None)
    return str(value)
