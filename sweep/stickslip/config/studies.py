"""The sections that ask for something else than a map. A configuration has at most one of them."""

from __future__ import annotations

import math
from typing import Annotated, Any

from pydantic import BeforeValidator, Field, ValidationInfo, field_validator

from stickslip.config.sections import Section, number, of_row, refused
from stickslip.vocabulary.quantities import PARAMETERS
from stickslip.vocabulary.settings import BORDER
from stickslip.vocabulary.words import listed, nearest


def _end(value: object, info: ValidationInfo) -> float:
    """One end of a range of the parameter `along`."""
    if "along" not in info.data:  # which is refused already
        return math.nan
    row = PARAMETERS[info.data["along"]]
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


STUDIES: dict[str, type[Section]] = {"border": Border}


def parameter(value: object) -> str:
    """The name of a parameter of a cell."""
    if value not in PARAMETERS:
        near = nearest(str(value), PARAMETERS)
        raise refused(f"a parameter of a cell: {listed(PARAMETERS)}", f"did you mean {near}?" if near else None)
    return str(value)
