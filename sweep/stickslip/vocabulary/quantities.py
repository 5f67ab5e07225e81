"""Every quantity a configuration may name.

These are the `PARAMETERS` of a cell (the inputs of the engine, all in SI); for friction, what people measure instead of
the coefficients of the curve (the friction coefficient at break-away, the one at the reversal point, which is the
minimum of the curve, and the speed there); and what moves the belt of a test rig. `settings.py` has all other numbers.
"""

from __future__ import annotations

from math import inf

from stickslip.vocabulary.parameter import NAN, Parameter, table

# The largest magnitudes that are plausible, in SI. Sliding contacts reach 30 m/s in brakes; friction falls within
# millimetres per second, and within a metre per second at most; oscillators that stick and slip weigh up to a machine
# table, and their specimens and strokes are shorter than a metre. With a unit only what no contact does is doubted.
_SPEED, _FALL = (30.0, 200.0), (1.0, 5.0)
_FRICTION = (1.5, 1.5)  # rubber on rough ground and clean metals in vacuum reach more

PARAMETERS: dict[str, Parameter] = table(
    Parameter("mass", "kg", "mass", "system", above=0, plausible=(50.0, inf)),
    Parameter("stiffness", "N m-1", "spring stiffness", "system", above=0),
    Parameter("damping", "N s m-1", "viscous damping coefficient", "system", default=0.0, at_least=0),
    Parameter("normal_load", "N", "normal load", "system", above=0),
    Parameter("belt_speed", "m s-1", "belt speed", "system", plausible=_SPEED),
    Parameter(
        "a1", "1", "friction coefficient a1, constant part of the Stribeck curve", "friction",
        at_least=0, plausible=_FRICTION,
    ),
    Parameter("a2", "s m-1", "slope a2 of the rising branch of the Stribeck curve", "friction"),
    Parameter(
        "a3", "1", "drop a3 of the declining branch of the Stribeck curve", "friction", plausible=_FRICTION
    ),
    Parameter(
        "a4", "m s-1", "decay speed a4 of the declining branch of the Stribeck curve", "friction",
        above=0, plausible=_FALL,
    ),
    Parameter("delta", "1", "exponent of the law stribeck_delta", "friction", default=1.0, at_least=1),
    Parameter(
        "mu_stop", "1", "friction coefficient as the slip speed falls to zero", "friction",
        default=NAN, at_least=0, word="none", absent="no hysteresis", plausible=_FRICTION,
    ),
    Parameter(
        "mu_static", "1", "static friction coefficient", "friction",
        default=NAN, at_least=0, word="mu_start", absent="mu_start = a1 + a3", plausible=_FRICTION,
    ),
    Parameter(
        "ageing_rate", "1", "growth of static friction per decade of contact time", "friction", default=0.0, at_least=0
    ),
    Parameter("ageing_time", "s", "contact time from which static friction grows", "friction", default=1.0, above=0),
    Parameter("displacement", "m", "displacement at the start", "start", default=0.0, plausible=(10.0, inf)),
    Parameter(
        "velocity", "m s-1", "velocity at the start", "start",
        default=NAN, word="sticking", absent="that of the belt, sticking", plausible=_SPEED,
    ),
    Parameter("contact_time", "s", "hold time: time in contact before the start", "start", default=0.0, at_least=0),
)  # fmt: skip

MEASURED: dict[str, Parameter] = table(
    Parameter("mu_start", "1", "friction coefficient at break-away", "friction", above=0, plausible=_FRICTION),
    Parameter(
        "mu_reversal", "1", "friction coefficient at the minimum of the Stribeck curve", "friction",
        at_least=0, plausible=_FRICTION,
    ),
    Parameter(
        "v_reversal", "m s-1", "speed at the minimum of the Stribeck curve", "friction", above=0, plausible=(1.0, 20.0)
    ),
)  # fmt: skip
SEARCHABLE = {**PARAMETERS, **MEASURED}  # what borders are searched along
REPLACED = ("a1", "a2", "a3")  # the coefficients that MEASURED stands for

# What moves the belt of a test rig, whose top speed is the belt speed.
DRIVE: dict[str, Parameter] = table(
    Parameter("stroke", "m", "stroke of the drive", "drive", above=0, plausible=(1.0, 10.0)),
    Parameter("ramp", "s", "time in which the drive reaches its speed, and stops", "drive", default=0.02, above=0),
    Parameter("dwell", "s", "standstill of the drive after each stroke", "drive", default=0.0, at_least=0),
    Parameter(
        "waiting_time", "s", "hold time in contact before the first stroke", "drive",
        default=0.0, at_least=0, at_most=1e9,  # thirty years; of much more, nothing is left of a second
    ),
)  # fmt: skip
PROFILES = ("trapezoid", "sine")

QUANTITIES: dict[str, Parameter] = PARAMETERS | MEASURED | DRIVE
