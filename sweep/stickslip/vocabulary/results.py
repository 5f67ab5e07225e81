"""Every quantity that comes out of the engine, declared once.

`VARIABLES` are those of a cell, `MAP_VARIABLES` those that a map may have (`computed` where it is refined),
`TRACE_VARIABLES` those of one trajectory over time, `MATERIAL_VARIABLES` those of materials compared, `LEVEL_VARIABLES`
those of how loud cells are. Studies declare those of their results themselves, as rows of the same kind.
Datasets, plots and documentation read these
tables; nothing else repeats a unit or a long name. Units are spelled as UDUNITS requires (``m s-1``).
"""

from stickslip.vocabulary.models import CURVE, FITTED, MODELS, Model
from stickslip.vocabulary.parameter import Variable, table
from stickslip.vocabulary.quantities import SEARCHABLE

_OF_MODELS = {variable.name: variable for model in MODELS for variable in model.results}
_OF_WHAT = "Of the cycle where there is stick-slip, else of the whole motion."

VARIABLES: dict[str, Variable] = table(
    Variable("regime", "1", "regime of motion", "regime"),
    Variable("status", "1", "how the integration ended", "regime"),
    Variable("breakaway_time", "s", "time of the first break-away"),
    Variable("restick_time", "s", "time of the first re-stick"),
    Variable("restick_displacement", "m", "displacement at the first re-stick"),
    Variable(
        "restick_margin", "m s-1", "least slip speed of the last slip after a break-away; below 0 where it re-sticks",
        "regime",
        comment="By how much that slip misses standstill; the belt speed where it settles without a trough. Where it "
        "re-sticks, -a^2 m/(2 k |v_belt|), a being the deceleration at standstill: the depth of the trough that the "
        "stick phase replaces. 0 where it comes to standstill without sticking; NaN without a break-away.",
    ),
    Variable("period", "s", "period of the limit cycle"),
    Variable("frequency", "s-1", "frequency of the limit cycle"),
    Variable("stick_fraction", "1", "share of the period spent sticking"),
    Variable("spring_force_max", "N", "largest spring force since slip began, or since the start", comment=_OF_WHAT),
    Variable("spring_force_min", "N", "smallest spring force since slip began, or since the start", comment=_OF_WHAT),
    Variable("slip_speed_max", "m s-1", "largest slip speed", comment=_OF_WHAT),
    Variable("acceleration_max", "m s-2", "largest magnitude of the acceleration", comment=_OF_WHAT),
    *_OF_MODELS.values(),
    Variable(
        "energy_per_cycle", "J", "friction heat per cycle",
        comment="Exact to the tolerance, or to 1e-13 of the energy that the spring exchanges, which may be more where "
        "friction nearly vanishes at speed.",
    ),
    Variable("equilibrium_crossings", "1", "crossings of the equilibrium with extrema outside the settling band"),
    Variable(
        "settling_time", "s", "time from first slip until the amplitude stays inside the settling band",
        comment="NaN where the motion does not settle, and where it is known to without having been followed that far.",
    ),
    Variable("settled_displacement", "m", "displacement at which the motion settles"),
    Variable("displacement_amplitude", "m", "half the range of displacement on the attractor; 0 where it settles"),
    Variable("velocity_amplitude", "m s-1", "half the range of velocity on the attractor; 0 where it settles"),
    Variable("cycle_force_max", "N", "largest spring force on the attractor"),
    Variable("cycle_force_min", "N", "smallest spring force on the attractor"),
    Variable("damping_ratio", "1", "linear damping ratio of steady sliding on the curve", "regime"),
    Variable("steps", "1", "integration steps tried", "regime"),
    Variable("sticks", "1", "stick phases begun up to the horizon", "full"),
    Variable("stick_time", "s", "time spent sticking up to the horizon", "full"),
    Variable("displacement_end", "m", "displacement at the horizon", "full"),
    Variable("velocity_end", "m s-1", "velocity at the horizon", "full"),
)  # fmt: skip

TRACE_VARIABLES: dict[str, Variable] = table(
    Variable("displacement", "m", "displacement"),
    Variable("velocity", "m s-1", "velocity"),
    Variable("relative_speed", "m s-1", "relative speed, belt minus mass"),
    Variable("friction_coefficient", "1", "friction force over normal load"),
    Variable("spring_force", "N", "spring force"),
    Variable("acceleration", "m s-2", "acceleration"),
    Variable("mode", "1", "contact mode"),
)

MATERIAL_VARIABLES: dict[str, Variable] = table(
    Variable("rank", "1", "rank of the material, 1 for the one that is quiet from the lowest speed on",
             comment="NaN: not determined, see quiet_state and fit_quality"),
    Variable("quiet_above", "m s-1", "belt speed above which the pair is quiet",
             comment="no stick-slip and no other lasting vibration that began in stick; see quiet_state"),
    Variable("quiet_state", "1", "what the speed above which the pair is quiet is"),
    Variable("quiet_above_low", "m s-1", "lower end of the confidence interval of quiet_above",
             comment="0: no vibration at any speed searched; NaN: the points do not determine it"),
    Variable("quiet_above_high", "m s-1", "upper end of the confidence interval of quiet_above",
             comment="inf: vibration up to the fastest speed searched; NaN: the points do not determine it"),
    Variable("better_than_next", "1", "probability of being quiet from a lower speed on than the next in rank",
             comment="as far as the scatter of the points goes"),
    Variable("draws_used", "1", "curves drawn whose verdict is known"),
    Variable("draws_falling", "1", f"share of the curves drawn that fall for ever ({CURVE.slope} < 0)",
             comment="they vibrate at any speed unless the damper outweighs the fall"),
    Variable("next_speed_1", "m s-1", "one of the two speeds at which more points would narrow the interval most",
             comment="NaN: nothing can be told; of repeats another specimen narrows it"),
    Variable("next_speed_2", "m s-1", "the other one"),
    Variable("next_low", "m s-1", "about the lower end of the interval of quiet_above with these two points",
             comment="of repeats with another specimen; NaN: nothing can be told"),
    Variable("next_high", "m s-1", "about the upper end of the interval of quiet_above with these two points",
             comment="of repeats with another specimen; NaN: nothing can be told"),
    Variable("margin", "1", "belt speed over quiet_above",
             comment="above 1: quiet; of a range of belt speeds that of its slowest"),
    Variable("worst_speed", "m s-1", "belt speed of a range at which the vibration is largest",
             comment="its slowest where it is quiet throughout"),
    Variable("vibrating_share", "1", "share of a range of belt speeds in which the pair vibrates",
             comment="of the places looked at, which are spaced by equal ratios"),
    Variable("quiet_probability", "1", "probability of being quiet at the belt speed",
             comment="as far as the scatter of the points goes; draws without a verdict do not count as quiet"),
    Variable("undecided_probability", "1", "share of the curves drawn without a verdict at the belt speed"),
    *(v for v in VARIABLES.values() if v.name in ("regime", "frequency", "stick_fraction", "tendency")),
    *(Variable(name, SEARCHABLE[name].units, SEARCHABLE[name].long_name) for name in (*FITTED, "mu_stop")),
    Variable("residual_rms", "1", "residual of the fit, root mean square"),
    Variable("points", "1", "measured points"),
    Variable("slowest_point", "m s-1", "slowest measured speed"),
    Variable("fastest_point", "m s-1", "fastest measured speed"),
    Variable("fit_good", "1", "whether the points determine the curve"),
    *(Variable(f"quiet_above_over_{name}", "m s-1", f"belt speed above which the pair is quiet, over {what}",
               comment="0: no vibration at any speed searched; inf: up to the fastest of them; NaN: not determined")
      for name, what in {"damping": "damping", "normal_load": "load", "friction_scale": "scale of friction"}.items()),
    Variable("friction", "1", "friction coefficient of the fitted curve"),
    Variable("friction_low", "1", "lower end of the 95 % band of the fitted curve"),
    Variable("friction_high", "1", "upper end of the 95 % band of the fitted curve"),
    Variable("point_friction", "1", "measured friction coefficient"),
    Variable("point_sigma", "1", "standard deviation of the measured friction coefficient"),
)  # fmt: skip

LEVEL = Variable(
    "acceleration_level_a", "1", "time-average A-weighted level of the acceleration, dB re 1e-6 m/s2",
    comment="Of the limit cycle, from the Fourier series of one period, up to 20 kHz; IEC 61672-1, ISO 1683. No level "
    "of sound pressure: levels of cells can be compared with each other. NaN where there is no cycle; -inf where "
    "nothing of it is heard.",
)  # fmt: skip

COMPUTED = Variable("computed", "1", "whether a cell was computed or its regime was inferred")
MAP_VARIABLES: dict[str, Variable] = VARIABLES | {COMPUTED.name: COMPUTED}
LEVEL_VARIABLES: dict[str, Variable] = {
    name: VARIABLES[name] for name in ("regime", "status", "period", "frequency", "damping_ratio")
} | {LEVEL.name: LEVEL}


def variables_of_model(model: Model) -> dict[str, Variable]:
    """The variables of a cell whose contact follows this model."""
    own = {variable.name for variable in model.results}
    return {name: row for name, row in VARIABLES.items() if name not in _OF_MODELS or name in own}
