"""What a motion means: extrema, crossings and cycles as they pass, and the regime once it is certain.

Nothing is guessed: stick-slip is a closed cycle, settling is proven by a Lyapunov function or by shrinking peaks, and a
cell whose horizon or budget runs out first is `unresolved`. Functions change `book` (slow state) and `results`.
"""

from math import atan2, cos, inf, log, nan, pi, sin

from .events import step_again
from .exponential import exp
from .friction import stribeck, stribeck_slope
from .jit import compiled
from .layout import (
    A1, A2, A3, A4, ACCELERATION_MAX, B, BAND, BELT, CELL, CREEP, CROSSED, CROSSINGS, CYCLE_CLOSED, CYCLE_HEAT,
    CYCLE_START, CYCLE_STICK_TIME, DAMPED, DECIDED, DROP, DW, DW_HIGH, ETA_END, FALL, G, GAMMA, HEAT, HEAT_START,
    JERK, LOOP_AMPLITUDE, LOOP_COUNT, LOOP_HEAT, LOOP_TAU, MARK, MU_REVERSAL, MU_TURN, OFFSET,
    OSCILLATION_SUSTAINED, PEAK, PEAK_BEFORE, PERIOD, RADIUS2, RATE, REGIME, RISE, SETTLED, SETTLING_TIME,
    SIDE_LAST, SIGMA, SLIP_START, SLOPE, SPEED_MAX, STATUS, STEPS, STICKS, STICK_COUNT, STICK_SLIP, STICK_SUM,
    STICK_TIME, SUSTAINED, TAU, TRIED, W, W_HIGH, W_MIN, W_STABLE, XI_END, XI_HIGH, XI_LOW, XI_MAX, XI_MIN, XI_STAR,
    Y, Y_STAR,
)  # fmt: skip
from .polynomial import derivative, hermite, minus, root, value

BAND_SHARE = 1e-4  # settling band in units of mu_start
LOOPS = 10  # cycles over which the log decrement is taken
SUSTAINED_DECREMENT = 1e-5
SHRINKING = 0.999  # a peak this much lower than the last counts as shrinking


@compiled
def damping_ratio(cells, c):
    """Linear damping ratio of steady sliding on the curve, (gamma + mu'(b)) / 2; NaN where the belt stands still."""
    belt = abs(cells[BELT, c])
    if belt == 0.0:
        return nan
    return 0.5 * (cells[GAMMA, c] + stribeck_slope(belt, cells[A2, c], cells[A3, c], cells[A4, c]))


@compiled
def start_book(book, i, cells, c):
    """Fresh slow state for cell c in lane i."""
    book[i, :] = 0.0
    belt = cells[BELT, c]
    mu_belt = stribeck(abs(belt), cells[A1, c], cells[A2, c], cells[A3, c], cells[A4, c])
    book[i, CELL] = c
    book[i, XI_STAR] = mu_belt if belt >= 0.0 else -mu_belt
    book[i, BAND] = BAND_SHARE * (cells[A1, c] + cells[A3, c])
    book[i, SLIP_START], book[i, CYCLE_START], book[i, MU_TURN] = nan, nan, nan
    book[i, PEAK], book[i, PEAK_BEFORE], book[i, LOOP_COUNT] = inf, inf, -1.0
    reset_extrema(book, i)


@compiled
def reset_extrema(book, i):
    """Forget the extrema so far."""
    book[i, XI_HIGH], book[i, XI_LOW], book[i, W_HIGH], book[i, DW_HIGH] = -inf, inf, 0.0, 0.0


# --- extrema --------------------------------------------------------------------------------------------------------


@compiled
def note_ends(book, i, u, w, dw):
    """Let a state that begins or ends a phase count towards the extrema."""
    xi = book[i, SIGMA] * u
    book[i, XI_HIGH], book[i, XI_LOW] = max(book[i, XI_HIGH], xi), min(book[i, XI_LOW], xi)
    book[i, W_HIGH], book[i, DW_HIGH] = max(book[i, W_HIGH], w), max(book[i, DW_HIGH], abs(dw))


@compiled
def record_extrema(s, i, book, results, h, y1, w1, dw1, jerk1):
    """Extrema of u, w and w' between the start of the step of lane i and the state after h."""
    y0, w0, dw0, jerk0, b = s[Y + i], s[W + i], s[DW + i], s[JERK + i], s[B + i]
    p = hermite(h, w0, dw0, jerk0, w1, dw1, jerk1)
    if dw0 * dw1 < 0.0:
        top = value(p, root(derivative(p), 0.0, 1.0))
        book[i, W_HIGH] = max(book[i, W_HIGH], top)
        if dw0 > 0.0:
            note_peak(book, i, top - b)
    if jerk0 * jerk1 < 0.0:
        slope = derivative(p)
        steepest = value(slope, root(derivative(slope), 0.0, 1.0)) / h
        book[i, DW_HIGH] = max(book[i, DW_HIGH], abs(steepest))
    if (w0 > b) != (w1 > b):  # u' = b - w changes sign
        theta = root(minus(p, b), 0.0, 1.0)
        y = value(hermite(h, y0, b - w0, -dw0, y1, b - w1, -dw1), theta)
        u = y - s[G + i] * b + s[OFFSET + i]
        note_turn(s, i, book, results, theta * h, book[i, SIGMA] * u)


@compiled
def note_peak(book, i, height):
    """A peak of the slip speed, `height` above the belt speed."""
    book[i, PEAK_BEFORE], book[i, PEAK] = book[i, PEAK], height


@compiled
def note_turn(s, i, book, results, h, xi):
    """An extremum of xi, at h after the start of the step: the range, the crossing of the equilibrium, the loop."""
    book[i, XI_HIGH], book[i, XI_LOW] = max(book[i, XI_HIGH], xi), min(book[i, XI_LOW], xi)
    distance = xi - book[i, XI_STAR]
    if abs(distance) > book[i, BAND]:
        side = 1.0 if distance > 0.0 else -1.0
        if side * book[i, SIDE_LAST] < 0.0:
            book[i, CROSSED] += 1.0
        book[i, SIDE_LAST] = side
    if distance > 0.0:
        book[i, LOOP_COUNT] += 1.0
        if book[i, LOOP_COUNT] == 0.0 or book[i, LOOP_COUNT] == LOOPS:
            compare_loops(s, i, book, results, h, distance)


@compiled
def compare_loops(s, i, book, results, h, amplitude):
    """At the first maximum and ten loops later: sustained if the log decrement is zero, else count the next ten."""
    tau, heat = s[TAU + i] + h, s[HEAT + i] + step_again(s, i, h)[4]
    if book[i, LOOP_COUNT] == LOOPS:
        decrement = log(book[i, LOOP_AMPLITUDE] / amplitude) / LOOPS
        if abs(decrement) < SUSTAINED_DECREMENT:
            c = int(book[i, CELL])
            results[PERIOD, c] = (tau - book[i, LOOP_TAU]) / LOOPS
            results[CYCLE_STICK_TIME, c] = 0.0
            results[CYCLE_HEAT, c] = (heat - book[i, LOOP_HEAT]) / LOOPS
            decide(s, i, book, results, SUSTAINED, OSCILLATION_SUSTAINED)
    book[i, LOOP_AMPLITUDE], book[i, LOOP_TAU], book[i, LOOP_HEAT] = amplitude, tau, heat
    book[i, LOOP_COUNT] = 0.0


@compiled
def note_side(book, i, xi):
    """Remember on which side of the equilibrium a slip starts."""
    distance = xi - book[i, XI_STAR]
    if abs(distance) > book[i, BAND]:
        book[i, SIDE_LAST] = 1.0 if distance > 0.0 else -1.0


# --- settling -------------------------------------------------------------------------------------------------------


@compiled
def proven_radius(s, i, book, mode, b):
    """Radius of the disc about steady sliding, in the plane (u, u'), from which the motion provably settles.

    With V = (u - u*)^2 + u'^2, V' = -2 u'^2 (gamma + mu'(somewhere between w and b)). As mu' grows with w, V falls for
    ever once the disc lies where gamma + mu' > 0 (w > v_H), where w > 0, and where the mode cannot change. A line (mode
    FALL) is left at the next trough of w, which never comes if sliding along it is overdamped: `on_slow_side`.
    """
    if b <= 0.0 or book[i, DECIDED] > 0.0:
        return 0.0
    if mode == FALL:
        return min(book[i, BAND], b) if s[G + i] + s[SLOPE + i] >= 2.0 else 0.0
    if mode == RISE and book[i, W_MIN] > 0.0:
        return 0.0
    return max(0.0, min(book[i, BAND], b - max(book[i, W_STABLE], book[i, W_MIN])))


@compiled
def on_slow_side(s, i, y, w):
    """Whether an overdamped approach along the line never passes w = b: beyond the fast eigenvector."""
    drag = s[G + i] + s[SLOPE + i]
    fast = 0.5 * drag + (0.25 * drag * drag - 1.0) ** 0.5
    return w >= s[B + i] and w - s[B + i] <= fast * (y - s[Y_STAR + i])


@compiled
def is_shrinking(s, i, book, cells, u, w):
    """Whether a trough below v_min, with its peak, lies inside the band and the peaks shrink.

    Near steady sliding on the hysteretic curve the motion is a chain of straight pieces, the same at every scale: peaks
    then shrink by a constant factor. Small against b and a4 so that the curve is straight over the loop.
    """
    b, c = s[B + i], int(book[i, CELL])
    small = min(book[i, BAND], 0.05 * min(b, cells[A4, c]))
    near = abs(book[i, SIGMA] * u - book[i, XI_STAR]) < book[i, BAND] and b - w < small and book[i, PEAK] < small
    return near and book[i, PEAK] < SHRINKING * book[i, PEAK_BEFORE]


@compiled
def ring_extremum(p, dp, zeta):
    """The next extremum of p'' + 2 zeta p' + p = 0 from (p, p'), zeta > 0; 0, the limit, if none is ahead."""
    discriminant = 1.0 - zeta * zeta
    omega = max(abs(discriminant), 1e-12) ** 0.5  # at zeta = 1 either formula holds in the limit
    s = (dp + zeta * p) / omega
    if discriminant > 0.0:
        phase = atan2(dp, zeta * s + omega * p)
        if phase <= 0.0:
            phase += pi
        return exp(-zeta * phase / omega) * (p * cos(phase) + s * sin(phase))
    tangent = dp / (zeta * s - omega * p)  # tanh(omega t) where p' vanishes
    if not 0.0 < tangent < 1.0:
        return 0.0
    t = 0.5 * log((1.0 + tangent) / (1.0 - tangent)) / omega
    return 0.5 * ((p + s) * exp((omega - zeta) * t) + (p - s) * exp(-(omega + zeta) * t))


@compiled
def note_ring_down(s, i, book):
    """Extrema still to come once the motion has settled, where it is the linear oscillator to one part in 10^4.

    An approach that stays inside the settling band may yet overshoot there, and its limit belongs to the range.
    """
    b = s[B + i]
    zeta = 0.5 * (s[G + i] + s[SLOPE + i] - s[DROP + i] * s[RATE + i] * exp(-s[RATE + i] * b))
    u_star = s[Y_STAR + i] - s[G + i] * b + s[OFFSET + i]
    note_ends(book, i, u_star, b, 0.0)
    p = ring_extremum(s[Y + i] - s[Y_STAR + i], b - s[W + i], zeta)
    q = ring_extremum(s[W + i] - b, s[DW + i], zeta)
    note_ends(book, i, u_star + p, b + q, 0.0)
    note_ends(book, i, u_star + ring_extremum(p, 0.0, zeta), b + ring_extremum(q, 0.0, zeta), 0.0)


# --- verdicts -------------------------------------------------------------------------------------------------------


@compiled
def decide(s, i, book, results, regime, status):
    """Write the verdict and the metrics of the motion; extrema are not recorded from here on."""
    c = int(book[i, CELL])
    results[REGIME, c], results[STATUS, c] = regime, status
    results[XI_MAX, c], results[XI_MIN, c] = book[i, XI_HIGH], book[i, XI_LOW]
    results[SPEED_MAX, c], results[ACCELERATION_MAX, c] = book[i, W_HIGH], book[i, DW_HIGH]
    results[MU_REVERSAL, c], results[CROSSINGS, c] = book[i, MU_TURN], book[i, CROSSED]
    book[i, DECIDED] = 1.0
    s[MARK + i], s[RADIUS2 + i] = 0.0, 0.0


@compiled
def decide_settled(s, i, book, results, tau):
    """The motion settles: damped if it crossed the equilibrium at least twice, creep if not."""
    results[SETTLING_TIME, int(book[i, CELL])] = tau - book[i, SLIP_START]
    note_ring_down(s, i, book)
    decide(s, i, book, results, DAMPED if book[i, CROSSED] >= 2.0 else CREEP, SETTLED)


@compiled
def decide_cycle(s, i, book, results, tau, stick_time):
    """Break-away to break-away: stick-slip, with one stick phase in the cycle."""
    c = int(book[i, CELL])
    results[PERIOD, c], results[CYCLE_STICK_TIME, c] = tau - book[i, CYCLE_START], stick_time
    results[CYCLE_HEAT, c] = s[HEAT + i] - book[i, HEAT_START]
    decide(s, i, book, results, STICK_SLIP, CYCLE_CLOSED)


@compiled
def finish(s, i, book, results, regime, status, xi, eta):
    """Close the cell: status, counters and final state; `regime` holds only where none was decided before."""
    c = int(book[i, CELL])
    if book[i, DECIDED] == 0.0:
        results[REGIME, c] = regime
        results[CROSSINGS, c] = book[i, CROSSED]
    results[STATUS, c] = status
    results[STEPS, c] = s[TRIED + i]
    results[STICKS, c], results[STICK_TIME, c] = book[i, STICK_COUNT], book[i, STICK_SUM]
    results[XI_END, c], results[ETA_END, c] = xi, eta
