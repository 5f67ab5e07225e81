"""Cells of which one or two parameters are left open, and the ranges in which borders are searched along these."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, replace
from itertools import product
from typing import Annotated, Any, NamedTuple, TypeVar

import numpy as np
import xarray as xr
from pydantic import BeforeValidator, Field, ValidationInfo

from stickslip.config.grid import build_grid
from stickslip.config.model import Axis, Config, Group, Range
from stickslip.config.problems import ProblemCollector
from stickslip.config.rules import Finding, QuantitySpace, findings
from stickslip.config.sections import RANGE, StudySection, interval, one_of
from stickslip.config.studies import Study
from stickslip.dataset.build import given_cells
from stickslip.engine import Options, Results, by_theory
from stickslip.errors import ArgumentError
from stickslip.studies.search import Flags, Floats, GuideAt, Integers, Labels, Scan
from stickslip.vocabulary.cells import Cells, Parameters
from stickslip.vocabulary.models import STRIBECK, model_of
from stickslip.vocabulary.models.memory import BORDER_TOLERANCE
from stickslip.vocabulary.parameter import NAN, Parameter, table
from stickslip.vocabulary.quantities import PARAMETERS, QUANTITIES, REGIMES, SEARCHABLE, UNDECIDED, VIBRATING, listed

AnySearch = TypeVar("AnySearch", bound=StudySection)
CellsOrConfig = Mapping[str, Any] | xr.Dataset | Config
Between = tuple[float, float]
Ranges = Mapping[str, Between | None]
PARAMETER = one_of(SEARCHABLE, "a parameter of a cell")  # of a field of a section


def _range_along(value: object, info: ValidationInfo) -> Between:
    """The range of the parameter `along` of a section, unless that is refused already."""
    return interval(QUANTITIES[info.data["along"]], value) if "along" in info.data else (NAN, NAN)


class OpenSection(StudySection):
    """A section that leaves parameters of cells open: one along lines, two of a plane (y, x)."""

    def ranges(self, given: CellsOrConfig) -> Ranges:
        """These parameters with their ranges; None for that of the axis. Raises ArgumentError."""
        raise NotImplementedError


class LineSection(OpenSection):
    """What studies of lines along a parameter have in common; the other axes are the lines."""

    along: Annotated[str, PARAMETER] = Field(description="parameter of a cell to go along")
    between: Annotated[Between | None, BeforeValidator(_range_along)] = Field(
        None,
        description="both ends of its range, the lower one first; those of the axis unless given",
        json_schema_extra=RANGE,
    )

    def ranges(self, given: CellsOrConfig) -> Ranges:
        """The parameter, with its range."""
        return {self.along: self.between}


class OpenStudy(Study):
    """A study whose section leaves parameters open; its result is drawn over a map of the cells."""

    @classmethod
    def check(cls, section: OpenSection, config: Config, problems: ProblemCollector) -> None:
        """Note lines, or a plane, that cannot be searched."""
        check_lines(section, config, problems)

    @classmethod
    def lines_in(cls, section: OpenSection, config: Config) -> Lines:
        """The lines along each parameter that is left open."""
        return lines_of(config, section.ranges(config))


def by_model(of_curve: float, with_memory: float) -> str:
    """The defaults of a setting that depends on the model, in words."""
    return f"{of_curve:g}, or {with_memory:g} with bristles or rate-and-state friction"


_TOLERANCES = by_model(STRIBECK.border_tolerance, BORDER_TOLERANCE)


def limits(section: str, what: str, *rows: Parameter) -> dict[str, Parameter]:
    """The rows of a section, with those that say how exactly `what` is looked for."""
    return table(
        *rows,
        Parameter(  # neighbouring floating-point numbers are 1e-16 apart
            "tolerance", "1", f"width of the bracket of {what}, over the border; unless given {_TOLERANCES}", section,
            at_least=1e-15, at_most=0.1, absent=_TOLERANCES,
        ),
        Parameter("rtol", "1", "relative tolerance of a step; a hundredth of the tolerance unless given", section,
                  at_least=1e-12, at_most=1e-2, absent="a hundredth of the tolerance"),
    )  # fmt: skip


def fine_enough(section: AnySearch, options: Options) -> tuple[AnySearch, Options]:
    """The section of a search with what it leaves to the model, such as its tolerance; and how to integrate.

    That is at a tolerance that leaves borders their digits, unless the section says another.
    """
    model, given = model_of(options.law), section.resolved()
    tolerance = given.get("tolerance", model.border_tolerance)
    rtol = given.get("rtol", float(np.clip(tolerance / 100, 1e-12, 1e-6)))
    settings = {"tolerance": tolerance, "points": given.get("points", model.contour_points)}
    settings = {name: value for name, value in settings.items() if name in type(section).model_fields}
    return section.model_copy(update=settings), replace(options, rtol=rtol, early_stop=True)


def search_options(options: Options) -> Options:
    """The same for what a search asks of a cell, beyond which nothing is computed (`Options.until`)."""
    return replace(options, early_stop=True, variables=("regime", model_of(options.law).guide, "steps"))


def guide_of(results: Results, options: Options) -> Floats:
    """The guide of computed cells; NaN where linear theory has it and is not what comes of the start."""
    model = model_of(options.law)
    guide = results[model.guide]
    return guide if model.growth is None else uncontradicted(guide, results["regime"])


def decided(regimes: Labels) -> Flags:
    """Return which regimes say what becomes of a motion."""
    return ~np.isin(regimes, UNDECIDED)


def uncontradicted(growth: Floats, regimes: Labels) -> Floats:
    """Rates of growth about steady sliding; NaN where a vibration lasts beside stable sliding, or the reverse."""
    vibrates = np.isin(regimes, [REGIMES.index(name) for name in VIBRATING])
    return np.where(~decided(regimes) | (vibrates == (growth > 0)), growth, np.nan)


def growth_of(cells: Callable[[Integers, Floats], Parameters], options: Options) -> GuideAt | None:
    """The guide where linear theory knows it, from cells by line and place; None where it does not."""
    name = model_of(options.law).growth
    return None if name is None else (lambda line, place: by_theory(name, cells(line, place), options))


@dataclass(frozen=True)
class Side(Scan):
    """A parameter that is left open, in SI; `points` on its range are looked at first, or are a grid.

    written_in : the unit in which it is shown.
    """

    name: str = ""
    written_in: str | None = None

    def at(self, point: Integers, share: Floats) -> Floats:
        """Values a `share` (0 to 1) of the way from grid points to the next ones, by ratio on log spacing."""
        here, there = self.places[point], self.places[np.minimum(point + 1, self.points - 1)]
        if self.spacing == "log":
            return np.asarray(here * (there / here) ** share)
        return np.asarray(here + share * (there - here))

    def scanned(self, count: int) -> Integers:
        """About so many grid points, evenly over the range."""
        return np.unique(np.linspace(0, self.points - 1, min(self.points, count)).round().astype(np.int64))

    def near(self, point: Integers, steps: Floats) -> Floats:
        """Values so many steps of the grid away from grid points, inside the range."""
        place = np.clip(point + steps, 0.0, self.points - 1.0)
        first = np.minimum(place.astype(np.int64), self.points - 2)
        return self.at(first, place - first)


# --- of a configuration -----------------------------------------------------------------------------------------------


class OpenLine(NamedTuple):
    """Lines along one parameter. axis : of the parameter, None if it is fixed. spacing : of that axis where its range
    is searched, else None."""

    axis: Axis | None
    between: Between
    spacing: str | None


Lines = dict[str, OpenLine]  # by parameter; of a plane y and x


def lines_of(config: Config, ranges: Ranges) -> Lines:
    """The lines along parameters; without a range, over that of their axes. Raises ArgumentError."""
    key = "axes" if len(ranges) > 1 else "along"
    return {name: _line_along(config, name, between, key) for name, between in ranges.items()}


def _line_along(config: Config, along: str, between: Between | None, key: str) -> OpenLine:
    if not config.has_cells:
        raise ArgumentError(key, "the configuration has a drive: cells of a rig have no regime to search for")
    if config.uncertain is not None:
        message = "the configuration has uncertain quantities, and a border is that of known ones; leave uncertain out"
        raise ArgumentError(key, message)
    names = {member.name for axis in config.axes for member in axis.members} | set(config.fixed())
    model = model_of(config.friction.law)
    forms = (model.replaced, tuple(model.measured))
    for form, other, whole in zip(forms, reversed(forms), model.forms, strict=False):
        if along in form and names & set(other):
            follows = f"{along} follows from {listed(other, 'and')} in this configuration"
            raise ArgumentError(key, f"{follows}; give the curve by {listed(whole, 'and')} to search along it")
    for axis in config.axes:
        if isinstance(axis, Group) and any(member.name == along for member in axis.members):
            raise ArgumentError(key, f"{along} varies together with others in the axis {axis.name}")
    own = next((axis for axis in config.axes if not isinstance(axis, Group) and axis.name == along), None)
    if between is not None:
        return OpenLine(own, between, None)
    if own is None:
        raise ArgumentError("between", f"missing; {along} is no axis of the configuration, so it needs a range")
    numbers = own.points()[~np.isnan(own.points())]
    if np.unique(numbers).size < 2:
        raise ArgumentError("between", f"missing; the axis {along} has no range, which takes two numbers")
    return OpenLine(own, (float(numbers.min()), float(numbers.max())), own.spacing if isinstance(own, Range) else None)


def broken_rules(config: Config, lines: Lines) -> Iterator[Finding]:
    """Everything that must hold between quantities and does not, somewhere on lines or in a plane.

    The path of what is searched is ("between",), in a plane with the name of the parameter.
    """
    rest = config.without(*lines)
    searched = [
        Range.model_construct(name=name, spacing="linear", start=line.between[0], stop=line.between[1], num=2)
        for name, line in lines.items()
    ]
    for finding in findings(QuantitySpace(rest.fixed(), (*rest.axes, *searched), law=config.friction.law)):
        is_searched = finding.path[0] == "axes" and finding.path[1:2] and finding.path[1] in lines
        between = ("between", *(finding.path[1:2] if len(lines) > 1 else ()))
        yield finding._replace(path=between) if is_searched else finding


def check_lines(section: OpenSection, config: Config, problems: ProblemCollector) -> None:
    """Note what keeps the lines, or the plane, of a section from being searched: they exist, and cells are possible."""
    try:
        ranges = section.ranges(config)
        lines = lines_of(config, ranges)
    except ArgumentError as error:
        problems.add((section.key, error.key), error.what)
        return
    for finding in broken_rules(config, lines):
        path = finding.path
        if path[0] == "between":
            name = str(path[-1]) if len(lines) > 1 else next(iter(lines))
            path = (section.key, *path) if ranges[name] else ("axes", name)
        problems.add_finding(finding._replace(path=path))


# --- lines and planes of cells ----------------------------------------------------------------------------------------


def opened(given: CellsOrConfig, ranges: Ranges, points: int, options: Options) -> tuple[Cells, list[Side]]:
    """Cells of which some parameters are left open, whatever the cells say of these, with so many points along each.

    Without a range, over that of the axis. Cells are checked at the corners of the ranges: bounds that hold there hold
    between, since they are linear. Raises TypeError or ValueError for what cannot be searched.
    """
    if isinstance(given, Config):
        lines = lines_of(given, ranges)
        for rule in broken_rules(given, lines):
            what = f"got {rule.got or 'values'} for which no cell is possible, expected {rule.expected}"
            raise ArgumentError(str(rule.path[-1]), what)
        units = given.written_in
        return build_grid(given.without(*lines)), [
            _side(name, line.between, points, line.spacing, units.get(name)) for name, line in lines.items()
        ]
    sides = []
    for name, between in ranges.items():
        if name not in PARAMETERS:
            others = listed(model_of(options.law).replaced, "and")
            raise ValueError(f"along: {name} is measured of a curve; cells have {others} instead")
        if between is None:
            raise ValueError(f"between: missing; cells need a range of {name} to search, (low, high)")
        sides.append(_side(name, between, points))
    for corner in product(*((side.high, side.low) for side in sides)):
        values = dict(zip(ranges, corner, strict=True))
        if isinstance(given, xr.Dataset):
            complete: Any = given.drop_vars(list(ranges), errors="ignore").assign(values)
        else:
            complete = {**given, **values}
        cells = given_cells(complete, options)
    return cells.without(*ranges), sides


def _side(name: str, between: Between, points: int, spacing: str | None = None, written_in: str | None = None) -> Side:
    return Side(*between, points, spacing or Scan.over(*between, 2).spacing, name, written_in)
