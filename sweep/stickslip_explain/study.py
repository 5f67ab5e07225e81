"""Explanations computed: items are the populations of every law, each a sequential Monte Carlo of its own.

A population is an item, so that threads, shards and a resumed run give the same bits, and the spread of independent
populations is the standard error of the evidence, whatever the sampler does.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from functools import cached_property
from math import prod
from typing import Any

import numpy as np
import xarray as xr
from matplotlib.figure import Figure

from stickslip import extensions
from stickslip.config.grid import build_grid
from stickslip.config.model import Config
from stickslip.config.problems import ProblemCollector
from stickslip.config.studies import Moved, ReportTable, Study
from stickslip.engine import Options, Results, StopFlag
from stickslip.errors import Path
from stickslip.studies.study import joined
from stickslip.vocabulary.cells import Cells, taken
from stickslip.vocabulary.flags import DECIDED, REGIMES
from stickslip.vocabulary.models import laws_with, model_of
from stickslip.vocabulary.quantities import PARAMETERS_OF, QUANTITIES
from stickslip_explain import proposals, summary
from stickslip_explain.likelihood import RECORD, Experiment, Floats, grid_of_predictions, results_over
from stickslip_explain.section import Explain, law_of
from stickslip_explain.smc import tempered

_DRAWS = 1000  # of the prior that are timed
_MOVES = 250  # of a population, about, for estimates of time
_COLUMNS = ("score", "log_likelihood", "unsure", "contradicts", "log_evidence", "evaluations", "predicted")


class ExplainStudy(Study):
    """The populations of a configuration with uncertain quantities and observations."""

    section, variables = Explain, summary.VARIABLES
    subject, caption = "probability", "explanation"
    name, counted, ragged = "posterior", "populations", True
    own_conditions = True
    columns: Mapping[str, np.dtype[Any]] = dict.fromkeys(_COLUMNS, np.dtype(np.float64))

    def __init__(self, config: Config, section: Explain, options: Options) -> None:
        assert config.uncertain is not None
        self.config, self.request, self.prior = config, section, config.uncertain
        self.title, self.laws = "Explanation", section.laws or (config.friction.law,)
        self.dims, self.shape = ("law", "repetition"), (len(self.laws), section.repetitions)
        self.grid = grid_of_predictions(config)
        self.options = replace(options, variables=("regime",), early_stop=True)
        observed = sum(1 if observation.record is None else RECORD for observation in section.observed)
        self.cells_each = _MOVES * section.particles * observed + self.predicted_draws * self.grid_size
        self.weight = 4096  # a population is a block

    @property
    def predicted_draws(self) -> int:
        """Draws of a population that regimes are predicted from."""
        return min(int(self.request.draws), int(self.request.particles)) if self.config.axes else 0

    @property
    def grid_size(self) -> int:
        """Cells that regimes are predicted for."""
        return self.grid.size if self.config.axes else 0

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
        parts = []
        for item in items:
            number, repetition = divmod(item, self.shape[1])
            parts.append(self._population(number, repetition, stop, moved))
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
            "evaluations": np.array([float(population.evaluations)]),
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
        return summary.dataset(self._context, whole, attributes)

    @cached_property
    def _context(self) -> summary.Context:
        return summary.Context(self.prior, self.request, self.laws, self.grid, self.config.written_in)
