"""Draws of what is uncertain, the cells behind them, and what they say together.

An item is a draw by cell, scrambling, matrix and number, in that order, the last running fastest: scrambled Sobol
points, none of which depends on which others are asked for. So a block of a run makes its own points wherever it lies,
and a hundred million of them are never in memory together.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property, lru_cache
from typing import NamedTuple

import numpy as np
import scipy  # type: ignore[import-untyped]

from stickslip.config.grid import build_grid
from stickslip.config.model import Config
from stickslip.config.studies import Moved
from stickslip.config.uncertain import Uncertain
from stickslip.engine import Options, Results, StopFlag, blank_results, compute_range, joined
from stickslip.studies.search import Flags, Floats, Integers, Labels
from stickslip.vocabulary.cells import Cells, Parameters, impossible, taken
from stickslip.vocabulary.models import model_of
from stickslip.vocabulary.quantities import MEASURED, REGIMES

BITS = 30  # of a coordinate, as SciPy has them
_AT_ONCE = 2**16  # points of a scrambling that are made together; many, since SciPy walks to the first of them
_IN_MEMORY = 2**21  # points


class SobolPoints:
    """Independent scramblings of the first `count` Sobol points in the unit cube; count : a power of two.

    Scrambling: a random matrix and a digital shift (Matousek).
    """

    def __init__(self, dimensions: int, count: int, seed: int) -> None:
        self._dimensions, self._together = dimensions, min(count, _AT_ONCE)
        self._seed = seed
        self._part = lru_cache(_IN_MEMORY // self._together)(self._part_of)

    def at(self, scrambling: Integers, number: Integers) -> Floats:
        """Points by scrambling and number (both (n,)), as (n, dimensions), strictly between 0 and 1.

        A point is the middle of its interval of 2^-30: SciPy gives the lower end, which may be 0.
        """
        points = np.empty((number.size, self._dimensions))
        places = np.stack([scrambling, number // self._together])
        for scrambled, part in np.unique(places, axis=1).T.tolist():
            here = (places[0] == scrambled) & (places[1] == part)
            points[here] = self._part(scrambled, part)[number[here] % self._together]
        return points + 0.5 * 2.0**-BITS

    def _part_of(self, scrambling: int, part: int) -> Floats:
        """Points of a scrambling that are made together."""
        # A new one every time: SciPy spawns another from it, which it remembers.
        seed = np.random.SeedSequence(self._seed, spawn_key=(scrambling,))
        engine = scipy.stats.qmc.Sobol(self._dimensions, scramble=True, bits=BITS, seed=np.random.default_rng(seed))
        if part:  # SciPy takes 0 points for more than none
            engine.fast_forward(part * self._together)
        return np.asarray(engine.random(self._together), np.float64)


class DrawPlace(NamedTuple):
    """Places of items: four rows of numbers. matrix : 0 is A, 1 is B, 2 + i is A with the column i of B."""

    cell: Integers
    scrambling: Integers
    matrix: Integers
    number: Integers


@dataclass(frozen=True)
class Design:
    """The draws of every cell, the same in all of them, so that cells differ by what they are and not by luck.

    quantities : how many are uncertain. draws : per scrambling and matrix, a power of two.
    indices : whether the matrices of Saltelli (2010) are drawn, quantities + 2 of them, or one alone.
    """

    quantities: int
    draws: int
    scramblings: int
    seed: int
    indices: bool

    @property
    def matrices(self) -> int:
        """Matrices of draws per scrambling."""
        return self.quantities + 2 if self.indices else 1

    @property
    def plain(self) -> int:
        """Matrices that are independent draws, from which probabilities are counted: A, and B if there is one."""
        return 2 if self.indices else 1

    @property
    def unit(self) -> int:
        """Draws of one cell in one scrambling."""
        return self.matrices * self.draws

    @property
    def per_cell(self) -> int:
        """Draws of one cell."""
        return self.scramblings * self.unit

    @cached_property
    def points(self) -> SobolPoints:
        """In the unit cube; the columns of B after those of A."""
        return SobolPoints(self.plain * self.quantities, self.draws, self.seed)

    def place(self, start: int, stop: int) -> DrawPlace:
        """Return where the items from `start` to `stop` stand."""
        shape = (-(-stop // self.per_cell) or 1, self.scramblings, self.matrices, self.draws)
        return DrawPlace(*np.unravel_index(np.arange(start, stop, dtype=np.int64), shape))

    def normals(self, place: DrawPlace) -> Floats:
        """Independent standard normal deviates of items, (n, quantities)."""
        points, matrix, d = self.points.at(place.scrambling, place.number), place.matrix[:, None], self.quantities
        drawn = points[:, :d]
        if self.indices:
            drawn = np.where((matrix == 1) | (matrix == 2 + np.arange(d)), points[:, d:], drawn)
        return np.asarray(scipy.special.ndtri(drawn))


@dataclass(frozen=True)
class Inputs:
    """Cells of a configuration with uncertain quantities."""

    config: Config

    @property
    def uncertain(self) -> Uncertain:
        """The quantities that scatter."""
        if self.config.uncertain is None:
            raise ValueError("this configuration has no section uncertain")
        return self.config.uncertain

    @cached_property
    def grid(self) -> Cells:
        """The cells of its axes, without what is uncertain."""
        return build_grid(self.config)

    def cells(self, numbers: Integers, normals: Floats) -> tuple[Parameters, Flags]:
        """Parameters of cells of the axes, their uncertain ones drawn; and which of the draws an oscillator can have.

        numbers : of cells of the axes, (n,). normals : independent standard normal deviates, (n, quantities).
        Others (friction below 0, mu_stop above its start, ...) are `failed`; a configuration with more than one in some
        thousand of them is refused when it is read.
        """
        return drawn_cells(self.grid, numbers, self.uncertain.values(normals), Options(self.config.friction.law))

    def compute(
        self, numbers: Integers, normals: Floats, options: Options, stop: StopFlag, moved: Moved | None = None
    ) -> Results:
        """Their results, by the calling thread. Raises StoppedError."""
        return computed_where(*self.cells(numbers, normals), options, stop, moved)


def drawn_cells(grid: Cells, numbers: Integers, drawn: Parameters, options: Options) -> tuple[Parameters, Flags]:
    """Parameters of the cells of these numbers, drawn quantities in place of their own; and which are possible."""
    cells = grid.take(numbers, **drawn)
    model = model_of(options.law)
    wrong, curve = impossible(cells, model.rules.get(options.law, ())), model.curve
    if curve and MEASURED.keys() & drawn.keys():
        wrong |= ~(cells[curve.drop] > 0)  # its minimum is not below its start
    return cells, ~wrong


def computed_where(
    cells: Parameters, possible: Flags, options: Options, stop: StopFlag, moved: Moved | None = None
) -> Results:
    """The results of cells, by the calling thread; those of impossible ones are `failed`. Raises StoppedError."""
    chosen = Cells.of(taken(cells, possible))
    computed = compute_range(chosen, 0, chosen.size, options, stop, moved)
    results = blank_results(possible.size, options)
    results["regime"][:] = REGIMES.index("failed")
    for name, values in results.items():
        values[possible] = computed[name]
    return results


# --- from draws to probabilities, moments and Sobol indices -----------------------------------------------------------

# No more than the draws of one scrambling of one cell are looked at together, so that memory depends on `draws` alone.
# Scramblings are independent of each other, and each gives an unbiased estimate. So the spread of their estimates is
# the error of their mean, whatever is estimated and however evenly Sobol points lie; errors of plain Monte Carlo would
# be far too large. (Owen 1997; L'Ecuyer, Nakayama, Owen and Tuffin 2023 find this interval the most reliable.)

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
    """The indices from the sums of all scramblings, the first dimension; NaN where nothing varies.

    One quantity alone explains all of the variance.
    """
    variance = sums.variance + 0 * sums.first
    if variance.shape[-1] == 1:
        sums = IndexSums(variance, variance, variance)
    return {"sobol_first": ratio(sums.first, variance), "sobol_total": ratio(sums.total, variance)}


def reduced(
    blocks: Iterable[Results], cells: int, design: Design, metrics: Sequence[str], levels: Sequence[float]
) -> dict[str, Floats]:
    """Return what the draws say, by name, the first dimension that of the cells.

    blocks : the items of the run, in order. metrics : of which mean and quantiles, at these levels, are wanted.
    """
    rows: dict[str, list[Floats]] = {}
    units = (_estimates(unit, design, metrics, levels) for unit in _units(blocks, design.unit))
    for _ in range(cells):
        of_cell = [next(units) for _ in range(design.scramblings)]
        stacked = {name: np.array([unit[name] for unit in of_cell]) for name in of_cell[0]}
        for name, value in _cell(stacked, design, metrics).items():
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


def _estimates(results: Results, design: Design, metrics: Sequence[str], levels: Sequence[float]) -> dict[str, Floats]:
    """Estimates by one scrambling of one cell.

    counts : of each state. sums, having, quantiles : of each metric, how many draws have it, its quantiles (metrics,
    quantiles). open : whether draws are unknown. out_, in_ : sums of the indices with these counted out of each state,
    and into each.
    """
    regime = results["regime"].reshape(design.matrices, design.draws)
    plain = design.plain * design.draws
    having = [values[np.isfinite(values)] for values in (results[name][:plain] for name in metrics)]
    quantiles = [np.quantile(values, levels) if values.size else np.full(len(levels), np.nan) for values in having]
    estimates = {
        "counts": np.bincount(regime[: design.plain].ravel(), minlength=len(REGIMES))[_CODES].astype(np.float64),
        "sums": np.array([values.sum() for values in having]),
        "having": np.array([values.size for values in having], np.float64),
        "quantiles": np.array(quantiles).reshape(len(metrics), len(levels)),
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


def _cell(units: Mapping[str, Floats], design: Design, metrics: Sequence[str]) -> dict[str, Floats]:
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
    for i, name in enumerate(metrics):
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
