"""What must hold of the configuration of a rig, beside what must hold of cells."""

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from typing import Any

from stickslip.config.grid import build_grid
from stickslip.config.model import Config
from stickslip.config.problems import ProblemCollector
from stickslip.config.resolve import varied_paths
from stickslip.config.rules import Finding, QuantitySpace, worst_cell
from stickslip.errors import Path, Problem
from stickslip.vocabulary.models import ROUNDING
from stickslip.vocabulary.quantities import QUANTITIES
from stickslip_rig.sections import Drive, sections_of

MOST_TESTS = 100_000
MOST_SAMPLES = 20_000_000  # of one motion: 160 MB a signal
FEWEST_SAMPLES = 16  # of a record
_NARROWEST = 1e-6  # of the rate: bandwidths


def misplaced(data: Mapping[str, Any]) -> Iterator[Problem]:
    """Everything in the plain data of a rig that does not belong there, or is missing."""
    axes = data.get("axes")
    varied = varied_paths(axes if isinstance(axes, dict) else {})
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


def findings(drive: Drive, space: QuantitySpace, given: Mapping[str, Sequence[Path]]) -> Iterator[Finding]:
    """The belt of a rig moves, and reaches its speed within a stroke, if its profile has a ramp."""
    default = float(QUANTITIES["ramp"].default or 0.0)
    if drive.profile == "sine" and "ramp" in given and drive.ramp != default:
        got = "a ramp with the profile sine"
        yield Finding(given["ramp"][0], "none", "the profile trapezoid has one", got)
    fixed = space.fixed if "ramp" in given else {**space.fixed, "ramp": default}
    if drive.profile == "sine":
        fixed = {name: value for name, value in fixed.items() if name != "ramp"}
    space = replace(space, fixed=fixed)
    moving = worst_cell(space, {"belt_speed": -1}, lambda p: p["belt_speed"])
    if moving and moving.margin <= 0:
        yield Finding(moving.paths["belt_speed"], "a speed above 0 m/s, that of the drive", "strokes are reciprocating")
        return
    cell = worst_cell(
        space, {"stroke": -1, "belt_speed": 1, "ramp": 1}, lambda p: p["stroke"] / p["belt_speed"] - p["ramp"]
    )
    if cell and cell.margin < -ROUNDING * cell.values["ramp"]:
        most = cell.values["stroke"] / cell.values["belt_speed"]
        hint = "ramps up and down alone are longer than the stroke"
        yield Finding(
            cell.paths["ramp"], f"at most stroke/belt_speed = {most:.4g} s", hint, f"{cell.values['ramp']:.4g} s"
        )


def check(config: Config, problems: ProblemCollector) -> None:
    """Bandwidths are allowed by the sampling rate, tests are not too many, records neither too long nor too short."""
    drive, sensor, features = sections_of(config)[:3]
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
