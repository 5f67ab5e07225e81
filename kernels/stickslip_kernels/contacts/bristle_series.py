"""Bristles by the Taylor series of their motion, where they follow the slip at rates that explicit steps can do with.

Soft bristles swing, and nothing in their motion is much faster than that: a series of order 14 passes a turn in a few
steps, where an implicit method of order 5 takes dozens. With r = f/g and p = w (1 - sgn(w) r), products and a quotient
of series (`lugre.py` has the equations),

    y' = B - w,      w' = y - (gamma + a2) w - f - s_1 p,      f' = s_0 p,

and x, the weakening part of g, from w by the recurrence of its law (`stribeck/recurrences.py`). The sign of w is held
on to in a step: rows RATE have it.
"""

from math import inf, nan

from .. import layout as at
from ..dense import rise_and_work, subtract_damper_work
from ..intrinsics import select, widest_vectors
from ..jit import compiled, in_turn
from ..linking import by_law
from .explicit import ALLOWED_STATE, CAP, STATE, agrees, choose_step, may_turn_twice, state_after
from .stribeck.laws import RECURRENCES, shape, steps_over, weakening_slope
from .stribeck.resolvable import may_bend_twice, may_hide
from .stribeck.taylor import rows_of, sum_series

# rows of a lane, beside those of `explicit.py`: sign of w, a1, s_0, s_1; scales of speeds and of loads; one over g;
# steps since w' last vanished; of the series of f/g the first
SIGN, LEVEL_OF_CURVE, S_0, S_1, SPEED_SCALE, LOAD_SCALE = at.W_2, at.W_3, at.W_4, at.W_5, at.K_3, at.K_4
PER_LEVEL, QUIET = at.ERROR_Y, at.GAIN
SHARE = at.SERIES_SHARE
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


def order_loop(recurrence):
    """The function that gives, for an order n, the loop that finds coefficients n + 1 from those before."""
    f, g, keeps_f, keeps_g = rows_of(recurrence)
    scale, begin = recurrence.scale, recurrence.begin

    def loop_of(n):
        up, here = (n + 1) * at.WIDTH, n * at.WIDTH
        next_f, next_g, first, last = recurrence.next_f(n), recurrence.next_g(n), n == 0, n == at.ORDER - 1

        @compiled(inline=True)
        def loop(law, s):
            widest_vectors()
            for i in range(at.WIDTH):
                w_n, f_n, x_n = s[at.SERIES + here + i], s[STATE + here + i], s[at.SERIES_WEAK + here + i]
                if first:
                    begin(s, i)
                    y_n = s[at.Y + i]
                elif n == 1:
                    y_n = s[at.B + i] - s[at.SERIES + i]
                else:
                    y_n = s[at.SERIES + here - at.WIDTH + i] * (-1.0 / n)
                    if n == 2:
                        y_n += 0.5 * s[at.ALPHA + i]
                if keeps_g:
                    s[g + here + i] = next_g(s, i, x_n, w_n)
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
                if not last:
                    new_f = next_f(s, i, dw_n, w_1)
                    if keeps_f:
                        s[f + here + i] = new_f
                    total = 0.0
                    for j in range(n + 1):
                        total += s[f + j * at.WIDTH + i] * s[g + here - j * at.WIDTH + i]
                    s[at.SERIES_WEAK + up + i] = total * scale(s, i, 1.0 / (n + 1))

        return loop

    return loop_of


def expansion(recurrence):
    """The function that finds all coefficients of laws of this recurrence."""
    loops = in_turn(order_loop(recurrence), 0, at.ORDER)
    return lambda law, s: loops(law, s)


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
def try_step(law, s, rtol):
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
    s[at.TOP + i], s[at.TOP_TIME + i] = nan, nan  # extremes (`observers/peaks.py`) that may lie beyond
    s[at.Y_NEW + i], s[at.W_NEW + i], s[at.WEAK_NEW + i] = y, w, f
    s[at.DW_NEW + i], s[at.JERK_NEW + i], _ = motion(law, s, i, t, y, w, f)
