"""A risk number from three features of a record: the model RPN, not the rig maker's.

The rig maker's formula is not public; known are its three inputs, its range 1 to 10 and its bands. This model has the
same inputs, range and bands:

    level = base + sum over the features f of weight_f log10(1 + f/scale_f),   number = level rounded, within 1 to 10

It rises with every feature, logarithmically, as loudness does. A comment on `RISK` says where the default values come
from; `calibration.py` fits them to measured numbers.
"""

import math
from collections.abc import Mapping

import numpy as np
from numpy.typing import ArrayLike, NDArray

from stickslip.config.sections import Section, with_rows
from stickslip_rig.quantities import RISK

INPUTS = ("sticks", "acceleration_max", "acceleration_integral")
LOWEST, HIGHEST = 1, 10
BANDS = {"green": (1, 3), "yellow": (4, 5), "red": (6, 10)}  # the article's, page 4
UNDEFINED = 0  # the code of the band where a feature is not known; the number is NaN


class Risk(with_rows(Section, RISK)):  # type: ignore[misc]
    """Parameters of the model RPN: base, and weight_ and scale_ of each of its three features."""

    @property
    def scales(self) -> tuple[float, ...]:
        """In the order of `INPUTS`, in SI."""
        return tuple(getattr(self, f"scale_{name}") for name in INPUTS)

    def level(self, inputs: Mapping[str, ArrayLike]) -> NDArray[np.float64]:
        """The number before rounding and without ends, NaN where a feature is.

        inputs : by names of `INPUTS`, in SI, >= 0; arrays that broadcast.
        """
        total = np.asarray(self.base, np.float64)
        for name, scale in zip(INPUTS, self.scales, strict=True):
            total = total + getattr(self, f"weight_{name}") * decades(inputs[name], scale)
        return np.asarray(total)

    def number(self, inputs: Mapping[str, ArrayLike]) -> NDArray[np.float64]:
        """The model RPN, a whole number from 1 to 10; NaN where a feature is not known."""
        return number_of(self.level(inputs))


def decades(values: ArrayLike, scale: ArrayLike) -> NDArray[np.float64]:
    """log10(1 + values/scale): 0 without a signal, linear in small ones, one for every factor of ten in large ones."""
    return np.asarray(np.log1p(np.asarray(values, np.float64) / np.asarray(scale)) / math.log(10.0))


def number_of(level: ArrayLike) -> NDArray[np.float64]:
    """Levels rounded (halves up) and held within 1 to 10; NaN stays."""
    return np.asarray(np.clip(np.floor(np.asarray(level, np.float64) + 0.5), LOWEST, HIGHEST))


def rpn_text(number: float) -> str:
    """A number as it is shown: "?" where it is not known."""
    return f"{number:.0f}" if number >= LOWEST else "?"


def band_of(number: float) -> str:
    """The traffic light of a number: green, yellow or red; "unknown" for NaN."""
    return next((band for band, (low, high) in BANDS.items() if low <= number <= high), "unknown")
