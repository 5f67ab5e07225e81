"""Slip along a straight line of friction, in closed form however steep: the mode `fall` of the hysteretic curve.

With drag = gamma + slope of the line, and B, alpha as in `layout.py`,

    w'' + drag w' + w = B + alpha t

On a steady belt q = w - b is a linear oscillator and the end of the fall a closed form too. On a belt that accelerates
ends are searched for interval by interval. A slip that such a drive reverses soon after break-away leaves the curve at
a tiny w, and its line is so steep that no step could follow it: there the motion is what is added to the state at the
start, with push = B - w, so that nothing cancels.
"""

from math import atan2, cos, exp, expm1, inf, log1p, pi, sin
from typing import NamedTuple

from ... import layout as at
from ... import observers
from ...dense import gauss
from ...drive import Segments, belt_in_lane, by_drive, next_segment, pass_time, segment_is_over
from ...jit import compiled
from ...layout import DONE, RUNNING
from ...roots import LEVEL_REACHED, NO_EVENT, TURNED
from .friction import coefficient, line_slope
from .slip import enter_curve
from .stick import first_passage, is_above, stick

MOST_HALVINGS = 200
NODES, WEIGHTS = gauss(10)  # exact to rounding for the square of a sine over half a turn
LONGEST = 0.5  # time examined at once on a belt that accelerates: well below half a turn
SERIES_REACH = 1.2  # of drag t; beyond it, within LONGEST, the motion is overdamped
TERMS = 24
MOST_TRIES = 100


class Line(NamedTuple):
    """The line mu_stop + slope w; drag = gamma + slope."""

    mu_stop: float
    slope: float
    drag: float


# --- on any belt: here for the steady one, below for segments ---------------------------------------------------------


@by_drive
def along_line(m, i, w, v, drag, t):
    """w and w' after a time t, from w and w' = v at the present state of lane i."""
    b = m.s[at.B + i]
    q, v = oscillation(w - b, v, drag, t)
    return b + q, v


@by_drive
def end_on_line(m, i, w, v, drag, longest):
    """Return what ends a fall (v <= 0) and when: w = 0 (LEVEL_REACHED), a trough of w (TURNED), or nothing.

    Looks no further than `longest` where the belt accelerates.
    """
    return end_of_fall(w - m.s[at.B + i], v, drag, m.s[at.B + i])


@along_line.of(Segments)
def _along_line_on_segment(m, i, w, v, drag, t):
    w, v, _, _ = motion(w, v, m.s[at.B + i] - w, m.s[at.ALPHA + i], drag, t)
    return w, v


@end_on_line.of(Segments)
def _end_on_segment(m, i, w, v, drag, longest):
    return end_within(w, v, m.s[at.B + i] - w, m.s[at.ALPHA + i], drag, longest)


@compiled(inline=True)
def first_stretch(drag):
    """Return how far to look at once: a time in which the fastest part of the motion on a line decays little."""
    return min(0.5 / abs(drag), LONGEST)


# --- on a steady belt -----------------------------------------------------------------------------------------------


@compiled
def oscillation(q, v, drag, t):
    """q = w - b and v = w' after a time t: both kinds of roots so that nothing overflows or cancels."""
    half = 0.5 * drag
    discriminant = half * half - 1.0
    if discriminant < 0.0:
        omega = (-discriminant) ** 0.5
        decay = exp(-half * t)
        c, s = decay * cos(omega * t), decay * sin(omega * t) / omega
    else:
        root = discriminant**0.5
        fast = half + root if half > 0.0 else half - root  # the rate further from zero; the other is its inverse
        gap = fast - 1.0 / fast
        slow_decay = exp(-t / fast)
        c = 0.5 * (slow_decay + exp(-fast * t))
        s = slow_decay * (-expm1(-gap * t) / gap if gap != 0.0 else t)
    return q * c + (v + half * q) * s, v * c - (q + half * v) * s


@compiled
def turn_time(q, v, drag):
    """When v next vanishes; inf if never again."""
    half = 0.5 * drag
    discriminant = half * half - 1.0
    if discriminant < 0.0:
        omega = (-discriminant) ** 0.5
        phase = atan2(omega * v, q + half * v)
        if phase <= 0.0:  # half a turn on, without rounding by adding pi: near critical damping it is tiny
            phase = atan2(-omega * v, -(q + half * v))
        return (phase if phase > 0.0 else pi) / omega
    root = discriminant**0.5
    fast = half + root if half > 0.0 else half - root
    gap = fast - 1.0 / fast
    if q + v / fast == 0.0:
        return inf
    ratio = v / (q + v / fast)
    if not ratio * gap > -1.0:
        return inf
    t = log1p(ratio * gap) / gap if gap != 0.0 else ratio
    return t if t > 0.0 else inf


@compiled
def level_time(q, v, drag, level, latest):
    """When q, falling all the way to `latest`, reaches `level`, which the caller knows. By safeguarded Halley."""
    low, high, t, q1, v1 = 0.0, latest, 0.0, q, v
    for _ in range(MOST_HALVINGS):
        f = q1 - level
        if f > 0.0:
            low = t
        else:
            high = t
        square, curving = v1 * v1, -0.5 * f * (drag * v1 + q1)  # q'' = -drag v - q
        new = t - f * v1 / (square - curving)
        # Near a turn, where the slope vanishes, the method would find that; false for NaN as well.
        if not (abs(curving) < 0.5 * square and low <= new <= high):
            new = 0.5 * (low + high)
        elif abs(new - t) <= 1e-6 * t:  # what Halley's method leaves is about the cube of its last correction
            return new
        if new == t or high - low <= 1e-16 * high:
            break
        t = new
        q1, v1 = oscillation(q, v, drag, t)
    return t


@compiled
def end_of_fall(q, v, drag, b):
    """Return what ends a fall on a belt at b, and after what time; nothing, inf if w only tends to b.

    At a trough w'' = b - w > 0: only below the belt speed.
    """
    turn = turn_time(q, v, drag)
    if turn == inf:
        if b > 0.0 and drag > 0.0:
            return NO_EVENT, inf
        latest = 1.0
        while oscillation(q, v, drag, latest)[0] > -b and latest < 1e300:
            latest *= 2.0
        return (LEVEL_REACHED, level_time(q, v, drag, -b, latest)) if latest < 1e300 else (NO_EVENT, inf)
    if oscillation(q, v, drag, turn)[0] > -b:
        return TURNED, turn
    return LEVEL_REACHED, level_time(q, v, drag, -b, turn)


@compiled
def distance2(q, v, drag, shift):
    """Squared distance, in the plane (u, u'), from a point at w = b and `shift` below steady sliding on the line."""
    p = v + drag * q + shift
    return p * p + q * q


@compiled
def entry_time(q, v, drag, shift, radius2, latest):
    """When the motion, outside a disc now and inside at `latest`, came into it."""
    outside, inside = 0.0, latest
    for _ in range(MOST_HALVINGS):
        t = 0.5 * (outside + inside)
        q1, v1 = oscillation(q, v, drag, t)
        if distance2(q1, v1, drag, shift) < radius2:
            inside = t
        else:
            outside = t
        if inside - outside <= 1e-15 * inside:
            break
    return inside


@compiled
def square_integral(q, v, drag, t):
    """Integral of q^2 over the next time t."""
    q1, v1 = oscillation(q, v, drag, t)
    if abs(drag) > 1e-3:  # q^2 + (v + drag q)^2 loses 2 drag q^2 per time
        return 0.5 * (distance2(q, v, drag, 0.0) - distance2(q1, v1, drag, 0.0)) / drag
    total = 0.0
    for node in range(len(NODES)):
        q1 = oscillation(q, v, drag, NODES[node] * t)[0]
        total += WEIGHTS[node] * q1 * q1
    return t * total


# --- on a belt that accelerates ------------------------------------------------------------------------------------


@compiled
def response(drag, t):
    """s', s, its integral and the integral of that after t, where s'' + drag s' + s = 0, s(0) = 0, s'(0) = 1."""
    if abs(drag) * t > SERIES_REACH:
        half = 0.5 * drag
        root = (half * half - 1.0) ** 0.5
        fast = half + root if half > 0.0 else half - root  # the rate further from zero; the other is its inverse
        slow = 1.0 / fast
        gap, slow_decay, fast_decay = fast - slow, exp(-slow * t), exp(-fast * t)
        once = (expm1(-fast * t) / fast - expm1(-slow * t) / slow) / gap
        twice = t * t * (second_phi(-slow * t) - second_phi(-fast * t)) / gap
        return (fast * fast_decay - slow * slow_decay) / gap, (slow_decay - fast_decay) / gap, once, twice
    before, term = 0.0, 1.0  # of the series of s, over t
    speed, way, once, twice = 0.0, 0.0, 0.0, 0.0
    for n in range(1, TERMS):
        speed += n * term
        way += term
        once += term / (n + 1)
        twice += term / ((n + 1) * (n + 2))
        before, term = term, -t * (drag * term + before * t / n) / (n + 1)
    return speed, t * way, t * t * once, t * t * t * twice


@compiled
def second_phi(x):
    """(e^x - 1 - x)/x^2."""
    if abs(x) > SERIES_REACH:
        return (expm1(x) - x) / (x * x)
    total = 1.0
    for n in range(TERMS, 2, -1):
        total = 1.0 + total * x / n
    return 0.5 * total


@compiled
def motion(w, v, push, alpha, drag, t):
    """w, w', w'' and w''' after t, from w, w' = v and push = B - w at the start."""
    ds, s, once, twice = response(drag, t)
    dw = v * ds + push * s + alpha * once
    jerk = push * ds - v * (drag * ds + s) + alpha * s
    return w + v * s + push * once + alpha * twice, dw, jerk, alpha - dw - drag * jerk


@compiled
def zero(order, w, v, push, alpha, drag, high):
    """When the derivative of w of this order (0, 1, 2), monotone up to `high`, passes zero. By safeguarded Newton."""
    low, t, rises = 0.0, high, motion(w, v, push, alpha, drag, high)[order] > 0.0
    for _ in range(MOST_TRIES):
        there = motion(w, v, push, alpha, drag, t)
        if (there[order] > 0.0) == rises:
            high = t
        else:
            low = t
        new = t - there[order] / there[order + 1]
        if not low < new < high:
            new = 0.5 * (low + high)
        if abs(new - t) <= 1e-15 * t:
            break
        t = new
    return t


@compiled
def steepest(w, v, push, alpha, drag, h):
    """When w' is extremal within h; h if it is not."""
    after = motion(w, v, push, alpha, drag, h)[2]
    return zero(2, w, v, push, alpha, drag, h) if (push - drag * v) * after < 0.0 else h


@compiled
def end_within(w, v, push, alpha, drag, h):
    """Return what ends a fall (v <= 0) within h, and when: w = 0 (LEVEL_REACHED), a trough of w (TURNED), nothing."""
    end = h
    turned = motion(w, v, push, alpha, drag, h)[1] > 0.0
    if not turned and push - drag * v > 0.0:  # w' may have been positive in between
        end = steepest(w, v, push, alpha, drag, h)
        turned = motion(w, v, push, alpha, drag, end)[1] > 0.0
    end = zero(1, w, v, push, alpha, drag, end) if turned else h
    if motion(w, v, push, alpha, drag, end)[0] <= 0.0:
        return LEVEL_REACHED, zero(0, w, v, push, alpha, drag, end)
    return (TURNED if turned else NO_EVENT), end


# --- down the line (fall), and at constant speed between line and curve (hold) ----------------------------------------
# Over as many segments of the drive as they last; u, w, b are displacement, slip speed and belt speed in the frame of
# `layout.py`, and alpha + u + gamma u' is the load.


CURVE, LINE, DRIVE_OVER = range(3)  # what ends a hold


@compiled(inline=True)
def displacement_on_line(m, i, line, w, dw):
    """u of lane i from the equation of motion, friction being that of the line."""
    b = belt_in_lane(m, i, 0.0)
    return line.mu_stop + line.slope * w + dw - m.s[at.ALPHA + i] - m.s[at.G + i] * (b - w)


@compiled
def fall(m, i, u, w, dw):
    """From (u, w) on, w' = dw <= 0, friction follows the line to (0, mu_stop), Eq. (2a), until w or w' is zero.

    A trough of w on the line leads up the curve; where that lies above, at constant speed until the load has risen
    to it or fallen back to the line (`hold`).
    """
    s, cells, c = m.s, m.cells, int(m.s[at.CELL + i])
    slope = line_slope(w, coefficient(m.law, cells, c, w), cells[at.MU_STOP, c])
    line = Line(cells[at.MU_STOP, c], slope, s[at.G + i] + slope)
    h = first_stretch(line.drag)
    s[at.MODE + i] = at.FALL
    while True:
        alpha, left = m.s[at.ALPHA + i], s[at.TAU_END + i] - s[at.TAU + i]
        kind, t = end_on_line(m, i, w, dw, line.drag, min(h, left))
        if observers.stays_on_line(m, i, line, u, w, dw, kind, t):
            return DONE
        if t >= left:
            kind, t = NO_EVENT, left
        observers.observe_line(m, i, line, u, w, dw, t)
        w, dw = along_line(m, i, w, dw, line.drag, t)
        pass_time(m, i, t)
        if kind == LEVEL_REACHED:
            observers.observe_standstill(m, i, dw)
            return stick(m, i, displacement_on_line(m, i, line, 0.0, dw), True)
        h = min(2.0 * h, LONGEST)
        u = displacement_on_line(m, i, line, w, dw)
        if kind == NO_EVENT and segment_is_over(s, i):
            if not next_segment(m, i):
                return observers.finish(m, i, at.HORIZON_REACHED, u, belt_in_lane(m, i, 0.0) - w)
            dw += m.s[at.ALPHA + i] - alpha
            h = first_stretch(line.drag)
        if kind == TURNED or dw > 0.0:
            observers.observe_trough(m, i, u, w)
            if observers.is_over(m, i):
                return observers.finish(m, i, s[at.DECIDED_BY + i], u, belt_in_lane(m, i, 0.0) - w)
            mu_line, mu_curve = line.mu_stop + slope * w, coefficient(m.law, cells, c, w)
            onto = CURVE
            if mu_curve > mu_line:
                onto, u, dw = hold(m, i, u, w, dw if kind != TURNED else 0.0, mu_line, mu_curve)
            if onto == DRIVE_OVER:
                return observers.finish(m, i, at.HORIZON_REACHED, u, belt_in_lane(m, i, 0.0) - w)
            if onto == CURVE:
                enter_curve(m, i, at.RISE if w < s[at.W_MIN + i] else at.FAST, u, w, mu_curve > mu_line and dw == 0.0)
                return RUNNING
            s[at.MODE + i] = at.FALL
            h = first_stretch(line.drag)


@compiled
def hold(m, i, u, w, dw, mu_line, mu_curve):
    """Constant slip speed w while the load lies between line and curve: the exact (Filippov) solution.

    On the line, where w' would be dw, the speed would rise; on the curve it would fall. Returns what the load has come
    to, u, and w' there, which is zero but where a jump of the load ends the hold.
    """
    s, gamma, load = m.s, m.s[at.G + i], mu_line + dw
    s[at.MODE + i] = at.HOLD
    while True:
        b, alpha = belt_in_lane(m, i, 0.0), m.s[at.ALPHA + i]
        rate, left = b - w + gamma * alpha, s[at.TAU_END + i] - s[at.TAU + i]
        up = first_passage(load, rate, alpha, mu_curve, 0.0, 1.0, left)
        down = first_passage(-load, -rate, -alpha, -mu_line, 0.0, 1.0, left)
        t = min(up, down, left)
        observers.observe_constant_speed(m, i, u, b, w, t)
        u += t * (b - w + 0.5 * alpha * t)
        pass_time(m, i, t)
        if min(up, down) < inf and not segment_is_over(s, i):
            over = load - mu_curve if up <= down else mu_line - load
            jump = over if is_above(over, alpha, mu_curve if up <= down else mu_line) else 0.0
            return (CURVE, u, jump) if up <= down else (LINE, u, -jump)
        load += t * (rate + 0.5 * alpha * t) - alpha
        if not next_segment(m, i):
            return DRIVE_OVER, u, 0.0
        load += m.s[at.ALPHA + i]
