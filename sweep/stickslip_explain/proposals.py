"""What to measure next: how much an observation at each place of some axes would tell of what is not known yet.

The expected information of an observation is the mutual information of what is seen there and of the draws: by how
much, on average over what might be seen, the entropy of the draws falls (Lindley 1956). Of each draw the regime and the
results at a place are computed; what it would show is simulated, with labels that may be wrong and results that
scatter, and weighed against what all draws would show. Measured in bits: one bit is a question that halves what is
possible. With n draws no more than log2 n bits can be seen.
"""

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import replace
from typing import Any

import numpy as np
import xarray as xr
from numpy.typing import NDArray
from pydantic_core import PydanticCustomError

from stickslip.config.grid import options_of
from stickslip.config.model import Config, Range
from stickslip.config.sections import interval
from stickslip.config.studies import ReportTable
from stickslip.dataset.build import NO_FILL, grid_coordinates, study_dataset, text_index
from stickslip.engine import Options, stop_flag
from stickslip.errors import ArgumentError
from stickslip.vocabulary.cells import Cells
from stickslip.vocabulary.parameter import Variable, table
from stickslip.vocabulary.quantities import DECIDED, PARAMETERS, REGIMES, listed, or_meant
from stickslip_explain.likelihood import grid_of_predictions, log_shares, results_over
from stickslip_explain.section import METRICS, POINT, Explain, law_of
from stickslip_explain.summary import table_over

Floats = NDArray[np.float64]

DRAWS, POINTS, BEST = 256, 16, 3
_APART = 0.2  # of the axes: proposals lie as far from one another at least
_SCATTER = 0.03  # of a result that nobody has measured yet: relative standard deviation
_BEYOND = 3.0
_PROPOSAL = ("proposal",)
VARIABLES = table(
    Variable("information", "1", "expected information of an observation (bits)",
             comment="mutual information of regime and results, and of what is not known"),
    Variable("chance", "1", "probability of seeing a regime", dims=("state",)),
    Variable("proposed_information", "1", "expected information of a proposal (bits)", dims=_PROPOSAL),
    Variable("spread_left", "1", "expected standard deviation of a quantity after the observation over that before",
             dims=("proposal", "quantity")),
)  # fmt: skip


def proposals(
    explained: xr.Dataset, config: Config, over: Sequence[Range], at: Mapping[str, float],
    measured: Mapping[str, float], draws: int = DRAWS, moved: Callable[[int, int], None] | None = None,
) -> xr.Dataset:  # fmt: skip
    """The expected information over axes, and the best observations; see `next_measurement`. Raises ArgumentError."""
    section = config.study
    assert isinstance(section, Explain)
    if not 1 <= len(over) <= 2:
        raise ArgumentError("over", f"got {len(over)} axes, expected one or two")
    shared = section.shared | {name: float(value) for name, value in at.items()}
    given = {*shared, *(axis.name for axis in over)}
    if differ := [name for name in conditions_of(config) if name not in given]:
        settings = " ".join(f"--at {name}=VALUE" for name in differ)
        raise ArgumentError("over", f"not all observations have one {listed(differ)}: add it here, or give {settings}")
    grid = grid_of_predictions(config.model_copy(update={"axes": tuple(over)}))
    chosen = np.linspace(0, explained.sizes["draw"] - 1, min(draws, explained.sizes["draw"])).astype(int)
    names = [str(name) for name in explained["quantity"].values]
    drawn = {name: explained[f"posterior_{name}"].values[chosen] for name in names}
    laws = explained["posterior_law"].values[chosen].astype(int)
    names_of_laws = section.laws or (config.friction.law,)
    each = [(names_of_laws[law], {name: values[i] for name, values in drawn.items()}) for i, law in enumerate(laws)]
    regimes, logs = _shown(grid, shared, each, tuple(measured), options_of(config), moved)
    rng = np.random.default_rng(int(section.seed))
    outcome = _Outcomes(regimes, logs, np.array([*measured.values()]), float(section.mislabelled), rng)
    information = np.array([outcome.information(i) for i in range(grid.size)])
    chances = np.stack([(regimes == code).mean(1) for code in range(len(DECIDED))], axis=1)
    best = _best(information.reshape(grid.shape))
    values = {"information": information, "chance": chances}
    coordinates = grid_coordinates(grid) | {
        "state": text_index("state", DECIDED, "regime"), "quantity": explained["quantity"].variable,
    }  # fmt: skip
    attributes = {name: value for name, value in explained.attrs.items() if not name.startswith("explained_")}
    ds = study_dataset("explain", VARIABLES, values, grid.dims, grid.shape, coordinates, attributes)
    numbers = np.array([drawn[name] for name in names])
    left = [outcome.spread_left(i, numbers) for i in best]
    own = {"proposed_information": information[best], "spread_left": np.reshape(left, (len(best), len(names)))}
    ds = ds.assign(study_dataset("explain", VARIABLES, {n: v[None] for n, v in own.items()}, (), (), {}, {}).data_vars)
    places = np.unravel_index(best, grid.shape)
    for axis, place in zip(over, places, strict=True):
        ds[f"proposed_{axis.name}"] = ("proposal", ds[axis.name].values[place], dict(ds[axis.name].attrs), NO_FILL)
    scatters = ", ".join(f"{name}={value:.2g}" for name, value in measured.items())
    return ds.assign_attrs(proposal_scatter=scatters)


def scatter_of(config: Config) -> dict[str, float]:
    """Results that were measured, with the standard deviation of one logarithm; else the period."""
    assert isinstance(config.study, Explain)
    spreads: dict[str, list[float]] = {}
    for name, measured in (row for observation in config.study.observed for row in observation.metrics.items()):
        spreads.setdefault(name, []).append(measured.log_std * np.sqrt(len(measured.repeats or [0])))
    spreads.pop(POINT, None)
    return {name: float(np.median(values)) for name, values in spreads.items()} or {"period": _SCATTER}


def checked_scatter(scatter: Mapping[str, float]) -> Mapping[str, float]:
    """Results that will be measured, as they are given. Raises ArgumentError for what is no result, or no scatter."""
    for name, value in scatter.items():
        if name not in METRICS or name == POINT:
            raise ArgumentError("scatter", f"got {name}, expected a result: {listed([*METRICS][:-1])}")
        if not 0 < value < 10:
            raise ArgumentError("scatter", f"got {value:g} for {name}, expected a relative standard deviation above 0")
    return scatter


def conditions_of(config: Config) -> list[str]:
    """The conditions that some observation of an explanation names."""
    assert isinstance(config.study, Explain)
    return list(dict.fromkeys(name for observation in config.study.observed for name in observation.conditions))


def axis_of(config: Config, name: str, ends: Any, points: int) -> Range:
    """The axis of a parameter; without ends that of the configuration, else beyond what was observed."""
    section, row = config.study, PARAMETERS.get(name)
    assert isinstance(section, Explain) and config.uncertain is not None
    if row is None or name in config.uncertain.names:
        expected = f"a parameter that an observation may differ in{or_meant(name, PARAMETERS)}"
        raise ArgumentError("over", f"got {name}, expected {expected}")
    if points < 2:
        raise ArgumentError("points", f"got {points}, expected 2 at least")
    given = next((axis for axis in config.axes if isinstance(axis, Range) and axis.name == name), None)
    seen = [made.conditions[name] for made in section.observed if name in made.conditions]
    try:
        if ends is not None:
            low, high = interval(row, list(ends))
        elif given is not None:
            low, high = given.start, given.stop
        elif seen and min(seen) > 0:
            low, high = min(seen) / _BEYOND, max(seen) * _BEYOND
        else:
            raise ArgumentError("over", f"got {name} without a range, which no observation names: {name}=LOW..HIGH")
    except PydanticCustomError as error:
        context = error.context or {}
        raise ArgumentError("over", f"{name}: got {list(ends)}, expected {context.get('expected')}") from None
    spacing = "log" if low > 0 and high >= 10 * low else "linear"
    return Range.model_construct(name=name, spacing=spacing, start=low, stop=high, num=points)


def _shown(
    grid: Cells, shared: Mapping[str, float], draws: Sequence[tuple[str, Mapping[str, float]]],
    metrics: tuple[str, ...], options: Options, moved: Callable[[int, int], None] | None,
) -> tuple[NDArray[np.intp], Floats]:  # fmt: skip
    """What draws, laws and quantities, show at places: regimes (places, draws) as places of `DECIDED`, -1 for no
    verdict; logarithms of results (places, draws, results), NaN where there is none. shared : conditions of all."""
    size, count, stop = grid.size, len(draws), stop_flag()
    regimes, logs = np.empty((size, count), np.intp), np.full((size, count, len(metrics)), np.nan)
    codes = np.full(len(REGIMES), -1)
    codes[[REGIMES.index(name) for name in DECIDED]] = range(len(DECIDED))
    for draw, (name_of_law, drawn) in enumerate(draws):
        law, fixed = law_of(name_of_law)
        how = replace(options, law=law, early_stop=True).for_contact({*grid.fixed, *drawn}).keeping(metrics)
        results = results_over(grid, {**shared, **drawn, **fixed}, how, stop)
        regimes[:, draw] = codes[results["regime"]]
        for i, name in enumerate(metrics):
            logs[:, draw, i] = np.log(np.where(results[name] > 0, results[name], np.nan))
        if moved:
            moved(draw + 1, count)
    return regimes, logs


class _Outcomes:
    """What might be seen at places, simulated from each draw once, and what it says of all draws."""

    def __init__(
        self, regimes: NDArray[np.intp], logs: Floats, scatter: Floats, mislabelled: float, rng: np.random.Generator
    ) -> None:
        count = regimes.shape[1]
        self._regimes, self._logs, self._scatter = regimes, logs, scatter
        self._right, self._wrong = log_shares(1, mislabelled)
        self._errors = scatter * rng.standard_normal((count, scatter.size))
        self._mistaken = rng.random(count) < mislabelled
        self._others = rng.integers(1, len(DECIDED), count)  # the label that is noted wrongly, after the true one
        self._any = rng.integers(0, len(DECIDED), count)  # the label of what has no verdict

    def _log_likelihood(self, place: int) -> Floats:
        """Of what draw j shows at a place (second index), given draw i (first)."""
        regime, logs = self._regimes[place], self._logs[place]
        label = np.where(regime < 0, self._any, (regime + self._mistaken * self._others) % len(DECIDED))
        known = np.where(regime[:, None] == label, self._right, self._wrong)
        log_likelihood = np.where((regime < 0)[:, None], -np.log(len(DECIDED)), known)
        for i in range(self._scatter.size):
            error = (logs[None, :, i] + self._errors[None, :, i] - logs[:, None, i]) / self._scatter[i]
            density = -0.5 * error**2 - np.log(self._scatter[i] * np.sqrt(2 * np.pi))
            log_likelihood += np.where(np.isfinite(error), density, 0.0)
        return np.asarray(log_likelihood)

    def information(self, place: int) -> float:
        """The expected information of an observation at a place (bits)."""
        log_likelihood = self._log_likelihood(place)
        most = log_likelihood.max(0)
        mean = np.log(np.mean(np.exp(log_likelihood - most), axis=0)) + most
        return max(float(np.mean(np.diag(log_likelihood) - mean) / np.log(2.0)), 0.0)

    def spread_left(self, place: int, numbers: Floats) -> Floats:
        """Expected standard deviations of numbers (quantities, draws) after an observation, over those before."""
        log_likelihood = self._log_likelihood(place)
        weights = np.exp(log_likelihood - log_likelihood.max(0))
        weights /= weights.sum(0)
        mean = numbers @ weights
        return np.asarray(np.sqrt(np.maximum((numbers**2 @ weights - mean**2).mean(1), 0.0)) / numbers.std(1))


def _best(information: Floats) -> NDArray[np.intp]:
    """Numbers of the best places, one after the other, that are not neighbours of one another."""
    left, shape = information.copy(), information.shape
    best: list[int] = []
    grids = np.meshgrid(*(np.linspace(0, 1, n) for n in shape), indexing="ij")
    while len(best) < BEST and np.isfinite(left).any() and left.max() > 0:
        place = np.unravel_index(int(np.argmax(left)), shape)
        best.append(int(np.ravel_multi_index(place, shape)))
        left[np.sqrt(sum((g - g[place]) ** 2 for g in grids)) < _APART] = -np.inf
    return np.array(best, np.intp)


def report(ds: xr.Dataset) -> Iterator[str | ReportTable]:
    """The proposals, the best first, with what each is to leave of the scatter of every quantity."""
    names = [name for name in ds.data_vars if ds[name].dims == _PROPOSAL]
    left = ds["spread_left"].to_dataset("quantity")
    left = left.rename({name: f"{name} left" for name in left.data_vars})
    yield table_over(ds[names].assign(left), "proposal", *names, *left)
    yield f"measured  regime, {ds.attrs['proposal_scatter']}"
