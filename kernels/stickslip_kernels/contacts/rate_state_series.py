"""Rate-and-state friction by the Taylor series of the motion, where much inertia lets the contact follow it.

Where m v^2/(a N D) is large, friction takes long to change the slip speed, and a loop is next to harmonic: a series of
order 14 passes it in a dozen steps, an implicit method of order 5 in hundreds. In the symbols of `rate_and_state.py`,

    y' = B - w,      w' = y - gamma w - mu_V - a phi - b psi,      w phi' = w',      psi' = (V/D) g

are products of series: with u = e^-psi, u' = -psi' u and g = u - w/V (ageing); g = -(w/V) u with u = phi + psi (slip).
"""

from math import inf

from .. import layout as at
from ..dense import subtract_damper_work
from ..exponential import exp
from ..exponential import log as ln
from ..intrinsics import select, widest_vectors
from ..jit import compiled
from ..linking import by_law
from .explicit import ALLOWED_STATE, CAP, STATE, agrees, choose_step, may_turn_twice, state_after
from .rate_state_laws import ROWS, AgeingCutOff, Slip, SlipCutOff, growth
from .stribeck.resolvable import may_bend_twice
from .stribeck.taylor import sum_series

A, B_STATE, MU_V, V, RATE = ROWS[:5]
# first rows of the series of phi', of psi', of u; rows of sums
PHI_SLOPE, PSI_SLOPE, U = at.SERIES_WEAK, at.SERIES_DW, at.SERIES_SHARE
SUM, SUM_STATE = at.K_3, at.K_4
ERROR_SHARE = 0.01  # of the tolerance that each of the last coefficients may spend, and the error of a step
CARRIED = 10.0  # over a: from this slip speed on, errors of w do not count over w, since the load is as far off


@by_law(":b", inline=True)
def has_series(law):
    """Return whether the law has such series."""
    return True


@has_series.of(AgeingCutOff, SlipCutOff)
def _has_none(law):
    return False


@by_law(inline=True)
def follow(law, s, i, first, u, w, q, total, per_n):
    """u and psi' of order n; u : of order 0, for that alone. q : phi + psi. total : of products of lower orders."""
    u = select(first, u, -total * per_n)
    return u, s[RATE + i] * (u - w / s[V + i])


@follow.of(Slip)
def _follow_slip(law, s, i, first, u, w, q, total, per_n):
    return q, -s[RATE + i] / s[V + i] * (s[at.SERIES + i] * q + total)


@by_law(inline=True)
def left(law):
    """First row, less one, of what is multiplied by u."""
    return at.SERIES_DW - at.WIDTH


@left.of(Slip)
def _left_slip(law):
    return at.SERIES


@compiled
def begin_series(law, s, rtol):
    """Order 0, and what errors may be."""
    widest_vectors()
    for i in range(at.WIDTH):
        w, psi = s[at.W + i], s[at.WEAK + i]
        phi = ln(w / s[V + i])
        s[at.SERIES + i], s[STATE + i] = w, psi
        dw = s[at.Y + i] - s[at.G + i] * w - s[MU_V + i] - s[A + i] * phi - s[B_STATE + i] * psi
        u, slope = follow(law, s, i, True, exp(-psi), w, phi + psi, 0.0, 1.0)
        s[U + i], s[PSI_SLOPE + i], s[PHI_SLOPE + i] = u, slope, dw / w
        s[at.SERIES + at.WIDTH + i], s[STATE + at.WIDTH + i] = dw, slope
        s[at.ALLOWED + i] = ERROR_SHARE * rtol * min(abs(w), CARRIED * abs(s[A + i]))
        s[ALLOWED_STATE + i] = ERROR_SHARE * rtol


@compiled
def find_order(law, s, n):
    """Coefficients n of the slopes, and n + 1 of w and psi.

    For any n, sums being kept in rows: a loop for each order compiles for three seconds and saves a quarter of a step.
    """
    widest_vectors()
    for i in range(at.WIDTH):
        s[SUM + i], s[SUM_STATE + i] = 0.0, 0.0
    for j in range(1, n + 1):
        w, phi = at.SERIES + j * at.WIDTH, PHI_SLOPE + (n - j) * at.WIDTH
        first, u = left(law) + j * at.WIDTH, U + (n - j) * at.WIDTH
        for i in range(at.WIDTH):
            s[SUM + i] += s[w + i] * s[phi + i]
            s[SUM_STATE + i] += s[first + i] * s[u + i]
    here, below, up = n * at.WIDTH, (n - 1) * at.WIDTH, (n + 1) * at.WIDTH
    per_n, per_next = 1.0 / n, 1.0 / (n + 1)
    belt, bend = 1.0 if n == 1 else 0.0, 1.0 if n == 2 else 0.0
    for i in range(at.WIDTH):
        w, psi, phi = s[at.SERIES + here + i], s[STATE + here + i], s[PHI_SLOPE + below + i] * per_n
        y = (belt * s[at.B + i] + bend * s[at.ALPHA + i] - s[at.SERIES + below + i]) * per_n
        dw = y - s[at.G + i] * w - s[A + i] * phi - s[B_STATE + i] * psi
        u, slope = follow(law, s, i, False, 0.0, w, phi + psi, s[SUM_STATE + i], per_n)
        s[U + here + i], s[PSI_SLOPE + here + i] = u, slope
        s[PHI_SLOPE + here + i] = (dw - s[SUM + i]) / s[at.SERIES + i]
        s[at.SERIES + up + i], s[STATE + up + i] = dw * per_next, slope * per_next


@compiled(inline=True)
def motion(law, s, i, t, y, w, psi):
    """w', w'' and psi' at t after the start of the step, by the equations."""
    e = w / s[V + i]
    phi = ln(e)
    dw = y - s[at.G + i] * w - s[MU_V + i] - s[A + i] * phi - s[B_STATE + i] * psi
    slope = s[RATE + i] * growth(law, e, phi, psi)[0]
    load = s[at.B + i] + t * s[at.ALPHA + i] - w
    return dw, load - s[at.G + i] * dw - s[A + i] * dw / w - s[B_STATE + i] * slope, slope


@compiled
def end_step(law, s):
    """The state at the end, by the equations themselves; the step is good if its series agree with them."""
    widest_vectors()
    for i in range(at.WIDTH):
        h, y, w = s[at.TAKEN + i], s[at.Y_NEW + i], s[at.W_NEW + i]
        psi, slope = state_after(s, i, h)
        dw, jerk, dpsi = motion(law, s, i, h, y, w, psi)
        hides = may_bend_twice(s, i, h, dw, jerk) | may_turn_twice(s, i, h, dw, jerk)
        good = (s[at.GOOD + i] > 0.0) & agrees(s, i, h, dw, dpsi, slope) & (w / s[V + i] > 0.0) & (not hides)
        s[at.WEAK_NEW + i], s[at.DW_NEW + i], s[at.JERK_NEW + i] = psi, dw, jerk
        s[at.GOOD + i] = select(good, 1.0, 0.0)
        s[CAP + i] = select(good, inf, 0.5 * h)


@compiled
def try_step(law, s, rtol):
    """A step in every lane, as far as the series are good for; nothing is committed."""
    begin_series(law, s, rtol)
    for n in range(1, at.ORDER):
        find_order(law, s, n)
    choose_step(s)
    sum_series(s)
    subtract_damper_work(s)
    end_step(law, s)
