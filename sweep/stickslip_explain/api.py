"""The Python calls: from what was measured back to its causes, what to measure next, what friction should be."""

import os
from collections.abc import Mapping, Sequence
from typing import Any, Unpack

import xarray as xr

from stickslip.api.runs import run
from stickslip.api.studies import Ends, rtol_of
from stickslip.config.grid import in_si
from stickslip.config.reader import parse_config
from stickslip.config.studies import section_of_call
from stickslip.engine import SolverKeywords
from stickslip.errors import ArgumentError, ContradictionError
from stickslip.files.reading import open
from stickslip.progress import Watch, watched
from stickslip.runs.threads import CellsOrConfig, Subject
from stickslip.vocabulary.display_units import units_shown, written_units
from stickslip.vocabulary.quantities import PARAMETERS, listed
from stickslip_explain.goal import Goal
from stickslip_explain.proposals import DRAWS, POINTS, axis_of, checked_scatter, conditions_of, proposals, scatter_of

__all__ = ["explain", "goal", "next_measurement"]


def explain(
    observed: Sequence[Mapping[str, Any]] | str | os.PathLike[str],
    prior: Mapping[str, Any] | None = None,
    *,
    laws: str | Sequence[str] | None = None,
    predict: Mapping[str, Any] | None = None,
    output: str | os.PathLike[str] | None = None,
    progress: Watch = "auto",
    **settings: Any,
) -> xr.Dataset:
    """Find which oscillators, and which laws of friction, explain what was observed, and how sure that is.

    Parameters
    ----------
    observed : sequence of Mapping, or path
        Observations, each with the conditions it was made at (numbers in SI, or texts with units) and what was seen:
        ``regime`` (or a list), results of `evaluate` with their scatter (``period="54 +- 2 ms"``), or lists of repeats.
        Or a file of observations, which says all else itself.
    prior : Mapping
        By quantity what was known before: a number or text, else a distribution as in the section `uncertain` of a
        configuration, ``{"lognormal": {"median": "5 N/mm", "factor": 1.5}}``; and `correlation` or `fit` as there.
    laws : str or sequence of str, optional
        Laws of friction, alternatives of the same probability; "stribeck" unless given.
    predict : Mapping, optional
        Axes, as in a configuration, over which the probability of each regime is predicted.
    output, progress
        As for `run`.
    **settings
        mislabelled (0.01, the probability that a regime was noted wrongly), particles (500 draws a population),
        repetitions (4 populations a law), draws (64 of each population, of which regimes are predicted), seed (1);
        solver, execution and title as in a configuration.

    Returns
    -------
    Dataset
        posterior_NAME over `draw`, all of the same weight, with interval_NAME and prior_interval_NAME over `share`,
        and posterior_law; over `law` log_evidence with its error and law_probability; over `quantity` variance_ratio,
        correlation and r_hat; over `direction`, the one that is fixed best first, direction_ratio and direction_weight;
        log_predictive and contradicted over `observation`; with `predict` also probability, of several laws
        law_regime_probability and disagreement.

    Raises
    ------
    ConfigError
        For bad input, before anything is computed.
    ContradictionError
        If nothing explains the observations; it names the one that contradicts, and holds the result, `dataset`.
    """
    if not isinstance(observed, str | os.PathLike):
        known = dict(prior or {}) | ({} if laws is None else {"laws": laws})
        axes = {} if predict is None else {"predict": {"axes": predict}}
        ds = run({"observed": observed, "prior": known, **settings, **axes}, output, progress=progress)
    elif prior is None and laws is None and predict is None and not settings:
        ds = run(observed, output, progress=progress)
    else:
        raise TypeError("explain: a file of observations says prior, laws, predict and settings itself")
    if text := ds.attrs.get("explained_contradiction"):
        raise ContradictionError(f"nothing explains this: {text}", ds)
    return ds


def next_measurement(
    explained: xr.Dataset | str | os.PathLike[str],
    over: str | Sequence[str] | Mapping[str, tuple[float | str, float | str] | None],
    *,
    at: Mapping[str, float | str] | None = None,
    scatter: Mapping[str, float] | None = None,
    points: int = POINTS,
    draws: int = DRAWS,
    progress: Watch = "auto",
) -> xr.Dataset:
    """Find where one more observation would tell most of what is not known yet.

    Parameters
    ----------
    explained : Dataset or path
        What `explain` returned.
    over : str, sequence of str, or Mapping
        One or two parameters in which an observation may differ, with ranges in SI or texts with units; without them
        those of the prediction, else three times beyond what was observed.
    at : Mapping, optional
        Values, in SI or as texts with units, of what differs between observations and is not among the axes.
    scatter : Mapping, optional
        Results that will be measured, with their relative standard deviation; those observed before unless given.
    points, draws : int
        Of each axis; of the explanation, which are weighed against each other.
    progress
        As for `run`.

    Returns
    -------
    Dataset
        Over the axes information (bits) and the chance of each regime; over `proposal`, the best first, proposed_NAME,
        proposed_information, wrong_before and wrong_after (the share of the plane whose most likely regime is not the
        true one) and spread_left of each quantity.

    Raises
    ------
    ValueError
        For bad input, before anything is computed.
    """
    ds = explained if isinstance(explained, xr.Dataset) else open(explained)
    if "posterior_law" not in ds or "configuration" not in ds.attrs:
        raise ArgumentError("explained", "holds no draws, expected what `stickslip explain` wrote")
    config = parse_config(str(ds.attrs["configuration"]), "configuration of the explanation")
    names = {over: None} if isinstance(over, str) else dict.fromkeys(over) if not isinstance(over, Mapping) else over
    config = config.shown_in(units_shown(ds) | written_units(names))
    known = [name for name in conditions_of(config) if name not in names]
    if foreign := [name for name in at or {} if name not in known]:
        raise ArgumentError("at", f"got {foreign[0]}, expected what observations name: {listed(known) or 'nothing'}")
    conditions = {name: in_si(PARAMETERS[name], str(value), "at", name) for name, value in (at or {}).items()}
    axes = [axis_of(config, name, ends, points) for name, ends in names.items()]
    measured = scatter_of(config) if scatter is None else checked_scatter(scatter)
    with watched(progress, "draws") as moved:
        return proposals(ds, config, axes, conditions, measured, draws, moved)


def goal(
    cells_or_config: CellsOrConfig,
    quiet_over: Mapping[str, Ends | str],
    axes: tuple[str, str] | None = None,
    between: Mapping[str, Ends] | None = None,
    probability: float | None = None,
    *,
    samples: int = 9,
    points: int = 257,
    tolerance: float = 1e-5,
    scan: int = 65,
    progress: Watch = "auto",
    **solver: Unpack[SolverKeywords],
) -> xr.Dataset:
    """Find the region of a plane of two parameters in which cells are quiet over whole ranges, and the way there.

    Parameters
    ----------
    cells_or_config : Mapping, Dataset, DataFrame, Config or path
        A configuration, whose other axes (materials, say) are panels, and whose section `uncertain` says what scatters;
        or cells as `evaluate` takes them, each of which is a panel.
    quiet_over : Mapping of str to pair or str
        By parameter the range throughout which neither stick-slip nor another vibration lasts, in SI or texts with
        units, ``{"belt_speed": "5..60 mm/s"}``; of several, at all of their combinations.
    axes : pair of str, optional
        The two parameters of the plane, (y, x), what is measured of a curve among them; by default the last two axes
        of the configuration.
    between : Mapping of str to pair, optional
        Their ranges; by default those of the axes, or from half of the least to twice the largest of what panels have.
    probability : float, optional
        Of being quiet throughout, where quantities scatter; 0.95 unless given.
    samples : int
        Values of each range looked at first. A vibration between them is missed, but about the one that comes closest
        to re-sticking.
    points, tolerance, scan
        As for `contours`; at the points looked at first the probability is in the result.
    progress, **solver
        As for `border`.

    Returns
    -------
    Dataset
        Over the panels and the plane quiet_probability with its error; the borders as `contours` has them, border_NAME
        over `node`, with verdict_left, verdict_right and `panel` over `line`; over the panels verdict, quiet_share,
        here_NAME (what the panel has), and where the verdict changes next: alone_NAME by this parameter alone,
        together_NAME in both.

    Raises
    ------
    TypeError, ValueError, ConfigError
        For bad input, before anything is computed.
    """
    section = section_of_call(
        Goal, quiet_over=quiet_over, axes=axes, between=between, probability=probability, samples=samples,
        points=points, tolerance=tolerance, scan=scan, rtol=rtol_of(solver),
    )  # fmt: skip
    return Subject.of(cells_or_config, solver).computed(section, progress)
