"""Slow ramps of a parameter up and down again: each value starts from where the motion at the one before ended."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from stickslip.basins.starts import DISTURBANCE, SETTLED, Work, settled, unloaded
from stickslip.borders.lines import Lines
from stickslip.engine import Options, Results, StopFlag
from stickslip.vocabulary.cells import Cells, as_cells
from stickslip.vocabulary.flags import REGIMES
from stickslip.vocabulary.parameter import of_section
from stickslip.vocabulary.quantities import PARAMETERS
from stickslip.vocabulary.results import RAMP_VARIABLES

Floats = NDArray[np.float64]
State = tuple[Floats, Floats]

UP, DOWN = "up", "down"
_STICK_SLIP, _SUSTAINED, _STUCK = (REGIMES.index(name) for name in ("stick_slip", "sustained", "stuck"))
_HALVINGS = 30  # of a step of the ramp
_DECIDED = (
    10  # of these, the first ones; closer to the end motions are within the tolerance of it, and may be undecided
)


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
    """By names of `RAMP_VARIABLES`, and `vibration_end`, arrays (lines, direction, values): up first, from an unloaded
    contact that sticks.

    The ramp waits at every value until the motion has come to its attractor: to a cycle or to steady sliding, where a
    disturbance of `DISTURBANCE` of the belt speed is left. Down goes on where up ended. A value where the motion
    stays undecided passes on the state it started from. `vibration_end`, at the last value that vibrates: the one,
    between it and the next, at which vibration gives way to steady sliding; NaN elsewhere, and where that is not known.
    moved : called with values finished, over all lines.
    """
    lines, size = ramp.lines, ramp.lines.size
    others = lines.others(0, size)
    shape = (size, 2, ramp.values.size)
    found: Results = {name: np.full(shape, np.nan) for name in (*RAMP_VARIABLES, "vibration_end")}
    work, state = Work(replace(options, early_stop=True), stop), None
    for direction, order in enumerate((range(ramp.values.size), range(ramp.values.size)[::-1])):
        vibrated, before = np.zeros(size, np.bool_), order[0]
        for i in order:
            cells = as_cells(others | {lines.along: np.full(size, ramp.values[i])})
            state = unloaded(cells) if state is None else state
            results = work.results(cells, *state)
            for name in RAMP_VARIABLES:
                found[name][:, direction, i] = results[name]
            ended = np.flatnonzero(vibrated & settled(results["regime"]))
            if ended.size:
                between, last = (ramp.values[before], ramp.values[i]), (state[0][ended], state[1][ended])
                found["vibration_end"][ended, direction, before] = _end(ramp, ended, between, last, work)
            state = _passed_on(cells, results, state)
            vibrated, before = np.isin(results["regime"], (_STICK_SLIP, _SUSTAINED)), i
            if moved:
                moved(size)
    return found


def _end(ramp: Ramp, at: NDArray[np.intp], between: tuple[float, float], state: State, work: Work) -> Floats:
    """Where vibration ends on lines `at` that vibrate at the first of two values, from which `state` is, and not at the
    other; NaN where a motion between them stays undecided.
    """
    others = {name: values[at] for name, values in ramp.lines.others(0, ramp.lines.size).items()}
    last, first = (np.full(at.size, value) for value in between)  # that vibrates; that does not
    known = np.ones(at.size, np.bool_)
    for k in range(_HALVINGS):
        middle = 0.5 * (last + first)
        cells = as_cells(others | {ramp.lines.along: middle})
        results = work.results(cells, *state)
        vibrates = np.isin(results["regime"], (_STICK_SLIP, _SUSTAINED))
        known &= vibrates | settled(results["regime"]) | (k >= _DECIDED)
        last, first = np.where(vibrates, middle, last), np.where(vibrates, first, middle)
        x, v = _passed_on(cells, results, state)
        state = np.where(vibrates, x, state[0]), np.where(vibrates, v, state[1])
    return np.where(known, 0.5 * (last + first), np.nan)


def _passed_on(cells: Cells, results: Results, state: State) -> State:
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
