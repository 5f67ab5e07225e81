"""The section `uncertain`, of inputs that are not known exactly: distributions, correlation, and the sampling."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Annotated, Any

import numpy as np
from numpy.typing import NDArray
from pydantic import Field, field_validator

from stickslip.config.sections import (
    BOOLEAN,
    POINTS_FILE,
    Read,
    Schema,
    Section,
    StudySection,
    list_of,
    of_row,
    one_of,
    plain,
    refused,
)
from stickslip.vocabulary import units
from stickslip.vocabulary.quantities import SEARCHABLE
from stickslip.vocabulary.results import VARIABLES
from stickslip.vocabulary.settings import SUBSET, UNCERTAIN
from stickslip.vocabulary.suggest import listed

if TYPE_CHECKING:
    from stickslip.theory.distributions import Distribution

Floats = NDArray[np.float64]

# By kind of distribution: what describes it. All in the unit of the quantity, but for the pure number `factor`.
ARGUMENTS: dict[str, tuple[str, ...]] = {
    "normal": ("mean", "std"), "lognormal": ("median", "factor"), "uniform": ("low", "high"),
    "triangular": ("low", "mode", "high"),
}  # fmt: skip
METRICS = tuple(name for name in VARIABLES if name not in ("regime", "status", "steps"))
TENTH = 10  # one of so many samples of a level of subset simulation lies beyond it


class Scatter(Section):
    """One quantity with its distribution; `name` is its key in the file.

    arguments : in the order of `ARGUMENTS`, in SI. low, high : where it is truncated; -inf and inf for nowhere.
    """

    name: str
    kind: str
    arguments: tuple[float, ...]
    low: float = -math.inf
    high: float = math.inf

    @property
    def distribution(self) -> Distribution:
        """The map from standard normal deviates to values."""
        from stickslip.theory.distributions import KINDS, Truncated  # SciPy, which only this needs, takes its time

        whole = KINDS[self.kind](*self.arguments)
        return Truncated(whole, self.low, self.high) if self.is_truncated else whole

    @property
    def is_truncated(self) -> bool:
        """True if a part of the distribution is cut off."""
        return math.isfinite(self.low) or math.isfinite(self.high)

    @property
    def in_words(self) -> str:
        """`normal, mean 0.8 m/s, std 0.05 m/s`."""
        unit, numbers = units.spelled(SEARCHABLE[self.name].units), []
        for name, value in zip(ARGUMENTS[self.kind], self.arguments, strict=True):
            numbers.append(f"{name} {value:.6g} {'' if name == 'factor' else unit}".rstrip())
        if self.is_truncated:
            numbers.append(f"truncated to {self.low:.6g} ... {self.high:.6g} {unit}".rstrip())
        return f"{self.kind}, {', '.join(numbers)}"

    def resolved(self) -> dict[str, Any]:
        """The distribution as plain data, without the name."""
        whole = {self.kind: dict(zip(ARGUMENTS[self.kind], self.arguments, strict=True))}
        ends = {name: end for name, end in (("low", self.low), ("high", self.high)) if math.isfinite(end)}
        return whole | ({"truncated": ends} if ends else {})


class Subset(Section):
    """Subset simulation: rare stick-slip, one order of magnitude after the other."""

    rows = SUBSET
    samples: int = of_row(SUBSET["samples"])
    repetitions: int = of_row(SUBSET["repetitions"])
    seed: int = of_row(SUBSET["seed"])

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


class Sampling(StudySection):
    """How uncertain inputs are drawn, and what is told of the results."""

    key = "uncertain"
    rows = UNCERTAIN
    draws: int = of_row(UNCERTAIN["draws"])
    scramblings: int = of_row(UNCERTAIN["scramblings"])
    seed: int = of_row(UNCERTAIN["seed"])
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

    @field_validator("draws")
    @classmethod
    def _draws(cls, value: int) -> int:
        if value & (value - 1):
            near = 2 ** round(math.log2(value))
            raise refused("a power of two", f"Sobol points are even in powers of two; the nearest is {near}")
        return value


class Uncertain(Sampling):
    """Inputs that are not known exactly, and how their scatter is carried to the result.

    quantities : in the order of the file. correlation : of their normal deviates, in that order (a Gaussian copula;
    for normal quantities it is their correlation); None where they are independent. subset : None for Sobol points.
    """

    quantities: tuple[Scatter, ...]
    correlation: tuple[tuple[float, ...], ...] | None = None
    subset: Subset | None = None

    @property
    def names(self) -> tuple[str, ...]:
        """The quantities."""
        return tuple(one.name for one in self.quantities)

    @property
    def draws_per_cell(self) -> int:
        """Cells computed for each cell of the axes: by one simulation of a subset simulation, one level."""
        if self.subset is not None:
            return self.subset.samples * self.subset.repetitions
        return self.draws * self.scramblings * (len(self.quantities) + 2 if self.indices else 1)

    @property
    def correlation_in_words(self) -> str:
        """The correlation of the quantities, and the meaning of its numbers."""
        if self.correlation is None:
            return "none: the quantities are independent"
        if all(one.kind == "normal" and not one.is_truncated for one in self.quantities):
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
            normals = normals @ np.linalg.cholesky(np.array(self.correlation)).T
        return {one.name: one.distribution.at(normals[:, i]) for i, one in enumerate(self.quantities)}

    def resolved(self) -> dict[str, Any]:
        """The section as plain data, which reads back as an equal one."""
        settings = ("fit",) if self.subset else tuple(Sampling.model_fields)
        given = {name: plain(value) for name in settings if (value := getattr(self, name)) is not None}
        if self.subset is not None:
            given["subset"] = self.subset.resolved()
        given["quantities"] = {one.name: one.resolved() for one in self.quantities}
        if self.correlation is not None:
            given["correlation"] = {"between": list(self.names), "matrix": plain(self.correlation)}
        return given
