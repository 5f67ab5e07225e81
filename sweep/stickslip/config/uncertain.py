"""The section `uncertain`, of inputs not known exactly: distributions, correlation, and the sampling; and its
reading, against what is physically possible.
"""

from __future__ import annotations

import math
from collections.abc import Collection, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING, Annotated, Any

import numpy as np
from numpy.typing import NDArray
from pydantic import Field, field_validator

from stickslip.config.problems import ProblemCollector
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
from stickslip.errors import Path, QuantityError
from stickslip.vocabulary import units
from stickslip.vocabulary.quantities import SEARCHABLE, SUBSET, UNCERTAIN, VARIABLES, listed

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

    def resolved(self) -> dict[str, Any]:
        """The distribution as a file has it."""
        inside: Any = [*self.numbers.values()] if self.kind == DRAWN else dict(self.numbers)
        return {self.kind: inside} | ({TRUNCATED: dict(self.ends)} if self.ends else {})

    def text(self, unit: str) -> str:
        """The distribution of a quantity with this SI unit, for people: `normal, mean 10 N, std 1 N`."""
        if self.kind == DRAWN:
            return f"one of {len(self.numbers)} values"
        with_ends = self.numbers | {f"{TRUNCATED} at {end}": value for end, value in self.ends.items()}
        unit = units.spelled(unit)
        own = {name for name in self.numbers if not has_unit(self.kind, name)}
        return ", ".join([self.kind, *(f"{name} {value:.6g} {'' if name in own else unit}".rstrip()
                                       for name, value in with_ends.items())])  # fmt: skip


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


# --- reading ----------------------------------------------------------------------------------------------------------

SECTION = "uncertain"
QUANTITIES_PATH: Path = (SECTION, "quantities")
_ALLOWED_OUTSIDE = 1e-6  # of the points: rarely met, and then such a draw is `failed`
_LEAST_INSIDE = 1e-6  # of a distribution that is truncated; from less, what is left has no digits
_SMALLEST_EIGENVALUE = 1e-12  # of a correlation matrix
_LARGEST = 1e100  # numbers of distributions, whose squares are to be finite
_NEEDED = "numbers that make one: std and median above 0, factor above 1, low below high, mode between them"
_EXAMPLE = "between: [mass, stiffness], matrix: [[1, 0.5], [0.5, 1]]"
_ENDS = ("low", "high")


def read_uncertain(problems: ProblemCollector, raw: object, early_stop: bool) -> Uncertain | None:
    """The section in plain data `raw`; None where something is wrong with it. early_stop : of the solver."""
    path: Path = (SECTION,)
    data = problems.keys_of(raw, path, ("quantities", "correlation", *SamplingSection.model_fields))
    sampling = problems.section_of(
        SamplingSection, path, {key: data[key] for key in data if key in SamplingSection.model_fields}
    )
    for name in sampling.metrics if early_stop else ():
        if VARIABLES[name].when == "full":
            problems.refuse((*path, "metrics"), f"no {name}: it needs solver: {{early_stop: false}} and a horizon")
    for key in (key for key in NOT_WITH_SUBSET if key in data and "subset" in data):
        hint = "subset simulation tells the probability of stick-slip and nothing else"
        problems.add((*path, key), f"got {key} besides subset, expected one of them", hint, at_key=True)
    given = problems.mapping(data.get("quantities"), QUANTITIES_PATH, "names of quantities")
    if not given:
        if data.get("quantities") in (None, {}):
            problems.add(QUANTITIES_PATH, "missing, expected quantities with distributions",
                         "quantities: {belt_speed: {normal: {mean: 0.8 m/s, std: 0.05 m/s}}}")  # fmt: skip
        return None
    read = {name: _scatter(problems, name, value) for name, value in given.items()}
    scatters = {name: scatter for name, scatter in read.items() if scatter is not None}
    if len(scatters) < len(given):
        return None
    drawn = {name: len(scatter.numbers) for name, scatter in scatters.items() if scatter.kind == DRAWN}
    first = next(iter(drawn), "")
    for name in (name for name, size in drawn.items() if size != drawn[first]):
        message = f"got {drawn[name]} values, expected {drawn[first]} like {first}: they are drawn together, row by row"
        problems.add((*QUANTITIES_PATH, name, DRAWN), message)
    if drawn and sampling.subset:
        message = f"got it beside {first}, which is drawn from values and leads nowhere"
        problems.add((*path, "subset"), message, "leave subset out, and count draws")
    correlation = _correlation(problems, data.get("correlation"), [*scatters], drawn)
    independent = correlation is None and len(drawn) < 2
    if not independent and sampling.indices:
        problems.refuse((*path, "indices"), "false: Sobol indices are defined for independent inputs",
                        "leave the correlation out to see which input matters")  # fmt: skip
    settings = dict(sampling) | {"indices": independent if sampling.indices is None else sampling.indices}
    whole: Uncertain = Uncertain.model_construct(**settings, quantities=scatters, correlation=correlation)
    return whole


# --- one quantity -----------------------------------------------------------------------------------------------------


def _scatter(problems: ProblemCollector, name: str, raw: Any) -> Scatter | None:
    """A quantity with its distribution; None, and problems, where something is wrong with it."""
    from stickslip.theory.distributions import numbers_of  # SciPy takes its time

    path, before = (*QUANTITIES_PATH, name), len(problems.problems)
    if name not in SEARCHABLE:
        problems.unknown_key(path, SEARCHABLE, "quantity")
        return None
    kinds = [str(key) for key in raw if key != TRUNCATED] if isinstance(raw, dict) else []
    known = [key for key in kinds if key in (*NUMBERS, DRAWN) or numbers_of(key)]
    if len(known) != 1 and len(kinds) != 1:
        problems.refuse(path, f"one of {FORMS}", kind=listed(kinds, "and") if kinds else None)
        return None
    kind = next((key for key in kinds if key not in known), kinds[0])
    inside, ends = raw.get(kind), raw.get(TRUNCATED)
    names: Any = NUMBERS.get(kind) or numbers_of(kind)
    if kind == DRAWN:
        names = range(len(inside)) if isinstance(inside, list) else ()
        if len(names) < 2 or ends:
            problems.refuse((*path, kind), "a list of values, each of which is as probable as any other, and no ends")
            return None
    elif not names:
        hint = "others have their names in scipy.stats, if their quantiles are known in closed form"
        problems.unknown_key((*path, kind), (*NUMBERS, DRAWN, TRUNCATED), hint=hint)
        return None
    if kind in (DRAWN, "uniform") and isinstance(inside, list) and len(inside) == len(names):
        inside = dict(zip(names, inside, strict=True))
    else:
        inside = problems.keys_of(inside, (*path, kind), names)
    missing = [key for key in names if key not in inside] if len(problems.problems) == before else []
    for key in missing:
        problems.add((*path, kind, key), f"missing, expected {listed(names, 'and')}")
    limits = problems.keys_of(ends, (*path, TRUNCATED), _ENDS)
    given: dict[Path, Any] = {(kind, key): value for key, value in inside.items()}
    values = _in_si(problems, path, given | {(TRUNCATED, end): value for end, value in limits.items()})
    if len(problems.problems) > before:
        return None
    numbers = {key: values[kind, key] for key in names}
    scatter = Scatter(kind=kind, numbers=numbers, ends={end: values[TRUNCATED, end] for end in limits})
    _check(problems, scatter, path)
    return scatter if len(problems.problems) == before else None


def _in_si(problems: ProblemCollector, path: Path, given: dict[Path, Any]) -> dict[Path, float]:
    """The numbers of a quantity in SI, by their places within it."""
    row = SEARCHABLE[str(path[-1])]
    with_unit = [place for place in given if has_unit(*place)]
    values: dict[Path, float] = {}
    try:
        whole = units.each_with_unit([given[place] for place in with_unit], row.units)
    except QuantityError as error:
        problems.refuse(path, error.expected)
        return values
    for place, value in (given | dict(zip(with_unit, whole, strict=True))).items():
        try:
            values[place] = units.si_value(value, row.units if place in with_unit else "1")
            if not abs(values[place]) < _LARGEST:
                raise QuantityError(f"a number below {_LARGEST:g}")
        except QuantityError as error:
            problems.refuse((*path, *place), error.expected, error.hint, error.kind)
    return values


def _check(problems: ProblemCollector, scatter: Scatter, path: Path) -> None:
    """Note numbers that no such distribution has, and values that the quantity cannot have."""
    row, of, kind = SEARCHABLE[str(path[-1])], scatter.distribution, scatter.kind
    expected = row.expected.removesuffix(row.otherwise)
    if kind == DRAWN:
        for i in (i for i, value in scatter.numbers.items() if not row.allows(value)):
            problems.refuse((*path, DRAWN, i), expected)
        return
    inside = of.shares[2]
    if not inside >= _LEAST_INSIDE:  # NaN for numbers that make no such distribution
        expected = f"{_LEAST_INSIDE:g} of it or more within the ends" if inside < _LEAST_INSIDE else _NEEDED
        problems.add((*path, kind), f"got {scatter.text(row.units)}, expected {expected}")
        return
    low = max(bound for bound in (row.above, row.at_least, of.low) if bound is not None)
    possible = replace(of, low=low, high=of.high if row.at_most is None else min(of.high, row.at_most))
    share = 1.0 - max(possible.shares[2], 0.0) / inside
    if share > _ALLOWED_OUTSIDE:
        hint = f"truncate it: {row.name}: {{{kind}: ..., truncated: {{low: ..., high: ...}}}}, or one end"
        problems.add(path, f"got {100 * share:.3g} % of the points elsewhere, expected {expected}", hint, at_key=True)


def _correlation(
    problems: ProblemCollector, raw: object, names: Sequence[str], drawn: Collection[str]
) -> tuple[Any, ...] | None:  # fmt: skip
    """The correlation of all quantities, those that are drawn from values with none; None where there is none."""
    path: Path = (SECTION, "correlation")
    if not (data := problems.keys_of(raw, path, ("between", "matrix"))):
        return None
    between, possible = data.get("between"), [name for name in names if name not in drawn]
    if not (isinstance(between, list) and len(between) > 1
            and all(between.count(name) == 1 and name in possible for name in between)):  # fmt: skip
        expected = f"two or more of the quantities that have a distribution: {', '.join(possible)}"
        problems.refuse((*path, "between"), expected, _EXAMPLE)
        return None
    size, places, whole = len(between), [names.index(name) for name in between], np.eye(len(names))
    try:
        part = np.array(data.get("matrix"), np.float64)
    except (TypeError, ValueError, OverflowError):  # no numbers, or no matrix
        part = np.empty(0)
    is_symmetric = part.shape == (size, size) and np.allclose(part, part.T, rtol=1e-9, atol=0)
    if not (is_symmetric and (abs(part) <= np.diag(part)).all() and (np.diag(part) == 1.0).all()
            and np.linalg.eigvalsh(part)[0] >= _SMALLEST_EIGENVALUE):  # fmt: skip
        expected = f"{size} rows of {size} numbers, symmetric, positive definite and with 1 along the diagonal"
        problems.refuse((*path, "matrix"), expected, _EXAMPLE)
        return None
    whole[np.ix_(places, places)] = (part + part.T) / 2
    return None if (whole == np.eye(len(names))).all() else tuple(map(tuple, whole.tolist()))
