"""Starting states and the regimes that motions from them reach: states drawn in the box that people ask for, and the
smallest disturbances of steady sliding after which it does not come back.
"""

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Annotated

import numpy as np
import scipy  # type: ignore[import-untyped]
from pydantic import Field, field_validator

from stickslip.config.sections import RANGE, Read, StudySection, interval, of_row, refused
from stickslip.engine import Options, Results, Scales, StopFlag, friction_at_belt_speed, solve
from stickslip.studies.lines import decided
from stickslip.studies.search import Flags, Floats, Integers, Labels, Looked, Scan, search_lines
from stickslip.vocabulary.cells import Parameters, taken
from stickslip.vocabulary.models import model_with
from stickslip.vocabulary.parameter import Parameter, Variable, table
from stickslip.vocabulary.quantities import PARAMETERS
from stickslip.vocabulary.results import REGIMES
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


# --- motions ----------------------------------------------------------------------------------------------------------

DISTURBANCE = 1e-4  # of the belt speed: how far from steady sliding a motion is started that is to be near it
SETTLED = (REGIMES.index("damped"), REGIMES.index("creep"))


def settled(regimes: Labels) -> Flags:
    """Return whether a motion settles to steady sliding."""
    return np.isin(regimes, SETTLED)


@dataclass(frozen=True)
class Motions:
    """Computing from starting states of cells.

    Methods raise StoppedError once `stop` is raised: half of what belongs to a cell says nothing. moved : called with
    motions computed, now and then.
    """

    options: Options
    stop: StopFlag
    moved: Callable[[int], None] | None = None

    def regimes(self, cells: Parameters, displacement: Floats, velocity: Floats) -> Labels:
        """The regime each cell reaches from a state."""
        alone = replace(self, options=replace(self.options, variables=("regime",)))
        return np.asarray(alone.results(cells, displacement, velocity)["regime"])

    def results(self, cells: Parameters, displacement: Floats, velocity: Floats) -> Results:
        """All results of cells that start from a state."""
        state = cells | {"displacement": displacement, "velocity": velocity}
        return solve(state, self.options, self.stop, self.moved)

    def from_sliding(self, cells: Parameters, steady: Floats) -> Labels:
        """Regimes from close to steady sliding; not computed where the belt is at rest."""
        moving = np.isfinite(steady)
        regimes = np.zeros(steady.size, np.int8)
        if moving.any():
            state = taken(cells, moving)
            regimes[moving] = self.regimes(state, steady[moving], DISTURBANCE * state["belt_speed"])
        return regimes


def steady_state(cells: Parameters, options: Options) -> Floats:
    """Displacement of steady sliding (m), under any law; NaN where the belt is at rest."""
    by, turn = Scales(cells), np.sign(cells["belt_speed"])
    return np.where(turn == 0, np.nan, turn * (by.load * friction_at_belt_speed(cells, options)) / by.stiffness)


def unloaded(cells: Parameters) -> tuple[Floats, Floats]:
    """The state that sticks with no load on the contact: displacement and velocity."""
    x = -cells["damping"] * cells["belt_speed"] / cells["stiffness"]
    return x, np.full_like(x, np.nan)


# --- cells whose phase plane is not known -----------------------------------------------------------------------------

_SCAN = Scan(1e-4, 10.0, 48, "log")  # of a disturbance, over the scale of the cell
_TOLERANCE = 1e-6
_TOGETHER = 2**16  # motions that are held at once
_LOST, _SETTLES = 0, 1


def _states_in(box: Attractors) -> Floats:
    """Scrambled Sobol points in the box, one randomisation after the other (states, 2), the same for every cell."""
    seeds = np.random.SeedSequence(box.seed).spawn(RANDOMISATIONS)
    sobol = (scipy.stats.qmc.Sobol(2, scramble=True, rng=np.random.default_rng(seed)) for seed in seeds)
    low, high = zip(box.displacement, box.velocity, strict=True)
    return np.asarray(scipy.stats.qmc.scale(np.concatenate([points.random(box.points) for points in sobol]), low, high))


def sampled_shares(cells: Parameters, box: Attractors, work: Motions) -> tuple[Results, Flags]:
    """The shares of the box that settle, with error and bounds, by names of `VARIABLES`; and the regimes that were
    reached (cells, regimes).

    The randomisations are independent and each is unbiased, so that their scatter gives the standard error of their
    mean; that of independent points (the binomial one) would be too large several times, since Sobol points fill the
    box evenly. Where all agree the error is that of one state in all of them.
    """
    states, each = _states_in(box), box.samples
    total = cells["mass"].size * each
    parts = []
    for first in range(0, total, _TOGETHER):
        cell, state = divmod(np.arange(first, min(first + _TOGETHER, total)), each)
        parts.append(work.regimes(taken(cells, cell), states[state, 0], states[state, 1]))
    regimes = np.concatenate(parts).reshape(-1, RANDOMISATIONS, box.points)
    ends, known = settled(regimes), decided(regimes)
    with np.errstate(invalid="ignore"):
        share = ends.sum(axis=(1, 2)) / known.sum(axis=(1, 2))
        parts = ends.sum(axis=2) / known.sum(axis=2)
    error = np.maximum(parts.std(axis=1, ddof=1) / np.sqrt(RANDOMISATIONS), 1.0 / (each + 2))
    low, high = ends.mean(axis=(1, 2)), (ends | ~known).mean(axis=(1, 2))
    results = {"settling_share": share, "share_error": error, "settling_share_low": low, "settling_share_high": high}
    return results, np.stack([(regimes == code).any(axis=(1, 2)) for code in range(len(REGIMES))], axis=1)


def critical_disturbances(cells: Parameters, steady: Floats, work: Motions) -> Results:
    """The smallest disturbances of steady sliding after which it does not come back, of a scan narrowed by halving.

    By names of `VARIABLES`, along and against the motion of the belt; 0 where the smallest of the scan is enough, inf
    where the largest is not, NaN where undecided states come before. They are measured by the speed of the belt, and
    that to which friction deflects the spring.
    """
    by, turn, none = Scales(cells), np.sign(cells["belt_speed"]), np.zeros(steady.size)
    speed = np.abs(cells["belt_speed"]) + by.load * model_with(cells).start_of(cells) / by.impedance
    length = speed * by.time
    smallest = {}
    for way, sign in (("along", turn), ("against", -turn)):
        smallest[f"critical_shock_{way}"] = speed * _first_lost(cells, steady, none, sign * speed, work)
        smallest[f"critical_shift_{way}"] = length * _first_lost(cells, steady, sign * length, none, work)
    return smallest


def _first_lost(cells: Parameters, steady: Floats, shift: Floats, shock: Floats, work: Motions) -> Floats:
    """Return how many times a disturbance of displacement and velocity is enough, per cell."""

    def looked(line: Integers, place: Floats) -> Looked:
        regimes = work.regimes(taken(cells, line), steady[line] + place * shift[line], place * shock[line])
        return Looked(np.where(settled(regimes), _SETTLES, _LOST).astype(np.int8), decided(regimes))

    lines = steady.size
    brackets, _ = search_lines(lines, _SCAN, _TOLERANCE, looked)
    start = looked(np.arange(lines), np.full(lines, _SCAN.low))
    lost = np.where(start.labels == _SETTLES, np.inf, 0.0)
    lost[~start.decided] = np.nan
    for bracket in brackets[::-1]:  # the lowest of a line comes last
        line = bracket["line"]
        if bracket["below"] == _SETTLES and lost[line] != 0.0:
            wide = bracket["high"] - bracket["low"] > 1.5 * _TOLERANCE * bracket["high"]
            lost[line] = np.nan if wide else 0.5 * (bracket["low"] + bracket["high"])
    return lost
