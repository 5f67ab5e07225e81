"""Settling: the disc from which it is certain, the band that says when, and what is still to come.

All in the plane (p, q) about steady sliding on the curve, p = u - u*, q = w - b = -u': p' = -q, q' = p - F(q), where
F(q)/q is gamma plus the mean slope of the curve between b and w.
"""

from math import atan2, cos, inf, log, nan, pi, sin

from .. import layout as at
from ..arithmetic import exp
from ..contacts.stribeck.equations import slope_in_lane
from ..contacts.stribeck.friction import Table, slopes_between
from ..contacts.stribeck.laws import inflection, shape, weakening_slope
from ..dense import rise_and_work, speed
from ..jit import compiled
from ..linking import by_law
from .verdict import decide_settled, ends_with_regime, note_closeness, note_closest_trough, note_ends, note_trough

BAND_SHARE = 1e-4  # settling band over the distance from steady sliding at which the slip began
SMALLEST_BAND = 1e-12  # what is smaller is lost to rounding
SHRINKING = 0.999  # a peak this much lower than the last counts as shrinking
NOTHING = 1e-12  # a drag that no integration sees


@compiled(inline=True)
def set_band(s, i, u, w, b):
    """The settling band of a slip that begins at (u, w)."""
    p, q = u - s[at.SIGMA + i] * s[at.XI_STAR + i], w - b
    s[at.AMPLITUDE + i] = max((p * p + q * q) ** 0.5, SMALLEST_BAND / BAND_SHARE)
    band = BAND_SHARE * s[at.AMPLITUDE + i]
    s[at.BAND + i] = band
    s[at.BAND2 + i] = band * band


# --- certain settling -----------------------------------------------------------------------------------------------


@compiled(inline=True)
def certain_radius(law, s, i, b):
    """Radius of the disc about steady sliding in which only settling is left; 0 where there is none.

    With V = p^2 + q^2, V' = -2 q F(q): V decreases monotonically once the disc lies where gamma + mu' > 0, where w > 0,
    and where a hysteretic curve is not left.
    """
    if b <= 0.0 or not s[at.STABLE_FROM + i] < b < s[at.STABLE_TO + i]:
        return 0.0
    return max(0.0, min(b - max(s[at.STABLE_FROM + i], s[at.W_MIN + i]), s[at.STABLE_TO + i] - b))


@compiled(inline=True)
def proven_radius(m, i):
    """Radius of the disc in which the motion counts as settled: that of certainty, or of the settling band if smaller.

    On a hysteretic curve below its minimum the mode changes where w' = 0, and the disc only tells when to ask
    `creeps_in`; infinite where that is asked after every step.
    """
    law, s, b = m.law, m.s, m.s[at.B + i]
    if b <= 0.0 or s[at.DECIDED + i] > 0.0:
        return 0.0
    if ends_with_regime(m, i) and s[at.W_MIN + i] == 0.0 and drag_at(law, s, i, b) >= 2.0:
        return inf
    if s[at.MODE + i] == at.RISE and s[at.W_MIN + i] > 0.0:
        return min(s[at.BAND + i], b) if s[at.W_MIN + i] > b and drag_at(law, s, i, b) >= 2.0 else 0.0
    return min(s[at.BAND + i], certain_radius(law, s, i, b))


@compiled
def drag_at(law, s, i, w):
    """gamma + mu'(w) under the law of the present mode."""
    z, drop, exponent, rate = s[at.RATE + i] * w, s[at.DROP + i], s[at.EXPONENT + i], s[at.RATE + i]
    x = drop * shape(law, z, exponent)
    return s[at.G + i] + s[at.SLOPE + i] + rate * weakening_slope(law, z, x, drop, exponent)


@by_law("siff:f")
def least_drag(law, s, i, w, b):
    """The least gamma + mu' between two slip speeds: at an end, or at the inflection, its only extremum."""
    least, bend = min(drag_at(law, s, i, w), drag_at(law, s, i, b)), inflection(law, s[at.EXPONENT + i])
    bend /= s[at.RATE + i]
    return min(least, drag_at(law, s, i, bend)) if min(w, b) < bend < max(w, b) else least


@compiled
def creeps_in(law, s, i):
    """Return whether w tends to b on the curve, from below or from above, without ever passing it.

    Let q > 0; the other side is its mirror image. Once q' <= 0 it stays so while q > 0 (where q' = 0, q'' = -q), and w
    never leaves the way from here to b. And q stays positive on this side of the eigenvector of the faster of two real
    rates f, f^2 - d f + 1 = 0, d being the least drag on that way: where q = f p, (q - f p)' = q/f - F + f q <= 0.
    """
    w, b = s[at.W + i], s[at.B + i]
    side = 1.0 if w > b else -1.0
    p, q = side * (s[at.Y + i] + slope_in_lane(law, s, i, 0.0, b)), side * (w - b)
    if side * s[at.DW + i] > 0.0 or changes_curve(s, i, side):
        return False
    drag = least_drag(law, s, i, w, b)
    if drag < 2.0:
        return False
    fast = 0.5 * drag + (0.25 * drag * drag - 1.0) ** 0.5
    return q <= fast * p


@compiled
def changes_curve(s, i, side):
    """Return whether the way from w to b, from above (side 1) or below, leaves the law of the present mode."""
    if s[at.W_MIN + i] == 0.0:
        return False
    return side > 0.0 if s[at.MODE + i] == at.RISE else s[at.B + i] <= s[at.W_MIN + i]


@compiled
def settles_for_certain(law, s, i):
    """Return whether a slip that has not come into the settling band can only do so, and is damped or creep already."""
    p, q, b = s[at.Y + i] - s[at.Y_STAR + i], s[at.W + i] - s[at.B + i], s[at.B + i]
    if b <= 0.0:
        return False
    inside = p * p + q * q < certain_radius(law, s, i, b) ** 2
    return (inside and s[at.CROSSED + i] >= 2.0) or creeps_in(law, s, i)


@compiled
def is_neutral(law, s, i):
    """Return whether nothing damps or feeds a motion as large as this."""
    b, reach = s[at.B + i], ((s[at.Y + i] - s[at.Y_STAR + i]) ** 2 + (s[at.W + i] - s[at.B + i]) ** 2) ** 0.5
    low, high = max(b - reach, 0.0), b + reach
    return low >= s[at.W_MIN + i] and has_no_drag(law, s, i, low, high)


@by_law("siff:b")
def has_no_drag(law, s, i, low, high):
    """Return whether gamma + mu' vanishes from one slip speed to another."""
    bend = inflection(law, s[at.EXPONENT + i]) / s[at.RATE + i]
    if low < bend < high and s[at.DROP + i] != 0.0:
        return False
    return abs(drag_at(law, s, i, low)) <= NOTHING and abs(drag_at(law, s, i, high)) <= NOTHING


# of a table


@compiled
def drags_between(law, s, i, low, high):
    """The least and the largest gamma + mu' between two slip speeds under the law of the present mode."""
    rate, drop = s[at.RATE + i], s[at.DROP + i]
    least, most = slopes_between(law, rate * low, rate * high, s[at.EXPONENT + i])
    drag, one, other = s[at.G + i] + s[at.SLOPE + i], rate * drop * least, rate * drop * most
    return drag + min(one, other), drag + max(one, other)


least_drag.of(Table)(lambda law, s, i, w, b: drags_between(law, s, i, min(w, b), max(w, b))[0])


@has_no_drag.of(Table)
def _has_no_drag(law, s, i, low, high):
    least, most = drags_between(law, s, i, low, high)
    return least >= -NOTHING and most <= NOTHING


@compiled(inline=True)
def check_settling(m, i):
    """Inside the disc of `proven_radius` the motion has settled; where the mode may yet change, if it creeps in."""
    law, s = m.law, m.s
    p, q = s[at.Y + i] - s[at.Y_STAR + i], s[at.W + i] - s[at.B + i]
    radius2, may_change = s[at.RADIUS2 + i], s[at.MODE + i] == at.RISE and s[at.W_MIN + i] > 0.0
    if radius2 == inf:
        if creeps_in(law, s, i):
            note_closest_trough(s, i)
            decide_settled(m, i, nan, s[at.XI_STAR + i], at.SETTLING_CERTAIN)
            return
        radius2 = min(s[at.BAND + i], certain_radius(law, s, i, s[at.B + i])) ** 2
    if p * p + q * q < radius2 and (not may_change or creeps_in(law, s, i)):
        note_closest_trough(s, i)  # before those to come, which the disc rules out as an end
        if note_ring_down(law, s, i, m.rtol):
            decide_settled(m, i, s[at.ENTERED + i], s[at.XI_STAR + i], at.SETTLED)


# --- what is still to come ------------------------------------------------------------------------------------------


@compiled
def ring_extremum(p, dp, zeta):
    """The next extremum of p'' + 2 zeta p' + p = 0 from (p, p'), zeta > 0; 0, the limit, if none is ahead."""
    discriminant = 1.0 - zeta * zeta
    omega = max(abs(discriminant), 1e-12) ** 0.5  # at zeta = 1 either formula holds in the limit
    s = (dp + zeta * p) / omega
    if discriminant > 0.0:
        phase = atan2(dp, zeta * s + omega * p)
        if phase <= 0.0:
            phase += pi
        return exp(-zeta * phase / omega) * (p * cos(phase) + s * sin(phase))
    tangent = dp / (zeta * s - omega * p)  # tanh(omega t) where p' vanishes
    if not 0.0 < tangent < 1.0:
        return 0.0
    t = 0.5 * log((1.0 + tangent) / (1.0 - tangent)) / omega
    return 0.5 * ((p + s) * exp((omega - zeta) * t) + (p - s) * exp(-(omega + zeta) * t))


@compiled
def note_ring_down(law, s, i, rtol):
    """Extremes still to come once the motion has settled, as those of the linear oscillator; whether that will do.

    An approach that stays inside the settling band may yet overshoot there, and its limit belongs to the range. Where
    an extreme to come is a record, the oscillator has to be linear to the tolerance.
    """
    b, w, zeta = s[at.B + i], s[at.W + i], 0.5 * drag_at(law, s, i, s[at.B + i])
    u_star = s[at.Y_STAR + i] - s[at.G + i] * b + s[at.OFFSET + i]
    p = ring_extremum(s[at.Y + i] - s[at.Y_STAR + i], b - w, zeta)
    q = ring_extremum(w - b, s[at.DW + i], zeta)
    p_after, q_after = ring_extremum(p, 0.0, zeta), ring_extremum(q, 0.0, zeta)
    xi, xi_after = s[at.SIGMA + i] * (u_star + p), s[at.SIGMA + i] * (u_star + p_after)
    record = min(xi, xi_after) < s[at.XI_LOW + i] or max(xi, xi_after) > s[at.XI_HIGH + i]
    record = record or b + max(q, q_after) > max(s[at.V_HIGH + i], -s[at.V_LOW + i])
    bending = abs(drag_at(law, s, i, w) - 2.0 * zeta) + abs(drag_at(law, s, i, b + q) - 2.0 * zeta)
    if record and bending * (abs(w - b) + abs(q)) > rtol * b:
        return False
    if s[at.CROSSED + i] < 2.0:
        note_closeness(s, i, 1.0 - max(abs(p), abs(p_after)) / s[at.BAND + i])
    note_trough(s, i, b + min(q, q_after))
    note_ends(s, i, u_star + p, b + q, 0.0)
    note_ends(s, i, u_star + p_after, b + q_after, 0.0)
    return True


# --- the settling band ----------------------------------------------------------------------------------------------


@compiled(inline=True)
def comes_into_band(s, i, y1, w1):
    """Return whether the motion of lane i comes into the settling band on the way to (y1, w1)."""
    p0, q0 = s[at.Y + i] - s[at.Y_STAR + i], s[at.W + i] - s[at.B + i]
    return (p0 * p0 + q0 * q0 >= s[at.BAND2 + i]) & (distance2_from_sliding(s, i, y1, w1) < s[at.BAND2 + i])


@compiled(inline=True)
def distance2_from_sliding(s, i, y, w):
    """Squared distance of (y, w) from steady sliding."""
    p, q = y - s[at.Y_STAR + i], w - s[at.B + i]
    return p * p + q * q


@compiled(inline=True)
def note_entry(s, i, h, y1, w1):
    """Note when, between the start of the step of lane i and the state after h, the motion came into the band."""
    if not comes_into_band(s, i, y1, w1):
        return
    b, band2, p0 = s[at.B + i], s[at.BAND2 + i], s[at.Y + i] - s[at.Y_STAR + i]
    outside, inside, t = 0.0, h, h
    for _ in range(60):
        dw = speed(s, i, t)[1]
        w, rise, _ = rise_and_work(s, i, t)
        p, q = p0 + rise, w - b
        excess, slope = p * p + q * q - band2, 2.0 * q * (dw - p)  # p' = b - w = -q
        if excess < 0.0:
            inside = t
        else:
            outside = t
        new = t - excess / slope
        if abs(new - t) <= 1e-9 * h:
            break
        t = new if outside < new < inside else 0.5 * (outside + inside)
    s[at.ENTERED + i] = s[at.TAU + i] + t


@compiled
def note_entry_at_constant_speed(s, i, tau, u, w, b, duration):
    """The same for a stick or hold phase that starts at tau: u moves at b - w >= 0."""
    p0, q2 = u - s[at.SIGMA + i] * s[at.XI_STAR + i], (w - b) ** 2
    p1, band2 = p0 + (b - w) * duration, s[at.BAND2 + i]
    if p0 * p0 + q2 >= band2 and p1 * p1 + q2 < band2:
        s[at.ENTERED + i] = tau - (p0 + (band2 - q2) ** 0.5) / (b - w)


@compiled
def is_shrinking(s, i, cells, u, w, b):
    """Return whether the loop that ends in this trough below v_min lies inside the band, its peak the lower one.

    Near steady sliding on the hysteretic curve the motion is a chain of straight pieces, the same at every scale: peaks
    then shrink by a constant factor. Small against b and a4 so that the curve is straight over the loop.
    """
    before = s[at.TROUGH_TIME + i]
    s[at.TROUGH_TIME + i] = s[at.TAU + i]
    small = min(s[at.BAND + i], 0.05 * min(b, cells[at.A4, int(s[at.CELL + i])]))
    near = (u - s[at.SIGMA + i] * s[at.XI_STAR + i]) ** 2 + (w - b) ** 2 < s[at.BAND2 + i]
    near = near and b - w < small and s[at.PEAK + i] < small and s[at.ENTERED + i] <= before
    return near and s[at.PEAK + i] < SHRINKING * s[at.PEAK_BEFORE + i]
