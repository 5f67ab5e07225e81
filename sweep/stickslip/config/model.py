"""A configuration that is right: frozen pydantic models, all in SI.

A quantity is either fixed, in the section that owns it (`sections.py`), or varied, in `axes`. `reader.py` reads these
models from files and sees to it that they fit together.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from html import escape
from typing import Annotated, Any, Self

import numpy as np
from numpy.typing import NDArray
from pydantic import BeforeValidator, FailFast, PrivateAttr, ValidationInfo, field_validator, model_validator

from stickslip.config.sections import (
    Execution,
    Friction,
    Output,
    Section,
    Solver,
    Start,
    StudySection,
    System,
    each_with_unit,
    number,
    one_of,
    refused,
)
from stickslip.config.uncertain import Uncertain
from stickslip.config.yaml import write_yaml
from stickslip.vocabulary import units
from stickslip.vocabulary.models import model_of
from stickslip.vocabulary.quantities import AXIS, QUANTITIES, QUANTITIES_OF

DEFAULT_TITLE = "Regimes of a friction oscillator"
QUANTITY_SECTIONS: dict[str, type[Section]] = {"system": System, "friction": Friction, "start": Start}
SECTIONS: dict[str, type[Section]] = {
    **QUANTITY_SECTIONS, "solver": Solver, "execution": Execution, "output": Output,
}  # fmt: skip

# --- axes -------------------------------------------------------------------------------------------------------------


class _OneQuantity(Section):
    """One quantity along a dimension; `name` is its key in the file."""

    name: str

    @property
    def members(self) -> tuple[Self]:
        """The quantity along the axis."""
        return (self,)


def _value(value: object, info: ValidationInfo) -> float:
    return number(QUANTITIES[info.data["name"]], value)


class Values(_OneQuantity):
    """One quantity that takes the listed values."""

    values: Annotated[tuple[Annotated[float, BeforeValidator(_value)], ...], FailFast()]  # which may be long

    @field_validator("values", mode="before")
    @classmethod
    def _list(cls, value: object, info: ValidationInfo) -> object:
        if not isinstance(value, list | tuple) or not value:
            raise refused("a list of values")
        return each_with_unit(QUANTITIES[info.data["name"]], value)

    @property
    def size(self) -> int:
        """Number of points."""
        return len(self.values)

    def points(self) -> NDArray[np.float64]:
        """The values in SI; NaN for words."""
        return np.array(self.values, np.float64)

    def resolved(self) -> dict[str, Any]:
        """The axis as plain data, without its name."""
        return {"values": [QUANTITIES[self.name].written(value) for value in self.values]}


class Range(_OneQuantity):
    """One quantity from `start` to `stop`, both included, in `num` points."""

    spacing: Annotated[str, one_of(("linear", "log"))] = "linear"
    start: float
    stop: float
    num: int

    @model_validator(mode="before")
    @classmethod
    def _one_unit(cls, value: Any) -> Any:
        if not isinstance(value, dict):
            return value
        ends = {key: value[key] for key in ("start", "stop") if key in value}
        return {**value, **each_with_unit(QUANTITIES[value["name"]], ends)}

    @field_validator("start", "stop", mode="before")
    @classmethod
    def _end(cls, value: object, info: ValidationInfo) -> float:
        name, start = info.data["name"], info.data.get("start")
        row = QUANTITIES[name]
        end, unit = number(row, value), units.spelled(row.units)
        if math.isnan(end):
            raise refused(units.expected(row.units), f"{row.word} is allowed in a list: values: [...]")
        if info.field_name == "start" and info.data.get("spacing") == "log" and end <= 0:
            raise refused(f"a start above 0 {unit}".rstrip() + " for log spacing", "or use spacing: linear")
        if info.field_name == "stop" and start is not None and end <= start:
            hint = "swap start and stop" if end < start else "a quantity that does not vary belongs in its section"
            raise refused(f"more than start ({start:g} {unit}".rstrip() + ")", hint)
        return end

    @field_validator("num", mode="before")
    @classmethod
    def _num(cls, value: object, info: ValidationInfo) -> int:
        if value == 1:
            hint = "a quantity that does not vary belongs in its section"
            raise refused(AXIS["num"].expected, hint)
        points = int(number(AXIS["num"], value))
        start, stop = info.data.get("start"), info.data.get("stop")
        if start is not None and stop is not None:
            largest = max(abs(start), abs(stop))
            if (stop - start) / (points - 1) < 4 * math.ulp(largest):
                raise refused("fewer points: neighbours would be equal after rounding")
        return points

    @property
    def size(self) -> int:
        """Number of points."""
        return self.num

    def points(self) -> NDArray[np.float64]:
        """The values in SI."""
        spread = np.geomspace if self.spacing == "log" else np.linspace
        return spread(self.start, self.stop, self.num)

    def resolved(self) -> dict[str, Any]:
        """The axis as plain data, without its name."""
        return {"start": self.start, "stop": self.stop, "num": self.num, "spacing": self.spacing}


class Group(Section):
    """Quantities that vary together, point by point, along one dimension called `name`.

    members : at least one, all of one length. labels : names of the points, or None.
    """

    name: str
    members: tuple[Values, ...]
    labels: tuple[str, ...] | None = None

    @property
    def size(self) -> int:
        """Number of points."""
        return self.members[0].size

    def resolved(self) -> dict[str, Any]:
        """The axis as plain data, without its name."""
        plain: dict[str, Any] = {"zip": {member.name: member.resolved()["values"] for member in self.members}}
        return plain if self.labels is None else {**plain, "labels": list(self.labels)}


Axis = Range | Values | Group


def quantities_in(section: Section | type[Section]) -> list[str]:
    """The names of the quantities that a section gives; ranges of them, in a study, are none."""
    key = getattr(section, "key", None)
    names = (section if isinstance(section, type) else type(section)).model_fields
    return [name for name in names if name in QUANTITIES and key in (None, QUANTITIES[name].section)]


class Config(Section):
    """A whole configuration: every quantity exactly once, fixed or along an axis, everything in SI.

    axes : in the order of the file, which is that of the dimensions (the first is the outermost).
    study : what is asked for instead of a map of every cell, in the section that its key names.
    beside : other sections that belong to it, by key.
    uncertain : the same of quantities that scatter, which are neither fixed nor along an axis.
    """

    title: str
    system: System
    friction: Friction
    start: Start
    axes: tuple[Axis, ...]
    solver: Solver
    execution: Execution
    output: Output
    study: StudySection | None = None
    beside: dict[str, Section] = {}
    uncertain: Uncertain | None = None
    _written_in: dict[str, str] = PrivateAttr(default_factory=dict)

    @property
    def written_in(self) -> dict[str, str]:
        """By quantity, the unit in which it was written; plain numbers are SI, and have none.

        No part of what is computed: configurations that differ in it are equal, and `resolved` leaves it out.
        """
        return self._written_in

    def shown_in(self, written_in: Mapping[str, str]) -> Config:
        """The configuration, its results to be shown in these units."""
        other = self.model_copy()
        other._written_in = dict(written_in)
        return other

    @property
    def is_map(self) -> bool:
        """True if a map of cells is asked for, refined or not, and nothing else."""
        return self.uncertain is None and (self.study is None or self.study.is_map)

    def plain_map(self) -> Config:
        """The configuration of the map of every cell, whatever study it asks for."""
        return self.model_copy(update={"study": None, "beside": {}, "uncertain": None})

    @property
    def has_cells(self) -> bool:
        """True if what is asked for are cells on a steady belt, which have regimes."""
        return self.study is None or self.study.has_cells

    def with_sections(self, **sections: Section) -> Config:
        """The configuration with other sections under these keys."""
        changed: dict[str, Any] = {key: section for key, section in sections.items() if key in type(self).model_fields}
        if study := next((section for section in sections.values() if isinstance(section, StudySection)), None):
            changed["study"] = study
        beside = {key: section for key, section in sections.items() if key in self.beside}
        return self.model_copy(update={**changed, "beside": {**self.beside, **beside}})

    def fixed(self) -> dict[str, float]:
        """The quantities that do not vary, by name; what is measured of a curve among them where they were given."""
        whole: tuple[Section | None, ...] = (self.system, self.friction, self.start, self.study)
        sections = [section for section in whole if section is not None]
        named = {name: getattr(section, name) for section in sections for name in quantities_in(section)}
        own = QUANTITIES_OF[model_of(self.friction.law)]
        return {name: value for name, value in named.items() if value is not None and name in own}

    def at(self, **values: float | None) -> Config:
        """The configuration with quantities at these values in SI (NaN for a word), fixed and not varied.

        Axes of a quantity of these go, groups only with all of their quantities. Nothing is checked.
        """
        axes = tuple(axis for axis in self.axes if not all(member.name in values for member in axis.members))
        changed: dict[str, Any] = {"axes": axes}
        for name, value in values.items():
            section = QUANTITIES[name].section
            section = section if section in type(self).model_fields else "study"
            changed[section] = changed.get(section, getattr(self, section)).model_copy(update={name: value})
        return self.model_copy(update=changed)

    def without(self, *names: str) -> Config:
        """The configuration without these quantities, which are neither fixed nor along an axis of their own."""
        return self.at(**dict.fromkeys(names))

    def resolved(self) -> dict[str, Any]:
        """Everything as plain data: SI, defaults filled in. Read again, it gives an equal configuration."""
        named = {value.key if isinstance(value, StudySection) else key: value for key, value in self}
        named |= named.pop("beside")
        plain = {key: value.resolved() if isinstance(value, Section) else value for key, value in named.items()}
        plain["axes"] = {axis.name: axis.resolved() for axis in self.axes}
        if not self.is_map:  # what is asked for on a command line instead of the map of a file has other variables
            plain["output"].pop("variables", None)
        return {key: value for key, value in plain.items() if value is not None}

    def _repr_html_(self) -> str:
        """What notebooks show."""
        return f"<b>{escape(self.title)}</b><pre>{escape(self.to_yaml())}</pre>"

    def to_yaml(self) -> str:
        """`resolved` as YAML text; what result files keep, and what `reader.parse_config` reads."""
        return write_yaml(self.resolved())
