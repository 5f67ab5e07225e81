"""The configuration of a simulated rig: that of a map with a drive and sensors, and how records are judged."""

from __future__ import annotations

import json
import math
import os
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import asdict, dataclass, replace
from typing import Any

from stickslip.config.examples import existing_config
from stickslip.config.grid import build_grid
from stickslip.config.model import Config
from stickslip.config.overrides import Setting, overridden
from stickslip.config.python import python_document
from stickslip.config.reader import read_rig_config
from stickslip.config.sections import Drive, Sensor
from stickslip.config.unit_warnings import warn_of_units
from stickslip.config.yaml import Document, parse_yaml, read_yaml
from stickslip.errors import ConfigError, Place, Problem
from stickslip.rig.records.record import FEWEST_SAMPLES
from stickslip.rig.risk import Risk
from stickslip.rig.settings import FeatureSettings, Settings, read_settings
from stickslip.rig.simulate.drive import duration

_NARROWEST = 1e-6  # of the rate: bandwidths
MOST_TESTS = 100_000
MOST_SAMPLES = 20_000_000  # of one motion: 160 MB a signal
_JUDGED = ("features", "risk")  # sections that are about records, measured or simulated


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

    @property
    def settings(self) -> Settings:
        """How records are judged."""
        return Settings(features=self.features, risk=self.risk)

    def to_yaml(self) -> str:
        """Everything, as text that gives it again."""
        features = {name: value for name, value in asdict(self.features).items() if value is not None}
        judged = {"features": features, "risk": self.risk.known}
        return json.dumps(self.config.resolved() | judged, indent=2, ensure_ascii=False) + "\n"  # which YAML contains


def load_rig(path: str | os.PathLike[str] | Mapping[str, Any], settings: Iterable[Setting] = ()) -> RigConfig:
    """The rig in a YAML file, or the one of the package that `path` calls (`examples.existing_config`); or what such a
    file would say as a mapping (see `config.reader.load_config`).

    settings : of a command line, which are put into the file.
    Raises ConfigError, which lists everything that is wrong with it, and warns of numbers whose unit was forgotten.
    """
    document = python_document(path) if isinstance(path, Mapping) else read_yaml(existing_config(path))
    document = overridden(document, settings)
    rig = _read(document)
    warn_of_units(document, rig.config)
    return rig


def is_rig(path: str | os.PathLike[str]) -> bool:
    """Whether a YAML file is that of a rig: whether it has a drive. Raises ConfigError if it cannot be read."""
    data = read_yaml(existing_config(path)).data
    return isinstance(data, dict) and "drive" in data


def parse_rig(text: str, name: str = "<text>") -> RigConfig:
    """The rig in a YAML text. Raises ConfigError."""
    return _read(parse_yaml(text, name))


def make_rig(data: Mapping[str, Any], name: str = "<data>") -> RigConfig:
    """The rig in mappings shaped like the YAML. Raises ConfigError."""
    return _read(python_document(data, name))


def _read(document: Document) -> RigConfig:
    problems: list[Problem] = []
    try:
        config = read_rig_config(document, _JUDGED)
    except ConfigError as error:
        problems += error.problems
    try:
        settings = read_settings(_part(document))
    except ConfigError as error:
        problems += error.problems
    if problems:
        raise ConfigError(document.name, problems)
    rig = RigConfig(config, settings.features, settings.risk)
    if problems := [replace(p, place=_place(document, p)) for p in (*_bandwidths(rig), *_lengths(rig))]:
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
    """Too many tests, or records too long to be computed or too short to be judged."""
    grid, sensor = build_grid(rig.config), rig.sensor
    if grid.size > MOST_TESTS:
        message = f"got {grid.size:,} tests, expected at most {MOST_TESTS:,}"
        yield Problem(("axes",), message, hint="use fewer points, or fewer axes")
        return
    durations = duration(rig.drive.profile, rig.drive.strokes, grid.cells(0, grid.size))
    longest, shortest = float(durations.max()), float(durations.min())
    fine = sensor.rate * sensor.oversampling
    if (samples := longest * fine) > MOST_SAMPLES:
        got = f"the longest test ({longest:.4g} s) takes {samples:.3g} samples, {sensor.oversampling} for one kept"
        message = f"{got}, expected at most {MOST_SAMPLES:.0e}"
        yield Problem(("sensor", "rate"), message, hint="lower the rate, the oversampling or the strokes")
    if (kept := math.ceil((math.ceil(shortest * fine - 1e-6) - 1) / sensor.oversampling)) < FEWEST_SAMPLES:
        got = f"the shortest test ({shortest:.4g} s) has {kept} samples"
        yield Problem(("sensor", "rate"), f"{got}, expected at least {FEWEST_SAMPLES}", hint="raise the rate")


def _place(document: Document, problem: Problem) -> Place | None:
    """The position of a problem; the drive, where what it is about is not mentioned."""
    return document.values.get(problem.path) or document.keys.get(("drive",))


def _part(document: Document) -> Document:
    """What the document says of judging records."""
    data = document.data if isinstance(document.data, dict) else {}
    return replace(document, data={key: data[key] for key in _JUDGED if key in data}, problems=[])
