"""Every quantity that comes out of the engine, declared once.

`VARIABLES` are those of a cell, `MAP_VARIABLES` those that a map may have; each study has a table of its own. A border
and its width are in the units of the parameter searched. Datasets, plots and documentation read these tables; nothing
else repeats a unit or a long name. Units are spelled as UDUNITS requires (``m s-1``).
"""

from __future__ import annotations

from stickslip.vocabulary.models import CURVE, FITTED, MODELS, Model
from stickslip.vocabulary.parameter import Variable, table
from stickslip.vocabulary.quantities import SEARCHABLE

_OF_MODELS = {variable.name: variable for model in MODELS for variable in model.results}
_OF_WHAT = "Of the cycle where there is stick-slip, else of the whole motion."

VARIABLES: dict[str, Variable] = table(
    Variable("regime", "1", "regime of motion"),
    Variable("status", "1", "how the integration ended"),
    Variable("breakaway_time", "s", "time of the first break-away"),
    Variable("restick_time", "s", "time of the first re-stick"),
    Variable("restick_displacement", "m", "displacement at the first re-stick"),
    Variable(
        "restick_margin", "m s-1", "least slip speed of the last slip after a break-away; below 0 where it re-sticks",
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
    Variable("damping_ratio", "1", "linear damping ratio of steady sliding on the curve"),
    Variable("steps", "1", "integration steps tried"),
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

BORDER_VARIABLES: dict[str, Variable] = table(
    Variable("border", "1", "where the regime changes", comment="the middle of the last bracket"),
    Variable("regime_below", "1", "regime just below the border"),
    Variable("regime_above", "1", "regime just above the border"),
    Variable("border_width", "1", "width of the last bracket of the border"),
    Variable("method", "1", "how the border was found"),
    Variable("regime_throughout", "1", "regime all along a line without borders", comment="as far as the scan sees"),
    Variable("scan_undecided", "1", "cells of the scan that were unresolved or failed"),
)

ATTRACTOR_VARIABLES: dict[str, Variable] = table(
    Variable("coexisting", "1", "regimes reached from different starting states"),
    Variable("regime_from_stick", "1", "regime reached from sticking, with no load on the contact"),
    Variable("regime_from_sliding", "1", "regime reached from close to steady sliding"),
    Variable("settling_share", "1", "share of the starting states in the box that settle to steady sliding"),
    Variable("share_error", "1", "standard error of the share that settles; 0 where it is exact"),
    Variable("settling_share_low", "1", "share that settles if no undecided starting state does"),
    Variable("settling_share_high", "1", "share that settles if all undecided starting states do"),
    Variable("share_method", "1", "how the share that settles was found"),
    Variable("unstable_amplitude", "m", "half the range of displacement on the unstable cycle"),
    Variable("unstable_velocity_amplitude", "m s-1", "half the range of velocity on the unstable cycle"),
    Variable("unstable_period", "s", "period of the unstable cycle"),
    Variable(
        "critical_shock", "m s-1", "smallest change of velocity after which steady sliding does not come back",
        comment="inf: no change does that; 0: any does",
    ),
    Variable("critical_shock_along", "m s-1", "critical change of velocity, along the motion of the belt"),
    Variable("critical_shock_against", "m s-1", "critical change of velocity, against the motion of the belt"),
    Variable(
        "critical_shift", "m", "smallest change of displacement after which steady sliding does not come back",
        comment="inf: no change does that; 0: any does",
    ),
    Variable("critical_shift_along", "m", "critical change of displacement, along the motion of the belt"),
    Variable("critical_shift_against", "m", "critical change of displacement, against the motion of the belt"),
    VARIABLES["damping_ratio"],
)  # fmt: skip
_ERROR = "standard error: scatter over independent scramblings"
UNCERTAIN_VARIABLES: dict[str, Variable] = table(
    Variable("probability", "1", "probability of a regime", comment="share of the draws whose regime is known"),
    Variable("probability_error", "1", "standard error of the probability of a regime",
             comment=f"{_ERROR}; at least that of one draw"),
    Variable("probability_low", "1", "lower bound of the probability of a regime",
             comment="no draw that is unresolved or failed has the regime; without the standard error"),
    Variable("probability_high", "1", "upper bound of the probability of a regime",
             comment="all draws that are unresolved or failed have the regime; without the standard error"),
    Variable("undecided", "1", "share of draws that are unresolved or failed"),
    Variable("sobol_first", "1", "first-order Sobol index of being in a regime",
             comment="share of the variance of the indicator that a quantity explains by itself"),
    Variable("sobol_first_error", "1", "standard error of the first-order Sobol index",
             comment=f"{_ERROR}; and what undecided draws could change"),
    Variable("sobol_total", "1", "total Sobol index of being in a regime",
             comment="share of the variance of the indicator that would remain if all other quantities were known"),
    Variable("sobol_total_error", "1", "standard error of the total Sobol index",
             comment=f"{_ERROR}; and what undecided draws could change"),
    Variable("levels", "1", "levels of the subset simulation, the most of all repetitions"),
    Variable("evaluations", "1", "cells computed by all subset simulations of a cell"),
)  # fmt: skip
# What is told of a metric, as a name and a long name to put its own behind.
STATISTICS = {
    "mean": "mean", "mean_error": "standard error of the mean", "quantile": "quantile",
    "quantile_error": "standard error of the quantile", "count": "draws that have",
}  # fmt: skip

CONTOUR_VARIABLES: dict[str, Variable] = table(
    Variable("node_count", "1", "nodes of the line"),
    Variable("closed", "1", "whether the line is a loop", comment="its last node is its first"),
    Variable("regime_left", "1", "regime to the left of the line"),
    Variable("regime_right", "1", "regime to the right of the line"),
    Variable("node_width", "1", "width of the last bracket, over the side of the grid cell it lies on"),
    Variable(
        "node_along", "1", "parameter that was searched along at the node",
        comment="the other one has the value of a grid point; junction: three or more regimes meet inside a grid cell",
    ),
)  # fmt: skip

# Of cells, most of them once per parameter: `margin_stiffness`. Units: "parameter" stands for those of the parameter,
# "flag" for those of a regime.
MARGIN_VARIABLES: dict[str, Variable] = table(
    Variable("margin", "parameter", "distance to the nearest border", comment="border minus value, with its sign"),
    Variable("ratio", "1", "nearest border over the value", comment="NaN where the value is 0 or may change its sign"),
    Variable("border", "parameter", "nearest border on either side"),
    Variable("border_width", "parameter", "width of the last bracket of the border"),
    Variable("beyond", "flag", "regime just past the border"),
    Variable("proposed", "parameter", "value past the border that was simulated"),
    Variable("checked", "flag", "regime of the simulation past the border"),
    Variable("joint_cost", "1", "cost of the cheapest joint change", comment="root of the sum of (cost x change)^2; "
             "changes are logarithms of ratios, or over a scale where the value is 0 or may change its sign"),
    Variable("joint", "parameter", "value after the cheapest joint change"),
    Variable("joint_share", "1", "share of the change in the square of the cost of the cheapest joint change"),
    Variable("joint_proposed", "parameter", "value past the border that was simulated, of the cheapest joint change"),
    Variable("joint_checked", "flag", "regime of the simulation past the border, of the cheapest joint change"),
    Variable("joint_ended", "1", "whether the search of the joint change ended at its limit, 1 or 0",
             comment="1: after so many steps of integration that there may be a cheaper joint change"),
)  # fmt: skip

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
    *(Variable(name, SEARCHABLE[name].units, SEARCHABLE[name].long_name) for name in FITTED),
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
_RAMP = ("regime", "status", "velocity_amplitude", "displacement_amplitude", "period", "stick_fraction")
RAMP_VARIABLES: dict[str, Variable] = {name: VARIABLES[name] for name in _RAMP}
_BETWEEN = ("unstable_amplitude", "unstable_velocity_amplitude", "unstable_period", "damping_ratio")
BETWEEN_VARIABLES: dict[str, Variable] = {name: ATTRACTOR_VARIABLES[name] for name in _BETWEEN}


def variables_of_model(model: Model) -> dict[str, Variable]:
    """The variables of a cell whose contact follows this model."""
    own = {variable.name for variable in model.results}
    return {name: row for name, row in VARIABLES.items() if name not in _OF_MODELS or name in own}
