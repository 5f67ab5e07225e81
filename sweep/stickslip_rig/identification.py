"""Parameters of a simulated rig from a measured record: least squares on the features.

Features rather than samples, because two records of the same rig soon differ in phase by many periods. Counts
(sticks, drops) are discontinuous and stop a search that follows gradients; the rates and means of `SMOOTH` do not.
"""

import itertools
from collections.abc import Callable, Collection, Hashable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import xarray as xr
from scipy.optimize import least_squares  # type: ignore[import-untyped]

from stickslip.vocabulary import units
from stickslip_materials.fit.uncertainty import Floats, Interval, covariance, student
from stickslip_rig.evaluation import features
from stickslip_rig.quantities import FORCES
from stickslip_rig.sections import FeatureSettings
from stickslip_rig.vocabulary import CONDITIONS

Parameters = Mapping[str, float]
Simulator = Callable[[Parameters], xr.Dataset]  # parameters by name, in SI, to a record

SMOOTH = ("static_force", "dynamic_force", "drop_mean", "stick_fraction", "acceleration_max", "time_to_sliding")
_DEFAULT_SIGMA = 0.02  # of a measured feature: how far measured and simulated may differ, unless given
_STEP = 0.02  # of a parameter: how far it is moved to either side for a slope; less is lost in the sampling of records
_MOST = 60  # steps of the search
_ALIKE = 0.01  # relative: conditions of the measured and the simulated test that differ by less are the same
_BOUND = 1e3  # times the start and its inverse, where no bounds are given


@dataclass(frozen=True)
class Identification:
    """Parameters found, and their uncertainty.

    estimates, standard_error, interval (95 %) : by parameter; infinite where the features do not determine it.
    measured, simulated, sigma : by feature. chi_squared : sum of the squared residuals over sigma.
    """

    estimates: Mapping[str, float]
    standard_error: Mapping[str, float]
    interval: Mapping[str, Interval]
    covariance: Floats
    measured: Mapping[str, float]
    simulated: Mapping[str, float]
    sigma: Mapping[str, float]
    chi_squared: float
    evaluations: int
    converged: bool


def identify(
    simulate: Simulator,
    record: xr.Dataset,
    start: Parameters,
    *,
    bounds: Mapping[str, Interval] | None = None,
    names: Sequence[str] = SMOOTH,
    sigma: Mapping[str, float] | None = None,
    settings: FeatureSettings | None = None,
    progress: Callable[[int, int], None] | None = None,
) -> Identification:
    """Identify the parameters with which `simulate` gives a record with the features of the measured one.

    The search goes over logarithms of the parameters. Simulated records are evaluated with what the measured one has:
    without stick flags, for instance, if it has none.

    Parameters
    ----------
    simulate
        Gives the record for parameters by name: `simulator`.
    record
        The measured one.
    start
        First guesses, > 0, in SI.
    bounds
        (lowest, highest), > 0, of some parameters; else a thousandth and a thousand times the start.
    names
        The features to compare; those that the measured record does not define are left out.
    sigma
        Standard deviations of measured features, from repetitions; 2 % of the feature where none is given, and then
        the errors are scaled by the residuals of the fit.
    settings
        Of the features.
    progress
        Called with (records simulated, how many there may be at most).

    Raises
    ------
    ValueError
        Fewer features than parameters, or one of them that the simulated record lacks at the start.
    """
    target = _vector(features(record, settings), names)
    used = [name for name in names if np.isfinite(target[name])]
    keys = list(start)
    if len(used) < len(keys):
        raise ValueError(f"{len(used)} features ({', '.join(used)}) cannot determine {len(keys)} parameters")
    spread = {name: (sigma or {}).get(name, _DEFAULT_SIGMA * abs(target[name])) or 1.0 for name in used}
    low, high = _limits(start, bounds or {})
    count, most = itertools.count(1), 2 + _MOST * (1 + 2 * len(keys))
    largest = np.ones(len(used))  # of residuals: what a feature that a trial record lacks is counted as

    def simulated(p: Floats) -> dict[str, float]:
        trial = simulate(dict(zip(keys, np.exp(p).tolist(), strict=True)))
        if progress:
            progress(next(count), most)
        return _vector(features(as_measured(trial, record.variables), settings), used)

    def residuals(p: Floats) -> Floats:
        trial = simulated(p)
        r = np.array([(trial[name] - target[name]) / spread[name] for name in used])
        known = np.isfinite(r)
        largest[known] = np.maximum(largest[known], np.abs(r[known]))
        return np.where(known, r, 10.0 * largest)

    begin = np.log([start[key] for key in keys])
    if lost := [name for name, value in simulated(begin).items() if not np.isfinite(value)]:
        raise ValueError(f"at the start the simulated record does not define {', '.join(lost)}: start elsewhere")

    def slopes(p: Floats) -> Floats:
        sides = [(np.minimum(p + step, high), np.maximum(p - step, low)) for step in _STEP * np.eye(p.size)]
        return np.stack([(residuals(a) - residuals(b)) / (a - b).sum() for a, b in sides], axis=1)

    run = least_squares(residuals, begin, slopes, (low, high), xtol=1e-6, ftol=1e-8, gtol=1e-8, max_nfev=_MOST)
    freedom = len(used) - len(keys)
    scale = 1.0 if sigma is not None else (2.0 * run.cost / freedom if freedom > 0 else np.inf)
    by_log = covariance(run.jac) * scale
    values = np.exp(run.x)
    reach = student(np.inf if sigma is not None else freedom)
    error = np.sqrt(np.diag(by_log))
    ends = [np.exp(np.clip(run.x + side * reach * error, -700, 700)) for side in (-1.0, 1.0)]
    return Identification(
        estimates=dict(zip(keys, values.tolist(), strict=True)),
        standard_error=dict(zip(keys, (error * values).tolist(), strict=True)),
        interval={key: (float(a), float(b)) for key, a, b in zip(keys, *ends, strict=True)},
        covariance=by_log * np.outer(values, values),
        measured={name: target[name] for name in used},
        simulated=simulated(run.x),
        sigma=spread,
        chi_squared=2.0 * float(run.cost),
        evaluations=int(run.nfev),
        converged=bool(run.status > 0),
    )


def as_measured(trial: xr.Dataset, known: Collection[Hashable]) -> xr.Dataset:
    """The part of a simulated record that the measured one, of these names, has as well: features depend on it."""
    needed = () if any(name in trial and name in known for name in FORCES) else FORCES
    return trial.drop_vars([name for name in trial.variables if name not in (*known, "time", *needed)])


def other_test(record: xr.Dataset, simulated: Mapping[Any, Any], free: Collection[str]) -> str | None:
    """By which condition the simulated test is another than that of the record, in words; but for those that are free
    in it. None if they are the same."""
    for name, row in CONDITIONS.items():
        is_free = name in free or name == "drive_speed" and "belt_speed" in free
        if is_free or name not in record.coords or name not in simulated:
            continue
        measured, given = float(record[name]), float(simulated[name])
        if abs(measured - given) > _ALIKE * abs(given):
            unit = units.spelled(row.units)
            return f"{name} is {measured:g} {unit}, and {given:g} {unit}"
    return None


def _vector(row: xr.Dataset, names: Sequence[str]) -> dict[str, float]:
    return {name: float(row[name]) for name in names}


def _limits(start: Parameters, bounds: Mapping[str, Interval]) -> tuple[Floats, Floats]:
    """Logarithms of the lowest and highest values. Raises ValueError."""
    ends = [bounds.get(key, (value / _BOUND, value * _BOUND)) for key, value in start.items()]
    for (key, value), (low, high) in zip(start.items(), ends, strict=True):
        if not 0 < low < value < high:
            raise ValueError(
                f"{key}: got the start {value:g}, expected it between the bounds {low:g} and {high:g} (> 0)"
            )
    return np.log([low for low, _ in ends]), np.log([high for _, high in ends])
