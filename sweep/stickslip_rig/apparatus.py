"""The parts of a simulated rig: the plate that moves in segments of constant acceleration, and the sensors.

A segment is (duration in s, speed at its start in m/s, acceleration in m/s2). A test is a hold time (`waiting_time`),
then reciprocating strokes, each followed by standstill (`dwell`).

Sensors give evenly spaced samples, limited in bandwidth, with noise. The motion is sampled `oversampling` times as
often as the record, where the acceleration is the mean over the time between two samples (the change of the velocity,
so no jump of it is missed). There the sensor follows within its bandwidth, if it has one (a causal low-pass,
Butterworth of order 4), and what is above the Nyquist frequency is removed before decimation: by a symmetric low-pass,
flat to 0.82 of that frequency and 80 dB down from 0.98 of it on. So nothing is aliased, unless `oversampling` is 1.
"""

import math
from collections.abc import Mapping
from functools import cache

import numpy as np
from scipy import signal  # type: ignore[import-untyped]

from stickslip_rig.sections import PIECES, Drive, Sensor
from stickslip_rig.signals import Floats, band_limited

_HALF_LENGTH = 32  # of the symmetric low-pass, in samples of the record
_CUTOFF = 0.9  # of half the sampling rate: 6 dB down there
_ATTENUATION = 80.0  # dB


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
