"""The configuration of a simulated rig: that of a map with a drive and sensors, and how records are evaluated."""

from __future__ import annotations

import json
import math
import os
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass, replace
from typing import Any

from stickslip.config.examples import existing_config
from stickslip.config.grid import build_grid
from stickslip.config.model import Config
from stickslip.config.overrides import Setting, overridden
from stickslip.config.python import python_document
from stickslip.config.reader import read_document
from stickslip.config.sections import Drive, Sensor
from stickslip.config.unit_warnings import warn_of_units
from stickslip.config.yaml import Document, parse_yaml, read_yaml
from stickslip.errors import ConfigError, Problem
from stickslip.rig.apparatus import duration
from stickslip.rig.records import FEWEST_SAMPLES
from stickslip.rig.rpn import Risk
from stickslip.rig.settings import FeatureSettings, read_settings

_NARROWEST = 1e-6  # of the rate: bandwidths
MOST_TESTS = 100_000
MOST_SAMPLES = 20_000_000  # of one motion: 160 MB a signal
_EVALUATION = ("features", "risk")  # sections that are about records, measured or simulated


@dataclass(frozen=True)
class RigConfig:
    """A test matrix: `config` has a drive. features, risk : as for measured records."""

    config: Config
    features: FeatureSettings
    risk: Risk

    @property
    def drive(self) -> Drive:
        """The drive, which every rig has."""
        assert self.config.drive is not None
        return self.config.drive

    @property
    def sensor(self) -> Sensor:
        """The sensors; the default ones where the configuration says nothing."""
        return self.config.sensor or Sensor()

    def to_yaml(self) -> str:
        """Everything, as text that gives it again."""
        sections = self.config.resolved() | {"features": self.features.known, "risk": self.risk.known}
        return json.dumps(sections, indent=2, ensure_ascii=False) + "\n"  # which YAML contains


def load_rig(path: str | os.PathLike[str] | Mapping[str, Any], settings: Iterable[Setting] = ()) -> RigConfig:
    """Load the configuration of a simulated rig, and warn of numbers whose unit was forgotten.

    Parameters
    ----------
    path
        A YAML file, the name of one of the package, or what such a file would say as a mapping.
    settings
        Of a command line, which are put into the file.

    Raises
    ------
    ConfigError
        With everything that is wrong.
    """
    document = python_document(path) if isinstance(path, Mapping) else read_yaml(existing_config(path))
    document = overridden(document, settings)
    rig = _read(document)
    warn_of_units(document, rig.config)
    return rig


def is_rig(path: str | os.PathLike[str]) -> bool:
    """True if a YAML file is that of a rig: whether it has a drive. Raises ConfigError if it cannot be read."""
    data = read_yaml(existing_config(path)).data
    return isinstance(data, dict) and "drive" in data


def parse_rig(text: str, name: str = "<text>") -> RigConfig:
    """The rig in a YAML text. Raises ConfigError."""
    return _read(parse_yaml(text, name))


def make_rig(data: Mapping[str, Any], name: str = "<data>") -> RigConfig:
    """The rig in mappings shaped like the YAML. Raises ConfigError."""
    return _read(python_document(data, name))


def _read(document: Document) -> RigConfig:
    data = document.data if isinstance(document.data, dict) else {}
    evaluation = {key: data[key] for key in _EVALUATION if key in data}
    problems: list[Problem] = []
    try:
        config = read_document(document, rig=True, others=_EVALUATION)
    except ConfigError as error:
        problems += error.problems
    try:
        settings = read_settings(replace(document, data=evaluation, problems=[]))
    except ConfigError as error:
        problems += error.problems
    if problems:
        raise ConfigError(document.name, problems)
    rig = RigConfig(config, settings.features, settings.risk)
    drive = document.keys.get(("drive",))  # the place of what is not mentioned
    problems += (replace(p, place=document.values.get(p.path) or drive) for p in (*_bandwidths(rig), *_lengths(rig)))
    if problems:
        raise ConfigError(document.name, problems)
    return rig


def _bandwidths(rig: RigConfig) -> Iterator[Problem]:
    """Bandwidths that the sampling rate does not allow."""
    least, most = _NARROWEST * rig.sensor.rate, 0.5 * rig.sensor.rate
    for section, bandwidth in (("sensor", rig.sensor.bandwidth), ("features", rig.features.bandwidth)):
        if bandwidth is not None and bandwidth < least:
            message = f"got {bandwidth:g} Hz, expected at least {least:g} Hz, a millionth of the rate of the sensor"
            yield Problem((section, "bandwidth"), message, hint="below, rounding takes over in the filter")
        if bandwidth is not None and not bandwidth < most:
            message = f"got {bandwidth:g} Hz, expected less than half the rate of the sensor, {most:g} Hz"
            yield Problem((section, "bandwidth"), message, hint="leave it out, or raise the rate")


def _lengths(rig: RigConfig) -> Iterator[Problem]:
    """Too many tests, or records too long to be computed or too short to be evaluated."""
    grid, sensor = build_grid(rig.config), rig.sensor
    if grid.size > MOST_TESTS:
        message = f"got {grid.size:,} tests, expected at most {MOST_TESTS:,}"
        yield Problem(("axes",), message, hint="use fewer points, or fewer axes")
        return
    durations = duration(rig.drive.profile, rig.drive.strokes, grid[:])
    longest, shortest = float(durations.max()), float(durations.min())
    fine = sensor.rate * sensor.oversampling
    if (samples := longest * fine) > MOST_SAMPLES:
        got = f"the longest test ({longest:.4g} s) takes {samples:.3g} samples, {sensor.oversampling} for one recorded"
        message = f"{got}, expected at most {MOST_SAMPLES:.0e}"
        yield Problem(("sensor", "rate"), message, hint="lower the rate, the oversampling or the strokes")
    if (fewest := math.ceil((math.ceil(shortest * fine - 1e-6) - 1) / sensor.oversampling)) < FEWEST_SAMPLES:
        got = f"the shortest test ({shortest:.4g} s) has {fewest} samples"
        yield Problem(("sensor", "rate"), f"{got}, expected at least {FEWEST_SAMPLES}", hint="raise the rate")
