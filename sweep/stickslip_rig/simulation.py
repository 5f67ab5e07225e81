"""Simulated rigs: records of tests as sensors would make them, and the features of a matrix of tests.

The plate moves in segments of constant acceleration: (duration in s, speed at its start in m/s, acceleration in m/s2).
A test is a hold time (`waiting_time`), then reciprocating strokes, each followed by standstill (`dwell`).

Sensors give evenly spaced samples, limited in bandwidth, with noise. The motion is sampled `oversampling` times as
often as the record, where the acceleration is the mean over the time between two samples (the change of the velocity,
so no jump of it is missed). There the sensor follows within its bandwidth, if it has one (a causal low-pass,
Butterworth of order 4), and what is above the Nyquist frequency is removed before decimation: by a symmetric low-pass,
flat to 0.82 of that frequency and 80 dB down from 0.98 of it on. So nothing is aliased, unless `oversampling` is 1.
"""

from __future__ import annotations

import math
import os
from collections.abc import Callable, Collection, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import cache, cached_property
from typing import Any

import numpy as np
import xarray as xr
from scipy import signal  # type: ignore[import-untyped]

from stickslip import engine
from stickslip.config.grid import build_grid, options_of
from stickslip.config.model import Config
from stickslip.config.reader import load_config, make_config
from stickslip.config.studies import Moved
from stickslip.config.yaml import Setting
from stickslip.dataset.build import grid_coordinates, study_dataset
from stickslip.engine import joined
from stickslip.errors import StoppedError
from stickslip.vocabulary.cells import scales_of
from stickslip.vocabulary.quantities import MODES, STATUSES
from stickslip_rig.evaluation import PEAKS, features, rate, test_names
from stickslip_rig.quantities import CONDITIONS, EXACT, FEATURES, MATERIAL, PER_PEAK, RATINGS, SIGNALS
from stickslip_rig.records import make_record
from stickslip_rig.sections import PIECES, Drive, RigStudy, Sensor, sections_of
from stickslip_rig.signals import Floats, band_limited

_SAMPLES = 4_000_000  # of motions that are computed together
_HALF_LENGTH = 32  # of the symmetric low-pass, in samples of the record
_CUTOFF = 0.9  # of half the sampling rate: 6 dB down there
_ATTENUATION = 80.0  # dB
_REACHED = STATUSES.index("horizon_reached")


# --- the plate --------------------------------------------------------------------------------------------------------


def segments(drive: Drive, quantities: Mapping[str, float]) -> Floats:
    """The segments of a test, shape (m, 3).

    drive : of the profile "trapezoid" (from standstill to `belt_speed` within `ramp`, constant, and back) or "sine"
        (half a period, with `belt_speed` in its middle, in straight pieces).
    quantities : belt_speed, stroke, ramp, dwell, waiting_time.
    """
    stroke = _trapezoid(quantities) if drive.profile == "trapezoid" else _sine(quantities)
    rest = np.array([[quantities["dwell"], 0.0, 0.0]])
    there, back = np.concatenate([stroke, rest]), np.concatenate([stroke * (1.0, -1.0, -1.0), rest])
    wait = np.array([[quantities["waiting_time"], 0.0, 0.0]])
    whole = np.concatenate([wait, *(back if n % 2 else there for n in range(drive.strokes))])
    return np.asarray(whole[whole[:, 0] > 0.0])


def _trapezoid(quantities: Mapping[str, float]) -> Floats:
    speed, ramp = quantities["belt_speed"], quantities["ramp"]
    plateau = max(quantities["stroke"] / speed - ramp, 0.0)
    return np.array([[ramp, 0.0, speed / ramp], [plateau, speed, 0.0], [ramp, speed, -speed / ramp]])


def _sine(quantities: Mapping[str, float]) -> Floats:
    """Speeds at the ends of the pieces lie on the sine; the stroke is that of the pieces, exactly."""
    share = np.linspace(0.0, 1.0, PIECES + 1)
    speed = quantities["belt_speed"] * np.sin(math.pi * share)
    speed[-1] = 0.0
    duration = quantities["stroke"] / np.trapezoid(speed, share)
    piece = duration / PIECES
    return np.stack([np.full(PIECES, piece), speed[:-1], np.diff(speed) / piece], axis=1)


def motion(drive: Floats, time: Floats) -> tuple[Floats, Floats]:
    """Speed and displacement of the plate at some times (s since the start of the drive)."""
    ends = np.cumsum(drive[:, 0])
    begins = ends - drive[:, 0]
    ways = drive[:, 0] * (drive[:, 1] + 0.5 * drive[:, 0] * drive[:, 2])
    at = np.minimum(np.searchsorted(ends, time, side="right"), len(drive) - 1)
    since = time - begins[at]
    speed = drive[at, 1] + drive[at, 2] * since
    return speed, (np.cumsum(ways) - ways)[at] + since * 0.5 * (drive[at, 1] + speed)


# --- the sensors ------------------------------------------------------------------------------------------------------


def times(samples: int, sensor: Sensor) -> Floats:
    """Times of the samples of a record, s since the first of `samples` samples of the motion."""
    size = -(-(samples - 1) // sensor.oversampling)
    return np.asarray((np.arange(size) + 0.5 / sensor.oversampling) / sensor.rate, np.float64)


def accelerations(velocity: Floats, sensor: Sensor) -> Floats:
    """Mean accelerations between the samples of the motion."""
    return np.asarray(np.diff(velocity) * (sensor.rate * sensor.oversampling))


def midway(values: Floats) -> Floats:
    """Values between the samples of the motion, of something that does not jump."""
    return np.asarray(0.5 * (values[1:] + values[:-1]))


def sensed(values: Floats, sensor: Sensor, deviation: float = 0.0, noise: np.random.Generator | None = None) -> Floats:
    """The sensor's record of a signal given between the samples of the motion.

    deviation : of its white Gaussian noise, which is drawn from `noise`.
    """
    if sensor.bandwidth is not None:
        values = band_limited(values, sensor.rate * sensor.oversampling, sensor.bandwidth)
    if sensor.oversampling > 1:
        padded = np.pad(values, _HALF_LENGTH * sensor.oversampling, mode="edge")
        weights = _weights(int(sensor.oversampling))
        values = signal.oaconvolve(padded, weights, mode="valid")[:: sensor.oversampling]
    if noise is not None and deviation > 0.0:
        values = values + noise.normal(0.0, deviation, values.size)
    return np.asarray(values)


@cache
def _weights(oversampling: int) -> Floats:
    """Of the symmetric low-pass."""
    window = ("kaiser", signal.kaiser_beta(_ATTENUATION))
    return np.asarray(signal.firwin(2 * _HALF_LENGTH * oversampling + 1, _CUTOFF / oversampling, window=window))


# --- the tests --------------------------------------------------------------------------------------------------------


@dataclass(frozen=True)
class RigTest:
    """One rig: its number in the matrix, its name, its record (None if it was not integrated to its end), and
    what the integration itself gives, by names of `EXACT`."""

    number: int
    name: str
    record: xr.Dataset | None
    exact: Mapping[str, float]


class RigTests(RigStudy):
    """All tests of a configuration with a drive, numbered as the cells of its grid.

    Its result holds features, model RPN and what the integration gives, over the dimensions of the grid. A test that
    was not integrated to its end has a status that says why, and NaN.
    """

    variables, subject = FEATURES | EXACT | RATINGS, "model_rpn"
    name, counted, ragged, weight = "matrix", "tests", True, 4096
    columns = {name: np.dtype(np.float64) for name in (*FEATURES, *EXACT)} | {"status": np.dtype(np.int8)}
    recorded: Collection[str] = tuple(SIGNALS)  # by the sensors
    kernels = ()  # those of signals, which are loaded when they are first needed

    def __init__(self, config: Config) -> None:
        self.config = config
        self.drive, self.sensor, self.features, self.risk = sections_of(config)
        self.grid, self.options = build_grid(config), options_of(config)
        self.dims, self.shape = self.grid.dims, self.grid.shape

    # --- its tests ----------------------------------------------------------------------------------------------------

    def label(self, number: int) -> str:
        """The points that distinguish a test from the others, in words."""
        return self._labels[number] or self.config.title

    @cached_property
    def _labels(self) -> list[str]:
        return test_names(xr.Dataset(coords=grid_coordinates(self.grid)), self.dims)

    def segments(self, number: int) -> Floats:
        """The drive of a test, as `segments` gives it."""
        return segments(self.drive, self._cell(number))

    def duration(self, number: int) -> float:
        """The duration of a test from the first stroke on, s."""
        return float(self.segments(number)[:, 0].sum()) - self._cell(number)["waiting_time"]

    def tests(self, numbers: Sequence[int], stop: engine.StopFlag | None = None) -> Iterator[RigTest]:
        """The tests of these numbers, one after the other, by this thread alone; together those that memory holds."""
        if not numbers:
            return
        stop = engine.stop_flag() if stop is None else stop
        fine = self.sensor.rate * self.sensor.oversampling
        cells = self.grid.take(np.asarray(numbers, np.int64))
        together = np.floor(np.cumsum(self.drive.duration(cells) * fine) / _SAMPLES)
        for batch in np.split(np.arange(len(numbers)), np.flatnonzero(np.diff(together)) + 1):
            part = {name: values[batch] for name, values in cells.items()}
            drives = [self.segments(numbers[i]) for i in batch]
            runs = engine.compute_rigs(part, drives, engine.Sampling(fine, part["waiting_time"]), self.options, stop)
            for i, drive in enumerate(drives):
                number, exact = numbers[batch[i]], {name: float(runs.results[name][i]) for name in EXACT}
                record = self._record(number, runs.signals[i], drive) if exact["status"] == _REACHED else None
                yield RigTest(number, self.label(number), record, exact)

    def _cell(self, number: int) -> dict[str, float]:
        """The quantities of one test."""
        return {name: float(values[0]) for name, values in self.grid[number : number + 1].items()}

    def noise(self, number: int) -> np.random.Generator:
        """The noise of a test."""
        return np.random.default_rng([self.sensor.seed, number])

    def _record(self, number: int, signals: Mapping[str, Floats], drive: Floats) -> xr.Dataset:
        """The sensors' record of a motion, from the first stroke on."""
        cell, sensor, noise = self._cell(number), self.sensor, self.noise(number)
        acceleration = accelerations(signals["velocity"], sensor)
        spring = cell["stiffness"] * midway(signals["displacement"])
        mass = float(scales_of(cell).mass)
        friction = mass * acceleration + cell["damping"] * midway(signals["velocity"]) + spring
        sticks = (signals["mode"][1:] == MODES.index("stick")).astype(np.float64)
        time = times(signals["velocity"].size, sensor)
        speed, way = motion(drive, time + cell["waiting_time"])
        sources: dict[str, Callable[[], Any]] = {
            "spring_force": lambda: sensed(spring, sensor, sensor.force_noise, noise),
            "friction_force": lambda: sensed(friction, sensor),
            "acceleration": lambda: sensed(acceleration, sensor, sensor.acceleration_noise, noise),
            "drive_velocity": lambda: speed,
            "drive_displacement": lambda: way,
            # Through the same sensor, so that a stick ends where the force shows its end.
            "stick": lambda: sensed(sticks, sensor) > 0.5,
        }
        recorded = {name: make() for name, make in sources.items() if name in self.recorded}
        conditions: dict[str, float | str] = {name: cell[name] for name in CONDITIONS if name in cell}
        conditions |= {"mass": mass, "drive_speed": cell["belt_speed"], MATERIAL: self._material(number)}
        return make_record(time, recorded, conditions).assign_attrs(title=self.label(number))

    def _material(self, number: int) -> str:
        """The name of the material: that of the point on a labelled axis, the title where there is none."""
        at = np.unravel_index(number, self.shape) if self.shape else ()
        for dim, i in zip(self.dims, at, strict=True):
            first = next(c for c in self.grid.coords if c.dim == dim)
            if first.labels is not None and first.name != dim.removesuffix("_case"):
                return first.labels[int(i)]
        return self.config.title

    # --- as a study ---------------------------------------------------------------------------------------------------

    @classmethod
    def of(cls, given: Config, section: Drive, options: engine.Options) -> RigTests:
        """The tests that a configuration asks for."""
        return cls(given)

    def compute(self, items: range, stop: engine.StopFlag, moved: Moved | None = None) -> engine.Results:
        """The features of a range of tests."""
        rows: list[dict[str, Any]] = []
        for test in self.tests(items, stop):
            if stop[0]:
                raise StoppedError
            row: dict[str, Any] = {**self.blank(range(1)), **test.exact}
            if test.record is not None:
                ds = features(test.record, self.features)
                row |= {name: ds[name].values for name in FEATURES}
            rows.append(row)
            if moved:
                moved(1)
        return {name: np.ravel([row[name] for row in rows]).astype(kind) for name, kind in self.columns.items()}

    def blank(self, items: range) -> engine.Results:
        """Tests that were not run: NaN."""
        sizes = {name: len(items) * (PEAKS if name in PER_PEAK else 1) for name in self.columns}
        return {name: np.zeros(size, np.int8) if name == "status" else np.full(size, np.nan)
                for name, size in sizes.items()}  # fmt: skip

    def dataset(self, parts: Sequence[engine.Results], attributes: Mapping[str, Any]) -> xr.Dataset:
        """The matrix over the dimensions of the grid, and `peak`."""
        values = joined(parts)
        values |= {name: values[name].reshape(-1, PEAKS) for name in PER_PEAK}
        coordinates = grid_coordinates(self.grid)
        ds = study_dataset(self.section.key, self.variables, values, self.dims, self.shape, coordinates, attributes)
        return rate(ds, self.risk)


def load_rig(path: str | os.PathLike[str] | Mapping[str, Any], settings: Iterable[Setting] = ()) -> Config:
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
    return load_config(path, settings, apart="drive")


def make_rig(data: Mapping[str, Any], name: str = "<data>") -> Config:
    """The configuration of a rig in mappings shaped like the YAML. Raises ConfigError."""
    return make_config(data, name, apart="drive")
