"""Every quantity a configuration may name, and the words that stand for "absent".

These are the `PARAMETERS` of a cell; for friction, what people measure instead of the coefficients of the curve (the
friction coefficient at break-away, the one at the reversal point, which is the minimum of the curve, and the speed
there); and what moves the belt of a test rig.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from .variables import PARAMETERS, Parameter

_MEASURED = (
    Parameter("mu_start", "1", "friction coefficient at break-away", "friction", None, 0.0, True),
    Parameter("mu_reversal", "1", "friction coefficient at the minimum of the Stribeck curve", "friction", None, 0.0),
    Parameter("v_reversal", "m s-1", "speed at the minimum of the Stribeck curve", "friction", None, 0.0, True),
)

# What moves the belt of a test rig, whose top speed is the belt speed.
_DRIVE = (
    Parameter("stroke", "m", "stroke of the drive", "drive", None, 0.0, True),
    Parameter("ramp", "s", "time in which the drive comes up to speed, and to rest", "drive", 0.02, 0.0, True),
    Parameter("dwell", "s", "rest of the drive after each stroke", "drive", 0.0, 0.0),
    Parameter("waiting_time", "s", "rest in contact before the first stroke", "drive", 0.0, 0.0),
)
_SENSOR = (
    Parameter("rate", "s-1", "samples per second", "sensor", None, 0.0, True),
    Parameter("bandwidth", "s-1", "bandwidth of the sensors", "sensor", None, 0.0, True),
    Parameter("force_noise", "N", "standard deviation of the noise of the force", "sensor", None, 0.0),
    Parameter(
        "acceleration_noise", "m s-2", "standard deviation of the noise of the acceleration", "sensor", None, 0.0
    ),
)
PROFILES = ("trapezoid", "sine")

DRIVE: dict[str, Parameter] = {p.name: p for p in _DRIVE}
SENSOR: dict[str, Parameter] = {p.name: p for p in _SENSOR}
MEASURED: dict[str, Parameter] = {p.name: p for p in _MEASURED}
REPLACED = ("a1", "a2", "a3")  # the coefficients that MEASURED stands for
QUANTITIES: dict[str, Parameter] = PARAMETERS | MEASURED | DRIVE
HORIZON_UNITS = "s"

# Where NaN means "absent", people write what then holds.
WORDS = {"mu_stop": "none", "mu_static": "mu_start", "velocity": "sticking"}


def default(name: str) -> float | str | None:
    """What holds where a configuration does not mention the quantity: a number in SI or a word; None: nothing does."""
    value = QUANTITIES[name].default
    return WORDS[name] if value is not None and math.isnan(value) else value


class Coefficients(NamedTuple):
    """The coefficients of the Stribeck curve that the measured form stands for."""

    a1: NDArray[np.float64]
    a2: NDArray[np.float64]
    a3: NDArray[np.float64]


def coefficients(mu_start: ArrayLike, mu_reversal: ArrayLike, v_reversal: ArrayLike, a4: ArrayLike) -> Coefficients:
    """Coefficients a1, a2, a3 of the curve S(w) = a1 + a2 w + a3 exp(-w/a4) with S(0) = mu_start and its minimum
    mu_reversal at w = v_reversal.

    Arrays that broadcast; speeds in m/s, a4 > 0, v_reversal > 0. From S'(v) = 0, S(0) and S(v), with r = v/a4:
    a2 = (mu_start - mu_reversal)/(a4 (e^r - 1) - v), a3 = a2 a4 e^r, a1 = mu_start - a3.
    """
    start, drop = np.asarray(mu_start, np.float64), np.subtract(mu_start, mu_reversal)
    with np.errstate(divide="ignore", over="ignore"):  # a minimum at no speed at all: a3 and -a1 are infinite
        r = np.minimum(np.divide(v_reversal, a4), 1000.0)  # e^-r is 0 from there on
        share = -np.expm1(-r) - r * np.exp(-r)  # drop/a3; written in e^-r, which cannot overflow
        a3 = drop / share
    return Coefficients(start - a3, a3 * np.exp(-r) / a4, a3)
