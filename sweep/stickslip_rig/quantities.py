"""Every quantity of a rig record, and every feature, declared once."""

from stickslip.vocabulary.parameter import Variable
from stickslip_rig.risk import FORMULA, RPN_NAME

TIME = Variable("time", "s", "time since the start of the record")
_SIGNALS = (
    Variable("spring_force", "N", "force on the specimen as the rig measures it, that of its spring"),
    Variable("friction_force", "N", "friction force in the contact"),
    Variable("acceleration", "m s-2", "acceleration of the specimen"),
    Variable("drive_velocity", "m s-1", "velocity of the drive"),
    Variable("drive_displacement", "m", "displacement of the drive"),
    Variable("stick", "1", "contact sticks (1) or slips (0)"),
)
SIGNALS: dict[str, Variable] = {v.name: v for v in _SIGNALS}
COLUMNS: dict[str, Variable] = {TIME.name: TIME} | SIGNALS
FORCES = ("spring_force", "friction_force")  # a record has one of them, or both

MATERIAL = "material"  # the only condition that is a text

SIGNAL_OF = {  # by kind of column (`fit/headings.py`)
    "time": "time", "force": "spring_force", "friction_force": "friction_force", "acceleration": "acceleration",
    "speed": "drive_velocity", "displacement": "drive_displacement", "stick": "stick",
}  # fmt: skip
CONDITION_WORDS = {"load": "normal_load", "speed": "drive_speed", "waiting": "waiting_time", "wait": "waiting_time"}

_PEAK = ("peak",)
_FEATURES = (
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
    Variable("friction_speeding_up", "1", "friction coefficient in slow ramps of the drive up, mean over its speeds"),
    Variable(
        "friction_slowing_down", "1", "friction coefficient in slow ramps of the drive down, mean over its speeds"
    ),
    Variable("peak_frequency", "s-1", "frequencies of the peaks in the spectrum of the acceleration", dims=_PEAK),
    Variable("peak_acceleration", "m s-2", "amplitudes of the peaks in the spectrum of the acceleration", dims=_PEAK),
    Variable("energy_per_stroke", "J", "work of the drive per stroke"),
    Variable("strokes", "1", "number of strokes of the drive"),
    Variable("travel", "m", "total travel of the drive"),
    Variable("duration", "s", "duration of the record"),
    Variable("sample_rate", "s-1", "sampling rate, mean"),
)
FEATURES: dict[str, Variable] = {v.name: v for v in _FEATURES}
# What the integration of a simulated rig gives itself, without sensors and sampling.
_EXACT = (
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
EXACT: dict[str, Variable] = {v.name: v for v in _EXACT}
_RATINGS = (
    Variable("model_rpn_level", "1", f"level of the {RPN_NAME}", comment=f"{RPN_NAME}: {FORMULA}"),
    Variable("model_rpn", "1", RPN_NAME, comment="1 to 10; missing where a feature is not known"),
    Variable("model_rpn_band", "1", f"traffic light of the {RPN_NAME}"),
    Variable("model_rpn_extrapolated", "1", f"whether (1) the {RPN_NAME}, is an extrapolation",
             comment="a feature lies outside the range of the pairs of the calibration"),
)  # fmt: skip
RATINGS: dict[str, Variable] = {v.name: v for v in _RATINGS}
PER_PEAK = tuple(v.name for v in _FEATURES if v.dims)  # one value for each peak, the largest first
