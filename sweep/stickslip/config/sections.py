"""The sections of a configuration: frozen pydantic models, all in SI.

What is a number is declared in the vocabulary, and read and written as its row says: NaN where a word such as "none"
is given in the file. A quantity that varies along an axis is None here. What is no number is annotated with a `Read`,
which both the reader and the JSON Schema take it from.

Validators report what they refuse through `refused`, so that every message says what was expected.
"""

import re
from collections.abc import Callable, Collection, Mapping
from dataclasses import dataclass
from pathlib import PurePath
from typing import Annotated, Any, ClassVar, TypeVar

from pydantic import (
    BaseModel,
    ConfigDict,
    Field,
    GetCoreSchemaHandler,
    ValidationInfo,
    create_model,
    field_validator,
    model_validator,
)
from pydantic_core import CoreSchema, PydanticCustomError
from pydantic_core.core_schema import no_info_before_validator_function

from stickslip.errors import QuantityError
from stickslip.vocabulary import units
from stickslip.vocabulary.models import CURVE, LAW_MESSAGES, LAWS, OWN_NAME, WRITTEN_LAWS, law_remedy, own_names
from stickslip.vocabulary.own_laws import is_law
from stickslip.vocabulary.parameter import Parameter, Variable, of_section
from stickslip.vocabulary.quantities import EXECUTION, QUANTITIES, SOLVER, VARIABLES, did_you_mean, listed

REFUSED = "refused"  # type of the errors of `refused`, among pydantic's own
OUTPUT_SUFFIXES = (".nc", ".zarr")
REMOTE_SUFFIX = ".zarr"  # what may be behind a URL
PLOT_SUFFIXES = (".png", ".svg", ".pdf")
PAGE_SUFFIXES = (".html",)
HERE, LOCAL = "none", "local"  # where blocks are computed: by threads of this process; by processes of this machine
ADDRESS = f"an address such as tcp://host:8786, a scheduler file (.json), {LOCAL} or {HERE}"
_ADDRESS = rf"^({HERE}|{LOCAL}|[a-z]{{2,10}}://[^\s/]+:\d{{1,5}}|[^\0]+\.json)$"
_WITH_UNIT = r"^\s*[-+]?(\d+\.?\d*|\.\d+)([eE][-+]?\d{1,3})?\s*[A-Za-zµμ/].*$"

Schema = dict[str, Any]


def refused(expected: str, hint: str | None = None, kind: str | None = None) -> PydanticCustomError:
    """The error of a validator: what was expected, the next step, and what kind of quantity was given instead."""
    return PydanticCustomError(REFUSED, "expected {expected}", {"expected": expected, "hint": hint, "kind": kind})


def is_address(value: object) -> bool:
    """True if this names a Dask scheduler: by URL, by its scheduler file, or by one of the two words."""
    return isinstance(value, str) and re.fullmatch(_ADDRESS, value) is not None


# --- single values ----------------------------------------------------------------------------------------------------


@dataclass(frozen=True, eq=False)
class Read:
    """An annotation of a field: how the value of its key is read, and what the JSON Schema says of it."""

    read: Callable[[Any], Any]
    schema: Schema

    def __get_pydantic_core_schema__(self, source: Any, handler: GetCoreSchemaHandler) -> CoreSchema:
        return no_info_before_validator_function(self.read, handler(source))


VALUE: Schema = {"anyOf": [{"type": "number"}, {"type": "string", "pattern": _WITH_UNIT}]}
RANGE: Schema = {"type": "array", "minItems": 2, "maxItems": 2, "items": VALUE}


def number(row: Parameter, value: object) -> float:
    """The value of a row of the vocabulary as a file gives it, in SI; NaN for its word."""
    try:
        return row.read(value)
    except QuantityError as error:
        remedy = f"leave {row.name} out for {row.absent}" if row.default is None and row.absent else None
        if isinstance(value, list | dict) and row.name in QUANTITIES:
            remedy = f"what varies belongs to axes: {{{row.name}: ...}}"
        raise refused(error.expected, error.hint or remedy, error.kind) from None


def finite(row: Parameter, value: object) -> float:
    """The value of a row of the vocabulary, for which no word may stand."""
    if (si := number(row, value)) != si:
        raise refused(row.expected.removesuffix(row.otherwise))
    return si


def each_with_unit(row: Parameter | Variable, given: Any) -> Any:
    """Values of a row of the vocabulary, as `units.each_with_unit` has them."""
    try:
        return units.each_with_unit(given, row.units)
    except QuantityError as error:
        raise refused(error.expected) from None


def interval(row: Parameter, value: object) -> tuple[float, float]:
    """Both ends of a range of a row of the vocabulary, in SI and in order."""
    if not isinstance(value, list | tuple) or len(value) != 2:
        raise refused("a list of two values, the lower end first")
    low, high = (finite(row, end) for end in each_with_unit(row, value))
    if not low < high:
        raise refused("the lower end first and the upper above it", "swap the ends" if low > high else None)
    return low, high


def number_schema(row: Parameter) -> Schema:
    """A number within the bounds of a row, a text with a unit, or the word for NaN."""
    bare: Schema = {"type": "integer" if row.whole else "number"}
    if row.units != "1":
        bare["description"] = f"in {units.spelled(row.units)}"
    bounds = {"exclusiveMinimum": row.above, "minimum": row.at_least, "maximum": row.at_most}
    forms = [bare | {key: bound for key, bound in bounds.items() if bound is not None}]
    if row.units != "1":
        forms.append({"type": "string", "pattern": _WITH_UNIT, "examples": [units.example(row.units)]})
    if row.word:
        forms.append({"const": row.word})
    return forms[0] if len(forms) == 1 else {"anyOf": forms}


def choice(
    value: object, words: Collection[str], what: str = "", inside: bool = False, remedy: str | None = None
) -> str:
    """One of some words. what : they are, for messages. inside : it is a key of the value that messages quote.

    remedy : where no word is like it.
    """
    if not isinstance(value, str) or value not in words:
        hint = did_you_mean(str(value), words) or remedy
        got = f"{value!r} in it" if inside else None
        raise refused(f"{what}: {listed(words)}" if what else listed(words), hint, got)
    return value


def one_of(words: Collection[str], what: str = "") -> Read:
    """One of some words."""
    return Read(lambda value: value if value in [*words] else choice(value, words, what), {"enum": list(words)})


def list_of(
    words: Collection[str], expected: str, hint: str | None = None, *, unique: bool = False, single: bool = False,
    empty: bool = False,
) -> Read:  # fmt: skip
    """A list of words, whose items are annotated themselves.

    unique : none of them twice. single : also one of them without a list. empty : none at all is a list, too.
    """
    word: Schema = {"enum": list(words)}
    several: Schema = {"type": "array", "items": word} | ({} if empty else {"minItems": 1})
    several |= {"uniqueItems": True} if unique else {}

    def read(value: Any) -> Any:
        names = [value] if single and isinstance(value, str) else value
        if not isinstance(names, list | tuple) or not (names or empty):
            raise refused(expected, hint)
        if unique and len(set(map(str, names))) < len(names):
            raise refused("a list without repetitions")
        return names

    return Read(read, {"anyOf": [word, several]} if single else several)


def true_or_false(value: object) -> bool:
    """A boolean."""
    if not isinstance(value, bool):
        raise refused("true or false")
    return value


def file_name(*suffixes: str) -> Read:
    """The name of a file with one of these suffixes; of what may be remote also a URL."""

    def read(value: object) -> str:
        suffix = PurePath(value).suffix.lower() if isinstance(value, str) else ""
        if not isinstance(value, str) or suffix not in suffixes or not value.isprintable():
            hint = f"did you mean {value}{suffixes[0]}?" if value and isinstance(value, str) and not suffix else None
            raise refused(f"a file name that ends in {listed(suffixes)}", hint)
        if "://" in value and suffix != REMOTE_SUFFIX:
            raise refused(f"a file of this machine; what is behind a URL ends in {REMOTE_SUFFIX}")
        return value

    here = "|".join(re.escape(suffix) for suffix in suffixes if suffix != REMOTE_SUFFIX)
    local = f"^(?!.*://).*({here})$"
    pattern = f"{re.escape(REMOTE_SUFFIX)}$|{local}" if REMOTE_SUFFIX in suffixes else local
    return Read(read, {"type": "string", "pattern": pattern})


BOOLEAN = Read(true_or_false, {"type": "boolean"})
POINTS_FILE, RESULT_FILE = file_name(".csv"), file_name(*OUTPUT_SUFFIXES)


def _points(value: Any) -> Any:
    return tuple(map(POINTS_FILE.read, value)) if isinstance(value, list | tuple) and value else POINTS_FILE.read(value)


def _address(value: object) -> str:
    if not is_address(value):
        raise refused(ADDRESS)
    return str(value)


_FILES: Schema = {"type": "array", "minItems": 1, "items": POINTS_FILE.schema}
_POINTS = Read(_points, {"anyOf": [POINTS_FILE.schema, _FILES]})
_DASK = Read(_address, {"type": "string", "pattern": _ADDRESS, "examples": ["tcp://host:8786", LOCAL]})
_LAW = Read(
    lambda value: (
        str(value) if is_law(value) else choice(value, (*WRITTEN_LAWS, *own_names()), remedy=law_remedy(value))
    ),
    {"anyOf": [{"enum": list(LAWS)}, {"type": "string", "pattern": OWN_NAME}]},
)
_TABLE = Read(lambda value: value, {"type": ["string", "object"]})  # read in `resolve.py`
_EXAMPLE, _ALL = "a list of variables such as [regime, period]", "leave variables out to keep all of them"
_VARIABLES = list_of(VARIABLES, _EXAMPLE, _ALL, single=True)


# --- sections ---------------------------------------------------------------------------------------------------------


class Section(BaseModel):
    """A mapping of the file: no keys but its own, and nothing to change once it is read.

    rows : those of its fields that are numbers of the vocabulary.
    """

    model_config = ConfigDict(defer_build=True, extra="forbid", frozen=True)
    rows: ClassVar[Mapping[str, Parameter]] = {}

    @model_validator(mode="before")
    @classmethod
    def _mapping(cls, value: object) -> object:
        if not isinstance(value, dict | Section | None):
            raise refused(f"a mapping with the keys {listed(cls.model_fields)}")
        return {} if value is None else value

    @field_validator("*", mode="before")
    @classmethod
    def _number(cls, value: object, info: ValidationInfo) -> object:
        row = cls.rows.get(str(info.field_name))
        if row is None:
            return value
        si = number(row, value)
        return None if row.whole and si != si else si  # no whole number is NaN

    def resolved(self) -> dict[str, Any]:
        """The section as plain data: words for NaN, lists for tuples, nothing for None."""
        given = {name: plain(value) for name, value in self if value is not None}
        return {name: self.rows[name].written(value) if name in self.rows else value for name, value in given.items()}

    def __eq__(self, other: object) -> bool:
        """Equality of what is resolved, in this order; NaN, which stands for a word, is equal to itself."""
        if type(self) is not type(other):
            return NotImplemented
        return repr(self.resolved()) == repr(other.resolved())


class StudySection(Section):
    """The section of a study: what a configuration asks for instead of a map of every cell.

    key : of the section in the file. is_map : whether what comes out is a map all the same. has_cells : whether what it
    is about are cells on a steady belt, which have regimes.
    options : of the command, where they are not called as the fields.
    """

    key: ClassVar[str]
    options: ClassVar[Mapping[str, str]] = {}

    @property
    def action(self) -> str:
        """The action, for the history of a result: `border along belt_speed`."""
        along = getattr(self, "along", None)
        return f"{self.key} along {along}" if along else self.key

    is_map: ClassVar[bool] = False
    has_cells: ClassVar[bool] = True


AnySection = TypeVar("AnySection", bound=Section)


def plain(value: Any) -> Any:
    """A value of a field as plain data."""
    if isinstance(value, Section):
        return value.resolved()
    if isinstance(value, tuple):
        return list(map(plain, value))
    return {key: plain(inner) for key, inner in value.items()} if isinstance(value, dict) else value


def of_row(row: Parameter) -> Any:
    """The field of a number: None where it is absent."""
    default = row.default
    return Field(None if default is None or row.may_be_absent else default, description=row.long_name)


def with_rows(base: type[AnySection], rows: Mapping[str, Parameter], varied: bool = False) -> type[AnySection]:
    """The section with a field for each of these rows of the vocabulary; `varied` ones are None along an axis."""
    fields: dict[str, Any] = {
        name: (float | None, None) if varied else (int | None if row.whole else float | None, of_row(row))
        for name, row in rows.items()
    }
    model = create_model(f"{base.__name__}_", __base__=base, **fields)
    model.rows = {**base.rows, **rows}
    return model


def with_quantities(base: type[AnySection], section: str) -> type[AnySection]:
    """The section with a field for each quantity that the vocabulary puts there."""
    return with_rows(base, of_section(section, QUANTITIES.values()), varied=True)


class System(with_quantities(Section, "system")):  # type: ignore[misc]
    """The oscillator: a mass on a belt, held by a spring and a damper."""


class _Law(Section):
    law: Annotated[str, _LAW] = Field(
        "stribeck",
        description="shape of the weakening: " + "; ".join(f"{law}: {LAW_MESSAGES[law]}" for law in WRITTEN_LAWS),
    )
    fit: Annotated[str | tuple[str, ...] | None, _POINTS] = Field(
        None,
        description="CSV file of measured slip speeds and friction coefficients that "
        f"{CURVE.level} to {CURVE.decay} are fitted to; a list of files is an axis of materials",
    )
    table: Annotated[dict[str, Any] | None, _TABLE] = Field(
        None,
        description="CSV file of measured slip speeds and friction coefficients that are the curve as they are, in "
        f"place of {CURVE.level} to {CURVE.decay}, or {{file: FILE.csv, monotone: true}}",
    )


class Friction(with_quantities(_Law, "friction")):  # type: ignore[misc]
    """The friction curve, by its coefficients or by what is measured of it, and what else the contact is."""


class Start(with_quantities(Section, "start")):  # type: ignore[misc]
    """The initial state."""


class Solver(with_rows(Section, SOLVER)):  # type: ignore[misc]
    """Integration of the cells: accuracy, and how long."""

    early_stop: Annotated[bool, BOOLEAN] = Field(
        True, description="stop as soon as the regime is decided; false integrates every cell to the horizon"
    )

    @field_validator("early_stop")
    @classmethod
    def _early_stop(cls, value: bool, info: ValidationInfo) -> bool:
        if not value and info.data.get("horizon", 0.0) is None:  # a horizon that was refused is not in `data`
            raise refused("true, because no horizon is given", "add a horizon such as '100 s' to solver")
        return value


class Execution(with_rows(Section, EXECUTION)):  # type: ignore[misc]
    """Machines that compute. They do not change the result."""

    dask: Annotated[str | None, _DASK] = Field(
        None, description=f"where blocks are computed, if not by threads of this process: {ADDRESS}"
    )


class Output(Section):
    """Files of the result. Relative paths start at the folder the command is run in, not at that of the file."""

    file: Annotated[str | None, file_name(*OUTPUT_SUFFIXES)] = Field(
        None, description="file of the result, .nc (netCDF) or .zarr, or the URL of a .zarr"
    )
    plot: Annotated[str | None, file_name(*PLOT_SUFFIXES)] = Field(
        None, description="plot of the map, .png, .svg or .pdf"
    )
    report: Annotated[str | None, file_name(*PAGE_SUFFIXES)] = Field(
        None, description="page of the result, .html: plots and meanings"
    )
    variables: Annotated[tuple[Annotated[str, one_of(VARIABLES, "a variable of a map")], ...] | None, _VARIABLES] = (
        Field(None, description="variables of a map that are kept, regime among them; what none needs is not computed")
    )

    @field_validator("variables")
    @classmethod
    def _in_order(cls, value: tuple[str, ...]) -> tuple[str, ...]:
        """Each once, in the order of the vocabulary; without the regime nobody could tell what is computed."""
        return tuple(name for name in VARIABLES if name in (*value, "regime"))
