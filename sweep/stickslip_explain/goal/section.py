"""The section `goal`, and the plane, the ranges and the cells that it asks about."""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Annotated, Any

import numpy as np
import xarray as xr
from pydantic import Field

from stickslip.config.grid import build_grid
from stickslip.config.model import Config, Group, Range, Values
from stickslip.config.sections import RANGE, Read, choice, interval, of_row, refused
from stickslip.dataset.build import given_cells
from stickslip.engine import Options
from stickslip.errors import ArgumentError
from stickslip.studies.contours import Contours
from stickslip.studies.lines import PARAMETER, CellsOrConfig, Side
from stickslip.studies.search import Floats, Scan
from stickslip.vocabulary.cells import Cells, Parameters
from stickslip.vocabulary.models import laws_with, model_of
from stickslip.vocabulary.parameter import Parameter, table
from stickslip.vocabulary.quantities import PARAMETERS, SEARCHABLE
from stickslip.vocabulary.suggest import listed
from stickslip.vocabulary.units import ends_of

PROBABILITY = 0.95  # where quantities scatter and no other one is wanted
_RANGES = "a range for each of some parameters: {belt_speed: 5..60 mm/s}"
_WITHIN = 2.0  # factor up and down of what panels have, where no range is given
_TEXT = {"type": "string", "pattern": r"\.\."}


def _quiet_over(value: object) -> object:
    """Ranges by parameter, of two ends or "5..60 mm/s"; of the belt speed above 0."""
    if not isinstance(value, Mapping) or not value:
        raise refused(_RANGES)
    ranges = {}
    for name, ends in value.items():
        row = SEARCHABLE[choice(name, SEARCHABLE, "a parameter of a cell", inside=True)]
        if isinstance(ends, str):
            try:
                ends = ends_of(name, ends)
            except ValueError:
                raise refused(_RANGES) from None
        ranges[name] = interval(replace(row, above=0) if name == "belt_speed" else row, ends)
    return ranges


def _own(name: str, default: float) -> Parameter:
    """A row of contours with a default of its own, the same for all contacts."""
    row = Contours.rows[name]
    return replace(row, section="goal", default=default, long_name=row.long_name.partition("; unless")[0])


class Goal(Contours):
    """The region of a plane in which cells are quiet over whole ranges; the other axes, materials say, are panels."""

    key, options = "goal", {"axes": "--over", "probability": "--with"}
    rows = Contours.rows | table(
        _own("points", 257),
        _own("scan", 65),
        _own("tolerance", 1e-5),
        Parameter("samples", "1", "values of each range that are looked at first, by equal ratios", key,
                  default=9, at_least=2, at_most=1000, whole=True),
        Parameter("probability", "1", "probability of being quiet throughout, of what scatters (uncertain); "
                  f"{PROBABILITY:g} unless given", key, above=0, at_most=1, absent=f"{PROBABILITY:g}"),
    )  # fmt: skip
    quiet_over: Annotated[
        dict[str, tuple[float, float]],
        Read(_quiet_over, {"type": "object", "minProperties": 1, "propertyNames": PARAMETER.schema,
                           "additionalProperties": {"anyOf": [RANGE, _TEXT]}}),
    ] = Field(description="by parameter, the range throughout which cells are to be quiet")  # fmt: skip
    probability: float | None = of_row(rows["probability"])
    samples: int = of_row(rows["samples"])
    points: int = of_row(rows["points"])
    tolerance: float = of_row(rows["tolerance"])
    scan: int = of_row(rows["scan"])


@dataclass(frozen=True, eq=False)
class GoalPlane:
    """The plane of a goal, its panels and its ranges.

    panels : the cells in which the plane is opened. as_they_are : their parameters, what scatters at its median, with
    what is measured of curves where `measured`: then the coefficients follow from that. here : by parameter of the
    plane (y, x), what panels have; NaN for a curve without a minimum. is_plane : whether nothing is known of that,
    since a parameter of the plane is an axis. ranges : of the values to be quiet over.
    """

    panels: Cells
    as_they_are: Parameters
    measured: bool
    here: Parameters
    is_plane: bool
    y: Side
    x: Side
    ranges: tuple[Side, ...]


def goal_plane(given: CellsOrConfig, section: Goal, options: Options) -> GoalPlane:
    """The plane of a configuration, or of cells. Raises TypeError or ValueError for what cannot be goal."""
    if isinstance(given, Config):
        names, written = _names(given, section), given.written_in
        panels, axes, changed, known = _of_config(given, section, names)
    else:
        names, written = _names(None, section), {}
        panels, axes, changed, known = (
            _of_cells(given, section, names, options),
            {},
            {*names, *section.quiet_over},
            set(),
        )
    for name in (*names, *section.quiet_over):
        if options.law not in (laws := laws_with(name)):
            raise ArgumentError("axes", f"{name} is for the law {listed(laws)}, not {options.law}")
    model, cells = model_of(options.law), panels[:]
    measured = bool((changed | known) & {*model.measured})
    if measured and (replaced := changed & {*model.replaced}):
        follows = f"{min(replaced)} follows from {listed(model.measured, 'and')}"
        raise ArgumentError("axes", f"{follows} here, expected one of these to change or to scatter, or none")
    cells = model.with_measured(cells) if measured else cells
    here = {name: np.full(panels.size, np.nan) if name in axes or name not in cells else cells[name] for name in names}
    y, x = (_side(name, section, axes.get(name), here[name], written.get(name)) for name in names)
    ranges = tuple(Side(*ends, section.samples, "log" if ends[0] > 0 else "linear", name)
                   for name, ends in section.quiet_over.items())  # fmt: skip
    return GoalPlane(panels, cells, measured, here, any(name in axes for name in names), y, x, ranges)


def _names(config: Config | None, section: Goal) -> tuple[str, str]:
    """The parameters of the plane, y and x. Raises ArgumentError."""
    names = section.axes
    if names is None:
        single = [axis.name for axis in (config.axes if config else ()) if not isinstance(axis, Group)]
        free = [name for name in single if name not in section.quiet_over][-2:]
        if len(free) < 2:
            raise ArgumentError("axes", "missing, expected the two parameters of the plane, y and x")
        names = free[0], free[1]
    if both := [name for name in names if name in section.quiet_over]:
        raise ArgumentError("quiet_over", f"got {both[0]}, which is a parameter of the plane, expected others")
    if other := [name for name in section.between or () if name not in names]:
        raise ArgumentError("between", f"got a range for {other[0]!r}, expected {names[0]} or {names[1]}")
    return names


def _of_config(
    config: Config, section: Goal, names: tuple[str, str]
) -> tuple[Cells, dict[str, Range | Values], set[str], set[str]]:  # fmt: skip
    """The panels, the axes of the configuration that the plane takes, what changes or scatters, and what is given."""
    if not config.has_cells:
        raise ArgumentError("axes", "the configuration has a drive: cells of a rig have no regime to be quiet in")
    uncertain = config.uncertain
    if uncertain is None and section.probability not in (None, 1.0):
        raise ArgumentError("probability", "got one, and nothing scatters, expected a section uncertain")
    if uncertain is not None and uncertain.subset is not None:
        raise ArgumentError("probability", "goals take Sobol points, expected no subset in uncertain")
    varied = {*names, *section.quiet_over}
    scattered = {} if uncertain is None else uncertain.values(np.zeros((1, len(uncertain.names))))
    if both := varied & scattered.keys():
        name = min(both)
        key, place = ("axes", "along the plane") if name in names else ("quiet_over", "over this range")
        raise ArgumentError(
            key, f"{name} is uncertain, expected one that is known: {place} it takes each value in turn"
        )
    given = {*config.fixed(), *(member.name for axis in config.axes for member in axis.members)}
    own = {axis.name: axis for axis in config.axes if not isinstance(axis, Group) and axis.name in varied}
    known = {name: float(values[0]) for name, values in scattered.items()}
    known |= {name: float(axis.points()[0]) for name, axis in own.items()}
    return build_grid(config.at(**known)), own, varied | scattered.keys(), given


def _of_cells(given: Any, section: Goal, names: tuple[str, str], options: Options) -> Cells:
    """Cells as `evaluate` takes them; what is open in them need not be given."""
    between = section.between or {}
    ends = {**section.quiet_over, **{name: between[name] for name in names if name in between}}
    missing = {name: ends[name][1] for name in ends if name in PARAMETERS and name not in given}
    whole = given.assign(missing) if isinstance(given, xr.Dataset) else {**given, **missing}
    return given_cells(whole, options)


def _side(name: str, section: Goal, axis: Range | Values | None, here: Floats, written: str | None) -> Side:
    """A parameter of the plane: over the range of the section, of its axis, or about what panels have."""
    between, spacing, known = (section.between or {}).get(name), None, here[np.isfinite(here)]
    if between is None and axis is not None:
        between = float(np.nanmin(axis.points())), float(np.nanmax(axis.points()))
        spacing = axis.spacing if isinstance(axis, Range) else None
    elif between is None and known.size and known.min() > 0:
        between = float(known.min()) / _WITHIN, float(known.max()) * _WITHIN
    if between is None or not between[0] < between[1]:
        raise ArgumentError("between", f"missing, expected a range of {name}, (low, high)")
    return Side(*between, section.points, spacing or Scan.over(*between, 2).spacing, name, written)
