"""Populations of draws reduced to what people read: laws, intervals, directions, predictions, contradictions."""

from collections.abc import Hashable, Iterator, Mapping, Sequence
from typing import Any, NamedTuple

import numpy as np
import xarray as xr
from numpy.typing import NDArray
from scipy import linalg, stats  # type: ignore[import-untyped]

from stickslip.config.studies import ReportTable
from stickslip.config.uncertain import Uncertain
from stickslip.dataset.build import (
    NO_FILL,
    attributes_of,
    grid_coordinates,
    parameter_variable,
    shown_in,
    study_dataset,
    text_index,
)
from stickslip.dataset.display import unit_of
from stickslip.engine import Results
from stickslip.studies.draws import ratio
from stickslip.vocabulary.cells import Cells
from stickslip.vocabulary.parameter import Variable, table
from stickslip.vocabulary.quantities import DECIDED, SEARCHABLE
from stickslip_explain.section import Explain

Floats = NDArray[np.float64]

SHARES = (0.05, 0.5, 0.95)  # of intervals
DRAWN, INTERVAL, PRIOR = "posterior_", "interval_", "prior_interval_"  # before the name of a quantity
_PRIOR_DRAWS = 20_000
_ALIKE = 0.1  # of the probability of the best law: from there on another one explains the data as well
_RARE, _BEYOND = 0.05, 1e-6  # probabilities: of so many wrong regimes; of a point so far out in the prior
_LAW, _OBSERVED, _QUANTITY, _STATE = ("law",), ("observation",), ("quantity",), ("state",)
_SPREAD = "standard error, from the scatter of independent populations"

VARIABLES = table(
    Variable("log_evidence", "1", "logarithm of the evidence of a law", dims=_LAW,
             comment="of the mean likelihood over the prior; densities of results are per e-fold; cells without a "
             "verdict are taken to be what was seen"),
    Variable("log_evidence_error", "1", f"logarithm of the evidence of a law: {_SPREAD}", dims=_LAW),
    Variable("law_probability", "1", "probability of a law, all having had the same before", dims=_LAW),
    Variable("law_probability_error", "1", f"probability of a law: {_SPREAD}", dims=_LAW),
    Variable("posterior_law", "1", "law of a draw", dims=("draw",)),
    Variable("variance_ratio", "1", "variance of a quantity after the observations over that before", dims=_QUANTITY,
             comment="of the normal deviate that stands for it"),
    Variable("r_hat", "1", "agreement of independent populations about a quantity: R-hat", dims=_QUANTITY,
             comment="1 where they agree; from 1.1 on take more particles"),
    Variable("direction_ratio", "1", "variance along a direction after the observations over that before",
             dims=("direction",)),
    Variable("direction_weight", "1", "exponent, or coefficient, of a quantity in a direction",
             dims=("direction", "quantity"),
             comment="exponents of what is always positive: stiffness 1 and mass -1 are the ratio of both"),
    Variable("log_predictive", "1", "log-probability of an observation given all others", dims=_OBSERVED,
             comment="leave-one-out; densities of results are per e-fold"),
    Variable("contradicted", "1", "share of the draws that contradict an observation", dims=_OBSERVED,
             comment="in its regime, or by 4 standard deviations in a result"),
    Variable("probability", "1", "probability of a regime given the observations", dims=_STATE,
             comment="of all draws: what is missing to 1 is not decided"),
    Variable("probability_error", "1", f"probability of a regime: {_SPREAD}", dims=_STATE),
    Variable("disagreement", "1", "largest difference of the probability of a regime between laws",
             comment="among laws whose probability is a tenth of the best at least"),
)  # fmt: skip
_OF_DRAWS = {
    DRAWN: Variable(DRAWN, "parameter", "drawn given the observations", dims=("draw",)),
    INTERVAL: Variable(INTERVAL, "parameter", "quantile given the observations", dims=("share",)),
    PRIOR: Variable(PRIOR, "parameter", "quantile before the observations", dims=("share",)),
}


class Context(NamedTuple):
    """What an explanation is about: prior, observations, laws, and the cells that regimes are predicted for."""

    prior: Uncertain
    request: Explain
    laws: Sequence[str]
    grid: Cells
    written_in: Mapping[str, str]


def dataset(context: Context, columns: Results, attributes: Mapping[str, Any]) -> xr.Dataset:
    """The result of all populations. columns : of the study, each (laws, repetitions, ...); NaN: not computed."""
    complete = ~np.isnan(columns["log_evidence"]).any(0)
    if not complete.any():
        empty = {"log_evidence": np.full((1, len(context.laws)), np.nan)}
        coordinates = {"law": text_index("law", context.laws, "law of friction")}
        return study_dataset("explain", VARIABLES, empty, (), (), coordinates, attributes)
    columns = {name: values[:, complete] for name, values in columns.items()}
    share = _shares(columns["log_evidence"])
    laws = ratio(share.T, share.sum(0)[:, None])
    law, draws = _drawn(share, columns)
    correlation = context.prior.correlation
    root = np.eye(len(context.prior.names)) if correlation is None else np.linalg.cholesky(correlation)
    deviates = draws["score"] @ root.T
    rng = np.random.default_rng(int(context.request.seed))
    posterior = context.prior.values(draws["score"])
    prior = context.prior.values(rng.standard_normal((_PRIOR_DRAWS, len(context.prior.names))))
    ratios, weights = directions(prior, posterior)
    values = _evidence(columns) | {
        "law_probability": laws.value, "law_probability_error": laws.error, "variance_ratio": deviates.var(0),
        "posterior_law": law, "r_hat": _r_hat(np.asarray(columns["score"] @ root.T, np.float64), laws.value),
        "direction_ratio": ratios, "direction_weight": weights,
        "log_predictive": _leave_one_out(draws["log_likelihood"]), "contradicted": draws["contradicts"].mean(0),
    }  # fmt: skip
    rows = dict(VARIABLES)
    for name in context.prior.names:
        row = SEARCHABLE[name]
        for before, what in _OF_DRAWS.items():
            about = f"{row.long_name}, {what.long_name}"
            rows[before + name] = Variable(before + name, row.units, about, dims=what.dims)
        values |= {
            DRAWN + name: posterior[name], INTERVAL + name: np.quantile(posterior[name], SHARES),
            PRIOR + name: np.quantile(prior[name], SHARES),
        }  # fmt: skip
    attributes = dict(attributes) | {
        "explained_undecided": float(np.mean(draws["unsure"] != 0.0)),
    } | _contradiction(context, draws)  # fmt: skip
    whole = {name: np.asarray(array)[None] for name, array in values.items()}
    ds = study_dataset("explain", rows, whole, (), (), _coordinates(context), attributes)
    meanings = attributes_of(VARIABLES["posterior_law"], tuple(context.laws))
    ds["posterior_law"] = xr.Variable("draw", law.astype(np.int8), meanings, NO_FILL)
    for name in context.prior.names:
        for before in _OF_DRAWS:
            shown_in(ds[before + name].variable, context.written_in.get(name))
    return ds.assign(_predictions(context, columns["predicted"], share, laws.value)) if context.grid.dims else ds


def _coordinates(context: Context) -> dict[str, xr.Variable]:
    about = {"units": "1", "long_name": "share of the draws below the quantile"}
    observed = context.request.observed
    predicted = {*context.grid.fixed, *context.grid.along} if context.grid.dims else set()
    conditions = dict.fromkeys(name for made in observed for name in made.conditions if name not in predicted)
    values = {name: [made.conditions.get(name, np.nan) for made in observed] for name in conditions}
    return {
        name: shown_in(parameter_variable(name, _OBSERVED, made_at), context.written_in.get(name))
        for name, made_at in values.items()
    } | {
        "law": text_index("law", context.laws, "law of friction"),
        "quantity": text_index("quantity", context.prior.names, "uncertain quantity"),
        "observation": text_index("observation", [observation.words for observation in observed], "observation"),
        "share": xr.Variable("share", np.array(SHARES), about, NO_FILL),
    }  # fmt: skip


def _shares(log_evidence: Floats) -> Floats:
    """Evidence of populations (laws, repetitions) over the largest; all 0 where there is none."""
    best = log_evidence.max()
    return np.exp(log_evidence - best) if np.isfinite(best) else np.ones(log_evidence.shape)


def _evidence(columns: Results) -> Results:
    """The evidence of each law; of several populations the mean."""
    with np.errstate(divide="ignore", invalid="ignore"):
        each = columns["log_evidence"]
        best = np.maximum(each.max(1, keepdims=True), -1e300)
        scaled, count = np.exp(each - best), each.shape[1]
        mean = scaled.mean(1)
        error = scaled.std(1, ddof=1) / mean / np.sqrt(count) if count > 1 else np.full(len(each), np.nan)
        return {"log_evidence": np.log(mean) + best[:, 0], "log_evidence_error": error}


def _drawn(share: Floats, columns: Results) -> tuple[NDArray[np.intp], Results]:
    """Draws of the same weight from all populations, in proportion to their evidence: their laws, and columns."""
    laws, repetitions, size = columns["unsure"].shape
    weights = np.cumsum(np.repeat(share.ravel() / share.sum(), size))
    places = (np.arange(repetitions * size) + 0.5) / (repetitions * size) * weights[-1]
    chosen = np.minimum(np.searchsorted(weights, places), weights.size - 1)
    names = ("score", "log_likelihood", "unsure", "contradicts")
    flat = {name: columns[name].reshape(laws * repetitions * size, *columns[name].shape[3:])[chosen] for name in names}
    return chosen // (repetitions * size), flat


def _r_hat(deviates: Floats, probability: Floats) -> Floats:
    """R-hat of quantities over the populations (laws, repetitions, n, quantities), the largest of likely laws."""
    between = deviates.mean(2).var(1, ddof=1) if deviates.shape[1] > 1 else np.full(deviates.shape[::3], np.nan)
    each = np.sqrt(1.0 + between / deviates.var(2).mean(1))
    return np.asarray(each[probability >= _ALIKE * probability.max()].max(0))


def _leave_one_out(log_likelihood: Floats) -> Floats:
    """Log-probability of each observation given the others: the harmonic mean of its likelihood over the draws."""
    least = log_likelihood.min(0)
    return np.asarray(least - np.log(np.mean(np.exp(least - log_likelihood), axis=0)))


def _contradiction(context: Context, draws: Results) -> dict[str, Any]:
    """The attributes that name the observation that contradicts all else; none where something explains them all."""
    observed, contradicts = context.request.observed, draws["contradicts"]
    if not np.isfinite(draws["log_likelihood"]).all():
        text = "no draw of the prior is a possible oscillator"
        return {"explained_contradicting": 0, "explained_contradiction": text}
    wrong = int(np.quantile(contradicts.sum(1), _RARE))
    regimes = sum(observation.regime is not None for observation in observed)
    farthest = stats.chi2.isf(_BEYOND, len(context.prior.names))
    out_of_reach = float(np.quantile(np.sum(draws["score"] ** 2, 1), _RARE)) > farthest
    if not out_of_reach and (not wrong or stats.binom.sf(wrong - 1, regimes, context.request.mislabelled) >= _RARE):
        return {}
    best = draws["log_likelihood"].max(0) if not wrong else np.zeros(len(observed))
    surprise = best - _leave_one_out(draws["log_likelihood"])
    guilty = np.where(contradicts.mean(0) >= _RARE, surprise, -np.inf) if wrong else surprise
    number = int(np.argmax(guilty))
    against = "the others" if len(observed) > 1 and wrong else "the prior"
    text = f"observation {number + 1} ({observed[number].words}) contradicts {against}"
    return {"explained_contradicting": number, "explained_contradiction": text}


def _predictions(context: Context, predicted: Floats, share: Floats, probability: Floats) -> dict[str, xr.DataArray]:
    """Regimes over the axes: their probabilities, those of each law, and where likely laws differ."""
    grid = context.grid
    whole = ratio(np.einsum("lr,lrcs->rcs", share, predicted), share.sum(0)[:, None, None])
    by_law = np.einsum("lr,lrcs->cls", share, predicted) / share.sum(1)[:, None]
    likely = by_law[:, probability >= _ALIKE * probability.max()]
    values = {"probability": whole.value, "probability_error": whole.error}
    if len(context.laws) > 1:
        values["disagreement"] = (likely.max(1) - likely.min(1)).max(1)
    coordinates = grid_coordinates(grid) | {"state": text_index("state", DECIDED, "regime")}
    ds = study_dataset("explain", VARIABLES, values, grid.dims, grid.shape, coordinates, {})
    return dict(ds.data_vars)  # type: ignore[arg-type]


# --- for the screen ---------------------------------------------------------------------------------------------------


def report(ds: xr.Dataset) -> Iterator[str | ReportTable]:
    """What explains the observations: laws, quantities before and after, what is fixed, and what is not explained."""
    if "posterior_law" not in ds:
        yield "no population is computed yet"
        return
    if text := ds.attrs.get("explained_contradiction"):
        yield f"nothing explains this: {text}"
    yield table_over(ds, "law", "log_evidence", "log_evidence_error", "law_probability")
    headings = ("before: 5 %", "95 %", "after: 5 %", "50 %", "95 %", "variance left", "R-hat")
    yield ReportTable("", ("quantity",), headings, [_row(ds, str(name)) for name in ds["quantity"].values])
    weights = ds["direction_weight"].to_dataset("quantity")
    yield table_over(weights.assign(direction_ratio=ds["direction_ratio"]), "direction", "direction_ratio", *weights)
    yield table_over(ds, "observation", "log_predictive", "contradicted")
    yield f"undecided {ds.attrs['explained_undecided']:.1%} of the draws have cells without a verdict"


def table_over(ds: xr.Dataset, dim: str, *names: Hashable) -> ReportTable:
    """Variables over a dimension, by their names, in the units in which they are shown."""
    labels = ds[dim].values if dim in ds.coords else range(1, ds.sizes[dim] + 1)
    columns = [[unit_of(ds[name]).text(float(value), 3) for value in ds[name].values] for name in names]
    headings = [str(name).replace("_", " ") for name in names]
    return ReportTable("", (dim,), headings, list(zip(map(str, labels), *columns, strict=True)))


def _row(ds: xr.Dataset, name: str) -> list[str]:
    unit, of_quantity = unit_of(ds[DRAWN + name]), ds.sel(quantity=name)
    values = (*ds[PRIOR + name].values[[0, 2]], *ds[INTERVAL + name].values)
    texts = [unit.text(float(value), 4) for value in values]
    return [name, *texts, f"{float(of_quantity['variance_ratio']):.2f}", f"{float(of_quantity['r_hat']):.2f}"]


# --- directions -------------------------------------------------------------------------------------------------------


def directions(prior: Mapping[str, Floats], posterior: Mapping[str, Floats]) -> tuple[Floats, Floats]:
    """Combinations of quantities that observations fix, from draws of prior and posterior, the best first.

    Of two covariance matrices, prior P and posterior Q of the same numbers, the directions v with Q v = r P v are those
    along which the data have narrowed what was known by sqrt(r), independent of each other under both; r is the same
    whatever units the numbers have. Products of powers (stiffness/mass) show in logarithms, which are taken of all
    quantities that are positive. Returns r (n,), and weights (n, quantities): exponents or coefficients, the largest
    part of each direction being 1.
    """
    positive = {name for name in prior if (prior[name] > 0).all() and (posterior[name] > 0).all()}
    before, after = (
        np.array([np.log(values) if name in positive else values for name, values in draws.items()])
        for draws in (prior, posterior)
    )
    scale = before.std(1)
    p, q = (np.atleast_2d(np.cov(draws / scale[:, None])) for draws in (before, after))
    ratio, vectors = linalg.eigh(q, p)
    rows, largest = np.arange(len(scale)), np.abs(vectors.T).argmax(1)
    parts = vectors.T / vectors.T[rows, largest][:, None]
    weights = parts / scale
    return np.maximum(ratio, 0.0), weights / weights[rows, largest][:, None]
