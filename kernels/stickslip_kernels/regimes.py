"""What a motion means: extrema, crossings and cycles as they pass, and the regime once it is certain.

Nothing is guessed: stick-slip is a closed cycle, settling is proven by a Lyapunov function or by shrinking peaks, and a
cell whose horizon or budget runs out first is `unresolved`. Functions change the slow state and `results`.
"""

from math import atan2, cos, inf, log, nan, pi, sin

from .dense import rise_and_work, speed
from .exponential import exp
from .friction import coefficient, coefficient_slope
from .jit import compiled
from .lanes import reach
from .laws import inflection, shape, weakening_slope
from .layout import (
    A1, A3, A4, ACCELERATION_MAX, B, BAND, BAND2, BELT, CELL, CREEP, CROSSED, CROSSINGS, CYCLE_CLOSED, CYCLE_HEAT,
    CYCLE_START, CYCLE_STICK_TIME, DAMPED, DECIDED, DECIDED_BY, DROP, DW, DW_HIGH, DW_TOP, ENTERED, ETA_END,
    EXPONENT, G, GAMMA, HEAT, HEAT_START, JERK, LANE_NUMBERS, LOOP_AMPLITUDE, LOOP_COUNT, LOOP_DECREMENT, LOOP_HEAT,
    LOOP_TAU, MARK, MODE, MU_REVERSAL, MU_TURN, OFFSET, OSCILLATION_SUSTAINED, PEAK, PEAK_BEFORE, PERIOD, QUIET,
    QUIET_GIVEN, RADIUS2, RATE, REGIME, RELEASE_CHANGE, RISE, SETTLED, SETTLING_TIME, SIDE_LAST, SIGMA, SLIP_START,
    SLOPE, SLOW, SPEED_MAX, STATUS, STEPS, STICKS, STICK_COUNT, STICK_SLIP, STICK_SUM, STICK_TIME, SUSTAINED, TAU,
    TRIED, W, WIDTH, W_HIGH, W_MIN, W_STABLE, W_TOP, XI_END, XI_HIGH, XI_LOW, XI_MAX, XI_MIN, XI_STAR, Y, Y_HIGH,
    Y_LOW, Y_STAR,
)  # fmt: skip
from .roots import FOR_A_VALUE, arrival, extreme_slope, extreme_speed

BAND_SHARE = 1e-4  # settling band in units of mu_start
LOOPS = 10  # cycles over which the log decrement is taken
SUSTAINED_DECREMENT = 1e-5
DECREMENT_NOISE = 1e-7  # what the integration itself may add
SHRINKING = 0.999  # a peak this much lower than the last counts as shrinking


@compiled
def damping_ratio(law, cells, c):
    """Linear damping ratio of steady sliding on the curve, (gamma + mu'(b)) / 2; NaN where the belt stands still."""
    belt = abs(cells[BELT, c])
    if belt == 0.0:
        return nan
    return 0.5 * (cells[GAMMA, c] + coefficient_slope(law, cells, c, belt))


@compiled(inline=True)
def start_book(law, s, i, cells, c):
    """Fresh slow state for cell c in lane i."""
    for row in range(SLOW, LANE_NUMBERS, WIDTH):
        s[row + i] = 0.0
    belt = cells[BELT, c]
    mu_belt = coefficient(law, cells, c, abs(belt))
    s[CELL + i] = c
    s[XI_STAR + i] = mu_belt if belt >= 0.0 else -mu_belt
    s[BAND + i] = BAND_SHARE * (cells[A1, c] + cells[A3, c])
    s[SLIP_START + i], s[CYCLE_START + i], s[MU_TURN + i], s[ENTERED + i] = nan, nan, nan, -inf
    s[PEAK + i], s[PEAK_BEFORE + i], s[LOOP_COUNT + i], s[LOOP_DECREMENT + i] = inf, inf, -1.0, -inf
    s[RELEASE_CHANGE + i] = inf
    reset_extrema(s, i)


@compiled
def reset_extrema(s, i):
    """Forget the extrema so far."""
    s[XI_HIGH + i], s[XI_LOW + i], s[W_HIGH + i], s[DW_HIGH + i] = -inf, inf, 0.0, 0.0


# --- extrema --------------------------------------------------------------------------------------------------------


@compiled(inline=True)
def note_ends(s, i, u, w, dw):
    """Let a state that begins or ends a phase count towards the extrema."""
    xi = s[SIGMA + i] * u
    s[XI_HIGH + i], s[XI_LOW + i] = max(s[XI_HIGH + i], xi), min(s[XI_LOW + i], xi)
    s[W_HIGH + i], s[DW_HIGH + i] = max(s[W_HIGH + i], w), max(s[DW_HIGH + i], abs(dw))


@compiled(inline=True)
def record_extrema(s, i, results, h, y1, w1, dw1, jerk1):
    """Extrema of u, w and w' between the start of the step of lane i and the state after h."""
    w0, dw0, jerk0, b, at_end = s[W + i], s[DW + i], s[JERK + i], s[B + i], (w1, dw1, jerk1, 0.0)
    if dw0 * dw1 < 0.0 and max(w0, w1) + reach(dw0, dw1, h) >= s[W_TOP + i]:
        top = extreme_speed(s, i, h, at_end, FOR_A_VALUE)[1]
        s[W_HIGH + i] = max(s[W_HIGH + i], top)
        if dw0 > 0.0:
            note_peak(s, i, top - b)
    if jerk0 * jerk1 < 0.0 and max(abs(dw0), abs(dw1)) + reach(jerk0, jerk1, h) >= s[DW_TOP + i]:
        steepest = extreme_slope(s, i, h, at_end)
        s[DW_HIGH + i] = max(s[DW_HIGH + i], abs(steepest))
    if (w0 > b) != (w1 > b):  # u' = b - w changes sign
        t, rise, work = arrival(s, i, b, 1.0 if w1 > b else -1.0, h, at_end)
        u = s[Y + i] + rise - s[G + i] * b + s[OFFSET + i]
        if note_turn(s, i, s[SIGMA + i] * u):
            compare_loops(s, i, results, s[TAU + i] + t, s[HEAT + i] + work, s[SIGMA + i] * u)


@compiled(inline=True)
def show_tops(s, i):
    """Tell the lanes which extrema are worth a look; on a hysteretic curve every peak is, for `is_shrinking`.

    Extrema of u may pass until the next comparison of loops is due.
    """
    s[W_TOP + i] = s[W_HIGH + i] if s[W_MIN + i] == 0.0 else -inf
    s[DW_TOP + i] = s[DW_HIGH + i]
    to_y = s[G + i] * s[B + i] - s[OFFSET + i]
    s[Y_HIGH + i], s[Y_LOW + i] = s[XI_HIGH + i] + to_y, s[XI_LOW + i] + to_y
    may_pass = s[SIGMA + i] > 0.0 and s[LOOP_COUNT + i] >= 0.0
    s[QUIET_GIVEN + i] = 2.0 * (LOOPS - 1.0 - s[LOOP_COUNT + i]) if may_pass else 0.0
    s[QUIET + i] = s[QUIET_GIVEN + i]


@compiled(inline=True)
def count_quiet_turns(s, i):
    """Count the extrema of u that passed without a look: in turn above and below the equilibrium, beyond the band."""
    turns = s[QUIET_GIVEN + i] - s[QUIET + i]
    if turns > 0.0:
        last = 1.0 if s[W + i] > s[B + i] else -1.0
        first = last if turns % 2.0 == 1.0 else -last
        s[CROSSED + i] += turns if first * s[SIDE_LAST + i] < 0.0 else turns - 1.0
        s[LOOP_COUNT + i] += 0.5 * turns if turns % 2.0 == 0.0 else 0.5 * (turns + last)
        s[SIDE_LAST + i], s[QUIET_GIVEN + i] = last, s[QUIET + i]


@compiled
def note_peak(s, i, height):
    """A peak of the slip speed, `height` above the belt speed."""
    s[PEAK_BEFORE + i], s[PEAK + i] = s[PEAK + i], height


@compiled
def note_turn(s, i, xi):
    """An extremum of xi: the range, the crossing of the equilibrium, the loop. Whether to compare loops now."""
    s[XI_HIGH + i], s[XI_LOW + i] = max(s[XI_HIGH + i], xi), min(s[XI_LOW + i], xi)
    distance = xi - s[XI_STAR + i]
    if abs(distance) > s[BAND + i]:
        side = 1.0 if distance > 0.0 else -1.0
        if side * s[SIDE_LAST + i] < 0.0:
            s[CROSSED + i] += 1.0
        s[SIDE_LAST + i] = side
    if distance <= 0.0:
        return False
    s[LOOP_COUNT + i] += 1.0
    return s[LOOP_COUNT + i] == 0.0 or s[LOOP_COUNT + i] == LOOPS


@compiled
def compare_loops(s, i, results, tau, heat, xi):
    """At the first maximum of xi, and ten loops after each look: sustained if the log decrement is zero and stays so.

    A motion that leaves an unstable cycle also starts with a decrement near zero, which then grows: two looks in a row
    tell them apart.
    """
    amplitude = xi - s[XI_STAR + i]
    decrement = abs(log(s[LOOP_AMPLITUDE + i] / amplitude)) / LOOPS if s[LOOP_COUNT + i] == LOOPS else inf
    if decrement < SUSTAINED_DECREMENT and decrement <= s[LOOP_DECREMENT + i] + DECREMENT_NOISE:
        c = int(s[CELL + i])
        results[PERIOD, c] = (tau - s[LOOP_TAU + i]) / LOOPS
        results[CYCLE_STICK_TIME, c] = 0.0
        results[CYCLE_HEAT, c] = (heat - s[LOOP_HEAT + i]) / LOOPS
        decide(s, i, results, SUSTAINED, OSCILLATION_SUSTAINED)
    s[LOOP_DECREMENT + i] = decrement if decrement < SUSTAINED_DECREMENT else -inf
    s[LOOP_AMPLITUDE + i], s[LOOP_TAU + i], s[LOOP_HEAT + i] = amplitude, tau, heat
    s[LOOP_COUNT + i] = 0.0


@compiled(inline=True)
def note_side(s, i, xi):
    """Remember on which side of the equilibrium a slip starts."""
    distance = xi - s[XI_STAR + i]
    if abs(distance) > s[BAND + i]:
        s[SIDE_LAST + i] = 1.0 if distance > 0.0 else -1.0


# --- settling -------------------------------------------------------------------------------------------------------


@compiled(inline=True)
def proven_radius(law, s, i, mode, b):
    """Radius of the disc about steady sliding, in the plane (u, u'), from which the motion provably settles.

    With V = (u - u*)^2 + u'^2, V' = -2 u'^2 (gamma + mu'(somewhere between w and b)). As mu' grows with w, V falls for
    ever once the disc lies where gamma + mu' > 0 (w > v_H), where w > 0, and where the mode cannot change. On a
    hysteretic curve below its minimum the mode changes where w' = 0, and the disc only tells when to ask
    `creeps_in`.
    """
    if b <= 0.0 or s[DECIDED + i] > 0.0 or drag_at(law, s, i, b) <= 0.0:
        return 0.0
    if mode == RISE and s[W_MIN + i] > 0.0:
        return min(s[BAND + i], b) if s[W_MIN + i] > b and drag_at(law, s, i, b) >= 2.0 else 0.0
    return max(0.0, min(s[BAND + i], b - max(s[W_STABLE + i], s[W_MIN + i])))


@compiled
def drag_at(law, s, i, w):
    """gamma + mu'(w) under the law of the present mode."""
    z, drop, exponent, rate = s[RATE + i] * w, s[DROP + i], s[EXPONENT + i], s[RATE + i]
    x = drop * shape(law, z, exponent)
    return s[G + i] + s[SLOPE + i] + rate * weakening_slope(law, z, x, drop, exponent)


@compiled
def creeps_in(law, s, i):
    """Whether w grows towards b on the curve for ever, never passing it.

    With q = w - b, p = u - u* and F(q) = (gamma + mu')(between w and b) q: p' = -q, q' = p - F(q). As long as q < 0, q'
    cannot change its sign (where q' = 0, q'' = -q). And q stays negative beyond the eigenvector of the faster of two
    real rates f, f^2 - d f + 1 = 0, d being the least drag on the way, which is that at w where the slope of the curve
    only grows.
    """
    p, q = s[Y + i] - s[Y_STAR + i], s[W + i] - s[B + i]
    drag = drag_at(law, s, i, s[W + i])
    if q > 0.0 or drag < 2.0 or s[RATE + i] * s[W + i] < inflection(law, s[EXPONENT + i]):
        return False
    fast = 0.5 * drag + (0.25 * drag * drag - 1.0) ** 0.5
    return q >= fast * p


@compiled(inline=True)
def check_settling(law, s, i, results):
    """Inside the disc of `proven_radius` the motion has settled; where the mode may yet change, if it creeps in."""
    p, q = s[Y + i] - s[Y_STAR + i], s[W + i] - s[B + i]
    may_change = s[MODE + i] == RISE and s[W_MIN + i] > 0.0
    if p * p + q * q < s[RADIUS2 + i] and (not may_change or creeps_in(law, s, i)):
        note_ring_down(law, s, i)
        decide_settled(s, i, results, s[ENTERED + i])


# --- the settling band ----------------------------------------------------------------------------------------------


@compiled(inline=True)
def note_entry(s, i, h, y1, w1):
    """Note when, between the start of the step of lane i and the state after h, the motion came into the band."""
    b, band2 = s[B + i], s[BAND2 + i]
    p0, p1, q0, q1 = s[Y + i] - s[Y_STAR + i], y1 - s[Y_STAR + i], s[W + i] - b, w1 - b
    if not (p0 * p0 + q0 * q0 >= band2 and p1 * p1 + q1 * q1 < band2):
        return
    outside, inside, t = 0.0, h, h
    for _ in range(60):
        dw = speed(s, i, t)[1]
        w, rise, _ = rise_and_work(s, i, t)
        p, q = p0 + rise, w - b
        excess, slope = p * p + q * q - band2, 2.0 * q * (dw - p)  # p' = b - w = -q
        if excess < 0.0:
            inside = t
        else:
            outside = t
        new = t - excess / slope
        if abs(new - t) <= 1e-9 * h:
            break
        t = new if outside < new < inside else 0.5 * (outside + inside)
    s[ENTERED + i] = s[TAU + i] + t


@compiled
def note_entry_at_constant_speed(s, i, tau, u, w, b, duration):
    """The same for a stick or hold phase that starts at tau: u moves at b - w >= 0."""
    p0, q2 = u - s[SIGMA + i] * s[XI_STAR + i], (w - b) ** 2
    p1, band2 = p0 + (b - w) * duration, s[BAND2 + i]
    if p0 * p0 + q2 >= band2 and p1 * p1 + q2 < band2:
        s[ENTERED + i] = tau - (p0 + (band2 - q2) ** 0.5) / (b - w)


@compiled
def is_shrinking(s, i, cells, u, w, b):
    """Whether a trough below v_min, with its peak, lies inside the band and the peaks shrink.

    Near steady sliding on the hysteretic curve the motion is a chain of straight pieces, the same at every scale: peaks
    then shrink by a constant factor. Small against b and a4 so that the curve is straight over the loop.
    """
    small = min(s[BAND + i], 0.05 * min(b, cells[A4, int(s[CELL + i])]))
    near = (u - s[SIGMA + i] * s[XI_STAR + i]) ** 2 + (w - b) ** 2 < s[BAND2 + i]
    near = near and b - w < small and s[PEAK + i] < small
    return near and s[PEAK + i] < SHRINKING * s[PEAK_BEFORE + i]


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
def note_ring_down(law, s, i):
    """Extrema still to come once the motion has settled, where it is the linear oscillator to one part in 10^4.

    An approach that stays inside the settling band may yet overshoot there, and its limit belongs to the range.
    """
    b = s[B + i]
    zeta = 0.5 * drag_at(law, s, i, b)
    u_star = s[Y_STAR + i] - s[G + i] * b + s[OFFSET + i]
    note_ends(s, i, u_star, b, 0.0)
    p = ring_extremum(s[Y + i] - s[Y_STAR + i], b - s[W + i], zeta)
    q = ring_extremum(s[W + i] - b, s[DW + i], zeta)
    note_ends(s, i, u_star + p, b + q, 0.0)
    note_ends(s, i, u_star + ring_extremum(p, 0.0, zeta), b + ring_extremum(q, 0.0, zeta), 0.0)


# --- verdicts -------------------------------------------------------------------------------------------------------


@compiled
def decide(s, i, results, regime, status):
    """Write the verdict and the metrics of the motion; extrema are not recorded from here on.

    The status stays NOT_RUN until the cell is finished, so that an interrupted one counts as not computed.
    """
    c = int(s[CELL + i])
    results[REGIME, c] = regime
    results[XI_MAX, c], results[XI_MIN, c] = s[XI_HIGH + i], s[XI_LOW + i]
    results[SPEED_MAX, c], results[ACCELERATION_MAX, c] = s[W_HIGH + i], s[DW_HIGH + i]
    results[MU_REVERSAL, c], results[CROSSINGS, c] = s[MU_TURN + i], s[CROSSED + i]
    s[DECIDED + i], s[DECIDED_BY + i] = 1.0, status
    s[MARK + i], s[RADIUS2 + i], s[BAND2 + i] = 0.0, 0.0, 0.0


@compiled
def decide_settled(s, i, results, entered):
    """The motion has come into the settling band for good: damped if it crossed the equilibrium twice, creep if not."""
    results[SETTLING_TIME, int(s[CELL + i])] = max(entered - s[SLIP_START + i], 0.0)
    decide(s, i, results, DAMPED if s[CROSSED + i] >= 2.0 else CREEP, SETTLED)


@compiled(inline=True)
def decide_cycle(s, i, results, tau, stick_time):
    """Break-away to break-away: stick-slip, with one stick phase in the cycle."""
    c = int(s[CELL + i])
    results[PERIOD, c], results[CYCLE_STICK_TIME, c] = tau - s[CYCLE_START + i], stick_time
    results[CYCLE_HEAT, c] = s[HEAT + i] - s[HEAT_START + i]
    decide(s, i, results, STICK_SLIP, CYCLE_CLOSED)


@compiled
def finish(s, i, results, regime, status, xi, eta):
    """Close the cell: status, counters and final state; `regime` holds only where none was decided before."""
    c = int(s[CELL + i])
    if s[DECIDED + i] == 0.0:
        results[REGIME, c] = regime
        results[CROSSINGS, c] = s[CROSSED + i]
    results[STATUS, c] = status
    results[STEPS, c] = s[TRIED + i]
    results[STICKS, c], results[STICK_TIME, c] = s[STICK_COUNT + i], s[STICK_SUM + i]
    results[XI_END, c], results[ETA_END, c] = xi, eta
