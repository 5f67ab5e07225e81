"""The hot loops: one trial step of WIDTH trajectories at once.

Branch-free loops over the lanes of one flat buffer, which LLVM turns into full-width vector code (a test looks at the
assembly). A step is tried by its Taylor series where the law allows it (`taylor.py`), else by Runge-Kutta
(`rk_lanes.py`). Accepting, rejecting and choosing the next step are part of the loops. Whatever is rare only raises the
lane's FLAG; the scalar code (`modes.py`) then looks at that lane before the step is committed.
"""

from numba.extending import overload

from . import rk_lanes, taylor
from .bits import select
from .jit import compiled
from .laws import is_exponential
from .layout import (
    B, BAND2, DW, DW_NEW, DW_NEXT, DW_TOP, FLAG, GOOD, HEAT, HEAT_NEXT, JERK, JERK_NEW, JERK_NEXT, LEVEL, MARK,
    RADIUS2, SIDE, STATE_NUMBERS, STEP, TAKEN, TAU, TAU_END, TAU_NEXT, TRIED, TURN, W, WEAK, WEAK_NEW, WEAK_NEXT,
    WIDTH, WORK, W_NEW, W_NEXT, W_TOP, Y, Y_NEW, Y_NEXT, Y_STAR,
)  # fmt: skip

SMALLEST_STEP = 1e-13
UNCOUNTED = {"_nrt": False, "error_model": "numpy"}


# --- the step: what a law is stepped by -----------------------------------------------------------------------------


def try_step(law, s, rtol):
    """Try a step in every lane: its end, the work done, whether it is GOOD (compiled code only)."""
    raise NotImplementedError


def interpolate(law, s, i):
    """Have rows SERIES of lane i hold the motion over its step (compiled code only)."""
    raise NotImplementedError


def begin_stepping(law, s, i, cells, c):
    """Choose the first step of a slip of cell c in lane i (compiled code only)."""
    raise NotImplementedError


def restart(law, s, i, h):
    """Let the next step of lane i, after a change of mode, be of about the size h (compiled code only)."""
    raise NotImplementedError


@overload(try_step, jit_options=UNCOUNTED)
def _try_step(law, s, rtol):
    if is_exponential(law):
        return lambda law, s, rtol: taylor.try_step(s, rtol)
    return lambda law, s, rtol: rk_lanes.try_step(law, s, rtol)


@overload(interpolate, jit_options=UNCOUNTED)
def _interpolate(law, s, i):
    if is_exponential(law):
        return lambda law, s, i: None
    return lambda law, s, i: rk_lanes.interpolate(s, i)


@overload(begin_stepping, jit_options=UNCOUNTED)
def _begin_stepping(law, s, i, cells, c):
    if is_exponential(law):
        return lambda law, s, i, cells, c: taylor.restart(s, i)
    return lambda law, s, i, cells, c: rk_lanes.begin_stepping(law, s, i, cells, c)


@overload(restart, jit_options=UNCOUNTED)
def _restart(law, s, i, h):
    if is_exponential(law):
        return lambda law, s, i, h: taylor.restart(s, i)
    return lambda law, s, i, h: rk_lanes.restart(s, i, h)


# --- all lanes ------------------------------------------------------------------------------------------------------


@compiled
def step_lanes(law, lanes, rtol, max_steps):
    """Try one step in every lane; commit it where it is good and nothing happened, else leave it as a candidate.

    law : tag of the friction law (`laws`). lanes : float64, LANE_NUMBERS long, changed in place; idle ones compute
        numbers nobody reads.
    rtol : tolerance of a step relative to the amplitude. max_steps : trial steps a cell may take.
    """
    try_step(law, lanes, rtol)
    watch_and_commit(lanes, max_steps)


@compiled
def watch_and_commit(s, max_steps):
    """Raise flags where something happened inside the step; commit the other good steps."""
    for i in range(WIDTH):
        y, w, dw, jerk, b = s[Y_NEW + i], s[W_NEW + i], s[DW_NEW + i], s[JERK_NEW + i], s[B + i]
        w0, dw0, jerk0, h = s[W + i], s[DW + i], s[JERK + i], s[TAKEN + i]
        # Guards, turned so that the level is reached from below and a turning point is a maximum.
        side = s[SIDE + i]
        level = side * s[LEVEL + i]
        d0, d1, j0, j1 = side * dw0, side * dw, side * jerk0, side * jerk
        reached = side * w >= level
        # An extremum inside the step is taken to be no higher than the nearer end plus h times the larger slope there.
        grazed = (d0 > 0.0) & (d1 <= 0.0) & (max(side * w0, side * w) + h * max(d0, -d1) >= level)
        turned = (d1 <= 0.0) | ((j0 < 0.0) & (j1 > 0.0) & (min(d0, d1) - h * max(-j0, j1) <= 0.0))
        # Extrema: of u each, for they are counted; of w and w' only those that can be the largest so far.
        peak = (dw0 * dw < 0.0) & (max(w0, w) + h * max(abs(dw0), abs(dw)) >= s[W_TOP + i])
        steepest = (jerk0 * jerk < 0.0) & (max(abs(dw0), abs(dw)) + h * max(abs(jerk0), abs(jerk)) >= s[DW_TOP + i])
        extremum = ((w0 > b) != (w > b)) | peak | steepest
        p, q = y - s[Y_STAR + i], w - b
        p0, q0, distance2 = s[Y + i] - s[Y_STAR + i], w0 - b, p * p + q * q
        entered = (p0 * p0 + q0 * q0 >= s[BAND2 + i]) & (distance2 < s[BAND2 + i])
        look = reached | grazed | ((s[TURN + i] > 0.0) & turned) | ((s[MARK + i] > 0.0) & extremum)
        look = look | entered | (distance2 < s[RADIUS2 + i]) | (s[TAU + i] + h >= s[TAU_END + i])
        good = s[GOOD + i] > 0.0
        look = look & good
        tried = s[TRIED + i] + 1.0
        possible = s[STEP + i] >= SMALLEST_STEP
        halted = (tried >= max_steps) | (not possible)
        commit = good & (not look) & (not halted)
        s[FLAG + i] = select(halted, 2.0, select(look, 1.0, 0.0))
        s[TRIED + i] = tried
        s[Y_NEXT + i] = select(commit, y, s[Y + i])
        s[W_NEXT + i] = select(commit, w, w0)
        s[DW_NEXT + i] = select(commit, dw, dw0)
        s[JERK_NEXT + i] = select(commit, jerk, jerk0)
        s[WEAK_NEXT + i] = select(commit, s[WEAK_NEW + i], s[WEAK + i])
        s[TAU_NEXT + i] = s[TAU + i] + select(commit, h, 0.0)
        s[HEAT_NEXT + i] = s[HEAT + i] + select(commit, s[WORK + i], 0.0)
    # The state is copied back from rows of its own: storing a select where it was loaded from becomes a masked store,
    # at 40 cycles each on some processors (Zen 3).
    for i in range(STATE_NUMBERS):
        s[i] = s[STATE_NUMBERS + i]
