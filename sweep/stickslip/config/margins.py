"""The section that asks how far the cells of a map are from a border."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from pydantic import Field, ValidationInfo, field_validator

from stickslip.config.sections import Section, interval, number, of_row, refused
from stickslip.vocabulary.flags import DECIDED
from stickslip.vocabulary.quantities import SEARCHABLE
from stickslip.vocabulary.settings import COST, FACTOR, MARGINS
from stickslip.vocabulary.words import listed, nearest

Reach = float | tuple[float, float]


class Margins(Section):
    """How far each cell is from a border along single parameters, and by the cheapest change of several."""

    rows = MARGINS
    parameters: tuple[str, ...] | None = Field(
        None, description="parameters that may change; all that a designer chooses unless given"
    )
    costs: dict[str, float] = Field(
        {}, description="by parameter, what changing it by a factor costs relative to the others; 1 unless given"
    )
    within: dict[str, Reach] | float = Field(
        float(FACTOR.default or 0),
        description="how far to look: a factor, or by parameter a factor or both ends of a range",
    )
    into: tuple[str, ...] | None = Field(None, description="regimes that count; any other unless given")
    joint: bool = Field(
        False,
        description="whether the cheapest joint change is looked for, which takes a second per cell, rarely more",
    )
    scan: int = of_row(MARGINS["scan"])
    tolerance: float = of_row(MARGINS["tolerance"])
    beyond: float = of_row(MARGINS["beyond"])
    rtol: float | None = of_row(MARGINS["rtol"])

    @field_validator("parameters", mode="before")
    @classmethod
    def _parameters(cls, value: object) -> object:
        if not isinstance(value, list | tuple) or not value or len(set(map(str, value))) != len(value):
            raise refused("a list of different parameters")
        return tuple(_one_of(name, tuple(SEARCHABLE), "a parameter of a cell") for name in value)

    @field_validator("costs", mode="before")
    @classmethod
    def _costs(cls, value: object, info: ValidationInfo) -> object:
        return {name: number(COST, cost) for name, cost in _by_parameter(value, info).items()}

    @field_validator("within", mode="before")
    @classmethod
    def _within(cls, value: object, info: ValidationInfo) -> object:
        if not isinstance(value, Mapping):
            return number(FACTOR, value)
        reaches = _by_parameter(value, info)
        return {name: interval(SEARCHABLE[name], one) if isinstance(one, list | tuple) else number(FACTOR, one)
                for name, one in reaches.items()}  # fmt: skip

    @field_validator("into", mode="before")
    @classmethod
    def _into(cls, value: object) -> object:
        if not isinstance(value, list | tuple) or not value:
            raise refused("a list of regimes")
        return tuple(_one_of(name, DECIDED, "a regime") for name in value)

    @field_validator("joint", mode="before")
    @classmethod
    def _joint(cls, value: object) -> bool:
        if not isinstance(value, bool):
            raise refused("true or false")
        return value

    def resolved(self) -> dict[str, Any]:
        """The section as plain data."""
        return {name: _plain(value) for name, value in super().resolved().items()}


def _by_parameter(value: object, info: ValidationInfo) -> dict[str, Any]:
    """A mapping whose keys are among the parameters that may change."""
    if not isinstance(value, Mapping):
        raise refused("a mapping of parameters to numbers")
    known = info.data.get("parameters") or tuple(SEARCHABLE)
    return {_one_of(name, known, "a parameter that may change"): one for name, one in value.items()}


def _one_of(value: object, known: tuple[str, ...], what: str) -> str:
    if value not in known:
        near = nearest(str(value), known)
        raise refused(f"{what}: {listed(known)}", f"did you mean {near}?" if near else None, found=f"{value!r} in it")
    return str(value)


def _plain(value: Any) -> Any:
    if isinstance(value, tuple):
        return list(value)
    return {name: _plain(one) for name, one in value.items()} if isinstance(value, dict) else value
