"""One step of slip by the Taylor series of the motion, for laws whose weakening is exponential.

With the weakening part x = drop e^(-rate w) of friction, the equations of the frame (`layout.py`) read

    y' = B - w,      w' = y - drag w - x,      x' = -rate x w',      B' = a

so that the coefficients of y, w and x follow from each other, order by order, by products of series and a single
exponential a step (G. Corliss, Y. F. Chang, Solving ordinary differential equations using Taylor series, ACM TOMS 8
(1982) 114-144). A step of order 14 costs no more than one of the Runge-Kutta pair and reaches 3.7 times as far at a
tolerance of 1e-6, 8 times at 1e-9; and its polynomial is the motion itself between the ends.

Loops over the lanes of one flat buffer, as in `lanes.py`; a loop an order, so that the processor overlaps the lanes.
"""

from math import inf

from . import layout as at
from .bits import select, widest_vectors
from .dense import conservative_work, horner, subtract_damper_work
from .exponential import exp, rough_exp2, rough_log2
from .jit import compiled
from .roots import extreme_slope  # noqa: F401 (`stepping.py` asks every stepper for it)
from .steep import may_hide

LONGEST = 1.0  # step; events inside a step are told from its ends, so it must stay well below half a turn
ERROR_SHARE = 0.1  # of the tolerance that each of the last two coefficients may spend, and the error of a step


def pair_loop(n):
    """The loop that finds the coefficients of orders n and n + 1 (n even) of w', and one higher of w and the weakening.

    A function for each pair: with n a constant the compiler unrolls the products of series and sees every row. Two
    orders at a time, since it is the loads of a product that bound it, and two sums share them.
    """
    w, dw, weak = at.SERIES + n * at.WIDTH, at.SERIES_DW + n * at.WIDTH, at.SERIES_WEAK + n * at.WIDTH

    @compiled(inline=True)
    def loop(s):
        widest_vectors()
        for i in range(at.WIDTH):
            drag, minus_rate = s[at.G + i] + s[at.SLOPE + i], -s[at.RATE + i]
            w_n, weak_n = s[w + i], s[weak + i]
            y_n = s[w - at.WIDTH + i] * (-1.0 / n)
            if n == 2:
                y_n += 0.5 * s[at.ALPHA + i]
            dw_n = y_n - drag * w_n - weak_n
            w_1 = dw_n * (1.0 / (n + 1))
            # Coefficients n and n + 1 of weakening times w', each in two sums so that no addition waits for the last.
            even, odd, even_1, odd_1 = dw_n * s[at.SERIES_WEAK + i], 0.0, dw_n * s[at.SERIES_WEAK + at.WIDTH + i], 0.0
            above = weak_n
            for j in range(0, n, 2):
                f, g = s[at.SERIES_DW + j * at.WIDTH + i], s[at.SERIES_DW + (j + 1) * at.WIDTH + i]
                p, q = s[weak - j * at.WIDTH + i], s[weak - (j + 1) * at.WIDTH + i]
                even += f * p
                odd += g * q
                odd_1 += g * p
                if j > 0:
                    even_1 += f * above
                above = q
            weak_1 = (even + odd) * (minus_rate * (1.0 / (n + 1)))
            dw_1 = w_n * (-1.0 / (n + 1)) - drag * w_1 - weak_1
            s[dw + i], s[dw + at.WIDTH + i] = dw_n, dw_1
            s[w + at.WIDTH + i], s[w + 2 * at.WIDTH + i] = w_1, dw_1 * (1.0 / (n + 2))
            s[weak + at.WIDTH + i] = weak_1
            if n + 2 < at.ORDER:
                even_1 += s[at.SERIES_DW + i] * weak_1
                odd_1 += dw_1 * s[at.SERIES_WEAK + i]
                s[weak + 2 * at.WIDTH + i] = (even_1 + odd_1) * (minus_rate * (1.0 / (n + 2)))

    return loop


def pairs_from(n):
    """The loops of order n and above, one after the other."""
    loop = pair_loop(n)
    if n + 2 == at.ORDER:
        return loop
    rest = pairs_from(n + 2)

    @compiled(inline=True)
    def loops(s):
        loop(s)
        rest(s)

    return loops


higher_orders = pairs_from(2)


@compiled
def expand(s):
    """The coefficients of w, w' and the weakening about the present state of every lane."""
    widest_vectors()
    for i in range(at.WIDTH):
        dw, jerk, weak = s[at.DW + i], s[at.JERK + i], s[at.WEAK + i]
        s[at.SERIES + i], s[at.SERIES + at.WIDTH + i], s[at.SERIES + 2 * at.WIDTH + i] = s[at.W + i], dw, 0.5 * jerk
        s[at.SERIES_DW + i], s[at.SERIES_DW + at.WIDTH + i] = dw, jerk
        rate = -s[at.RATE + i]
        weak_1 = rate * (weak * dw)
        s[at.SERIES_WEAK + i], s[at.SERIES_WEAK + at.WIDTH + i] = weak, weak_1
        s[at.SERIES_WEAK + 2 * at.WIDTH + i] = 0.5 * rate * (weak_1 * dw + weak * jerk)
    higher_orders(s)


@compiled(inline=True)
def speed_scale(s, i):
    """What an error of w is measured against: the amplitude about steady sliding; less while w is small."""
    floor = s[at.FLOOR + i]
    amplitude = max(abs(s[at.Y + i] - s[at.Y_STAR + i]), abs(s[at.W + i] - s[at.B + i])) + 1e-3 * floor
    return min(amplitude, abs(s[at.W + i]) + abs(s[at.DW + i]) + floor)


@compiled
def choose_step(s, rtol):
    """As long a step as the last two coefficients allow, each being within the tolerance.

    After A. Jorba, M. Zou, A software package for the numerical integration of ODEs by means of high-order Taylor
    methods, Experimental Mathematics 14 (2005) 99-117.
    """
    widest_vectors()
    for i in range(at.WIDTH):
        s[at.ALLOWED + i] = ERROR_SHARE * rtol * speed_scale(s, i)
        allowed = rough_log2(s[at.ALLOWED + i])
        last = rough_log2(s[at.SERIES + at.ORDER * at.WIDTH + i])
        before = rough_log2(s[at.SERIES + (at.ORDER - 1) * at.WIDTH + i])
        h = rough_exp2(min((allowed - last) * (1.0 / at.ORDER), (allowed - before) * (1.0 / (at.ORDER - 1))))
        h = min(h, LONGEST)
        s[at.GOOD + i] = select(h >= at.SMALLEST_STEP, 1.0, 0.0)
        s[at.TAKEN + i] = min(h, min(s[at.STEP + i], s[at.TAU_END + i] - s[at.TAU + i]))


@compiled
def sum_series(s):
    """w, w' and y at the end of the step, and the friction work over it but for the damper's share.

    Two loops, each small enough for the compiler to unroll its sums, without which it does not see the lanes.
    """
    widest_vectors()
    for i in range(at.WIDTH):
        s[at.W_NEW + i], s[at.DW_NEW + i] = horner(s, i, s[at.TAKEN + i])[:2]
    for i in range(at.WIDTH):
        h = s[at.TAKEN + i]
        once, twice = horner(s, i, h)[4:6]
        rise = h * (s[at.B + i] + 0.5 * h * s[at.ALPHA + i]) - once
        s[at.Y_NEW + i] = s[at.Y + i] + rise
        s[at.WORK + i] = conservative_work(s, i, h, rise, s[at.W_NEW + i], twice)


@compiled
def judge_step(s):
    """State at the end by the equations themselves; the step is good if the series agrees with them (its
    defect) and hides nothing from them.
    """
    widest_vectors()
    for i in range(at.WIDTH):
        y, w, drag = s[at.Y_NEW + i], s[at.W_NEW + i], s[at.G + i] + s[at.SLOPE + i]
        weak = s[at.DROP + i] * exp(-s[at.RATE + i] * w)
        dw = y - drag * w - weak
        h, defect = s[at.TAKEN + i], abs(s[at.DW_NEW + i] - dw)
        good = (
            (s[at.GOOD + i] > 0.0) & (defect * h <= (at.ORDER + 1) * s[at.ALLOWED + i]) & (not may_hide(s, i, h, w, dw))
        )
        s[at.WEAK_NEW + i], s[at.DW_NEW + i] = weak, dw
        s[at.JERK_NEW + i] = (s[at.B + i] + h * s[at.ALPHA + i] - w) - (drag - s[at.RATE + i] * weak) * dw
        s[at.GOOD + i], s[at.STEP + i] = select(good, 1.0, 0.0), select(good, inf, 0.5 * h)


@compiled
def try_step(law, s, rtol):
    """A step in every lane, as far as the series is good for; nothing is committed."""
    widest_vectors()
    expand(s)
    choose_step(s, rtol)
    sum_series(s)
    subtract_damper_work(s)
    judge_step(s)


@compiled
def restart(law, s, i, h):
    """The series itself tells how far the next step of lane i may reach."""
    s[at.STEP + i] = inf


@compiled
def begin_stepping(law, s, i, cells, c):
    """The same for the first step of a slip."""
    s[at.STEP + i] = inf
