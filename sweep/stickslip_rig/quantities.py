"""Every number of a test rig, declared once: of its sensors and records, of features, and of the risk model.

What moves the drive is in `drive.py`, since the engine asks for it before all else.
"""

from stickslip.vocabulary.parameter import Parameter, Variable, table
from stickslip.vocabulary.quantities import PARAMETERS

RPN_NAME = "model RPN, not the rig maker's"
FORMULA = "base + sum of weight log10(1 + feature/scale) over sticks, acceleration_max and acceleration_integral"

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
    PARAMETERS["damping"],
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
)  # fmt: skip


# --- records and results ----------------------------------------------------------------------------------------------

TIME = Variable("time", "s", "time since the start of the record")
SIGNALS: dict[str, Variable] = table(
    Variable("spring_force", "N", "force on the specimen as the rig measures it, that of its spring"),
    Variable("friction_force", "N", "friction force in the contact"),
    Variable("acceleration", "m s-2", "acceleration of the specimen"),
    Variable("drive_velocity", "m s-1", "velocity of the drive"),
    Variable("drive_displacement", "m", "displacement of the drive"),
    Variable("stick", "1", "contact sticks (1) or slips (0)"),
)
LOAD = "normal_load"
COLUMNS: dict[str, Variable | Parameter] = {TIME.name: TIME, **SIGNALS, LOAD: CONDITIONS[LOAD]}
FORCES = ("spring_force", "friction_force")  # a record has one of them, or both

MATERIAL = "material"  # the only condition that is a text

SIGNAL_OF = {  # by kind of column (`fit/headings.py`)
    "time": "time", "force": "spring_force", "friction_force": "friction_force", "acceleration": "acceleration",
    "speed": "drive_velocity", "displacement": "drive_displacement", "stick": "stick", "load": LOAD,
}  # fmt: skip
CONDITION_WORDS = {"load": "normal_load", "speed": "drive_speed", "waiting": "waiting_time", "wait": "waiting_time"}

FEATURES: dict[str, Variable] = table(
    Variable("sticks", "1", "number of stick phases"),
    Variable("slips", "1", "number of break-aways: stick phases that end in sliding"),
    Variable("stick_fraction", "1", "share of the time spent sticking"),
    Variable("acceleration_max", "m s-2", "largest magnitude of the sampled acceleration"),
    Variable("acceleration_max_limited", "m s-2", "largest magnitude of the band-limited acceleration"),
    Variable("acceleration_integral", "m s-1", "integral of the magnitude of the acceleration over the record"),
    Variable("acceleration_integral_limited", "m s-1", "the same of the band-limited acceleration"),
    Variable("time_to_sliding", "s", "time from break-away to sliding, median"),
    Variable("stick_slip_period", "s", "time from break-away to break-away, mean within strokes"),
    Variable("drops", "1", "number of drops of the friction force"),
    Variable("drop_mean", "N", "mean size of the drops of the friction force"),
    Variable("drop_max", "N", "largest drop of the friction force"),
    Variable("impulse_rate", "m-1", "break-aways over the total travel of the drive"),
    Variable("static_force", "N", "force at break-away, median"),
    Variable("static_force_first", "N", "force at the first break-away"),
    Variable("dynamic_force", "N", "mean force while sliding"),
    Variable("static_friction", "1", "static friction coefficient as the rig measures it"),
    Variable("static_friction_first", "1", "static friction coefficient at the first break-away"),
    Variable("dynamic_friction", "1", "dynamic friction coefficient as the rig measures it"),
    Variable("peak_frequency", "s-1", "frequency of the largest peak in the spectrum of the acceleration"),
    Variable("peak_acceleration", "m s-2", "amplitude of the largest peak in the spectrum of the acceleration"),
    Variable("energy_per_stroke", "J", "work of the drive per stroke"),
    Variable("strokes", "1", "number of strokes of the drive"),
    Variable("travel", "m", "total travel of the drive"),
    Variable("duration", "s", "duration of the record"),
    Variable("sample_rate", "s-1", "sampling rate, mean"),
)
# What the integration of a simulated rig gives itself, without sensors and sampling.
EXACT: dict[str, Variable] = table(
    Variable("status", "1", "how the integration ended"),
    Variable("steps", "1", "integration steps tried"),
    Variable("sticks_exact", "1", "number of stick phases, event-exact"),
    Variable("slips_exact", "1", "number of break-aways, event-exact"),
    Variable("stick_time", "s", "time spent sticking, the waiting time (hold time) included"),
    Variable("breakaway_time", "s", "time of the first break-away, since the start of the waiting time"),
    Variable("breakaway_force", "N", "tangential load on the contact at the first break-away"),
    Variable("acceleration_max_exact", "m s-2", "largest magnitude of the acceleration, event-exact"),
    Variable("drive_work", "J", "work of the drive over the test"),
    Variable("friction_heat", "J", "friction heat over the test"),
    Variable("damper_heat", "J", "heat in the damper over the test"),
    Variable("energy_error", "1", "energy-balance residual: work minus heat and stored energy, over the work"),
)
RATINGS: dict[str, Variable] = table(
    Variable("model_rpn_level", "1", f"level of the {RPN_NAME}", comment=f"{RPN_NAME}: {FORMULA}"),
    Variable("model_rpn", "1", RPN_NAME, comment="1 to 10; missing where a feature is not known"),
    Variable("model_rpn_band", "1", f"traffic light of the {RPN_NAME}"),
)  # fmt: skip
