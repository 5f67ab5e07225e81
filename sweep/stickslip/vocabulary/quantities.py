"""What people give and what comes out: every quantity a configuration may name, variables, what their integers mean,
kinds of results; and words in messages: the one that was probably meant, several in a row.

These are the `PARAMETERS` of a cell (the inputs of the engine, all in SI): those of the oscillator and its start, and
those of all models of the contact (`models/`); what people measure instead of some of them (`MEASURED`); and those of
extensions. Symbols of formulas and the field's other words for our quantities (`synonyms`) are never read, since a file
should say the same to everyone; messages name ours.

`VARIABLES` are those of a cell, `MAP_VARIABLES` those that a map may have (`computed` where it is refined),
`TRACE_VARIABLES` those of one trajectory over time. Studies and extensions declare those of their results themselves,
as rows of the same kind. Datasets, plots and documentation read these tables; nothing else repeats a unit or a long
name. Units are spelled as UDUNITS requires (``m s-1``). The value of a flag (regimes, ends of an integration, contact
modes) is its position. `STUDIES` are what may be computed instead of a map of every cell, and where each is declared.
"""

from __future__ import annotations

import difflib
from collections.abc import Iterable
from typing import TYPE_CHECKING

from stickslip import extensions
from stickslip.extensions import StudyEntry
from stickslip.vocabulary.models import MODELS
from stickslip.vocabulary.parameter import NAN, SPEED, Parameter, Variable, table

if TYPE_CHECKING:
    import xarray as xr

_BODY = table(
    # Oscillators that stick and slip weigh up to a machine table, and their specimens and strokes are shorter than a
    # metre.
    Parameter("mass", "kg", "mass", "system", above=0, plausible=50.0, synonyms="m"),
    Parameter("stiffness", "N m-1", "spring stiffness", "system", above=0, synonyms="k spring spring_constant"),
    Parameter(
        "damping", "N s m-1", "viscous damping coefficient", "system", default=0.0, at_least=0,
        synonyms="c d damper dashpot",
    ),
    Parameter("normal_load", "N", "normal load", "system", above=0, synonyms="n fn f_n normal_force force"),
    Parameter(
        "belt_speed", "m s-1", "belt speed", "system", plausible=SPEED,
        synonyms="v v0 v_belt drive_speed sliding_speed sliding_velocity",
    ),
)  # fmt: skip
_START = table(
    Parameter("displacement", "m", "displacement at the start", "start", default=0.0, plausible=10.0),
    Parameter(
        "velocity", "m s-1", "velocity at the start", "start",
        default=NAN, word="sticking", absent="that of the belt, sticking", plausible=SPEED,
    ),
    Parameter("contact_time", "s", "hold time: time in contact before the start", "start", default=0.0, at_least=0),
)  # fmt: skip
# Of a cell whose contact follows a model, in their order.
PARAMETERS_OF = {model: {**_BODY, **model.parameters, **_START} for model in MODELS}

PARAMETERS: dict[str, Parameter] = {**_BODY, **{n: row for m in MODELS for n, row in m.parameters.items()}, **_START}
MEASURED: dict[str, Parameter] = {name: row for model in MODELS for name, row in model.measured.items()}
SEARCHABLE = {**PARAMETERS, **MEASURED}  # what borders are searched along


# What extensions bring, of cells that belong to their studies.
OF_EXTENSIONS: dict[str, Parameter] = {
    name: row for place in extensions.brought("quantities").values() for name, row in extensions.imported(place).items()
}

QUANTITIES: dict[str, Parameter] = PARAMETERS | MEASURED | OF_EXTENSIONS
# Those that a configuration with a model may name.
QUANTITIES_OF = {model: PARAMETERS_OF[model] | dict(model.measured) | OF_EXTENSIONS for model in MODELS}


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
    Parameter("num", "1", "number of points", "axes", at_least=2, at_most=10_000_000, whole=True)
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


# --- columns of measured points ---------------------------------------------------------------------------------------

_MU = Parameter("mu", "1", "friction coefficient", "points", at_least=0)
CURVE_COLUMNS = (
    Parameter("speed", "m s-1", "slip speed", "points", at_least=0),
    _MU,
    Parameter("sigma", "1", "standard deviation of mu", "points", default=NAN, above=0),
)
AGEING_COLUMNS = (Parameter("time", "s", "waiting time", "points", at_least=0), _MU)


# --- words in messages ------------------------------------------------------------------------------------------------


def suggest(word: str, among: Iterable[str]) -> str | None:
    """The word `among` the possible ones that was probably meant: a synonym, or one that is spelled much like it."""
    known = list(among)
    return synonym_of(word, known) or nearest(word, known)


def did_you_mean(word: str, among: Iterable[str]) -> str | None:
    """The question `did you mean mass?` about a word that is none `among` the possible ones; None if none is near."""
    near = suggest(word, among)
    return f"did you mean {near}?" if near else None


def or_meant(word: str, among: Iterable[str], before: str = "; ", otherwise: str = "") -> str:
    """The end of a message about such a word: `; did you mean mass?`, or `otherwise`."""
    question = did_you_mean(word, among)
    return f"{before}{question}" if question else otherwise


def synonym_of(word: str, among: Iterable[str]) -> str | None:
    """Our quantity for what somebody else calls `word`, if it is `among` those that are possible."""
    known, spelled = set(among), word.strip().lower().replace("-", "_").replace(" ", "_")
    rows = (row for name, row in QUANTITIES.items() if name in known)
    return next((row.name for row in rows if spelled in row.synonyms.lower().split()), None)


def nearest(word: str, among: Iterable[str]) -> str | None:
    """The word that is spelled most like `word`, if any comes close."""
    known, spelled = [other for other in among if other != word], word.lower().replace("-", "_").replace(" ", "_")
    if swapped := [other for other in known if sorted(other) == sorted(spelled)]:  # strokse is strokes, not stroke
        return swapped[0]
    if whole := [other for other in known if spelled in other.split("_")]:  # belt is belt_speed rather than delta
        return whole[0]
    close = difflib.get_close_matches(spelled, known, 1, 0.6)
    return close[0] if close else None


def listed(words: Iterable[str], last: str = "or") -> str:
    """Words in a row: ``a, b or c``."""
    *first, final = words
    return f"{', '.join(first)} {last} {final}" if first else final


# --- what comes out ---------------------------------------------------------------------------------------------------


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
