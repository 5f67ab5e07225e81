"""Slow ramps of a parameter up and down again: each value starts from where the motion at the one before ended."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from stickslip.basins.starts import DISTURBANCE, SETTLED, Work, unloaded
from stickslip.borders.lines import Lines
from stickslip.engine import Options, Results, StopFlag
from stickslip.vocabulary.cells import Cells, as_cells
from stickslip.vocabulary.flags import REGIMES
from stickslip.vocabulary.parameter import of_section
from stickslip.vocabulary.quantities import PARAMETERS
from stickslip.vocabulary.results import RAMP_VARIABLES

Floats = NDArray[np.float64]

UP, DOWN = "up", "down"
_STICK_SLIP, _SUSTAINED, _STUCK = (REGIMES.index(name) for name in ("stick_slip", "sustained", "stuck"))


@dataclass(frozen=True, eq=False)
class Ramp:
    """Lines of cells, and the values (ascending, SI) their parameter goes through, up and down again."""

    lines: Lines
    values: Floats

    def __post_init__(self) -> None:
        if self.lines.along in of_section("start", PARAMETERS.values()):
            raise ValueError(f"along: {self.lines.along} is a starting state, which a ramp carries from value to value")
        for end in self.lines.between:
            as_cells(self.lines.others(0, self.lines.size) | {self.lines.along: np.array([end])})


def follow_ramp(ramp: Ramp, options: Options, stop: StopFlag, moved: Callable[[int], None] | None = None) -> Results:
    """By names of `RAMP_VARIABLES`, arrays (lines, direction, values): up first, from an unloaded contact that sticks.

    The ramp waits at every value until the motion has come to its attractor: to a cycle or to steady sliding, where a
    disturbance of `DISTURBANCE` of the belt speed is left. Down goes on where up ended. A value where the motion
    stays undecided passes on the state it started from. moved : called with values finished, over all lines.
    """
    lines, size = ramp.lines, ramp.lines.size
    others = lines.others(0, size)
    shape = (size, 2, ramp.values.size)
    found: Results = {name: np.full(shape, np.nan) for name in RAMP_VARIABLES}
    work, state = Work(replace(options, early_stop=True), stop), None
    for direction, order in enumerate((range(ramp.values.size), range(ramp.values.size)[::-1])):
        for i in order:
            cells = as_cells(others | {lines.along: np.full(size, ramp.values[i])})
            state = unloaded(cells) if state is None else state
            results = work.results(cells, *state)
            for name, values in found.items():
                values[:, direction, i] = results[name]
            state = _passed_on(cells, results, state)
            if moved:
                moved(size)
    return found


def _passed_on(cells: Cells, results: Results, state: tuple[Floats, Floats]) -> tuple[Floats, Floats]:
    """A state on each attractor.

    Of stick-slip one of the stick phase: the belt then loads the contact up to the break-away of the next value, from
    where the slip is the same whatever was before.
    """
    regime = results["regime"]
    slides, sticks = np.isin(regime, SETTLED), np.isin(regime, (_STICK_SLIP, _STUCK))
    x, v = state
    x = np.where(regime == _STICK_SLIP, results["restick_displacement"], x)
    x = np.where(slides | (regime == _STUCK), results["settled_displacement"], x)
    x = np.where(regime == _SUSTAINED, results["cycle_force_max"] / cells["stiffness"], x)
    v = np.where(sticks, np.nan, np.where(slides, DISTURBANCE * cells["belt_speed"], v))
    return x, np.where(regime == _SUSTAINED, 0.0, v)
