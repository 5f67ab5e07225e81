"""The phase portrait of a single cell: its unstable cycle as a closed line."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from stickslip.basins import plain
from stickslip.basins.cycle import find_cycles, sampled_motion
from stickslip.basins.exact import verdicts
from stickslip.basins.starts import Work
from stickslip.engine import Options, stop_flag
from stickslip.vocabulary.cells import Parameters

Floats = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class Loop:
    """An unstable cycle: displacements (m) and velocities (m/s) of one round, its end being its start; period in s."""

    displacement: Floats
    velocity: Floats
    period: float

    @property
    def velocity_amplitude(self) -> float:
        """Half the range of the velocity (m/s)."""
        return float(np.ptp(self.velocity) / 2.0)


def unstable_cycle(cell: Parameters, regime: int, options: Options, samples: int = 257) -> Loop | None:
    """The unstable cycle of a cell, where the theorems of `plain.py` say that there is one; None elsewhere.

    cell : arrays of length 1. regime : the one it reaches from sticking. On a hysteretic or ageing contact, and under
    other laws than stribeck, nothing is known.
    """
    work = Work(options, stop_flag())
    with np.errstate(invalid="ignore"):
        if not verdicts(cell, np.array([regime], np.int8), work).inside[0]:
            return None
    ahead = plain.forward(cell)
    cycles, back = find_cycles(ahead, work), plain.backwards(ahead)
    if not cycles.found[0]:
        return None
    motion = sampled_motion(back, cycles.reach, cycles.period, samples, options)
    if not motion["velocity"].max() < ahead["belt_speed"][0]:
        return None
    turn = float(np.sign(cell["belt_speed"][0]))
    beyond = motion["displacement"][0] - plain.steady_displacement(back)[0]  # backwards in time its sign is changed
    displacement = plain.steady_displacement(ahead)[0] - beyond
    return Loop(turn * displacement, turn * motion["velocity"][0], float(cycles.period[0]))
