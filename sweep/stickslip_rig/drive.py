"""The quantities of the drive of a rig, which may vary as those of a cell do."""

from stickslip.vocabulary.parameter import Parameter, table

# What moves the belt of a test rig, whose top speed is the belt speed.
DRIVE: dict[str, Parameter] = table(
    Parameter("stroke", "m", "stroke of the drive", "drive", above=0, plausible=1.0),
    Parameter("ramp", "s", "time in which the drive reaches its speed, and stops", "drive", default=0.02, above=0),
    Parameter("dwell", "s", "standstill of the drive after each stroke", "drive", default=0.0, at_least=0),
    Parameter(
        "waiting_time", "s", "hold time in contact before the first stroke", "drive",
        default=0.0, at_least=0, at_most=1e9,  # thirty years; of much more, nothing is left of a second
    ),
)  # fmt: skip
PROFILES = ("trapezoid", "sine")
