"""Slip on the curve: how a lane is set up for it."""

from math import isnan

from .jit import compiled
from .equations import jerk_in_lane, weakening_in_lane
from .lanes import begin_stepping
from .layout import (
    A1, A2, A3, B, CELL, DECIDED, DROP, DW, G, JERK, LEVEL, MODE, OFFSET, RADIUS2, RISE, SIDE, SIDE_LAST, SIGMA,
    SLIP_START, SLOPE, TAU, TURN, W, WEAK, W_MIN, XI_STAR, Y, Y_STAR,
)  # fmt: skip
from .extrema import note_side, show_tops
from .regimes import note_ends
from .settling import proven_radius, set_band
from .trace import log_slip


@compiled(inline=True)
def enter_curve(law, s, i, cells, mode, u, w, b, turning):
    """Enter RISE or FAST at (u, w). RISE without hysteresis is the plain curve, which ends only at w = 0.

    turning : w' is zero here, exactly.
    """
    c = int(s[CELL + i])
    w_min = s[W_MIN + i]
    s[OFFSET + i], s[SLOPE + i], s[DROP + i] = cells[A1, c], cells[A2, c], cells[A3, c]
    plain_rise = mode == RISE and w_min == 0.0
    s[LEVEL + i] = 0.0 if plain_rise else w_min
    s[SIDE + i] = 1.0 if mode == RISE and not plain_rise else -1.0
    s[TURN + i] = 1.0 if mode == RISE and not plain_rise else 0.0
    offset = s[OFFSET + i]
    s[B + i] = b
    s[Y + i] = u + s[G + i] * b - offset
    s[W + i] = w
    s[WEAK + i] = weakening_in_lane(law, s, i, w)
    s[DW + i] = 0.0 if turning else s[Y + i] - (s[G + i] + s[SLOPE + i]) * w - s[WEAK + i]
    s[JERK + i] = jerk_in_lane(law, s, i, s[Y + i], w, s[DW + i], b)
    # Steady sliding; in a reverse slip (b < 0) that of the forward one.
    s[Y_STAR + i] = s[SIGMA + i] * s[XI_STAR + i] + s[G + i] * b - offset
    s[RADIUS2 + i] = proven_radius(law, s, i, mode, b) ** 2
    s[MODE + i] = mode
    show_tops(s, i)


@compiled(inline=True)
def begin_slip(law, s, i, cells, log, u, b, lifting_off, fresh):
    """Slip from rest at (u, b); `lifting_off` where the load equals the friction of the curve, so that w' is zero.

    fresh : whether a slip begins here, rather than one that only turns round.
    """
    c = int(s[CELL + i])
    if isnan(s[SLIP_START + i]):
        s[SLIP_START + i] = s[TAU + i]
    if fresh and s[DECIDED + i] == 0.0:
        set_band(s, i, u, 0.0, b)
    if s[SIDE_LAST + i] == 0.0:
        note_side(s, i, s[SIGMA + i] * u)
    enter_curve(law, s, i, cells, RISE, u, 0.0, b, lifting_off)
    begin_stepping(law, s, i, cells, c)
    note_ends(s, i, u, 0.0, s[DW + i])
    log_slip(log, s, i, RISE, s[SIGMA + i])
