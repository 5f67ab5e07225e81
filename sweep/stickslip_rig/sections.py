"""The sections of a test rig: how its plate moves, how it is read, how its records are evaluated."""

import math
from collections.abc import Mapping
from typing import Annotated, Any, NamedTuple

import numpy as np
from numpy.typing import NDArray
from pydantic import Field

from stickslip.config.model import Config
from stickslip.config.sections import BOOLEAN, Section, StudySection, one_of, with_quantities, with_rows
from stickslip_rig.drive import PROFILES
from stickslip_rig.vocabulary import FEATURE_SETTINGS, SENSOR, STROKES

PIECES = 64  # straight pieces of the speed of a sinusoidal stroke
_SINE_MEAN = 1.0 / (PIECES * math.tan(0.5 * math.pi / PIECES))  # of these pieces, over the top speed


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
