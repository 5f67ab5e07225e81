"""Checks of what a configuration asks for: maps or rigs, and what its study needs of the rest.

The first part looks at plain data before it is read, the second at what was read.
"""

import math
from collections.abc import Iterator, Mapping
from typing import Any

from stickslip.config.grid import build_grid
from stickslip.config.model import Config
from stickslip.config.problems import ProblemCollector
from stickslip.config.rigs import Drive
from stickslip.config.rules import Finding
from stickslip.config.studies import study_class
from stickslip.errors import Path, Problem
from stickslip.vocabulary.models.lugre import STIFFNESS
from stickslip.vocabulary.quantities import DRIVE, QUANTITIES
from stickslip.vocabulary.results import VARIABLES
from stickslip.vocabulary.studies import EXPLAIN, STUDIES
from stickslip.vocabulary.suggest import listed

RIGID = "none"  # for the stiffness of a contact that sticks without giving way
OF_RIGS = ("drive", "sensor", "features", "risk")  # sections
MOST_TESTS = 100_000  # of a rig
MOST_SAMPLES = 20_000_000  # of one motion: 160 MB a signal
FEWEST_SAMPLES = 16  # of a record
_NARROWEST = 1e-6  # of the rate: bandwidths


# --- maps and rigs, which exclude each other --------------------------------------------------------------------------


def belongs(rig: bool, key: str) -> bool:
    """True if a configuration of a rig, or of a map, may have this key."""
    return key not in (STUDIES if rig else OF_RIGS)


def with_rigid_contact(data: Mapping[str, Any]) -> Mapping[str, Any]:
    """The plain data, without the stiffness of a contact that has none."""
    friction = data.get("friction")
    if not isinstance(friction, dict) or friction.get(STIFFNESS) != RIGID:
        return data
    return {**data, "friction": {name: value for name, value in friction.items() if name != STIFFNESS}}


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


def observed_paths(sections: Mapping[str, Any]) -> list[Path]:
    """The positions of the quantities that the first observation is made at; the others must name them as well."""
    observed = sections.get(EXPLAIN, {}).get("observed")
    first = observed[0] if isinstance(observed, list) and observed else None
    return [(EXPLAIN, "observed", 0, name) for name in first if name in QUANTITIES] if isinstance(first, dict) else []


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


# --- what studies need ------------------------------------------------------------------------------------------------


def check_study(config: Config, problems: ProblemCollector) -> None:
    """Note what is wrong between the section of a study, a drive, or what is kept of a map, and the rest."""
    if config.drive is not None:
        _check_rig(config, problems)
    if config.study is not None:
        study_class(config.study.key).check(config.study, config, problems)
    path, variables = ("output", "variables"), config.output.variables or ()
    if variables and not config.is_map:
        problems.add(path, "given for something else than a map, expected none: only maps can do without variables")
    absent = [name for name in variables if VARIABLES[name].when == "full" and config.solver.early_stop]
    if absent:
        message = f"got {listed(absent, 'and')}, which only a run to a horizon defines"
        problems.add(path, message, "add early_stop: false and a horizon to solver")


def add_finding(problems: ProblemCollector, finding: Finding) -> None:
    """Note a rule that is broken."""
    got = finding.got or problems.text(finding.path)
    problems.add(finding.path, f"got {got}, expected {finding.expected}", finding.hint)


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
