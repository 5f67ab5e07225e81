"""The section `attractors`, a box of starting states and how it is sampled, and the variables of its result."""

from typing import Annotated

from pydantic import Field, field_validator

from stickslip.config.sections import RANGE, Read, StudySection, interval, of_row, refused
from stickslip.vocabulary.parameter import Parameter, Variable, table
from stickslip.vocabulary.quantities import PARAMETERS
from stickslip.vocabulary.results import VARIABLES as CELL_VARIABLES

RANDOMISATIONS = 16  # of Sobol points: so many that their scatter is known to a fifth
Interval = tuple[float, float]
_CHANGES = "inf: no change does that; 0: any does"
VARIABLES = table(
    Variable("coexisting", "1", "regimes reached from different starting states"),
    Variable("regime_from_stick", "1", "regime reached from sticking, with no load on the contact"),
    Variable("regime_from_sliding", "1", "regime reached from close to steady sliding"),
    Variable("settling_share", "1", "share of the starting states in the box that settle to steady sliding"),
    Variable("share_error", "1", "standard error of the share that settles; 0 where it is exact"),
    Variable("settling_share_low", "1", "share that settles if no undecided starting state does"),
    Variable("settling_share_high", "1", "share that settles if all undecided starting states do"),
    Variable("share_method", "1", "how the share that settles was found"),
    Variable("unstable_amplitude", "m", "half the range of displacement on the unstable cycle"),
    Variable("unstable_velocity_amplitude", "m s-1", "half the range of velocity on the unstable cycle"),
    Variable("unstable_period", "s", "period of the unstable cycle"),
    Variable("critical_shock", "m s-1", "smallest change of velocity after which steady sliding does not come back",
             comment=_CHANGES),
    Variable("critical_shock_along", "m s-1", "critical change of velocity, along the motion of the belt"),
    Variable("critical_shock_against", "m s-1", "critical change of velocity, against the motion of the belt"),
    Variable("critical_shift", "m", "smallest change of displacement after which steady sliding does not come back",
             comment=_CHANGES),
    Variable("critical_shift_along", "m", "critical change of displacement, along the motion of the belt"),
    Variable("critical_shift_against", "m", "critical change of displacement, against the motion of the belt"),
    CELL_VARIABLES["damping_ratio"],
)  # fmt: skip


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
