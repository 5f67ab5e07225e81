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

from math import inf, log, pi

from .. import layout as at
from ..exponential import exp
from ..jit import compiled
from ..roots import arrival
from .cycles import forget_loops
from .settling import drag_at
from .weak import put

AFTER = 2.0  # loops: the first ones lose most, and reach where the curve is steepest
WORTH = 30.0  # half loops still to come from which the map costs less than they do
FEWEST = 5  # nodes before an agreement counts
AGREEMENT = 0.5  # of the tolerance: the last node may differ by this from what those before foretold
# Of [-1, 1]; the third stands for a = 0, wherever that is.
LEJA = (
    1.0, -1.0, 0.0, -0.57735, 0.65871, -0.83922, 0.86998, 0.30562, -0.32166, -0.94305, 0.95271, 0.47937, -0.71265,
    -0.15601, 0.77488, -0.97949,
)  # fmt: skip
MOST_NODES = 16
MOST_HALF_LOOPS = 1e5  # on the way down
ASIDE = (at.TAU_END, at.W_LEAST, at.DW_TOP, at.GAIN, at.GAIN_TOP, at.HEAT, at.BAND2)  # untouched by half loops measured
UNTRIED, TO_BEGIN, MEASURING, OVER = 0.0, 1.0, 2.0, 3.0  # codes of MAP_STATE


# --- when it is worth it ----------------------------------------------------------------------------------------------


@compiled(inline=True)
def map_may_begin(m, i):
    """Return whether the maximum of u that was just looked at is one to begin a map from."""
    s = m.s
    if s[at.MAP_STATE + i] != UNTRIED or s[at.LOOP_COUNT + i] < AFTER or not m.observer.early_stop:
        return False
    plain = s[at.W_MIN + i] == 0.0 and s[at.B + i] > 0.0 and s[at.DECIDED + i] + s[at.LEAPT + i] == 0.0
    return plain and s[at.CONFIRMING + i] + s[at.PUSH_STATE + i] == 0.0


@compiled
def consider_map(m, i, tau, xi):
    """Have a map begin at this maximum of u, where the motion has a long way to settle."""
    s = m.s
    if not map_may_begin(m, i):
        return
    s[at.MAP_STATE + i] = OVER
    ratio = 0.5 * drag_at(m.law, s, i, s[at.B + i])
    amplitude = s[at.SIGMA + i] * (xi - s[at.XI_STAR + i])
    if not 0.0 < ratio < 0.5 or not amplitude > s[at.BAND + i]:
        return
    if log(amplitude / s[at.BAND + i]) > WORTH * pi * ratio:
        s[at.MAP_STATE + i], s[at.MAP_TAU + i], s[at.MAP_FROM + i] = TO_BEGIN, tau, amplitude


# --- measuring ----------------------------------------------------------------------------------------------------------


@compiled
def begin_map(m, i):
    """Put what the half loops must not touch aside, and begin the first one."""
    s = m.s
    for k in range(len(ASIDE)):
        s[at.MAP_ASIDE + k * at.WIDTH + i] = s[ASIDE[k] + i]
    s[at.TAU_END + i], s[at.W_LEAST + i], s[at.DW_TOP + i] = inf, -inf, inf
    s[at.BAND2 + i], s[at.RADIUS2 + i], s[at.W_TOP + i], s[at.QUIET_BELOW + i] = 0.0, 0.0, inf, -1.0
    s[at.MAP_STATE + i], s[at.MAP_NODES + i] = MEASURING, 0.0
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


@compiled
def follow_map(m, i):
    """After a step: begin the next half loop where one has ended; end the map where it is known, or will not be."""
    s = m.s
    a, to = s[at.MAP_AT + i], s[at.MAP_TO + i]
    if to == 0.0:
        return
    s[at.MAP_TO + i] = 0.0
    if not a * to < 0.0:
        end_map(m, i, s[at.MAP_TAU + i], s[at.MAP_FROM + i], 0.0)
        return
    off = add_node(s, i, a, log(-to / a), s[at.MAP_TIME + i])
    n = int(s[at.MAP_NODES + i])
    if n == 1:
        begin_half_loop(m, i, to)
        return
    if n == 2:
        ratio = 0.5 * drag_at(m.law, s, i, s[at.B + i])
        turning = (1.0 - ratio * ratio) ** 0.5
        add_node(s, i, 0.0, -pi * ratio / turning, pi / turning)
        n = 3
    elif n > FEWEST and off <= AGREEMENT * m.rtol:
        leap_down(m, i)
        return
    if n == MOST_NODES:
        end_map(m, i, s[at.MAP_TAU + i], s[at.MAP_FROM + i], 0.0)
        return
    first, second = s[at.MAP_A + i], s[at.MAP_A + at.WIDTH + i]
    begin_half_loop(m, i, 0.5 * (first + second) + 0.5 * (first - second) * LEJA[n])


# --- the way down -------------------------------------------------------------------------------------------------------


@compiled
def leap_down(m, i):
    """Put lane i at the last turn but one outside the settling band, or at the last before its horizon."""
    s, n = m.s, int(m.s[at.MAP_NODES + i])
    a, tau, half_loops, before = s[at.MAP_FROM + i], s[at.MAP_TAU + i], 0.0, 0.0
    while True:
        c, time = newton(s, i, at.MAP_C, n, a), newton(s, i, at.MAP_T, n, a)
        if half_loops > 0.0 and c + before >= 0.0 or half_loops > MOST_HALF_LOOPS:  # the map has a fixed point
            end_map(m, i, s[at.MAP_TAU + i], s[at.MAP_FROM + i], 0.0)
            return
        ratio = exp(c)
        if abs(a) * ratio * ratio <= s[at.BAND + i] or tau + time >= s[at.MAP_ASIDE + i]:
            break
        a, tau, half_loops, before = -a * ratio, tau + time, half_loops + 1.0, c
    end_map(m, i, tau, a, half_loops)


@compiled
def end_map(m, i, tau, a, half_loops):
    """Let the motion of lane i go on from the turn with amplitude a, so many half loops after the map began."""
    s = m.s
    s[at.MAP_STATE + i], s[at.TAU + i], s[at.CROSSED + i] = OVER, tau, s[at.CROSSED + i] + half_loops
    for k in range(len(ASIDE)):
        s[ASIDE[k] + i] = s[at.MAP_ASIDE + k * at.WIDTH + i]
    s[at.SIDE_LAST + i] = s[at.SIGMA + i] if a > 0.0 else -s[at.SIGMA + i]
    put(m, i, a, 0.0)
    forget_loops(s, i)
