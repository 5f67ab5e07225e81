"""The hot loops: one trial step of WIDTH trajectories at once.

Branch-free loops over the lanes of one flat buffer, which LLVM turns into full-width vector code (a test looks at the
assembly). A step is tried by its Taylor series where the law allows it (`taylor.py`), else by Runge-Kutta
(`rk_lanes.py`). Accepting, rejecting and choosing the next step are part of the loops. Whatever is rare only raises the
lane's FLAG; the scalar code (`modes.py`) then looks at that lane before the step is committed.
"""

from typing import Any

from numba.extending import overload

from . import rk_lanes, roots, taylor
from .bits import select
from .jit import compiled
from .laws import is_exponential
from .layout import (
    B, BAND2, DW, DW_NEW, DW_NEXT, DW_TOP, EXTREMUM, FLAG, GOOD, HEAT, HEAT_NEXT, JERK, JERK_NEW, JERK_NEXT, LEVEL,
    MARK, QUIET, QUIET_NEXT, RADIUS2, SIDE, SMALLEST_STEP, STATE_NUMBERS, STEP, TAKEN, TAU, TAU_END, TAU_NEXT,
    TRIED, TURN, TURNED_QUIETLY, W, WEAK, WEAK_NEW, WEAK_NEXT, WIDTH, WORK, W_NEW, W_NEXT, W_TOP, Y, Y_HIGH, Y_LOW,
    Y_NEW, Y_NEXT, Y_STAR,
)  # fmt: skip

UNCOUNTED: Any = {"_nrt": False, "error_model": "numpy"}  # as in `jit.compiled`


# --- the step: what a law is stepped by -----------------------------------------------------------------------------


def try_step(law, s, rtol):
    """Try a step in every lane: its end, the work done, whether it is GOOD (compiled code only)."""
    raise NotImplementedError


def begin_stepping(law, s, i, cells, c):
    """Choose the first step of a slip of cell c in lane i (compiled code only)."""
    raise NotImplementedError


def restart(law, s, i, h):
    """Let the next step of lane i, after a change of mode, be of about the size h (compiled code only)."""
    raise NotImplementedError


def extreme_slope(law, s, i, h, at_end):
    """w' where w'' of lane i vanishes within h; at_end as for `roots.arrival` (compiled code only)."""
    raise NotImplementedError


@overload(try_step, jit_options=UNCOUNTED)
def _try_step(law, s, rtol):
    if is_exponential(law):
        return lambda law, s, rtol: taylor.try_step(s, rtol)
    return lambda law, s, rtol: rk_lanes.try_step(law, s, rtol)


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


@overload(extreme_slope, jit_options=UNCOUNTED)
def _extreme_slope(law, s, i, h, at_end):
    if is_exponential(law):
        return lambda law, s, i, h, at_end: roots.extreme_slope(s, i, h, at_end)
    return lambda law, s, i, h, at_end: rk_lanes.extreme_slope(law, s, i, h, at_end[2])


# --- all lanes ------------------------------------------------------------------------------------------------------


@compiled
def step_lanes(law, lanes, rtol, max_steps):
    """Try one step in every lane; commit it where it is good and nothing happened, else leave it as a candidate.

    law : tag of the friction law (`laws`). lanes : float64, LANE_NUMBERS long, changed in place; idle ones compute
        numbers nobody reads.
    rtol : tolerance of a step relative to the amplitude. max_steps : trial steps a cell may take.
    """
    try_step(law, lanes, rtol)
    watch_extrema(lanes)
    watch_and_commit(lanes, max_steps)


@compiled(inline=True)
def reach(a, b, h):
    """How far beyond the nearer end an extremum within h may lie, its slopes at the ends being a and b.

    A bound where the slope only falls, or only rises, on the way.
    """
    return h * min(abs(a), abs(b))


@compiled
def watch_extrema(s):
    """Mark the lanes whose step holds an extremum to be looked at, and those in which u turns without need of it."""
    for i in range(WIDTH):
        y0, y, w0, w, h = s[Y + i], s[Y_NEW + i], s[W + i], s[W_NEW + i], s[TAKEN + i]
        dw0, dw, jerk0, jerk = s[DW + i], s[DW_NEW + i], s[JERK + i], s[JERK_NEW + i]
        # Extrema of w and w' are looked at where they can be the largest so far, those of u also near the equilibrium,
        # where it is not plain from the ends of the step that u turns back from beyond the settling band.
        peak = (dw0 * dw < 0.0) & (max(w0, w) + reach(dw0, dw, h) >= s[W_TOP + i])
        steepest = (jerk0 * jerk < 0.0) & (max(abs(dw0), abs(dw)) + reach(jerk0, jerk, h) >= s[DW_TOP + i])
        p0, p, q0, q = y0 - s[Y_STAR + i], y - s[Y_STAR + i], w0 - s[B + i], w - s[B + i]
        # Sharper than `reach`, with a quarter to spare: it decides whether an oscillation that rings down is looked at.
        turn, slopes, beyond = (q0 > 0.0) != (q > 0.0), abs(q0) + abs(q), 1.25 * h * abs(q0 * q)
        known = (s[Y_HIGH + i] - max(y0, y)) * slopes > beyond
        known = known & ((min(y0, y) - s[Y_LOW + i]) * slopes > beyond)
        outward = (q * p > 0.0) & (p * p0 > 0.0) & (min(p * p, p0 * p0) > s[BAND2 + i])
        quiet = turn & known & outward & (s[QUIET + i] > 0.0)
        marked = s[MARK + i] > 0.0
        s[EXTREMUM + i] = select(marked & ((turn & (not quiet)) | peak | steepest), 1.0, 0.0)
        s[TURNED_QUIETLY + i] = select(quiet, 1.0, 0.0)


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
        p, q = y - s[Y_STAR + i], w - b
        p0, q0, distance2 = s[Y + i] - s[Y_STAR + i], w0 - b, p * p + q * q
        entered = (p0 * p0 + q0 * q0 >= s[BAND2 + i]) & (distance2 < s[BAND2 + i])
        look = reached | grazed | ((s[TURN + i] > 0.0) & turned) | (s[EXTREMUM + i] > 0.0)
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
        s[QUIET_NEXT + i] = s[QUIET + i] - select(commit, s[TURNED_QUIETLY + i], 0.0)
    # The state is copied back from rows of its own: storing a select where it was loaded from becomes a masked store,
    # at 40 cycles each on some processors (Zen 3).
    for i in range(STATE_NUMBERS):
        s[i] = s[STATE_NUMBERS + i]
