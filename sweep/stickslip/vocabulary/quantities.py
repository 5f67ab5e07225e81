"""Every quantity a configuration may name, and words in messages: the one that was probably meant, several in a row.

These are the `PARAMETERS` of a cell (the inputs of the engine, all in SI): those of the oscillator and its start, and
those of all models of the contact (`models/`); what people measure instead of some of them (`MEASURED`); and those of
extensions. Symbols of formulas and the field's other words for our quantities (`synonyms`) are never read, since a file
should say the same to everyone; messages name ours.
"""

import difflib
from collections.abc import Iterable

from stickslip import extensions
from stickslip.vocabulary.models import MODELS
from stickslip.vocabulary.parameter import NAN, SPEED, Parameter, table

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
