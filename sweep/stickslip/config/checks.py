"""Checks of what a configuration asks for: maps or rigs, lines, planes, boxes, starting states, variables.

The first part looks at plain data before it is read, the second builds what studies search, the third notes what is
wrong between the section of a study and the rest.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from typing import Any, NamedTuple

import numpy as np

from stickslip.config.grid import build_grid
from stickslip.config.model import Axis, Config, Group, Range
from stickslip.config.problems import ProblemCollector
from stickslip.config.rigs import Drive
from stickslip.config.rules import Finding, Space, findings
from stickslip.config.studies import STUDIES, Refine
from stickslip.errors import ArgumentError, Path, Problem, QuantityError
from stickslip.vocabulary.models import model_of
from stickslip.vocabulary.quantities import DRIVE, QUANTITIES
from stickslip.vocabulary.results import VARIABLES
from stickslip.vocabulary.suggest import listed

OF_RIGS = ("drive", "sensor", "features", "risk")  # sections
STATES_IN_BOX = "expected no axis: the starting states are those of the box (attractors)"
MOST_TESTS = 100_000  # of a rig
MOST_SAMPLES = 20_000_000  # of one motion: 160 MB a signal
FEWEST_SAMPLES = 16  # of a record
_NARROWEST = 1e-6  # of the rate: bandwidths
_MOST_IN_BOX = 18  # a box has at most about 2^18 cells: tiles of several boxes a side must fit into memory

Between = tuple[float, float]
Ends = tuple[float | str, float | str]  # in SI, or texts with units


# --- maps and rigs, which exclude each other --------------------------------------------------------------------------


def belongs(rig: bool, name: str) -> bool:
    """True if a configuration of a rig, or of a map, may have a section, or a quantity, of this name."""
    return name not in STUDIES if rig else not (name in OF_RIGS or name in DRIVE)


def misplaced(rig: bool, data: Mapping[str, Any]) -> Iterator[Problem]:
    """Everything in the plain data of a rig, or of a map, that does not belong there, or is missing."""
    axes = data.get("axes")
    varied = varied_paths(axes if isinstance(axes, dict) else {})
    if not rig:
        for key in OF_RIGS:
            if key in data:
                yield Problem((key,), f"expected no {key} in a map", hint="stickslip rig computes rigs")
        for path in varied:
            if path[-1] in DRIVE:
                yield Problem(path, f"{path[-1]} belongs to the drive of a rig", hint="stickslip rig has one")
        return
    velocities = [path for path in varied if path[-1] == "velocity"]
    if _given(data, "start", "velocity") not in (None, "sticking"):
        velocities = [("start", "velocity")]
    for path in velocities:
        yield Problem(path, "expected none: a rig starts sticking")
    allowed: tuple[object, ...]
    for path, message, allowed in (
        (("solver", "horizon"), "expected none: a test ends with its drive", (None,)),
        (("solver", "early_stop"), "expected none: a test ends with its drive", (None, True)),
        (("execution", "dask"), "expected none: tests are computed by threads of this process", (None,)),
    ):
        if _given(data, *path) not in allowed:
            yield Problem(path, message)
    if "drive" not in data:
        message = "missing, expected what moves the plate: drive: {stroke: 10 mm}"
        yield Problem(("drive",), message, hint="without a drive it is a map, which stickslip run computes")


def _given(data: Mapping[str, Any], *path: str | int) -> object:
    value: Any = data
    for key in path:
        value = value.get(key) if isinstance(value, dict) else None
    return value


def varied_paths(axes: Mapping[str, Any]) -> list[Path]:
    """The positions of the quantities along axes, whether they are right or wrong."""
    paths: list[Path] = []
    for name, axis in axes.items():
        zipped = axis.get("zip") if isinstance(axis, dict) else None
        if isinstance(zipped, dict):
            paths += [("axes", name, "zip", member) for member in zipped if member in QUANTITIES]
        elif name in QUANTITIES:
            paths.append(("axes", name))
    return paths


def ramp_of_no_use(drive: Drive, given: Mapping[str, list[Path]]) -> Problem | None:
    """A ramp that the profile does not have."""
    if drive.profile != "sine" or "ramp" not in given or drive.ramp == QUANTITIES["ramp"].default:
        return None
    message = "got a ramp with the profile sine, expected none"
    return Problem(given["ramp"][0], message, hint="the profile trapezoid has one")


def with_ramp(fixed: Mapping[str, float], drive: Drive, is_given: bool) -> dict[str, float]:
    """The quantities of a rig with the ramp that holds where none is given; without one where the profile has none."""
    default = {} if is_given else {"ramp": float(QUANTITIES["ramp"].default or 0.0)}
    return {name: value for name, value in {**fixed, **default}.items() if name != "ramp" or drive.profile != "sine"}


# --- lines and planes -------------------------------------------------------------------------------------------------


class Line(NamedTuple):
    """Lines along one parameter. axis : of the parameter, None if it is fixed. spacing : of that axis where its range
    is searched, else None."""

    axis: Axis | None
    between: Between
    spacing: str | None


Plane = dict[str, Line]  # by parameter, y and x


def line_along(config: Config, along: str, between: Between | None) -> Line:
    """The lines along a parameter; without a range, over that of its axis. Raises TypeError or ArgumentError."""
    if config.drive is not None:
        raise ArgumentError("along", "the configuration has a drive: cells of a rig have no regime to search for")
    if config.uncertain is not None:
        message = "the configuration has uncertain quantities, and a border is that of known ones; leave uncertain out"
        raise ArgumentError("along", message)
    names = {member.name for axis in config.axes for member in axis.members} | set(config.fixed())
    model = model_of(config.friction.law)
    forms = (model.replaced, tuple(model.measured))
    for form, other, whole in zip(forms, reversed(forms), model.forms, strict=False):
        if along in form and names & set(other):
            follows = f"{along} follows from {listed(other, 'and')} in this configuration"
            raise ArgumentError("along", f"{follows}; give the curve by {listed(whole, 'and')} to search along it")
    for axis in config.axes:
        if isinstance(axis, Group) and any(member.name == along for member in axis.members):
            raise ArgumentError("along", f"{along} varies together with others in the axis {axis.name}")
    own = next((axis for axis in config.axes if not isinstance(axis, Group) and axis.name == along), None)
    if between is not None:
        return Line(own, checked_range(along, between), None)
    if own is None:
        raise ArgumentError("between", f"missing; {along} is no axis of the configuration, so it needs a range")
    numbers = own.points()[~np.isnan(own.points())]
    ends = (float(numbers.min()), float(numbers.max())) if numbers.size else (np.nan, np.nan)
    return Line(own, checked_range(along, ends), own.spacing if isinstance(own, Range) else None)


def plane_along(config: Config, axes: tuple[str, str] | None, between: Mapping[str, Between]) -> Plane:
    """The plane over two parameters, y and x; the last two axes unless named. Raises TypeError or ArgumentError."""
    if axes is None:
        names = [axis.name for axis in config.axes[-2:] if not isinstance(axis, Group)]
        if len(names) < 2:
            message = "missing; the last two axes of the configuration are not two single parameters"
            raise ArgumentError("axes", message)
        axes = names[0], names[1]
    plane = {}
    for name in two_parameters(axes, between):
        try:
            plane[name] = line_along(config, name, between.get(name))
        except ArgumentError as error:
            raise ArgumentError("axes" if error.key == "along" else error.key, error.what) from None
    return plane


def two_parameters(axes: tuple[str, str], between: Mapping[str, Between]) -> tuple[str, str]:
    """Both names, once they are two; every range belongs to one of them. Raises ArgumentError."""
    if isinstance(axes, str) or len(axes) != 2 or axes[0] == axes[1]:
        raise ArgumentError("axes", f"got {axes!r}, expected the names of two different parameters, (y, x)")
    for name in between:
        if name not in axes:
            raise ArgumentError("between", f"got a range for {name!r}, expected {axes[0]} or {axes[1]}")
    return axes[0], axes[1]


def in_si(along: str, between: Ends) -> Between:
    """Both ends with texts read, as numbers in SI; whatever is no text is left to `checked_range`.

    Raises ArgumentError.
    """
    if along not in QUANTITIES or not isinstance(between, tuple | list):
        return between  # type: ignore[return-value]
    try:
        return tuple(QUANTITIES[along].read(end) if isinstance(end, str) else end for end in between)  # type: ignore[return-value]
    except QuantityError as error:
        raise ArgumentError("between", f"got {between!r} for {along}, {error}") from None


def checked_range(along: str, between: Between) -> Between:
    """Both ends as numbers, in order and within the bounds of the parameter. Raises TypeError or ArgumentError."""
    try:
        low, high = (float(end) for end in between)
    except (TypeError, ValueError):
        raise TypeError(f"between: got {between!r}, expected two numbers (low, high)") from None
    row = QUANTITIES[along]
    for word, end in (("lower", low), ("upper", high)):
        if not (np.isfinite(end) and row.allows(end)):
            expected = row.expected.removesuffix(row.otherwise)
            raise ArgumentError("between", f"got {end:g} as {word} end of {along}, expected {expected}")
    if not low < high:
        hint = "; swap the ends" if low > high else ""
        message = f"got {low:g} to {high:g}, expected the lower end first and the upper above it{hint}"
        raise ArgumentError("between", message)
    return low, high


def broken_rules(config: Config, lines: Plane) -> Iterator[Finding]:
    """Everything that must hold between quantities and does not, somewhere on lines or in a plane."""
    rest = config.without(*lines)
    searched = [
        Range.model_construct(name=name, spacing="linear", start=line.between[0], stop=line.between[1], num=2)
        for name, line in lines.items()
    ]
    for finding in findings(Space(rest.fixed(), (*rest.axes, *searched), law=config.friction.law)):
        is_searched = finding.path[0] == "axes" and finding.path[1:2] and finding.path[1] in lines
        between = ("border", "between") if len(lines) == 1 else ("contours", "between", *finding.path[1:2])
        yield finding._replace(path=between) if is_searched else finding


# --- what studies need ------------------------------------------------------------------------------------------------


def refined_axes(axes: Sequence[Axis], depth: int) -> tuple[int, ...]:
    """The positions of the axes along which boxes extend: ranges of at least the points that a box has on a side.

    Along the others (lists, groups, short ranges) every point is a map of its own.
    """
    return tuple(i for i, axis in enumerate(axes) if isinstance(axis, Range) and axis.size > 2**depth)


def state_axes(config: Config) -> Iterator[Path]:
    """The axes along which a starting state varies."""
    for axis in config.axes:
        for member in axis.members:
            if member.name in ("displacement", "velocity"):
                yield ("axes", axis.name, "zip", member.name) if isinstance(axis, Group) else ("axes", axis.name)


def check_study(config: Config, problems: ProblemCollector) -> None:
    """Note what is wrong between a section that asks for something else than a map, and the rest."""
    if config.drive is not None:
        _check_rig(config, problems)
    if config.border is not None or config.contours is not None:
        _check_lines(config, problems)
    for path in state_axes(config) if config.attractors else ():
        problems.add(path, STATES_IN_BOX, at_key=True)
    for finding in _broken_boxes(config.axes, config.refine) if config.refine else ():
        add_finding(problems, finding, at_key=bool(finding.got))
    path, variables = ("output", "variables"), config.output.variables or ()
    if variables and not config.is_map:
        problems.add(path, "given for something else than a map, expected none: only maps can do without variables")
    absent = [name for name in variables if VARIABLES[name].when == "full" and config.solver.early_stop]
    if absent:
        message = f"got {listed(absent, 'and')}, which only a run to a horizon defines"
        problems.add(path, message, "add early_stop: false and a horizon to solver")


def add_finding(problems: ProblemCollector, finding: Finding, hint: str | None = None, at_key: bool = False) -> None:
    """Note a rule that is broken."""
    got = finding.got or problems.text(finding.path)
    problems.add(finding.path, f"got {got}, expected {finding.expected}", hint or finding.hint, at_key)


def _check_lines(config: Config, problems: ProblemCollector) -> None:
    """The lines or the plane that is searched for borders exist, and cells there are possible."""
    border, contours = config.border, config.contours
    try:
        if border is not None:
            lines = {border.along: line_along(config, border.along, border.between)}
        else:
            assert contours is not None
            lines = plane_along(config, contours.axes, contours.between or {})
    except ArgumentError as error:
        problems.add(("border" if border is not None else "contours", error.key), error.what)
        return
    for finding in broken_rules(config, lines):
        path = finding.path
        if contours is not None and path[0] == "contours" and path[-1] not in (contours.between or {}):
            path = ("axes", path[-1])  # whose range is searched
        add_finding(problems, finding._replace(path=path))


def _broken_boxes(axes: Sequence[Axis], refine: Refine) -> Iterator[Finding]:
    """Everything that does not fit between a refinement and the axes."""
    dims = refined_axes(axes, refine.depth)
    ranges = {axis.name: axis.size for axis in axes if isinstance(axis, Range)}
    if not ranges:
        hint = "a list of values has nothing between them; leave refine out to compute every cell"
        yield Finding(("refine",), "an axis with start, stop and num", hint, "no range among the axes")
    elif not dims:
        name = max(ranges, key=lambda name: ranges[name])
        hint = f"boxes have 2^depth + 1 points a side, and the longest range, {name}, has {ranges[name]}"
        yield Finding(("refine", "depth"), f"at most {(ranges[name] - 1).bit_length() - 1}", hint)
    elif refine.depth * len(dims) > _MOST_IN_BOX:
        hint = f"boxes would have 2^{refine.depth * len(dims)} cells in {len(dims)} dimensions"
        yield Finding(("refine", "depth"), f"at most {_MOST_IN_BOX // len(dims)}", hint)


def _check_rig(config: Config, problems: ProblemCollector) -> None:
    """Bandwidths are allowed by the sampling rate, tests are not too many, records neither too long nor too short."""
    drive, sensor, features = config.drive, config.sensor, config.features
    assert drive is not None and sensor is not None and features is not None
    least, most = _NARROWEST * sensor.rate, 0.5 * sensor.rate
    for section, bandwidth in (("sensor", sensor.bandwidth), ("features", features.bandwidth)):
        if bandwidth is not None and bandwidth < least:
            message = f"got {bandwidth:g} Hz, expected at least {least:g} Hz, a millionth of the rate of the sensor"
            problems.add((section, "bandwidth"), message, "below, rounding takes over in the filter")
        if bandwidth is not None and not bandwidth < most:
            message = f"got {bandwidth:g} Hz, expected less than half the rate of the sensor, {most:g} Hz"
            problems.add((section, "bandwidth"), message, "leave it out, or raise the rate")
    tests = build_grid(config)
    if tests.size > MOST_TESTS:
        message = f"got {tests.size:,} tests, expected at most {MOST_TESTS:,}"
        problems.add(("axes",), message, "use fewer points, or fewer axes")
        return
    durations = drive.duration(tests[:])
    longest, shortest = float(durations.max()), float(durations.min())
    fine = sensor.rate * sensor.oversampling
    if (samples := longest * fine) > MOST_SAMPLES:
        got = f"the longest test ({longest:.4g} s) takes {samples:.3g} samples, {sensor.oversampling} for one recorded"
        message = f"{got}, expected at most {MOST_SAMPLES:.0e}"
        problems.add(("sensor", "rate"), message, "lower the rate, the oversampling or the strokes")
    if (fewest := math.ceil((math.ceil(shortest * fine - 1e-6) - 1) / sensor.oversampling)) < FEWEST_SAMPLES:
        got = f"the shortest test ({shortest:.4g} s) has {fewest} samples"
        problems.add(("sensor", "rate"), f"{got}, expected at least {FEWEST_SAMPLES}", "raise the rate")
