"""From draws to probabilities, moments and Sobol indices, each with its standard error.

No more than the draws of one scrambling of one cell are looked at together, so that memory depends on `draws` alone.

Scramblings are independent of each other, and each gives an unbiased estimate. So the spread of their estimates is the
error of their mean, whatever is estimated and however evenly Sobol points lie; errors of plain Monte Carlo would be far
too large, and one scrambling alone has none. (Owen 1997; L'Ecuyer, Nakayama, Owen and Tuffin 2023 find this interval
the most reliable of those tried.)
"""

from collections.abc import Iterable, Iterator, Mapping, Sequence
from typing import NamedTuple

import numpy as np

from stickslip.engine import Results
from stickslip.studies.draws import Design
from stickslip.studies.search import Flags, Floats, Labels
from stickslip.studies.study import joined
from stickslip.vocabulary.results import REGIMES

STATES = ("stick_slip", "damped", "creep", "sustained", "stuck")  # what a draw can be known to be
_CODES = np.array([REGIMES.index(name) for name in STATES], np.int8)


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


def indices_of(sums: IndexSums) -> dict[str, Mean]:
    """The indices from the sums of all scramblings, the first dimension; NaN where nothing varies."""
    variance = sums.variance + 0 * sums.first
    return {"sobol_first": ratio(sums.first, variance), "sobol_total": ratio(sums.total, variance)}


class Summary(NamedTuple):
    """Statistics of the metrics."""

    metrics: Sequence[str]
    quantiles: Sequence[float]


def reduced(blocks: Iterable[Results], cells: int, design: Design, summary: Summary) -> dict[str, Floats]:
    """Return what the draws say, by name, the first dimension that of the cells.

    blocks : the items of the run, in order.
    """
    rows: dict[str, list[Floats]] = {}
    units = (_estimates(unit, design, summary) for unit in _units(blocks, design.unit))
    for _ in range(cells):
        of_cell = [next(units) for _ in range(design.scramblings)]
        stacked = {name: np.array([unit[name] for unit in of_cell]) for name in of_cell[0]}
        for name, value in _cell(stacked, design, summary).items():
            rows.setdefault(name, []).append(value)
    return {name: np.array(values) for name, values in rows.items()}


def _units(blocks: Iterable[Results], size: int) -> Iterator[Results]:
    """The items in pieces of one scrambling of one cell, whatever the length of the blocks."""
    pieces: list[Results] = []
    count = 0
    for block in blocks:
        start, end = 0, block["regime"].size
        while start < end:
            stop = min(end, start + size - count)
            pieces.append({name: values[start:stop] for name, values in block.items()})
            count, start = count + stop - start, stop
            if count == size:
                yield joined(pieces)
                pieces, count = [], 0


def _estimates(results: Results, design: Design, summary: Summary) -> dict[str, Floats]:
    """Estimates by one scrambling of one cell.

    counts : of each state. sums, having, quantiles : of each metric, how many draws have it, its quantiles (metrics,
    quantiles). open : whether draws are unknown. out_, in_ : sums of the indices with these counted out of each state,
    and into each.
    """
    regime = results["regime"].reshape(design.matrices, design.draws)
    plain = design.plain * design.draws
    metrics = [values[np.isfinite(values)] for values in (results[name][:plain] for name in summary.metrics)]
    none = np.full(len(summary.quantiles), np.nan)
    quantiles = [np.quantile(values, summary.quantiles) if values.size else none for values in metrics]
    estimates = {
        "counts": np.bincount(regime[: design.plain].ravel(), minlength=len(REGIMES))[_CODES].astype(np.float64),
        "sums": np.array([values.sum() for values in metrics]),
        "having": np.array([values.size for values in metrics], np.float64),
        "quantiles": np.array(quantiles).reshape(len(summary.metrics), len(summary.quantiles)),
    }  # fmt: skip
    if design.indices:
        unknown = ~np.isin(regime, _CODES)
        estimates["open"] = np.asarray(unknown.any())
        for prefix, into in (("out_", np.zeros_like(unknown)), ("in_", unknown)):
            estimates |= {prefix + name: values for name, values in _index_sums(regime, into)._asdict().items()}
    return estimates


def _index_sums(regime: Labels, more: Flags) -> IndexSums:
    """The sums of the indicator of each state, with `more` draws counted into it."""
    quantities = regime.shape[0] - 2
    whole = IndexSums(*(np.zeros((len(STATES), n)) for n in (quantities, quantities, 1)))
    for i in np.flatnonzero(np.isin(_CODES, regime) | more.any()):
        values = ((regime == _CODES[i]) | more).astype(np.float64)
        for of_all, of_state in zip(whole, index_sums(values[0], values[1], values[2:]), strict=True):
            of_all[i] = of_state
    return whole


def _cell(units: Mapping[str, Floats], design: Design, summary: Summary) -> dict[str, Floats]:
    """Return what all scramblings of a cell say together; units : of each, the first dimension.

    The error of a probability is at least that of one draw in one scrambling: where all scramblings agree, as they do
    if a state was never met, their spread would be 0. The bounds hold whatever the unknown draws are.
    """
    counts, having, total = units["counts"], units["having"], float(design.per_cell // design.matrices * design.plain)
    share = ratio(counts, counts.sum(1, keepdims=True))
    unknown = total - counts.sum()
    cell = {
        "probability": share.value,
        "probability_error": np.where(np.isnan(share.value), np.nan, np.fmax(share.error, 1.0 / total)),
        "probability_low": counts.sum(0) / total,
        "probability_high": (counts.sum(0) + unknown) / total,
        "undecided": np.float64(unknown / total),
    }
    means = ratio(units["sums"], having)
    for i, name in enumerate(summary.metrics):
        cell[f"mean_{name}"], cell[f"mean_{name}_error"] = means.value[i], means.error[i]
        cell[f"count_{name}"] = having[:, i].sum()
        weight = having[:, i : i + 1]
        quantiles = ratio(np.where(weight > 0, units["quantiles"][:, i], 0.0) * weight, weight)
        cell[f"quantile_{name}"], cell[f"quantile_{name}_error"] = quantiles.value, quantiles.error
    return cell | (_indices(units) if design.indices else {})


def _indices(units: Mapping[str, Floats]) -> dict[str, Floats]:
    """Sobol indices per state; to their errors is added what counting unknown draws the other way would change.

    NaN where nothing would vary any more if they were counted the other way.
    """
    out, into = (indices_of(IndexSums(*(units[prefix + name] for name in IndexSums._fields)))
                 for prefix in ("out_", "in_"))  # fmt: skip
    cell = {}
    for name, (value, error) in out.items():
        if units["open"].any():
            error = error + np.abs(into[name].value - value)
            value = np.where(np.isfinite(error), value, np.nan)
        cell[name], cell[f"{name}_error"] = value, error
    return cell
