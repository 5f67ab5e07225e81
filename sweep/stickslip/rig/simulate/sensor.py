"""What the sensors of a simulated rig record: evenly spaced samples, limited in bandwidth, with noise.

The motion is sampled `oversampling` times as often as the record, where the acceleration is the mean over the time
between two samples (the change of the velocity, so no jump of it is missed). There the sensor follows within its
bandwidth, if it has one (a causal low-pass, Butterworth of order 4), and what is above the Nyquist frequency is
removed before decimation: by a symmetric low-pass, flat to 0.82 of that frequency and 80 dB down from 0.98 of it on. So
nothing is aliased, unless `oversampling` is 1.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy import signal  # type: ignore[import-untyped]

from stickslip.config.sections import Sensor
from stickslip.rig.records.sampling import band_limited

Floats = NDArray[np.float64]

_HALF_LENGTH = 32  # of the symmetric low-pass, in samples of the record
_CUTOFF = 0.9  # of half the sampling rate: 6 dB down there
_ATTENUATION = 80.0  # dB


def times(samples: int, sensor: Sensor) -> Floats:
    """Times of the samples of a record, s since the first of `samples` samples of the motion."""
    kept = -(-(samples - 1) // sensor.oversampling)
    return np.asarray((np.arange(kept) + 0.5 / sensor.oversampling) / sensor.rate, np.float64)


def accelerations(velocity: Floats, sensor: Sensor) -> Floats:
    """Mean accelerations between the samples of the motion."""
    return np.asarray(np.diff(velocity) * (sensor.rate * sensor.oversampling))


def midway(values: Floats) -> Floats:
    """Values between the samples of the motion, of something that does not jump."""
    return np.asarray(0.5 * (values[1:] + values[:-1]))


def seen(values: Floats, sensor: Sensor) -> Floats:
    """What the sensor shows of a signal given between the samples of the motion, without noise."""
    fine = sensor.rate * sensor.oversampling
    if sensor.bandwidth is not None:
        values = band_limited(values, fine, sensor.bandwidth)
    if sensor.oversampling == 1:
        return values
    half = _HALF_LENGTH * sensor.oversampling
    window = ("kaiser", signal.kaiser_beta(_ATTENUATION))
    weights = signal.firwin(2 * half + 1, _CUTOFF / sensor.oversampling, window=window)
    padded = np.pad(values, half, mode="edge")
    return np.asarray(signal.oaconvolve(padded, weights, mode="valid")[:: sensor.oversampling])


def noisy(values: Floats, deviation: float, noise: np.random.Generator) -> Floats:
    """With white Gaussian noise of a standard deviation."""
    return values if deviation == 0.0 else values + noise.normal(0.0, deviation, values.size)
