"""The draws of all cells reduced, one scrambling of one cell after the other, to what the dataset holds.

No more than the draws of one scrambling are looked at together, so that memory depends on `draws` alone.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from stickslip.engine import Results
from stickslip.uncertainty.design import Design
from stickslip.uncertainty.estimate import IndexSums, Mean, index_sums, indices_of, ratio
from stickslip.vocabulary.flags import REGIMES

Floats = NDArray[np.float64]
Labels = NDArray[np.int8]

STATES = ("stick_slip", "damped", "creep", "sustained", "stuck")  # what a draw can be known to be
_CODES = np.array([REGIMES.index(name) for name in STATES], np.int8)


class Asked(NamedTuple):
    """What is told of the metrics."""

    metrics: Sequence[str]
    quantiles: Sequence[float]


class _Unit(NamedTuple):
    """What one scrambling of one cell says.

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


def reduced(blocks: Iterable[Results], cells: int, design: Design, asked: Asked) -> dict[str, Floats]:
    """What the draws say, by name, the first dimension that of the cells.

    blocks : the items of the run, in order.
    """
    rows: dict[str, list[Floats]] = {}
    units = _units(blocks, design, asked)
    for _ in range(cells):
        of_cell = [next(units) for _ in range(design.scramblings)]
        for name, value in _cell(of_cell, design, asked).items():
            rows.setdefault(name, []).append(value)
    return {name: np.array(values) for name, values in rows.items()}


def _units(blocks: Iterable[Results], design: Design, asked: Asked) -> Iterator[_Unit]:
    """The items in pieces of one scrambling of one cell, whatever the length of the blocks."""
    names = ("regime", *asked.metrics)
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
                yield _unit({name: np.concatenate(pieces[name]) for name in names}, design, asked)
                pieces, held = {name: [] for name in names}, 0


def _unit(results: Results, design: Design, asked: Asked) -> _Unit:
    regime = results["regime"].reshape(design.matrices, design.draws)
    plain = design.plain * design.draws
    counts = np.bincount(regime[: design.plain].ravel(), minlength=len(REGIMES))[_CODES].astype(np.float64)
    metrics = [values[np.isfinite(values)] for values in (results[name][:plain] for name in asked.metrics)]
    quantiles = [
        np.quantile(values, asked.quantiles) if values.size else np.full(len(asked.quantiles), np.nan)
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
        np.array(quantiles).reshape(len(asked.metrics), len(asked.quantiles)),
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


def _cell(units: Sequence[_Unit], design: Design, asked: Asked) -> dict[str, Floats]:
    """What all scramblings of a cell say together."""
    counts, known = np.array([one.counts for one in units]), np.array([one.known for one in units])
    total = float(design.scramblings * design.plain * design.draws)
    found = _probabilities(counts, known[:, None], total)
    sums, held = np.array([one.sums for one in units]), np.array([one.held for one in units])
    means = ratio(sums, held)
    for i, name in enumerate(asked.metrics):
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
