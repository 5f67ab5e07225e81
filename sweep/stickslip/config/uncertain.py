"""The section `uncertain`, of inputs that are not known exactly: distributions, correlation, and the sampling.

The models are shaped like the file; `read_uncertain.py` checks what must hold between them.
"""

from __future__ import annotations

import math
from collections.abc import Collection
from typing import TYPE_CHECKING, Annotated, Any

import numpy as np
from numpy.typing import NDArray
from pydantic import BeforeValidator, Field, ValidationInfo, field_validator, model_validator

from stickslip.config.ranges import each_with_unit
from stickslip.config.sections import (
    BOOLEAN,
    POINTS_FILE,
    RESULT_FILE,
    VALUE,
    Read,
    Schema,
    Section,
    StudySection,
    finite,
    list_of,
    one_of,
    refused,
    with_rows,
)
from stickslip.errors import QuantityError
from stickslip.vocabulary import units
from stickslip.vocabulary.parameter import Parameter
from stickslip.vocabulary.quantities import SEARCHABLE
from stickslip.vocabulary.results import VARIABLES
from stickslip.vocabulary.settings import SUBSET, UNCERTAIN
from stickslip.vocabulary.suggest import listed

if TYPE_CHECKING:
    from stickslip.theory.distributions import Distribution, Drawn

Floats = NDArray[np.float64]

METRICS = tuple(name for name in VARIABLES if name not in ("regime", "status", "steps"))
TENTH = 10  # one of so many samples of a level of subset simulation lies beyond it
_LARGEST = 1e100  # numbers of distributions and matrices, whose squares are to be finite
NOT_WITH_SUBSET = ("draws", "scramblings", "seed", "metrics", "quantiles", "indices")
_MORE_THAN = {  # by number of a distribution: what it must exceed, and a hint
    "std": (0.0, "a quantity that does not scatter belongs in its section"),
    "median": (0.0, None),
    "factor": (1.0, "68 % of the values lie within this factor of the median, up or down"),
}
_EXAMPLE = "between: [mass, stiffness], matrix: [[1, 0.5], [0.5, 1]]"

# --- distributions ----------------------------------------------------------------------------------------------------


class _Numbers(Section):
    """The numbers of a distribution, in SI; the context in which they are read is the row of its quantity."""

    @field_validator("*", mode="before")
    @classmethod
    def _number(cls, value: object, info: ValidationInfo) -> float:
        name = str(info.field_name)
        row: Parameter = info.context  # type: ignore[assignment]
        unit, (least, hint) = "1" if name == "factor" else row.units, _MORE_THAN.get(name, (-math.inf, None))
        try:
            number = units.si_value(value, unit)
        except QuantityError as error:
            raise refused(error.expected, error.hint, error.found) from None
        if not abs(number) < _LARGEST:
            raise refused(f"a number below {_LARGEST:g}")
        if not number > least:
            raise refused(f"more than {least:g} {units.spelled(unit)}".rstrip(), hint)
        low, mode = info.data.get("low"), info.data.get("mode")
        if name == "high" and low is not None and number <= low:
            hint = "swap low and high" if low > number else "a quantity that does not scatter belongs in its section"
            raise refused(f"more than low ({low:g} {units.spelled(unit)}".rstrip() + ")", hint)
        if (name == "mode" and low is not None and number < low) or (mode is not None and number < mode):
            raise refused("low, mode and high in this order", "mode is the most probable value")
        return number


class Normal(_Numbers):
    """The normal distribution."""

    mean: float
    std: float


class Lognormal(_Numbers):
    """The lognormal distribution; 68 % of the values lie within a factor of the median."""

    median: float
    factor: float = Field(json_schema_extra={"type": "number", "exclusiveMinimum": 1})


class Uniform(_Numbers):
    """The uniform distribution."""

    low: float
    high: float


class Triangular(_Numbers):
    """The triangular distribution; mode is the most probable value."""

    low: float
    mode: float
    high: float


class Ends(_Numbers):
    """The ends at which a distribution is truncated."""

    low: float | None = None
    high: float | None = None


def _two_ends(value: Any) -> Any:
    """`[low, high]` for `{low: low, high: high}`."""
    return {"low": value[0], "high": value[1]} if isinstance(value, list) and len(value) == 2 else value


class Scatter(Section):
    """The distribution of one quantity: one of four kinds, maybe truncated."""

    normal: Normal | None = None
    lognormal: Lognormal | None = None
    uniform: Annotated[Uniform | None, BeforeValidator(_two_ends)] = None
    triangular: Triangular | None = None
    drawn: tuple[float, ...] | None = Field(None, json_schema_extra={"type": "array", "minItems": 2, "items": VALUE})
    truncated: Ends | None = None

    @model_validator(mode="before")
    @classmethod
    def _one_unit(cls, value: Any, info: ValidationInfo) -> Any:
        return value if info.context is None else each_with_unit(info.context, value)

    @field_validator("drawn", mode="before")
    @classmethod
    def _values(cls, values: Any, info: ValidationInfo) -> tuple[float, ...]:
        if not isinstance(values, list | tuple) or len(values) < 2:
            raise refused("a list of values, each of which is as probable as any other")
        return tuple(finite(info.context, value) for value in values)  # type: ignore[arg-type]

    @model_validator(mode="after")
    def _one_kind(self) -> Scatter:
        if len(kinds := [name for name, value in self if value is not None and name != "truncated"]) != 1:
            raise refused(f"one of {_FORMS}", found=listed(kinds, "and") if kinds else None)
        if self.drawn is not None and self.truncated is not None:
            raise refused("drawn values alone", "leave out those beyond the ends, with all that is drawn together")
        return self

    @property
    def kind(self) -> str:
        """The name of its kind."""
        return next(name for name, value in self if value is not None)

    @property
    def numbers(self) -> dict[str, float]:
        """The numbers that describe the kind, by name; none of drawn values."""
        return dict(() if self.drawn is not None else getattr(self, self.kind))

    @property
    def ends(self) -> dict[str, float]:
        """The ends at which it is truncated, `low`, `high` or both."""
        return {name: end for name, end in self.truncated or () if end is not None}

    @property
    def distribution(self) -> Distribution | Drawn:
        """The map from standard normal deviates to values."""
        from stickslip.theory.distributions import KINDS, Drawn  # SciPy, which only this needs, takes its time

        if self.drawn is not None:
            return Drawn(self.drawn)
        ends = self.ends.get("low", -math.inf), self.ends.get("high", math.inf)
        return KINDS[self.kind](*self.numbers.values(), *ends)

    def in_words(self, name: str) -> str:
        """`normal, mean 0.8 m/s, std 0.05 m/s`, for the quantity of this name."""
        unit = units.spelled(SEARCHABLE[name].units)
        if self.drawn is not None:
            return f"one of {len(self.drawn)} values, {min(self.drawn):.6g} to {max(self.drawn):.6g} {unit}".rstrip()
        words = [f"{key} {value:.6g} {'' if key == 'factor' else unit}".rstrip() for key, value in self.numbers.items()]
        if self.ends:
            low, high = self.ends.get("low", -math.inf), self.ends.get("high", math.inf)
            words.append(f"truncated to {low:.6g} ... {high:.6g} {unit}".rstrip())
        return f"{self.kind}, {', '.join(words)}"


_FORMS = listed(
    f"{model.__name__.lower()}: {{{', '.join(model.model_fields)}}}"
    for model in (Normal, Lognormal, Uniform, Triangular)
)


class Matrix(Section):
    """A correlation or covariance matrix of some quantities; the context in which it is read are the possible ones."""

    between: tuple[str, ...] = Field(
        json_schema_extra={"type": "array", "minItems": 2, "uniqueItems": True, "items": {"enum": list(SEARCHABLE)}}
    )
    matrix: tuple[tuple[float, ...], ...] = Field(
        json_schema_extra={"type": "array", "minItems": 2, "items": {"type": "array", "items": {"type": "number"}}}
    )

    @field_validator("between", mode="before")
    @classmethod
    def _names(cls, names: Any, info: ValidationInfo) -> Any:
        possible: Collection[str] = info.context or ()
        if not (isinstance(names, list) and len(names) > 1 and len(set(map(str, names))) == len(names)
                and all(isinstance(name, str) and name in possible for name in names)):  # fmt: skip
            raise refused(f"two or more of the uncertain quantities: {listed(possible)}", _EXAMPLE)
        return names

    @field_validator("matrix", mode="before")
    @classmethod
    def _symmetric(cls, rows: Any, info: ValidationInfo) -> Any:
        if (names := info.data.get("between")) is None:
            return ()  # refused already
        size = len(names)
        if not isinstance(rows, list) or [len(row) if isinstance(row, list) else 0 for row in rows] != [size] * size:
            raise refused(f"{size} rows of {size} numbers", _EXAMPLE)
        if not all(type(value) in (int, float) and abs(value) < _LARGEST for row in rows for value in row):
            raise refused(f"{size} rows of {size} numbers", _EXAMPLE)
        matrix = np.array(rows, np.float64)
        for i, j in np.argwhere(~np.isclose(matrix, matrix.T, rtol=1e-9, atol=0))[:1]:
            hint = f"{names[i]} with {names[j]} has {matrix[i, j]:g} in one place and {matrix[j, i]:g} in the other"
            raise refused("a symmetric matrix", hint)
        return ((matrix + matrix.T) / 2).tolist()

    @property
    def values(self) -> Floats:
        """The matrix as an array."""
        return np.array(self.matrix, np.float64)


# --- sampling ---------------------------------------------------------------------------------------------------------


class Subset(with_rows(Section, SUBSET)):  # type: ignore[misc]
    """Subset simulation: rare stick-slip, one order of magnitude after the other."""

    @field_validator("samples")
    @classmethod
    def _samples(cls, value: int) -> int:
        if value % TENTH:
            raise refused("a multiple of 10", "a tenth of the samples of a level start the next one")
        return value


def _quantiles(value: object) -> tuple[float, ...]:
    numbers = value if isinstance(value, list | tuple) else [value]
    good = all(isinstance(q, int | float) and not isinstance(q, bool) and 0 < q < 1 for q in numbers)
    if not good or list(numbers) != sorted(set(numbers)):
        raise refused("a list of numbers between 0 and 1, rising")
    return tuple(map(float, numbers))


_QUANTILE: Schema = {"exclusiveMinimum": 0, "exclusiveMaximum": 1}


class Sampling(with_rows(StudySection, UNCERTAIN)):  # type: ignore[misc]
    """Draws of uncertain inputs, and statistics of the results."""

    key = "uncertain"
    metrics: Annotated[
        tuple[Annotated[str, one_of(METRICS, "a result")], ...],
        list_of(METRICS, "a list of results", unique=True, single=True, empty=True),
    ] = Field(
        ("period", "slip_speed_max"),
        description="results whose mean and quantiles are told, of the draws that have them",
    )
    quantiles: Annotated[
        tuple[float, ...], Read(_quantiles, {"type": "array", "uniqueItems": True, "items": _QUANTILE})
    ] = Field((0.05, 0.5, 0.95), description="quantiles of the metrics, between 0 and 1")
    indices: Annotated[bool, BOOLEAN] | None = Field(
        None,
        description="whether Sobol indices are computed; unless given they are where inputs are independent",
        json_schema_extra=BOOLEAN.schema,
    )
    fit: Annotated[str, POINTS_FILE] | None = Field(
        None,
        description="CSV file of measured slip speeds and friction coefficients: the curve scatters as fitted",
        json_schema_extra=POINTS_FILE.schema,
    )
    explained: Annotated[str, RESULT_FILE] | None = Field(
        None,
        description="result of an explanation: what it is about and this configuration does not say is drawn from it",
        json_schema_extra=RESULT_FILE.schema,
    )

    @field_validator("draws")
    @classmethod
    def _draws(cls, value: int) -> int:
        if value & (value - 1):
            near = 2 ** round(math.log2(value))
            raise refused("a power of two", f"Sobol points are even in powers of two; the nearest is {near}")
        return value


class Uncertain(Sampling):
    """Inputs that are not known exactly, and how their scatter is carried to the result.

    subset : None for Sobol points. quantities : in the order of the file; those that are drawn from values are drawn
    together, row by row. correlation : of their normal deviates, in
    that order (a Gaussian copula; for normal quantities it is their correlation); None where they are independent.
    """

    subset: Subset | None = None
    quantities: dict[str, Scatter]
    correlation: Matrix | None = None

    @property
    def names(self) -> tuple[str, ...]:
        """The quantities."""
        return tuple(self.quantities)

    @property
    def drawn(self) -> tuple[str, ...]:
        """Those that are drawn from values."""
        return tuple(name for name, scatter in self.quantities.items() if scatter.drawn is not None)

    @property
    def draws_per_cell(self) -> int:
        """Cells computed for each cell of the axes: by one simulation of a subset simulation, one level."""
        if self.subset is not None:
            return int(self.subset.samples * self.subset.repetitions)
        return int(self.draws * self.scramblings * (len(self.quantities) + 2 if self.indices else 1))

    @property
    def correlation_in_words(self) -> str:
        """The correlation of the quantities, and the meaning of its numbers."""
        if len(self.drawn) > 1:
            return f"{listed(self.drawn, 'and')} are drawn together, row by row"
        if self.correlation is None:
            return "none: the quantities are independent"
        if all(scatter.normal is not None and not scatter.ends for scatter in self.quantities.values()):
            return f"{listed(self.names, 'and')} are jointly normal"
        return f"the normal deviates of {listed(self.names, 'and')} are correlated (a Gaussian copula)"

    @property
    def method_in_words(self) -> str:
        """The method by which the quantities are drawn."""
        if (of := self.subset) is not None:
            return f"subset simulation: {of.repetitions} repetitions with {of.samples} samples a level, seed {of.seed}"
        words = f"scrambled Sobol points: {self.scramblings} scramblings of {self.draws} draws, seed {self.seed}"
        return words + ("; Sobol indices by Saltelli (first order) and Jansen (total)" if self.indices else "")

    def values(self, normals: Floats) -> dict[str, Floats]:
        """Quantities in SI by name, each (n,), from independent standard normal deviates (n, quantities)."""
        if self.correlation is not None:
            normals = normals @ np.linalg.cholesky(self.correlation.values).T
        column = {name: i for i, name in enumerate(self.names)}
        column |= {name: column[self.drawn[0]] for name in self.drawn}
        return {name: scatter.distribution.at(normals[:, column[name]]) for name, scatter in self.quantities.items()}

    def resolved(self) -> dict[str, Any]:
        """The section as plain data, which reads back as an equal one."""
        left_out = NOT_WITH_SUBSET if self.subset else ()
        return {name: value for name, value in super().resolved().items() if name not in left_out}
