"""Every quantity a configuration may name, and the words that stand for "absent".

These are the `PARAMETERS` of a cell (the inputs of the engine, all in SI); for friction, what people measure instead of
the coefficients of the curve (the friction coefficient at break-away, the one at the reversal point, which is the
minimum of the curve, and the speed there); and what moves the belt of a test rig.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

NAN = float("nan")


@dataclass(frozen=True)
class Parameter:
    """One input of a cell.

    default : value used when the user says nothing; None means it must be given; NaN means "absent".
    absent : what then holds, for those whose default is NaN.
    minimum : smallest value allowed; `exclusive` says whether the minimum itself is refused.
    """

    name: str
    units: str
    long_name: str
    section: str
    default: float | None = None
    minimum: float = float("-inf")
    exclusive: bool = False
    absent: str | None = None


_PARAMETERS = (
    Parameter("mass", "kg", "mass", "system", None, 0.0, True),
    Parameter("stiffness", "N m-1", "spring stiffness", "system", None, 0.0, True),
    Parameter("damping", "N s m-1", "viscous damping coefficient", "system", 0.0, 0.0),
    Parameter("normal_load", "N", "normal load", "system", None, 0.0, True),
    Parameter("belt_speed", "m s-1", "belt speed", "system", None),
    Parameter("a1", "1", "friction coefficient a1, constant part of the Stribeck curve", "friction", None, 0.0),
    Parameter("a2", "s m-1", "slope a2 of the rising branch of the Stribeck curve", "friction", None),
    Parameter("a3", "1", "drop a3 of the declining branch of the Stribeck curve", "friction", None),
    Parameter(
        "a4", "m s-1", "decay speed a4 of the declining branch of the Stribeck curve", "friction", None, 0.0, True
    ),
    Parameter("delta", "1", "exponent of the law stribeck_delta", "friction", 1.0, 1.0),
    Parameter(
        "mu_stop", "1", "friction coefficient just before standstill", "friction", NAN, 0.0, absent="no hysteresis"
    ),
    Parameter("mu_static", "1", "static friction coefficient", "friction", NAN, 0.0, absent="mu_start = a1 + a3"),
    Parameter("ageing_rate", "1", "growth of static friction per decade of contact time", "friction", 0.0, 0.0),
    Parameter("ageing_time", "s", "contact time from which static friction grows", "friction", 1.0, 0.0, True),
    Parameter("displacement", "m", "displacement at the start", "start", 0.0),
    Parameter("velocity", "m s-1", "velocity at the start", "start", NAN, absent="that of the belt, sticking"),
    Parameter("contact_time", "s", "time in contact before the start", "start", 0.0, 0.0),
)

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

PARAMETERS: dict[str, Parameter] = {p.name: p for p in _PARAMETERS}
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
