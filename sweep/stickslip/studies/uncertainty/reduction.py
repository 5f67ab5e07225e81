"""The draws of all cells reduced, one scrambling of one cell after the other, to what the dataset holds.

No more than the draws of one scrambling are looked at together, so that memory depends on `draws` alone.

From the draws of one cell to probabilities, moments and Sobol indices, each with its standard error.

Scramblings are independent of each other, and each gives an unbiased estimate. So the spread of their estimates is the
error of their mean, whatever is estimated and however evenly Sobol points lie; errors of plain Monte Carlo would be far
too large, and one scrambling alone has none. (Owen 1997; L'Ecuyer, Nakayama, Owen and Tuffin 2023 find this interval
the most reliable of those tried.)
"""

from collections.abc import Iterable, Iterator, Sequence
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from stickslip.engine import Results
from stickslip.studies.uncertainty.design import Design
from stickslip.vocabulary.flags import REGIMES

Floats = NDArray[np.float64]
Labels = NDArray[np.int8]


class Mean(NamedTuple):
    """A mean over scramblings and its standard error; arrays of one shape."""

    value: Floats
    error: Floats


def ratio(above: Floats, below: Floats) -> Mean:
    """The ratio of two sums over scramblings (first dimension), with the jackknife error over scramblings.

    NaN where the sum `below` is 0, or would be without one of the scramblings: then nothing is known of the error.
    """
    with np.errstate(divide="ignore", invalid="ignore"):
        whole = above.sum(0) / below.sum(0)
        without = (above.sum(0) - above) / (below.sum(0) - below)
    count = len(above)
    if count < 2:
        return Mean(whole, np.full(whole.shape, np.nan))
    with np.errstate(invalid="ignore"):
        error = np.sqrt((count - 1) / count * np.sum((without - without.mean(0)) ** 2, axis=0))
    known = np.isfinite(whole)
    return Mean(np.where(known, whole, np.nan), np.where(known, error, np.nan))


class Indices(NamedTuple):
    """First-order and total Sobol indices, (..., quantities)."""

    first: Mean
    total: Mean


class IndexSums(NamedTuple):
    """Sums behind the indices of one scrambling: (..., quantities), the variance with a last dimension 1."""

    first: Floats
    total: Floats
    variance: Floats


def index_sums(a: Floats, b: Floats, mixed: Floats) -> IndexSums:
    """The sums of one scrambling.

    a, b : values at the draws of A and of B, (..., draws). mixed : at those of A with one column of B,
    (..., quantities, draws).
    First order by Saltelli et al. (2010, table 2 b), total by Jansen (1999), as `scipy.stats.sobol_indices`.
    """
    centre = 0.5 * (a.mean(-1) + b.mean(-1))[..., None]
    a, b = a - centre, b - centre
    mixed = mixed - centre[..., None]
    step = mixed - a[..., None, :]
    first = np.mean(b[..., None, :] * step, axis=-1)
    total = 0.5 * np.mean(step**2, axis=-1)
    return IndexSums(first, total, 0.5 * np.mean(a**2 + b**2, axis=-1)[..., None])


def indices_of(sums: list[IndexSums]) -> Indices:
    """The indices from the sums of all scramblings; NaN where nothing varies."""
    first, total, variance = (np.array([getattr(one, name) for one in sums]) for name in IndexSums._fields)
    return Indices(ratio(first, variance + 0 * first), ratio(total, variance + 0 * total))


STATES = ("stick_slip", "damped", "creep", "sustained", "stuck")  # what a draw can be known to be
_CODES = np.array([REGIMES.index(name) for name in STATES], np.int8)


class Summary(NamedTuple):
    """Statistics of the metrics."""

    metrics: Sequence[str]
    quantiles: Sequence[float]


class _Unit(NamedTuple):
    """Estimates by one scrambling of one cell.

    counts : of each state (states,), and of draws that are known at all, `known`. sums, held, quantiles : of each
    metric, how many have it, and their quantiles (metrics, quantiles). inside, outside : sums of the indices with
    unknown draws counted in and out of each state.
    """

    counts: Floats
    known: float
    sums: Floats
    held: Floats
    quantiles: Floats
    outside: IndexSums | None
    inside: IndexSums | None


def reduced(blocks: Iterable[Results], cells: int, design: Design, summary: Summary) -> dict[str, Floats]:
    """Return what the draws say, by name, the first dimension that of the cells.

    blocks : the items of the run, in order.
    """
    rows: dict[str, list[Floats]] = {}
    units = _units(blocks, design, summary)
    for _ in range(cells):
        of_cell = [next(units) for _ in range(design.scramblings)]
        for name, value in _cell(of_cell, design, summary).items():
            rows.setdefault(name, []).append(value)
    return {name: np.array(values) for name, values in rows.items()}


def _units(blocks: Iterable[Results], design: Design, summary: Summary) -> Iterator[_Unit]:
    """The items in pieces of one scrambling of one cell, whatever the length of the blocks."""
    names = ("regime", *summary.metrics)
    pieces: dict[str, list[NDArray[Any]]] = {name: [] for name in names}
    held = 0
    for block in blocks:
        size, start = block["regime"].size, 0
        while start < size:
            stop = min(size, start + design.unit - held)
            for name in names:
                pieces[name].append(block[name][start:stop])
            held, start = held + stop - start, stop
            if held == design.unit:
                yield _unit({name: np.concatenate(pieces[name]) for name in names}, design, summary)
                pieces, held = {name: [] for name in names}, 0


def _unit(results: Results, design: Design, summary: Summary) -> _Unit:
    regime = results["regime"].reshape(design.matrices, design.draws)
    plain = design.plain * design.draws
    counts = np.bincount(regime[: design.plain].ravel(), minlength=len(REGIMES))[_CODES].astype(np.float64)
    metrics = [values[np.isfinite(values)] for values in (results[name][:plain] for name in summary.metrics)]
    quantiles = [
        np.quantile(values, summary.quantiles) if values.size else np.full(len(summary.quantiles), np.nan)
        for values in metrics
    ]
    outside = inside = None
    if design.indices:
        outside, inside = _index_sums(regime)
    return _Unit(
        counts,
        float(counts.sum()),
        np.array([values.sum() for values in metrics]),
        np.array([values.size for values in metrics], np.float64),
        np.array(quantiles).reshape(len(summary.metrics), len(summary.quantiles)),
        outside,
        inside,
    )


def _index_sums(regime: Labels) -> tuple[IndexSums, IndexSums | None]:
    """The sums of the indicator of each state: unknown draws are not in it; and, if there are some, all are in it."""
    present = np.isin(_CODES, regime)
    unknown = ~np.isin(regime, _CODES)

    def sums(more: NDArray[np.bool_]) -> IndexSums:
        size = regime.shape[0] - 2
        found = IndexSums(*(np.zeros((len(STATES), n)) for n in (size, size, 1)))
        for i in np.flatnonzero(present | more.any()):
            values = ((regime == _CODES[i]) | more).astype(np.float64)
            for whole, one in zip(found, index_sums(values[0], values[1], values[2:]), strict=True):
                whole[i] = one
        return found

    none = np.zeros_like(unknown)
    return sums(none), sums(unknown) if unknown.any() else None


def _cell(units: Sequence[_Unit], design: Design, summary: Summary) -> dict[str, Floats]:
    """Return what all scramblings of a cell say together."""
    counts, known = np.array([one.counts for one in units]), np.array([one.known for one in units])
    total = float(design.scramblings * design.plain * design.draws)
    found = _probabilities(counts, known[:, None], total)
    sums, held = np.array([one.sums for one in units]), np.array([one.held for one in units])
    means = ratio(sums, held)
    for i, name in enumerate(summary.metrics):
        found[f"mean_{name}"], found[f"mean_{name}_error"] = means.value[i], means.error[i]
        found[f"count_{name}"] = held[:, i].sum()
        quantiles = np.array([one.quantiles[i] for one in units])
        weighted = ratio(np.where(held[:, i : i + 1] > 0, quantiles, 0.0) * held[:, i : i + 1], held[:, i : i + 1])
        found[f"quantile_{name}"], found[f"quantile_{name}_error"] = weighted.value, weighted.error
    if design.indices:
        found |= _indices(units)
    return found


def _probabilities(counts: Floats, known: Floats, total: float) -> dict[str, Floats]:
    """Shares of the states among the draws that are known, and bounds that hold whatever the others are.

    The error is at least that of one draw in one scrambling: where all scramblings agree, as they do if a state was
    never met, their spread would be 0.
    """
    share: Mean = ratio(counts, known)
    error = np.where(np.isnan(share.value), np.nan, np.fmax(share.error, 1.0 / total))
    unknown = total - known.sum()
    return {
        "probability": share.value,
        "probability_error": error,
        "probability_low": counts.sum(0) / total,
        "probability_high": (counts.sum(0) + unknown) / total,
        "undecided": np.float64(unknown / total),
    }


def _indices(units: Sequence[_Unit]) -> dict[str, Floats]:
    """Sobol indices per state; to their errors is added what counting unknown draws the other way would change.

    NaN where nothing would vary any more if they were counted the other way.
    """
    outside = indices_of([one.outside for one in units if one.outside])
    found = {}
    other = None
    if any(one.inside for one in units):
        other = indices_of([one.inside or one.outside for one in units if one.outside])
    for i, name in enumerate(("sobol_first", "sobol_total")):
        found[name], found[f"{name}_error"] = outside[i].value, outside[i].error
        if other is not None:
            error = outside[i].error + np.abs(other[i].value - outside[i].value)
            found[name], found[f"{name}_error"] = np.where(np.isfinite(error), found[name], np.nan), error
    return found
