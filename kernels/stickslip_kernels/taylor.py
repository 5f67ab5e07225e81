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

from .bits import select
from .dense import conservative_work, subtract_damper_work
from .exponential import exp, rough_exp2, rough_log2
from .jit import compiled
from .layout import (
    ALLOWED, ALPHA, B, DROP, DW, DW_NEW, FLOOR, G, GOOD, JERK, JERK_NEW, ORDER, RATE, SERIES, SERIES_DW,
    SERIES_WEAK, SLOPE, SMALLEST_STEP, STEP, TAKEN, TAU, TAU_END, W, WEAK, WEAK_NEW, WIDTH, WORK, W_NEW, Y, Y_NEW,
    Y_STAR,
)  # fmt: skip
from .steep import may_hide

LONGEST = 1.0  # step; events inside a step are told from its ends, so it must stay well below half a turn
ERROR_SHARE = 0.1  # of the tolerance that each of the last two coefficients may spend, and the error of a step


def pair_loop(n):
    """The loop that finds the coefficients of orders n and n + 1 (n even) of w', and one higher of w and the weakening.

    A function for each pair: with n a constant the compiler unrolls the products of series and sees every row. Two
    orders at a time, since it is the loads of a product that bound it, and two sums share them.
    """
    w, dw, weak = SERIES + n * WIDTH, SERIES_DW + n * WIDTH, SERIES_WEAK + n * WIDTH

    @compiled(inline=True)
    def loop(s):
        for i in range(WIDTH):
            drag, minus_rate = s[G + i] + s[SLOPE + i], -s[RATE + i]
            w_n, weak_n = s[w + i], s[weak + i]
            y_n = s[w - WIDTH + i] * (-1.0 / n)
            if n == 2:
                y_n += 0.5 * s[ALPHA + i]
            dw_n = y_n - drag * w_n - weak_n
            w_1 = dw_n * (1.0 / (n + 1))
            # Coefficients n and n + 1 of weakening times w', each in two sums so that no addition waits for the last.
            even, odd, even_1, odd_1 = dw_n * s[SERIES_WEAK + i], 0.0, dw_n * s[SERIES_WEAK + WIDTH + i], 0.0
            above = weak_n
            for j in range(0, n, 2):
                f, g = s[SERIES_DW + j * WIDTH + i], s[SERIES_DW + (j + 1) * WIDTH + i]
                p, q = s[weak - j * WIDTH + i], s[weak - (j + 1) * WIDTH + i]
                even += f * p
                odd += g * q
                odd_1 += g * p
                if j > 0:
                    even_1 += f * above
                above = q
            weak_1 = (even + odd) * (minus_rate * (1.0 / (n + 1)))
            dw_1 = w_n * (-1.0 / (n + 1)) - drag * w_1 - weak_1
            s[dw + i], s[dw + WIDTH + i] = dw_n, dw_1
            s[w + WIDTH + i], s[w + 2 * WIDTH + i] = w_1, dw_1 * (1.0 / (n + 2))
            s[weak + WIDTH + i] = weak_1
            if n + 2 < ORDER:
                even_1 += s[SERIES_DW + i] * weak_1
                odd_1 += dw_1 * s[SERIES_WEAK + i]
                s[weak + 2 * WIDTH + i] = (even_1 + odd_1) * (minus_rate * (1.0 / (n + 2)))

    return loop


def pairs_from(n):
    """The loops of order n and above, one after the other."""
    loop = pair_loop(n)
    if n + 2 == ORDER:
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
    for i in range(WIDTH):
        dw, jerk, weak = s[DW + i], s[JERK + i], s[WEAK + i]
        s[SERIES + i], s[SERIES + WIDTH + i], s[SERIES + 2 * WIDTH + i] = s[W + i], dw, 0.5 * jerk
        s[SERIES_DW + i], s[SERIES_DW + WIDTH + i] = dw, jerk
        rate = -s[RATE + i]
        weak_1 = rate * (weak * dw)
        s[SERIES_WEAK + i], s[SERIES_WEAK + WIDTH + i] = weak, weak_1
        s[SERIES_WEAK + 2 * WIDTH + i] = 0.5 * rate * (weak_1 * dw + weak * jerk)
    higher_orders(s)


@compiled(inline=True)
def speed_scale(s, i):
    """What an error of w is measured against: the amplitude about steady sliding; less while w is small."""
    floor = s[FLOOR + i]
    amplitude = max(abs(s[Y + i] - s[Y_STAR + i]), abs(s[W + i] - s[B + i])) + 1e-3 * floor
    return min(amplitude, abs(s[W + i]) + abs(s[DW + i]) + floor)


@compiled
def choose_step(s, rtol):
    """As long a step as the last two coefficients allow, each being within the tolerance.

    After A. Jorba, M. Zou, A software package for the numerical integration of ODEs by means of high-order Taylor
    methods, Experimental Mathematics 14 (2005) 99-117.
    """
    for i in range(WIDTH):
        s[ALLOWED + i] = ERROR_SHARE * rtol * speed_scale(s, i)
        allowed = rough_log2(s[ALLOWED + i])
        last = rough_log2(s[SERIES + ORDER * WIDTH + i])
        before = rough_log2(s[SERIES + (ORDER - 1) * WIDTH + i])
        h = rough_exp2(min((allowed - last) * (1.0 / ORDER), (allowed - before) * (1.0 / (ORDER - 1))))
        h = min(h, LONGEST)
        s[GOOD + i] = select(h >= SMALLEST_STEP, 1.0, 0.0)
        s[TAKEN + i] = min(h, min(s[STEP + i], s[TAU_END + i] - s[TAU + i]))


@compiled
def sum_series(s):
    """w, w' and y at the end of the step, and the friction work over it but for the damper's share.

    Two loops, each small enough for the compiler to unroll its sums, without which it does not see the lanes.
    """
    for i in range(WIDTH):
        h = s[TAKEN + i]
        w, dw = s[SERIES + ORDER * WIDTH + i], 0.0
        for j in range(ORDER):
            dw = dw * h + w
            w = w * h + s[SERIES + (ORDER - 1 - j) * WIDTH + i]
        s[W_NEW + i], s[DW_NEW + i] = w, dw
    for i in range(WIDTH):
        h = s[TAKEN + i]
        once = twice = s[SERIES + ORDER * WIDTH + i]
        for j in range(ORDER):
            n = ORDER - 1 - j
            c = s[SERIES + n * WIDTH + i]
            # Each less its factors 1/(n + 1) and 1/((n + 1)(n + 2)), so that a sum waits for one operation a term.
            once = once * (h * ((n + 1) / (n + 2))) + c
            twice = twice * (h * ((n + 1) / (n + 3))) + c
        rise = h * (s[B + i] + 0.5 * h * s[ALPHA + i] - once)
        s[Y_NEW + i] = s[Y + i] + rise
        s[WORK + i] = conservative_work(s, i, h, rise, s[W_NEW + i], 0.5 * h * h * twice)


@compiled
def judge_step(s):
    """State at the end by the equations themselves; the step is good if the series agrees with them (its
    defect) and hides nothing from them.
    """
    for i in range(WIDTH):
        y, w, drag = s[Y_NEW + i], s[W_NEW + i], s[G + i] + s[SLOPE + i]
        weak = s[DROP + i] * exp(-s[RATE + i] * w)
        dw = y - drag * w - weak
        h, defect = s[TAKEN + i], abs(s[DW_NEW + i] - dw)
        good = (s[GOOD + i] > 0.0) & (defect * h <= (ORDER + 1) * s[ALLOWED + i]) & (not may_hide(s, i, h, w, dw))
        s[WEAK_NEW + i], s[DW_NEW + i] = weak, dw
        s[JERK_NEW + i] = (s[B + i] + h * s[ALPHA + i] - w) - (drag - s[RATE + i] * weak) * dw
        s[GOOD + i], s[STEP + i] = select(good, 1.0, 0.0), select(good, inf, 0.5 * h)


@compiled
def try_step(s, rtol):
    """A step in every lane, as far as the series is good for; nothing is committed."""
    expand(s)
    choose_step(s, rtol)
    sum_series(s)
    subtract_damper_work(s)
    judge_step(s)


@compiled
def restart(s, i):
    """The series itself tells how far the next step of lane i may reach."""
    s[STEP + i] = inf
