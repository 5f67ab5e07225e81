"""What becomes of a slip that spirals about steady sliding, known from its first loop.

In the plane (p, q) of `settling.py`, p' = -q, q' = p - F(q), a slip that has gone round once without coming to rest, on
one curve, and ends further in than it began, is enclosed by that loop for good: it tends to steady sliding or to a
cycle about it (Poincaré, Bendixson). A slip that began at rest is, once it has a trough: that lies on the inner side of
how it began. With f = F', the drag:

- Where f(0) < 0 steady sliding repels, and there is a cycle.
- Where f(0) > 0 and f is concave from the trough of the loop on, there is none. f(q)/q only falls on either side of
  q = 0, since q f' - f is at most -f(0): so there is at most one cycle (Zhang Zhi-Fen), which would repel as steady
  sliding attracts, and the loop around it would have grown.
- On other curves there is none if G(r) = F(r) - F(-r) > 0 from 0 down to the trough. z = q^2/2 follows dz/dp = F - p on
  both sides of q = 0, so that of two halves of a cycle, which leave p = A together, the one with the larger F is the
  lower one all the way, and they do not meet again (Filippov).
- On a hysteretic curve with its minimum below b, friction below that is on the line, on the curve or between: F(-r) is
  at most that of the higher one, with which G > 0 says the same, loop by loop. Each loop then ends further in than the
  one before, and its trough lies higher, since the ways down, by one curve and one line, do not cross.

Zhang Zhi-Fen, Ding Tong-Ren, Huang Wen-Zao, Dong Zhen-Xi, Qualitative Theory of Differential Equations, AMS 1992,
chapter IV.
"""

from math import inf, isnan, nan

from .. import layout as at
from ..contacts.stribeck.equations import weakening_in_lane
from ..contacts.stribeck.friction import Table, coefficient, is_concave_from, line_slope
from ..contacts.stribeck.laws import relaxation
from ..jit import compiled
from ..linking import by_law
from .settling import NOTHING, certain_radius, drag_at, least_drag
from .verdict import decide, decide_settled, note_closest_trough

MOST_LOOKS = 100  # at G, from the disc of `certain_radius` to the trough
NEARLY = 0.999  # of the way to where G may vanish at the soonest


@compiled
def loss(law, s, i, line, r):
    """G at r > 0. line : slope of the line of a hysteretic curve."""
    b, below = s[at.B + i], s[at.W_MIN + i] - s[at.B + i] + r
    straight = 2.0 * r * (s[at.G + i] + s[at.SLOPE + i])
    lost = straight + weakening_in_lane(law, s, i, b + r) - weakening_in_lane(law, s, i, b - r)
    if below <= 0.0:
        return lost
    fall = weakening_in_lane(law, s, i, b - r) - weakening_in_lane(law, s, i, s[at.W_MIN + i])
    return lost - max(-line * below - (fall - s[at.SLOPE + i] * below), 0.0)


@compiled
def loses_in_all_loops(m, i, r):
    """Return whether G > 0 from 0 to r <= b.

    It is where the drag is positive on both sides; from there, it falls at most at the rate of the least drag.
    """
    law, s, cells, c = m.law, m.s, m.cells, int(m.s[at.CELL + i])
    b, lowest, line = s[at.B + i], s[at.W_MIN + i], 0.0
    known, least = certain_radius(law, s, i, b), least_drag(law, s, i, b - r, b)
    if known >= r or not known > 0.0:
        return known >= r
    if b - r < lowest:
        line = line_slope(lowest, coefficient(law, cells, c, lowest), cells[at.MU_STOP, c])
        least = min(least, s[at.G + i] + line)
    fall = -least - least_drag(law, s, i, b + r, b)
    for _ in range(MOST_LOOKS):
        here = loss(law, s, i, line, known)
        if not here > NOTHING:
            return False
        if here > fall * (r - known):
            return True
        known += NEARLY * here / fall
    return False


@by_law("sif:b")
def relaxes_from(law, s, i, w):
    """Return whether the slope of the curve of lane i is concave from slip speed w on."""
    return s[at.RATE + i] * w >= relaxation(law, s[at.EXPONENT + i])


relaxes_from.of(Table)(lambda law, s, i, w: is_concave_from(law, s[at.RATE + i] * w, s[at.EXPONENT + i]))


@compiled
def fate(m, i):
    """The regime that the slip under way comes to for certain, DAMPED or SUSTAINED; else UNRESOLVED."""
    law, s = m.law, m.s
    b, least, lowest, damped = s[at.B + i], s[at.W_LEAST + i], s[at.W_MIN + i], s[at.CROSSED + i] >= 2.0
    if not 0.0 < least < b or (lowest > 0.0 and not (b > lowest and s[at.MODE + i] == at.FAST)):
        return at.UNRESOLVED
    drag, inward = drag_at(law, s, i, b), s[at.INWARD + i] > 0.0 and s[at.MAP_REST + i] < s[at.MAP_TAU + i]
    enclosed = least > lowest and (inward or not isnan(s[at.CYCLE_START + i]))
    if enclosed and drag < -NOTHING:
        return at.SUSTAINED
    if not damped or not drag > NOTHING:
        return at.UNRESOLVED
    concave = enclosed and s[at.DROP + i] >= 0.0 and relaxes_from(law, s, i, least)
    return at.DAMPED if concave or loses_in_all_loops(m, i, b - least) else at.UNRESOLVED


@compiled
def is_damped(m, i):
    """Return whether the slip under way rings down for certain."""
    return fate(m, i) == at.DAMPED


@compiled
def end_in_spiral(m, i):
    """Decide about lane i, at a maximum of u where nothing but the regime is asked, if that is certain."""
    s, least = m.s, m.s[at.W_LEAST + i]
    if s[at.DECIDED + i] > 0.0 or least == inf:
        return
    regime = fate(m, i)
    note_closest_trough(s, i)
    if regime == at.SUSTAINED:
        decide(m, i, regime, at.SLIP_CYCLE)
    elif regime == at.DAMPED:
        decide_settled(m, i, nan, s[at.XI_STAR + i], at.SETTLING_CERTAIN)
    else:  # the next loop has a trough of its own
        s[at.SLIP_LEAST + i], s[at.W_LEAST + i] = min(s[at.SLIP_LEAST + i], least), inf
