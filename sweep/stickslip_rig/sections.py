"""The sections of a test rig: how its plate moves, how it is read, how its records are evaluated; what must hold of
them beside what must hold of cells, and what results of rigs say of themselves.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from typing import Annotated, Any, NamedTuple

import numpy as np
import xarray as xr
from numpy.typing import NDArray
from pydantic import Field

from stickslip.config.describe import value_text
from stickslip.config.grid import build_grid
from stickslip.config.model import Config
from stickslip.config.problems import ProblemCollector
from stickslip.config.resolve import varied_paths
from stickslip.config.rules import Finding, QuantitySpace, worst_cell
from stickslip.config.sections import BOOLEAN, Section, StudySection, one_of, with_quantities, with_rows
from stickslip.config.studies import Study
from stickslip.errors import Path, Problem
from stickslip.vocabulary.models import ROUNDING
from stickslip_rig.drive import DRIVE, PROFILES
from stickslip_rig.quantities import FEATURE_SETTINGS, RPN_NAME, SENSOR, STROKES

PIECES = 64  # straight pieces of the speed of a sinusoidal stroke
_SINE_MEAN = 1.0 / (PIECES * math.tan(0.5 * math.pi / PIECES))  # of these pieces, over the top speed
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


class _Profile(StudySection):
    key, has_cells = "drive", False
    profile: Annotated[str, one_of(PROFILES)] = Field(
        "trapezoid", description="speed over time: " + ", ".join(PROFILES)
    )


class Drive(with_quantities(with_rows(_Profile, STROKES), "drive")):  # type: ignore[misc]
    """Motion of the belt of a test rig: reciprocating, from standstill, at speeds up to that of the belt (`system`)."""

    def duration(self, quantities: Mapping[str, NDArray[np.float64]]) -> NDArray[np.float64]:
        """Durations of tests from the first stroke on, s. quantities : belt_speed, stroke, ramp and dwell, in SI."""
        stroke = quantities["stroke"] / quantities["belt_speed"]
        once = stroke + quantities["ramp"] if self.profile == "trapezoid" else stroke / _SINE_MEAN
        return np.asarray(self.strokes * (once + quantities["dwell"]))


class Sensor(with_rows(Section, SENSOR)):  # type: ignore[misc]
    """Sensors of a test rig: samples, bandwidth, noise."""


class FeatureSettings(with_rows(Section, FEATURE_SETTINGS)):  # type: ignore[misc]
    """Evaluation of a record: settings of its features."""

    subtract_offset: Annotated[bool, BOOLEAN] = Field(
        default=False, description="whether the median of the acceleration is subtracted as an offset"
    )


class RigSections(NamedTuple):
    """The sections of a rig."""

    drive: Any
    sensor: Any
    features: Any
    risk: Any


def sections_of(config: Config) -> RigSections:
    """The sections of the configuration of a rig. Raises ValueError for one without a drive."""
    if not isinstance(config.study, Drive):
        raise ValueError(f"{config.title}: got a configuration without a drive, expected that of a rig")
    return RigSections(config.study, *(config.beside[key] for key in ("sensor", "features", "risk")))


# --- what must hold ---------------------------------------------------------------------------------------------------


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
        default = float(DRIVE["ramp"].default or 0.0)
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
        from stickslip_rig.commands.rig import report

        return report(ds)

    @classmethod
    def figure(
        cls, ds: xr.Dataset, variable: str | None, select: Mapping[str, Any], title: str | None, look: Any, state: str
    ) -> Any:
        """The heat map of the model RPN; of a feature its map."""
        from stickslip_rig.plots import plot_matrix

        return plot_matrix(ds) if variable is None else None

    @classmethod
    def table(cls, ds: xr.Dataset) -> Any:
        """The features as people read them."""
        from stickslip_rig.evaluation import shown_table

        return shown_table(ds)

    @classmethod
    def page(cls, ds: xr.Dataset, title: str | None) -> str:
        """The page of a result, with all tests on its picture, and what was not integrated to its end."""
        from stickslip.plots.pages import Picture, result_page
        from stickslip_rig.evaluation import unfinished

        caption = ". ".join([RPN_NAME, *unfinished(ds)])
        return result_page(ds, [Picture(caption, cls.figure(ds, None, {}, None, None, ""))], title)
