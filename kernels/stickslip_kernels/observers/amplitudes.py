"""The amplitude map: a slip that rings down to steady sliding, taken there without following every turn.

About steady sliding a slip that neither sticks nor leaves its curve is a flow in the plane (p, q), and where it turns,
q = 0, the signed amplitude p = a is the whole state. Half a loop takes it to

    a' = -a e^c(a)      after a time T(a),

with c and T analytic through a = 0, where they are those of the linear oscillator. Spirals of a plane do not cross: all
turns to come lie between the last two, a_0 and a_1. So c and T are interpolated there (Newton's form), from half loops
that begin at points of a Leja sequence, in which each new one shows by how much those before were wrong. Once that is
within the tolerance the map is iterated to the turn before the settling band, and the motion goes on from there. Where
it does not come within the tolerance, or the map has a fixed point on the way, the motion goes on from where it was.

L. Reichel, Newton interpolation at Leja points, BIT 30 (1990) 332-346.
"""

from math import floor, inf, log, nan, pi

from .. import layout as at
from ..exponential import exp
from ..jit import compiled
from ..roots import arrival
from .cycles import forget_loops
from .margin import note_closest_trough
from .settling import drag_at
from .verdict import decide_settled, ends_with_regime
from .weak import put

AFTER = 1.0  # loops: the first ones lose most, and reach where the curve is steepest
AFTER_LOOKS = 8.0  # the same where each loop may end the cell
WEAKEST = 1e-4  # damping ratio of steady sliding: below, whether a motion settles is a question of its own
STRONGEST = 0.5
REACH, SLOWLY = 0.5, 0.01  # of the belt speed, within which few nodes do; unless damping takes long to get there
BY = 10.0  # tolerances by which a loop ends further in than it began
AGAIN = 0.7  # of the amplitude at which a map was refused, the next one is tried
DEAREST = 300.0  # steps that a map may take
WORTH = 30.0  # half loops still to come from which the map costs less than they do
FEWEST = 5  # nodes before an agreement counts
AGREEMENT = 0.5  # of the tolerance: the last node may differ by this from what those before foretold ...
EARLIER = 0.1  # ... and the one before by ten times as much: one agreement may be chance
# Of [-1, 1]; the third stands for a = 0, wherever that is.
LEJA = (
    1.0, -1.0, 0.0, -0.57735, 0.65871, -0.83922, 0.86998, 0.30562, -0.32166, -0.94305, 0.95271, 0.47937, -0.71265,
    -0.15601, 0.77488, -0.97949,
)  # fmt: skip
MOST_NODES = 16
SEVERAL = 16.0  # half loops that are worth a formula
TRUNCATED = 0.01  # of the tolerance: terms below are left out
NARROWER, MOST_STALLED = 0.7, 4000.0  # half loops on the way down until the amplitude is so much smaller
# What half loops that are measured must not touch; the end of the drive comes first.
ASIDE = (at.TAU_END, at.W_LEAST, at.DW_TOP, at.GAIN, at.GAIN_TOP, at.HEAT, at.BAND2, at.TAU, at.Y, at.W)
UNTRIED, TO_BEGIN, MEASURING, REFUSED, OVER = 0.0, 1.0, 2.0, 3.0, 4.0  # codes of MAP_STATE


# --- when it is worth it ----------------------------------------------------------------------------------------------


@compiled(inline=True)
def consider_map(m, i, tau, xi):
    """Have a map begin at the maximum of u that was just looked at, where the motion has a long way to settle."""
    s, amplitude = m.s, m.s[at.SIGMA + i] * (xi - m.s[at.XI_STAR + i])
    state = s[at.MAP_STATE + i]
    if state == REFUSED and s[at.LOOP_COUNT + i] == 0.0 and amplitude < AGAIN * s[at.MAP_FROM + i]:
        s[at.MAP_STATE + i] = UNTRIED
    elif state == UNTRIED:
        no_rest = s[at.MAP_REST + i] < s[at.MAP_TAU + i]  # since the last maximum
        inward = no_rest and amplitude < (1.0 - BY * m.rtol) * s[at.MAP_FROM + i]
        if no_rest and s[at.LOOP_COUNT + i] >= (AFTER_LOOKS if ends_with_regime(m, i) else AFTER):
            if not inward:
                s[at.MAP_STATE + i] = OVER
            elif amplitude < REACH * s[at.B + i] or 0.5 * drag_at(m.law, s, i, s[at.B + i]) < SLOWLY:
                s[at.MAP_STATE + i] = TO_BEGIN if is_worth_it(m, i, amplitude) else OVER
        s[at.MAP_TAU + i], s[at.MAP_FROM + i], s[at.INWARD + i] = tau, amplitude, 1.0 if inward else 0.0


@compiled
def is_worth_it(m, i, amplitude):
    """Return whether the motion from a maximum of u, on one curve, has a long way to settle."""
    s, ratio = m.s, 0.5 * drag_at(m.law, m.s, i, m.s[at.B + i])
    if s[at.W_MIN + i] > 0.0 and s[at.MODE + i] != at.FAST:
        return False
    other = s[at.DECIDED + i] + s[at.LEAPT + i] + s[at.CONFIRMING + i] + s[at.PUSH_STATE + i]
    if other > 0.0 or s[at.B + i] <= 0.0 or m.observer.until == at.UNTIL_HORIZON or not WEAKEST < ratio < STRONGEST:
        return False
    if m.max_steps - s[at.TRIED + i] < DEAREST:
        return False
    return amplitude > s[at.BAND + i] and log(amplitude / s[at.BAND + i]) > WORTH * pi * ratio


# --- measuring --------------------------------------------------------------------------------------------------------


@compiled
def begin_map(m, i):
    """Put what the half loops must not touch aside, and begin the first one."""
    s = m.s
    for k in range(len(ASIDE)):
        s[at.MAP_ASIDE + k * at.WIDTH + i] = s[ASIDE[k] + i]
    s[at.TAU_END + i], s[at.W_LEAST + i], s[at.DW_TOP + i] = inf, -inf, inf
    s[at.BAND2 + i], s[at.RADIUS2 + i], s[at.W_TOP + i], s[at.QUIET_BELOW + i] = 0.0, 0.0, inf, -1.0
    s[at.MAP_STATE + i], s[at.MAP_NODES + i], s[at.MAP_STEPS + i] = MEASURING, 0.0, s[at.TRIED + i]
    begin_half_loop(m, i, s[at.MAP_FROM + i])


@compiled
def begin_half_loop(m, i, a):
    """Put lane i at the turn with amplitude a, at time 0."""
    m.s[at.MAP_AT + i], m.s[at.TAU + i] = a, 0.0
    put(m, i, a, 0.0)


@compiled
def note_half_loop(m, i, h, w, dw, jerk):
    """Record the half loop that ends inside the step of lane i, over h to (w, dw, jerk), if one does."""
    s, b = m.s, m.s[at.B + i]
    if (s[at.W + i] > b) == (w > b) or s[at.TAU + i] == 0.0:
        return
    t, rise, _ = arrival(s, i, b, 1.0 if w > b else -1.0, h, (w, dw, jerk, 0.0))
    s[at.MAP_TO + i], s[at.MAP_TIME + i] = s[at.Y + i] + rise - s[at.Y_STAR + i], s[at.TAU + i] + t


@compiled(inline=True)
def newton(s, i, row, nodes, a):
    """The polynomial with the divided differences of a row, at a."""
    value = s[row + (nodes - 1) * at.WIDTH + i]
    for k in range(nodes - 2, -1, -1):
        value = value * (a - s[at.MAP_A + k * at.WIDTH + i]) + s[row + k * at.WIDTH + i]
    return value


@compiled
def add_node(s, i, a, c, time):
    """Add a node to the interpolants; by how much of it those before were wrong."""
    n = int(s[at.MAP_NODES + i])
    off_c, off_time = c, time
    if n > 0:
        off_c, off_time = c - newton(s, i, at.MAP_C, n, a), time - newton(s, i, at.MAP_T, n, a)
    spread = 1.0
    for k in range(n):
        spread *= a - s[at.MAP_A + k * at.WIDTH + i]
    s[at.MAP_A + n * at.WIDTH + i], s[at.MAP_NODES + i] = a, n + 1.0
    s[at.MAP_C + n * at.WIDTH + i], s[at.MAP_T + n * at.WIDTH + i] = off_c / spread, off_time / spread
    return max(abs(off_c), abs(off_time) / time)


@compiled(apart=True)
def follow_map(m, i):
    """After a step: begin the next half loop where one has ended; end the map where it is known, or will not be."""
    s = m.s
    a, to = s[at.MAP_AT + i], s[at.MAP_TO + i]
    if to == 0.0:
        return
    s[at.MAP_TO + i] = 0.0
    if not a * to < 0.0:
        refuse_map(m, i)
        return
    before, off = s[at.MAP_OFF + i], add_node(s, i, a, log(-to / a), s[at.MAP_TIME + i])
    s[at.MAP_OFF + i] = off
    n = int(s[at.MAP_NODES + i])
    if n == 1:
        begin_half_loop(m, i, to)
        return
    if n == 2:
        ratio = 0.5 * drag_at(m.law, s, i, s[at.B + i])
        turning = (1.0 - ratio * ratio) ** 0.5
        add_node(s, i, 0.0, -pi * ratio / turning, pi / turning)
        n = 3
    elif n > FEWEST and max(off, EARLIER * before) <= AGREEMENT * m.rtol:
        leap_down(m, i)
        return
    if n == MOST_NODES:
        refuse_map(m, i)
        return
    first, second = s[at.MAP_A + i], s[at.MAP_A + at.WIDTH + i]
    begin_half_loop(m, i, 0.5 * (first + second) + 0.5 * (first - second) * LEJA[n])


# --- the way down -----------------------------------------------------------------------------------------------------


@compiled
def leap_down(m, i):
    """Put lane i at the last turn but one outside the settling band, or at the last before its horizon.

    The smaller the amplitude, the fewer powers of it matter.
    """
    s, n = m.s, int(m.s[at.MAP_NODES + i])
    expand_in_powers(s, i, at.MAP_C, n)
    expand_in_powers(s, i, at.MAP_T, n)
    a, tau, half_loops, before = s[at.MAP_FROM + i], s[at.MAP_TAU + i], 0.0, -inf
    wide, stalled = inf, 0.0
    while True:
        stalled += 1.0
        if abs(a) < wide:
            n, wide, stalled = terms_that_matter(s, i, n, abs(a), TRUNCATED * m.rtol), NARROWER * abs(a), 0.0
            if n <= 3:
                many, log_ratio, time = many_half_loops(s, i, n, a, m.rtol)
                if many > 0.0 and tau + time < s[at.MAP_ASIDE + i]:
                    a, tau, half_loops = a * exp(log_ratio), tau + time, half_loops + many
        c, time = power_series(s, i, n, a)
        if c + before >= 0.0 or stalled > MOST_STALLED:  # the motion grows, or may never settle
            refuse_map(m, i)
            return
        ratio = exp(c)
        if abs(a) * ratio * ratio <= s[at.BAND + i] or tau + time >= s[at.MAP_ASIDE + i]:
            break
        a, tau, half_loops, before = -a * ratio, tau + time, half_loops + 1.0, c
    end_map(m, i, tau, a, half_loops)


@compiled
def expand_in_powers(s, i, row, nodes):
    """Turn divided differences into coefficients of the powers of a, in place."""
    for k in range(nodes - 2, -1, -1):
        node = s[at.MAP_A + k * at.WIDTH + i]
        for j in range(k, nodes - 1):
            s[row + j * at.WIDTH + i] -= node * s[row + (j + 1) * at.WIDTH + i]


@compiled
def terms_that_matter(s, i, most, a, tolerance):
    """How many terms of c and T there are up to the last above the tolerance at a > 0."""
    terms, power = 1, 1.0
    for k in range(1, most):
        power *= a
        if power * max(abs(s[at.MAP_C + k * at.WIDTH + i]), abs(s[at.MAP_T + k * at.WIDTH + i])) > tolerance:
            terms = k + 1
    return terms


@compiled
def many_half_loops(s, i, terms, a, rtol):
    """An even number of half loops that almost lead to the settling band, the change of ln a by them, and their time.

    Amplitudes so small that the sums over them are geometric series, to the square of what these amount to.
    """
    c_0, c_1, t_0, t_1 = s[at.MAP_C + i], s[at.MAP_C + at.WIDTH + i], s[at.MAP_T + i], s[at.MAP_T + at.WIDTH + i]
    c_2, t_2 = s[at.MAP_C + 2 * at.WIDTH + i], s[at.MAP_T + 2 * at.WIDTH + i]
    if terms < 3:
        c_2, t_2 = 0.0, 0.0
    if not c_0 < 0.0:
        return 0.0, 0.0, 0.0
    ratio = exp(c_0)
    largest = abs(c_1 * a) + abs(c_2) * a * a / (1.0 - ratio * ratio)
    many = 2.0 * floor(0.5 * log(abs(a) / s[at.BAND + i]) / -c_0 - 3.0)
    if not largest * largest <= TRUNCATED * rtol or many < SEVERAL:
        return 0.0, 0.0, 0.0
    left = exp(many * c_0)
    first, second = a * (1.0 - left) / (1.0 + ratio), a * a * (1.0 - left * left) / (1.0 - ratio * ratio)
    return many, many * c_0 + c_1 * first + c_2 * second, many * t_0 + t_1 * first + t_2 * second


@compiled(inline=True)
def power_series(s, i, terms, a):
    """c and T at a."""
    c, time = 0.0, 0.0
    for k in range(terms - 1, -1, -1):
        c, time = c * a + s[at.MAP_C + k * at.WIDTH + i], time * a + s[at.MAP_T + k * at.WIDTH + i]
    return c, time


@compiled
def refuse_map(m, i):
    """Let the motion of lane i go on from where it was."""
    s = m.s
    take_up(s, i)
    s[at.MAP_STATE + i] = REFUSED
    s[at.LOOP_STEPS + i] += s[at.TRIED + i] - s[at.MAP_STEPS + i]  # loops cost what they did
    put(m, i, s[at.Y + i] - s[at.Y_STAR + i], s[at.W + i] - s[at.B + i])


@compiled
def end_map(m, i, tau, a, half_loops):
    """Let the motion of lane i go on from the turn with amplitude a, so many half loops after the map began."""
    s = m.s
    take_up(s, i)
    s[at.MAP_STATE + i], s[at.TAU + i], s[at.CROSSED + i] = OVER, tau, s[at.CROSSED + i] + half_loops
    s[at.SIDE_LAST + i] = s[at.SIGMA + i] if a > 0.0 else -s[at.SIGMA + i]
    put(m, i, a, 0.0)
    if ends_with_regime(m, i):
        note_closest_trough(s, i)
        decide_settled(m, i, nan, s[at.XI_STAR + i], at.SETTLING_CERTAIN)
    else:
        forget_loops(s, i)


@compiled(inline=True)
def take_up(s, i):
    """Put back what was put aside."""
    for k in range(len(ASIDE)):
        s[ASIDE[k] + i] = s[at.MAP_ASIDE + k * at.WIDTH + i]
