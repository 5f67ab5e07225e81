"""The section `uncertain` read: distributions checked against what is physically possible, matrices put together."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from stickslip.config.problems import ProblemCollector
from stickslip.config.rules import MOST_CELLS
from stickslip.config.uncertain import ARGUMENTS, Sampling, Scatter, Subset, Uncertain
from stickslip.errors import Path, QuantityError
from stickslip.vocabulary import units
from stickslip.vocabulary.parameter import Parameter
from stickslip.vocabulary.quantities import SEARCHABLE
from stickslip.vocabulary.results import VARIABLES
from stickslip.vocabulary.suggest import listed

Floats = NDArray[np.float64]
SectionReader = Callable[[type[Any], Path, Mapping[str, Any]], Any]

SECTION = "uncertain"
QUANTITIES_PATH: Path = (SECTION, "quantities")
_KEYS = ("quantities", "correlation", "covariance", "subset", *Sampling.model_fields)
_FORMS = listed(f"{kind}: {{{', '.join(arguments)}}}" for kind, arguments in ARGUMENTS.items())
_ALLOWED_OUTSIDE = 1e-6  # of the points: rarely met, and then such a draw is `failed`
_LEAST_KEPT = 1e-6  # of a distribution that is truncated; from less, what is left has no digits
_LARGEST = 1e100  # numbers of distributions and matrices, whose squares are to be finite
_SMALLEST_EIGENVALUE = 1e-12  # of a correlation matrix
_NOT_WITH_SUBSET = ("draws", "scramblings", "seed", "metrics", "quantiles", "indices")
_MORE_THAN = {  # by argument of a distribution: what it must exceed, and a hint
    "std": (0.0, "a quantity that does not scatter belongs in its section"),
    "median": (0.0, None),
    "factor": (1.0, "68 % of the values lie within this factor of the median, up or down"),
}


class _Block(NamedTuple):
    """One correlation or covariance matrix of the file."""

    path: Path
    names: tuple[str, ...]
    matrix: Floats


def read_uncertain(
    problems: ProblemCollector, raw: object, section: SectionReader, early_stop: bool
) -> Uncertain | None:
    """The section in plain data `raw`; None where something is wrong with its quantities.

    section : reads a plain section, as `reader._Reader` does. early_stop : of the solver.
    """
    data = problems.keys_of(raw, (SECTION,), _KEYS)
    sampling = section(Sampling, (SECTION,), {key: data[key] for key in data if key in Sampling.model_fields})
    for name in sampling.metrics if early_stop else ():
        if VARIABLES[name].when != "always":
            expected = f"no {name}: it needs solver: {{early_stop: false}} and a horizon"
            problems.refuse((SECTION, "metrics"), expected)
    subset = _subset(problems, data, section)
    given = problems.mapping(data.get("quantities"), QUANTITIES_PATH, "names of quantities")
    if not given:
        if data.get("quantities") in (None, {}):
            problems.add(QUANTITIES_PATH, "missing, expected quantities with distributions",
                         "quantities: {belt_speed: {normal: {mean: 0.8 m/s, std: 0.05 m/s}}}")  # fmt: skip
        return None
    before = len(problems.problems)
    covariances = _blocks(problems, data, "covariance", given)
    stds = _stds(problems, covariances, given)
    scatters = [_scatter(problems, name, value, stds.get(name)) for name, value in given.items()]
    correlations = _blocks(problems, data, "correlation", given)
    if len(problems.problems) > before:
        return None
    quantities = tuple(scatter for scatter in scatters if scatter is not None)
    blocks = [*correlations, *map(_scaled, covariances)]
    correlation = _together(problems, [scatter.name for scatter in quantities], blocks)
    if correlation is not None and sampling.indices:
        problems.refuse((SECTION, "indices"), "false: Sobol indices are defined for independent inputs",
                        "leave the correlation out to see which input matters")  # fmt: skip
    settings = dict(sampling) | {"indices": correlation is None if sampling.indices is None else sampling.indices}
    whole = Uncertain(**settings, quantities=quantities, correlation=correlation, subset=subset)
    if whole.draws_per_cell > MOST_CELLS:
        message = f"got {whole.draws_per_cell:.3g} draws of every cell, expected at most {MOST_CELLS:.0e}"
        problems.add((SECTION, "draws"), message, "use fewer draws or scramblings")
    return whole


def _subset(problems: ProblemCollector, data: Mapping[str, Any], section: SectionReader) -> Subset | None:
    """The settings of subset simulation, which takes the place of Sobol points."""
    if "subset" not in data:
        return None
    path: Path = (SECTION, "subset")
    subset: Subset = section(Subset, path, problems.keys_of(data["subset"], path, Subset.model_fields))
    for key in _NOT_WITH_SUBSET:
        if key in data:
            problems.add((SECTION, key), f"got {key} besides subset, expected one of them",
                         "subset simulation tells the probability of stick-slip and nothing else",
                         at_key=True)  # fmt: skip
    return subset


# --- one quantity -----------------------------------------------------------------------------------------------------


def _scatter(problems: ProblemCollector, name: str, raw: object, std: float | None) -> Scatter | None:
    """A quantity with its distribution; `std` follows from a covariance."""
    path: Path = (*QUANTITIES_PATH, name)
    if name not in SEARCHABLE:
        problems.unknown_key(path, SEARCHABLE, "quantity")
        return None
    row, before = SEARCHABLE[name], len(problems.problems)
    data = problems.known_keys(problems.mapping(raw, path, _FORMS), path, (*ARGUMENTS, "truncated"))
    kinds = [key for key in data if key in ARGUMENTS]
    if len(kinds) != 1 and len(problems.problems) == before:
        got = f"got {listed(kinds, 'and')}" if kinds else "no distribution"
        problems.add(path, f"{got}, expected one of {_FORMS}")
    if len(problems.problems) > before:
        return None
    arguments = _arguments(problems, row, kinds[0], data[kinds[0]], (*path, kinds[0]), std)
    low, high = _ends(problems, row, data.get("truncated"), (*path, "truncated"))
    if len(problems.problems) > before:
        return None
    scatter = Scatter(name=name, kind=kinds[0], arguments=arguments, low=low, high=high)
    if (kept := getattr(scatter.distribution, "kept", 1.0)) < _LEAST_KEPT:
        message = f"keeps {_share(kept)} of the {scatter.kind} distribution, expected at least {_share(_LEAST_KEPT)}"
        hint = "the distribution lies elsewhere; check its numbers"
        problems.add((*path, "truncated"), message, hint, at_key=True)
    else:
        _check_inside(problems, scatter, row, path)
    return scatter


def _arguments(
    problems: ProblemCollector, row: Parameter, kind: str, raw: object, path: Path, std: float | None
) -> tuple[float, ...]:
    """The numbers that describe a distribution, in order; fewer where some are wrong."""
    names, places = ARGUMENTS[kind], dict[str, int]()
    if kind == "uniform" and isinstance(raw, list) and len(raw) == 2:
        raw, places = dict(zip(names, raw, strict=True)), {"low": 0, "high": 1}
    data = problems.known_keys(problems.mapping(raw, path, f"the keys {listed(names, 'and')}"), path, names)
    if std is not None and kind == "normal":
        if "std" in data:
            message = "given besides a covariance, which says it already, expected once"
            problems.add((*path, "std"), message, at_key=True)
        data = {**data, "std": std}
    values: dict[str, float | None] = {}
    for name in names:
        where = (*path, places.get(name, name))
        if name in data:
            values[name] = _number(problems, row, name, data[name], where)
        else:
            problems.add(where, f"missing, expected {listed(names, 'and')} of a {kind} distribution")
    numbers = {name: value for name, value in values.items() if value is not None}
    if len(numbers) == len(names) and _rises(problems, row, numbers, (*path, places.get("high", "high"))):
        low, high = numbers.get("low", 0.0), numbers.get("high", 0.0)
        if not low <= numbers.get("mode", low) <= high:
            span = f"{low:g} to {high:g} {units.spelled(row.units)}".rstrip()
            problems.refuse((*path, "mode"), f"the most probable value, from low to high ({span})")
    return tuple(numbers.values())


def _number(problems: ProblemCollector, row: Parameter, name: str, raw: object, path: Path) -> float | None:
    """One number of a distribution, in SI."""
    unit, (least, hint) = "1" if name == "factor" else row.units, _MORE_THAN.get(name, (-math.inf, None))
    try:
        value = units.si_value(raw, unit)
    except QuantityError as error:
        problems.refuse(path, error.expected, error.hint, error.found)
        return None
    if not abs(value) < _LARGEST:
        problems.refuse(path, f"a number below {_LARGEST:g}")
    elif not value > least:
        problems.refuse(path, f"more than {least:g} {units.spelled(unit)}".rstrip(), hint)
    else:
        return value
    return None


def _rises(problems: ProblemCollector, row: Parameter, ends: Mapping[str, float | None], path: Path) -> bool:
    """True if `high`, at `path`, is above `low`, where both are given; if not, that is noted."""
    low, high = ends.get("low"), ends.get("high")
    if low is None or high is None or low < high:
        return True
    hint = "swap low and high" if low > high else "a quantity that does not scatter belongs in its section"
    problems.refuse(path, f"more than low ({low:g} {units.spelled(row.units)}".rstrip() + ")", hint)
    return False


def _ends(problems: ProblemCollector, row: Parameter, raw: object, path: Path) -> tuple[float, float]:
    """The ends at which a distribution is truncated."""
    if raw is None:
        return -math.inf, math.inf
    data = problems.known_keys(problems.mapping(raw, path, "the keys low or high"), path, ("low", "high"))
    ends = {name: _number(problems, row, name, value, (*path, name)) for name, value in data.items()}
    _rises(problems, row, ends, (*path, "high"))
    low, high = ends.get("low"), ends.get("high")
    return -math.inf if low is None else low, math.inf if high is None else high


def _check_inside(problems: ProblemCollector, scatter: Scatter, row: Parameter, path: Path) -> None:
    """The distribution stays where the parameter may be."""
    from stickslip.theory.distributions import share_outside  # SciPy takes its time, and most have no use for it

    low = max((bound for bound in (row.above, row.at_least) if bound is not None), default=-math.inf)
    high = math.inf if row.at_most is None else row.at_most
    under, over = share_outside(scatter.distribution, low, high)
    if under + over <= _ALLOWED_OUTSIDE:
        return
    side, bound = ("below", low) if under >= over else ("above", high)
    ends = {"low": (under, low), "high": (over, high)}
    text = ", ".join(f"{name}: {end:g}" for name, (share, end) in ends.items() if share > _ALLOWED_OUTSIDE)
    points = f"got {_share(under + over)} of the points {side} {bound:g} {units.spelled(row.units)}".rstrip()
    hint = f"truncate it: {scatter.name}: {{{scatter.kind}: ..., truncated: {{{text}}}}}"
    problems.add(path, f"{points}, expected {row.expected.removesuffix(row.otherwise)}", hint, at_key=True)


def _share(share: float) -> str:
    return f"{100 * share:.3g} %"


# --- matrices ---------------------------------------------------------------------------------------------------------

_EXAMPLE = "between: [mass, stiffness], matrix: [[1, 0.5], [0.5, 1]]"


def _blocks(
    problems: ProblemCollector, data: Mapping[str, Any], key: str, quantities: Mapping[str, Any]
) -> list[_Block]:
    """The matrices under a key: one mapping, or a list of them."""
    raw, path = data.get(key), (SECTION, key)
    if raw is None:
        return []
    listing = [((*path, i), one) for i, one in enumerate(raw)] if isinstance(raw, list) else [(path, raw)]
    return [block for where, one in listing if (block := _block(problems, one, where, quantities)) is not None]


def _block(problems: ProblemCollector, raw: object, path: Path, quantities: Mapping[str, Any]) -> _Block | None:
    before = len(problems.problems)
    if not isinstance(raw, dict):
        problems.refuse(path, f"a mapping such as {{{_EXAMPLE}}}")
        return None
    data = problems.known_keys(raw, path, ("between", "matrix"))
    at = {key: (*path, key) if key in data else path for key in ("between", "matrix")}
    names = data.get("between")
    if not (isinstance(names, list) and len(names) > 1 and len(set(map(str, names))) == len(names)
            and all(isinstance(name, str) and name in quantities for name in names)):  # fmt: skip
        expected = f"expected two or more of the uncertain quantities: {listed(quantities)}"
        problems.add(at["between"], expected, _EXAMPLE)
        return None
    if not _is_square(data.get("matrix"), len(names)):
        problems.add(at["matrix"], f"expected {len(names)} rows of {len(names)} numbers", _EXAMPLE)
        return None
    matrix = np.array(data["matrix"], np.float64)
    differ = np.argwhere(~np.isclose(matrix, matrix.T, rtol=1e-9, atol=0))
    if len(differ):
        i, j = map(int, differ[0])
        got = f"got {matrix[i, j]:g} and {matrix[j, i]:g} for {names[i]} with {names[j]}"
        problems.add(at["matrix"], f"{got}, expected a symmetric matrix")
    return _Block(path, tuple(names), (matrix + matrix.T) / 2) if len(problems.problems) == before else None


def _is_square(rows: object, size: int) -> bool:
    """True for a list of as many lists of finite numbers."""
    if not isinstance(rows, list) or len(rows) != size:
        return False
    flat = [value for row in rows if isinstance(row, list) and len(row) == size for value in row]
    return len(flat) == size**2 and all(
        isinstance(value, int | float) and not isinstance(value, bool) and abs(value) < _LARGEST for value in flat
    )


def _stds(problems: ProblemCollector, blocks: list[_Block], quantities: Mapping[str, Any]) -> dict[str, float]:
    """The standard deviations that follow from covariances, which are of normal quantities."""
    stds: dict[str, float] = {}
    for block in blocks:
        for name, variance in zip(block.names, np.diag(block.matrix), strict=True):
            raw = quantities[name]
            if not isinstance(raw, dict) or "normal" not in raw or "truncated" in raw:
                message = f"got {name}, which is not normal, expected normal quantities"
                hint = "a correlation joins any distributions (their normal deviates: a Gaussian copula)"
                problems.add((*block.path, "between"), message, hint)
            elif not variance > 0:
                message = f"got the variance {variance:g} of {name}, expected more than 0"
                problems.add((*block.path, "matrix"), message)
            else:
                stds[name] = math.sqrt(variance)
    return stds


def _scaled(block: _Block) -> _Block:
    """A covariance as a correlation."""
    std = np.sqrt(np.diag(block.matrix))
    matrix = block.matrix / np.outer(std, std)
    np.fill_diagonal(matrix, 1.0)
    return block._replace(matrix=matrix)


def _together(
    problems: ProblemCollector, names: list[str], blocks: list[_Block]
) -> tuple[tuple[float, ...], ...] | None:
    """The correlation of all quantities; None if they are independent."""
    whole, given = np.eye(len(names)), np.eye(len(names), dtype=bool)
    for block in blocks:
        path, places = (*block.path, "matrix"), [names.index(name) for name in block.names]
        part = np.ix_(places, places)
        if not np.allclose(np.diag(block.matrix), 1.0, rtol=0, atol=1e-9):
            hint = "a covariance has its own key: covariance"
            problems.add(path, "expected 1 along the diagonal of a correlation matrix", hint)
            return None
        if (given[part] & ~np.eye(len(places), dtype=bool)).any():
            problems.add(path, f"says again how {listed(block.names, 'and')} are correlated, expected once")
            return None
        whole[part], given[part] = block.matrix, True
    np.fill_diagonal(whole, 1.0)
    if blocks and (least := float(np.linalg.eigvalsh(whole)[0])) < _SMALLEST_EIGENVALUE:
        message = f"got a matrix that is not positive definite (smallest eigenvalue {least:.3g}), expected one that is"
        problems.add((*blocks[-1].path, "matrix"), message, "no quantities can be correlated like this")
        return None
    return tuple(map(tuple, whole.tolist())) if (whole != np.eye(len(names))).any() else None
