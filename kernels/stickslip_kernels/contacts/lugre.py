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
from math import factorial, pi
from typing import NamedTuple

from .. import contacts
from .. import layout as at
from ..dense import interpolate, work_by_ends
from ..drive import SMALLEST_SPEED
from ..events import end_motion, reaches
from ..exponential import exp
from ..intrinsics import select, widest_vectors
from ..jit import compiled
from ..machine import DONE, RUNNING
from ..observers.recurrence import Recurrence
from ..roots import TO_ROUNDING, crossing, extreme_speed
from . import smooth
from .implicit import end_of_step, errors, factorise, judge_steady_sliding, rates, slopes, stages, step_factor
from .stribeck import laws
from .stribeck.friction import coefficient, coefficient_slope


class LuGre(NamedTuple):
    """Tag of this contact."""

    code: int


TAG = LuGre(0)
PREFIX = "lugre_"
LAWS, REGIMES = {f"{PREFIX}{name}": law for name, law in laws.LAWS.items()}, Recurrence

# rows of a lane, in room that steps of other contacts need: sign of w; a1; s_0, s_1 and how fast s_1 falls; the elastic
# part; scales of speeds and of loads
(SIGN, LEVEL_OF_CURVE, S_0, S_1, S_1_RATE, ELASTIC, SPEED_SCALE, LOAD_SCALE) = (
    at.W_2, at.W_3, at.W_4, at.W_5, at.W_6, at.K_2, at.K_3, at.K_4,
)  # fmt: skip
SPENT = 0.3  # of the tolerance that one step may spend
HELD = 30.0  # periods of bristles in a step from which on the slip follows the load
PASSED = 0.1  # tolerances, of the speed: slip back by less has not passed zero
BEYOND, AT_MOST = 1.5, 2.0  # of this: where a step that passes zero is to end, and the most it may be beyond
TINIEST_STEP, NOTHING = 1e-60, 1e-300
CURVED = 4.0  # slip speeds by which w may curve in a step; more is what errors of the load do to stiff bristles
FLOOR = 1e-3  # of the speed scale
SLIDING = 0.1  # by how much bristles that slide may be off the deflection at which they do
SINE = tuple((-1.0) ** n / factorial(2 * n + 1) for n in range(8))  # coefficients of sin(x)/x


# --- the equations ----------------------------------------------------------------------------------------------------


@compiled(inline=True)
def yielding(elastic, q):
    """alpha(q) q and its derivative. elastic : 0 for LuGre."""
    ramp = min(max((q - elastic) / (1.0 - elastic), 0.0), 1.0)
    x = pi * (ramp - 0.5)
    x2 = x * x
    sine, cosine = SINE[7], 15.0 * SINE[7]
    for n in range(6, -1, -1):
        sine, cosine = sine * x2 + SINE[n], cosine * x2 + (2 * n + 1) * SINE[n]
    alpha, slope = 0.5 + 0.5 * x * sine, 0.5 * pi * cosine / (1.0 - elastic)
    plain = elastic == 0.0
    slope = select((ramp > 0.0) & (ramp < 1.0), slope, 0.0)
    return select(plain, q, alpha * q), select(plain, 1.0, alpha + q * slope)


@compiled(inline=True)
def bristles(law, s, i, w, f):
    """z' and its derivatives by w and by f; s_1 and its derivative by w; g and its slope."""
    sign, rate, drop, delta = s[SIGN + i], s[at.RATE + i], s[at.DROP + i], s[at.EXPONENT + i]
    over = max(rate * sign * w, 0.0)
    weakening = drop * laws.shape(law, over, delta)
    g = s[LEVEL_OF_CURVE + i] + weakening
    per_g = 1.0 / g
    g_slope = laws.weakening_slope(law, over, weakening, drop, delta) * rate
    q = sign * f * per_g
    yields, yields_slope = yielding(s[ELASTIC + i], q)
    fade = s[S_1_RATE + i] * w
    s_1 = s[S_1 + i] * exp(-fade * fade)
    by_w = 1.0 - yields + sign * w * yields_slope * q * g_slope * per_g
    s_1_slope = -2.0 * fade * s[S_1_RATE + i] * s_1
    return w * (1.0 - yields), by_w, -sign * w * yields_slope * per_g, s_1, s_1_slope, g, g_slope


@rates.of(LuGre)
def _rates(kind, s, i, y, w, f):
    give, _, _, s_1, _, _, _ = bristles(kind[1], s, i, w, f)
    return w, y - (s[at.G + i] + s[at.SLOPE + i]) * w - f - s_1 * give, s[S_0 + i] * give


@slopes.of(LuGre)
def _slopes(kind, s, i, y, w, f):
    give, by_w, by_f, s_1, s_1_slope, _, _ = bristles(kind[1], s, i, w, f)
    damping = s[at.G + i] + s[at.SLOPE + i] + s_1 * by_w + s_1_slope * give
    return 1.0, 1.0, -damping, -1.0 - s_1 * by_f, s[S_0 + i] * by_w, s[S_0 + i] * by_f


@compiled(inline=True)
def derivatives(law, s, i, t, h, y, w, f):
    """w' and w'' at t after the start of a step of length h.

    Where bristles hold w back, w' is the small difference of large forces, and what the step leaves of an error in them
    would be all of it. There slip follows the load, f' = y', so that w = B/(1 + s_0 (1 - q)). Where they follow the
    slip at once, f is g, and the same holds of w''.
    """
    sign, s_0, drag = s[SIGN + i], s[S_0 + i], s[at.G + i] + s[at.SLOPE + i]
    give, by_w, by_f, s_1, s_1_slope, g, g_slope = bristles(law, s, i, w, f)
    damping, firm, drive = drag + s_1 * by_w + s_1_slope * give, s_0 * by_w, s[at.B + i] + t * s[at.ALPHA + i]
    follows = abs(w * (1.0 + firm) - drive) < 0.5 * abs(drive) + FLOOR * s[SPEED_SCALE + i]
    held = follows & (h * h * firm > HELD * HELD) & (h * firm > HELD * abs(damping))
    dw = y - drag * w - f - s_1 * give
    bend = drive - w - damping * dw - (1.0 + s_1 * by_f) * s_0 * give
    slow = (s[at.ALPHA + i] - s_0 * by_f * s_0 * give) / (1.0 + firm)
    rate = s_0 * abs(w) / g
    slides = (rate * h > HELD) & (abs(1.0 - sign * f / g) < SLIDING)
    sliding = (y - drag * w - sign * g) / (1.0 + g_slope * (s_1 / s_0 - 1.0 / rate))
    dw = select(held, slow, select(slides, sliding, dw))
    bend = select(slides, drive - w - (drag + g_slope) * dw, bend)
    return dw, select(held, 2.0 * slow * slow * w / (w * w + NOTHING), bend)


# --- cells ------------------------------------------------------------------------------------------------------------


@compiled
def begin_cell(m, i, c):
    """Put cell c into lane i, its bristles relaxed; DONE if it cannot be computed."""
    s, cells, b = m.s, m.cells, abs(m.cells[at.BELT, c])
    if smooth.open_cell(m, i, c) == DONE:
        return DONE
    s[at.SLOPE + i], s[at.DROP + i], s[at.RATE + i] = cells[at.A2, c], cells[at.A3, c], 1.0 / cells[at.A4, c]
    s[at.EXPONENT + i], s[LEVEL_OF_CURVE + i] = cells[at.DELTA, c], cells[at.A1, c]
    s[S_0 + i], s[S_1 + i] = cells[at.CONTACT_STIFFNESS, c], cells[at.CONTACT_DAMPING, c]
    s[S_1_RATE + i] = cells[at.CONTACT_DAMPING_RATE, c]
    s[ELASTIC + i] = cells[at.ELASTIC_PART, c]
    s[LOAD_SCALE + i] = cells[at.A1, c] + max(cells[at.A3, c], 0.0)
    fastest = (s[at.FLOOR + i] - SMALLEST_SPEED) * 1e3  # of the belt
    s[SPEED_SCALE + i] = fastest if fastest > 0.0 else s[LOAD_SCALE + i] / s[S_0 + i] ** 0.5
    s[at.STEP + i] = 1e-3 / (1.0 + s[S_0 + i] ** 0.5 + s[S_1 + i])
    s[at.WEAK + i], s[SIGN + i] = 0.0, 1.0
    if b > 0.0:
        judge(m, i, c, b)
    derive(m, i)
    sign = s[at.W + i] if s[at.W + i] != 0.0 else s[at.DW + i] if s[at.DW + i] != 0.0 else s[at.JERK + i]
    slide(m, i, -1.0 if sign < 0.0 else 1.0)
    derive(m, i)
    return RUNNING


@compiled
def judge(m, i, c, b):
    """What linear theory says of steady sliding at the belt speed b."""
    s, cells = m.s, m.cells
    g, slope = coefficient(m.law, cells, c, b) - cells[at.A2, c] * b, coefficient_slope(m.law, cells, c, b)
    s_1 = s[S_1 + i] * exp_of(-((s[S_1_RATE + i] * b) ** 2))
    drag = s[at.G + i] + cells[at.A2, c]
    judge_steady_sliding(s, i, drag + s_1 * b * (slope - cells[at.A2, c]) / g, s[at.G + i] + slope, b * s[S_0 + i] / g)


@compiled(inline=True)
def slide(m, i, sign):
    """Let lane i hold on to this sign of w, until w is beyond zero by more than steps leave of it."""
    passed = PASSED * m.s[SPEED_SCALE + i] * min(m.rtol, 1.0 / (1.0 + m.s[S_0 + i]))
    m.s[SIGN + i], m.s[at.SIDE + i], m.s[at.LEVEL + i] = sign, -sign, -sign * passed


@compiled(inline=True)
def derive(m, i):
    """w' and w'' of lane i at its present state."""
    s = m.s
    w = s[at.W + i]
    s[at.DW + i], s[at.JERK + i] = derivatives(m.law, s, i, 0.0, s[at.STEP + i], s[at.Y + i], w, s[at.WEAK + i])


@compiled
def handle_event(m, i):
    """Look at lane i, whose step was flagged: one that passes zero is tried again, to end there."""
    s = m.s
    turns = False
    if s[at.FLAG + i] != at.HALTED:
        turns = reaches(s, i, s[at.W_NEW + i])
        t = time_to_zero(s, i)
        if t > 0.0:
            s[at.STEP + i] = t
            return RUNNING
    if smooth.commit(m, i) == DONE:
        return DONE
    if turns:
        slide(m, i, -s[SIGN + i])
    derive(m, i)
    return RUNNING


@compiled
def time_to_zero(s, i):
    """When, within the step of lane i, w is as far beyond zero as a step is to end; 0 where it does, or never is."""
    h, side, level, at_end = s[at.TAKEN + i], s[at.SIDE + i], s[at.LEVEL + i], end_motion(s, i)
    if reaches(s, i, at_end[0]):
        if side * at_end[0] <= AT_MOST * side * level:
            return 0.0
        return crossing(s, i, 0, BEYOND * level, h, at_end, TO_ROUNDING)
    if side * s[at.DW + i] > 0.0 and side * at_end[1] < 0.0:
        t, w = extreme_speed(s, i, h, at_end, TO_ROUNDING)
        if side * w > AT_MOST * side * level:
            return crossing(s, i, 0, BEYOND * level, t, (w, 0.0, 0.0, 0.0), TO_ROUNDING)
    return 0.0


@compiled
def deviation(m, i):
    """Of w over b and over the scale of the curve, and of the deflection."""
    s = m.s
    b, c = s[at.B + i], int(s[at.CELL + i])
    sign, over = 1.0 if b > 0.0 else -1.0, abs(s[at.W + i] - b)
    g = coefficient(m.law, m.cells, c, abs(b)) - s[at.SLOPE + i] * abs(b)
    return max(over / abs(b), over * s[at.RATE + i], abs(sign * s[at.WEAK + i] / g - 1.0))


def expand(m):
    """Series of the step between its ends."""
    interpolate(m.s)


def smallest_step(contact):
    """Steps that end at zero may be as short as they like."""
    return TINIEST_STEP


def steady_friction(contact, law, cells, c, w):
    """The curve."""
    return coefficient(law, cells, c, w)


# --- a step -----------------------------------------------------------------------------------------------------------


@compiled
def try_step(m):
    """A step of the size STEP in every lane; nothing is committed."""
    kind = (m.contact, m.law)
    factorise(kind, m.s)
    stages(kind, m.s)
    control_step(m.law, m.s, m.rtol)


@compiled
def control_step(law, s, rtol):
    """End of the step, its error, and the size of the next."""
    widest_vectors()
    tolerance2 = 1.0 / (SPENT * rtol) ** 2
    for i in range(at.WIDTH):
        (y, w, f), (e_y, e_w, e_f) = end_of_step(s, i), errors(s, i)
        per_load, per_speed = 1.0 / s[LOAD_SCALE + i], 1.0 / max(abs(w), s[SPEED_SCALE + i])
        e_y, e_w, e_f = e_y * per_load, e_w * per_speed, e_f * per_load
        error2 = (e_y * e_y + e_w * e_w + e_f * e_f) * tolerance2
        h = s[at.TAKEN + i]
        s[at.Y_NEW + i], s[at.W_NEW + i], s[at.WEAK_NEW + i] = y, w, f
        s[at.DW_NEW + i], s[at.JERK_NEW + i] = derivatives(law, s, i, h, h, y, w, f)
        most = CURVED / (h * h * per_speed)
        s[at.JERK + i] = min(max(s[at.JERK + i], -most), most)
        s[at.JERK_NEW + i] = min(max(s[at.JERK_NEW + i], -most), most)
        leaps = leaps_over_breakaway(s, i, h, f) | passes_friction(law, s, i, h)
        s[at.GOOD + i] = select((error2 <= 1.0) & (not leaps), 1.0, 0.0)
        s[at.STEP + i] = select(leaps, 0.5, step_factor(error2)) * s[at.STEP + i]
        s[at.WORK + i] = work_by_ends(s, i, h)


@compiled(inline=True)
def leaps_over_breakaway(s, i, h, f):
    """Return whether a long step brings bristles that hold the slip back closer to giving way than half way.

    Beyond, equations with the sign of w held on to have a motion backwards under any load, and nothing in a step that
    ends there tells.
    """
    sign, per_g = s[SIGN + i], 1.0 / (s[LEVEL_OF_CURVE + i] + s[at.DROP + i])
    room = 1.0 - sign * s[at.WEAK + i] * per_g
    return (h * h * s[S_0 + i] * room > HELD * HELD) & (sign * (f - s[at.WEAK + i]) * per_g > 0.5 * room)


@compiled(inline=True)
def passes_friction(law, s, i, h):
    """Return whether a step may have passed over friction unseen."""
    rate = s[SIGN + i] * s[at.RATE + i]
    z, z_end, rise = rate * s[at.W + i], rate * s[at.W_NEW + i], h * rate
    return laws.passes_unseen(law, z, z_end, rise * s[at.DW + i], rise * s[at.DW_NEW + i])


contacts.register(LuGre, globals())
