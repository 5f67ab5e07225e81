"""The sections of a configuration: frozen pydantic models, all in SI.

What is a number is declared in the vocabulary, and read and written as its row says: NaN where a word such as "none"
is given in the file. A quantity that varies along an axis is None here.

Validators report what they refuse through `refused`, so that every message says what was expected.
"""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import PurePath
from typing import Annotated, Any, ClassVar, TypeVar

from pydantic import BaseModel, BeforeValidator, ConfigDict, Field, ValidationInfo, create_model, field_validator
from pydantic_core import PydanticCustomError

from stickslip.config import addresses
from stickslip.errors import QuantityError
from stickslip.vocabulary import beyond
from stickslip.vocabulary.laws import LAW_MESSAGES, LAWS
from stickslip.vocabulary.parameter import Parameter, of_section
from stickslip.vocabulary.quantities import PROFILES, QUANTITIES
from stickslip.vocabulary.results import VARIABLES
from stickslip.vocabulary.settings import EXECUTION, SENSOR, SOLVER, STROKES
from stickslip.vocabulary.words import listed, nearest

REFUSED = "refused"  # type of the errors of `refused`, among pydantic's own
OUTPUT_SUFFIXES = (".nc", ".zarr")
REMOTE_SUFFIX = ".zarr"  # what may be behind a URL
PLOT_SUFFIXES = (".png", ".svg", ".pdf")


def refused(expected: str, hint: str | None = None, found: str | None = None) -> PydanticCustomError:
    """The error of a validator: what was expected, the next step, and what kind of quantity was found instead."""
    return PydanticCustomError(REFUSED, "expected {expected}", {"expected": expected, "hint": hint, "found": found})


# --- single values ----------------------------------------------------------------------------------------------------


def number(row: Parameter, value: object) -> float:
    """What a file says of a row of the vocabulary, in SI; NaN for its word."""
    try:
        return row.read(value)
    except QuantityError as error:
        remedy = f"leave {row.name} out for {row.absent}" if row.default is None and row.absent else None
        if isinstance(value, list | dict) and row.name in QUANTITIES:
            remedy = f"what varies belongs to axes: {{{row.name}: ...}}"
        if isinstance(value, dict) and {"amplitude", "frequency"} & value.keys():
            remedy = beyond.hint(f"{row.name}_amplitude")
        raise refused(error.expected, error.hint or remedy, error.found) from None


def interval(row: Parameter, value: object) -> tuple[float, float]:
    """Both ends of a range of a row of the vocabulary, in SI and in order."""
    if not isinstance(value, list | tuple) or len(value) != 2:
        raise refused("a list of two values, the lower end first")
    low, high = (number(row, end) for end in value)
    if low != low or high != high:
        raise refused(row.expected.removesuffix(row.otherwise))
    if not low < high:
        raise refused("the lower end first and the upper above it", "swap the ends" if low > high else None)
    return low, high


def one_of(value: object, words: tuple[str, ...]) -> str:
    """One of some words."""
    if value not in words:
        near = next((word for word in words if str(value).lower().startswith(word)), None) or nearest(str(value), words)
        raise refused(listed(words), beyond.hint(str(value)) or (f"did you mean {near}?" if near else None))
    return str(value)


def _file(value: object, suffixes: tuple[str, ...]) -> str:
    if not isinstance(value, str) or PurePath(value).suffix.lower() not in suffixes or "\0" in value:
        is_bare = isinstance(value, str) and value and not PurePath(value).suffix
        raise refused(
            f"a file name that ends in {listed(suffixes)}", f"did you mean {value}{suffixes[0]}?" if is_bare else None
        )
    if not value.isprintable():
        raise refused(
            "a file name without control characters",
            "in double quotes a backslash begins an escape: use single quotes, or /",
        )
    if "://" in value and PurePath(value).suffix.lower() != REMOTE_SUFFIX:
        zarr = f", or a URL that ends in {REMOTE_SUFFIX}" if REMOTE_SUFFIX in suffixes else ""
        raise refused(f"a file of this machine{zarr}", "a file can be copied there afterwards")
    return value


def _variable(value: object) -> str:
    """The name of a variable of a cell."""
    if value not in VARIABLES:
        near = nearest(str(value), VARIABLES)
        raise refused(f"a variable of a map: {listed(VARIABLES)}", f"did you mean {near}?" if near else None)
    return str(value)


# --- sections ---------------------------------------------------------------------------------------------------------


class Section(BaseModel):
    """A mapping of the file: no keys but its own, and nothing to change once it is read.

    rows : those of its fields that are numbers of the vocabulary.
    """

    model_config = ConfigDict(defer_build=True, extra="forbid", frozen=True)
    rows: ClassVar[Mapping[str, Parameter]] = {}

    @field_validator("*", mode="before")
    @classmethod
    def _number(cls, value: object, info: ValidationInfo) -> object:
        row = cls.rows.get(str(info.field_name))
        if row is None:
            return value
        found = number(row, value)
        return None if row.whole and found != found else found  # no whole number is NaN

    def resolved(self) -> dict[str, Any]:
        """The section as plain data: words for NaN, nothing for None."""
        given = {name: value for name, value in self if value is not None}
        return {name: self.rows[name].written(value) if name in self.rows else value for name, value in given.items()}

    def __eq__(self, other: object) -> bool:
        if type(self) is not type(other):
            return NotImplemented
        return all(_same(value, getattr(other, name)) for name, value in self)


AnySection = TypeVar("AnySection", bound=Section)


def _same(one: Any, other: Any) -> bool:
    """Whether two values are equal; NaN, which stands for a word, is equal to itself."""
    if isinstance(one, tuple) and isinstance(other, tuple):
        return len(one) == len(other) and all(map(_same, one, other))
    return bool(one == other or (one != one and other != other))


def _with_quantities(base: type[AnySection], section: str) -> type[AnySection]:
    """The section with a field for each quantity that the vocabulary puts there."""
    rows = of_section(section, QUANTITIES.values())
    fields: dict[str, Any] = {name: (float | None, None) for name in rows}
    model = create_model(f"{section}_quantities", __base__=base, **fields)
    model.rows = {**base.rows, **rows}
    return model


def of_row(row: Parameter) -> Any:
    """The field of a number: None where it is absent."""
    default = row.default
    return Field(None if default is None or row.may_be_absent else default, description=row.long_name)


class System(_with_quantities(Section, "system")):  # type: ignore[misc]
    """The oscillator: a mass on a belt, held by a spring and a damper."""


class _Law(Section):
    law: str = Field(
        "stribeck", description="shape of the weakening: " + "; ".join(map(": ".join, LAW_MESSAGES.items()))
    )
    fit: str | tuple[str, ...] | None = Field(
        None,
        description="CSV file of measured slip speeds and friction coefficients that a1 to a4 are fitted to; a list of "
        "files is an axis of materials",
    )

    @field_validator("law", mode="before")
    @classmethod
    def _law(cls, value: object) -> str:
        return one_of(value, LAWS)

    @field_validator("fit", mode="before")
    @classmethod
    def _fit(cls, value: object) -> str | tuple[str, ...]:
        if isinstance(value, list | tuple) and value:
            return tuple(_file(one, (".csv",)) for one in value)
        return _file(value, (".csv",))


class Friction(_with_quantities(_Law, "friction")):  # type: ignore[misc]
    """The friction curve, by its coefficients a1 to a4 or by what is measured (mu_start to v_reversal, a4)."""


class Start(_with_quantities(Section, "start")):  # type: ignore[misc]
    """The initial state."""


class Solver(Section):
    """How cells are integrated, and how long."""

    rows = SOLVER
    rtol: float = of_row(SOLVER["rtol"])
    horizon: float | None = of_row(SOLVER["horizon"])
    max_steps: int = of_row(SOLVER["max_steps"])
    early_stop: bool = Field(
        True, description="stop as soon as the regime is decided; false integrates every cell to the horizon"
    )

    @field_validator("early_stop", mode="before")
    @classmethod
    def _early_stop(cls, value: object, info: ValidationInfo) -> bool:
        if not isinstance(value, bool):
            words = {"yes": "true", "on": "true", "1": "true", "no": "false", "off": "false", "0": "false"}
            meant = words.get(str(value).lower())
            raise refused("true or false", f"did you mean {meant}?" if meant else None)
        if not value and info.data.get("horizon", 0.0) is None:  # a horizon that was refused is not in `data`
            raise refused("true, because no horizon is given", "add a horizon such as '100 s' to solver")
        return value


class Execution(Section):
    """What the computation runs on. It does not change the result."""

    rows = EXECUTION
    threads: int | None = of_row(EXECUTION["threads"])
    block: int = of_row(EXECUTION["block"])
    dask: str | None = Field(
        None, description=f"where blocks are computed, if not by threads of this process: {addresses.EXPECTED}"
    )

    @field_validator("dask", mode="before")
    @classmethod
    def _dask(cls, value: object) -> str:
        if not addresses.is_address(value):
            raise refused(addresses.EXPECTED)
        return str(value)


class _Profile(Section):
    rows = STROKES
    profile: str = Field("trapezoid", description="speed over time: " + ", ".join(PROFILES))
    strokes: int = of_row(STROKES["strokes"])

    @field_validator("profile", mode="before")
    @classmethod
    def _profile(cls, value: object) -> str:
        return one_of(value, PROFILES)


class Drive(_with_quantities(_Profile, "drive")):  # type: ignore[misc]
    """How the belt of a test rig moves: reciprocating, from standstill, at speeds up to that of the belt (`system`)."""


class Sensor(Section):
    """How a test rig is read: samples, bandwidth, noise."""

    rows = SENSOR
    rate: float = of_row(SENSOR["rate"])
    bandwidth: float | None = of_row(SENSOR["bandwidth"])
    force_noise: float = of_row(SENSOR["force_noise"])
    acceleration_noise: float = of_row(SENSOR["acceleration_noise"])
    seed: int = of_row(SENSOR["seed"])
    oversampling: int = of_row(SENSOR["oversampling"])


class Output(Section):
    """Where the result goes. Relative paths start at the folder the command is run in, not at that of the file."""

    file: str | None = Field(None, description="file of the result, .nc (netCDF) or .zarr, or the URL of a .zarr")
    plot: str | None = Field(None, description="plot of the map, .png, .svg or .pdf")
    variables: tuple[Annotated[str, BeforeValidator(_variable)], ...] | None = Field(
        None, description="variables of a map that are stored and written, the others are not; regime always is"
    )

    @field_validator("file", mode="before")
    @classmethod
    def _file(cls, value: object) -> str:
        return _file(value, OUTPUT_SUFFIXES)

    @field_validator("plot", mode="before")
    @classmethod
    def _plot(cls, value: object) -> str:
        return _file(value, PLOT_SUFFIXES)

    @field_validator("variables", mode="before")
    @classmethod
    def _names(cls, value: object) -> object:
        if isinstance(value, str):
            return (value,)
        if not isinstance(value, list | tuple) or not value:
            raise refused("a list of variables such as [regime, period]", "leave variables out to keep all of them")
        return value

    @field_validator("variables", mode="after")
    @classmethod
    def _in_order(cls, value: tuple[str, ...]) -> tuple[str, ...]:
        """Each once, in the order of the vocabulary; without the regime nobody could tell what is computed."""
        return tuple(name for name in VARIABLES if name in (*value, "regime"))

    def resolved(self) -> dict[str, Any]:
        """The section as plain data."""
        plain = super().resolved()
        return plain if self.variables is None else {**plain, "variables": list(self.variables)}
