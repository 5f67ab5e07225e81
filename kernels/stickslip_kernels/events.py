"""Events: the ends of a mode inside a step.

A step only says that an event lies inside it; the dense output of the step then tells the time, to the step's own
error. (The root of a cubic polynomial spoils a good step: 3e-4 at rtol 1e-6, measured.)
"""

from math import isnan

from . import layout as at
from .dense import speed
from .jit import compiled
from .roots import TO_ROUNDING, crossing, extreme_speed

NO_EVENT, LEVEL_REACHED, TURNED = range(3)


# --- what a step may hold: tested in all lanes, and again where one is looked at ----------------------------------
# Guards are turned by SIDE so that the level is reached from below, and a turning point is a maximum. An extremum
# inside a step is taken to be no further out than the nearer end plus h times the larger slope there.


@compiled(inline=True)
def reaches(s, i, w):
    """Return whether w has reached the level that ends the mode."""
    return s[at.SIDE + i] * w >= s[at.SIDE + i] * s[at.LEVEL + i]


@compiled(inline=True)
def grazes(s, i, h, w, dw):
    """Return whether the slip speed may have reached that level on the way to w, and have turned back."""
    side = s[at.SIDE + i]
    d0, d1 = side * s[at.DW + i], side * dw
    return (d0 > 0.0) & (d1 <= 0.0) & (max(side * s[at.W + i], side * w) + h * max(d0, -d1) >= side * s[at.LEVEL + i])


@compiled(inline=True)
def may_turn(s, i, h, dw):
    """Return whether w' may have vanished on the way to dw, also where it points the same way at both ends."""
    side = s[at.SIDE + i]
    d0, d1, j0, j1 = side * s[at.DW + i], side * dw, side * s[at.JERK + i], side * s[at.JERK_NEW + i]
    return (d1 <= 0.0) | ((j0 < 0.0) & (j1 > 0.0) & (min(d0, d1) - h * max(-j0, j1) <= 0.0))


# --- when -------------------------------------------------------------------------------------------------------------


@compiled(inline=True)
def end_motion(s, i):
    """w, w' and w'' at the end of the step of lane i, as `crossing` wants them."""
    return s[at.W_NEW + i], s[at.DW_NEW + i], s[at.JERK_NEW + i], 0.0


@compiled
def turn_time(s, i):
    """When w' of lane i first vanishes within its step, w moving towards LEVEL before; -1 if it does not."""
    h, at_end = s[at.TAKEN + i], end_motion(s, i)
    if s[at.SIDE + i] * at_end[1] <= 0.0:
        if s[at.SOUGHT + i] == at.OF_SPEED and not isnan(s[at.TOP_TIME + i]):
            return s[at.TOP_TIME + i]
        return extreme_speed(s, i, h, at_end, TO_ROUNDING)[0]
    # Towards the level at both ends: the slope may still turn between them.
    bottom = crossing(s, i, 2, 0.0, h, at_end, TO_ROUNDING)
    at_bottom = speed(s, i, bottom)
    return -1.0 if s[at.SIDE + i] * at_bottom[1] > 0.0 else crossing(s, i, 1, 0.0, bottom, at_bottom, TO_ROUNDING)
