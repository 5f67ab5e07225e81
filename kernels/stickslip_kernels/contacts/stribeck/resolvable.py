"""Steps that resolve all the friction they pass through.

Friction weakens within a few a4 of standstill. A step that starts and ends far above may dip into that zone between:
no coefficient, stage or defect at its ends shows it, and a re-stick is missed. So the lowest point of a step is
bounded from its ends, and a step that may hide the zone is refused; halved, it soon ends inside and sees it.
"""

from math import inf

from ... import layout as at
from ...jit import compiled
from .laws import hidden_depth, last_weakening

MARGIN = 1.25  # tangents bound a convex trough; the rest is for one that is not quite


@compiled(inline=True)
def know_steepness(law, s, i, cells, c):
    """Let lane i know where friction weakens: rows FAR and HIDES."""
    drop, a4 = cells[at.A3, c], cells[at.A4, c]
    s[at.FAR + i] = a4 * last_weakening(law, cells[at.DELTA, c])
    s[at.HIDES + i] = a4 * hidden_depth(law, cells[at.DELTA, c]) if drop != 0.0 else inf


@compiled(inline=True)
def may_hide(s, i, h, w, dw, sign=1.0):
    """Return whether the step of lane i over h, to w and w' = dw, may have met friction that its ends do not show.

    sign : of w. A trough of |w| inside lies at most h a b/(a + b) below its nearer end, where the tangents of slopes -a
    and b meet.
    """
    down, up, nearer = -sign * s[at.DW + i], sign * dw, min(sign * s[at.W + i], sign * w)
    slopes = down + up
    return (slopes > 0.0) & (MARGIN * h * down * up > slopes * max(s[at.HIDES + i], nearer - s[at.FAR + i]))


@compiled(inline=True)
def may_bend_twice(s, i, h, dw, jerk):
    """Return whether w'', of one sign at both ends of the step of lane i, may vanish twice in it, at a record of |w'|.

    It falls towards zero, and by its tangent at the start passes it: an extremum of w' that the ends do not show.
    """
    jerk0, snap0, top = s[at.JERK + i], 6.0 * s[at.SERIES + 3 * at.WIDTH + i], max(abs(s[at.DW + i]), abs(dw))
    falls = (jerk0 * jerk > 0.0) & (jerk0 * snap0 < 0.0) & (h * abs(snap0) > abs(jerk0))
    return falls & (top + h * abs(jerk0) >= s[at.DW_TOP + i])
