"""Explanations computed: items are the populations of every law, each a tempered sequential Monte Carlo of its own.

So threads, shards and a resumed run give the same bits, and the spread of independent populations is the standard error
of the evidence, whatever the sampler does. The prior is that of independent standard normal deviates
(`Uncertain.values` makes quantities of them), so that no bound of a quantity is a wall for the moves. A population goes
from the prior to the posterior through likelihoods to powers that rise from 0 to 1: each power is chosen so that half
of the population is still worth something, then the population is resampled, and moved by Metropolis steps drawn from
its own covariance until it has forgotten where it was, or forgets no more: modes that no move connects keep the share
that the weights gave them.

Sources: Del Moral, Doucet and Jasra (2006), J. R. Stat. Soc. B 68, 411-436; the powers as Jasra, Stephens, Doucet and
Tsagaris (2011), Scand. J. Stat. 38, 1-22, choose them; the number of moves after Dau and Chopin (2022), same journal
as the first, 84, 114-148, who show that a fixed one is what goes wrong.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from math import prod
from typing import Any

import numpy as np
import xarray as xr
from matplotlib.figure import Figure
from numpy.typing import NDArray

from stickslip import extensions
from stickslip.config.grid import build_grid
from stickslip.config.model import Config
from stickslip.config.problems import ProblemCollector
from stickslip.config.studies import Moved, ReportTable, Study
from stickslip.engine import Options, Results, StopFlag, joined
from stickslip.errors import Path
from stickslip.vocabulary.cells import Cells, taken
from stickslip.vocabulary.models import laws_with, model_of
from stickslip.vocabulary.quantities import DECIDED, PARAMETERS_OF, QUANTITIES, REGIMES
from stickslip_explain import proposals, summary
from stickslip_explain.likelihood import RECORD, Experiment, Floats, grid_of_predictions, results_over
from stickslip_explain.section import Explain, law_of

_DRAWS = 1000  # of the prior that are timed
_MOVES = 250  # of a population, about, for estimates of time

LogLikelihood = Callable[[Floats], Floats]

_WORTH = 0.5  # effective share of a population after a change of the power
_TAKEN = 0.3  # share of moves that are to be accepted; between the optima of one dimension (0.44) and of many (0.23)
_FORGOTTEN = 0.1  # correlation with where it was before, from which on a population has forgotten it
_PATIENCE, _PROGRESS = 10, 0.95  # moves after which that correlation is to have fallen to such a share of its least
_MOST_MOVES = 200


class ExplainStudy(Study):
    """The populations of a configuration with uncertain quantities and observations."""

    section, variables = Explain, summary.VARIABLES
    subject, caption = "probability", "explanation"
    name, counted, ragged = "posterior", "populations", True
    own_conditions = True
    columns: Mapping[str, np.dtype[Any]] = dict.fromkeys(
        ("score", "log_likelihood", "unsure", "contradicts", "log_evidence", "predicted"), np.dtype(np.float64)
    )

    def __init__(self, config: Config, section: Explain, options: Options) -> None:
        assert config.uncertain is not None
        self.config, self.request, self.prior = config, section, config.uncertain
        self.title, self.laws = "Explanation", section.laws or (config.friction.law,)
        self.dims, self.shape = ("law", "repetition"), (len(self.laws), section.repetitions)
        self.grid = grid_of_predictions(config)
        self.options = replace(options, variables=("regime",), early_stop=True)
        # Cells that regimes are predicted for, and the draws of a population that they are predicted from.
        self.grid_size = self.grid.size if config.axes else 0
        self.predicted_draws = min(int(section.draws), int(section.particles)) if config.axes else 0
        observed = sum(1 if observation.record is None else RECORD for observation in section.observed)
        self.cells_each = _MOVES * section.particles * observed + self.predicted_draws * self.grid_size
        self.weight = 4096  # a population is a block

    @classmethod
    def of(cls, given: Config, section: Explain, options: Options) -> ExplainStudy:
        """The populations that a configuration asks for."""
        return cls(given, section, options)

    @classmethod
    def given_in(cls, raw: Any) -> Iterator[Path]:
        """The conditions of the first observation; the others must name them as well."""
        observed = raw.get("observed") if isinstance(raw, dict) else None
        first = observed[0] if isinstance(observed, list) and observed else None
        yield from (("observed", 0, name) for name in (first if isinstance(first, dict) else ()) if name in QUANTITIES)

    @classmethod
    def conditions(cls, section: Explain) -> Mapping[str, float]:
        """Those of the first observation."""
        return section.observed[0].conditions

    @classmethod
    def answer(cls, ds: xr.Dataset) -> Mapping[str, Any]:
        """What contradicts, if nothing explains the observations."""
        text = ds.attrs.get("explained_contradiction")
        return {"contradiction": text, "observation": int(ds.attrs["explained_contradicting"])} if text else {}

    @classmethod
    def check(cls, section: Explain, config: Config, problems: ProblemCollector) -> None:
        """Note observations that say nothing, or not where they were made, and laws that do not fit."""
        if config.uncertain is None:
            problems.add((section.key,), "nothing is uncertain, expected a distribution of a quantity at least",
                         "uncertain: {quantities: {stiffness: {uniform: [1 N/mm, 9 N/mm]}}}", at_key=True)  # fmt: skip
            return
        uncertain = {*config.uncertain.names}
        known = {*config.fixed(), *uncertain}
        for i, observation in enumerate(section.observed):
            cls._check_observation(section, config, i, known | {*observation.conditions}, problems)
            for name in uncertain & observation.conditions.keys():
                problems.add((section.key, "observed", i, name), "given, and uncertain, expected one of them")
        along = {member.name for axis in config.axes for member in axis.members}
        for name in {*section.observed[0].conditions} - known - along - section.shared.keys() if config.axes else ():
            message = f"{name} differs between observations, so that nothing can be predicted without it"
            problems.add(("axes",), message, f"add it to the axes, or {name} to system or uncertain")
        for i, name in enumerate(section.laws or ()):
            if wrong := cls._wrong_law(name, config, uncertain, known):
                problems.add((section.key, "laws", i), f"got {name}{wrong}")

    @classmethod
    def _check_observation(
        cls, section: Explain, config: Config, number: int, known: set[str], problems: ProblemCollector
    ) -> None:
        """Note an observation that says nothing, or not where it was made."""
        observation, path = section.observed[number], (section.key, "observed", number)
        if observation.regime is None and not observation.metrics:
            problems.add(path, "nothing was observed, expected a regime, or a result with its scatter")
        elsewhere = {name for other in section.observed for name in other.conditions}
        for name, row in PARAMETERS_OF[model_of(config.friction.law)].items():
            if name not in known and row.section == "system" and row.default is None:
                message = f"missing, expected the {row.long_name}: here, in system or in uncertain"
                problems.add((*path, name), message, "an observation says what it was made at")
            elif name not in known and name in elsewhere:
                problems.add((*path, name), f"missing, expected the {row.long_name}, as other observations have")

    @classmethod
    def _wrong_law(cls, name: str, config: Config, uncertain: set[str], known: set[str]) -> str | None:
        """Why a law cannot explain with these quantities."""
        law, fixed = law_of(name)
        model = model_of(law)
        if model is not model_of(config.friction.law):
            return f" beside {config.friction.law}, expected laws of one model"
        if foreign := [quantity for quantity in uncertain if law not in laws_with(quantity)]:
            return f", which has no {foreign[0]}, which is uncertain"
        if twice := uncertain & {*fixed}:
            return f", whose {min(twice)} is uncertain"
        needed = {*model.needed} - {*fixed} - known
        lacking = [] if model.measured else [quantity for quantity in PARAMETERS_OF[model] if quantity in needed]
        return f", for which {lacking[0]} is missing" if lacking else None

    @classmethod
    def explain(cls, section: Explain, config: Config) -> Iterator[tuple[str, str, str]]:
        """The observations, and the settings."""
        for i, observation in enumerate(section.observed):
            yield f"observed {i + 1}", "", observation.words
        if section.laws:
            yield "laws", ", ".join(section.laws), "alternatives of the same probability"
        for name, row in section.rows.items():
            yield f"{section.key} {name}", f"{getattr(section, name):g}", row.long_name

    @classmethod
    def own_dims(cls) -> set[str]:
        """Those of draws and of what sums them up."""
        return super().own_dims() | {"draw", "quantity", "share", "law"}

    @classmethod
    def report(cls, ds: xr.Dataset) -> Iterator[str | ReportTable]:
        """What explains the observations, and how sure that is."""
        return proposals.report(ds) if "information" in ds else summary.report(ds)

    @classmethod
    def is_drawn(cls, ds: xr.Dataset) -> bool:
        """Always."""
        return True

    @classmethod
    def figure(
        cls, ds: xr.Dataset, variable: str | None, select: Mapping[str, Any], title: str | None, look: Any, state: str
    ) -> Figure | None:
        """Prior beside posterior, and the regimes over the axes; of a variable over the axes, its map."""
        from stickslip_explain.plots import plot_explained, plot_information

        if "information" in ds and variable is None:
            return plot_information(ds, title=title)
        return None if variable is not None else plot_explained(ds, dict(select).pop("state", state), title=title)

    @property
    def kernels(self) -> tuple[str, ...]:
        """The laws."""
        return tuple(dict.fromkeys(self._law(name).options.law for name in self.laws))

    def _law(self, name: str) -> Experiment:
        """The observations as cells of a law."""
        law, fixed = law_of(name)
        base = build_grid(self.config.model_copy(update={"axes": ()}))
        options = replace(self.options, law=law).for_contact({*self.prior.names, *base.fixed})
        observed, e = self.request.observed, float(self.request.mislabelled)
        friction = self.config.friction.model_copy(update={"law": law, **fixed})
        simulated = {i: extensions.call("rig", "stickslip").SimulatedRecords(record.drive, record.known, friction)
                     for i, record in enumerate(observed) if record.record is not None}  # fmt: skip
        return Experiment(observed, base, options.law, fixed, e, options, simulated)

    def sample(self, count: int) -> Cells:
        """Cells of draws from the prior, to time what an explanation takes."""
        rng = np.random.default_rng(int(self.request.seed))
        points = rng.standard_normal((min(count, _DRAWS), len(self.prior.names)))
        cells = replace(self._law(self.laws[0]), simulated={})  # a simulated record counts as so many of them
        return Cells.of(taken(*cells.cells(self.prior.values(points))))

    def compute(self, items: range, stop: StopFlag, moved: Moved | None = None) -> Results:
        """Populations, one after the other."""
        parts = [self._population(*divmod(item, self.shape[1]), stop, moved) for item in items]
        return joined(parts) if parts else self.blank(items)

    def _population(self, number: int, repetition: int, stop: StopFlag, moved: Moved | None) -> Results:
        experiment, dimensions = self._law(self.laws[number]), len(self.prior.names)

        def log_likelihood(points: Floats) -> Floats:
            return np.asarray(experiment.terms(self.prior.values(points), stop, moved).log_likelihood.sum(1))

        rng = np.random.default_rng([int(self.request.seed), number, repetition])
        population = tempered(log_likelihood, dimensions, int(self.request.particles), rng)
        terms = experiment.terms(self.prior.values(population.points), stop, moved)
        return {
            "score": population.points.ravel(),
            "log_likelihood": terms.log_likelihood.ravel(),
            "unsure": terms.unsure.sum(1),
            "contradicts": terms.contradicts.ravel().astype(np.float64),
            "log_evidence": np.array([population.log_evidence]),
            "predicted": self._predicted(experiment, population.points, stop, moved).ravel(),
        }

    def _predicted(self, experiment: Experiment, points: Floats, stop: StopFlag, moved: Moved | None) -> Floats:
        """By cell of the axes and regime that says what the motion is, the share of some draws; (cells, regimes)."""
        size, draws = self.grid_size, self.predicted_draws
        shares = np.zeros((size, len(DECIDED)))
        if not size:
            return shares
        chosen = np.linspace(0, len(points) - 1, draws).astype(int)
        drawn = self.prior.values(points[chosen])
        codes = [REGIMES.index(name) for name in DECIDED]
        for draw in range(draws):
            known = {name: value[draw] for name, value in drawn.items()} | self.request.shared | {**experiment.fixed}
            results = results_over(self.grid, known, experiment.options, stop, moved)
            shares += results["regime"][:, None] == codes
        return shares / draws

    def blank(self, items: range) -> Results:
        """Populations of which nothing is known."""
        return {name: np.full(len(items) * prod(self._shape_of(name)), np.nan) for name in self.columns}

    def _shape_of(self, column: str) -> tuple[int, ...]:
        n, d, o = int(self.request.particles), len(self.prior.names), len(self.request.observed)
        shapes = {"score": (n, d), "log_likelihood": (n, o), "unsure": (n,), "contradicts": (n, o),
                  "predicted": (self.grid_size, len(DECIDED))}  # fmt: skip
        return shapes.get(column, ())

    def dataset(self, parts: Sequence[Results], attributes: Mapping[str, Any]) -> xr.Dataset:
        """The draws, and what they say."""
        columns = joined(parts)
        whole = {name: column.reshape(*self.shape, *self._shape_of(name)) for name, column in columns.items()}
        context = summary.Context(self.prior, self.request, self.laws, self.grid, self.config.written_in)
        return summary.dataset(context, whole, attributes)


# --- tempered sequential Monte Carlo ----------------------------------------------------------------------------------


@dataclass(frozen=True, eq=False)
class Population:
    """Draws from a posterior, all of the same weight: standard normal deviates (n, dimensions), their likelihoods, and
    the evidence (-inf where no point of the prior has a likelihood)."""

    points: Floats
    log_likelihood: Floats
    log_evidence: float


def tempered(log_likelihood: LogLikelihood, dimensions: int, size: int, rng: np.random.Generator) -> Population:
    """A population of `size` points. log_likelihood : of points (n, dimensions), (n,); -inf is a value, NaN is none."""
    points = rng.standard_normal((size, dimensions))
    values = log_likelihood(points)
    power, log_evidence, reach = 0.0, 0.0, 2.38 / np.sqrt(dimensions)
    while power < 1.0:
        weights, step = _reweighted(values, 1.0 - power)
        mean = float(weights.mean())
        if mean == 0.0:
            return Population(points, values, -np.inf)
        best = float(np.max(values))
        log_evidence += np.log(mean) + step * best
        power = power + step if step < 1.0 - power else 1.0
        chosen = _resampled(weights, rng)
        points, values = points[chosen], values[chosen]
        points, values, reach = _moved(log_likelihood, points, values, power, reach, rng)
    return Population(points, values, float(log_evidence))


def _reweighted(values: Floats, left: float) -> tuple[Floats, float]:
    """Weights, the largest of them 1, after the largest step of the power, at most `left`, that keeps `_WORTH` of the
    points with a likelihood; the others are lost at the smallest step."""
    known = np.isfinite(values)
    if not known.any():
        return np.zeros(values.size), left
    differences = np.where(known, values - values[known].max(), -np.inf)

    def weights(step: float) -> Floats:
        return np.asarray(np.where(known, np.exp(step * np.where(known, differences, 0.0)), 0.0))

    def worth(step: float) -> float:
        w = weights(step)
        return float(w.sum() ** 2 / (w @ w) / known.sum())

    if worth(left) >= _WORTH:
        return weights(left), left
    low, high = 0.0, left
    for _ in range(200):
        middle = 0.5 * (low + high)
        low, high = (middle, high) if worth(middle) >= _WORTH else (low, middle)
        if high - low <= 1e-6 * high:
            break
    return weights(high), high


def _resampled(weights: Floats, rng: np.random.Generator) -> NDArray[np.intp]:
    """Numbers of points in proportion to their weights, systematically: each as often as it should be, but for one."""
    places = (np.arange(weights.size) + rng.random()) / weights.size
    return np.minimum(np.searchsorted(np.cumsum(weights) / weights.sum(), places), weights.size - 1)


def _moved(
    log_likelihood: LogLikelihood, points: Floats, values: Floats, power: float, reach: float,
    rng: np.random.Generator,
) -> tuple[Floats, Floats, float]:  # fmt: skip
    """The population after so many moves that it has forgotten where it was, and the reach they had."""
    size, dimensions = points.shape
    spread = np.atleast_2d(np.cov(points, rowvar=False)) + 1e-12 * np.eye(dimensions)
    root = np.asarray(np.linalg.cholesky(spread), np.float64)
    first = _whitened(points, root)
    enough = max(_FORGOTTEN, 3.0 / np.sqrt(size))  # what chance alone makes of independent points
    least, waited = np.inf, 0
    for _ in range(_MOST_MOVES):
        tried = points + reach * rng.standard_normal(points.shape) @ root.T
        moved = log_likelihood(tried)
        gain = power * (moved - values) + 0.5 * (np.sum(points**2, 1) - np.sum(tried**2, 1))
        taken = np.log(rng.random(size)) < gain
        points, values = np.where(taken[:, None], tried, points), np.where(taken, moved, values)
        reach = min(reach * float(np.exp(taken.mean() - _TAKEN)), 10.0)
        left = float(np.abs(np.mean(first * _whitened(points, root), axis=0)).max())
        least, waited = (left, 0) if left < _PROGRESS * least else (least, waited + 1)
        if left <= enough or waited == _PATIENCE:
            break
    return points, values, reach


def _whitened(points: Floats, root: Floats) -> Floats:
    """The points along independent directions, centred, each of variance 1."""
    white = np.linalg.solve(root, (points - points.mean(0)).T).T
    return np.asarray(white / np.maximum(white.std(0), 1e-300))
