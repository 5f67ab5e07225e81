"""Bristles between the surfaces: the LuGre model on any friction curve g(w) + a2 w, and the elasto-plastic one.

    z' = w (1 - alpha(q) q),  q = sgn(w) sigma_0 z/g(|w|),        F = sigma_0 z + sigma_1(w) z' + a2 w

alpha = 1 is LuGre; with an elastic part p, alpha is 0 up to q = p and rises to 1 at q = 1, so that bristles give way
from there on only. g is that part of the curve which does not grow with the speed for ever. With f = sigma_0 z, in
kernel units, beside y of `layout.py`:

    y' = B - w,      w' = y - (gamma + a2) w - f - s_1 z',      f' = s_0 z'

C. Canudas de Wit, H. Olsson, K. J. Astrom, P. Lischinsky, IEEE Trans. Autom. Control 40 (1995) 419; P. Dupont, V.
Hayward, B. Armstrong, F. Altpeter, ibid. 47 (2002) 787. |w| has a kink at w = 0: a step holds on to the sign of w that
it begins with, and one that would pass zero is tried again so that it ends there. Row WEAK has f.
"""

from math import exp as exp_of
from math import nan

from .. import contacts
from .. import layout as at
from ..arithmetic import select
from ..dense import interpolate
from ..drive import SMALLEST_SPEED
from ..jit import compiled
from ..layout import DONE, RUNNING
from ..linking import by_law
from ..observers import return_map
from ..observers.recurrence import Recurrence
from ..roots import TO_ROUNDING, crossing, end_motion, extreme_speed, grazes, reaches
from . import bristles, explicit, smooth
from .explicit import MOST, SINCE
from .implicit import judge_steady_sliding
from .stribeck import laws
from .stribeck.equations import know_steepness
from .stribeck.friction import TABLES, coefficient, coefficient_slope

TAG = bristles.LuGre(0)
LAWS, REGIMES = {f"lugre_{name}": law for name, law in (laws.LAWS | TABLES).items()}, Recurrence

(FITS,) = bristles.ROWS.take(1)  # 1 where a lane steps by series again once it swings
TERMS = 6  # of a series between ends
# what that of one kind of step would overwrite of the other
OF_SERIES = (at.WORK, *range(at.SERIES, at.SERIES + TERMS * at.WIDTH, at.WIDTH))
PASSED = 0.1  # tolerances, of the speed: slip back by less has not passed zero
BEYOND, AT_MOST = 1.5, 2.0  # of this: where a step that passes zero is to end, and the most it may be beyond
TINIEST_STEP = 1e-60
SOFT = 1e3  # s_0 up to which steps are those of series ...
STOCK, SHORT, SWINGING = 256.0, 0.15, 0.5  # ... stock being taken after so many; of the longest: short ones; of a swing
LONGEST = 3.0  # of them, in radians of bristles that swing


# --- cells ------------------------------------------------------------------------------------------------------------


@compiled
def begin_cell(m, i, c):
    """Put cell c into lane i, its bristles relaxed; DONE if it cannot be computed."""
    s, cells, b = m.s, m.cells, abs(m.cells[at.BELT, c])
    if smooth.open_cell(m, i, c) == DONE:
        return DONE
    s[at.SLOPE + i], s[at.DROP + i], s[at.RATE + i] = cells[at.A2, c], cells[at.A3, c], 1.0 / cells[at.A4, c]
    s[at.EXPONENT + i], s[bristles.LEVEL_OF_CURVE + i] = cells[at.DELTA, c], cells[at.A1, c]
    s[bristles.S_0 + i], s[bristles.S_1 + i] = cells[at.CONTACT_STIFFNESS, c], cells[at.CONTACT_DAMPING, c]
    s[bristles.S_1_RATE + i] = cells[at.CONTACT_DAMPING_RATE, c]
    s[bristles.ELASTIC + i] = cells[at.ELASTIC_PART, c]
    s[MOST + i], s[bristles.QUIET + i], s[FITS + i] = LONGEST / (1.0 + s[bristles.S_0 + i]) ** 0.5, 0.0, 0.0
    know_steepness(m.law, s, i, cells, c)
    s[at.STEP + i] = 1e-3 / (1.0 + s[bristles.S_0 + i] ** 0.5 + s[bristles.S_1 + i])
    if not is_later(m, c):
        explicit.step_by_series(m, i, STOCK)
    s[bristles.LOAD_SCALE + i] = cells[at.A1, c] + max(cells[at.A3, c], 0.0)
    fastest = (s[at.FLOOR + i] - SMALLEST_SPEED) * 1e3  # of the belt
    s[bristles.SPEED_SCALE + i] = fastest if fastest > 0.0 else s[bristles.LOAD_SCALE + i] / s[bristles.S_0 + i] ** 0.5
    s[at.WEAK + i], s[bristles.SIGN + i], s[return_map.TIMES + i] = 0.0, 1.0, return_map.MOST_FIRM
    if b > 0.0:
        judge(m, i, c, b)
    derive(m.law, s, i)
    sign = s[at.W + i] if s[at.W + i] != 0.0 else s[at.DW + i] if s[at.DW + i] != 0.0 else s[at.JERK + i]
    slide(m, i, -1.0 if sign < 0.0 else 1.0)
    derive(m.law, s, i)
    return RUNNING


@compiled
def is_later(m, c):
    """Cells whose steps are not those of series."""
    cells = m.cells
    plain = cells[at.ELASTIC_PART, c] == 0.0 and cells[at.CONTACT_DAMPING, c] * cells[at.CONTACT_DAMPING_RATE, c] == 0.0
    return not (bristles.has_series(m.law) and plain and cells[at.CONTACT_STIFFNESS, c] < SOFT)


@compiled
def judge(m, i, c, b):
    """What linear theory says of steady sliding at the belt speed b."""
    s, cells = m.s, m.cells
    g, slope = coefficient(m.law, cells, c, b) - cells[at.A2, c] * b, coefficient_slope(m.law, cells, c, b)
    s_1 = s[bristles.S_1 + i] * exp_of(-((s[bristles.S_1_RATE + i] * b) ** 2))
    drag = s[at.G + i] + cells[at.A2, c]
    judge_steady_sliding(
        s, i, drag + s_1 * b * (slope - cells[at.A2, c]) / g, s[at.G + i] + slope, b * s[bristles.S_0 + i] / g
    )


@compiled(inline=True)
def slide(m, i, sign):
    """Let lane i hold on to this sign of w, until w is beyond zero by more than steps leave of it."""
    passed = PASSED * m.s[bristles.SPEED_SCALE + i] * min(m.rtol, 1.0 / (1.0 + m.s[bristles.S_0 + i]))
    m.s[bristles.SIGN + i], m.s[at.SIDE + i], m.s[at.LEVEL + i] = sign, -sign, -sign * passed
    m.s[at.RATE + i] = sign * abs(m.s[at.RATE + i])


@by_law("si:")
def derive(law, s, i):
    """w' and w'' of lane i at its present state."""
    w = s[at.W + i]
    if s[at.BY_SERIES + i] > 0.0:
        s[at.DW + i], s[at.JERK + i], _ = bristles.motion(law, s, i, 0.0, s[at.Y + i], w, s[at.WEAK + i])
        return
    s[at.DW + i], s[at.JERK + i] = bristles.derivatives(law, s, i, 0.0, s[at.STEP + i], s[at.Y + i], w, s[at.WEAK + i])


@compiled
def handle_event(m, i):
    """Look at lane i, whose step was flagged: one that passes zero is tried again, to end there."""
    s = m.s
    if s[at.FLAG + i] == at.HALTED and s[at.TRIED + i] < m.max_steps and s[at.STEP + i] >= TINIEST_STEP:
        take_stock(m, i)
        return RUNNING
    if s[at.FLAG + i] != at.HALTED:
        t = time_to_zero(s, i)
        if t > 0.0 and s[at.BY_SERIES + i] == 0.0:
            s[at.STEP + i] = t
            return RUNNING
        if s[at.BY_SERIES + i] > 0.0:
            if t > 0.0:
                bristles.end_earlier(m.law, s, i, t)
            t = explicit.passes_twice(s, i, s[at.B + i])
            if t > 0.0:
                bristles.end_earlier(m.law, s, i, t)
        if reaches(s, i, s[at.W_NEW + i]):
            slide(m, i, -s[bristles.SIGN + i])
    swings = s[at.DW + i] * s[at.DW_NEW + i] < 0.0 and s[FITS + i] > 0.0 and s[at.TAKEN + i] < SWINGING * s[MOST + i]
    if smooth.commit(m, i) == DONE:
        return DONE
    if swings:
        s[FITS + i] = 0.0
        explicit.step_by_series(m, i, STOCK)
    derive(m.law, s, i)
    return RUNNING


@compiled
def take_stock(m, i):
    """Let lane i step by the implicit method where steps by series turn out to be short, or nothing swings."""
    s = m.s
    short = s[at.TAU + i] - s[SINCE + i] < SHORT * STOCK * s[MOST + i]
    if short or s[bristles.QUIET + i] >= STOCK:
        explicit.step_implicitly(m, i)
        s[FITS + i] = 0.0 if short else 1.0
        derive(m.law, s, i)
    else:
        explicit.step_by_series(m, i, STOCK)


@compiled
def time_to_zero(s, i):
    """When, within the step of lane i, w is as far beyond zero as a step is to end; 0 where it does, or never is."""
    h, side, level, at_end = s[at.TAKEN + i], s[at.SIDE + i], s[at.LEVEL + i], end_motion(s, i)
    if reaches(s, i, at_end[0]):
        if side * at_end[0] <= AT_MOST * side * level:
            return 0.0
        return crossing(s, i, 0, BEYOND * level, h, at_end, TO_ROUNDING)
    if grazes(s, i, h, at_end[0], at_end[1]):
        t, w = extreme_speed(s, i, h, at_end, TO_ROUNDING)
        if side * w > AT_MOST * side * level:
            return crossing(s, i, 0, BEYOND * level, t, (w, 0.0, 0.0, 0.0), TO_ROUNDING)
    return 0.0


@compiled
def deviation(m, i):
    """Of w over b and over the scale of the curve, and of the deflection."""
    s = m.s
    b, over = s[at.B + i], abs(s[at.W + i] - s[at.B + i])
    return max(over / abs(b), over * abs(s[at.RATE + i]), abs(s[at.WEAK + i] / on_curve(m, i) - 1.0))


def inner_load(m, i, t, y, w):
    """Of f, by how much it is off the curve: in loops about steady sliding that slide all the time. In others bristles
    may swing at any phase, and a deviation is not that of such a loop.
    """
    s = m.s
    sign = 1.0 if w > 0.0 else -1.0
    slides = s[at.V_LOW + i] > 0.0 if w > 0.0 else s[at.V_HIGH + i] < 0.0
    if s[at.BY_SERIES + i] == 0.0 or not (slides and sign * (y - s[at.Y_STAR + i]) > 0.0):
        return nan
    return explicit.state_after(s, i, t)[0] - on_curve(m, i)


def put(m, i, y, w, load):
    """Put lane i there."""
    m.s[at.Y + i], m.s[at.W + i], m.s[at.WEAK + i] = y, w, on_curve(m, i) + load
    slide(m, i, 1.0 if w > 0.0 else -1.0)


@compiled(inline=True)
def loops_are_cheap(m, i):
    """Those of few steps."""
    return m.s[at.BY_SERIES + i] > 0.0


@compiled
def on_curve(m, i):
    """f of lane i in steady sliding."""
    b = m.s[at.B + i]
    g = coefficient(m.law, m.cells, int(m.s[at.CELL + i]), abs(b)) - m.s[at.SLOPE + i] * abs(b)
    return g if b > 0.0 else -g


def expand(m):
    """Series of the step between its ends."""
    s = m.s
    if not bristles.has_series(m.law):
        interpolate(s)
        return
    by_series, others = explicit.kinds_of_steps(s)
    if not others:
        return
    if by_series:
        explicit.set_aside(s, OF_SERIES, at.AFTER)
    for n in range(TERMS, at.ORDER + 1):
        for i in range(at.WIDTH):
            s[at.SERIES + n * at.WIDTH + i] = select(s[at.BY_SERIES + i] > 0.0, s[at.SERIES + n * at.WIDTH + i], 0.0)
    interpolate(s)
    if by_series:
        explicit.bring_back(s, OF_SERIES, at.AFTER, 1.0)


def smallest_step(contact):
    """Steps that end at zero may be as short as they like."""
    return TINIEST_STEP


def steady_friction(contact, law, cells, c, w):
    """The curve."""
    return coefficient(law, cells, c, w)


# --- a step -----------------------------------------------------------------------------------------------------------


def try_step(m):
    """A step in every lane, by series or of the size STEP; nothing is committed."""
    step(m.law, m.s, m.rtol)


@by_law("sf:")
def step(law, s, rtol):
    """The same."""
    if not bristles.has_series(law):
        bristles.step_implicitly(law, s, rtol)
        return
    by_series, others = explicit.kinds_of_steps(s)
    if by_series:
        bristles.step_by_series(law, s, rtol)
    if others:
        if by_series:
            explicit.set_aside(s, explicit.OF_STEP, at.AFTER)
        bristles.step_implicitly(law, s, rtol)
        if by_series:
            explicit.bring_back(s, explicit.OF_STEP, at.AFTER, 1.0)


LINKED = (
    laws.shape, laws.weakening_slope, laws.last_weakening, laws.hidden_depth, bristles.has_series,
    bristles.end_earlier, derive, step,
)  # fmt: skip
contacts.register(bristles.LuGre, globals())
