"""What must hold of the configuration of a rig, beside what must hold of cells; what its results say of themselves."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from typing import Any

import xarray as xr

from stickslip.config.describe import value_text
from stickslip.config.grid import build_grid
from stickslip.config.model import Config
from stickslip.config.problems import ProblemCollector
from stickslip.config.resolve import varied_paths
from stickslip.config.rules import Finding, QuantitySpace, worst_cell
from stickslip.config.studies import Study
from stickslip.errors import Path, PlotError, Problem
from stickslip.vocabulary.models import ROUNDING
from stickslip.vocabulary.quantities import QUANTITIES
from stickslip_rig.sections import Drive, sections_of
from stickslip_rig.vocabulary import SENSOR

MOST_TESTS = 100_000
MOST_SAMPLES = 20_000_000  # of one motion: 160 MB a signal
FEWEST_SAMPLES = 16  # of a record
_NARROWEST = 1e-6  # of the rate: bandwidths
_ENDS = "a test ends with its drive"
_NOT_OF_RIGS = {  # by place in the file: why it is not of a rig, and what may stand there
    ("start", "velocity"): ("a rig starts sticking", (None, "sticking")),
    ("solver", "horizon"): (_ENDS, (None,)),
    ("solver", "early_stop"): (_ENDS, (None, True)),
    ("execution", "dask"): ("tests are computed by threads of this process", (None,)),
}


class RigStudy(Study):
    """What a study of rig tests says without computing any."""

    section = Drive

    @classmethod
    def misplaced(cls, data: Mapping[str, Any]) -> Iterator[Problem]:
        """Everything in the plain data of a rig that does not belong there, or is missing."""
        axes = data.get("axes")
        for path in varied_paths(axes if isinstance(axes, dict) else {}):
            if path[-1] == "velocity":
                yield Problem(path, "expected none: a rig starts sticking")
        for (key, name), (reason, allowed) in _NOT_OF_RIGS.items():
            section = data.get(key)
            if isinstance(section, dict) and section.get(name) not in allowed:
                yield Problem((key, name), f"expected none: {reason}")
        if "drive" not in data:
            message = "missing, expected what moves the plate: drive: {stroke: 10 mm}"
            yield Problem(("drive",), message, hint="without a drive it is a map, which stickslip run computes")

    @classmethod
    def rules(cls, section: Drive, space: QuantitySpace, given: Mapping[str, Sequence[Path]]) -> Iterator[Finding]:
        """The belt of a rig moves, and reaches its speed within a stroke, if its profile has a ramp."""
        default = float(QUANTITIES["ramp"].default or 0.0)
        is_sine = section.profile == "sine"
        if is_sine and "ramp" in given and section.ramp != default:
            got = "a ramp with the profile sine"
            yield Finding(given["ramp"][0], "none", "the profile trapezoid has one", got)
        fixed = space.fixed if "ramp" in given else {**space.fixed, "ramp": default}
        space = replace(space, fixed={name: v for name, v in fixed.items() if not (is_sine and name == "ramp")})
        moving = worst_cell(space, {"belt_speed": -1}, lambda p: p["belt_speed"])
        if moving and moving.margin <= 0:
            yield Finding(
                moving.paths["belt_speed"], "a speed above 0 m/s, that of the drive", "strokes are reciprocating"
            )
            return
        ways = {"stroke": -1, "belt_speed": 1, "ramp": 1}
        cell = worst_cell(space, ways, lambda p: p["stroke"] / p["belt_speed"] - p["ramp"])
        if cell and cell.margin < -ROUNDING * cell.values["ramp"]:
            most = f"at most stroke/belt_speed = {cell.values['stroke'] / cell.values['belt_speed']:.4g} s"
            hint = "ramps up and down alone are longer than the stroke"
            yield Finding(cell.paths["ramp"], most, hint, f"{cell.values['ramp']:.4g} s")

    @classmethod
    def check(cls, section: Drive, config: Config, problems: ProblemCollector) -> None:
        """Bandwidths are allowed by the sampling rate, tests not too many, records neither too long nor too short."""
        _, sensor, features, _ = sections_of(config)
        least, most = _NARROWEST * sensor.rate, 0.5 * sensor.rate
        for key, bandwidth in (("sensor", sensor.bandwidth), ("features", features.bandwidth)):
            if bandwidth is not None and not least <= bandwidth < most:
                limit, end = ("at least a millionth of", least) if bandwidth < least else ("less than half", most)
                message = f"got {bandwidth:g} Hz, expected {limit} the rate of the sensor, {end:g} Hz"
                problems.add((key, "bandwidth"), message, "leave it out, or change the rate")
        tests = build_grid(config)
        if tests.size > MOST_TESTS:
            message = f"got {tests.size:,} tests, expected at most {MOST_TESTS:,}"
            return problems.add(("axes",), message, "use fewer points, or fewer axes")
        durations = section.duration(tests[:])
        longest, shortest = float(durations.max()), float(durations.min())
        fine = sensor.rate * sensor.oversampling
        if (samples := longest * fine) > MOST_SAMPLES:
            got = f"the longest test ({longest:.4g} s) takes {samples:.3g} samples"
            message = f"{got}, {sensor.oversampling} for one recorded, expected at most {MOST_SAMPLES:.0e}"
            problems.add(("sensor", "rate"), message, "lower the rate, the oversampling or the strokes")
        if (fewest := math.ceil((math.ceil(shortest * fine - 1e-6) - 1) / sensor.oversampling)) < FEWEST_SAMPLES:
            got = f"the shortest test ({shortest:.4g} s) has {fewest} samples"
            problems.add(("sensor", "rate"), f"{got}, expected at least {FEWEST_SAMPLES}", "raise the rate")

    @classmethod
    def explain(cls, section: Drive, config: Config) -> Iterator[tuple[str, str, str]]:
        """The strokes, and the sensors."""
        yield "drive", f"{section.strokes} strokes, {section.profile}", "strokes, and speed over time"
        for name, row in SENSOR.items():
            value = getattr(sections_of(config).sensor, name)
            yield name, "none" if value is None else value_text(value, row), row.long_name

    @classmethod
    def report(cls, ds: xr.Dataset) -> Iterator[Any]:
        """The features, and what to mind of them."""
        from stickslip_rig.commands.features import report

        return report(ds)

    @classmethod
    def is_drawn(cls, ds: xr.Dataset) -> bool:
        """Never by itself: the commands of rigs draw tests."""
        return False

    @classmethod
    def figure(
        cls, ds: xr.Dataset, variable: str | None, select: Mapping[str, Any], title: str | None, look: Any, state: str
    ) -> Any:
        """None. Raises PlotError."""
        raise PlotError("features of rig tests, no map: `stickslip rig run CONFIG --plot PICTURE` draws them, --report "
                        "makes a page; of records, `stickslip rig features FILES --plot PICTURE`")  # fmt: skip
