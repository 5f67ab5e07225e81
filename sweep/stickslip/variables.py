"""Every quantity that enters or leaves the engine, declared once.

`PARAMETERS` are what a cell is made of (the inputs, all in SI), `VARIABLES` are what the engine says of a cell (the
outputs), `TRACE_VARIABLES` what it says of one trajectory over time. Configuration, grid, dataset, plots and
documentation read these tables; nothing else repeats a unit or a long name. Units are spelled as UDUNITS wants them
(``m s-1``).
"""

from __future__ import annotations

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


@dataclass(frozen=True)
class Variable:
    """One output per cell.

    when : "always", or "full" for those that only a run to the horizon (early_stop=False) defines.
    comment : what the long name does not say, or nothing.
    """

    name: str
    units: str
    long_name: str
    when: str = "always"
    comment: str = ""


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

_VARIABLES = (
    Variable("regime", "1", "regime of motion"),
    Variable("status", "1", "how the integration ended"),
    Variable("breakaway_time", "s", "time of the first break-away"),
    Variable("restick_time", "s", "time of the first re-stick"),
    Variable("restick_displacement", "m", "displacement at the first re-stick"),
    Variable("period", "s", "period of the limit cycle"),
    Variable("frequency", "s-1", "frequency of the limit cycle"),
    Variable("stick_fraction", "1", "share of the period spent sticking"),
    Variable("spring_force_max", "N", "largest spring force since the first break-away, or since the start"),
    Variable("spring_force_min", "N", "smallest spring force since the first break-away, or since the start"),
    Variable("slip_speed_max", "m s-1", "largest slip speed"),
    Variable("acceleration_max", "m s-2", "largest magnitude of the acceleration"),
    Variable("mu_reversal", "1", "friction coefficient at the reversal point as it occurred"),
    Variable("mu_breakaway", "1", "friction coefficient at the last break-away, ageing included"),
    Variable(
        "tendency",
        "1",
        "stick-slip tendency mu_breakaway - 2 mu_reversal + mu_stop",
        comment="Eq. (3) with what occurred in this motion: friction at break-away, mu_static and ageing included, and "
        "at reversal, which is not the minimum of the curve. It diagnoses a motion, it does not predict one.",
    ),
    Variable("energy_per_cycle", "J", "friction heat per cycle"),
    Variable("equilibrium_crossings", "1", "crossings of the equilibrium with extrema outside the settling band"),
    Variable("settling_time", "s", "time from first slip until the amplitude stays inside the settling band"),
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
)

_TRACE_VARIABLES = (
    Variable("displacement", "m", "displacement"),
    Variable("velocity", "m s-1", "velocity"),
    Variable("relative_speed", "m s-1", "relative speed, belt minus mass"),
    Variable("friction_coefficient", "1", "friction force over normal load"),
    Variable("spring_force", "N", "spring force"),
    Variable("acceleration", "m s-2", "acceleration"),
    Variable("mode", "1", "contact mode"),
)

PARAMETERS: dict[str, Parameter] = {p.name: p for p in _PARAMETERS}
VARIABLES: dict[str, Variable] = {v.name: v for v in _VARIABLES}
TRACE_VARIABLES: dict[str, Variable] = {v.name: v for v in _TRACE_VARIABLES}

# Flags: the value is the position. design: regimes are int8 and 0 means "nobody computed this cell".
REGIME_MESSAGES = {
    "not_computed": "this cell was not computed",
    "stick_slip": "a limit cycle with a stick phase",
    "damped": "settles to steady sliding, crossing the equilibrium at least twice",
    "creep": "overdamped approach: settles to steady sliding, crossing the equilibrium at most once",
    "sustained": "oscillates for ever without sticking",
    "stuck": "never breaks away",
    "unresolved": "not decided: the horizon or the step budget ran out, or growth cannot be told from decay",
    "failed": "no number could be computed; the status says why",
}
STATUS_MESSAGES = {
    "not_run": "this cell was not computed",
    "cycle_closed": "one full cycle from break-away to break-away was closed",
    "settled": "the motion came into the settling band, from where it is proven that it stays",
    "slip_cycle": "a cycle of slip in one direction came back to where it was",
    "never_breaks_away": "the contact sticks for ever",
    "horizon_reached": "the horizon was reached; raise `horizon` to see more",
    "step_limit": "the step budget ran out; raise `max_steps`",
    "step_underflow": "the step size fell below rounding",
    "not_finite": "a number was not finite",
    "neutral_ringing": "a free vibration that nothing damps or feeds came back to where it was",
    "two_way_slip_cycle": "a cycle of slip in both directions, without sticking, came back to where it was",
    "fall_hold_cycle": "a cycle of slip down the line of a hysteretic curve and up again came back to where it was",
    "settling_observed": "the peaks of a chain of falls and holds shrank inside the settling band: seen, not proven",
    "settling_certain": "the settling band was not reached, but it is proven that nothing else is left",
    "too_slow_to_tell": "the amplitude grows or decays too slowly for the integration to tell which",
    "negative_friction": "the slip reached speeds at which the law makes the friction coefficient negative",
}
MODE_MESSAGES = {
    "stick": "the mass rides on the belt",
    "rise": "slip on the Stribeck curve (on a hysteretic one: below its minimum)",
    "fast": "slip on a hysteretic Stribeck curve at or above its minimum",
    "fall": "slip on the straight line of a hysteretic curve",
    "hold": "slip at constant speed, friction between the line and the curve",
}
# Shapes of the weakening of friction: mu = a1 + a2 w + a3 shape(w/a4), shape(0) = 1.
LAW_MESSAGES = {
    "stribeck": "exp(-w/a4), Eq. (2) of the article",
    "stribeck_delta": "exp(-(w/a4)^delta), delta = 2 being Gaussian",
    "rational": "1/(1 + w/a4), the law of Leine et al. (1998) with a1 = a2 = 0",
    "cubic": "1 - 3/2 w/a4 + 1/2 (w/a4)^3, the law of Thomsen and Fidlin (2003) with a2 = 0",
}
LAWS = tuple(LAW_MESSAGES)
REGIMES = tuple(REGIME_MESSAGES)
STATUSES = tuple(STATUS_MESSAGES)
MODES = tuple(MODE_MESSAGES)
FLAGS: dict[str, dict[str, str]] = {"regime": REGIME_MESSAGES, "status": STATUS_MESSAGES, "mode": MODE_MESSAGES}

# What is said beside a flag that has another name in the field.
_ALSO = {"creep": "overdamped"}


def flag_label(name: str) -> str:
    """The name of a flag as people read it in tables and legends."""
    return f"{name} ({_ALSO[name]})" if name in _ALSO else name
