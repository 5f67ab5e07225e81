"""What a configuration says, once it is right: frozen pydantic models, all in SI.

A quantity is held as a number in SI, or as the word that stands for its absence (`quantities.WORDS`). It is either
fixed, in the section that owns it, or varied, in `axes`; where it is not fixed the section holds None. `config.py`
reads these models from files and sees to it that they fit together.

Field validators report what they refuse through `refused`, so that every message says what was expected.
"""

from __future__ import annotations

import math
from pathlib import PurePath
from typing import Annotated, Any, Literal

import numpy as np
from numpy.typing import NDArray
from pydantic import BaseModel, BeforeValidator, ConfigDict, Field, ValidationInfo, field_validator
from pydantic_core import PydanticCustomError

from . import addresses, units
from .problems import listed
from .quantities import HORIZON_UNITS, QUANTITIES, WORDS
from .variables import LAW_MESSAGES, LAWS, Parameter
from .yaml_source import write_yaml

REFUSED = "refused"  # type of the errors of `refused`, among pydantic's own
LONGEST_AXIS = 10_000_000  # points; the values of axes are held in memory, those of cells are not
RTOL = (1e-12, 1e-2)  # smallest and largest relative tolerance
OUTPUT_SUFFIXES = (".nc", ".zarr")
PLOT_SUFFIXES = (".png", ".svg", ".pdf")


def refused(expected: str, hint: str | None = None, found: str | None = None) -> PydanticCustomError:
    """The error of a validator: what was expected, the next step, and what kind of quantity was found instead."""
    return PydanticCustomError(REFUSED, "expected {expected}", {"expected": expected, "hint": hint, "found": found})


# --- single values ----------------------------------------------------------------------------------------------------


def quantity(name: str, value: object) -> float | str:
    """The quantity called `name` as a number in SI within its bounds, or as the word that stands for its absence."""
    declared, word = QUANTITIES[name], WORDS.get(name)
    if word is not None and value == word:
        return word
    or_word = f", or {word}" if word else ""
    try:
        number = units.si_value(value, declared.units)
    except units.QuantityError as error:
        raise refused(error.expected + or_word, error.hint, error.found) from None
    if number < declared.minimum or (declared.exclusive and number == declared.minimum):
        raise refused(_bound(declared) + or_word)
    return number


def _bound(declared: Parameter) -> str:
    """The lower bound of a quantity in words: ``a mass above 0 kg``."""
    relation = "above" if declared.exclusive else "of at least"
    return f"{units.kind(declared.units)} {relation} {declared.minimum:g} {units.spelled(declared.units)}".rstrip()


def _fixed(value: object, info: ValidationInfo) -> float | str:
    return quantity(str(info.field_name), value)


def _whole(value: object, least: int, most: int) -> int:
    """A whole number within bounds; 1e6 is one, true is none."""
    if isinstance(value, bool) or not isinstance(value, int | float) or not least <= value <= most:
        raise refused(f"a whole number from {least} to {most}")
    if value != int(value):
        raise refused(f"a whole number from {least} to {most}")
    return int(value)


def _one_of(value: object, words: tuple[str, ...]) -> str:
    if value not in words:
        raise refused(listed(words))
    return str(value)


def _file(value: object, suffixes: tuple[str, ...]) -> str:
    if not isinstance(value, str) or PurePath(value).suffix.lower() not in suffixes or "\0" in value:
        raise refused(f"a file name that ends in {listed(suffixes)}")
    return value


def _flag(value: object) -> bool:
    if not isinstance(value, bool):
        raise refused("true or false")
    return value


Fixed = Annotated[float | str | None, BeforeValidator(_fixed)]


# --- sections ---------------------------------------------------------------------------------------------------------


class Section(BaseModel):
    """A mapping of the file: no keys but its own, and nothing to change once it is read."""

    model_config = ConfigDict(extra="forbid", frozen=True)


class System(Section):
    """The oscillator: a mass on a belt, held by a spring and a damper."""

    mass: Fixed = None
    stiffness: Fixed = None
    damping: Fixed = None
    normal_load: Fixed = None
    belt_speed: Fixed = None


class Friction(Section):
    """The friction curve, by its coefficients a1 to a4 or by what is measured (mu_start to v_reversal, a4)."""

    law: str = Field(
        "stribeck", description="shape of the weakening: " + "; ".join(map(": ".join, LAW_MESSAGES.items()))
    )
    fit: str | None = Field(
        None, description="CSV file of measured slip speeds and friction coefficients that a1 to a4 are fitted to"
    )
    a1: Fixed = None
    a2: Fixed = None
    a3: Fixed = None
    a4: Fixed = None
    mu_start: Fixed = None
    mu_reversal: Fixed = None
    v_reversal: Fixed = None
    mu_stop: Fixed = None
    mu_static: Fixed = None
    delta: Fixed = None
    ageing_rate: Fixed = None
    ageing_time: Fixed = None

    @field_validator("law", mode="before")
    @classmethod
    def _law(cls, value: object) -> str:
        return _one_of(value, LAWS)

    @field_validator("fit", mode="before")
    @classmethod
    def _fit(cls, value: object) -> str:
        return _file(value, (".csv",))


class Start(Section):
    """The state at the start."""

    displacement: Fixed = None
    velocity: Fixed = None
    contact_time: Fixed = None


class Solver(Section):
    """How cells are integrated, and how long."""

    rtol: float = Field(1e-6, description="relative tolerance of a step, from 1e-12 to 1e-2")
    horizon: float | None = Field(None, description="longest time simulated per cell; leave it out for no limit")
    max_steps: int = Field(1_000_000, description="step budget of a cell; when it runs out the cell is unresolved")
    early_stop: bool = Field(
        True, description="stop as soon as the regime is decided; false integrates every cell to the horizon"
    )

    @field_validator("rtol", mode="before")
    @classmethod
    def _rtol(cls, value: object) -> float:
        try:
            number = units.si_value(value, "1")
        except units.QuantityError as error:
            raise refused(f"a number from {RTOL[0]:g} to {RTOL[1]:g}", error.hint) from None
        if not RTOL[0] <= number <= RTOL[1]:
            raise refused(f"a number from {RTOL[0]:g} to {RTOL[1]:g}")
        return number

    @field_validator("horizon", mode="before")
    @classmethod
    def _horizon(cls, value: object) -> float:
        leave_out = "leave horizon out for no limit"
        try:
            number = units.si_value(value, HORIZON_UNITS)
        except units.QuantityError as error:
            raise refused(error.expected, error.hint or leave_out, error.found) from None
        if number <= 0:
            raise refused(f"{units.kind(HORIZON_UNITS)} above 0 {HORIZON_UNITS}", leave_out)
        return number

    @field_validator("max_steps", mode="before")
    @classmethod
    def _max_steps(cls, value: object) -> int:
        return _whole(value, 1, 2_000_000_000)  # steps are counted in 32 bits

    @field_validator("early_stop", mode="before")
    @classmethod
    def _early_stop(cls, value: object, info: ValidationInfo) -> bool:
        flag = _flag(value)
        if not flag and info.data.get("horizon", 0.0) is None:  # a horizon that was refused is not in `data`
            raise refused("true, because no horizon is given", "add a horizon such as '100 s' to solver")
        return flag


class Execution(Section):
    """What the computation runs on. It does not change the result."""

    threads: int | Literal["auto"] = Field("auto", description="threads; auto takes the processors of this machine")
    block: int = Field(4096, description="cells computed together")
    dask: str | None = Field(
        None, description=f"where blocks are computed, if not by threads of this process: {addresses.EXPECTED}"
    )

    @field_validator("threads", mode="before")
    @classmethod
    def _threads(cls, value: object) -> int | str:
        if value == "auto":
            return "auto"
        if isinstance(value, bool) or not isinstance(value, int) or not 1 <= value <= 4096:
            raise refused("auto or a whole number from 1 to 4096")
        return value

    @field_validator("block", mode="before")
    @classmethod
    def _block(cls, value: object) -> int:
        return _whole(value, 1, 1_000_000)

    @field_validator("dask", mode="before")
    @classmethod
    def _dask(cls, value: object) -> str:
        if not addresses.is_address(value):
            raise refused(addresses.EXPECTED)
        return str(value)


class Output(Section):
    """Where the result goes. Relative paths start at the folder the command is run in, not at that of the file."""

    file: str | None = Field(None, description="file of the result, .nc (netCDF) or .zarr")
    plot: str | None = Field(None, description="picture of the map, .png, .svg or .pdf")

    @field_validator("file", mode="before")
    @classmethod
    def _file(cls, value: object) -> str:
        return _file(value, OUTPUT_SUFFIXES)

    @field_validator("plot", mode="before")
    @classmethod
    def _plot(cls, value: object) -> str:
        return _file(value, PLOT_SUFFIXES)


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
        return _one_of(value, ("linear", "log"))

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
        number = _whole(value, 2, LONGEST_AXIS)
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
    """

    title: str
    system: System
    friction: Friction
    start: Start
    axes: tuple[Axis, ...]
    solver: Solver
    execution: Execution
    output: Output

    def fixed(self) -> dict[str, float | str]:
        """The quantities that do not vary, by name; `quantities.MEASURED` among them where they were given."""
        sections = (self.system, self.friction, self.start)
        named = {name: value for section in sections for name, value in section if name in QUANTITIES}
        return {name: value for name, value in named.items() if value is not None}

    def resolved(self) -> dict[str, Any]:
        """Everything as plain data: SI, defaults filled in. Read again, it gives an equal configuration."""
        plain = self.model_dump(exclude={"axes"}, exclude_none=True)
        axes = {axis.name: axis.resolved() for axis in self.axes}
        return {key: axes if key == "axes" else plain[key] for key in type(self).model_fields}

    def to_yaml(self) -> str:
        """`resolved` as YAML text; what result files keep, and what `config.parse_config` reads."""
        return write_yaml(self.resolved())
