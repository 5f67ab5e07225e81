"""Slip on the curve: how a lane is set up for it."""

from ... import layout as at
from ... import observers
from ...drive import belt_in_lane, steady_load
from ...jit import compiled
from ...layout import RUNNING
from .equations import jerk_in_lane, slope_in_lane, weakening_in_lane
from .runge_kutta import begin_stepping


@compiled(inline=True)
def displacement_in_lane(m, i, y, t):
    """u of lane i, from y, at t after its present state."""
    return y + m.s[at.OFFSET + i] - m.s[at.ALPHA + i] - m.s[at.G + i] * belt_in_lane(m, i, t)


@compiled(inline=True)
def set_slip(m, i, u, w, turning):
    """Put lane i at (u, w) under the friction and the belt of its rows.

    turning : w' is zero here, exactly.
    """
    s, law, b = m.s, m.law, belt_in_lane(m, i, 0.0)
    to_y = s[at.G + i] * b - s[at.OFFSET + i]
    s[at.Y + i], s[at.W + i] = u + to_y + m.s[at.ALPHA + i], w
    s[at.WEAK + i] = weakening_in_lane(law, s, i, w)
    s[at.DW + i] = 0.0 if turning else slope_in_lane(law, s, i, s[at.Y + i], w)
    s[at.JERK + i] = jerk_in_lane(law, s, i, s[at.Y + i], w, s[at.DW + i], s[at.B + i])
    # Errors are measured against the distance from steady sliding; in a reverse slip (b < 0) from the forward one.
    s[at.Y_STAR + i] = steady_load(m, i) + to_y


@compiled(inline=True)
def enter_curve(m, i, mode, u, w, turning):
    """Enter RISE or FAST at (u, w). RISE without hysteresis is the plain curve, which ends only at w = 0."""
    s, cells, c = m.s, m.cells, int(m.s[at.CELL + i])
    w_min = s[at.W_MIN + i]
    s[at.OFFSET + i], s[at.SLOPE + i], s[at.DROP + i] = cells[at.A1, c], cells[at.A2, c], cells[at.A3, c]
    below_minimum = mode == at.RISE and w_min > 0.0
    s[at.LEVEL + i], s[at.MODE + i] = w_min, mode
    s[at.SIDE + i], s[at.TURN + i] = (1.0, 1.0) if below_minimum else (-1.0, 0.0)
    set_slip(m, i, u, w, turning)
    observers.watch_from(m, i, u)


@compiled(inline=True)
def begin_slip(m, i, mode, u, w, turning, fresh):
    """Slip from (u, w) on.

    fresh : whether a slip begins here, rather than one that only changes its direction.
    """
    observers.observe_slip_begin(m, i, u, w, fresh)
    enter_curve(m, i, mode, u, w, turning)
    begin_stepping(m.law, m.s, i, m.cells, int(m.s[at.CELL + i]))
    return RUNNING
