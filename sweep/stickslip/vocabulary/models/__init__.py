"""The models of the contact, a file each; `model.py` says what a model consists of.

A new one is a file and a row in `MODELS`. The `law` that users name chooses the model. Laws of one's own
(`own_laws.py` beside this folder) are added to the models of a friction curve while the program runs.
"""

from collections.abc import Container
from typing import Any

from stickslip.vocabulary.models.memory import BRISTLES_ON_ANY, LUGRE, ON_POSITIVE, RATE_STATE, STIFFNESS
from stickslip.vocabulary.models.model import (
    KNOWN_OWN,
    OWN_NAME,
    PREFIX,
    ROUNDING,
    TABLE,
    Curve,
    Model,
    OnBristles,
    OwnKernels,
    OwnLaw,
    Rule,
    coefficients_of,
    kernel_of,
    law_remedy,
    own_law,
    own_names,
)
from stickslip.vocabulary.models.stribeck import BREAKAWAY, CURVE, FITTED, FORMULA, OF_ANY_SHAPE, STRIBECK

MODELS: tuple[Model, ...] = (STRIBECK, RATE_STATE, LUGRE)
LAW_MESSAGES = {law: text for model in MODELS for law, text in model.laws.items()}
LAWS = tuple(LAW_MESSAGES)
CURVE_LAWS = tuple(STRIBECK.laws)  # those of a friction curve and nothing else
WRITTEN_LAWS = tuple(law for model in MODELS if not model.implied for law in model.laws)  # what people name
_OF_LAW = {law: model for model in MODELS for law in model.laws}

__all__ = [
    "BREAKAWAY", "CURVE", "CURVE_LAWS", "FITTED", "FORMULA", "LAWS", "LAW_MESSAGES", "MODELS", "OWN_NAME", "PREFIX",
    "ROUNDING", "STIFFNESS", "STRIBECK", "TABLE", "WRITTEN_LAWS", "Curve", "Model", "OnBristles", "OwnKernels",
    "OwnLaw", "Rule", "add_law", "coefficients_of", "kernel_of", "law_of_contact", "law_remedy", "laws_with",
    "model_of", "model_with", "own_law", "own_names",
]  # fmt: skip


def add_law(own: OwnLaw) -> None:
    """Let a law of one's own be one of the models of a friction curve, in place of one that had its name."""
    rules = ON_POSITIVE if own.positive else BRISTLES_ON_ANY
    for model, name, ruled in ((STRIBECK, str(own), OF_ANY_SHAPE), (LUGRE, f"{PREFIX}{own}", rules)):
        model.laws[name] = LAW_MESSAGES[name] = own.text
        model.rules[name], _OF_LAW[name] = ruled, model
    KNOWN_OWN[str(own)] = own


def model_of(name: str) -> Model:
    """The model that a law belongs to."""
    return _OF_LAW[name]


def law_of_contact(name: str, quantities: Any) -> str:
    """The law of cells with these quantities: that of bristles on its curve where they have a stiffness."""
    return f"{PREFIX}{name}" if STIFFNESS in quantities and name in STRIBECK.laws else name


def laws_with(name: str) -> tuple[str, ...]:
    """The laws whose cells may have a quantity: all for what is of no model."""
    own = [model for model in MODELS if name in model.parameters or name in model.measured]
    return (
        tuple(law for model in own for law in model.of_laws.get(name, tuple(model.laws)))
        if own
        else tuple(LAW_MESSAGES)
    )


def model_with(names: Container[Any]) -> Model:
    """The model of cells that have parameters of these names."""
    able = [model for model in MODELS if all(name in names for name in model.needed)]
    if not able:
        raise KeyError(f"no model has all it needs among {names}")
    return max(able, key=lambda model: len(model.needed))
