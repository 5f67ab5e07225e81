"""Extrema of the motion inside a step: which are worth a look, recorded where they can be the largest so far.

What the lanes test on whole steps is tested again on the part of a step that is recorded, by the same functions.
"""

from math import inf

from .. import layout as at
from ..contacts.stribeck.equations import extreme_slope
from ..jit import compiled
from ..roots import FOR_A_VALUE, arrival, extreme_speed
from .amplitudes import AFTER, UNTRIED, consider_map
from .cycles import LOOPS, note_loop
from .spirals import end_in_spiral
from .tops import has_low_speed, has_top_slope, has_top_speed, is_found
from .verdict import ends_with_regime, note_closeness, note_force, note_speed, note_trough

# --- what a step holds, from its start to a state after h ------------------------------------------------------------


@compiled(inline=True)
def turns(s, i, w):
    """Return whether u has an extremum: u' = b - w changes its sign."""
    return (s[at.W + i] > s[at.B + i]) != (w > s[at.B + i])


@compiled(inline=True)
def turns_quietly(s, i, h, y, w):
    """Return whether a turn of u needs no look: no extreme so far, and plainly back from beyond the settling band.

    A closer bound than `reach`, with a quarter to spare: it decides how often an oscillation that rings down is looked
    at.
    """
    y0, p0, q0 = s[at.Y + i], s[at.Y + i] - s[at.Y_STAR + i], s[at.W + i] - s[at.B + i]
    p, q = y - s[at.Y_STAR + i], w - s[at.B + i]
    slopes, beyond = abs(q0) + abs(q), 1.25 * h * abs(q0 * q)
    known = (s[at.Y_HIGH + i] - max(y0, y)) * slopes > beyond
    known = known & ((min(y0, y) - s[at.Y_LOW + i]) * slopes > beyond)
    outward = (q * p > 0.0) & (p * p0 > 0.0) & (min(p * p, p0 * p0) > s[at.BAND2 + i])
    return known & outward & (s[at.LOOP_COUNT + i] < s[at.QUIET_BELOW + i])


# --- what is recorded -------------------------------------------------------------------------------------------------


@compiled(inline=True)
def record_extrema(m, i, h, w, dw, jerk):
    """Extrema of u, w and w' between the start of the step of lane i and the state after h."""
    s, b, at_end = m.s, m.s[at.B + i], (w, dw, jerk, 0.0)
    if has_top_speed(s, i, h, w, dw):
        top = s[at.TOP + i] if is_found(s, i, h, at.OF_SPEED) else extreme_speed(s, i, h, at_end, FOR_A_VALUE)[1]
        note_speed(s, i, top)
        if s[at.DW + i] > 0.0:
            note_peak(s, i, top - b)
    if has_low_speed(s, i, h, w, dw):
        low = s[at.TOP + i] if is_found(s, i, h, at.OF_SPEED) else extreme_speed(s, i, h, at_end, FOR_A_VALUE)[1]
        note_trough(s, i, low)
    if has_top_slope(s, i, h, dw, jerk):
        steepest = s[at.TOP + i] if is_found(s, i, h, at.OF_SLOPE) else extreme_slope(m.law, s, i, h, at_end)
        s[at.DW_TOP + i] = max(s[at.DW_TOP + i], abs(steepest))
    if turns(s, i, w):
        t, rise, work = arrival(s, i, b, h, at_end)
        xi = s[at.SIGMA + i] * (s[at.Y + i] + rise - s[at.G + i] * b + s[at.OFFSET + i])
        note_turn(s, i, xi)
        if w > b:
            note_loop(m, i, s[at.TAU + i] + t, s[at.HEAT + i] + work, xi)
            consider_map(m, i, s[at.TAU + i] + t, xi)
            if ends_with_regime(m, i):
                end_in_spiral(m, i)


@compiled(inline=True)
def show_tops(m, i):
    """Tell the lanes which extrema are worth a look; on a hysteretic curve every peak is, for `is_shrinking`.

    Extrema of u may pass until the next comparison of loops, but for the last minimum and the last maximum before it;
    while a cycle is confirmed, none; nor while each may end the cell.
    """
    s = m.s
    forward, confirming = s[at.SIGMA + i] > 0.0, s[at.CONFIRMING + i] > 0.0
    top = s[at.V_HIGH + i] if forward else -s[at.V_LOW + i]
    s[at.W_TOP + i] = top if s[at.W_MIN + i] == 0.0 and not confirming else -inf
    to_y = s[at.G + i] * s[at.B + i] - s[at.OFFSET + i]
    s[at.Y_HIGH + i], s[at.Y_LOW + i] = s[at.XI_HIGH + i] + to_y, s[at.XI_LOW + i] + to_y
    may_pass = forward and s[at.LOOP_COUNT + i] >= 0.0 and not confirming
    next_look = LOOPS
    if s[at.MAP_STATE + i] == UNTRIED:
        next_look = 0.0 if ends_with_regime(m, i) else AFTER
    s[at.QUIET_BELOW + i] = next_look - 1.0 if may_pass else -1.0


@compiled(inline=True)
def note_peak(s, i, height):
    """A peak of the slip speed, `height` above the belt speed."""
    s[at.PEAK_BEFORE + i], s[at.PEAK + i] = s[at.PEAK + i], height


@compiled
def note_turn(s, i, xi):
    """An extremum of xi: the range, and the crossing of the equilibrium."""
    note_force(s, i, xi)
    s[at.TURN_BEFORE + i], s[at.TURN_LAST + i] = s[at.TURN_LAST + i], xi
    distance = xi - s[at.XI_STAR + i]
    if s[at.CROSSED + i] < 2.0:
        note_closeness(s, i, 1.0 - abs(distance) / s[at.BAND + i])
    if abs(distance) > s[at.BAND + i]:
        side = 1.0 if distance > 0.0 else -1.0
        if side * s[at.SIDE_LAST + i] < 0.0:
            s[at.CROSSED + i] += 1.0
        s[at.SIDE_LAST + i] = side


@compiled(inline=True)
def note_side(s, i, xi):
    """Remember on which side of the equilibrium a slip starts."""
    distance = xi - s[at.XI_STAR + i]
    if abs(distance) > s[at.BAND + i]:
        s[at.SIDE_LAST + i] = 1.0 if distance > 0.0 else -1.0
