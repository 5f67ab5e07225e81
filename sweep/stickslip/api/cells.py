"""The calls for cells and trajectories: evaluate, simulate."""

import json
import warnings
from collections.abc import Mapping, Sequence
from dataclasses import replace
from math import ceil, floor, inf, isfinite, log10, pi
from typing import NamedTuple

import numpy as np
import xarray as xr
from numpy.typing import ArrayLike

from stickslip.dataset.build import evaluated_dataset, given_cells, grid_coordinates, provenance, trace_dataset
from stickslip.engine import Options, compute, trajectory
from stickslip.errors import ExtrapolationWarning, Interrupted, QuantityError
from stickslip.theory.contacts import time_to_cycle
from stickslip.vocabulary.cells import Parameters, as_cells, named_values, scales_of
from stickslip.vocabulary.own_laws import beyond_points
from stickslip.vocabulary.quantities import PARAMETERS, REGIMES, SOLVER


def evaluate(
    cells: Mapping[str, ArrayLike | str | Sequence[str] | xr.DataArray] | xr.Dataset,
    rtol: float = 1e-6,
    horizon: float | None = None,
    early_stop: bool = True,
    threads: int | None = None,
    law: str = "stribeck",
    max_steps: int = Options.max_steps,
    *,
    options: Options | None = None,
    variables: Sequence[str] | None = None,
) -> xr.Dataset:
    """Compute regime and metrics of any list of cells.

    Parameters
    ----------
    cells : Mapping, Dataset or DataFrame
        Numbers or arrays in SI, or texts with units ("5 N/mm"), that broadcast against each other: mass, stiffness,
        damping (0), normal_load, belt_speed, a1, a2, a3, a4, mu_stop (NaN: no hysteresis), mu_static (NaN: a1 + a3),
        displacement (0), velocity (NaN: sticking), and for the law stribeck_delta `delta`; in brackets the defaults.
        Static friction grows with the time in contact: mu_static + ageing_rate (0) log10(1 + t/ageing_time (1 s)),
        counted from contact_time (0) before the start. DataArrays are broadcast by their dimensions, and converted from
        the units in their attributes. Of a Dataset, variables and coordinates that carry names of parameters are taken.
        A DataFrame is read by its columns, each a parameter; its index is the dimension. Quantities of Pint are
        converted. What is masked (NumPy) or missing (NA of pandas) is refused.
    rtol : float
        Relative tolerance of the integration.
    horizon : float, optional
        s; by default there is no limit.
    early_stop : bool
        False integrates every cell to the horizon and adds sticks, stick_time, displacement_end, velocity_end.
    threads : int, optional
        By default one per processor.
    law : str
        Shape of the weakening of friction: one of `vocabulary.models.LAWS`, one of your own (`register_law`), or a
        measured `Table`, which brings a1 to a4.
    max_steps : int
        Step budget of a cell.
    options : Options, optional
        In place of all of these.
    variables : sequence of str, optional
        The only ones to compute, `regime` in any case. What is not asked for is not computed: the regime alone (with
        `status`, `restick_margin`, `damping_ratio`, `steps`) of a cell that settles costs no more than that of one that
        sticks.

    Returns
    -------
    Dataset
        Over `cell`; over the dimensions of the DataArrays, or of the Dataset, with their coordinates, where cells have
        such.

    Raises
    ------
    TypeError, ValueError
        For bad input, before anything is computed.
    """
    if options is None:
        end = inf if horizon is None else float(horizon)
        options = Options(law, float(rtol), end, int(max_steps), bool(early_stop), threads)
    options = options.for_contact(cells)
    if variables is not None:
        options = options.keeping(variables)
    full = given_cells(cells, options)
    computed = compute(full, options)
    if (slip_speed := computed.results.get("slip_speed_max")) is not None:
        _warn_beyond_points(options, slip_speed, full.listed)
    attributes = provenance(options.described(), title="Cells evaluated one by one", action="evaluate")
    dataset = evaluated_dataset(full.dims, full.shape, grid_coordinates(full), computed.results, attributes)
    if not computed.complete:
        raise Interrupted(computed.done, full.size, dataset=dataset)
    return dataset


def _warn_beyond_points(options: Options, slip_speed: ArrayLike, cells: Parameters) -> None:
    if text := beyond_points(options.law, slip_speed, cells.get("a4", np.inf)):
        warnings.warn(text, ExtrapolationWarning, stacklevel=3)


def simulate(
    cells: Mapping[str, float | str] | xr.Dataset | None = None,
    *,
    duration: float | str,
    samples: int = 2001,
    rtol: float = 1e-6,
    law: str = "stribeck",
    max_steps: int = Options.max_steps,
    options: Options | None = None,
    **cell: float | str,
) -> xr.Dataset:
    """Compute one trajectory over time, by the stepping that computes maps.

    Parameters
    ----------
    cells : Mapping or Dataset, optional
        The parameters of `evaluate`, one value each.
    duration : float or str
        s, or a text with a unit.
    samples : int
        How many, evenly spaced from 0 to `duration`.
    rtol, law, max_steps, options
        As for `evaluate`.
    **cell : float or str
        Parameters by name, in place of `cells` or of some of them.

    Returns
    -------
    Dataset
        Over `time`: displacement, velocity, relative_speed, friction_coefficient (signed, positive along the belt),
        spring_force, acceleration, mode.

    Raises
    ------
    TypeError, ValueError
        For bad input.
    NotReachedError
        Where the integration does not reach the end.
    """
    try:
        seconds = SOLVER["horizon"].read(duration) if isinstance(duration, str) else float(duration)
    except QuantityError as error:
        raise ValueError(f"duration: got {duration!r}, {error}") from None
    if not (np.isfinite(seconds) and seconds > 0):
        raise ValueError(f"duration: got {duration!r}, expected a time > 0 (s)")
    if samples < 2:
        raise ValueError(f"samples: got {samples!r}, expected at least 2")
    options = replace(options or Options(law, float(rtol), max_steps=int(max_steps)), horizon=seconds)
    given = {**({} if cells is None else named_values(cells)), **cell}
    options = options.for_contact(given)
    full = as_cells(given, options.law)
    if full["mass"].size != 1:
        raise ValueError("simulate computes one trajectory: give every parameter one number")
    times = np.linspace(0.0, seconds, samples)
    motion = trajectory(full, times, options)
    _warn_beyond_points(options, np.abs(motion["relative_speed"]).max(keepdims=True), full)
    solver = {"rtol": options.rtol, "duration": seconds, "samples": int(samples)}
    text = json.dumps({"friction": options.friction, "solver": solver})
    attributes = provenance(text, title="Trajectory", action="simulate")
    return trace_dataset(times, motion, {name: float(value[0]) for name, value in full.items()}, attributes)


# --- how long to look -------------------------------------------------------------------------------------------------

CYCLES = 8.0  # shown after the first break-away
_SETTLED = 1.1  # settling times shown
_SLOW = 30.0  # natural periods, for what neither sticks nor settles
_PER_PERIOD = 60  # samples a natural period
_MOST_SAMPLES = 40_001
_LONGEST = 1e3  # natural periods, of what does not stick


class TimeSpan(NamedTuple):
    """Duration of a trajectory (s), its number of samples, and the reason in words."""

    duration: float
    samples: int
    why: str


def time_span(result: xr.Dataset, duration: float | None = None) -> TimeSpan:
    """The time that shows what becomes of a cell, or the one that is given.

    result : what `evaluate` says of it: eight cycles after the first break-away; a decay until it has settled.
    """
    names = ("breakaway_time", "period", "settling_time", "stiffness", "spring_force_max")
    values = {name: float(result[name].values[0]) for name in names}
    by = scales_of({name: float(result[name].values[0]) for name in PARAMETERS if name in result})
    natural, why = 2.0 * pi * float(by.time), ""
    if duration is None:
        regime = REGIMES[int(result["regime"].values[0])]
        began = values["breakaway_time"] if isfinite(values["breakaway_time"]) else 0.0
        if "growth_rate" in result and isfinite(values["period"]):  # a contact without break-away
            speed, growth = (float(result[name].values[0]) for name in ("belt_speed", "growth_rate"))
            far = values["spring_force_max"] / values["stiffness"]
            began = min(time_to_cycle(far, speed, growth), _LONGEST * natural)
        after, why = _SLOW * natural, f"{_SLOW:g} natural periods"
        if regime == "stick_slip" and isfinite(values["period"]):
            after, why = CYCLES * values["period"], f"{CYCLES:g} cycles"
        elif regime == "sustained":
            after = max(_SLOW * natural, CYCLES * values["period"])
        elif regime in ("damped", "creep") and isfinite(values["settling_time"]):
            after, why = max(_SETTLED * values["settling_time"], natural), "until it has settled"
        if regime != "stick_slip" and after > _LONGEST * natural:
            after, why = _LONGEST * natural, f"{_LONGEST:g} natural periods, no more"
        duration = _rounded_up(began + after)
    return TimeSpan(duration, min(max(2001, ceil(_PER_PERIOD * duration / natural) + 1), _MOST_SAMPLES), why)


def _rounded_up(seconds: float) -> float:
    """A duration with two digits, no shorter."""
    scale = 10.0 ** (floor(log10(seconds)) - 1)
    return float(f"{ceil(seconds / scale * (1.0 - 1e-12)) * scale:.12g}")
