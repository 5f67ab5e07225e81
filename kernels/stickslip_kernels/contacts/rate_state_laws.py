"""The laws of rate-and-state friction, with cut-offs and without, for both forms of it (`rate_and_state.py`,
`regularised.py`), in the symbols of these.

Laws with cut-offs have -a ln(1 + v_1/w) + b ln(1 + v_2 theta/D), but for a constant (P. G. Okubo, J. Geophys. Res. 94
(1989) 12321): the direct effect ceases at w beyond v_1, that of theta at theta below D/v_2. So friction is a (phi -
ln(1 + p e^phi)) + b (psi + ln(1 + q e^-psi)) beside a constant, with p = V/v_1, q = V/v_2.
"""

from math import inf, log
from typing import NamedTuple

from .. import layout as at
from ..arithmetic import exp, in_turn, select, widest_vectors
from ..arithmetic import log as ln
from ..dense import subtract_damper_work
from ..jit import compiled
from ..linking import by_law
from . import explicit
from .explicit import ALLOWED_STATE, CAP, STATE, agrees, choose_step, may_turn_twice, state_after
from .stribeck.equations import may_bend_twice
from .stribeck.taylor import sum_series


class Ageing(NamedTuple):
    """Tag of the ageing law."""

    code: int


class Slip(NamedTuple):
    """Tag of the slip law."""

    code: int


class AgeingCutOff(Ageing):
    """The same with cut-offs."""


class SlipCutOff(Slip):
    """The same with cut-offs."""


LAWS = {
    "rate_state_ageing": Ageing(0), "rate_state_slip": Slip(0), "rate_state_ageing_cut_off": AgeingCutOff(0),
    "rate_state_slip_cut_off": SlipCutOff(0),
}  # fmt: skip

CUT_OFF = AgeingCutOff, SlipCutOff

# rows of cells; the last two are one over v_1 and v_2
MU_0, DIRECT, EVOLUTION, DISTANCE, V_0 = at.OWN_0, at.OWN_1, at.OWN_2, at.OWN_3, at.OWN_4
PER_DIRECT, PER_EVOLUTION = at.OWN_5, at.OWN_6
# rows of a lane: a, b, mu_V, V, V/D, p, q
FREE = explicit.ROWS.beside()
ROWS = A, B_STATE, MU_V, V, RATE, CUT_P, CUT_Q = FREE.take(7)
(RATIO,) = FREE.take(1)  # b/a, in the regularised form
NOTHING = 1e-300


@by_law(inline=True)
def growth(law, e, phi, psi):
    """g and its derivatives with respect to phi and psi; e = exp(phi)."""
    healed = exp(-psi)
    return healed - e, -e, -healed


growth.of(Slip)(lambda law, e, phi, psi: (-e * (phi + psi), -e * (1.0 + phi + psi), -e))


# --- cut-offs: without them, what is 0.0 is subtracted, which leaves nothing in the code ------------------------------


@by_law("sif:f", inline=True)
def direct(law, s, i, e):
    """Slope of friction over phi."""
    return s[A + i]


@by_law("sif:f", inline=True)
def evolution(law, s, i, psi):
    """Slope of friction over psi."""
    return s[B_STATE + i]


@by_law("sif:f", inline=True)
def above(law, s, i, e):
    """What friction is above a phi, and ..."""
    return 0.0


@by_law("sif:f", inline=True)
def further(law, s, i, psi):
    """... above b psi, beside mu_V."""
    return 0.0


@by_law(inline=True)
def bent(law, s, i, e, psi, phi_1, psi_1):
    """What comes to friction's second derivative over time from changes of these slopes."""
    return 0.0


@by_law("sif:f", inline=True)
def state_of(law, s, i, load):
    """psi at which friction is by so much above that of psi = 0."""
    return load / s[B_STATE + i]


direct.of(*CUT_OFF)(lambda law, s, i, e: s[A + i] / (1.0 + s[CUT_P + i] * e))
evolution.of(*CUT_OFF)(lambda law, s, i, psi: s[B_STATE + i] / (1.0 + s[CUT_Q + i] * exp(-psi)))
above.of(*CUT_OFF)(lambda law, s, i, e: -s[A + i] * ln(1.0 + s[CUT_P + i] * e))
further.of(*CUT_OFF)(lambda law, s, i, psi: s[B_STATE + i] * ln(1.0 + s[CUT_Q + i] * exp(-psi)))


@bent.of(*CUT_OFF)
def _bent(law, s, i, e, psi, phi_1, psi_1):
    p, q = s[CUT_P + i] * e, s[CUT_Q + i] * exp(-psi)
    by_phi, by_psi = -s[A + i] * p / ((1.0 + p) * (1.0 + p)), s[B_STATE + i] * q / ((1.0 + q) * (1.0 + q))
    return by_phi * phi_1 * phi_1 + by_psi * psi_1 * psi_1


@state_of.of(*CUT_OFF)
def _state_of(law, s, i, load):
    return ln(max((1.0 + s[CUT_Q + i]) * exp(load / s[B_STATE + i]) - s[CUT_Q + i], NOTHING))


# --- the same for the regularised form --------------------------------------------------------------------------------


@by_law("siff:f", inline=True)
def risen(law, s, i, psi_0, psi):
    """By how much c is larger at psi than at psi_0."""
    return s[RATIO + i] * (psi - psi_0)


@by_law("sif:f", inline=True)
def damper(law, s, i, w):
    """By what w' falls as w grows, chi being the same."""
    return s[at.G + i]


@by_law(inline=True)
def less_turned(law, s, i, psi, z, tanh):
    """What r' z tanh is below 0, r' being the slope of r."""
    return 0.0


@by_law(inline=True)
def less_bent(law, s, i, psi, z, tanh, w, dw):
    """What the third derivative of w loses to the slopes of r and of the damper."""
    return 0.0


@risen.of(*CUT_OFF)
def _risen(law, s, i, psi_0, psi):
    return s[RATIO + i] * (psi - psi_0) + (further(law, s, i, psi) - further(law, s, i, psi_0)) / s[A + i]


damper.of(*CUT_OFF)(lambda law, s, i, w: s[at.G + i] - s[A + i] * s[CUT_P + i] / (s[V + i] + s[CUT_P + i] * abs(w)))


@less_turned.of(*CUT_OFF)
def _less_turned(law, s, i, psi, z, tanh):
    q = s[CUT_Q + i] * exp(-psi)
    return -s[RATIO + i] * q / ((1.0 + q) * (1.0 + q)) * z * tanh


@less_bent.of(*CUT_OFF)
def _less_bent(law, s, i, psi, z, tanh, w, dw):
    steep = s[CUT_P + i] * dw / (s[V + i] + s[CUT_P + i] * abs(w))
    turned = s[A + i] * steep * steep
    return select(w < 0.0, -turned, turned) - s[A + i] * z * less_turned(law, s, i, psi, z, tanh)


# --- steady sliding ---------------------------------------------------------------------------------------------------


@compiled
def in_logarithms(cells, c, w):
    """Friction in steady sliding."""
    a, b, v_0, per_direct, per_evolution = (
        cells[DIRECT, c], cells[EVOLUTION, c], cells[V_0, c], cells[PER_DIRECT, c], cells[PER_EVOLUTION, c]
    )  # fmt: skip
    cut = a * log((1.0 + per_direct * w) / (1.0 + per_direct * v_0))
    cut -= b * log((1.0 + per_evolution * w) / (1.0 + per_evolution * v_0))
    return cells[MU_0, c] + (a - b) * log(w / v_0) - cut


@compiled
def over_a(cells, c, w):
    """ln(2 sinh chi) in steady sliding."""
    over = in_logarithms(cells, c, w) / cells[DIRECT, c]
    return over + log(1.0 + w * cells[PER_DIRECT, c])


# --- the series of w over an implicit step, from ln w at its ends -----------------------------------------------------

COEFFICIENTS = at.ORDER + 1
P = P_1, P_2, P_3, P_4, P_5 = FREE.take(5)  # k p_k of the polynomial of ln w


@compiled(inline=True)
def put_powers(s, i, off, h, rise, slope, slope_new, bend, bend_new):
    """The quintic Hermite polynomial of ln w into rows P, or those `off` beyond them.

    rise : of ln w over the step. slope, bend : its first and second derivatives, at both ends.
    """
    rise -= h * (slope + 0.5 * h * bend)
    change, turn = h * (slope_new - slope - h * bend), h * h * (bend_new - bend)
    s[P_1 + off + i], s[P_2 + off + i] = h * slope, h * h * bend
    s[P_3 + off + i] = 3.0 * (10.0 * rise - 4.0 * change + 0.5 * turn)
    s[P_4 + off + i] = 4.0 * (-15.0 * rise + 7.0 * change - turn)
    s[P_5 + off + i] = 5.0 * (6.0 * rise - 3.0 * change + 0.5 * turn)


@compiled(inline=True)
def find_term(rows, s, n):
    """Coefficient n in powers of t/h: n c_n = p_1 c_(n-1) + 2 p_2 c_(n-2) + ..., rows P having k p_k."""
    widest_vectors()
    (off, series), count = rows, min(n, len(P))
    for i in range(at.WIDTH):
        total = 0.0
        for k in range(count):
            total += s[P_1 + k * at.WIDTH + off + i] * s[series + (n - 1 - k) * at.WIDTH + i]
        s[series + n * at.WIDTH + i] = total * (1.0 / n)


@compiled
def find_terms(s, off, series):
    """Rows `series` beyond the first, from the polynomial in rows P + off."""
    in_turn(find_term, (off, series), s, 1, COEFFICIENTS)


# --- the Taylor series of the motion, where much inertia lets the contact follow it -----------------------------------
# Where m v^2/(a N D) is large, friction takes long to change the slip speed, and a loop is next to harmonic: a series
# of order 14 passes it in a dozen steps, an implicit method of order 5 in hundreds. In symbols of `rate_and_state.py`,
#
#     y' = B - w,      w' = y - gamma w - mu_V - a phi - b psi,      w phi' = w',      psi' = (V/D) g
#
# are products of series: with u = e^-psi, u' = -psi' u and g = u - w/V (ageing); g = -(w/V) u, u = phi + psi (slip).


# first rows of the series of phi', of psi', of u; rows of sums
PHI_SLOPE, PSI_SLOPE, U = at.SERIES_WEAK, at.SERIES_DW, at.SERIES_SHARE
SUM, SUM_STATE = FREE.take(2)
ERROR_SHARE = 0.01  # of the tolerance that each of the last coefficients may spend, and the error of a step
CARRIED = 10.0  # over a: from this slip speed on, errors of w do not count over w, since the load is as far off


@by_law(":b", inline=True)
def has_series(law):
    """Return whether the law has such series."""
    return True


has_series.of(*CUT_OFF)(lambda law: False)


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


left.of(Slip)(lambda law: at.SERIES)


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
def step_by_series(law, s, rtol):
    """A step in every lane, as far as the series are good for; nothing is committed."""
    begin_series(law, s, rtol)
    for n in range(1, at.ORDER):
        find_order(law, s, n)
    choose_step(s)
    sum_series(s)
    subtract_damper_work(s)
    end_step(law, s)
