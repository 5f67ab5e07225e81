"""Starting states of motions, and the regimes they reach."""

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from stickslip.engine import Options, Results, Scales, StopFlag, friction_at_belt_speed, solve
from stickslip.vocabulary.cells import Parameters
from stickslip.vocabulary.flags import REGIMES, UNDECIDED

Floats = NDArray[np.float64]
Regimes = NDArray[np.int8]

DISTURBANCE = 1e-4  # of the belt speed: how far from steady sliding a motion is started that is to be near it
SETTLED = (REGIMES.index("damped"), REGIMES.index("creep"))


def settled(regimes: Regimes) -> NDArray[np.bool_]:
    """Return whether a motion settles to steady sliding."""
    return np.isin(regimes, SETTLED)


def decided(regimes: Regimes) -> NDArray[np.bool_]:
    """Return whether it is known what becomes of a motion."""
    return ~np.isin(regimes, UNDECIDED)


@dataclass(frozen=True)
class Motions:
    """Computing from starting states of cells.

    Methods raise StoppedError once `stop` is raised: half of what belongs to a cell says nothing. moved : called with
    motions computed, now and then.
    """

    options: Options
    stop: StopFlag
    moved: Callable[[int], None] | None = None

    def regimes(self, cells: Parameters, displacement: Floats, velocity: Floats) -> Regimes:
        """The regime each cell reaches from a state."""
        alone = replace(self, options=replace(self.options, variables=("regime",)))
        return np.asarray(alone.results(cells, displacement, velocity)["regime"])

    def results(self, cells: Parameters, displacement: Floats, velocity: Floats) -> Results:
        """All results of cells that start from a state."""
        state = cells | {"displacement": displacement, "velocity": velocity}
        return solve(state, self.options, self.stop, self.moved)


def steady_state(cells: Parameters, options: Options) -> Floats:
    """Displacement of steady sliding (m), under any law; NaN where the belt is at rest."""
    by, turn = Scales(cells), np.sign(cells["belt_speed"])
    return np.where(turn == 0, np.nan, turn * (by.load * friction_at_belt_speed(cells, options)) / by.stiffness)


def unloaded(cells: Parameters) -> tuple[Floats, Floats]:
    """The state that sticks with no load on the contact: displacement and velocity."""
    x = -cells["damping"] * cells["belt_speed"] / cells["stiffness"]
    return x, np.full_like(x, np.nan)


def from_sliding(cells: Parameters, steady: Floats, work: Motions) -> Regimes:
    """From close to steady sliding; not computed where the belt is at rest."""
    moving = np.isfinite(steady)
    regimes = np.zeros(steady.size, np.int8)
    if moving.any():
        state = {name: values[moving] for name, values in cells.items()}
        regimes[moving] = work.regimes(state, steady[moving], DISTURBANCE * state["belt_speed"])
    return regimes
