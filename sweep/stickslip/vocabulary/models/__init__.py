"""The models of the contact, a file each; `model.py` says what a model consists of.

A new one is a file and a row in `MODELS`. The `law` that users name chooses the model.
"""

from __future__ import annotations

from collections.abc import Container
from typing import Any

from stickslip.vocabulary.models.lugre import LUGRE, law_of_contact
from stickslip.vocabulary.models.model import ROUNDING, Curve, Model, OwnKernels, Rule, Slider
from stickslip.vocabulary.models.rate_state import RATE_STATE
from stickslip.vocabulary.models.stribeck import BREAKAWAY, CURVE, FITTED, FORMULA, STRIBECK

MODELS: tuple[Model, ...] = (STRIBECK, RATE_STATE, LUGRE)
LAW_MESSAGES = {law: text for model in MODELS for law, text in model.laws.items()}
LAWS = tuple(LAW_MESSAGES)
CURVE_LAWS = tuple(STRIBECK.laws)  # those of a friction curve and nothing else
WRITTEN_LAWS = tuple(law for model in MODELS if not model.implied for law in model.laws)  # what people name
_OF_LAW = {law: model for model in MODELS for law in model.laws}

__all__ = [
    "BREAKAWAY", "CURVE", "CURVE_LAWS", "FITTED", "FORMULA", "LAWS", "LAW_MESSAGES", "MODELS", "ROUNDING", "STRIBECK",
    "WRITTEN_LAWS", "Curve", "Model", "OwnKernels", "Rule", "Slider", "law_of_contact", "laws_with", "model_of",
    "model_with",
]  # fmt: skip


def model_of(law: str) -> Model:
    """The model that a law belongs to."""
    return _OF_LAW[law]


def laws_with(name: str) -> tuple[str, ...]:
    """The laws whose cells may have a quantity: all for what is of no model."""
    own = [model for model in MODELS if name in model.parameters or name in model.measured]
    return tuple(law for model in own for law in model.of_laws.get(name, tuple(model.laws))) if own else LAWS


def model_with(names: Container[Any]) -> Model:
    """The model of cells that have parameters of these names."""
    able = [model for model in MODELS if all(name in names for name in model.needed)]
    if not able:
        raise KeyError(f"no model has all it needs among {names}")
    return max(able, key=lambda model: len(model.needed))
