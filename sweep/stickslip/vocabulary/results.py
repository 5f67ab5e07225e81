"""What comes out: variables, what their integers mean, and kinds of results.

`VARIABLES` are those of a cell, `MAP_VARIABLES` those that a map may have (`computed` where it is refined),
`TRACE_VARIABLES` those of one trajectory over time. Studies and extensions declare those of their results themselves,
as rows of the same kind. Datasets, plots and documentation read these tables; nothing else repeats a unit or a long
name. Units are spelled as UDUNITS requires (``m s-1``). The value of a flag (regimes, ends of an integration, contact
modes) is its position. `STUDIES` are what may be computed instead of a map of every cell, and where each is declared.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from stickslip import extensions
from stickslip.extensions import StudyEntry
from stickslip.vocabulary.models import MODELS
from stickslip.vocabulary.parameter import Variable, table

if TYPE_CHECKING:
    import xarray as xr

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


# --- what integers mean -----------------------------------------------------------------------------------------------

# Regimes are int8 and 0 means "this cell was not computed".
REGIME_MESSAGES = {
    "not_computed": "this cell was not computed",
    "stick_slip": "a limit cycle with a stick phase",
    "damped": "settles to steady sliding, crossing the equilibrium at least twice",
    "creep": "overdamped approach: settles to steady sliding, crossing the equilibrium at most once",
    "sustained": "oscillates indefinitely without sticking",
    "stuck": "never breaks away",
    "unresolved": "not decided: the horizon or the step budget ran out, or growth cannot be distinguished from decay",
    "failed": "no number could be computed; the status says why",
}
STATUS_MESSAGES = {
    "not_run": "this cell was not computed",
    "cycle_closed": "one full cycle was closed: from break-away to break-away, or the state recurred",
    "settled": "the motion came into the settling band, from where it is proven that it stays",
    "slip_cycle": "a limit cycle of slip in one direction: the state recurred",
    "never_breaks_away": "the contact sticks permanently",
    "horizon_reached": "the horizon was reached; raise `horizon` to see more",
    "step_limit": "the step budget ran out; raise `max_steps`",
    "step_underflow": "the step size fell below rounding",
    "not_finite": "a number was not finite",
    "neutral_ringing": "an undamped free vibration: the state recurred",
    "two_way_slip_cycle": "a limit cycle of slip in both directions, without sticking: the state recurred",
    "fall_hold_cycle": "a limit cycle of slip down the line of a hysteretic curve and up the curve: the state recurred",
    "settling_observed": "seen to shrink into the settling band, or to where small motions decay: not proven",
    "settling_certain": "the settling band was not reached, but it is proven that the motion settles",
    "too_slow_to_tell": "the amplitude grows or decays too slowly for the integration to tell the two apart",
    "negative_friction": "the slip reached speeds at which the law makes the friction coefficient negative",
    "hysteresis_undefined": "mu_stop was given for a curve that rises first and falls without end: it has no minimum",
    "irregular": "it sticks again and again, but not in the same way; stick-slip unless steady sliding is stable",
}
MODE_MESSAGES = {
    "stick": "the mass moves with the belt",
    "rise": "slip on the Stribeck curve (on a hysteretic one: below its minimum)",
    "fast": "slip on a hysteretic Stribeck curve at or above its minimum",
    "fall": "slip on the straight line of a hysteretic curve",
    "hold": "slip at constant speed, friction between the line and the curve (Filippov sliding mode)",
}
SHARE_MESSAGES = {
    "not_computed": "this cell was not computed",
    "exact": "the area inside the unstable cycle, or a theorem of the plane (see the attribute share_exact)",
    "sampled": "scrambled Sobol points in the box; the error is the standard error of their randomisations",
}
METHOD_MESSAGES = {
    "not_computed": "there is no border",
    "bisection": "the regime was bisected",
    "restick_margin": "stick-slip ends by grazing there: restick_margin passes zero, and a bracketed secant led to it",
    "growth_rate": "steady sliding loses its stability there, by linear theory; cells whose regime is known lie "
    "border_width apart on both sides",
}
COMPUTED_MESSAGES = {
    "inferred": "not computed itself: its regime is that of the computed cells around it",
    "computed": "computed itself",
}
QUIET_MESSAGES = {
    "not_computed": "this material was not computed",
    "border": "vibration ends there: above, up to the fastest speed searched, nothing vibrates for long",
    "quiet_throughout": "no vibration at any speed searched: the value is the slowest of them, an upper bound",
    "vibrates_throughout": "vibration up to the fastest speed searched: the value is that speed, a lower bound",
    "unresolved": "cells without a verdict lie around the border: the value is where these end, an upper bound",
    "not_determined": "the measured points do not tell where vibration ends, or are no friction coefficients",
}
VERDICT_MESSAGES = {
    "not_computed": "this was not computed",
    "vibrates": "a vibration lasts somewhere in the range, more often than the goal allows",
    "quiet": "no vibration lasts anywhere in the range, as often as the goal wants it",
    "undecided": "cells in the range are unresolved or failed, on which the verdict depends",
    "impossible": "no cell is so: friction at the minimum above that at break-away, say",
}
REGIMES = tuple(REGIME_MESSAGES)
# Codes of regimes that do not say what the motion is, and names of those that do.
UNDECIDED = tuple(REGIMES.index(name) for name in ("not_computed", "unresolved", "failed"))
DECIDED = tuple(name for code, name in enumerate(REGIMES) if code not in UNDECIDED)
STATUSES = tuple(STATUS_MESSAGES)
VERDICTS = tuple(VERDICT_MESSAGES)
MODES = tuple(MODE_MESSAGES)
SHARE_METHODS = tuple(SHARE_MESSAGES)
METHODS = tuple(METHOD_MESSAGES)
QUIET_STATES = tuple(QUIET_MESSAGES)
VIBRATING = ("stick_slip", "sustained")  # regimes in which a vibration lasts
FLAGS: dict[str, dict[str, str]] = {
    "regime": REGIME_MESSAGES, "status": STATUS_MESSAGES, "mode": MODE_MESSAGES, "computed": COMPUTED_MESSAGES,
    "regime_below": REGIME_MESSAGES, "regime_above": REGIME_MESSAGES,
    "regime_throughout": REGIME_MESSAGES, "method": METHOD_MESSAGES,
    "regime_from_stick": REGIME_MESSAGES, "regime_from_sliding": REGIME_MESSAGES, "share_method": SHARE_MESSAGES,
    "regime_left": REGIME_MESSAGES, "regime_right": REGIME_MESSAGES, "quiet_state": QUIET_MESSAGES,
    **dict.fromkeys(("verdict", "verdict_left", "verdict_right"), VERDICT_MESSAGES),
}  # fmt: skip

# Names in the field, beside ours.
_ALSO = {"creep": "overdamped"}


def flag_label(name: str) -> str:
    """The name of a flag as people read it in tables and legends."""
    return f"{name} ({_ALSO[name]})" if name in _ALSO else name


# --- kinds of results -------------------------------------------------------------------------------------------------

# By the key of the section that asks for it, which is the name of the command and the attribute `result` as well.
STUDIES: dict[str, StudyEntry] = {
    "border": StudyEntry("stickslip.studies.border:BorderStudy", "Find where along a parameter the regime changes."),
    "contours": StudyEntry("stickslip.studies.contours:ContourStudy", "Follow the borders of regimes in a plane."),
    "margins": StudyEntry("stickslip.studies.margins:MarginStudy"),
    "attractors": StudyEntry(
        "stickslip.studies.attractors:AttractorStudy", "Find which regimes coexist, and what settles."
    ),
    "ramp": StudyEntry("stickslip.studies.ramp:RampStudy", "Follow attractors up and down a parameter."),
    "refine": StudyEntry("stickslip.studies.refine:RefinedMap"),
    "uncertain": StudyEntry("stickslip.studies.uncertain:SampleStudy"),
} | extensions.brought("studies")
BESIDE = {key: study for study, entry in STUDIES.items() for key in entry.beside}  # sections by key: their study
WITH_UNCERTAIN = tuple(key for key, entry in STUDIES.items() if entry.with_uncertain)  # may stand beside this section

# Results that are no studies, by a variable or a dimension of theirs.
_MARKS = {"time": "trajectory", **extensions.brought("marks")}


def kind_of(ds: xr.Dataset) -> str:
    """The kind of a result: the key of a study, trajectory, comparison, or map."""
    if (kind := ds.attrs.get("result")) in STUDIES:
        return str(kind)
    names = {*map(str, ds.variables), *map(str, ds.dims)}
    return next((kind for mark, kind in _MARKS.items() if mark in names), "map")
