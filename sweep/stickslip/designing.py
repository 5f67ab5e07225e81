"""The calls of a designer: borders as lines in a plane, and how far cells are from a border."""

from __future__ import annotations

import json
import os
from collections.abc import Mapping, Sequence
from dataclasses import replace
from math import isinf, prod
from numbers import Integral
from typing import Any

import xarray as xr
from numpy.typing import ArrayLike

from . import borders, distances
from .config.grid import build_grid
from .config.model import Config
from .config.options import options_of
from .config.reader import load_config
from .config.studies import Contours, alone
from .dataset.build import cell_coordinates, grid_coordinates
from .dataset.provenance import provenance
from .engine import Options, Progress
from .runs.memory import compute_study
from .vocabulary.cells import as_cells
from .vocabulary.settings import CONTOURS

__all__ = ["contours", "margins"]

Cells = Mapping[str, ArrayLike] | xr.Dataset
Asked = Cells | Config | str | os.PathLike[str]


def contours(
    cells_or_config: Asked,
    axes: tuple[str, str] | None = None,
    between: Mapping[str, tuple[float, float]] | None = None,
    points: int = 512,
    tolerance: float = 1e-9,
    *,
    scan: int = 64,
    rtol: float | None = None,
    horizon: float | None = None,
    threads: int | None = None,
    law: str | None = None,
    max_steps: int | None = None,
    progress: Progress | None = None,
) -> xr.Dataset:
    """Where the regime changes in a plane of two parameters: lines, loops among them.

    cells_or_config : a configuration, whose other axes are further panels; or cells as `evaluate` takes them, each of
        which is a panel.
    axes : the two parameters, (y, x); None takes the last two axes of the configuration, as plots do. between : their
        ranges (SI) by name; those of the axes of the configuration unless given.
    points : of the grid whose sides are crossed, along either axis. Only points beside a line are looked at, so that
        the cost grows with its length, not with the area.
    tolerance : width of the last bracket over the border, for every node.
    scan : points along each axis that are looked at first. A loop between them is missed.
    rtol, horizon, threads, law, max_steps, progress : as for `border`.

    Returns a dataset of lines in the manner of CF geometries: the parameters over `node`, the lines one after the
    other; over `line` node_count, closed (its last node is its first), regime_left and regime_right as x grows to the
    right and y upwards. Every node lies where a line crosses a side of the grid (node_along says which parameter was
    searched), or is a junction, where three or more regimes meet. What is unresolved or failed is a region of its own.
    Raises TypeError or ValueError for bad input before anything is computed, ConfigError for a bad configuration.
    """
    limits, ranges = borders.Limits(scan, tolerance), dict(between or {})
    _check_points(points)
    given = _given(rtol, limits.rtol(), horizon, threads, max_steps)
    if isinstance(cells_or_config, Config | str | os.PathLike):
        config = _config(cells_or_config)
        options = _options_of(config, law, given)
        plane = borders.plane_of_config(config, axes, ranges, int(points))
        asked = Contours.model_construct(
            axes=axes, between=ranges or None, points=int(points), tolerance=tolerance, scan=scan, rtol=rtol
        )
        title = f"Contours of regimes: {config.title}"
        text = config.model_copy(update=alone("contours", asked)).to_yaml()
    else:
        options = Options(law=law or Options.law, **given)
        plane = borders.plane_of_cells(cells_or_config, axes, ranges, int(points))
        title, text = "Contours of regimes", _text(options)
    study = borders.ContourStudy(plane, limits, options)
    action = f"contours over {plane.y.name} and {plane.x.name}"
    return study.dataset(compute_study(study, progress), provenance(text, title=title, action=action))


def margins(
    cells_or_config: Asked,
    parameters: Sequence[str] | None = None,
    costs: Mapping[str, float] | None = None,
    within: float | Mapping[str, float | tuple[float, float]] = distances.FACTOR,
    *,
    into: Sequence[str] | None = None,
    joint: bool = True,
    tolerance: float = 1e-9,
    scan: int = 32,
    beyond: float = 0.01,
    rtol: float | None = None,
    horizon: float | None = None,
    threads: int | None = None,
    law: str | None = None,
    max_steps: int | None = None,
    progress: Progress | None = None,
) -> xr.Dataset:
    """How far each cell is from a border: along single parameters, and by the cheapest change of all of them together.

    cells_or_config : cells as `evaluate` takes them, or a configuration, whose axes are the dimensions.
    parameters : that may change; None for belt_speed, stiffness, damping, normal_load, mass, and mu_stop and mu_static
        where a cell has them.
    costs : of changing each parameter by a factor, relative to the others; 1 unless given. Where a value is 0, and for
        displacement and velocity, of a change by a scale of the cell (for damping, critical damping).
    within : how far to look: a factor, or by parameter factors or ranges (SI).
    into : names of the regimes that count; None for any other than that of the cell.
    joint : False leaves out the cheapest joint change, which takes most of the time.
    scan : places looked at first on either side. beyond : how far past a border each proposal is simulated, over the
        value.
    tolerance, rtol, horizon, threads, law, max_steps, progress : as for `border`.

    Returns a dataset over the cells, and `side` (below, above). For each parameter NAME: margin_NAME, the distance to
    the nearest border with its sign; ratio_NAME, the same as a factor; border_NAME, border_width_NAME, beyond_NAME,
    proposed_NAME and checked_NAME (the value past the border that was simulated, and its regime) on both sides. NaN,
    and regime 0, where there is no border within reach. joint_cost, joint_NAME, joint_proposed_NAME, joint_checked.
    Raises TypeError or ValueError for bad input before anything is computed, ConfigError for a bad configuration.
    """
    limits = borders.Limits(scan, tolerance)
    given = _given(rtol, limits.rtol(), horizon, threads, max_steps)
    if isinstance(cells_or_config, Config | str | os.PathLike):
        config = _config(cells_or_config)
        if config.drive is not None:
            raise ValueError("a configuration with a drive is that of a rig, whose cells have no regime")
        if config.uncertain is not None:
            raise ValueError("a configuration with uncertain quantities has no single margin; leave uncertain out")
        options, grid = _options_of(config, law, given), build_grid(config)
        asking = distances.Asking(grid.dims, grid.shape, grid_coordinates(grid), grid.cells)
        title, text = f"Margins: {config.title}", config.to_yaml()
    else:
        options = Options(law=law or Options.law, **given)
        cells = as_cells(cells_or_config)
        size = cells["mass"].size
        asking = distances.Asking(
            ("cell",), (size,), cell_coordinates(cells, size),
            lambda start, stop: {name: values[start:stop] for name, values in cells.items()},
        )  # fmt: skip
        title, text = "Margins of cells", _text(options)
    names = distances.parameters_of(asking.cells(0, prod(asking.shape))) if parameters is None else tuple(parameters)
    question = distances.Question(
        names, dict(costs or {}), within, None if into is None else tuple(into), scan, tolerance, beyond, joint
    )
    attributes = provenance(text, title=title, action=f"margins along {', '.join(names)}")
    study = distances.MarginStudy(asking, question, options)
    return study.dataset(compute_study(study, progress), attributes)


def _check_points(points: object) -> None:
    row = CONTOURS["points"]
    if isinstance(points, bool) or not isinstance(points, Integral) or not row.allows(int(points)):
        raise ValueError(f"points: got {points!r}, expected {row.expected}")


def _given(
    rtol: float | None, default: float, horizon: float | None, threads: int | None, max_steps: int | None
) -> dict[str, Any]:
    """What was said of the integration."""
    given: dict[str, Any] = {"horizon": horizon, "threads": threads, "max_steps": max_steps}
    given = {name: value for name, value in given.items() if value is not None}
    return given | {"rtol": default if rtol is None else float(rtol)}


def _config(config_or_path: Config | str | os.PathLike[str]) -> Config:
    return config_or_path if isinstance(config_or_path, Config) else load_config(config_or_path)


def _options_of(config: Config, law: str | None, given: Mapping[str, Any]) -> Options:
    if law is not None:
        raise ValueError(f"law: got {law!r}, but a configuration says its law itself: {config.friction.law}")
    return replace(options_of(config), early_stop=True, **given)


def _text(options: Options) -> str:
    """What cells computed one by one share, as text."""
    solver = {"rtol": options.rtol, "horizon": None if isinf(options.horizon) else options.horizon}
    return json.dumps({"friction": {"law": options.law}, "solver": solver | {"max_steps": options.max_steps}})
