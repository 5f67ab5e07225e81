"""How well cells explain observations.

The regime of an observation was noted rightly with probability 1 - e, else it is any other of the n there are with the
same probability. The logarithm of a result that was measured scatters normally about that of the cell, and the mean
of repeats as Student's t, their variance being unknown (with the prior 1/sigma). A cell that does not have a result
that was measured is judged by its regime alone, as a regime that was noted wrongly; densities of logarithms are per
e-fold, so that such a cell counts as one whose result may be anything within an e-fold. Where an observation says no
regime, having its results is what may be noted wrongly.

Cells without a verdict (unresolved, failed) might have the regime that was seen or not: the likelihood takes that they
do, and `unsure` is by how much it would be less if they did not. Impossible cells explain nothing.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy import stats  # type: ignore[import-untyped]

from stickslip.config.grid import build_grid
from stickslip.config.model import Config
from stickslip.config.studies import Moved
from stickslip.engine import Options, Results, StopFlag, friction_at_belt_speed
from stickslip.studies.draws import computed_where, drawn_cells
from stickslip.vocabulary.cells import Cells, Parameters
from stickslip.vocabulary.quantities import DECIDED, REGIMES, UNDECIDED
from stickslip_explain.section import POINT, Measured, Observation

Floats = NDArray[np.float64]

# An observation that is no cell, as a function of draws: results, the regime among them, and which draws are possible.
Simulated = Callable[[Parameters, StopFlag, Moved | None], tuple[Results, NDArray[np.bool_]]]

RECORD = 1000  # cells that a simulated record takes about as long as
_FAR = 4.0  # standard deviations, or what is as rare of Student's t: a result further off is not explained


class Terms(NamedTuple):
    """By point and observation: log-likelihoods; what they lose if cells without a verdict are others; contradictions,
    in a regime or by far in a result."""

    log_likelihood: Floats
    unsure: Floats
    contradicts: NDArray[np.bool_]


@dataclass(frozen=True)
class Experiment:
    """Observations of an oscillator, some of whose quantities are not known.

    base : the one cell of the configuration, without what is unknown or differs. law, fixed : of friction, and what its
    name stands for. mislabelled : e. simulated : the observations that are no cells, by their numbers.
    """

    observed: Sequence[Observation]
    base: Cells
    law: str
    fixed: Mapping[str, float]
    mislabelled: float
    options: Options
    simulated: Mapping[int, Simulated] = field(default_factory=dict)

    @cached_property
    def _cells(self) -> list[int]:
        """The numbers of the observations of cells."""
        return [i for i in range(len(self.observed)) if i not in self.simulated]

    def cells(self, drawn: Parameters) -> tuple[Parameters, NDArray[np.bool_]]:
        """The cells of points (quantities that are not known, (n,) each), one observation of cells after the other; and
        which are possible."""
        size = next(iter(drawn.values())).size
        parts = []
        for i in self._cells:
            known = {**self.fixed, **self.observed[i].conditions}
            known_of_all = {name: np.full(size, value) for name, value in known.items()}
            parts.append(drawn_cells(self.base, np.zeros(size, np.int64), {**drawn, **known_of_all}, self.options))
        cells = {name: np.concatenate([part[name] for part, _ in parts]) for name in parts[0][0]}
        return cells, np.concatenate([possible for _, possible in parts])

    def terms(self, drawn: Parameters, stop: StopFlag, moved: Moved | None = None) -> Terms:
        """How well points explain each observation. Raises StoppedError."""
        each = self._results(drawn, stop, moved) if self._cells else {}
        of_records = (lambda done: moved(RECORD * done)) if moved else None
        each |= {i: simulate(drawn, stop, of_records) for i, simulate in self.simulated.items()}
        parts = []
        for i, observation in enumerate(self.observed):
            results, possible = each[i]
            terms = observation_terms(observation, results, self.mislabelled)
            terms.log_likelihood[~possible] = -np.inf
            parts.append(terms)
        return Terms(*(np.stack(part, axis=1) for part in zip(*parts, strict=True)))

    def _results(
        self, drawn: Parameters, stop: StopFlag, moved: Moved | None
    ) -> dict[int, tuple[Results, NDArray[np.bool_]]]:
        """By number of an observation of a cell, the results of points, and which are possible."""
        size, count = next(iter(drawn.values())).size, len(self._cells)
        cells, possible = self.cells(drawn)
        metrics = dict.fromkeys(name for observation in self.observed for name in observation.metrics)
        measuring = self.options.keeping(tuple(name for name in metrics if name != POINT))
        columns = computed_where(cells, possible, measuring, stop, moved)
        if POINT in metrics:
            columns[POINT] = np.where(possible, friction_at_belt_speed(cells, self.options), np.nan)
        results = {name: values.reshape(count, size) for name, values in columns.items()}
        each = zip(self._cells, possible.reshape(count, size), strict=True)
        return {number: ({name: values[i] for name, values in results.items()}, which)
                for i, (number, which) in enumerate(each)}  # fmt: skip


def grid_of_predictions(config: Config) -> Cells:
    """The cells of the axes, without what along them differs from what was observed."""
    whole = build_grid(config)
    return whole.without(*whole.along)


def results_over(
    grid: Cells, known: Mapping[str, float], options: Options, stop: StopFlag, moved: Moved | None = None
) -> Results:
    """The results of the cells of some axes. known : quantities they have in common. Raises StoppedError."""
    here = {name: np.full(grid.size, value) for name, value in known.items() if name not in grid.along}
    cells, possible = drawn_cells(grid, np.arange(grid.size), here, options)
    return computed_where(cells, possible, options, stop, moved)


def observation_terms(observed: Observation, results: Results, mislabelled: float) -> Terms:
    """The terms of one observation from the results of cells, (n,) each; see the top of this file."""
    regime = results["regime"]
    undecided = np.isin(regime, UNDECIDED)
    has_all = np.ones(regime.shape, np.bool_)
    log_density, far = np.zeros(regime.shape), np.zeros(regime.shape, np.bool_)
    for name, measured in (observed.metrics | observed.of_record).items():
        values = results[name]
        has = values > 0
        has_all &= has
        distribution = error_of(measured)
        error = (np.log(np.where(has, values, 1.0)) - measured.log_mean) / measured.log_std
        log_density += np.where(has, distribution.logpdf(error) - np.log(measured.log_std), 0.0)
        far |= has & (np.abs(error) > distribution.isf(stats.norm.sf(_FAR)))
    right, wrong = log_shares(len(observed.regime or ()) or 1, mislabelled)
    fits = has_all if observed.regime is None else np.isin(regime, [REGIMES.index(name) for name in observed.regime])
    fits_at_best = fits | undecided
    return Terms(
        np.where(fits_at_best, right, wrong) + log_density,
        np.where(undecided & ~(fits & (observed.regime is None)), right - wrong, 0.0),
        far | ~fits_at_best | (~has_all & ~undecided),
    )


def log_shares(alternatives: int, mislabelled: float) -> tuple[float, float]:
    """Log-probabilities of noting one of some regimes in a cell that has one of them, and in one that has another."""
    other = mislabelled / (len(DECIDED) - 1)
    return float(np.log(1.0 - mislabelled + (alternatives - 1) * other)), float(np.log(alternatives * other))


def error_of(measured: Measured) -> stats.rv_continuous:
    """The distribution of the error of a logarithm in units of its standard deviation."""
    return stats.norm if np.isinf(measured.freedom) else stats.t(measured.freedom)
