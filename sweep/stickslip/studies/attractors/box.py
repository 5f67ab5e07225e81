"""The section `attractors`: the box of starting states, and how finely it is sampled where it has to be."""

from __future__ import annotations

from typing import Annotated

from pydantic import Field, field_validator

from stickslip.config.sections import RANGE, Read, StudySection, interval, of_row, refused
from stickslip.vocabulary.parameter import Parameter, table
from stickslip.vocabulary.quantities import PARAMETERS

RANDOMISATIONS = 16  # of Sobol points: so many that their scatter is known to a fifth
Interval = tuple[float, float]


def _ends(name: str) -> Read:
    return Read(lambda value: interval(PARAMETERS[name], value), RANGE)


class Attractors(StudySection):
    """Which attractors cells have: regimes by starting state, and the share of a box of states that settles."""

    key = "attractors"
    rows = table(
        Parameter("samples", "1", "starting states drawn per cell where the share that settles is not exact", key,
                  default=1024, at_least=RANDOMISATIONS, at_most=2**20, whole=True),
        Parameter("seed", "1", "seed of the starting states: the same seed, the same states", key,
                  default=1, at_least=0, at_most=2**32 - 1, whole=True),
    )  # fmt: skip
    displacement: Annotated[Interval, _ends("displacement")] = Field(
        description="displacements of the box of starting states, [low, high]"
    )
    velocity: Annotated[Interval, _ends("velocity")] = Field(
        description="velocities of the box of starting states, [low, high]"
    )
    samples: int = of_row(rows["samples"])
    seed: int = of_row(rows["seed"])

    @field_validator("samples")
    @classmethod
    def _samples(cls, value: int) -> int:
        points, rest = divmod(value, RANDOMISATIONS)
        if rest or points & (points - 1):
            raise refused(f"{RANDOMISATIONS} times a power of 2")
        return value

    @property
    def points(self) -> int:
        """Points of each randomisation."""
        return self.samples // RANDOMISATIONS

    @property
    def area(self) -> float:
        """Area in the plane of states (m2/s)."""
        (left, right), (low, high) = self.displacement, self.velocity
        return (right - left) * (high - low)
