"""The calls of a designer: borders along a parameter, or as lines in a plane, and how far cells are from one."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from dataclasses import replace
from math import isinf, prod
from numbers import Integral
from typing import Any, cast

import numpy as np
import xarray as xr
from numpy.typing import ArrayLike

from . import borders, distances
from .config.checks import Ends, checked_range, in_si, line_along, plane_along
from .config.grid import build_grid
from .config.model import Axis, Config, Range
from .config.options import options_of
from .config.reader import Given, as_config, is_config
from .config.studies import STUDIES, Border, Contours, alone
from .dataset.build import grid_coordinates
from .dataset.given import given_cells
from .dataset.provenance import provenance
from .engine import Options
from .errors import ArgumentError
from .progress import Watch, watched
from .runs.memory import compute_study
from .study import Study
from .vocabulary.quantities import QUANTITIES
from .vocabulary.settings import CONTOURS

_SPEEDS = 9  # looked at in a range of belt speeds

__all__ = ["border", "contours", "margins"]

_COARSE = 160  # points of an axis of the map that is computed to be drawn

Cells = Mapping[str, ArrayLike] | xr.Dataset
Asked = Cells | Given


def border(
    cells_or_config: Asked,
    along: str,
    between: Ends | None = None,
    tolerance: float = 1e-9,
    *,
    scan: int = 64,
    rtol: float | None = None,
    horizon: float | None = None,
    threads: int | None = None,
    law: str | None = None,
    max_steps: int | None = None,
    progress: Watch = "auto",
) -> xr.Dataset:
    """Where along a parameter the regime changes, in every line of cells.

    cells_or_config : cells as `evaluate` takes them, whose dimensions the result has; or a configuration, as `run`
        takes it, whose other axes are the dimensions. What they say of the searched parameter itself is left out.
    along : a parameter of a cell. between : its range, in SI or texts with units; None takes that of the axis of the
        configuration.
    tolerance : width of the last bracket over the border, or over a thousandth of the larger end of a range if
        that holds 0 and the border is closer to it.
    scan : places looked at first, evenly spaced, by ratio where the ends are a factor of 10 apart. A regime that begins
        and ends between two of them can be missed.
    rtol : of the integration; None for a hundredth of the tolerance, from 1e-12 to 1e-6.
    horizon, threads, law, max_steps : of `evaluate`; None takes the defaults, or what the configuration says. A
        configuration says its law itself. progress : as for `run`.

    A configuration with a section `border` asks for the same of `run`, which resumes and uses clusters.

    Returns a dataset over the lines and `crossing`, in ascending order: border (NaN where a line has fewer),
    regime_below, regime_above, border_width, method, and scan_undecided per line. Where cells at a border are
    unresolved or failed, border_width is the stretch of them. No crossing is no error: `crossing` has length 0, and the
    attribute border_found says so. Raises TypeError or ValueError for bad input before anything is computed,
    ConfigError for a bad configuration.
    """
    limits, ends = borders.Limits(scan, tolerance), None if between is None else in_si(along, between)
    given = _given(rtol, limits.rtol(), horizon, threads, max_steps)
    if is_config(cells_or_config):
        config = as_config(cast(Given, cells_or_config))
        options = _options_of(config, law, given)
        lines = borders.lines_of_config(config, along, ends)
        asked = Border.model_construct(along=along, between=ends, tolerance=tolerance, scan=scan, rtol=rtol)
        title = f"Borders of regimes: {config.title}"
        text = config.model_copy(update=alone("border", asked)).to_yaml()
    else:
        options = Options(law=law or Options.law, **given)
        lines = borders.lines_of_cells(cast(Cells, cells_or_config), along, ends, options.law)
        title, text = "Borders of regimes", _text(options)
    study = borders.BorderStudy(lines, limits, options)
    return _computed(study, progress, provenance(text, title=title, action=f"border along {along}"))


def contours(
    cells_or_config: Asked,
    axes: tuple[str, str] | None = None,
    between: Mapping[str, Ends] | None = None,
    points: int = 512,
    tolerance: float = 1e-9,
    *,
    scan: int = 64,
    rtol: float | None = None,
    horizon: float | None = None,
    threads: int | None = None,
    law: str | None = None,
    max_steps: int | None = None,
    progress: Watch = "auto",
) -> xr.Dataset:
    """Where the regime changes in a plane of two parameters: lines, loops among them.

    cells_or_config : a configuration, whose other axes are further panels; or cells as `evaluate` takes them, each of
        which is a panel.
    axes : the two parameters, (y, x); None takes the last two axes of the configuration, as plots do. between : their
        ranges by name, in SI or texts with units; those of the axes of the configuration unless given.
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
    limits, ranges = (
        borders.Limits(scan, tolerance),
        {name: in_si(name, ends) for name, ends in dict(between or {}).items()},
    )
    _check_points(points)
    given = _given(rtol, limits.rtol(), horizon, threads, max_steps)
    if is_config(cells_or_config):
        config = as_config(cast(Given, cells_or_config))
        options = _options_of(config, law, given)
        plane = borders.plane_of_config(config, axes, ranges, int(points))
        asked = Contours.model_construct(
            axes=axes, between=ranges or None, points=int(points), tolerance=tolerance, scan=scan, rtol=rtol
        )
        title = f"Contours of regimes: {config.title}"
        text = config.model_copy(update=alone("contours", asked)).to_yaml()
    else:
        options = Options(law=law or Options.law, **given)
        plane = borders.plane_of_cells(cast(Cells, cells_or_config), axes, ranges, int(points))
        title, text = "Contours of regimes", _text(options)
    study = borders.ContourStudy(plane, limits, options)
    action = f"contours over {plane.y.name} and {plane.x.name}"
    return _computed(study, progress, provenance(text, title=title, action=action))


def margins(
    cells_or_config: Asked,
    parameters: Sequence[str] | None = None,
    costs: Mapping[str, float] | None = None,
    within: float | Mapping[str, float | tuple[float, float]] = distances.FACTOR,
    *,
    into: Sequence[str] | None = None,
    speed_range: Ends | None = None,
    joint: bool = True,
    tolerance: float = 1e-9,
    scan: int = 32,
    beyond: float = 0.01,
    rtol: float | None = None,
    horizon: float | None = None,
    threads: int | None = None,
    law: str | None = None,
    max_steps: int | None = None,
    progress: Watch = "auto",
) -> xr.Dataset:
    """How far each cell is from a border: along single parameters, and by the cheapest change of all of them together.

    cells_or_config : cells as `evaluate` takes them, or a configuration, whose axes are the dimensions.
    parameters : that may change; None for belt_speed, stiffness, damping, normal_load, mass, and mu_stop and mu_static
        where a cell has them. Of mu_start, mu_reversal and v_reversal, which are measured of a curve, each changes with
        the others held, and a4 with all three.
    costs : of changing each parameter by a factor, relative to the others; 1 unless given. Where a value is 0, and for
        displacement and velocity, of a change by a scale of the cell (for damping, critical damping).
    within : how far to look: a factor, or by parameter factors or ranges (SI).
    into : names of the regimes that count; None for any other than that of the cell.
    speed_range : the ends of a range of belt speeds (m/s, or texts with units), of nine of which, by equal ratios, the
        worst counts: a goal such as quiet from 5 to 60 mm/s.
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
    if is_config(cells_or_config):
        config = as_config(cast(Given, cells_or_config))
        if config.drive is not None:
            raise ValueError("a configuration with a drive is that of a rig, whose cells have no regime")
        if config.uncertain is not None:
            raise ValueError("a configuration with uncertain quantities has no single margin; leave uncertain out")
        options, grid = _options_of(config, law, given), build_grid(config)
        asking = distances.Asking(grid.dims, grid.shape, grid_coordinates(grid), grid.cells)
        title, text = f"Margins: {config.title}", config.to_yaml()
    else:
        options = Options(law=law or Options.law, **given)
        cells = given_cells(cast(Cells, cells_or_config), options.law)
        asking = distances.Asking(cells.dims, cells.shape, cells.coordinates(), cells.part)
        title, text = "Margins of cells", _text(options)
    speeds = speeds_in(speed_range)
    names = distances.parameters_of(asking.cells(0, prod(asking.shape))) if parameters is None else tuple(parameters)
    if parameters is None and speeds:
        names = tuple(name for name in names if name != "belt_speed")
    question = distances.Question(
        names, dict(costs or {}), within, None if into is None else tuple(into), scan, tolerance, beyond, joint, speeds
    )
    attributes = provenance(text, title=title, action=f"margins along {', '.join(names)}")
    study = distances.MarginStudy(asking, question, options)
    return _computed(study, progress, attributes)


def _computed(study: Study, progress: Watch, attributes: Mapping[str, str]) -> xr.Dataset:
    with watched(progress, study.counted, study.options.law) as moved:
        return study.dataset(compute_study(study, moved), attributes)


def speeds_in(ends: Ends | None) -> tuple[float, ...]:
    """The belt speeds (m/s) looked at in a range, both ends among them. Raises TypeError or ValueError."""
    if ends is None:
        return ()
    try:
        low, high = checked_range("belt_speed", in_si("belt_speed", ends))
    except ArgumentError as error:
        raise ArgumentError("speed_range", error.what) from None
    if not low > 0:
        raise ValueError(f"speed_range: got {low:g} m/s, expected speeds above 0")
    return tuple(map(float, np.geomspace(low, high, _SPEEDS)))


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


def _options_of(config: Config, law: str | None, given: Mapping[str, Any]) -> Options:
    if law is not None:
        raise ValueError(f"law: got {law!r}, but a configuration says its law itself: {config.friction.law}")
    return replace(options_of(config), early_stop=True, **given)


def _text(options: Options) -> str:
    """What cells computed one by one share, as text."""
    solver = {"rtol": options.rtol, "horizon": None if isinf(options.horizon) else options.horizon}
    return json.dumps({"friction": {"law": options.law}, "solver": solver | {"max_steps": options.max_steps}})


# --- the map behind borders -------------------------------------------------------------------------------------------


def coarse_map(config: Config) -> Config:
    """The configuration of a map in which the borders that a configuration asks for lie, with few cells."""
    if config.border is not None:
        found = {config.border.along: line_along(config, config.border.along, config.border.between)}
    elif config.contours is not None:
        found = plane_along(config, config.contours.axes, config.contours.between or {})
    else:
        return config
    axes: list[Axis] = []
    for axis in config.axes:
        name = next((name for name, line in found.items() if line.axis is axis), None)
        axes.append(_coarse(axis) if name is None else _over(name, *found.pop(name)[1:]))
    axes += [_over(name, *line[1:]) for name, line in found.items()]
    if config.contours is not None:
        names = plane_along(config, config.contours.axes, config.contours.between or {})
        axes.sort(key=lambda axis: [*names].index(axis.name) if axis.name in names else -1)
    return _without_fixed(config, axes)


def _without_fixed(config: Config, axes: list[Axis]) -> Config:
    """The configuration of a map over these axes; what they vary is fixed no longer."""
    changed: dict[str, Any] = {**dict.fromkeys(STUDIES), "axes": tuple(axes)}
    for axis in axes:
        if axis.name in QUANTITIES:
            section = QUANTITIES[axis.name].section
            changed[section] = changed.get(section, getattr(config, section)).model_copy(update={axis.name: None})
    return config.model_copy(update=changed)


def _coarse(axis: Axis) -> Axis:
    return axis.model_copy(update={"num": min(axis.num, _COARSE)}) if isinstance(axis, Range) else axis


def _over(name: str, between: tuple[float, float], spacing: str | None) -> Axis:
    """An axis over a range; by ratio where that is how it is searched."""
    spacing = spacing or borders.Scan.over(*between, 2).spacing
    return Range.model_construct(name=name, spacing=spacing, start=between[0], stop=between[1], num=_COARSE)
