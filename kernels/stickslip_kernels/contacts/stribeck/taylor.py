"""One step of slip by the Taylor series of the motion, for laws whose weakening has a recurrence.

With the weakening part x of friction, the equations of the frame (`layout.py`) read

    y' = B - w,      w' = y - drag w - x,      B' = a

and x is tied to w by products of series: x' = -rate x w' where it is exponential, x (1 + rate w) = drop where it is
rational (`recurrences.py`). So the coefficients of y, w and x follow from each other, order by order, and a step needs
one value of x, at its end (G. Corliss, Y. F. Chang, Solving ordinary differential equations using Taylor series, ACM
TOMS 8 (1982) 114-144). A step of order 14 costs about as much as one of the Runge-Kutta pair and reaches 4 times as far
at a tolerance of 1e-6, 8 to 12 times at 1e-9; and its polynomial is the motion itself between the ends.

Loops over the lanes of one flat buffer, as in `lanes.py`; a loop two orders, so that the processor overlaps the lanes.
"""

from math import inf

from ... import layout as at
from ...arithmetic import in_turn, rough_exp2, rough_log2, select, widest_vectors
from ...dense import conservative_work, horner, subtract_damper_work
from ...jit import compiled
from ...linking import by_law
from .equations import may_bend_twice, may_hide
from .laws import RECURRENCES, bends, shape, steps_over, weakening_slope

LONGEST = 1.0  # step; events inside a step are told from its ends, so it must stay well below half a turn
ERROR_SHARE = 0.1  # of the tolerance that each of the last two coefficients may spend, and the error of a step
PAIRS = at.ORDER // 2


def expansion(recurrence):
    """The function that finds all coefficients of laws of this recurrence."""
    f, g, keeps_f, keeps_g = rows_of(recurrence)
    scale, begin, next_f, next_g = recurrence.scale, recurrence.begin, recurrence.next_f, recurrence.next_g

    @compiled(inline=True)
    def begin_series(s):
        """What the state tells: coefficients 0 to 2 of w and of the weakening, 0 and 1 of w'."""
        for i in range(at.WIDTH):
            w, dw, jerk, weak = s[at.W + i], s[at.DW + i], s[at.JERK + i], s[at.WEAK + i]
            s[at.SERIES + i], s[at.SERIES + at.WIDTH + i], s[at.SERIES + 2 * at.WIDTH + i] = w, dw, 0.5 * jerk
            s[at.SERIES_DW + i], s[at.SERIES_DW + at.WIDTH + i] = dw, jerk
            s[at.SERIES_WEAK + i] = weak
            begin(s, i)
            first_f, first_g = next_f(s, i, 0, dw, dw), next_g(s, i, 0, weak, w)
            if keeps_f:
                s[f + i] = first_f
            if keeps_g:
                s[g + i] = first_g
            weak_1 = first_f * first_g * scale(s, i, 1.0)
            second_f, second_g = next_f(s, i, 1, jerk, 0.5 * jerk), next_g(s, i, 1, weak_1, dw)
            weak_2 = (first_f * second_g + second_f * first_g) * scale(s, i, 0.5)
            s[at.SERIES_WEAK + at.WIDTH + i], s[at.SERIES_WEAK + 2 * at.WIDTH + i] = weak_1, weak_2
            if keeps_f:
                s[f + at.WIDTH + i] = second_f
            if keeps_g:
                s[g + at.WIDTH + i] = second_g
                s[g + 2 * at.WIDTH + i] = next_g(s, i, 2, weak_2, 0.5 * jerk)

    @compiled(inline=True)
    def find_pair(law, s, pair):
        """The coefficients of orders n = 2 pair and n + 1 of w', and one higher of w and the weakening.

        Merged for each pair (`in_turn`): with n a constant the compiler unrolls the products of series and sees every
        row. Two orders at a time, since it is the loads of a product that bound it, and two sums share them.
        """
        widest_vectors()
        n = 2 * pair
        here, last = n * at.WIDTH, n + 2 == at.ORDER
        w, dw, weak = at.SERIES + here, at.SERIES_DW + here, at.SERIES_WEAK + here
        for i in range(at.WIDTH):
            drag = s[at.G + i] + s[at.SLOPE + i]
            w_n, weak_n = s[w + i], s[weak + i]
            y_n = s[w - at.WIDTH + i] * (-1.0 / n)
            if n == 2:
                y_n += 0.5 * s[at.ALPHA + i]
            dw_n = y_n - drag * w_n - weak_n
            w_1 = dw_n * (1.0 / (n + 1))
            new_f = next_f(s, i, n, dw_n, w_1)
            # Coefficients n and n + 1 of the product, each in two sums so that no addition waits for the last.
            even, odd, even_1, odd_1 = new_f * s[g + i], 0.0, new_f * s[g + at.WIDTH + i], 0.0
            above = s[g + here + i]
            for j in range(0, n, 2):
                f_even, f_odd = s[f + j * at.WIDTH + i], s[f + (j + 1) * at.WIDTH + i]
                g_even, g_odd = s[g + here - j * at.WIDTH + i], s[g + here - (j + 1) * at.WIDTH + i]
                even += f_even * g_even
                odd += f_odd * g_odd
                odd_1 += f_odd * g_even
                if j > 0:
                    even_1 += f_even * above
                above = g_odd
            weak_1 = (even + odd) * scale(s, i, 1.0 / (n + 1))
            dw_1 = w_n * (-1.0 / (n + 1)) - drag * w_1 - weak_1
            w_2 = dw_1 * (1.0 / (n + 2))
            s[dw + i], s[dw + at.WIDTH + i] = dw_n, dw_1
            s[w + at.WIDTH + i], s[w + 2 * at.WIDTH + i] = w_1, w_2
            s[weak + at.WIDTH + i] = weak_1
            if not last:
                above_f, above_g = next_f(s, i, n + 1, dw_1, w_2), next_g(s, i, n + 1, weak_1, w_1)
                even_1 += s[f + i] * above_g
                odd_1 += above_f * s[g + i]
                weak_2 = (even_1 + odd_1) * scale(s, i, 1.0 / (n + 2))
                s[weak + 2 * at.WIDTH + i] = weak_2
                if keeps_f:
                    s[f + here + i], s[f + here + at.WIDTH + i] = new_f, above_f
                if keeps_g:
                    s[g + here + at.WIDTH + i] = above_g
                    s[g + here + 2 * at.WIDTH + i] = next_g(s, i, n + 2, weak_2, w_2)

    def find(law, s):
        begin_series(s)
        in_turn(find_pair, law, s, 1, PAIRS)

    return find


def rows_of(recurrence):
    """First rows of both factors, and which of them, if any, the recurrence keeps."""
    f, g = recurrence.f, recurrence.g
    return f, g, f == at.SERIES_FACTOR, g == at.SERIES_FACTOR


@by_law(inline=True)
def find_coefficients(law, s):
    """The coefficients of w, w' and the weakening about the present state of every lane."""
    raise NotImplementedError


for _tag, _recurrence in RECURRENCES.items():
    find_coefficients.of(_tag)(expansion(_recurrence))


@compiled
def expand(law, s):
    """The coefficients of w, w' and the weakening about the present state of every lane."""
    widest_vectors()
    find_coefficients(law, s)


@compiled(inline=True)
def speed_scale(s, i):
    """Return what an error of w is measured against: the amplitude about steady sliding; less while w is small."""
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
        h = min(h, s[at.LONGEST + i])
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
def judge_step(law, s):
    """State at the end by the equations themselves; the step is good if the series agrees with them (its
    defect) and hides nothing from them.
    """
    widest_vectors()
    for i in range(at.WIDTH):
        y, w, drag = s[at.Y_NEW + i], s[at.W_NEW + i], s[at.G + i] + s[at.SLOPE + i]
        rate, drop, delta = s[at.RATE + i], s[at.DROP + i], s[at.EXPONENT + i]
        weak = drop * shape(law, rate * w, delta)
        dw = y - drag * w - weak
        h, defect = s[at.TAKEN + i], abs(s[at.DW_NEW + i] - dw)
        slope = drag + rate * weakening_slope(law, rate * w, weak, drop, delta)
        jerk = (s[at.B + i] + h * s[at.ALPHA + i] - w) - slope * dw
        agrees = defect * h <= (at.ORDER + 1) * s[at.ALLOWED + i]
        hides = may_hide(s, i, h, w, dw)
        hides = hides | steps_over(law, rate * s[at.W + i], rate * w, rate * h * s[at.DW + i], rate * h * dw)
        hides = hides | (bends(law) & may_bend_twice(s, i, h, dw, jerk))
        good = (s[at.GOOD + i] > 0.0) & agrees & (not hides)
        s[at.WEAK_NEW + i], s[at.DW_NEW + i], s[at.JERK_NEW + i] = weak, dw, jerk
        s[at.GOOD + i], s[at.STEP + i] = select(good, 1.0, 0.0), select(good, inf, 0.5 * h)


@compiled
def try_step(law, s, rtol):
    """A step in every lane, as far as the series is good for; nothing is committed."""
    widest_vectors()
    expand(law, s)
    choose_step(s, rtol)
    sum_series(s)
    subtract_damper_work(s)
    judge_step(law, s)


@compiled
def restart(law, s, i, h):
    """The series itself tells how far the next step of lane i may reach."""
    s[at.STEP + i] = inf


@compiled
def begin_stepping(law, s, i, cells, c):
    """The same for the first step of a slip."""
    s[at.STEP + i], s[at.LONGEST + i] = inf, LONGEST
