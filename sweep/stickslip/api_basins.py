"""The calls of Python users about attractors: attractors, ramp. `stickslip` offers them beside those of `api.py`."""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import replace
from math import isinf
from typing import Any, cast

import numpy as np
import xarray as xr
from numpy.typing import ArrayLike

from . import basins, borders
from .config.checks import Ends, in_si
from .config.model import Config
from .config.options import options_of
from .config.reader import Given, as_config, is_config
from .config.studies import Attractors, alone
from .dataset.attractors import ramp_dataset
from .dataset.given import given_cells
from .dataset.provenance import provenance
from .engine import Options, stop_flag, warm_up
from .errors import ArgumentError
from .progress import Watch, watched
from .runs.memory import compute_study
from .vocabulary.quantities import PARAMETERS
from .vocabulary.settings import AXIS

__all__ = ["attractors", "ramp"]

Cells = Mapping[str, ArrayLike] | xr.Dataset
CellsOrConfig = Cells | Given


def attractors(
    cells_or_config: CellsOrConfig,
    box: Mapping[str, Ends] | None = None,
    *,
    samples: int = basins.Sampling.samples,
    seed: int = basins.Sampling.seed,
    rtol: float | None = None,
    horizon: float | None = None,
    threads: int | None = None,
    law: str | None = None,
    max_steps: int | None = None,
    progress: Watch = "auto",
) -> xr.Dataset:
    """Which regimes cells have, by starting state, and the share of a box of starting states that settles.

    cells_or_config : cells as `evaluate` takes them, whose dimensions the result has; or a configuration, as `run`
        takes it, whose axes are the dimensions. What they say of the state at the start is left out.
    box : {"displacement": (low, high), "velocity": (low, high)}, in SI or texts with units; None takes that of the
        section `attractors` of the configuration, with its samples and seed.
    samples : starting states drawn where the share is not exact, 16 times a power of 2. seed : of them.
    rtol, horizon, threads, law, max_steps : of `evaluate`; None takes the defaults, or what the configuration says. A
        configuration says its law itself. progress : as for `run`.

    A configuration with a section `attractors` asks for the same of `run`, which resumes and uses clusters.

    Returns a dataset: coexisting (a bit per regime), regime_from_stick, regime_from_sliding, settling_share with
    share_error, its bounds and share_method; of the unstable cycle (NaN where there is none, or it is not exact)
    unstable_amplitude, unstable_velocity_amplitude, unstable_period; critical_shock and critical_shift, the smallest
    changes of velocity and displacement at steady sliding after which it does not come back, and both in either
    direction. Raises TypeError or ValueError for bad input before anything is computed, ConfigError for a bad
    configuration.
    """
    config, options = _options(cells_or_config, law, rtol, horizon, threads, max_steps)
    sampling = basins.Sampling(samples, seed)
    if box is None:
        if config is None or config.attractors is None:
            raise ArgumentError("box", "missing, expected {'displacement': (low, high), 'velocity': (low, high)}")
        states = basins.Box(config.attractors.displacement, config.attractors.velocity)
        sampling = basins.Sampling(config.attractors.samples, config.attractors.seed)
    else:
        states = basins.Box.of(box)
    asked = Attractors.model_construct(
        displacement=states.displacement, velocity=states.velocity, samples=sampling.samples, seed=sampling.seed
    )
    if config is not None:
        cells = basins.asked_of_config(config)
        title = f"Attractors: {config.title}"
        text = config.model_copy(update=alone("attractors", asked)).to_yaml()
    else:
        cells, title = basins.asked_of_cells(given_cells(cast(Cells, cells_or_config), options.law)), "Attractors"
        text = _text(options, {"attractors": asked.resolved()})
    study = basins.AttractorStudy(cells, states, sampling, options)
    with watched(progress, study.counted, options.law) as moved:
        return study.dataset(compute_study(study, moved), provenance(text, title=title, action="attractors"))


def ramp(
    cells_or_config: CellsOrConfig,
    along: str,
    between: Ends | None = None,
    points: int = 200,
    *,
    rtol: float | None = None,
    horizon: float | None = None,
    law: str | None = None,
    max_steps: int | None = None,
    progress: Watch = "auto",
) -> xr.Dataset:
    """Attractors while a parameter goes slowly up and down again: where vibration stops, and where it starts.

    Every value starts from where the motion at the one before ended; the first, from sticking with an unloaded contact.
    The ramp waits at each until the motion has come to its attractor, and steady sliding keeps a disturbance of 1e-4 of
    the belt speed.

    cells_or_config, along, between : as for `border`; every line is a ramp. points : values, evenly spaced.
    rtol, horizon, law, max_steps : of `evaluate`; None takes the defaults, or what the configuration says.
    progress : as for `run`; what is counted are values of the parameter, those of either way and those between them.

    Returns a dataset over the lines, `direction` ("up", "down") and the parameter: regime, status, velocity_amplitude,
    displacement_amplitude, period, stick_fraction; and of what lies between both branches, over the lines and the
    parameter: unstable_amplitude, unstable_velocity_amplitude and unstable_period of the unstable cycle (as
    `attractors` finds it, NaN where it is not known exactly) and damping_ratio. `plots.plot_branches` draws it.
    Raises as `border` does.
    """
    if isinstance(points, bool) or not AXIS["num"].allows(points) or points != int(points):
        raise ArgumentError("points", f"got {points!r}, expected {AXIS['num'].expected}")
    config, options = _options(cells_or_config, law, rtol, horizon, None, max_steps)
    ends = None if between is None else in_si(along, between)
    if config is not None:
        lines, text = borders.lines_of_config(config, along, ends), config.to_yaml()
    else:
        lines, text = borders.lines_of_cells(cast(Cells, cells_or_config), along, ends, options.law), _text(options, {})
    values = np.linspace(*lines.between, int(points))
    title = f"Slow ramp: {PARAMETERS[along].long_name}" + (f": {config.title}" if config else "")
    asked = basins.Ramp(lines, values)
    stop, done, total = stop_flag(), 0, 3 * lines.size * values.size
    with watched(progress, "values", options.law) as moved:
        warm_up(options.law)

        def count(some: int) -> None:
            nonlocal done
            done += some
            if moved:
                moved(done, total)

        count(0)
        followed, between_them = (
            {name: result.reshape(*lines.shape, *result.shape[1:]) for name, result in found.items()}
            for found in (
                basins.follow_ramp(asked, options, stop, count), basins.between_branches(asked, options, stop, count)
            )
        )  # fmt: skip
    attributes = provenance(text, title=title, action=f"ramp of {along}")
    return ramp_dataset(
        along, values, lines.dims, lines.coordinates, followed, between_them, attributes, lines.written_in
    )


def _options(
    cells_or_config: CellsOrConfig, law: str | None, rtol: float | None, horizon: float | None, threads: int | None,
    max_steps: int | None,
) -> tuple[Config | None, Options]:  # fmt: skip
    """The configuration, if there is one, and how to integrate."""
    given: dict[str, Any] = {"rtol": rtol, "horizon": horizon, "threads": threads, "max_steps": max_steps}
    given = {name: value for name, value in given.items() if value is not None}
    if not is_config(cells_or_config):
        return None, Options(law=law or Options.law, **given)
    config = as_config(cast(Given, cells_or_config))
    if law is not None:
        raise ValueError(f"law: got {law!r}, but a configuration says its law itself: {config.friction.law}")
    return config, replace(options_of(config), early_stop=True, **given)


def _text(options: Options, more: Mapping[str, Any]) -> str:
    """What the result of a list of cells keeps as its configuration."""
    solver = {"rtol": options.rtol, "horizon": None if isinf(options.horizon) else options.horizon}
    return json.dumps(
        {"friction": {"law": options.law}, "solver": solver | {"max_steps": options.max_steps}} | dict(more)
    )
