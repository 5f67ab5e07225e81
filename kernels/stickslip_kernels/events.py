"""What ends a mode inside a step, and when.

A step only says that an event lies inside it; the dense output of the step then tells the time, to the step's own
error. (The root of a cubic polynomial spoils a good step: 3e-4 at rtol 1e-6, measured.)
"""

from .dense import speed, state_at
from .equations import slope_in_lane
from .jit import compiled
from .layout import DW, DW_NEW, JERK_NEW, LEVEL, SIDE, TAKEN, TURN, W, WORK, W_NEW, Y, Y_NEW
from .roots import TO_ROUNDING, arrival, crossing, extreme_speed

NO_EVENT, LEVEL_REACHED, TURNED = range(3)


@compiled(inline=True)
def end_motion(s, i):
    """w, w' and w'' at the end of the step of lane i, as `crossing` wants them."""
    return s[W_NEW + i], s[DW_NEW + i], s[JERK_NEW + i], 0.0


@compiled
def turn_time(s, i):
    """When w' of lane i first vanishes within its step, w moving towards LEVEL before; -1 if it does not."""
    h, at_end = s[TAKEN + i], end_motion(s, i)
    if s[SIDE + i] * at_end[1] <= 0.0:
        return extreme_speed(s, i, h, at_end, TO_ROUNDING)[0]
    # Towards the level at both ends: the slope may still turn between them.
    bottom = crossing(s, i, 2, 0.0, h, at_end, TO_ROUNDING)
    at_bottom = speed(s, i, bottom)
    return -1.0 if s[SIDE + i] * at_bottom[1] > 0.0 else crossing(s, i, 1, 0.0, bottom, at_bottom, TO_ROUNDING)


@compiled(inline=True)
def find_event(law, s, i):
    """What ends the mode of lane i inside the step it has just tried.

    Returns (kind, time from the step start, y, w, w', friction work up to there); for NO_EVENT the end of the step.
    """
    h, side, level = s[TAKEN + i], s[SIDE + i], s[LEVEL + i]
    w0, w1, dw1 = s[W + i], s[W_NEW + i], s[DW_NEW + i]
    d0, d1 = side * s[DW + i], side * dw1
    reached = side * w1 >= side * level
    # An extremum inside the step is taken to be no further out than the nearer end plus h times the larger slope there.
    grazed = d0 > 0.0 and d1 <= 0.0 and max(side * w0, side * w1) + h * max(d0, -d1) >= side * level
    end, at_end = h, end_motion(s, i)  # the level, if reached, is reached before this
    if s[TURN + i] > 0.0 or (grazed and not reached):
        turn = turn_time(s, i)
        if turn >= 0.0:
            y, w, dw, work = state_at(law, s, i, turn)
            if side * w >= side * level:
                reached, end, at_end = True, turn, (w, 0.0, 0.0, 0.0)
            elif s[TURN + i] > 0.0:
                return TURNED, turn, y, w, 0.0, work
    if not reached:
        return NO_EVENT, h, s[Y_NEW + i], w1, dw1, s[WORK + i]
    end, rise, work = arrival(s, i, level, side, end, at_end)
    y = s[Y + i] + rise
    return LEVEL_REACHED, end, y, level, slope_in_lane(law, s, i, y, level), work
