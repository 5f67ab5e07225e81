"""What a configuration says, once it is right: frozen pydantic models, all in SI.

A quantity is either fixed, in the section that owns it (`sections.py`), or varied, in `axes`. `reader.py` reads these
models from files and sees to it that they fit together.
"""

from __future__ import annotations

import math
from typing import Annotated, Any, Literal

import numpy as np
from numpy.typing import NDArray
from pydantic import BeforeValidator, ValidationInfo, field_validator
from pydantic_core import PydanticCustomError

from stickslip.config.sections import (
    Drive,
    Execution,
    Friction,
    Output,
    Section,
    Sensor,
    Solver,
    Start,
    System,
    one_of,
    quantity,
    refused,
    whole,
)
from stickslip.config.yaml import write_yaml
from stickslip.vocabulary import units
from stickslip.vocabulary.quantities import QUANTITIES

LONGEST_AXIS = 10_000_000  # points; the values of axes are held in memory, those of cells are not


# --- axes -------------------------------------------------------------------------------------------------------------


def _named(value: object, info: ValidationInfo) -> float | str:
    """One value of a list; the context holds how many more are worth explaining, which takes its time."""
    left: list[int] = info.context or [1]
    if left[0] <= 0:
        return math.nan  # the list is refused already
    try:
        return quantity(info.data["name"], value)
    except PydanticCustomError:
        left[0] -= 1
        raise


class Values(Section):
    """One quantity that takes the listed values; `name` is its key in the file."""

    name: str
    values: tuple[Annotated[float | str, BeforeValidator(_named)], ...]

    @property
    def size(self) -> int:
        """Number of points."""
        return len(self.values)

    def points(self) -> NDArray[np.float64]:
        """The values in SI; NaN where a word stands."""
        return np.array([math.nan if isinstance(value, str) else value for value in self.values], np.float64)

    def resolved(self) -> dict[str, Any]:
        """The axis as plain data, without its name."""
        return {"values": list(self.values)}


class Range(Section):
    """One quantity from `start` to `stop`, both included, in `num` points; `name` is its key in the file."""

    name: str
    spacing: Literal["linear", "log"] = "linear"
    start: float
    stop: float
    num: int

    @field_validator("spacing", mode="before")
    @classmethod
    def _spacing(cls, value: object) -> str:
        return one_of(value, ("linear", "log"))

    @field_validator("start", "stop", mode="before")
    @classmethod
    def _end(cls, value: object, info: ValidationInfo) -> float:
        name, start = info.data["name"], info.data.get("start")
        number = quantity(name, value)
        if isinstance(number, str):
            raise refused(units.expected(QUANTITIES[name].units), f"{number} can stand in a list: values: [...]")
        unit = units.spelled(QUANTITIES[name].units)
        if info.field_name == "start" and info.data.get("spacing") == "log" and number <= 0:
            raise refused(f"a start above 0 {unit}".rstrip() + " for log spacing", "or use spacing: linear")
        if info.field_name == "stop" and start is not None and number <= start:
            hint = "swap start and stop" if number < start else "a quantity that does not vary belongs in its section"
            raise refused(f"more than start ({start:g} {unit}".rstrip() + ")", hint)
        return number

    @field_validator("num", mode="before")
    @classmethod
    def _num(cls, value: object, info: ValidationInfo) -> int:
        if value == 1:
            hint = "a quantity that does not vary belongs in its section"
            raise refused(f"a whole number from 2 to {LONGEST_AXIS}", hint)
        number = whole(value, 2, LONGEST_AXIS)
        start, stop = info.data.get("start"), info.data.get("stop")
        if start is not None and stop is not None:
            largest = max(abs(start), abs(stop))
            if (stop - start) / (number - 1) < 4 * math.ulp(largest):
                raise refused("fewer points: neighbours would be equal after rounding")
        return number

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
        plain: dict[str, Any] = {"zip": {member.name: list(member.values) for member in self.members}}
        return plain if self.labels is None else {**plain, "labels": list(self.labels)}


Axis = Range | Values | Group


class Config(Section):
    """A whole configuration: every quantity exactly once, fixed or along an axis, everything in SI.

    axes : in the order of the file, which is that of the dimensions (the first is the outermost).
    drive, sensor : of a test rig; None where the belt moves at a constant speed.
    """

    title: str
    system: System
    friction: Friction
    start: Start
    axes: tuple[Axis, ...]
    solver: Solver
    execution: Execution
    output: Output
    drive: Drive | None = None
    sensor: Sensor | None = None

    def fixed(self) -> dict[str, float | str]:
        """The quantities that do not vary, by name; `quantities.MEASURED` among them where they were given."""
        sections = (self.system, self.friction, self.start, self.drive or ())
        named = {name: value for section in sections for name, value in section if name in QUANTITIES}
        return {name: value for name, value in named.items() if value is not None}

    def resolved(self) -> dict[str, Any]:
        """Everything as plain data: SI, defaults filled in. Read again, it gives an equal configuration."""
        plain = self.model_dump(exclude={"axes"}, exclude_none=True)
        axes = {axis.name: axis.resolved() for axis in self.axes}
        plain["axes"] = axes
        return {key: plain[key] for key in type(self).model_fields if key in plain}

    def to_yaml(self) -> str:
        """`resolved` as YAML text; what result files keep, and what `reader.parse_config` reads."""
        return write_yaml(self.resolved())
