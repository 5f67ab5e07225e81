"""The sound of a record: of an acceleration that was measured, or simulated on a rig."""

from __future__ import annotations

from fractions import Fraction
from math import nan

import numpy as np
from numpy.typing import NDArray

from stickslip.sound.making import RATE, checked, fades
from stickslip.sound.sounds import FULL_SCALE, Sound

Floats = NDArray[np.float64]

_FINEST = 1000  # denominator of the ratio of two rates


def of_record(
    acceleration: Floats,
    record_rate: float,
    *,
    rate: int = RATE,
    slow: float = 1.0,
    full_scale: float = FULL_SCALE,
    title: str = "",
) -> Sound:
    """The sound of an evenly sampled acceleration (m/s2).

    record_rate : samples a second of the record; tones up to half of it are in the sound. rate, slow, full_scale : as
        for `of`. Resampled by a symmetric low-pass, unless the rates are equal. Raises ValueError.
    """
    checked(record_rate=record_rate, rate=rate, slow=slow, full_scale=full_scale)
    values = np.asarray(acceleration, np.float64)
    ratio = Fraction(rate * slow / record_rate).limit_denominator(_FINEST)
    if ratio != 1:
        from scipy import signal  # type: ignore[import-untyped]

        values = signal.resample_poly(values, ratio.numerator, ratio.denominator)
    values = values * fades(values.size, rate)
    return Sound(values, int(rate), float(slow), float(full_scale), "", nan, False, title)
