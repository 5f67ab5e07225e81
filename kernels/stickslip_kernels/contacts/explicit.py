"""Explicit steps by the series of the motion, beside implicit ones (`implicit.py`): lanes of one batch step by either.

Rows SERIES have the series of w, rows STATE that of the inner state; BY_SERIES says which lanes step so.
"""

from math import inf

from .. import layout as at
from ..arithmetic import nonzero_bits, rough_exp2, rough_log2, select, widest_vectors
from ..jit import compiled
from ..layout import WIDTH
from ..roots import TO_ROUNDING, end_motion, extreme_speed
from .stribeck.equations import MARGIN

# how long a step may be; the same after one that failed; tolerance of the state in the step; time when stock was taken
ROWS = at.Rows(at.CONTACT, at.SERIES)
MOST, CAP, ALLOWED_STATE, SINCE = ROWS.take(4)
STATE = at.SERIES_STATE
# what one kind of step would overwrite of the other
OF_STEP = (
    at.TAKEN, at.STEP, at.WORK, at.GOOD, at.JERK, at.Y_NEW, at.W_NEW, at.DW_NEW, at.JERK_NEW, at.WEAK_NEW,
)  # fmt: skip


# --- a step -----------------------------------------------------------------------------------------------------------


@compiled(inline=True)
def log2_of_step(s, i, first, allowed):
    """How long a step may be for the last two coefficients of the series in these rows."""
    most, last, before = rough_log2(allowed), at.ORDER * at.WIDTH, (at.ORDER - 1) * at.WIDTH
    by_last, by_before = most - rough_log2(s[first + last + i]), most - rough_log2(s[first + before + i])
    return min(by_last * (1.0 / at.ORDER), by_before * (1.0 / (at.ORDER - 1)))


@compiled
def choose_step(s):
    """As long a step as the last two coefficients of w and of the state allow (`stribeck/taylor.py`)."""
    widest_vectors()
    for i in range(at.WIDTH):
        h = min(s[MOST + i], min(s[CAP + i], s[at.TAU_END + i] - s[at.TAU + i]))
        by_w = log2_of_step(s, i, at.SERIES, s[at.ALLOWED + i])
        by_state = log2_of_step(s, i, STATE, s[ALLOWED_STATE + i])
        h = min(h, rough_exp2(min(by_w, by_state)))
        s[at.TAKEN + i] = h
        s[at.GOOD + i] = select(h >= at.SMALLEST_STEP, 1.0, 0.0)


@compiled(inline=True)
def state_after(s, i, t):
    """The state at t after the start of the step, and its slope by the series."""
    z, slope = s[STATE + at.ORDER * at.WIDTH + i], 0.0
    for j in range(at.ORDER):
        slope = slope * t + z
        z = z * t + s[STATE + (at.ORDER - 1 - j) * at.WIDTH + i]
    return z, slope


@compiled(inline=True)
def agrees(s, i, h, dw, slope, slope_by_series):
    """Return whether the series agree with w' and the slope of the state at the end, by the equations."""
    close = abs(slope_by_series - slope) * h <= (at.ORDER + 1) * s[ALLOWED_STATE + i]
    return close & (abs(s[at.DW_NEW + i] - dw) * h <= (at.ORDER + 1) * s[at.ALLOWED + i])


@compiled(inline=True)
def may_turn_twice(s, i, h, dw, jerk):
    """Return whether w', of one sign at both ends of the step of lane i, may vanish twice in it.

    Tangents at the ends, which fall towards zero, meet beyond it.
    """
    side = select(dw > 0.0, 1.0, -1.0)
    start, down, up = side * s[at.DW + i], -side * s[at.JERK + i], side * jerk
    return (start > 0.0) & (min(down, up) > 0.0) & (MARGIN * h * down * up > (down + up) * min(start, side * dw))


@compiled
def passes_twice(s, i, level):
    """When, within the step of lane i, w turns beyond a level on one side of which it begins and ends; 0 if not."""
    w, at_end = s[at.W + i], end_motion(s, i)
    side = 1.0 if w < level else -1.0
    start, end = side * (level - w), side * (level - at_end[0])
    rise, fall = side * s[at.DW + i], -side * at_end[1]
    if min(end, rise, fall) <= 0.0 or min(start, end) > MARGIN * s[at.TAKEN + i] * rise * fall / (rise + fall):
        return 0.0
    t, peak = extreme_speed(s, i, s[at.TAKEN + i], at_end, TO_ROUNDING)
    return t if (w > level) != (peak > level) else 0.0


# --- lanes of either kind ---------------------------------------------------------------------------------------------


@compiled
def step_by_series(m, i, stock):
    """Let lane i step by series from here on, until stock is taken after so many steps."""
    s = m.s
    s[at.BY_SERIES + i], s[CAP + i], s[at.STEP + i] = 1.0, inf, inf
    s[SINCE + i], s[at.PAUSE + i] = s[at.TAU + i], min(s[at.TRIED + i] + stock, m.max_steps)


@compiled
def step_implicitly(m, i):
    """Let lane i step by the implicit method from here on."""
    m.s[at.BY_SERIES + i], m.s[at.STEP + i], m.s[at.PAUSE + i] = 0.0, m.s[at.TAKEN + i], m.max_steps


@compiled(inline=True)
def may_step_by_series(s):
    """Return False if no lane does."""
    return nonzero_bits(s, at.BY_SERIES, WIDTH) != 0


@compiled
def kinds_of_steps(s):
    """Return whether any lane at work steps by series, and whether any does not."""
    by_series, others = False, False
    for i in range(at.WIDTH):
        works = s[at.CELL + i] >= 0.0
        by_series |= works & (s[at.BY_SERIES + i] > 0.0)
        others |= works & (s[at.BY_SERIES + i] == 0.0)
    return by_series, others


@compiled(inline=True)
def set_aside(s, rows, to):
    """Copy these rows to rows `to`."""
    for row in rows:
        for i in range(at.WIDTH):
            s[to + i] = s[row + i]
        to += at.WIDTH


@compiled(inline=True)
def bring_back(s, rows, of, kind):
    """Copy them back in lanes of a kind: 1 of those that step by series, 0 of others."""
    for row in rows:
        for i in range(at.WIDTH):
            s[row + i] = select(s[at.BY_SERIES + i] == kind, s[of + i], s[row + i])
        of += at.WIDTH
