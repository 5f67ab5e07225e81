"""Every quantity a configuration may name.

These are the `PARAMETERS` of a cell (the inputs of the engine, all in SI): those of the oscillator and its start, and
those of all models of the contact (`models/`); what people measure instead of some of them (`MEASURED`); and those of
extensions. `settings.py` has all other numbers.
"""

from math import inf

from stickslip import extensions
from stickslip.vocabulary.models import MODELS, Model
from stickslip.vocabulary.parameter import NAN, SPEED, Parameter, table

_BODY = table(
    # Oscillators that stick and slip weigh up to a machine table, and their specimens and strokes are shorter than a
    # metre.
    Parameter("mass", "kg", "mass", "system", above=0, plausible=(50.0, inf), synonyms="m"),
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
    Parameter("displacement", "m", "displacement at the start", "start", default=0.0, plausible=(10.0, inf)),
    Parameter(
        "velocity", "m s-1", "velocity at the start", "start",
        default=NAN, word="sticking", absent="that of the belt, sticking", plausible=SPEED,
    ),
    Parameter("contact_time", "s", "hold time: time in contact before the start", "start", default=0.0, at_least=0),
)  # fmt: skip
# Of a cell whose contact follows a model, in their order.
PARAMETERS_OF = {model: {**_BODY, **model.parameters, **_START} for model in MODELS}

OSCILLATOR = tuple(_BODY)
PARAMETERS: dict[str, Parameter] = {**_BODY, **{n: row for m in MODELS for n, row in m.parameters.items()}, **_START}
MEASURED: dict[str, Parameter] = {name: row for model in MODELS for name, row in model.measured.items()}
SEARCHABLE = {**PARAMETERS, **MEASURED}  # what borders are searched along


# What extensions bring, of cells that belong to their studies.
OF_EXTENSIONS: dict[str, Parameter] = {
    name: row for place in extensions.brought("quantities").values() for name, row in extensions.imported(place).items()
}

QUANTITIES: dict[str, Parameter] = PARAMETERS | MEASURED | OF_EXTENSIONS


def quantities_of_model(model: Model) -> dict[str, Parameter]:
    """Those of `QUANTITIES` that a configuration with this model may name."""
    return PARAMETERS_OF[model] | dict(model.measured) | OF_EXTENSIONS
