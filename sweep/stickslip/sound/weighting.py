"""A-weighting: how much less the ear hears of low and very high tones.

The analytic formula of IEC 61672-1:2013, Annex E: four poles at 20.6 and 12194 Hz, one each at 107.7 and 737.9 Hz, and
0 dB at 1 kHz.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

HIGHEST = 20e3  # Hz; what lies above is not heard, and not summed
_POLES = 20.598997, 107.65265, 737.86223, 12194.217  # Hz


def _unscaled(frequency: NDArray[np.float64]) -> NDArray[np.float64]:
    f2 = frequency * frequency
    one, two, three, four = (pole * pole for pole in _POLES)
    return np.asarray(four * f2 * f2 / ((f2 + one) * np.sqrt((f2 + two) * (f2 + three)) * (f2 + four)))


_AT_1_KHZ = float(_unscaled(np.array(1000.0)))


def a_weighting(frequency: ArrayLike) -> NDArray[np.float64]:
    """The factor on the amplitude of a tone of a frequency (Hz): 1 at 1 kHz, 0 at 0."""
    return _unscaled(np.asarray(frequency, np.float64)) / _AT_1_KHZ


def decibels(factor: ArrayLike) -> NDArray[np.float64]:
    """A ratio of amplitudes in dB; -inf for 0."""
    with np.errstate(divide="ignore"):
        return np.asarray(20.0 * np.log10(np.asarray(factor, np.float64)))
