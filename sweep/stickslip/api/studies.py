"""The Python calls for studies of cells: border, contours, margins, attractors, ramp."""

from collections.abc import Mapping, Sequence
from typing import Unpack

import xarray as xr

from stickslip.config.model import Axis, Config, Range
from stickslip.config.studies import section_of_call, study_class
from stickslip.engine import SolverKeywords
from stickslip.errors import ArgumentError
from stickslip.progress import Watch
from stickslip.runs.threads import CellsOrConfig, Subject
from stickslip.studies.attractors import Attractors
from stickslip.studies.border import Border
from stickslip.studies.contours import Contours
from stickslip.studies.margins import Margins
from stickslip.studies.ramp import Ramp
from stickslip.studies.search import Scan
from stickslip.vocabulary.quantities import QUANTITIES

__all__ = ["attractors", "border", "contours", "margins", "ramp"]

Ends = tuple[float | str, float | str]  # in SI, or texts with units
_BOX = "{'displacement': (low, high), 'velocity': (low, high)}"
_COARSE = 160  # points of an axis of the map that is computed to be drawn


def border(
    cells_or_config: CellsOrConfig,
    along: str,
    between: Ends | None = None,
    tolerance: float | None = None,
    *,
    scan: int = 64,
    progress: Watch = "auto",
    **solver: Unpack[SolverKeywords],
) -> xr.Dataset:
    """Find where along a parameter the regime changes, in every line of cells.

    A configuration with a section `border` asks for the same of `run`, which resumes and uses clusters.

    Parameters
    ----------
    cells_or_config : Mapping, Dataset, DataFrame, Config or path
        Cells as `evaluate` takes them, whose dimensions the result has; or a configuration, as `run` takes it, whose
        other axes are the dimensions. What they say of the searched parameter itself is left out.
    along : str
        A parameter of a cell.
    between : pair of float or str, optional
        Its range, in SI or texts with units; by default that of the axis of the configuration.
    tolerance : float, optional
        Width of the last bracket over the border, or over a thousandth of the larger end of a range if that holds 0
        and the border is closer to it. By default 1e-9, 1e-4 for contacts with memory.
    scan : int
        Places looked at first, evenly spaced, by ratio where the ends are a factor of 10 apart. A regime that begins
        and ends between two of them can be missed.
    progress : bool, "auto" or callable
        As for `run`.
    **solver
        options, or single ones of them: law, rtol, horizon (s), max_steps and threads, as for `evaluate`; by default
        those of the configuration, which says its law itself. rtol is a hundredth of the tolerance, from 1e-12 to 1e-6.

    Returns
    -------
    Dataset
        Over the lines and `crossing`, in ascending order: border (NaN where a line has fewer), regime_below,
        regime_above, border_width, method, and scan_undecided per line. Where cells at a border are unresolved or
        failed, border_width is the stretch of them. No crossing is no error: `crossing` has length 0.

    Raises
    ------
    TypeError, ValueError, ConfigError
        For bad input, before anything is computed.
    """
    section = section_of_call(
        Border, along=along, between=between, tolerance=tolerance, scan=scan, rtol=rtol_of(solver)
    )
    return Subject.of(cells_or_config, solver).computed(section, progress)


def contours(
    cells_or_config: CellsOrConfig,
    axes: tuple[str, str] | None = None,
    between: Mapping[str, Ends] | None = None,
    points: int | None = None,
    tolerance: float | None = None,
    *,
    scan: int = 64,
    progress: Watch = "auto",
    **solver: Unpack[SolverKeywords],
) -> xr.Dataset:
    """Find where the regime changes in a plane of two parameters: lines, loops among them.

    Parameters
    ----------
    cells_or_config : Mapping, Dataset, DataFrame, Config or path
        A configuration, whose other axes are further panels; or cells as `evaluate` takes them, each of which is a
        panel.
    axes : pair of str, optional
        The two parameters, (y, x); by default the last two axes of the configuration, as plots have them.
    between : Mapping of str to pair, optional
        Their ranges, in SI or texts with units; by default those of the axes of the configuration.
    points : int, optional
        Of the grid whose sides are crossed, along either axis; by default 512, 128 for contacts with memory. Only
        points beside a line are looked at, so that the cost grows with its length, not with the area.
    tolerance : float, optional
        Width of the last bracket over the border, for every node; by default as for `border`.
    scan : int
        Points along each axis that are looked at first. A loop between them is missed.
    progress, **solver
        As for `border`, as are exceptions.

    Returns
    -------
    Dataset
        Lines in the manner of CF geometries: the parameters over `node`, the lines one after the other; over `line`
        node_count, closed (its last node is its first), regime_left and regime_right as x grows to the right and y
        upwards. Every node lies where a line crosses a side of the grid (node_along says which parameter was searched),
        or is a junction, where three or more regimes meet. What is unresolved or failed is a region of its own.
    """
    section = section_of_call(
        Contours, axes=axes, between=between, points=points, tolerance=tolerance, scan=scan, rtol=rtol_of(solver)
    )
    return Subject.of(cells_or_config, solver).computed(section, progress)


def margins(
    cells_or_config: CellsOrConfig,
    parameters: Sequence[str] | None = None,
    costs: Mapping[str, float] | None = None,
    within: float | Mapping[str, float | tuple[float, float]] = 10.0,
    *,
    into: Sequence[str] | None = None,
    speed_range: Ends | None = None,
    joint: bool = True,
    tolerance: float | None = None,
    scan: int = 32,
    beyond: float = 0.01,
    progress: Watch = "auto",
    **solver: Unpack[SolverKeywords],
) -> xr.Dataset:
    """Find how far each cell is from a border: along single parameters, and by the cheapest change of all of them.

    Parameters
    ----------
    cells_or_config : Mapping, Dataset, DataFrame, Config or path
        Cells as `evaluate` takes them, or a configuration, whose axes are the dimensions.
    parameters : sequence of str, optional
        What may change; by default belt_speed, stiffness, damping, normal_load, mass, and mu_stop and mu_static where a
        cell has them. Of what is measured of a curve, friction at break-away and its minimum, each changes with the
        others held, and the decay speed with all of them.
    costs : Mapping of str to float, optional
        Of changing each parameter by a factor, relative to the others; 1 unless given. Where a value is 0, and for
        displacement and velocity, of a change by a scale of the cell (for damping, critical damping).
    within : float or Mapping
        How far to look: a factor, or by parameter factors or ranges (SI).
    into : sequence of str, optional
        Names of the regimes that count, "opposite" for quiet ones of what vibrates and the reverse; by default any
        other than that of the cell.
    speed_range : pair of float or str, optional
        The ends of a range of belt speeds (m/s), of nine of which, by equal ratios, the worst counts: a goal such as
        quiet from 5 to 60 mm/s.
    joint : bool
        False leaves out the cheapest joint change, which takes most of the time.
    tolerance : float, optional
        As for `border`.
    scan : int
        Places looked at first on either side.
    beyond : float
        How far past a border each proposal is simulated, over the value.
    progress, **solver
        As for `border`, as are exceptions.

    Returns
    -------
    Dataset
        Over the cells, and `side` (below, above). For each parameter NAME: margin_NAME, the distance to the nearest
        border with its sign; ratio_NAME, the same as a factor; border_NAME, border_width_NAME, beyond_NAME,
        proposed_NAME and checked_NAME (the value past the border that was simulated, and its regime) on both sides.
        NaN, and regime 0, where there is no border within reach. joint_cost, joint_NAME, joint_proposed_NAME,
        joint_checked.
    """
    section = section_of_call(
        Margins, parameters=parameters, costs=costs, within=within, into=into, speed_range=speed_range, joint=joint,
        scan=scan, tolerance=tolerance, beyond=beyond, rtol=rtol_of(solver),
    )  # fmt: skip
    return Subject.of(cells_or_config, solver).computed(section, progress)


def attractors(
    cells_or_config: CellsOrConfig,
    box: Mapping[str, Ends] | None = None,
    *,
    samples: int = 1024,
    seed: int = 1,
    progress: Watch = "auto",
    **solver: Unpack[SolverKeywords],
) -> xr.Dataset:
    """Find which regimes cells have, by starting state, and the share of a box of starting states that settles.

    A configuration with a section `attractors` asks for the same of `run`, which resumes and uses clusters.

    Parameters
    ----------
    cells_or_config : Mapping, Dataset, DataFrame, Config or path
        Cells as `evaluate` takes them, whose dimensions the result has; or a configuration, as `run` takes it, whose
        axes are the dimensions. What they say of the state at the start is left out.
    box : Mapping, optional
        ``{"displacement": (low, high), "velocity": (low, high)}``, in SI or texts with units; by default that of the
        section `attractors` of the configuration, with its samples and seed.
    samples : int
        Starting states drawn where the share is not exact, 16 times a power of 2.
    seed : int
        Of them.
    progress, **solver
        As for `border`, with rtol of `evaluate`, as are exceptions.

    Returns
    -------
    Dataset
        coexisting (a bit per regime), regime_from_stick, regime_from_sliding, settling_share with share_error, its
        bounds and share_method; of the unstable cycle (NaN where there is none, or it is not exact) unstable_amplitude,
        unstable_velocity_amplitude, unstable_period; critical_shock and critical_shift, the smallest changes of
        velocity and displacement at steady sliding after which it does not come back, and both in either direction.
    """
    subject = Subject.of(cells_or_config, solver)
    if box is not None:
        if not isinstance(box, Mapping):
            raise TypeError(f"box: got {box!r}, expected {_BOX}")
        return subject.computed(section_of_call(Attractors, **box, samples=samples, seed=seed), progress)
    study = subject.cells.study if isinstance(subject.cells, Config) else None
    if not isinstance(study, Attractors):
        raise ArgumentError("box", f"missing, expected {_BOX}")
    return subject.computed(study, progress)


def ramp(
    cells_or_config: CellsOrConfig,
    along: str,
    between: Ends | None = None,
    points: int = 200,
    *,
    progress: Watch = "auto",
    **solver: Unpack[SolverKeywords],
) -> xr.Dataset:
    """Follow attractors while a parameter goes slowly up and down again: where vibration stops, and where it starts.

    Every value starts from where the motion at the one before ended; the first, from sticking with an unloaded contact.
    The ramp waits at each until the motion has come to its attractor, and steady sliding keeps a disturbance of 1e-4 of
    the belt speed.

    Parameters
    ----------
    cells_or_config, along, between
        As for `border`; every line is a ramp.
    points : int
        Values, spaced as the places that `border` looks at first, or as the axis of the configuration.
    progress, **solver
        As for `border`, with rtol of `evaluate`, as are exceptions.

    Returns
    -------
    Dataset
        Over the lines, `direction` ("up", "down") and the parameter: regime, status, velocity_amplitude,
        displacement_amplitude, period, stick_fraction; and of what lies between both branches, over the lines and the
        parameter: unstable_amplitude, unstable_velocity_amplitude and unstable_period of the unstable cycle (as
        `attractors` finds it, NaN where it is not known exactly) and damping_ratio. `plots.plot_branches` draws it.
    """
    section = section_of_call(Ramp, along=along, between=between, points=points)
    return Subject.of(cells_or_config, solver).computed(section, progress)


def rtol_of(solver: SolverKeywords) -> float | None:
    """The tolerance of the integration where one is given, by itself or among options."""
    options = solver.get("options")
    return solver.get("rtol") or (options.rtol if options else None)


# --- the map behind borders -------------------------------------------------------------------------------------------


def coarse_map(config: Config) -> Config:
    """The configuration of a map in which the borders that a configuration asks for lie, with few cells."""
    lines = study_class(config.study.key).lines_in(config.study, config) if config.study else {}
    if not lines:
        return config
    of_lines = {name: _over(name, *line[1:]) for name, line in lines.items()}
    axes = [axis.model_copy(update={"num": min(axis.num, _COARSE)}) if isinstance(axis, Range) else axis
            for axis in config.axes]  # fmt: skip
    axes = [next((of_lines.pop(name) for name, line in lines.items() if line.axis is whole), axis)
            for whole, axis in zip(config.axes, axes, strict=True)]  # fmt: skip
    axes += of_lines.values()
    if len(lines) > 1:
        axes.sort(key=lambda axis: [*lines].index(axis.name) if axis.name in lines else -1)
    varied = [axis.name for axis in axes if axis.name in QUANTITIES]
    return config.without(*varied).plain_map().model_copy(update={"axes": tuple(axes)})


def _over(name: str, between: tuple[float, float], spacing: str | None) -> Axis:
    """An axis over a range; by ratio where that is how it is searched."""
    spacing = spacing or Scan.over(*between, 2).spacing
    return Range.model_construct(name=name, spacing=spacing, start=between[0], stop=between[1], num=_COARSE)
