"""The numbers of a test rig: of its strokes, its sensors, the evaluation of its records, and the risk number."""

from stickslip.vocabulary.parameter import NAN, Parameter, table
from stickslip.vocabulary.quantities import PARAMETERS

STROKES: dict[str, Parameter] = table(
    Parameter("strokes", "1", "number of strokes, forward and back in turn", "drive",
              default=6, at_least=1, at_most=10_000, whole=True),
)  # fmt: skip
SENSOR: dict[str, Parameter] = table(
    Parameter("rate", "s-1", "samples per second", "sensor", default=1000.0, above=0),
    Parameter("bandwidth", "s-1", "bandwidth of both sensors, -3 dB; unlimited unless given", "sensor",
              above=0),
    Parameter("force_noise", "N", "standard deviation of the noise of the force", "sensor", default=0.0, at_least=0,
              at_most=1e9),
    Parameter(
        "acceleration_noise", "m s-2", "standard deviation of the noise of the acceleration", "sensor",
        default=0.0, at_least=0, at_most=1e9,
    ),
    Parameter("seed", "1", "seed of the noise: the same seed, the same noise", "sensor",
              default=1, at_least=0, at_most=2**32 - 1, whole=True),
    Parameter("oversampling", "1", "samples computed per sample kept, against aliasing", "sensor",
              default=8, at_least=1, at_most=64, whole=True),
)  # fmt: skip
FEATURE_SETTINGS: dict[str, Parameter] = table(
    Parameter("bandwidth", "s-1", "bandwidth of the acceleration sensor", "features", above=0),
    Parameter("smallest_drop", "N", "smallest drop of the friction force that counts", "features", above=0),
    Parameter("window", "s", "time over which the rate of the force is estimated", "features", above=0),
    Parameter(
        "tolerance", "1", "slip speed, over that of the drive, below which the contact sticks", "features",
        default=0.2, above=0,
    ),
)  # fmt: skip
CONDITIONS: dict[str, Parameter] = table(
    Parameter("drive_speed", "m s-1", "speed of the drive", "conditions", above=0),
    PARAMETERS["normal_load"],
    Parameter("waiting_time", "s", "waiting time (hold time) before the test", "conditions", at_least=0),
    PARAMETERS["mass"],
    PARAMETERS["stiffness"],
)

# The model RPN. Every pair sticks once per stroke, hence 6; the accelerations of such a pair are about
# 1 m/s2 and 1 m/s, or below. If friction drops half as far, there are twice as many sticks, half the
# acceleration and the same integral: equal weights would not tell how strong stick-slip is, so the largest acceleration
# has twice the weight of the others. What is left, the size of all weights, is set by the only published value: 7 for
# dry foamed PVC on PC-ABS.
_INPUTS = (  # unit, what it is, levels per decade, and from where on the level rises
    ("sticks", "1", "number of sticks", 1.0, 6.0),
    ("acceleration_max", "m s-2", "acceleration", 2.0, 1.0),
    ("acceleration_integral", "m s-1", "integral of acceleration", 1.0, 1.0),
)
RISK: dict[str, Parameter] = table(
    Parameter("base", "1", "level of a record without any signal", "risk", default=1.0),
    *(Parameter(f"weight_{name}", "1", f"levels per decade of the {what}", "risk", default=weight, at_least=0)
      for name, _, what, weight, _ in _INPUTS),
    *(Parameter(f"scale_{name}", unit, f"{what} from which the level rises", "risk", default=scale, above=0)
      for name, unit, what, _, scale in _INPUTS),
    *(Parameter(f"{end}_{name}", unit, f"{end} {what} of the pairs the model was calibrated with", "risk", default=NAN,
                at_least=0, absent="features are not compared with a range")
      for name, unit, what, _, _ in _INPUTS for end in ("lowest", "highest")),
)  # fmt: skip
