"""The section `uncertain` read: distributions checked against what is physically possible, matrices put together."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from stickslip.config.complaints import Complaints
from stickslip.config.rules import MOST_CELLS
from stickslip.config.scatter import ARGUMENTS, MAY_SCATTER, Sampling, Scatter, Subset, Uncertain
from stickslip.errors import Path, QuantityError
from stickslip.vocabulary import units
from stickslip.vocabulary.parameter import Parameter
from stickslip.vocabulary.results import VARIABLES
from stickslip.vocabulary.words import listed

Floats = NDArray[np.float64]

SECTION = "uncertain"
QUANTITIES_PATH: Path = (SECTION, "quantities")
_KEYS = ("quantities", "correlation", "covariance", "subset", *Sampling.model_fields)
_ALLOWED_OUTSIDE = 1e-6  # of the points: rarely met, and then such a draw is `failed`
_LEAST_KEPT = 1e-6  # of a distribution that is truncated; from less, what is left has no digits
_LARGEST = 1e100  # numbers of distributions and matrices, whose squares are to be finite
_SMALLEST_EIGENVALUE = 1e-12  # of a correlation matrix
_NOT_WITH_SUBSET = ("draws", "scramblings", "seed", "metrics", "quantiles", "indices")

SectionReader = Callable[[type[Any], Path, Mapping[str, Any]], Any]


class _Block(NamedTuple):
    """One correlation or covariance matrix of the file."""

    path: Path
    names: tuple[str, ...]
    matrix: Floats


def read_uncertain(to: Complaints, raw: object, section: SectionReader, early_stop: bool) -> Uncertain | None:
    """The section in plain data `raw`; what is wrong becomes problems of `to`, and then the result may be None.

    section : reads a plain section, as `reader._Reader` does. early_stop : of the solver.
    """
    path: Path = (SECTION,)
    data = to.known_keys(to.mapping(raw, path, f"the keys {listed(_KEYS)}"), path, _KEYS)
    sampling = section(Sampling, path, {key: value for key, value in data.items() if key in Sampling.model_fields})
    for name in sampling.metrics if early_stop else ():
        if VARIABLES[name].when != "always":
            to.refuse((SECTION, "metrics"), f"no {name}: it needs solver: {{early_stop: false}} and a horizon")
    subset = _subset(to, data, section)
    raw_quantities = to.mapping(data.get("quantities"), QUANTITIES_PATH, "names of quantities")
    if not raw_quantities:
        if "quantities" not in data or data["quantities"] in (None, {}):
            to.add(QUANTITIES_PATH, "missing, expected quantities with distributions",
                   "quantities: {belt_speed: {normal: {mean: 0.8 m/s, std: 0.05 m/s}}}")  # fmt: skip
        return None
    before = len(to.problems)
    covariances = _blocks(to, data, "covariance", raw_quantities)
    stds = _stds(to, covariances, raw_quantities)
    found = [_scatter(to, name, raw, stds.get(name)) for name, raw in raw_quantities.items()]
    correlations = _blocks(to, data, "correlation", raw_quantities)
    if len(to.problems) > before:
        return None
    quantities = tuple(one for one in found if one is not None)
    blocks = [*correlations, *(_scaled(block) for block in covariances)]
    correlation = _together(to, [one.name for one in quantities], blocks)
    if correlation is not None and sampling.indices:
        to.refuse((SECTION, "indices"), "false: Sobol indices are defined for independent inputs",
                  "leave the correlation out to see which input matters")  # fmt: skip
    settings = dict(sampling) | {"indices": correlation is None if sampling.indices is None else sampling.indices}
    whole = Uncertain(**settings, quantities=quantities, correlation=correlation, subset=subset)
    if whole.draws_per_cell > MOST_CELLS:
        message = f"got {whole.draws_per_cell:.3g} draws of every cell, expected at most {MOST_CELLS:.0e}"
        to.add((SECTION, "draws"), message, "use fewer draws or scramblings")
    return whole


def _subset(to: Complaints, data: Mapping[str, Any], section: SectionReader) -> Subset | None:
    """The settings of subset simulation, which takes the place of Sobol points."""
    if "subset" not in data:
        return None
    path: Path = (SECTION, "subset")
    found: Subset = section(Subset, path, to.mapping(data["subset"], path, f"the keys {listed(Subset.model_fields)}"))
    for key in _NOT_WITH_SUBSET:
        if key in data:
            to.add((SECTION, key), f"got {key} besides subset, expected one of them",
                   "subset simulation tells the probability of stick-slip and nothing else", at_key=True)  # fmt: skip
    return found


# --- one quantity -----------------------------------------------------------------------------------------------------


def _scatter(to: Complaints, name: str, raw: object, std: float | None) -> Scatter | None:
    """A quantity with its distribution; `std` is what a covariance says of it."""
    path: Path = (*QUANTITIES_PATH, name)
    if name not in MAY_SCATTER:
        to.unknown_key(path, MAY_SCATTER, "quantity")
        return None
    row, before = MAY_SCATTER[name], len(to.problems)
    forms = listed(f"{kind}: {{{', '.join(arguments)}}}" for kind, arguments in ARGUMENTS.items())
    data = to.known_keys(to.mapping(raw, path, forms), path, (*ARGUMENTS, "truncated"))
    kinds = [key for key in data if key in ARGUMENTS]
    if len(kinds) != 1 and len(to.problems) == before:
        got = f"got {listed(kinds, 'and')}" if kinds else "no distribution"
        to.add(path, f"{got}, expected one of {forms}")
    if len(to.problems) > before:
        return None
    kind = kinds[0]
    arguments = _arguments(to, row, kind, data[kind], (*path, kind), std)
    low, high = _ends(to, row, data.get("truncated"), (*path, "truncated"))
    if arguments is None or len(to.problems) > before:
        return None
    found = Scatter(name=name, kind=kind, arguments=arguments, low=low, high=high)
    _check_kept(to, found, path)
    if len(to.problems) == before:
        _check_inside(to, found, row, path)
    return found


def _arguments(
    to: Complaints, row: Parameter, kind: str, raw: object, path: Path, std: float | None
) -> tuple[float, ...] | None:
    """The numbers that describe a distribution, in order."""
    names = ARGUMENTS[kind]
    if kind == "uniform" and isinstance(raw, list) and len(raw) == 2:
        raw, keys = dict(zip(names, raw, strict=True)), {"low": 0, "high": 1}
    else:
        keys = {}
    data = to.known_keys(to.mapping(raw, path, f"the keys {listed(names, 'and')}"), path, names)
    if std is not None and kind == "normal":
        if "std" in data:
            to.add((*path, "std"), "given besides a covariance, which says it already, expected once", at_key=True)
        data = {**data, "std": std}
    before, values = len(to.problems), {}
    for name in names:
        where = (*path, keys.get(name, name))
        if name not in data:
            to.add(where, f"missing, expected {listed(names, 'and')} of a {kind} distribution")
        elif (value := _number(to, row, name, data[name], where)) is not None:
            values[name] = value
    if len(to.problems) == before:
        _check_order(to, row, values, path, keys)
    return tuple(values[name] for name in names) if len(to.problems) == before else None


def _number(to: Complaints, row: Parameter, name: str, raw: object, path: Path) -> float | None:
    """One number of a distribution, in SI."""
    unit = "1" if name == "factor" else row.units
    try:
        value = units.si_value(raw, unit)
    except QuantityError as error:
        to.refuse(path, error.expected, error.hint, error.found)
        return None
    if not abs(value) < _LARGEST:
        to.refuse(path, f"a number below {_LARGEST:g}")
        return None
    least = {"std": 0.0, "median": 0.0, "factor": 1.0}.get(name)
    if least is not None and not value > least:
        hints = {"factor": "68 % of the values lie within this factor of the median, up or down",
                 "std": "a quantity that does not scatter belongs in its section"}  # fmt: skip
        to.refuse(path, f"more than {least:g} {units.spelled(unit)}".rstrip(), hints.get(name))
        return None
    return value


def _check_order(
    to: Complaints, row: Parameter, values: Mapping[str, float], path: Path, keys: Mapping[str, int]
) -> None:
    """low < high, and the mode between."""
    if "low" not in values:
        return
    low, high = values["low"], values["high"]
    unit = units.spelled(row.units)
    if not low < high:
        hint = "swap low and high" if low > high else "a quantity that does not scatter belongs in its section"
        to.refuse((*path, keys.get("high", "high")), f"more than low ({low:g} {unit}".rstrip() + ")", hint)
    elif not low <= values.get("mode", low) <= high:
        to.refuse(
            (*path, "mode"), f"the most probable value, from low to high ({low:g} to {high:g} {unit}".rstrip() + ")"
        )


def _ends(to: Complaints, row: Parameter, raw: object, path: Path) -> tuple[float, float]:
    """Where a distribution is truncated."""
    if raw is None:
        return -math.inf, math.inf
    data = to.known_keys(to.mapping(raw, path, "the keys low or high"), path, ("low", "high"))
    found = {name: _number(to, row, name, value, (*path, name)) for name, value in data.items()}
    low, high = found.get("low"), found.get("high")
    if low is not None and high is not None and not low < high:
        to.refuse((*path, "high"), f"more than low ({low:g} {units.spelled(row.units)}".rstrip() + ")")
    return -math.inf if low is None else low, math.inf if high is None else high


def _check_kept(to: Complaints, found: Scatter, path: Path) -> None:
    """Truncation leaves something."""
    kept = getattr(found.distribution, "kept", 1.0)
    if kept < _LEAST_KEPT:
        message = f"keeps {_share(kept)} of the {found.kind} distribution, expected at least {_share(_LEAST_KEPT)}"
        to.add((*path, "truncated"), message, "the distribution lies elsewhere; check its numbers", at_key=True)


def _check_inside(to: Complaints, found: Scatter, row: Parameter, path: Path) -> None:
    """The distribution stays where the parameter may be."""
    low = max((bound for bound in (row.above, row.at_least) if bound is not None), default=-math.inf)
    high = math.inf if row.at_most is None else row.at_most
    from stickslip.theory.distributions import share_outside  # SciPy takes its time, and most have no use for it

    under, over = share_outside(found.distribution, low, high)
    outside = under + over
    if outside <= _ALLOWED_OUTSIDE:
        return
    unit = units.spelled(row.units)
    side, bound = ("below", low) if under >= over else ("above", high)
    ends = {"low": low} if under > _ALLOWED_OUTSIDE else {}
    ends |= {"high": high} if over > _ALLOWED_OUTSIDE else {}
    text = ", ".join(f"{name}: {end:g}" for name, end in ends.items())
    expected = row.expected.removesuffix(row.otherwise)
    message = f"got {_share(outside)} of the points {side} {bound:g} {unit}".rstrip() + f", expected {expected}"
    to.add(path, message, f"truncate it: {found.name}: {{{found.kind}: ..., truncated: {{{text}}}}}", at_key=True)


def _share(share: float) -> str:
    return f"{100 * share:.3g} %"


# --- matrices ---------------------------------------------------------------------------------------------------------


def _blocks(to: Complaints, data: Mapping[str, Any], key: str, quantities: Mapping[str, Any]) -> list[_Block]:
    """The matrices under a key: one mapping, or a list of them."""
    raw, path = data.get(key), (SECTION, key)
    if raw is None:
        return []
    listing = [((*path, i), one) for i, one in enumerate(raw)] if isinstance(raw, list) else [(path, raw)]
    return [block for where, one in listing if (block := _block(to, one, where, quantities)) is not None]


def _block(to: Complaints, raw: object, path: Path, quantities: Mapping[str, Any]) -> _Block | None:
    before = len(to.problems)
    example = "between: [mass, stiffness], matrix: [[1, 0.5], [0.5, 1]]"
    if not isinstance(raw, dict):
        to.refuse(path, f"a mapping such as {{{example}}}")
        return None
    data = to.known_keys(raw, path, ("between", "matrix"))
    names, rows = data.get("between"), data.get("matrix")
    known = isinstance(names, list) and len(names) > 1 and len(set(map(str, names))) == len(names)
    if not known or not all(isinstance(name, str) and name in quantities for name in names):  # type: ignore[union-attr]
        where = (*path, "between") if "between" in data else path
        to.add(where, f"expected two or more of the uncertain quantities: {listed(quantities)}", example)
    elif not _is_square(rows, len(names)):  # type: ignore[arg-type]
        where = (*path, "matrix") if "matrix" in data else path
        to.add(where, f"expected {len(names)} rows of {len(names)} numbers", example)  # type: ignore[arg-type]
    else:
        matrix = np.array(rows, np.float64)
        if not np.allclose(matrix, matrix.T, rtol=1e-9, atol=0):
            i, j = map(int, np.argwhere(~np.isclose(matrix, matrix.T, rtol=1e-9, atol=0))[0])
            to.add((*path, "matrix"), f"got {matrix[i, j]:g} and {matrix[j, i]:g} for {names[i]} with {names[j]}, "  # type: ignore[index]
                   "expected a symmetric matrix")  # fmt: skip
        return _Block(path, tuple(names), (matrix + matrix.T) / 2) if len(to.problems) == before else None  # type: ignore[arg-type]
    return None


def _is_square(rows: object, size: int) -> bool:
    """Whether `rows` is a list of as many lists of finite numbers."""
    if not isinstance(rows, list) or len(rows) != size:
        return False
    flat = [value for row in rows if isinstance(row, list) and len(row) == size for value in row]
    return len(flat) == size**2 and all(
        isinstance(value, int | float) and not isinstance(value, bool) and abs(value) < _LARGEST for value in flat
    )


def _stds(to: Complaints, blocks: list[_Block], quantities: Mapping[str, Any]) -> dict[str, float]:
    """The standard deviations that covariances say; they are of normal quantities."""
    found: dict[str, float] = {}
    for block in blocks:
        for name, variance in zip(block.names, np.diag(block.matrix), strict=True):
            raw = quantities[name]
            if not isinstance(raw, dict) or "normal" not in raw or "truncated" in raw:
                to.add((*block.path, "between"), f"got {name}, which is not normal, expected normal quantities",
                       "a correlation joins any distributions (their normal deviates: a Gaussian copula)")  # fmt: skip
            elif not variance > 0:
                to.add((*block.path, "matrix"), f"got the variance {variance:g} of {name}, expected more than 0")
            else:
                found[name] = math.sqrt(variance)
    return found


def _scaled(block: _Block) -> _Block:
    """A covariance as a correlation."""
    std = np.sqrt(np.diag(block.matrix))
    matrix = block.matrix / np.outer(std, std)
    np.fill_diagonal(matrix, 1.0)
    return block._replace(matrix=matrix)


def _together(to: Complaints, names: list[str], blocks: list[_Block]) -> tuple[tuple[float, ...], ...] | None:
    """The correlation of all quantities; None if they are independent."""
    whole, said = np.eye(len(names)), np.eye(len(names), dtype=bool)
    for block in blocks:
        key = (*block.path, "matrix")
        places = np.ix_([names.index(name) for name in block.names], [names.index(name) for name in block.names])
        if not np.allclose(np.diag(block.matrix), 1.0, rtol=0, atol=1e-9):
            hint = "a covariance has its own key: covariance"
            to.add(key, "expected 1 along the diagonal of a correlation matrix", hint)
            return None
        if (said[places] & ~np.eye(len(block.names), dtype=bool)).any():
            to.add(key, f"says again how {listed(block.names, 'and')} are correlated, expected once")
            return None
        whole[places], said[places] = block.matrix, True
    np.fill_diagonal(whole, 1.0)
    if blocks and (least := float(np.linalg.eigvalsh(whole)[0])) < _SMALLEST_EIGENVALUE:
        message = f"got a matrix that is not positive definite (smallest eigenvalue {least:.3g}), expected one that is"
        to.add((*blocks[-1].path, "matrix"), message, "no quantities can be correlated like this")
        return None
    return tuple(map(tuple, whole.tolist())) if (whole != np.eye(len(names))).any() else None
