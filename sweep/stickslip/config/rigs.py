"""The sections of a test rig: how its plate moves, how it is read, how its records are evaluated."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Annotated

import numpy as np
from numpy.typing import NDArray
from pydantic import Field

from stickslip.config.sections import BOOLEAN, Section, of_row, one_of, with_quantities
from stickslip.vocabulary.quantities import PROFILES
from stickslip.vocabulary.settings import FEATURE_SETTINGS, SENSOR, STROKES

PIECES = 64  # straight pieces of the speed of a sinusoidal stroke
_SINE_MEAN = 1.0 / (PIECES * math.tan(0.5 * math.pi / PIECES))  # of these pieces, over the top speed


class _Profile(Section):
    rows = STROKES
    profile: Annotated[str, one_of(PROFILES)] = Field(
        "trapezoid", description="speed over time: " + ", ".join(PROFILES)
    )
    strokes: int = of_row(STROKES["strokes"])


class Drive(with_quantities(_Profile, "drive")):  # type: ignore[misc]
    """How the belt of a test rig moves: reciprocating, from standstill, at speeds up to that of the belt (`system`)."""

    def duration(self, quantities: Mapping[str, NDArray[np.float64]]) -> NDArray[np.float64]:
        """Durations of tests from the first stroke on, s. quantities : belt_speed, stroke, ramp and dwell, in SI."""
        stroke = quantities["stroke"] / quantities["belt_speed"]
        once = stroke + quantities["ramp"] if self.profile == "trapezoid" else stroke / _SINE_MEAN
        return np.asarray(self.strokes * (once + quantities["dwell"]))


class Sensor(Section):
    """How a test rig is read: samples, bandwidth, noise."""

    rows = SENSOR
    rate: float = of_row(SENSOR["rate"])
    bandwidth: float | None = of_row(SENSOR["bandwidth"])
    force_noise: float = of_row(SENSOR["force_noise"])
    acceleration_noise: float = of_row(SENSOR["acceleration_noise"])
    seed: int = of_row(SENSOR["seed"])
    oversampling: int = of_row(SENSOR["oversampling"])


class FeatureSettings(Section):
    """How the features of a record are read."""

    rows = FEATURE_SETTINGS
    bandwidth: float | None = of_row(FEATURE_SETTINGS["bandwidth"])
    smallest_drop: float | None = of_row(FEATURE_SETTINGS["smallest_drop"])
    window: float | None = of_row(FEATURE_SETTINGS["window"])
    tolerance: float = of_row(FEATURE_SETTINGS["tolerance"])
    subtract_offset: Annotated[bool, BOOLEAN] = Field(
        default=False, description="whether the median of the acceleration is subtracted as an offset"
    )
