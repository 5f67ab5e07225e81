"""Rate-and-state friction where slip may rest and turn round: the regularised form of `plain.py`.

    mu = a chi,      w = 2 v_0 sinh(chi) exp(-(mu_0 + b ln(v_0 theta/D))/a),      theta' with |w|

which friction of thermally activated jumps both ways is (J. R. Rice, N. Lapusta, K. Ranjith, J. Mech. Phys. Solids 49
(2001) 1865). Where chi is above 20, the two forms agree to rounding. With psi as there, r = b/a, and
c = mu_V/a + r psi, beside y of `layout.py`:

    y' = B - w,      chi' = (w' + r psi' w)/s,  w' = y - gamma w - a chi,      w = V (e^(chi - c) - e^(-chi - c))

where s = V (e^(chi - c) + e^(-chi - c)) is how w spreads over chi. w is some 1e-30 while the load passes through zero;
chi just follows the load then, which is why it is the state. Row WEAK has psi, row CHI chi, and t is w/s, tanh chi.
With cut-offs, psi in c is psi + ln((1 + q e^-psi)/(1 + q)), and friction a (chi - sgn(w) ln(1 + p |w|/V)).

This contact computes what `plain.py` leaves: cells and rigs whose belt or slip rests or turns round at the
start or in the drive, and cells whose slip comes to a rest that ln w cannot say.
"""

from math import exp as exp_of
from math import log
from typing import NamedTuple

from .. import contacts, observers
from .. import layout as at
from ..arithmetic import exp, select, widest_vectors
from ..arithmetic import log as ln
from ..dense import speed, work_by_ends
from ..drive import SMALLEST_SPEED, belt_in_lane
from ..jit import compiled
from ..lanes import run_lanes
from ..layout import DONE, RUNNING, Machine
from ..linking import by_law
from . import implicit, smooth
from . import rate_and_state as plain
from . import rate_state_laws as laws


class Regularised(NamedTuple):
    """Tag of this contact."""

    code: int


REGULARISED = Regularised(0)
TAG, LAWS, REGIMES = plain.TAG, plain.LAWS, plain.REGIMES  # which leaves the rest to this
A, B_STATE, MU_V, V, RATE, CUT_P, CUT_Q = laws.ROWS

CHI, CHI_NEW = at.ERROR_LOG, at.ERROR_LOG_NEW  # committed with the step, and no implicit step needs them
(LEVEL_0,) = laws.FREE.take(1)  # mu_V/a
BACK = laws.FREE.take(len(laws.P))[0] - laws.P_1  # rows P of what slips backwards, beyond those of what slips forwards
BACK_SERIES = at.SERIES_DW  # rows of its series: those of stages, which the step no longer needs
LOWEST = -450.0  # exponent of w below which there is no slip; to pass through 0, w takes steps as small as it is
ONE_WAY = 20.0  # chi from which on slip backwards is below rounding
EXACT = 30.0  # mu/a from which on the steady friction of both forms is the same


# --- the equations ----------------------------------------------------------------------------------------------------


@compiled(inline=True)
def cut(law, s, i, w):
    """What friction is above a chi."""
    more = laws.above(law, s, i, abs(w) / s[V + i])
    return select(w < 0.0, 0.0 - more, more)


@compiled(inline=True)
def spread(law, s, i, chi, psi):
    """w, and its derivative by chi."""
    c = s[LEVEL_0 + i] + laws.risen(law, s, i, 0.0, psi)
    ahead, back = exp(max(chi - c, LOWEST)), exp(max(-chi - c, LOWEST))
    return s[V + i] * (ahead - back), s[V + i] * (ahead + back)


@compiled(inline=True)
def has_ceased(law, s, i, chi, psi, chi_new, psi_new):
    """Return whether there is no slip at either end of a step, whose length nothing then limits."""
    c, c_new = laws.risen(law, s, i, 0.0, psi), laws.risen(law, s, i, 0.0, psi_new)
    return max(abs(chi) - c, abs(chi_new) - c_new) < LOWEST + s[LEVEL_0 + i]


@compiled(inline=True)
def follow(law, s, i, w, w_chi, psi):
    """psi', and its derivatives by chi and by psi."""
    per_v, rate = 1.0 / s[V + i], s[RATE + i]
    e = max(abs(w) * per_v, laws.NOTHING)
    g, g_phi, g_psi = laws.growth(law, e, ln(e), psi)
    by_chi = g_phi / e * (w_chi * per_v)
    sign = select(w > 0.0, 1.0, select(w < 0.0, -1.0, 0.0))
    return rate * g, rate * sign * by_chi, rate * (g_psi - laws.evolution(law, s, i, psi) / s[A + i] * g_phi)


@compiled(inline=True)
def force(law, s, i, y, w, chi):
    """w'."""
    return y - s[at.G + i] * w - s[A + i] * chi - cut(law, s, i, w)


class Motion(NamedTuple):
    """w and its derivative by chi; w' and w'' over that; chi', chi'', and the same of c."""

    w: float
    w_chi: float
    slope: float
    jerk: float
    chi_1: float
    chi_2: float
    c_1: float
    c_2: float


@compiled(inline=True)
def motion(law, s, i, t, h, y, chi, psi):
    """The motion at t after the start of a step of length h; where w' follows the load as in `plain.py`."""
    w, w_chi = spread(law, s, i, chi, psi)
    a, b, gamma = s[A + i], laws.evolution(law, s, i, psi), laws.damper(law, s, i, w)
    r = b / a
    per = 1.0 / w_chi
    tanh = w * per
    even = 1.0 - tanh * tanh
    z, z_chi, z_psi = follow(law, s, i, w, w_chi, psi)
    held, firm = (a * per + gamma) * h > plain.HELD, 1.0 / (a + gamma * w_chi)
    load, alpha = s[at.B + i] + t * s[at.ALPHA + i] - w - b * tanh * z, s[at.ALPHA + i]
    slope = load * firm
    less = laws.less_bent(law, s, i, psi, z, tanh, w, w_chi * slope)
    jerk = held_jerk(slope, w_chi, tanh, even, z, z_chi, z_psi, alpha, b, r, gamma, firm, less)
    slope = select(held, (load - w_chi * jerk) * firm, force(law, s, i, y, w, chi) * per)
    slope = min(max(slope, -plain.STEEPEST), plain.STEEPEST)
    less = laws.less_bent(law, s, i, psi, z, tanh, w, w_chi * slope)
    jerk = select(
        held,
        held_jerk(slope, w_chi, tanh, even, z, z_chi, z_psi, alpha, b, r, gamma, firm, less),
        (load - (gamma * w_chi + a) * slope) * per,
    )
    jerk = min(max(jerk, -plain.STEEPEST * plain.STEEPEST), plain.STEEPEST * plain.STEEPEST)
    chi_1, turn = slope + r * tanh * z, tanh * slope - r * z * even
    z_1 = z_chi * chi_1 + z_psi * z
    chi_2 = jerk - slope * turn + r * (even * chi_1 * z + tanh * z_1) - laws.less_turned(law, s, i, psi, z * z, tanh)
    return Motion(w, w_chi, slope, jerk, chi_1, chi_2, r * z, r * z_1 - laws.less_turned(law, s, i, psi, z * z, 1.0))


@compiled(inline=True)
def held_jerk(slope, w_chi, tanh, even, z, z_chi, z_psi, alpha, b, r, gamma, firm, less):
    """w'' over the derivative of w by chi where w' follows the load, and is `slope` times that; less : `less_bent`."""
    chi_1, turn = slope + r * tanh * z, tanh * slope - r * z * even
    z_1 = z_chi * chi_1 + z_psi * z
    return (
        alpha - w_chi * slope - b * (even * chi_1 * z + tanh * z_1) - gamma * w_chi * turn * slope - less
    ) * firm + slope * turn


# --- cells ------------------------------------------------------------------------------------------------------------


@compiled
def begin_cell(m, i, c):
    """Put cell c into lane i, if it is left; DONE if it is not, or cannot be computed."""
    if not observers.is_left(m, c) or smooth.open_cell(m, i, c) == DONE:
        return DONE
    s, cells, belt = m.s, m.cells, abs(m.cells[at.BELT, c])
    fastest = (s[at.FLOOR + i] - SMALLEST_SPEED) * 1e3  # of the belt
    s[V + i] = fastest if fastest > 0.0 else cells[laws.V_0, c]
    s[A + i], s[B_STATE + i] = cells[laws.DIRECT, c], cells[laws.EVOLUTION, c]
    s[CUT_P + i] = s[V + i] * cells[laws.PER_DIRECT, c]
    s[CUT_Q + i] = s[V + i] * cells[laws.PER_EVOLUTION, c]
    s[MU_V + i], s[RATE + i] = laws.in_logarithms(cells, c, s[V + i]), s[V + i] / cells[laws.DISTANCE, c]
    s[MU_V + i] -= laws.above(m.law, s, i, 1.0)
    s[laws.RATIO + i], s[LEVEL_0 + i] = s[B_STATE + i] / s[A + i], s[MU_V + i] / s[A + i]
    s[at.EVEN + i] = s[A + i]
    at_start = belt_in_lane(m, i, 0.0)
    w = plain.START * at_start if abs(at_start) > s[at.FLOOR + i] else 0.0  # at rest, but for rounding
    plain.start_slip(m, i, c, w)
    s[CHI + i] = friction_over_a(m.law, s, i, s[at.W + i], s[at.WEAK + i])
    at_rest = abs(s[at.W + i]) if s[at.W + i] != 0.0 else s[A + i]
    s[at.STEP + i] = 1e-3 * min(1.0, at_rest / s[A + i], 1.0 / s[RATE + i])
    if belt > 0.0:
        half = 0.5 * exp_of(min(laws.over_a(cells, c, belt), EXACT))
        tanh = half / (1.0 + half * half) ** 0.5
        at_once, later = tanh * s[A + i] / belt, tanh * laws.evolution(m.law, s, i, log(s[V + i] / belt)) / belt
        gamma = laws.damper(m.law, s, i, belt)
        implicit.judge_steady_sliding(s, i, gamma + at_once, gamma + at_once - later, belt / cells[laws.DISTANCE, c])
    derive_regularised(m.law, s, i)
    if s[at.W + i] == 0.0:  # where w' does not follow the load yet: friction is none
        observers.observe_standstill(m, i, s[at.Y + i])
    return RUNNING


def inner_load(m, i, t, y, w):
    """b psi: what is left of the load, in the direction of the belt."""
    s, way = m.s, 1.0 if m.s[at.B + i] > 0.0 else -1.0
    chi = way * (y - s[at.G + i] * w - speed(s, i, t)[1] - cut(m.law, s, i, w)) / s[A + i]
    return way * (s[A + i] * (chi + log((1.0 - exp_of(-2.0 * chi)) * s[V + i] / abs(w))) - s[MU_V + i])


def put(m, i, y, w, load):
    """Put lane i there."""
    s, way = m.s, 1.0 if w > 0.0 else -1.0
    s[at.Y + i], s[at.W + i], s[at.WEAK + i] = y, w, laws.state_of(m.law, s, i, way * load)
    s[CHI + i] = friction_over_a(m.law, s, i, w, s[at.WEAK + i])


@compiled
def friction_over_a(law, s, i, w, psi):
    """chi at a slip speed and a state."""
    c, over = s[LEVEL_0 + i] + laws.risen(law, s, i, 0.0, psi), abs(w) / s[V + i]
    if over == 0.0:
        return 0.0
    chi = max(log(0.5 * (over + (over * over + 4.0 * exp_of(-2.0 * c)) ** 0.5)) + c, 0.0)
    return chi if w > 0.0 else -chi


@by_law("si:")
def derive_regularised(law, s, i):
    """w' and w'' of lane i at its present state."""
    now = motion(law, s, i, 0.0, s[at.STEP + i], s[at.Y + i], s[CHI + i], s[at.WEAK + i])
    s[at.DW + i], s[at.JERK + i] = now.w_chi * now.slope, now.w_chi * now.jerk


@compiled
def handle_event(m, i):
    """Look at lane i, whose step was flagged."""
    if smooth.commit(m, i) == DONE:
        return DONE
    derive_regularised(m.law, m.s, i)  # the belt may accelerate otherwise from here on
    return RUNNING


@compiled
def deviation(m, i):
    """Of friction and load over a, and of ln theta."""
    s = m.s
    y, psi, chi = s[at.Y_STAR + i] - s[at.G + i] * s[at.B + i], s[at.WEAK + i], s[CHI + i]
    y -= cut(m.law, s, i, s[at.B + i])
    return max(abs(chi - y / s[A + i]), abs(psi), abs(s[at.Y + i] - s[at.Y_STAR + i]) / s[A + i])


def smallest_step(contact):
    """That of the other form."""
    return plain.TINIEST_STEP


def steady_friction(contact, law, cells, c, w):
    """a asinh(e^((mu_0 + (a - b) ln(w/v_0))/a)/2), and what cut-offs change."""
    over = laws.over_a(cells, c, max(w, laws.NOTHING))
    half, a = 0.5 * exp_of(min(over, EXACT)), cells[laws.DIRECT, c]
    chi = over if over > EXACT else log(half + (1.0 + half * half) ** 0.5)
    return a * chi - a * log(1.0 + w * cells[laws.PER_DIRECT, c])


# --- a step -----------------------------------------------------------------------------------------------------------


def try_step(m):
    """A step of the size STEP in every lane; nothing is committed."""
    step_regularised(m.law, m.s, m.rtol)


@by_law("sf:")
def step_regularised(law, s, rtol):
    """The same."""
    kind = (REGULARISED, law)
    implicit.factorise(kind, s)
    implicit.stages(kind, s)
    control_step(law, s, rtol)


implicit.variable.of(Regularised)(lambda kind, s, i: s[CHI + i])


@implicit.rates.of(Regularised)
def _rates(kind, s, i, y, chi, psi):
    law = kind[1]
    w, w_chi = spread(law, s, i, chi, psi)
    z, _, _ = follow(law, s, i, w, w_chi, psi)
    return w, (force(law, s, i, y, w, chi) + laws.evolution(law, s, i, psi) / s[A + i] * z * w) / w_chi, z


@implicit.slopes.of(Regularised)
def _slopes(kind, s, i, y, chi, psi):
    law = kind[1]
    w, w_chi = spread(law, s, i, chi, psi)
    gamma, r, per = laws.damper(law, s, i, w), laws.evolution(law, s, i, psi) / s[A + i], 1.0 / w_chi
    tanh, pull = w * per, force(law, s, i, y, w, chi) * per
    z, z_chi, z_psi = follow(law, s, i, w, w_chi, psi)
    by_chi = -gamma - s[A + i] * per - pull * tanh + r * (z_chi * tanh + z * (1.0 - tanh * tanh))
    by_psi = r * (gamma * tanh + pull + tanh * z_psi) - laws.less_turned(law, s, i, psi, z, tanh)
    return w_chi, per, by_chi, by_psi, z_chi, z_psi


@implicit.couple.of(Regularised)
def _couple(kind, s, i, l_10, v_z):
    by_z = -laws.evolution(kind[1], s, i, s[at.WEAK + i]) / s[A + i] * s[at.W + i]
    s[implicit.W_02 + i] = by_z
    return -v_z - l_10 * by_z


implicit.coupled.of(Regularised)(lambda kind, s, i, k_2: s[implicit.W_02 + i] * k_2)


@compiled
def control_step(law, s, rtol):
    """End of the step, its error, and the size of the next; errors as in `plain.py`."""
    widest_vectors()
    tolerance2 = 1.0 / (plain.SPENT * rtol) ** 2
    for i in range(at.WIDTH):
        (y, chi, psi), (e_0, e_1, e_2) = implicit.end_of_step(s, i), implicit.errors(s, i)
        h, chi_0, psi_0 = s[at.TAKEN + i], s[CHI + i], s[at.WEAK + i]
        end, w_chi_0 = motion(law, s, i, h, h, y, chi, psi), spread(law, s, i, chi_0, psi_0)[1]
        e_0 /= s[A + i]
        e_1 -= laws.evolution(law, s, i, psi) / s[A + i] * end.w / end.w_chi * e_2
        e_1 *= plain.weight(law, s, i, max(w_chi_0, end.w_chi))
        e_1 *= max(end.w_chi / max(abs(end.w), s[V + i]), 1.0)  # of w, where friction is far below a
        error2 = (e_0 * e_0 + e_1 * e_1 + e_2 * e_2) * tolerance2
        good, factor = error2 <= 1.0, implicit.step_factor(error2)
        s[at.Y_NEW + i], s[at.W_NEW + i], s[at.WEAK_NEW + i], s[CHI_NEW + i] = y, end.w, psi, chi
        s[at.DW_NEW + i], s[at.JERK_NEW + i] = end.w_chi * end.slope, end.w_chi * end.jerk
        rise, fall = chi - chi_0, laws.risen(law, s, i, psi_0, psi)
        ahead = select(max(chi, chi_0) > -ONE_WAY, abs(rise - fall), 0.0)
        back = select(min(chi, chi_0) < ONE_WAY, abs(rise + fall), 0.0)
        short = max(h * max(abs(end.slope), abs(s[at.DW + i] / w_chi_0)), ahead, back) < plain.LONGEST_RISE
        short = short | has_ceased(law, s, i, chi_0, psi_0, chi, psi)
        s[at.GOOD + i] = select(good & short, 1.0, 0.0)
        s[at.STEP + i] = select(short, factor, min(factor, 0.5)) * s[at.STEP + i]
        s[at.WORK + i] = work_by_ends(s, i, h)


def expand(m):
    """Series of w over the step: of what slips forwards, less what slips backwards, each as in `plain.py`."""
    expand_regularised(m.law, m.s)


@by_law("s:")
def expand_regularised(law, s):
    """The same."""
    widest_vectors()
    for i in range(at.WIDTH):
        h, chi, chi_new, psi, psi_new = (
            s[at.TAKEN + i], s[CHI + i], s[CHI_NEW + i], s[at.WEAK + i], s[at.WEAK_NEW + i]
        )  # fmt: skip
        p, q = (
            motion(law, s, i, 0.0, h, s[at.Y + i], chi, psi),
            motion(law, s, i, h, h, s[at.Y_NEW + i], chi_new, psi_new),
        )
        rise, fall = chi_new - chi, laws.risen(law, s, i, psi, psi_new)
        laws.put_powers(s, i, 0, h, rise - fall, p.chi_1 - p.c_1, q.chi_1 - q.c_1, p.chi_2 - p.c_2, q.chi_2 - q.c_2)
        laws.put_powers(
            s, i, BACK, h, -rise - fall, -p.chi_1 - p.c_1, -q.chi_1 - q.c_1, -p.chi_2 - p.c_2, -q.chi_2 - q.c_2
        )
        forwards, backwards = 0.5 * (p.w_chi + p.w), 0.5 * (p.w_chi - p.w)
        slips = not has_ceased(law, s, i, chi, psi, chi_new, psi_new)
        s[at.SERIES + i] = select(slips & (max(chi, chi_new) > -ONE_WAY), forwards, 0.0)
        s[BACK_SERIES + i] = select(slips & (min(chi, chi_new) < ONE_WAY), backwards, 0.0)
    laws.find_terms(s, 0, at.SERIES)
    laws.find_terms(s, BACK, BACK_SERIES)
    for i in range(at.WIDTH):
        per_h, scale = 1.0 / s[at.TAKEN + i], 1.0
        for n in range(at.ORDER + 1):
            row, back = at.SERIES + n * at.WIDTH + i, BACK_SERIES + n * at.WIDTH + i
            s[row] = select(scale < plain.LARGEST, (s[row] - s[back]) * scale, 0.0)
            scale *= per_h


LINKED = (
    *plain.LINKED, laws.risen, laws.damper, derive_regularised, step_regularised,
    expand_regularised,
)  # fmt: skip
contacts.register(Regularised, globals())


@contacts.run_rest.of(plain.RateAndState)
def _run_rest(m, stop):
    run_lanes(Machine(REGULARISED, m.law, m.drive, m.observer, m.s, m.cells, m.rtol, m.max_steps), stop)
