"""The amplitude map: a slip that rings down to steady sliding, taken there without following every turn.

About steady sliding a slip that neither sticks nor leaves its curve is a flow in the plane (p, q), and where it turns,
q = 0, the signed amplitude p = a is the whole state. Half a loop takes it to

    a' = -a R(a)      after a time T(a),

with R and T analytic through a = 0, where they are those of the linear oscillator. Spirals of a plane do not cross: all
turns to come lie between the last two, a_0 and a_1. So R and T are interpolated there (Newton's form), from half loops
that begin at points of a Leja sequence, in which each new one shows by how much those before were wrong. Once that is
within the tolerance the map is iterated to the turn before the settling band (`ring_down.py`), and the motion goes on
from there. Where the map has a fixed point on the way that attracts, the motion goes on from that (`ring_down.py`).
Where it does not come within the tolerance, the motion goes on from where it was.

L. Reichel, Newton interpolation at Leja points, BIT 30 (1990) 332-346.
"""

from math import e, inf, isnan, log, nan, pi

from .. import layout as at
from ..arithmetic import exp
from ..jit import compiled
from ..roots import arrival
from .cycles import begin_confirming, forget_loops, set_reference
from .ring_down import cycle_inside, ring_down, to_powers
from .settling import drag_at
from .verdict import decide_settled, ends_with_regime, note_closest_trough
from .weak import put

AFTER = 1.0  # loops: the first ones lose most, and reach where the curve is steepest
AFTER_LOOKS = 8.0  # the same where each loop may end the cell
WEAKEST = 1e-4  # damping ratio of steady sliding: below, whether a motion settles is a question of its own
STRONGEST = 0.5
LOOP, NODE = 8.0, 0.25  # steps: of a loop, and of a map over the square of its nodes ...
MORE, LIKELY = 1.3, 21.0  # times as many nodes as an entire function of its steepness needs; with which it is begun
REACH = 0.5  # of the belt speed, within which a map begins in any case
BY = 10.0  # tolerances by which a loop ends further in than it began
AGAIN = 0.7  # of the amplitude at which a map was refused, the next one is tried
DEAREST = 300.0  # steps that a map may take
WORTH = 30.0  # half loops still to come from which the map costs less than they do
FEWEST = 5  # nodes before an agreement counts
AGREEMENT = 0.5  # of the tolerance: the last node may differ by this from what those before foretold ...
EARLIER = 0.1  # ... and the one before by ten times as much: one agreement may be chance
BEYOND = 1e-15  # of the belt speed: where a turn is not seen again
FAR_OFF = 1e-3  # of the amplitude: a cycle that the map misses by as much is none
NEARER = 3.0  # by which every further node must bring it nearer, as a mean
# Of [-1, 1]; the third stands for a = 0, wherever that is.
LEJA = (
    1.0, -1.0, 0.0, -0.57735, 0.65871, -0.83922, 0.86998, 0.30562, -0.32166, -0.94305, 0.95271, 0.47937, -0.71265,
    -0.15601, 0.77488, -0.97949, 0.16117, 0.98333, -0.46137, -0.89189, 0.5719, 0.91256, -0.64926, 0.07982,
)  # fmt: skip
MOST_NODES = at.MAP_MOST_NODES
# What half loops that are measured must not touch; the end of the drive comes first.
ASIDE = (
    at.TAU_END, at.LONGEST, at.W_LEAST, at.DW_TOP, at.GAIN, at.GAIN_TOP, at.HEAT, at.BAND2, at.TAU, at.Y, at.W,
)  # fmt: skip
INSIDE = 1.5  # step in loops inside another one: all extremes are behind
QUARTER = 1.7  # step while half loops are measured, whose only events are their ends: two of them are half a loop
# Codes of MAP_STATE; the last two once the lane was put on a cycle, for a loop and after it.
UNTRIED, TO_BEGIN, MEASURING, REFUSED, OVER, ON_CYCLE, CORRECTED = 0.0, 1.0, 2.0, 3.0, 4.0, 5.0, 6.0


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
            elif not is_worth_it(m, i, amplitude):
                s[at.MAP_STATE + i] = OVER
            elif begins_best_here(m, i, amplitude):
                s[at.MAP_STATE + i] = TO_BEGIN
            if inward and is_on_one_curve(s, i) and 0.5 * drag_at(m.law, s, i, s[at.B + i]) < STRONGEST:
                s[at.LONGEST + i] = INSIDE
        s[at.MAP_TAU + i], s[at.MAP_FROM + i], s[at.INWARD + i] = tau, amplitude, 1.0 if inward else 0.0
    elif state == ON_CYCLE:
        correct_cycle(s, i, amplitude)


@compiled(inline=True)
def is_on_one_curve(s, i):
    """Return whether loops that turn further and further in stay on the curve of the present mode."""
    return s[at.W_MIN + i] == 0.0 or s[at.MODE + i] == at.FAST


@compiled
def is_worth_it(m, i, amplitude):
    """Return whether the motion from a maximum of u, on one curve, has a long way to settle."""
    s, ratio = m.s, 0.5 * drag_at(m.law, m.s, i, m.s[at.B + i])
    if not is_on_one_curve(s, i):
        return False
    other = s[at.DECIDED + i] + s[at.LEAPT + i] + s[at.CONFIRMING + i] + s[at.PUSH_STATE + i]
    if other > 0.0 or s[at.B + i] <= 0.0 or m.observer.until == at.UNTIL_HORIZON:
        return False
    if not WEAKEST < abs(ratio) < STRONGEST or m.max_steps - s[at.TRIED + i] < DEAREST:
        return False
    if ratio < 0.0 and s[at.TAU_END + i] < inf:
        return False
    return amplitude > s[at.BAND + i] and log(amplitude / s[at.BAND + i]) > WORTH * pi * ratio


@compiled
def begins_best_here(m, i, amplitude):
    """Return whether one more loop costs more steps than a map saves by it; near steady sliding, few nodes do."""
    if amplitude < REACH * m.s[at.B + i]:
        return True
    ratio = 0.5 * drag_at(m.law, m.s, i, m.s[at.B + i])
    after = amplitude * exp(-2.0 * pi * ratio)
    return likely_steps(m, i, amplitude) - likely_steps(m, i, after) < LOOP


@compiled
def likely_steps(m, i, amplitude):
    """Return about how many steps a map takes that begins here.

    e^(-k x), in [-1, 1], is within the tolerance of a polynomial of degree (2 k ln(1/tolerance))^(1/2).
    """
    s, b, steepness = m.s, m.s[at.B + i], amplitude * m.s[at.RATE + i]
    bend = abs(drag_at(m.law, s, i, max(b - amplitude, 0.0)) - drag_at(m.law, s, i, b))
    nodes = MORE * (2.0 * steepness * log(max(bend / (m.rtol * steepness), e))) ** 0.5
    return NODE * nodes * nodes if nodes < LIKELY else inf


# --- measuring --------------------------------------------------------------------------------------------------------


@compiled
def begin_map(m, i):
    """Put what the half loops must not touch aside, and begin the first one."""
    s = m.s
    for k in range(len(ASIDE)):
        s[at.MAP_ASIDE + k * at.WIDTH + i] = s[ASIDE[k] + i]
    s[at.TAU_END + i], s[at.W_LEAST + i], s[at.DW_TOP + i] = inf, -inf, inf
    s[at.BAND2 + i], s[at.RADIUS2 + i], s[at.W_TOP + i], s[at.QUIET_BELOW + i] = 0.0, 0.0, inf, -1.0
    s[at.LONGEST + i], s[at.MAP_STATE + i] = QUARTER, MEASURING
    s[at.MAP_NODES + i], s[at.MAP_STEPS + i] = 0.0, s[at.TRIED + i]
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
    t, rise, _ = arrival(s, i, b, h, (w, dw, jerk, 0.0))
    s[at.MAP_TO + i], s[at.MAP_TIME + i] = s[at.Y + i] + rise - s[at.Y_STAR + i], s[at.TAU + i] + t


@compiled(inline=True)
def newton(s, i, row, nodes, a):
    """The polynomial with the divided differences of a row, at a."""
    value = s[row + (nodes - 1) * at.WIDTH + i]
    for k in range(nodes - 2, -1, -1):
        value = value * (a - s[at.MAP_A + k * at.WIDTH + i]) + s[row + k * at.WIDTH + i]
    return value


@compiled
def add_node(s, i, a, ratio, time):
    """Add a node to the interpolants; by how much of it those before were wrong."""
    n = int(s[at.MAP_NODES + i])
    off_ratio, off_time = ratio, time
    if n > 0:
        off_ratio, off_time = ratio - newton(s, i, at.MAP_R, n, a), time - newton(s, i, at.MAP_T, n, a)
    spread = 1.0
    for k in range(n):
        spread *= a - s[at.MAP_A + k * at.WIDTH + i]
    s[at.MAP_A + n * at.WIDTH + i], s[at.MAP_NODES + i] = a, n + 1.0
    s[at.MAP_R + n * at.WIDTH + i], s[at.MAP_T + n * at.WIDTH + i] = off_ratio / spread, off_time / spread
    return max(abs(off_ratio) / ratio, abs(off_time) / time)


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
    before, off = s[at.MAP_OFF + i], add_node(s, i, a, -to / a, s[at.MAP_TIME + i])
    s[at.MAP_OFF + i] = off
    n = int(s[at.MAP_NODES + i])
    if n == 1:
        begin_half_loop(m, i, to)
        return
    if n == 2:
        ratio = 0.5 * drag_at(m.law, s, i, s[at.B + i])
        turning = (1.0 - ratio * ratio) ** 0.5
        add_node(s, i, 0.0, exp(-pi * ratio / turning), pi / turning)
        n = 3
    if n > FEWEST and max(off, EARLIER * before) <= AGREEMENT * m.rtol:
        leap_down(m, i)
    elif off > AGREEMENT * m.rtol * NEARER ** (MOST_NODES - n):
        refuse_map(m, i)
    else:
        first, second = s[at.MAP_A + i], s[at.MAP_A + at.WIDTH + i]
        begin_half_loop(m, i, 0.5 * (first + second) + 0.5 * (first - second) * LEJA[n])


# --- the end ----------------------------------------------------------------------------------------------------------


@compiled
def leap_down(m, i):
    """Put lane i where the map takes it."""
    s = m.s
    if drag_at(m.law, s, i, s[at.B + i]) < 0.0:
        leap_to_cycle(m, i)
        return
    a, tau, half_loops = ring_down(s, i, s[at.MAP_FROM + i], s[at.MAP_TAU + i], s[at.MAP_ASIDE + i], m.rtol)
    if half_loops < 0.0:
        refuse_map(m, i)
    else:
        end_map(m, i, tau, a, half_loops)


@compiled
def leap_to_cycle(m, i):
    """Put lane i on the cycle to which the map leads."""
    s, nodes = m.s, int(m.s[at.MAP_NODES + i])
    to_powers(s, i, nodes)
    a, left = cycle_inside(s, i, nodes, s[at.MAP_FROM + i], m.rtol)
    if isnan(a) or not a > s[at.BAND + i]:
        refuse_map(m, i)
        return
    go_on_from(m, i, s[at.MAP_TAU + i], a, 0.0)
    put(m, i, a, BEYOND * s[at.B + i])
    s[at.MAP_FROM + i], s[at.MULTIPLIER + i], s[at.MAP_STATE + i] = a, left, ON_CYCLE


@compiled
def correct_cycle(s, i, amplitude):
    """After a loop from the cycle of the map to `amplitude`: where the cycle is (Newton's method)."""
    off = (amplitude - s[at.MAP_FROM + i]) / (1.0 - s[at.MULTIPLIER + i])
    s[at.MAP_STATE + i] = CORRECTED if abs(off) <= FAR_OFF * amplitude else OVER
    s[at.MAP_FROM + i] += off


@compiled
def confirm_corrected(m, i):
    """Put lane i on the cycle, as corrected, which is gone through once more."""
    s, a = m.s, m.s[at.MAP_FROM + i]
    put(m, i, a, BEYOND * s[at.B + i])
    set_reference(s, i, s[at.TAU + i], s[at.HEAT + i], s[at.XI_STAR + i] + s[at.SIGMA + i] * a)
    begin_confirming(m, i)
    s[at.LOOP_MOVED + i], s[at.MAP_STATE + i] = 1.0, OVER


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
    """The motion of lane i comes to the turn with amplitude a, so many half loops after the map began, and settles."""
    s = m.s
    go_on_from(m, i, tau, a, half_loops)
    if ends_with_regime(m, i):
        note_closest_trough(s, i)
        decide_settled(m, i, nan, s[at.XI_STAR + i], at.SETTLING_CERTAIN)


@compiled
def go_on_from(m, i, tau, a, half_loops):
    """Let the motion of lane i go on from the turn with amplitude a, so many half loops after the map began."""
    s = m.s
    take_up(s, i)
    s[at.MAP_STATE + i], s[at.TAU + i], s[at.CROSSED + i] = OVER, tau, s[at.CROSSED + i] + half_loops
    s[at.SIDE_LAST + i] = s[at.SIGMA + i] if a > 0.0 else -s[at.SIGMA + i]
    put(m, i, a, 0.0)
    forget_loops(s, i)


@compiled(inline=True)
def take_up(s, i):
    """Put back what was put aside."""
    for k in range(len(ASIDE)):
        s[ASIDE[k] + i] = s[at.MAP_ASIDE + k * at.WIDTH + i]
