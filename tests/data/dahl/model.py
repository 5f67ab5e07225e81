"""Dahl's model of the contact: friction is a spring that yields."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

from stickslip.vocabulary.models.model import Model, Values
from stickslip.vocabulary.parameter import Parameter, table

if TYPE_CHECKING:
    from stickslip.vocabulary.cells import Floats
    from stickslip.vocabulary.models.model import Scales


@dataclass(frozen=True, eq=False)
class _Dahl(Model):
    def to_kernel(self, cells: Values, by: Scales) -> dict[str, Floats]:
        return {"OWN_0": cells["friction_limit"], "OWN_1": cells["contact_stiffness"] / by.stiffness}


DAHL = _Dahl(
    laws={"dahl": "a spring that yields, Dahl (1968)"},
    parameters=table(
        Parameter("friction_limit", "1", "friction coefficient of steady sliding", "friction", above=0),
        Parameter("contact_stiffness", "N m-1", "stiffness of the contact", "friction", above=0),
    ),
    levels=("friction_limit",),
)
