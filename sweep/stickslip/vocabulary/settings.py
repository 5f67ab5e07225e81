"""Every number that is set but is no parameter of a cell: of the solver, of sensors, of the evaluation of records.

By section of the configuration; what is no number (a law, a file) is declared where it is read.
"""

from stickslip.vocabulary.parameter import NAN, Parameter, table
from stickslip.vocabulary.quantities import PARAMETERS

SOLVER: dict[str, Parameter] = table(
    Parameter("rtol", "1", "relative tolerance of a step", "solver", default=1e-6, at_least=1e-12, at_most=1e-2),
    Parameter("horizon", "s", "longest time simulated per cell; no limit unless given", "solver", above=0,
              absent="no limit"),
    Parameter(
        "max_steps", "1", "step budget of a cell; when it runs out the cell is unresolved", "solver",
        default=100_000, at_least=1, at_most=2_000_000_000, whole=True,  # steps are counted in 32 bits
    ),
)  # fmt: skip
EXECUTION: dict[str, Parameter] = table(
    Parameter(
        "threads", "1", "threads; auto takes the processors of this machine", "execution",
        default=NAN, at_least=1, at_most=4096, whole=True, word="auto",
    ),
    Parameter("block", "1", "cells computed together", "execution",
              default=4096, at_least=1, at_most=1_000_000, whole=True),
)  # fmt: skip
AXIS: dict[str, Parameter] = table(  # the values of axes are held in memory, those of cells are not
    Parameter("num", "1", "number of points", "axes", at_least=2, at_most=10_000_000, whole=True),
)
UNCERTAIN: dict[str, Parameter] = table(
    Parameter(
        "draws", "1", "draws per scrambling, a power of two; with Sobol indices, quantities + 2 times as many",
        "uncertain", default=1024, at_least=2, at_most=2**30, whole=True,
    ),
    Parameter("scramblings", "1", "independent scramblings, whose spread is the standard error", "uncertain",
              default=8, at_least=2, at_most=1000, whole=True),
    Parameter("seed", "1", "seed of the scramblings: the same seed, the same draws", "uncertain",
              default=1, at_least=0, at_most=2**32 - 1, whole=True),
)  # fmt: skip
SUBSET: dict[str, Parameter] = table(
    Parameter("samples", "1", "samples of each level of a subset simulation, a multiple of 10", "uncertain",
              default=2000, at_least=100, at_most=10_000_000, whole=True),
    Parameter("repetitions", "1", "independent subset simulations, whose spread is the standard error", "uncertain",
              default=8, at_least=2, at_most=1000, whole=True),
    Parameter("seed", "1", "seed of the simulations: the same seed, the same samples", "uncertain",
              default=1, at_least=0, at_most=2**32 - 1, whole=True),
)  # fmt: skip


# --- rigs -------------------------------------------------------------------------------------------------------------

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
RISK: dict[str, Parameter] = table(
    Parameter("base", "1", "level of a record without any signal", "risk", default=1.0),
    Parameter("weight_sticks", "1", "levels per decade of sticks", "risk", default=1.0, at_least=0),
    Parameter(
        "weight_acceleration_max", "1", "levels per decade of the largest acceleration", "risk",
        default=2.0, at_least=0,
    ),
    Parameter(
        "weight_acceleration_integral", "1", "levels per decade of the integral of acceleration", "risk",
        default=1.0, at_least=0,
    ),
    Parameter("scale_sticks", "1", "number of sticks from which the level rises", "risk", default=6.0, above=0),
    Parameter(
        "scale_acceleration_max", "m s-2", "acceleration from which the level rises", "risk", default=1.0, above=0
    ),
    Parameter(
        "scale_acceleration_integral", "m s-1", "integral of acceleration from which the level rises", "risk",
        default=1.0, above=0,
    ),
    *(Parameter(f"{end}_{name}", unit, f"{end} {what} of the pairs the model was calibrated with", "risk", default=NAN,
                at_least=0, absent="features are not compared with a range")
      for name, unit, what in (("sticks", "1", "number of sticks"), ("acceleration_max", "m s-2", "acceleration"),
                               ("acceleration_integral", "m s-1", "integral of acceleration"))
      for end in ("lowest", "highest")),
)  # fmt: skip

# --- columns of measured points ---------------------------------------------------------------------------------------

_MU = Parameter("mu", "1", "friction coefficient", "points", at_least=0)
CURVE_COLUMNS = (
    Parameter("speed", "m s-1", "slip speed", "points", at_least=0),
    _MU,
    Parameter("sigma", "1", "standard deviation of mu", "points", default=NAN, above=0),
)
AGEING_COLUMNS = (Parameter("time", "s", "waiting time", "points", at_least=0), _MU)

# All numbers of a configuration that are neither quantities nor of a study, by section.
SETTINGS: dict[str, dict[str, Parameter]] = {
    "solver": SOLVER, "execution": EXECUTION, "drive": STROKES, "sensor": SENSOR, "features": FEATURE_SETTINGS,
    "risk": RISK,
}  # fmt: skip
