"""Stiff slip: a long way along the slow manifold at once.

Where the drag F' = gamma + mu'(w) is large, the motion falls onto a curve on which friction all but balances the load,
and creeps along it. Explicit steps are bound by 1/F' there, however little happens. On that curve w' is a function g of
w; with y' = b - w,

    g (F' + g') = b - w.

Its slow solution is the limit of g_0 = (b - w)/F' and g_(n+1) = (b - w)/(F' + g_n'), each nearer by a factor of about
g'/F', the ratio of the slow rate to the fast one: g_2 is taken where g_3 would be the same to the tolerance. A state
beside the curve nears it at the rate F'; one that is on it to the tolerance of a step counts as on it. Time and work
are integrals along q = w - b = q_0 e^-x, by Gauss over short panels, since dt = (F' + g') dx.

After the singular perturbation theory of N. Fenichel, Journal of Differential Equations 31 (1979) 53-98.
"""

from math import inf, log

from .. import layout as at
from ..arithmetic import exp
from ..contacts.stribeck.equations import jerk_in_lane, next_speed, slope_in_lane, weakening_in_lane
from ..contacts.stribeck.laws import has_kinks
from ..contacts.stribeck.runge_kutta import restart
from ..contacts.stribeck.slip import displacement_in_lane
from ..dense import NODES, WEIGHTS
from ..jit import compiled
from .settling import creeps_in, distance2_from_sliding, drag_at
from .verdict import come_to_a_point, decide, decide_settled, note_ends

ERROR_SHARE = 0.1  # of the tolerance that the slow rate may be wrong by
DIFFERENCE = 1e-3  # step of the differences that tell how the drag changes, over a4 or w
LONGEST, WIDEST = 0.5, 0.1  # a panel: in x, and over the larger of a4 and w in w
SHORTEST = 1.0 / 128.0  # a panel may become this much shorter than the longest
LEAST = 1e-3  # of a panel, taken even where a station of the curve ends it
MOST_PANELS, HALVINGS = 2000, 50
NOT_SLOW = (inf, inf)


@compiled
def slow_drag(law, s, i, w):
    """F' + g' on the slow manifold of lane i, where w' = (b - w)/(F' + g'), and its relative error; inf where none."""
    drag, q = drag_at(law, s, i, w), w - s[at.B + i]
    if drag <= 0.0:
        return NOT_SLOW
    e = DIFFERENCE * min(1.0 / s[at.RATE + i], w)
    below, above = drag_at(law, s, i, w - e), drag_at(law, s, i, w + e)
    far_below, far_above = drag_at(law, s, i, w - 2.0 * e), drag_at(law, s, i, w + 2.0 * e)
    slope = (8.0 * (above - below) - (far_above - far_below)) / (12.0 * e)
    bend = (16.0 * (above + below) - (far_above + far_below) - 30.0 * drag) / (12.0 * e * e)
    first = (q * slope / drag - 1.0) / drag  # g_0'
    drag_1 = drag + first
    if drag_1 <= 0.0:
        return NOT_SLOW
    change = (2.0 * slope + q * (bend - 2.0 * slope * slope / drag)) / (drag * drag)  # g_0''
    second = (q * (slope + change) / drag_1 - 1.0) / drag_1  # g_1'
    ratio, difference = abs(first) / drag, abs(second - first) / drag
    error = 4.0 * difference * max(ratio, difference / max(ratio, 1e-300))
    if has_kinks(law):  # g_0' jumps, and g' passes over from one side to the other while w moves by about g/F'
        error = max(error, ratio * ratio)
    return drag + second, error


@compiled
def along_panel(law, s, i, q, x, most):
    """Time and friction work while q shrinks by e^x, and the largest |w'|; the time is inf where the error is above
    `most`."""
    time, work, steepest = 0.0, 0.0, 0.0
    for node in range(len(NODES)):
        q_here = q * exp(-x * NODES[node])
        w = s[at.B + i] + q_here
        drag, error = slow_drag(law, s, i, w)
        if not error <= most:
            return inf, 0.0, 0.0
        mu = s[at.OFFSET + i] + s[at.SLOPE + i] * w + weakening_in_lane(law, s, i, w)
        time += WEIGHTS[node] * x * drag
        work += WEIGHTS[node] * x * drag * mu * w
        steepest = max(steepest, abs(q_here) / drag)
    return time, work, steepest


@compiled
def load_on_manifold(law, s, i, w):
    """y of lane i at w on the slow manifold."""
    return (s[at.B + i] - w) / slow_drag(law, s, i, w)[0] - slope_in_lane(law, s, i, 0.0, w)


@compiled
def is_in_band(law, s, i, w):
    """Return whether the slow manifold at w lies inside the settling band."""
    return distance2_from_sliding(s, i, load_on_manifold(law, s, i, w), w) < s[at.BAND2 + i]


@compiled
def way_to_band(law, s, i, q, x):
    """By how much x grows, at most x, until the motion comes into the settling band inside this panel."""
    outside, inside = 0.0, x
    for _ in range(HALVINGS):
        middle = 0.5 * (outside + inside)
        if is_in_band(law, s, i, s[at.B + i] + q * exp(-middle)):
            inside = middle
        else:
            outside = middle
    return inside


@compiled
def ends_of_mode(s, i):
    """Slip speeds between which the law of the present mode stays."""
    if s[at.W_MIN + i] == 0.0:
        return 0.0, inf
    return (0.0, s[at.W_MIN + i]) if s[at.MODE + i] == at.RISE else (s[at.W_MIN + i], inf)


@compiled
def pass_slowly(m, i):
    """Take lane i along the slow manifold as far as that goes, at most into the settling band; whether it moved."""
    law, s, b = m.law, m.s, m.s[at.B + i]
    w, left, most = s[at.W + i], s[at.TAU_END + i] - s[at.TAU + i], ERROR_SHARE * m.rtol
    if w == b or not w > 0.0:
        return False
    drag, error = slow_drag(law, s, i, w)
    beside = (s[at.DW + i] - (b - w) / drag) / drag
    amplitude = max(abs(s[at.Y + i] - s[at.Y_STAR + i]), abs(w - b))
    if not error <= most or not abs(beside) <= m.rtol * min(amplitude, w):
        return False
    low, high = ends_of_mode(s, i)
    outside = distance2_from_sliding(s, i, s[at.Y + i], w) >= s[at.BAND2 + i] > 0.0
    q, tau, heat, longest, entered = w + beside - b, 0.0, 0.0, LONGEST, False
    for _ in range(MOST_PANELS):
        x = longest * min(1.0, WIDEST / LONGEST * max(1.0 / s[at.RATE + i], b + q) / abs(q))
        w = b + q * exp(-x)
        station = next_speed(law, s, i, b + q, 1.0 if q < 0.0 else -1.0)
        if min(w, b + q) < station < max(w, b + q):
            x = max(log(q / (station - b)), LEAST * x)
            w = b + q * exp(-x)
        entered = outside and low < w < high and is_in_band(law, s, i, w)
        if entered:
            x = way_to_band(law, s, i, q, x)
            w = b + q * exp(-x)
        time, work, steepest = along_panel(law, s, i, q, x, most)
        if low < w < high and tau + time < left and not (s[at.MARK + i] > 0.0 and steepest > s[at.DW_TOP + i]):
            q, tau, heat = w - b, tau + time, heat + work
        else:
            longest, entered = 0.5 * longest, False
        if entered or longest < SHORTEST or abs(q) <= m.rtol * s[at.BAND + i]:
            break
    if tau == 0.0:
        return False
    arrive(m, i, b + q, tau, heat)
    if entered:
        s[at.ENTERED + i] = s[at.TAU + i]
        if s[at.DECIDED + i] == 0.0 and creeps_in(law, s, i):
            decide_settled(m, i, s[at.ENTERED + i], s[at.XI_STAR + i], at.SETTLED)
    return True


@compiled
def arrive(m, i, w, tau, heat):
    """Put lane i on the slow manifold at w, a time tau later."""
    law, s, b = m.law, m.s, m.s[at.B + i]
    y = load_on_manifold(law, s, i, w)
    s[at.TAU + i] += tau
    s[at.HEAT + i] += heat
    s[at.Y + i], s[at.W + i], s[at.WEAK + i] = y, w, weakening_in_lane(law, s, i, w)
    s[at.DW + i] = slope_in_lane(law, s, i, y, w)
    s[at.JERK + i] = jerk_in_lane(law, s, i, y, w, s[at.DW + i], b)
    note_ends(s, i, displacement_in_lane(m, i, y, 0.0), w, s[at.DW + i])
    restart(law, s, i, 1.0 / drag_at(law, s, i, w))


@compiled
def comes_to_rest(m, i):
    """Return whether slip on a belt at rest creeps to a stop under too low a load for break-away: a verdict."""
    s, c = m.s, int(m.s[at.CELL + i])
    if s[at.B + i] != 0.0 or not creeps_in(m.law, s, i):
        return False
    u = s[at.OFFSET + i] + s[at.DROP + i]
    note_ends(s, i, u, 0.0, 0.0)
    come_to_a_point(m.observer.results, c, s[at.SIGMA + i] * u)
    decide(m, i, at.STUCK, at.NEVER_BREAKS_AWAY)
    return True
