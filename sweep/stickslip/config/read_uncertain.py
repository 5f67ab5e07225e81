"""The section `uncertain` read: distributions against what is physically possible, matrices put together."""

import math
from collections.abc import Mapping
from typing import Any

import numpy as np

from stickslip.config.problems import ProblemCollector
from stickslip.config.uncertain import NOT_WITH_SUBSET, Matrix, Sampling, Scatter, Subset, Uncertain
from stickslip.errors import Path
from stickslip.vocabulary import units
from stickslip.vocabulary.quantities import SEARCHABLE
from stickslip.vocabulary.results import VARIABLES
from stickslip.vocabulary.suggest import listed

SECTION = "uncertain"
QUANTITIES_PATH: Path = (SECTION, "quantities")
_ALLOWED_OUTSIDE = 1e-6  # of the points: rarely met, and then such a draw is `failed`
_LEAST_KEPT = 1e-6  # of a distribution that is truncated; from less, what is left has no digits
_SMALLEST_EIGENVALUE = 1e-12  # of a correlation matrix

Matrices = list[tuple[Path, Matrix]]  # with their places in the file


def read_uncertain(problems: ProblemCollector, raw: object, early_stop: bool) -> Uncertain | None:
    """The section in plain data `raw`; None where something is wrong with it. early_stop : of the solver."""
    path: Path = (SECTION,)
    data = problems.keys_of(raw, path, ("quantities", "correlation", "covariance", "subset", *Sampling.model_fields))
    sampling = problems.section_of(Sampling, path, {key: data[key] for key in data if key in Sampling.model_fields})
    for name in sampling.metrics if early_stop else ():
        if VARIABLES[name].when == "full":
            problems.refuse((*path, "metrics"), f"no {name}: it needs solver: {{early_stop: false}} and a horizon")
    subset = None
    if "subset" in data:
        subset = problems.section_of(Subset, (*path, "subset"), data["subset"])
        for key in (key for key in NOT_WITH_SUBSET if key in data):
            problems.add((*path, key), f"got {key} besides subset, expected one of them",
                         "subset simulation tells the probability of stick-slip and nothing else",
                         at_key=True)  # fmt: skip
    given = problems.mapping(data.get("quantities"), QUANTITIES_PATH, "names of quantities")
    if not given:
        if data.get("quantities") in (None, {}):
            problems.add(QUANTITIES_PATH, "missing, expected quantities with distributions",
                         "quantities: {belt_speed: {normal: {mean: 0.8 m/s, std: 0.05 m/s}}}")  # fmt: skip
        return None
    before = len(problems.problems)
    covariances = _matrices(problems, data, "covariance", given)
    stds = _stds(problems, covariances, given)
    read = {name: _scatter(problems, name, value, stds.get(name)) for name, value in given.items()}
    scatters = {name: scatter for name, scatter in read.items() if scatter is not None}
    correlations = _matrices(problems, data, "correlation", given)
    if len(problems.problems) > before or len(scatters) < len(given):
        return None
    drawn = [name for name, scatter in scatters.items() if scatter.drawn is not None]
    _check_drawn(problems, {name: scatters[name] for name in drawn}, [*correlations, *covariances], subset is not None)
    correlation = _together(problems, tuple(scatters), [*correlations, *covariances])
    independent = correlation is None and len(drawn) < 2
    if not independent and sampling.indices:
        problems.refuse((*path, "indices"), "false: Sobol indices are defined for independent inputs",
                        "leave the correlation out to see which input matters")  # fmt: skip
    settings = dict(sampling) | {"indices": independent if sampling.indices is None else sampling.indices}
    whole: Uncertain = Uncertain.model_construct(
        **settings, quantities=scatters, correlation=correlation, subset=subset
    )
    return whole


# --- one quantity -----------------------------------------------------------------------------------------------------


def _scatter(problems: ProblemCollector, name: str, raw: Any, std: float | None) -> Scatter | None:
    """A quantity with its distribution; `std` follows from a covariance."""
    path: Path = (*QUANTITIES_PATH, name)
    if name not in SEARCHABLE:
        problems.unknown_key(path, SEARCHABLE, "quantity")
        return None
    if std is not None:
        if "std" in raw["normal"]:
            message = "given besides a covariance, which says it already, expected once"
            problems.add((*path, "normal", "std"), message, at_key=True)
        raw = {**raw, "normal": {**raw["normal"], "std": SEARCHABLE[name].in_file(std)}}
    scatter = problems.read(Scatter, path, raw, context=SEARCHABLE[name])
    if scatter is None:
        return None
    if scatter.ends and (kept := scatter.distribution.shares[2]) < _LEAST_KEPT:  # type: ignore[union-attr]
        message = f"keeps {_share(kept)} of the {scatter.kind} distribution, expected at least {_share(_LEAST_KEPT)}"
        hint = "the distribution lies elsewhere; check its numbers"
        problems.add((*path, "truncated"), message, hint, at_key=True)
    else:
        _check_inside(problems, scatter, path)
    return scatter


def _check_inside(problems: ProblemCollector, scatter: Scatter, path: Path) -> None:
    row = SEARCHABLE[str(path[-1])]
    low = max((bound for bound in (row.above, row.at_least) if bound is not None), default=-math.inf)
    high = math.inf if row.at_most is None else row.at_most
    under, over = scatter.distribution.outside(low, high)
    if under + over <= _ALLOWED_OUTSIDE:
        return
    side, bound = ("below", low) if under >= over else ("above", high)
    ends = {"low": (under, low), "high": (over, high)}
    text = ", ".join(f"{name}: {end:g}" for name, (share, end) in ends.items() if share > _ALLOWED_OUTSIDE)
    points = f"got {_share(under + over)} of the points {side} {bound:g} {units.spelled(row.units)}".rstrip()
    hint = f"truncate it: {row.name}: {{{scatter.kind}: ..., truncated: {{{text}}}}}"
    problems.add(path, f"{points}, expected {row.expected.removesuffix(row.otherwise)}", hint, at_key=True)


def _share(share: float) -> str:
    return f"{100 * share:.3g} %"


def _check_drawn(problems: ProblemCollector, drawn: Mapping[str, Scatter], matrices: Matrices, by_subset: bool) -> None:
    """Quantities drawn from values are rows of one table, and no others depend on them."""
    sizes = {name: len(scatter.drawn or ()) for name, scatter in drawn.items()}
    first = next(iter(sizes), "")
    for name, size in sizes.items():
        if size != sizes[first]:
            message = f"got {size} values, expected {sizes[first]} like {first}: they are drawn together, row by row"
            problems.add((*QUANTITIES_PATH, name, "drawn"), message)
    for path, matrix in matrices:
        if both := drawn.keys() & {*matrix.between}:
            problems.add((*path, "between"), f"got {min(both)}, which is drawn from values, expected distributions")
    if by_subset and drawn:
        hint = "leave subset out, and count draws"
        problems.add((SECTION, "subset"), f"got it beside {first}, which is drawn from values and leads nowhere", hint)


# --- matrices ---------------------------------------------------------------------------------------------------------


def _matrices(problems: ProblemCollector, data: Mapping[str, Any], key: str, names: Mapping[str, Any]) -> Matrices:
    """The matrices under a key: one mapping, or a list of them."""
    raw, path = data.get(key), (SECTION, key)
    if raw is None:
        return []
    listing = [((*path, i), one) for i, one in enumerate(raw)] if isinstance(raw, list) else [(path, raw)]
    read = ((where, problems.read(Matrix, where, one, context=names)) for where, one in listing)
    return [(where, matrix) for where, matrix in read if matrix is not None]


def _stds(problems: ProblemCollector, covariances: Matrices, quantities: Mapping[str, Any]) -> dict[str, float]:
    """The standard deviations that follow from covariances, which are of normal quantities."""
    stds: dict[str, float] = {}
    for path, covariance in covariances:
        for name, variance in zip(covariance.between, np.diag(covariance.values), strict=True):
            raw = quantities[name]
            if not isinstance(raw, dict) or not isinstance(raw.get("normal"), dict) or "truncated" in raw:
                message = f"got {name}, which is not normal, expected normal quantities"
                hint = "a correlation joins any distributions (their normal deviates: a Gaussian copula)"
                problems.add((*path, "between"), message, hint)
            elif not variance > 0:
                message = f"got the variance {variance:g} of {name}, expected more than 0"
                problems.add((*path, "matrix"), message)
            else:
                stds[name] = math.sqrt(variance)
    return stds


def _together(problems: ProblemCollector, names: tuple[str, ...], matrices: Matrices) -> Matrix | None:
    """The correlation of all quantities, of their correlations and covariances; None if they are independent."""
    whole, known = np.eye(len(names)), np.eye(len(names), dtype=bool)
    path: Path = ()
    for where, matrix in matrices:
        path, places = (*where, "matrix"), [names.index(name) for name in matrix.between]
        part, values = np.ix_(places, places), matrix.values
        if where[1] == "covariance":
            std = np.sqrt(np.diag(values))
            values = values / np.outer(std, std)
            np.fill_diagonal(values, 1.0)
        if not np.allclose(np.diag(values), 1.0, rtol=0, atol=1e-9):
            hint = "a covariance has its own key: covariance"
            problems.add(path, "expected 1 along the diagonal of a correlation matrix", hint)
            return None
        if (known[part] & ~np.eye(len(places), dtype=bool)).any():
            problems.add(path, f"says again how {listed(matrix.between, 'and')} are correlated, expected once")
            return None
        whole[part], known[part] = values, True
    np.fill_diagonal(whole, 1.0)
    if path and (least := float(np.linalg.eigvalsh(whole)[0])) < _SMALLEST_EIGENVALUE:
        message = f"got a matrix that is not positive definite (smallest eigenvalue {least:.3g}), expected one that is"
        problems.add(path, message, "no quantities can be correlated like this")
        return None
    if (whole == np.eye(len(names))).all():
        return None
    return Matrix.model_validate({"between": list(names), "matrix": whole.tolist()}, context=names)
