"""The section `uncertain`, of inputs that are not known exactly: distributions, correlation, and the sampling.

`read_uncertain.py` reads quantities with their distributions and their correlation, and checks them.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Annotated, Any

import numpy as np
from numpy.typing import NDArray
from pydantic import Field, field_validator

from stickslip.config.sections import (
    BOOLEAN,
    POINTS_FILE,
    RESULT_FILE,
    Read,
    Schema,
    Section,
    StudySection,
    list_of,
    one_of,
    refused,
    with_rows,
)
from stickslip.vocabulary import units
from stickslip.vocabulary.quantities import SEARCHABLE
from stickslip.vocabulary.results import VARIABLES
from stickslip.vocabulary.settings import SUBSET, UNCERTAIN
from stickslip.vocabulary.suggest import listed

if TYPE_CHECKING:
    from stickslip.theory.distributions import Distribution

Floats = NDArray[np.float64]

METRICS = tuple(name for name in VARIABLES if name not in ("regime", "status", "steps"))
TENTH = 10  # one of so many samples of a level of subset simulation lies beyond it
NOT_WITH_SUBSET = ("draws", "scramblings", "seed", "metrics", "quantiles", "indices")

# --- distributions ----------------------------------------------------------------------------------------------------


DRAWN, TRUNCATED = "drawn", "truncated"
NUMBERS = {  # of distributions with a name of their own here
    "normal": ("mean", "std"), "lognormal": ("median", "factor"),
    "uniform": ("low", "high"), "triangular": ("low", "mode", "high"),
}  # fmt: skip
FORMS = listed(f"{kind}: {{{', '.join(numbers)}}}" for kind, numbers in NUMBERS.items())


class Scatter(Section):
    """The distribution of one quantity, in SI.

    kind : of `NUMBERS`, a continuous distribution of scipy.stats, or `DRAWN`. numbers : that describe it, by name, or
    the values that are drawn, by their places. ends : `low`, `high` or both, at which it is truncated.
    """

    kind: str
    numbers: dict[Any, float]
    ends: dict[str, float]

    @property
    def distribution(self) -> Distribution:
        """The map from standard normal deviates to values."""
        from stickslip.theory.distributions import distribution  # SciPy, which only this needs, takes its time

        return distribution(self.kind, [*self.numbers.values()], **self.ends)

    def in_words(self, name: str) -> str:
        """`normal, mean 0.8 m/s, std 0.05 m/s`, for the quantity of this name."""
        unit, values = units.spelled(SEARCHABLE[name].units), self.numbers.values()
        if self.kind == DRAWN:
            return f"one of {len(values)} values"
        words = [f"{key} {value:.6g} {unit if has_unit(self.kind, key) else ''}" for key, value in self.numbers.items()]
        if self.ends:
            low, high = self.ends.get("low", -math.inf), self.ends.get("high", math.inf)
            words.append(f"truncated to {low:.6g} ... {high:.6g} {unit}")
        return ", ".join([self.kind, *map(str.rstrip, words)])

    def resolved(self) -> dict[str, Any]:
        """The distribution as a file has it."""
        inside: Any = [*self.numbers.values()] if self.kind == DRAWN else dict(self.numbers)
        return {self.kind: inside} | ({TRUNCATED: dict(self.ends)} if self.ends else {})


def has_unit(kind: object, number: object) -> bool:
    """Whether a number of a distribution has the unit of the quantity, or is a pure one as a factor or a shape is."""
    return number != "factor" if kind in (*NUMBERS, DRAWN, TRUNCATED) else number in ("loc", "scale")


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


class SamplingSection(with_rows(StudySection, UNCERTAIN)):  # type: ignore[misc]
    """Draws of uncertain inputs, and statistics of the results."""

    key = "uncertain"
    subset: Subset | None = None  # None: Sobol points
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


class Uncertain(SamplingSection):
    """Inputs that are not known exactly, and how their scatter is carried to the result.

    quantities : in the order of the file; those that are drawn from values are drawn together, row by row.
    correlation : of their normal deviates, in that order (a Gaussian copula; for normal quantities it is their
    correlation); None where they are independent.
    """

    quantities: dict[str, Scatter]
    correlation: tuple[tuple[float, ...], ...] | None = None

    @property
    def names(self) -> tuple[str, ...]:
        """The quantities."""
        return tuple(self.quantities)

    @property
    def drawn(self) -> tuple[str, ...]:
        """Those that are drawn from values."""
        return tuple(name for name, scatter in self.quantities.items() if scatter.kind == DRAWN)

    @property
    def draws_per_cell(self) -> int:
        """Cells computed for each cell of the axes: by one simulation of a subset simulation, one level."""
        if self.subset is not None:
            return int(self.subset.samples * self.subset.repetitions)
        return int(self.draws * self.scramblings * (len(self.quantities) + 2 if self.indices else 1))

    @property
    def correlation_in_words(self) -> str:
        """The correlation of the quantities."""
        if len(self.drawn) > 1:
            return f"{listed(self.drawn, 'and')} are drawn together, row by row"
        return "none" if self.correlation is None else "of normal deviates (a Gaussian copula)"

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
            normals = normals @ np.linalg.cholesky(self.correlation).T
        column = {name: i for i, name in enumerate(self.names)}
        column |= {name: column[self.drawn[0]] for name in self.drawn}
        return {name: scatter.distribution.at(normals[:, column[name]]) for name, scatter in self.quantities.items()}

    def resolved(self) -> dict[str, Any]:
        """The section as plain data, which reads back as an equal one."""
        left_out = NOT_WITH_SUBSET if self.subset else ()
        whole = {name: value for name, value in super().resolved().items() if name not in left_out}
        if self.correlation is not None:
            whole["correlation"] = {"between": list(self.names), "matrix": whole["correlation"]}
        return whole
