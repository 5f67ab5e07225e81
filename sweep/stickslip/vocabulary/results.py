"""Every quantity that comes out of the engine, declared once.

`VARIABLES` are those of a cell, `MAP_VARIABLES` those that a map may have (`computed` where it is refined),
`TRACE_VARIABLES` those of one trajectory over time. Studies and extensions declare those of their results themselves,
as rows of the same kind. Datasets, plots and documentation read these tables; nothing else repeats a unit or a long
name. Units are spelled as UDUNITS requires (``m s-1``).
"""

from __future__ import annotations

from stickslip.vocabulary.models import MODELS
from stickslip.vocabulary.parameter import Variable, table

_OF_MODELS = {variable.name: variable for model in MODELS for variable in model.results}
_OF_WHAT = "Of the cycle where the motion recurs (stick-slip, sustained), else of the whole motion."

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

COMPUTED = Variable("computed", "1", "whether a cell was computed or its regime was inferred")
MAP_VARIABLES: dict[str, Variable] = VARIABLES | {COMPUTED.name: COMPUTED}


# Those of a cell whose contact follows a model.
VARIABLES_OF = {
    model: {name: row for name, row in VARIABLES.items()
            if name not in _OF_MODELS or name in [variable.name for variable in model.results]}
    for model in MODELS
}  # fmt: skip
