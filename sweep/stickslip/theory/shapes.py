"""The weakening of friction as each law has it: mu = a1 + a2 w + a3 shape(w/a4), shape(0) = 1."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from stickslip.theory.numerics import Floats

# By names of `vocabulary.laws`; stribeck_delta is the Gaussian, delta = 2.
SHAPES: dict[str, Callable[[Floats], Floats]] = {
    "stribeck": lambda z: np.exp(-z),
    "stribeck_delta": lambda z: np.exp(-np.square(z)),
    "rational": lambda z: 1.0 / (1.0 + z),
    "cubic": lambda z: np.where(z < 1.0, 1.0 - 1.5 * z + 0.5 * z**3, 0.0),
}
