"""Rate-and-state friction: mu = mu_0 + a ln(w/v_0) + b ln(v_0 theta/D), theta being the state of the contact.

    ageing law  theta' = 1 - w theta/D                       slip law  theta' = -(w theta/D) ln(w theta/D)

J. H. Dieterich, J. Geophys. Res. 84 (1979) 2161; A. Ruina, J. Geophys. Res. 88 (1983) 10359. With phi = ln(w/V) and psi
= ln(theta V/D) beside y of `layout.py`, V being a speed of the cell,

    y' = B - w,      phi' = w'/w,  w' = y - gamma w - mu_V - a phi - b psi,      psi' = (V/D) g(phi, psi)

g = e^-psi - e^phi (ageing) or -e^phi (phi + psi) (slip). The slip speed spans dozens of decades and never vanishes, and
friction holds it back at rates of a/w, so steps are linearly implicit (`implicit.py`) with ln w as the state. Row
WEAK has psi.
"""

from math import inf, isnan, log
from typing import NamedTuple

from .. import contacts
from .. import layout as at
from ..arithmetic import exp, select, widest_vectors
from ..arithmetic import log as ln
from ..dense import speed, work_by_ends
from ..drive import SMALLEST_SPEED, belt_in_lane, keeps_direction
from ..jit import compiled
from ..layout import DONE, RUNNING
from ..linking import by_law
from ..observers.recurrence import Recurrence
from . import explicit, implicit, smooth
from . import rate_state_laws as laws


class RateAndState(NamedTuple):
    """Tag of this contact."""

    code: int


TAG, LAWS, REGIMES = RateAndState(0), laws.LAWS, Recurrence
A, B_STATE, MU_V, V, RATE, CUT_P, CUT_Q = laws.ROWS
SPENT = 1.0  # of the tolerance that one step may spend
CARRIED, LIGHTEST = 10.0, 1e-2  # weight of an error in ln w over what it leaves in load and state; the least
HELD = 30.0  # relaxations of w' in a step from which on it follows the load
TINIEST_STEP = 1e-250
STEEPEST = 1e150  # slope of ln w in a series, whose square is finite
LARGEST = 1e250  # power of 1/h in a series
LONGEST_RISE = 3.0  # of ln w in a step, so that its series hold
START = 0.1  # slip speed at the start, over that of the belt

# Series: rates up to which steps are theirs, of friction and of the state; stock being taken after so many; steps that
# are short, and the longest, in radians; how much of one that passes the speed of the belt and back is left as it is
MOST_FIRM, MOST_RATE, STOCK, SHORT, LONGEST, MOST_OF_STEP = 0.3, 10.0, 32.0, 0.05, 1.0, 0.99
OF_SERIES, ROOM = tuple(range(at.SERIES, at.SERIES_DW, at.WIDTH)), at.SERIES_DW  # rows, and where they are set aside


# --- the equations ----------------------------------------------------------------------------------------------------


@compiled(inline=True)
def force(law, s, i, y, w, phi, psi):
    """w'."""
    more, later = laws.above(law, s, i, w / s[V + i]), laws.further(law, s, i, psi)
    return y - s[at.G + i] * w - s[MU_V + i] - s[A + i] * phi - s[B_STATE + i] * psi - more - later


@compiled(inline=True)
def derivatives(law, s, i, t, h, y, phi, psi):
    """phi' and phi'' at t after the start of a step of length h.

    Where friction holds w back, w' is the small difference of large forces, and what the step leaves of an error in
    phi would be all of it. There it follows the load, which changes slowly: w' = (y' - b psi' - w'')/(gamma + a/w), to
    one over the square of HELD.
    """
    e = exp(phi)
    a, b = laws.direct(law, s, i, e), laws.evolution(law, s, i, psi)
    w, gamma, rate = s[V + i] * e, s[at.G + i], s[RATE + i]
    g, g_phi, g_psi = laws.growth(law, e, phi, psi)
    held, firm = (a / w + gamma) * h > HELD, 1.0 / (a + gamma * w)
    load = s[at.B + i] + t * s[at.ALPHA + i] - w - b * rate * g
    slope = load * firm
    turn = laws.bent(law, s, i, e, psi, slope, rate * g)
    bend = held_bend(s, i, w, b, slope, rate * (g_phi * slope + g_psi * rate * g), turn, firm)
    slope = select(held, (load - w * (bend + slope * slope)) * firm, force(law, s, i, y, w, phi, psi) / w)
    slope = min(max(slope, -STEEPEST), STEEPEST)
    turn = laws.bent(law, s, i, e, psi, slope, rate * g)
    bend = select(
        held,
        held_bend(s, i, w, b, slope, rate * (g_phi * slope + g_psi * rate * g), turn, firm),
        (load - gamma * w * slope - a * slope) / w - slope * slope,
    )
    return slope, min(max(bend, -STEEPEST * STEEPEST), STEEPEST * STEEPEST)


@compiled(inline=True)
def held_bend(s, i, w, b, slope, psi_2, turn, firm):
    """phi'' where w' follows the load; psi_2 is psi'', turn what is `bent`."""
    return (s[at.ALPHA + i] - w * slope - b * psi_2 - s[at.G + i] * w * slope * slope - turn) * firm


@compiled(inline=True)
def put_motion(s, i, row, w, slope, bend):
    """w, w' and w'' in rows of lane i that are `row` from those of the state."""
    s[row + at.W + i], s[row + at.DW + i], s[row + at.JERK + i] = w, w * slope, w * (bend + slope * slope)


# --- cells ------------------------------------------------------------------------------------------------------------


@compiled
def begin_cell(m, i, c):
    """Put cell c into lane i; DONE if it cannot be computed, or if slip need not keep its direction."""
    cells, belt = m.cells, m.cells[at.BELT, c]
    if not keeps_direction(m, c) or smooth.open_cell(m, i, c) == DONE:
        return DONE
    s = m.s
    speed = (s[at.FLOOR + i] - SMALLEST_SPEED) * 1e3  # of the belt, or its largest
    way = 1.0 if belt_in_lane(m, i, 0.0) > 0.0 else -1.0
    s[V + i], s[A + i], s[B_STATE + i] = way * speed, way * cells[laws.DIRECT, c], way * cells[laws.EVOLUTION, c]
    s[MU_V + i] = way * contacts.steady_friction(m.contact, m.law, cells, c, speed)
    s[RATE + i], s[at.EVEN + i] = speed / cells[laws.DISTANCE, c], cells[laws.DIRECT, c]
    s[CUT_P + i], s[CUT_Q + i] = speed * cells[laws.PER_DIRECT, c], speed * cells[laws.PER_EVOLUTION, c]
    s[MU_V + i] -= laws.above(m.law, s, i, 1.0) + laws.further(m.law, s, i, 0.0)
    start_slip(m, i, c, START * s[V + i])
    if not way * s[at.W + i] > 0.0:
        return DONE
    s[at.STEP + i] = 1e-3 * min(1.0, s[at.W + i] / s[A + i], 1.0 / s[RATE + i])
    over = belt / s[V + i]
    at_once = s[at.G + i] + laws.direct(m.law, s, i, over) / belt
    later = laws.evolution(m.law, s, i, -log(over)) / belt
    implicit.judge_steady_sliding(s, i, at_once, at_once - later, abs(belt) / cells[laws.DISTANCE, c])
    s[explicit.MOST + i] = LONGEST
    if not is_later(m, c):
        explicit.step_by_series(m, i, STOCK)
    derive(m.law, s, i)
    return RUNNING


@compiled
def is_later(m, c):
    """Cells whose steps are not those of series."""
    if not laws.has_series(m.law):
        return True
    cells, speed = m.cells, abs(m.cells[at.BELT, c])
    return cells[laws.DIRECT, c] > MOST_FIRM * speed or speed > MOST_RATE * cells[laws.DISTANCE, c]


@compiled
def start_slip(m, i, c, w):
    """The slip speed, w unless it is given, and the state that cell c begins with."""
    s, contact = m.s, m.cells[at.CONTACT_START, c]
    if isnan(m.cells[at.ETA_START, c]):
        s[at.W + i] = w
        smooth.place(m, i, m.cells[at.XI_START, c])
    s[at.WEAK + i] = log(contact * s[RATE + i]) if contact > 0.0 else 0.0


@by_law("si:")
def derive(law, s, i):
    """w' and w'' of lane i at its present state."""
    phi = ln(s[at.W + i] / s[V + i])
    h = 0.0 if s[at.BY_SERIES + i] > 0.0 else s[at.STEP + i]
    slope, bend = derivatives(law, s, i, 0.0, h, s[at.Y + i], phi, s[at.WEAK + i])
    put_motion(s, i, 0, s[at.W + i], slope, bend)


@compiled
def handle_event(m, i):
    """Look at lane i, whose step was flagged."""
    s = m.s
    if s[at.BY_SERIES + i] > 0.0 and is_tried_again(m, i):
        return RUNNING
    loosened = s[at.BY_SERIES + i] == 0.0 and laws.has_series(m.law) and has_loosened(s, i)
    if smooth.commit(m, i) == DONE:
        return DONE
    if loosened:
        explicit.step_by_series(m, i, STOCK)
    derive(m.law, s, i)  # the belt may accelerate otherwise from here on
    return RUNNING


@compiled(apart=True)
def is_tried_again(m, i):
    """Take stock in lane i, which steps by series, where that is due; return whether its step is not committed."""
    s = m.s
    if s[at.FLAG + i] == at.HALTED:
        if s[at.TRIED + i] < m.max_steps:
            take_stock(m, i)
            return True
        return False
    t = explicit.passes_twice(s, i, s[at.B + i])
    if 0.0 < t < MOST_OF_STEP * s[at.TAKEN + i]:
        s[explicit.CAP + i] = t  # to end there
        return True
    return False


@compiled(inline=True)
def has_loosened(s, i):
    """Return whether slip that passes the speed of the belt was nowhere held back fast in the loop that ends so."""
    b, way = s[at.B + i], 1.0 if s[at.B + i] > 0.0 else -1.0
    least = s[at.V_LOW + i] if b > 0.0 else -s[at.V_HIGH + i]
    ends = way * s[at.W + i] <= way * b < way * s[at.W_NEW + i]
    return ends and abs(s[A + i]) < MOST_FIRM * least and s[RATE + i] < MOST_RATE


@compiled
def take_stock(m, i):
    """Let lane i step by the implicit method where steps by series turn out to be short."""
    if m.s[at.TAU + i] - m.s[explicit.SINCE + i] < SHORT * STOCK:
        explicit.step_implicitly(m, i)
        derive(m.law, m.s, i)
    else:
        explicit.step_by_series(m, i, STOCK)


@compiled
def deviation(m, i):
    """Of ln w, of ln theta, and of friction over a."""
    s = m.s
    return max(abs(ln(s[at.W + i] / s[V + i])), abs(s[at.WEAK + i]), abs((s[at.Y + i] - s[at.Y_STAR + i]) / s[A + i]))


def inner_load(m, i, t, y, w):
    """b psi: what is left of the load."""
    s = m.s
    if s[at.BY_SERIES + i] > 0.0:
        return s[B_STATE + i] * explicit.state_after(s, i, t)[0]
    rest = y - s[at.G + i] * w - s[MU_V + i] - s[A + i] * ln(w / s[V + i]) - speed(s, i, t)[1]
    return rest - laws.above(m.law, s, i, w / s[V + i]) - laws.further(m.law, s, i, 0.0)


def put(m, i, y, w, load):
    """Put lane i there."""
    m.s[at.Y + i], m.s[at.W + i], m.s[at.WEAK + i] = y, w, laws.state_of(m.law, m.s, i, load)


def smallest_step(contact):
    """Held back by more friction than the load, slip slows down by dozens of decades within no time."""
    return TINIEST_STEP


def steady_friction(contact, law, cells, c, w):
    """mu_0 + (a - b) ln(w/v_0), and what cut-offs change."""
    return laws.in_logarithms(cells, c, w)


# --- a step -----------------------------------------------------------------------------------------------------------


def try_step(m):
    """A step of the size STEP in every lane, or by series; nothing is committed."""
    step(m.law, m.s, m.rtol)


@by_law("sf:")
def step(law, s, rtol):
    """The same."""
    kind = (TAG, law)
    implicit.factorise(kind, s)
    implicit.stages(kind, s)
    control_step(law, s, rtol)
    if laws.has_series(law) and explicit.may_step_by_series(s):
        step_some(law, s, rtol)


@compiled(apart=True)
def step_some(law, s, rtol):
    """The step by series of lanes that step so, in place of the one that all have taken: hardly ever all step so, and
    where none does the loops had better not stand behind a branch.
    """
    explicit.set_aside(s, explicit.OF_STEP, at.AFTER)
    laws.step_by_series(law, s, rtol)
    explicit.bring_back(s, explicit.OF_STEP, at.AFTER, 0.0)
    for i in range(at.WIDTH):
        s[at.STEP + i] = select(s[at.BY_SERIES + i] > 0.0, inf, s[at.STEP + i])
    explicit.set_aside(s, OF_SERIES, ROOM)


implicit.variable.of(RateAndState)(lambda kind, s, i: ln(s[at.W + i] / s[V + i]))


@implicit.rates.of(RateAndState)
def _rates(kind, s, i, y, phi, psi):
    e = exp(phi)
    w = s[V + i] * e
    return w, force(kind[1], s, i, y, w, phi, psi) / w, s[RATE + i] * laws.growth(kind[1], e, phi, psi)[0]


@implicit.slopes.of(RateAndState)
def _slopes(kind, s, i, y, phi, psi):
    law, w = kind[1], s[at.W + i]
    per_w, e = 1.0 / w, w / s[V + i]
    _, g_phi, g_psi = laws.growth(law, e, phi, psi)
    slope = force(law, s, i, y, w, phi, psi) * per_w
    at_once = -s[at.G + i] - laws.direct(law, s, i, e) * per_w - slope
    return w, per_w, at_once, -laws.evolution(law, s, i, psi) * per_w, s[RATE + i] * g_phi, s[RATE + i] * g_psi


@compiled(inline=True)
def weight(law, s, i, w):
    """Share of an error in ln w that counts.

    Friction takes it back within w/a. Till then load over a and ln theta change by w/a and w/D times as much as it is.
    """
    carried = (w / laws.direct(law, s, i, w / abs(s[V + i]))) * w * (1.0 / s[A + i] + s[RATE + i] / s[V + i])
    return max(min(CARRIED * carried, 1.0), LIGHTEST)


@compiled
def control_step(law, s, rtol):
    """End of the step, its error, and the size of the next.

    Errors are those of ln w, weighed, and of ln theta, and of the load over a, by which they move ln w.
    """
    widest_vectors()
    tolerance2 = 1.0 / (SPENT * rtol) ** 2
    for i in range(at.WIDTH):
        (y, phi, psi), (e_0, e_1, e_2) = implicit.end_of_step(s, i), implicit.errors(s, i)
        e_0 /= s[A + i]
        w_new = s[V + i] * exp(phi)
        e_1 *= weight(law, s, i, max(abs(s[at.W + i]), abs(w_new)))
        error2 = (e_0 * e_0 + e_1 * e_1 + e_2 * e_2) * tolerance2
        good, factor = error2 <= 1.0, implicit.step_factor(error2)
        h = s[at.TAKEN + i]
        slope, bend = derivatives(law, s, i, h, h, y, phi, psi)
        s[at.Y_NEW + i], s[at.WEAK_NEW + i] = y, psi
        put_motion(s, i, at.Y_NEW - at.Y, w_new, slope, bend)
        short = (
            h * max(abs(slope), abs(s[at.DW + i] / s[at.W + i]), abs(phi - s[implicit.V_START + i]) / h) < LONGEST_RISE
        )
        s[at.GOOD + i] = select(good & short, 1.0, 0.0)
        s[at.STEP + i] = select(short, factor, min(factor, 0.5)) * s[at.STEP + i]
        s[at.WORK + i] = work_by_ends(s, i, h)


@compiled(inline=True)
def expand(m):
    """Series of w over the step: of exp of the quintic Hermite polynomial of ln w."""
    s = m.s
    widest_vectors()
    for i in range(at.WIDTH):
        h, w, w_new = s[at.TAKEN + i], s[at.W + i], s[at.W_NEW + i]
        slope, slope_new = s[at.DW + i] / w, s[at.DW_NEW + i] / w_new
        bend, bend_new = s[at.JERK + i] / w - slope * slope, s[at.JERK_NEW + i] / w_new - slope_new * slope_new
        laws.put_powers(s, i, 0, h, ln(w_new / w), slope, slope_new, bend, bend_new)
        s[at.SERIES + i] = w
    laws.find_terms(s, 0, at.SERIES)
    for i in range(at.WIDTH):
        per_h, scale = 1.0 / s[at.TAKEN + i], 1.0
        for n in range(1, at.ORDER + 1):
            scale *= per_h
            row = at.SERIES + n * at.WIDTH + i
            s[row] = select(scale < LARGEST, s[row] * scale, 0.0)
    if laws.has_series(m.law) and explicit.may_step_by_series(s):
        bring_back_series(s)


@compiled(apart=True)
def bring_back_series(s):
    """Series that lanes had before."""
    explicit.bring_back(s, OF_SERIES, ROOM, 1.0)


LINKED = (
    laws.above, laws.direct, laws.evolution, laws.further, laws.state_of, laws.has_series, derive, step,
)  # fmt: skip
contacts.register(RateAndState, globals())
