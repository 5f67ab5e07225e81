"""The section `uncertain` read: its distributions against what is physically possible, and their correlation."""

from collections.abc import Collection, Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from stickslip.config.problems import ProblemCollector
from stickslip.config.uncertain import (
    DRAWN,
    FORMS,
    NOT_WITH_SUBSET,
    NUMBERS,
    TRUNCATED,
    SamplingSection,
    Scatter,
    Uncertain,
    has_unit,
)  # fmt: skip
from stickslip.errors import Path, QuantityError
from stickslip.vocabulary import units
from stickslip.vocabulary.quantities import SEARCHABLE
from stickslip.vocabulary.results import VARIABLES
from stickslip.vocabulary.suggest import listed

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
        problems.add((*path, kind), f"got {scatter.in_words(row.name)}, expected {expected}")
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
