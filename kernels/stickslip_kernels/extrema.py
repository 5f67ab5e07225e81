"""Extrema of the motion inside a step: recorded where they can be the largest so far, counted where u turns."""

from math import inf

from .jit import compiled
from .lanes import extreme_slope, reach
from .layout import (
    B, BAND, CONFIRMING, CROSSED, DW, DW_HIGH, DW_TOP, G, HEAT, JERK, LOOP_COUNT, OFFSET, PEAK, PEAK_BEFORE, QUIET,
    QUIET_GIVEN, SIDE_LAST, SIGMA, TAU, TURN_BEFORE, TURN_LAST, V_HIGH, V_LOW, W, W_MIN, W_TOP, XI_HIGH, XI_LOW,
    XI_STAR, Y, Y_HIGH, Y_LOW,
)  # fmt: skip
from .loops import LOOPS, note_loop
from .regimes import note_force, note_speed
from .roots import FOR_A_VALUE, arrival, extreme_speed


@compiled(inline=True)
def record_extrema(law, s, i, results, control, h, y1, w1, dw1, jerk1):
    """Extrema of u, w and w' between the start of the step of lane i and the state after h."""
    w0, dw0, jerk0, b, at_end = s[W + i], s[DW + i], s[JERK + i], s[B + i], (w1, dw1, jerk1, 0.0)
    if dw0 * dw1 < 0.0 and max(w0, w1) + reach(dw0, dw1, h) >= s[W_TOP + i]:
        top = extreme_speed(s, i, h, at_end, FOR_A_VALUE)[1]
        note_speed(s, i, top)
        if dw0 > 0.0:
            note_peak(s, i, top - b)
    if jerk0 * jerk1 < 0.0 and max(abs(dw0), abs(dw1)) + reach(jerk0, jerk1, h) >= s[DW_TOP + i]:
        s[DW_HIGH + i] = max(s[DW_HIGH + i], abs(extreme_slope(law, s, i, h, at_end)))
    if (w0 > b) != (w1 > b):  # u' = b - w changes sign
        t, rise, work = arrival(s, i, b, 1.0 if w1 > b else -1.0, h, at_end)
        xi = s[SIGMA + i] * (s[Y + i] + rise - s[G + i] * b + s[OFFSET + i])
        note_turn(s, i, xi)
        if w1 > b:
            note_loop(law, s, i, results, control, s[TAU + i] + t, s[HEAT + i] + work, xi)


@compiled(inline=True)
def show_tops(s, i):
    """Tell the lanes which extrema are worth a look; on a hysteretic curve every peak is, for `is_shrinking`.

    Extrema of u may pass until the next comparison of loops is due; while a cycle is confirmed, none.
    """
    forward, confirming = s[SIGMA + i] > 0.0, s[CONFIRMING + i] > 0.0
    top = s[V_HIGH + i] if forward else -s[V_LOW + i]
    s[W_TOP + i] = top if s[W_MIN + i] == 0.0 and not confirming else -inf
    s[DW_TOP + i] = s[DW_HIGH + i]
    to_y = s[G + i] * s[B + i] - s[OFFSET + i]
    s[Y_HIGH + i], s[Y_LOW + i] = s[XI_HIGH + i] + to_y, s[XI_LOW + i] + to_y
    may_pass = forward and s[LOOP_COUNT + i] >= 0.0 and not confirming
    # The last minimum and the last maximum are looked at; where the maximum comes first, one less may pass.
    passing = 2.0 * (LOOPS - 1.0 - s[LOOP_COUNT + i]) - (1.0 if s[W + i] < s[B + i] else 0.0)
    s[QUIET_GIVEN + i] = max(passing, 0.0) if may_pass else 0.0
    s[QUIET + i] = s[QUIET_GIVEN + i]


@compiled(inline=True)
def count_quiet_turns(s, i):
    """Count the extrema of u that passed without a look: in turn above and below the equilibrium, beyond the band."""
    turns = s[QUIET_GIVEN + i] - s[QUIET + i]
    if turns > 0.0:
        last = 1.0 if s[W + i] > s[B + i] else -1.0
        first = last if turns % 2.0 == 1.0 else -last
        s[CROSSED + i] += turns if first * s[SIDE_LAST + i] < 0.0 else turns - 1.0
        s[LOOP_COUNT + i] += 0.5 * turns if turns % 2.0 == 0.0 else 0.5 * (turns + last)
        s[SIDE_LAST + i], s[QUIET_GIVEN + i] = last, s[QUIET + i]


@compiled
def note_peak(s, i, height):
    """A peak of the slip speed, `height` above the belt speed."""
    s[PEAK_BEFORE + i], s[PEAK + i] = s[PEAK + i], height


@compiled
def note_turn(s, i, xi):
    """An extremum of xi: the range, and the crossing of the equilibrium."""
    note_force(s, i, xi)
    s[TURN_BEFORE + i], s[TURN_LAST + i] = s[TURN_LAST + i], xi
    distance = xi - s[XI_STAR + i]
    if abs(distance) > s[BAND + i]:
        side = 1.0 if distance > 0.0 else -1.0
        if side * s[SIDE_LAST + i] < 0.0:
            s[CROSSED + i] += 1.0
        s[SIDE_LAST + i] = side


@compiled(inline=True)
def note_side(s, i, xi):
    """Remember on which side of the equilibrium a slip starts."""
    distance = xi - s[XI_STAR + i]
    if abs(distance) > s[BAND + i]:
        s[SIDE_LAST + i] = 1.0 if distance > 0.0 else -1.0
