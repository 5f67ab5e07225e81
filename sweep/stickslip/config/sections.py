"""The sections of a configuration: frozen pydantic models, all in SI.

A quantity is held as a number in SI, or as the word that stands for its absence (`quantities.WORDS`); one that varies
along an axis is None here.

Field validators report what they refuse through `refused`, so that every message says what was expected.
"""

from __future__ import annotations

from pathlib import PurePath
from typing import Annotated, Literal

from pydantic import BaseModel, BeforeValidator, ConfigDict, Field, ValidationInfo, field_validator
from pydantic_core import PydanticCustomError

from stickslip.config import addresses
from stickslip.errors import QuantityError
from stickslip.vocabulary import units
from stickslip.vocabulary.laws import LAW_MESSAGES, LAWS
from stickslip.vocabulary.quantities import HORIZON_UNITS, PROFILES, QUANTITIES, SENSOR, WORDS, Parameter
from stickslip.vocabulary.words import listed

REFUSED = "refused"  # type of the errors of `refused`, among pydantic's own
RTOL = (1e-12, 1e-2)  # smallest and largest relative tolerance
OUTPUT_SUFFIXES = (".nc", ".zarr")
PLOT_SUFFIXES = (".png", ".svg", ".pdf")


def refused(expected: str, hint: str | None = None, found: str | None = None) -> PydanticCustomError:
    """The error of a validator: what was expected, the next step, and what kind of quantity was found instead."""
    return PydanticCustomError(REFUSED, "expected {expected}", {"expected": expected, "hint": hint, "found": found})


# --- single values ----------------------------------------------------------------------------------------------------


def quantity(name: str, value: object) -> float | str:
    """The quantity called `name` as a number in SI within its bounds, or as the word that stands for its absence."""
    word = WORDS.get(name)
    if word is not None and value == word:
        return word
    return within(QUANTITIES[name], value, f", or {word}" if word else "")


def within(declared: Parameter, value: object, otherwise: str = "") -> float:
    """A quantity as a number in SI within its bounds; `otherwise` is what else is allowed, in words."""
    try:
        number = units.si_value(value, declared.units)
    except QuantityError as error:
        raise refused(error.expected + otherwise, error.hint, error.found) from None
    if number < declared.minimum or (declared.exclusive and number == declared.minimum):
        raise refused(_bound(declared) + otherwise)
    return number


def _bound(declared: Parameter) -> str:
    """The lower bound of a quantity in words: ``a mass above 0 kg``."""
    relation = "above" if declared.exclusive else "of at least"
    return f"{units.kind(declared.units)} {relation} {declared.minimum:g} {units.spelled(declared.units)}".rstrip()


def _fixed(value: object, info: ValidationInfo) -> float | str:
    return quantity(str(info.field_name), value)


def whole(value: object, least: int, most: int) -> int:
    """A whole number within bounds; 1e6 is one, true is none."""
    if isinstance(value, bool) or not isinstance(value, int | float) or not least <= value <= most:
        raise refused(f"a whole number from {least} to {most}")
    if value != int(value):
        raise refused(f"a whole number from {least} to {most}")
    return int(value)


def one_of(value: object, words: tuple[str, ...]) -> str:
    """One of some words."""
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
        return one_of(value, LAWS)

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
    max_steps: int = Field(100_000, description="step budget of a cell; when it runs out the cell is unresolved")
    early_stop: bool = Field(
        True, description="stop as soon as the regime is decided; false integrates every cell to the horizon"
    )

    @field_validator("rtol", mode="before")
    @classmethod
    def _rtol(cls, value: object) -> float:
        try:
            number = units.si_value(value, "1")
        except QuantityError as error:
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
        except QuantityError as error:
            raise refused(error.expected, error.hint or leave_out, error.found) from None
        if number <= 0:
            raise refused(f"{units.kind(HORIZON_UNITS)} above 0 {HORIZON_UNITS}", leave_out)
        return number

    @field_validator("max_steps", mode="before")
    @classmethod
    def _max_steps(cls, value: object) -> int:
        return whole(value, 1, 2_000_000_000)  # steps are counted in 32 bits

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
        return whole(value, 1, 1_000_000)

    @field_validator("dask", mode="before")
    @classmethod
    def _dask(cls, value: object) -> str:
        if not addresses.is_address(value):
            raise refused(addresses.EXPECTED)
        return str(value)


class Drive(Section):
    """How the belt of a test rig moves: to and fro, from rest, at speeds up to that of the belt (`system`)."""

    profile: str = Field("trapezoid", description="speed over time: " + ", ".join(PROFILES))
    strokes: int = Field(6, description="number of strokes, to and fro in turn")
    stroke: Fixed = None
    ramp: Fixed = None
    dwell: Fixed = None
    waiting_time: Fixed = None

    @field_validator("profile", mode="before")
    @classmethod
    def _profile(cls, value: object) -> str:
        return one_of(value, PROFILES)

    @field_validator("strokes", mode="before")
    @classmethod
    def _strokes(cls, value: object) -> int:
        return whole(value, 1, 10_000)


class Sensor(Section):
    """How a test rig is read: samples, bandwidth, noise."""

    rate: float = Field(1000.0, description="samples per second")
    bandwidth: float | None = Field(None, description="of both sensors, -3 dB; without it they follow everything")
    force_noise: float = Field(0.0, description="standard deviation of the noise of the force")
    acceleration_noise: float = Field(0.0, description="standard deviation of the noise of the acceleration")
    seed: int = Field(1, description="of the noise: the same seed, the same noise")
    oversampling: int = Field(8, description="samples computed for one that is kept, so that nothing is aliased")

    @field_validator("rate", "bandwidth", "force_noise", "acceleration_noise", mode="before")
    @classmethod
    def _number(cls, value: object, info: ValidationInfo) -> float:
        return within(SENSOR[str(info.field_name)], value)

    @field_validator("seed", "oversampling", mode="before")
    @classmethod
    def _count(cls, value: object, info: ValidationInfo) -> int:
        return whole(value, 0, 2**32 - 1) if info.field_name == "seed" else whole(value, 1, 64)


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
