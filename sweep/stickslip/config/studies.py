"""The sections that ask for something else than a map. A configuration has at most one of them."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Annotated, Any

from pydantic import BeforeValidator, Field, ValidationInfo, field_validator

from stickslip.config.margins import Margins
from stickslip.config.scatter import Uncertain
from stickslip.config.sections import Section, interval, number, of_row, refused
from stickslip.vocabulary.quantities import QUANTITIES, SEARCHABLE
from stickslip.vocabulary.settings import ATTRACTORS, BORDER, CONTOURS, RANDOMISATIONS, REFINE
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

    def resolved(self) -> dict[str, Any]:
        """The section as plain data."""
        plain = super().resolved()
        return plain if self.between is None else plain | {"between": list(self.between)}


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


class Contours(Section):
    """Where in planes of two parameters the regime changes, as lines; the other axes are the panels."""

    rows = CONTOURS
    axes: tuple[str, str] | None = Field(
        None, description="the two parameters, y and x; the last two axes unless given"
    )
    between: dict[str, tuple[float, float]] | None = Field(
        None, description="by parameter, both ends of its range, the lower one first; those of its axis unless given"
    )
    points: int = of_row(CONTOURS["points"])
    tolerance: float = of_row(CONTOURS["tolerance"])
    scan: int = of_row(CONTOURS["scan"])
    rtol: float | None = of_row(CONTOURS["rtol"])

    @field_validator("axes", mode="before")
    @classmethod
    def _axes(cls, value: object) -> object:
        if not isinstance(value, list | tuple) or len(value) != 2 or value[0] == value[1]:
            raise refused("a list of two different parameters, y and x")
        return tuple(map(parameter, value))

    @field_validator("between", mode="before")
    @classmethod
    def _between(cls, value: object) -> object:
        if not isinstance(value, Mapping):
            raise refused("a range for each of the two parameters: {belt_speed: [0.1, 1]}")
        return {parameter(name): interval(QUANTITIES[name], ends) for name, ends in value.items()}

    def resolved(self) -> dict[str, Any]:
        """The section as plain data."""
        plain = super().resolved()
        if self.axes is not None:
            plain["axes"] = list(self.axes)
        if self.between is not None:
            plain["between"] = {name: list(ends) for name, ends in self.between.items()}
        return plain


class Attractors(Section):
    """Which attractors cells have: regimes by starting state, and the share of a box of states that settles."""

    rows = ATTRACTORS
    displacement: tuple[float, float] = Field(description="displacements of the box of starting states, [low, high]")
    velocity: tuple[float, float] = Field(description="velocities of the box of starting states, [low, high]")
    samples: int = of_row(ATTRACTORS["samples"])
    seed: int = of_row(ATTRACTORS["seed"])

    @field_validator("displacement", "velocity", mode="before")
    @classmethod
    def _interval(cls, value: object, info: ValidationInfo) -> object:
        return interval(QUANTITIES[str(info.field_name)], value)

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


STUDIES: dict[str, type[Section]] = {
    "border": Border, "contours": Contours, "margins": Margins, "attractors": Attractors, "refine": Refine,
    "uncertain": Uncertain,
}  # fmt: skip


def alone(key: str, section: Section) -> dict[str, Section | None]:
    """What to update a configuration with so that it asks for this and for nothing else.

    What is uncertain stays: without it quantities would be missing, and whoever needs known ones says so.
    """
    return {**dict.fromkeys(study for study in STUDIES if study != "uncertain"), key: section}


def parameter(value: object) -> str:
    """The name of a parameter of a cell, or of what is measured of its curve."""
    if value not in SEARCHABLE:
        near = nearest(str(value), SEARCHABLE)
        raise refused(f"a parameter of a cell: {listed(SEARCHABLE)}", f"did you mean {near}?" if near else None)
    return str(value)
