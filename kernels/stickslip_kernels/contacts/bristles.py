"""Bristles by the Taylor series of their motion, where they follow the slip at rates that explicit steps can do with.

Soft bristles swing, and nothing in their motion is much faster than that: a series of order 14 passes a turn in a few
steps, where an implicit method of order 5 takes dozens. With r = f/g and p = w (1 - sgn(w) r), products and a quotient
of series (`lugre.py` has the equations),

    y' = B - w,      w' = y - (gamma + a2) w - f - s_1 p,      f' = s_0 p,

and x, the weakening part of g, from w by the recurrence of its law (`stribeck/recurrences.py`). The sign of w is held
on to in a step: rows RATE have it.
"""

from math import factorial, inf, pi
from typing import NamedTuple

from .. import layout as at
from ..arithmetic import exp, in_turn, select, widest_vectors
from ..dense import rise_and_work, subtract_damper_work, work_by_ends
from ..jit import compiled
from ..linking import by_law
from . import explicit
from .explicit import ALLOWED_STATE, CAP, STATE, agrees, choose_step, may_turn_twice, state_after
from .implicit import end_of_step, errors, factorise, rates, slopes, stages, step_factor
from .stribeck import laws
from .stribeck.equations import may_bend_twice, may_hide
from .stribeck.laws import RECURRENCES, shape, steps_over, weakening_slope
from .stribeck.taylor import rows_of, sum_series

# rows of a lane, beside those of `explicit.py`: sign of w, a1, s_0, s_1; scales of speeds and of loads; one over g;
# steps since w' last vanished; of the series of f/g the first
ROWS = explicit.ROWS.beside()
SIGN, LEVEL_OF_CURVE, S_0, S_1, SPEED_SCALE, LOAD_SCALE, PER_LEVEL, QUIET = ROWS.take(8)
SHARE = at.SERIES_SHARE
ORDER = at.ORDER
ERROR_SHARE = 0.01  # of the tolerance that each of the last coefficients may spend, and the error of a step


@by_law(":b", inline=True)
def has_series(law):
    """Return whether the law has a recurrence."""
    return False


@by_law(inline=True)
def find_coefficients(law, s):
    """The coefficients of w, f and the rest about the present state of every lane."""


@compiled
def begin_series(law, s, rtol):
    """Coefficients 0, and what errors may be."""
    widest_vectors()
    for i in range(at.WIDTH):
        w = s[at.W + i]
        x = s[at.DROP + i] * shape(law, s[at.RATE + i] * w, s[at.EXPONENT + i])
        s[at.SERIES + i], s[at.SERIES_WEAK + i], s[STATE + i] = w, x, s[at.WEAK + i]
        s[PER_LEVEL + i] = 1.0 / (s[LEVEL_OF_CURVE + i] + x)
        s[at.ALLOWED + i] = ERROR_SHARE * rtol * max(abs(w), s[SPEED_SCALE + i])
        s[ALLOWED_STATE + i] = ERROR_SHARE * rtol * s[LOAD_SCALE + i]


def expansion(recurrence):
    """The function that finds all coefficients of laws of this recurrence."""
    f, g, keeps_f, keeps_g = rows_of(recurrence)
    scale, begin, next_f, next_g = recurrence.scale, recurrence.begin, recurrence.next_f, recurrence.next_g

    @compiled(inline=True)
    def find_order(law, s, n):
        """Coefficients n + 1 from those before."""
        widest_vectors()
        up, here = (n + 1) * at.WIDTH, n * at.WIDTH
        for i in range(at.WIDTH):
            w_n, f_n, x_n = s[at.SERIES + here + i], s[STATE + here + i], s[at.SERIES_WEAK + here + i]
            if n == 0:
                begin(s, i)
                y_n = s[at.Y + i]
            elif n == 1:
                y_n = s[at.B + i] - s[at.SERIES + i]
            else:
                y_n = s[at.SERIES + here - at.WIDTH + i] * (-1.0 / n)
                if n == 2:
                    y_n += 0.5 * s[at.ALPHA + i]
            if keeps_g:
                s[g + here + i] = next_g(s, i, n, x_n, w_n)
            r_n, share = f_n, 0.0
            for j in range(1, n + 1):
                r = s[SHARE + here - j * at.WIDTH + i]
                r_n -= s[at.SERIES_WEAK + j * at.WIDTH + i] * r
                share += s[at.SERIES + j * at.WIDTH + i] * r
            r_n *= s[PER_LEVEL + i]
            s[SHARE + here + i] = r_n
            p_n = w_n - s[SIGN + i] * (share + s[at.SERIES + i] * r_n)
            dw_n = y_n - (s[at.G + i] + s[at.SLOPE + i]) * w_n - f_n - s[S_1 + i] * p_n
            w_1 = dw_n * (1.0 / (n + 1))
            s[at.SERIES_DW + here + i], s[at.SERIES + up + i] = dw_n, w_1
            s[STATE + up + i] = s[S_0 + i] * p_n * (1.0 / (n + 1))
            if n < at.ORDER - 1:
                new_f = next_f(s, i, n, dw_n, w_1)
                if keeps_f:
                    s[f + here + i] = new_f
                total = 0.0
                for j in range(n + 1):
                    total += s[f + j * at.WIDTH + i] * s[g + here - j * at.WIDTH + i]
                s[at.SERIES_WEAK + up + i] = total * scale(s, i, 1.0 / (n + 1))

    return lambda law, s: in_turn(find_order, law, s, 0, ORDER)


for _tag, _recurrence in RECURRENCES.items():
    has_series.of(_tag)(lambda law: True)
    find_coefficients.of(_tag)(expansion(_recurrence))


@compiled(inline=True)
def motion(law, s, i, t, y, w, f):
    """w', w'' and f' at t after the start of the step, by the equations."""
    sign, s_0, s_1, drag = s[SIGN + i], s[S_0 + i], s[S_1 + i], s[at.G + i] + s[at.SLOPE + i]
    rate, drop, delta = s[at.RATE + i], s[at.DROP + i], s[at.EXPONENT + i]
    x = drop * shape(law, rate * w, delta)
    per_g = 1.0 / (s[LEVEL_OF_CURVE + i] + x)
    share = sign * f * per_g
    give = w * (1.0 - share)
    dw = y - drag * w - f - s_1 * give
    df = s_0 * give
    dx = weakening_slope(law, rate * w, x, drop, delta) * rate * dw
    give_slope = dw * (1.0 - share) - w * (sign * df - share * dx) * per_g
    jerk = s[at.B + i] + t * s[at.ALPHA + i] - w - drag * dw - df - s_1 * give_slope
    return dw, jerk, df


@compiled
def end_step(law, s):
    """The state at the end, by the equations themselves; the step is good if its series agree with them."""
    widest_vectors()
    for i in range(at.WIDTH):
        h, y, w = s[at.TAKEN + i], s[at.Y_NEW + i], s[at.W_NEW + i]
        f, slope = state_after(s, i, h)
        dw, jerk, df = motion(law, s, i, h, y, w, f)
        rate, rise = s[at.RATE + i], s[at.RATE + i] * h
        hides = may_hide(s, i, h, w, dw, s[SIGN + i])
        hides = hides | steps_over(law, rate * s[at.W + i], rate * w, rise * s[at.DW + i], rise * dw)
        hides = hides | may_bend_twice(s, i, h, dw, jerk) | may_turn_twice(s, i, h, dw, jerk)
        good = (s[at.GOOD + i] > 0.0) & agrees(s, i, h, dw, df, slope) & (not hides)
        s[at.WEAK_NEW + i], s[at.DW_NEW + i], s[at.JERK_NEW + i] = f, dw, jerk
        s[at.GOOD + i] = select(good, 1.0, 0.0)
        s[CAP + i] = select(good, inf, 0.5 * h)
        s[QUIET + i] = select(s[at.DW + i] * dw < 0.0, 0.0, s[QUIET + i] + 1.0)


@compiled
def step_by_series(law, s, rtol):
    """A step in every lane, as far as the series are good for; nothing is committed."""
    begin_series(law, s, rtol)
    find_coefficients(law, s)
    choose_step(s)
    sum_series(s)
    subtract_damper_work(s)
    end_step(law, s)


@by_law("sif:")
def end_earlier(law, s, i, t):
    """End the step of lane i at t after its start, where its series are as good."""
    w, rise, work = rise_and_work(s, i, t)
    y, f = s[at.Y + i] + rise, state_after(s, i, t)[0]
    s[at.TAKEN + i], s[at.WORK + i] = t, work
    s[at.SOUGHT + i] = 0.0  # the extreme may lie beyond
    s[at.Y_NEW + i], s[at.W_NEW + i], s[at.WEAK_NEW + i] = y, w, f
    s[at.DW_NEW + i], s[at.JERK_NEW + i], _ = motion(law, s, i, t, y, w, f)


# --- by linearly implicit steps (`implicit.py`): any law, stiff bristles, elasto-plastic ones, fading damping ---------


class LuGre(NamedTuple):
    """Tag of contacts of bristles."""

    code: int


# rows of a lane, beside those above: how fast s_1 falls; the elastic part
S_1_RATE, ELASTIC = ROWS.take(2)
SPENT = 0.3  # of the tolerance that one step may spend
HELD = 30.0  # periods of bristles in a step from which on the slip follows the load
NOTHING = 1e-300
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
    over = max(rate * w, 0.0)
    weakening = drop * laws.shape(law, over, delta)
    g = s[LEVEL_OF_CURVE + i] + weakening
    per_g = 1.0 / g
    g_slope = laws.weakening_slope(law, over, weakening, drop, delta) * rate * sign
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


# --- a step -----------------------------------------------------------------------------------------------------------


@compiled(inline=True)
def step_implicitly(law, s, rtol):
    """A step of the size STEP in every lane; nothing is committed."""
    kind = (LuGre(0), law)
    factorise(kind, s)
    stages(kind, s)
    control_step(law, s, rtol)


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
    rate = s[at.RATE + i]
    z, z_end, rise = rate * s[at.W + i], rate * s[at.W_NEW + i], h * rate
    return laws.passes_unseen(law, z, z_end, rise * s[at.DW + i], rise * s[at.DW_NEW + i])
