"""The friction oscillator once more, for speed and sharpness: the motion of one cell in kernel units, event by event.

No code in common with the kernels. Slip on the curve is stepped by SciPy's DOP853 pair, with steps that never carry
the slip speed over the steep part of the curve; events are located by stepping again from the start of the step. Stick,
the line of the hysteretic curve and hold are closed forms. The state is (p, w) in the frame of the present sliding
direction sigma, B = sigma b: w = |b - xi'|, and p = sigma xi + gamma B - mu(0) is the load beyond the friction at
w = 0, so that p' = B - w and w' = p - gamma w + mu(0) - mu(w), without cancellation where the contact breaks away.

All that is compiled stands in this one file, so that Numba's cache sees every edit.
"""

from math import atan2, atanh, cos, exp, expm1, inf, isnan, log, log1p, nan, pi, sin, sqrt

import numpy as np
from numba import njit
from scipy.integrate._ivp import dop853_coefficients as dop853

# Rows of a cell; LAW is the position in LAWS
BELT, GAMMA, A1, A2, A3, A4, DELTA, LAW, STATIC, STOP, AGEING, AGE_TIME, CONTACT, XI0, ETA0 = range(15)
CELL_ROWS = 15
LAWS = ("stribeck", "stribeck_delta", "rational", "cubic")

# Answers
(
    REGIME, BREAKAWAY_TIME, RESTICK_TIME, RESTICK_XI, PERIOD, STICK_TIME, XI_MAX, XI_MIN, SPEED_MAX, ACCELERATION_MAX,
    HEAT_PER_CYCLE, LOOPS_PER_CYCLE, DECREMENT, STEPS, BREAKAWAYS,
) = range(15)  # fmt: skip
ANSWERS = 15
UNDECIDED, STICK_SLIP, SETTLES, RINGS, STUCK = range(5)

# State of the motion, and what is remembered of it
(
    TAU, P, W, HEAT, SIGMA, STEP, TAKEN, BIRTH, STUCK_FOR, RELEASES, W_MIN, RADIUS, STIFFEST, AMPLITUDE, RATIO, QUIET,
    LOOP_TAU, LOOP_HEAT,
) = range(18)  # fmt: skip
STATES = 18
HIGH, LOW, FASTEST, HARDEST = range(4)  # of a book of extrema: xi, xi, w, |w'|
WHOLE, CYCLE, LOOP = range(3)  # books: since the first break-away or the start, since the last one, of a loop of slip
RELEASED_AT, RELEASED_P, RELEASED_STICK, RELEASED_HEAT = range(4)  # columns of the memory of break-aways
MEMORY = 8

SLIP_AGAIN, REST, FALL, TO_FAST, TO_RISE, DONE = range(6)  # what comes next
A, B_WEIGHTS, E3, E5 = dop853.A[:12, :12].copy(), dop853.B.copy(), dop853.E3.copy(), dop853.E5.copy()
LONGEST_STEP = 0.25
FLAT = 40.0  # e^-40 of the weakening is left there


# --- the friction curve ---


@njit(cache=True)
def weakened(c, w):
    """mu(0) - mu(w)."""
    z, delta, law = w / c[A4], c[DELTA], c[LAW]
    if law == 0:
        lost = -expm1(-z)
    elif law == 1:
        lost = -expm1(-(abs(z) ** delta))
    elif law == 2:
        lost = z / (1.0 + z)
    else:
        lost = 1.5 * z - 0.5 * z**3
    return c[A3] * lost - c[A2] * w


@njit(cache=True)
def slope_of_curve(c, w):
    """mu'(w)."""
    z, delta, law = w / c[A4], c[DELTA], c[LAW]
    if law == 0:
        slope = -exp(-z)
    elif law == 1:
        slope = -delta * abs(z) ** (delta - 1.0) * exp(-(abs(z) ** delta)) * (1.0 if z >= 0.0 else -1.0)
    elif law == 2:
        slope = -1.0 / (1.0 + z) ** 2
    else:
        slope = 1.5 * z * z - 1.5
    return c[A2] + c[A3] / c[A4] * slope


@njit(cache=True)
def room(c, w, share):
    """By how much w may change in a step that starts at w."""
    if c[A3] == 0.0:
        return inf
    z, law = w / c[A4], c[LAW]
    if law >= 2:
        return share * c[A4] * (1.0 + z)
    width = 1.0 if law == 0 else 1.0 / c[DELTA]
    end = FLAT**width
    return c[A4] * (share * width + 0.5 * max(0.0, z - end))


@njit(cache=True)
def speed_of_minimum(c):
    """Where the curve is lowest; 0 if it rises from the start, inf if it falls for ever."""
    if c[A3] <= 0.0:
        return 0.0
    if slope_of_curve(c, 1e9 * c[A4]) < 0.0 or (c[A2] == 0.0 and c[LAW] != 3):
        return inf
    low, high = 0.0, c[A4]
    falls = False
    for n in range(4000):  # the last fall on a fine grid over the weakening
        w = c[A4] * 1e-4 * (1.01**n - 1.0)
        if slope_of_curve(c, w) < 0.0:
            low, high, falls = w, c[A4] * 1e-4 * (1.01 ** (n + 1) - 1.0), True
    if not falls:
        return 0.0
    for _ in range(200):
        middle = 0.5 * (low + high)
        if slope_of_curve(c, middle) < 0.0:
            low = middle
        else:
            high = middle
    return 0.5 * (low + high)


# --- slip on the curve: w' and w'', one step, its control ---


@njit(cache=True)
def rate(c, p, w):
    """w'."""
    return p - c[GAMMA] * w + weakened(c, w)


@njit(cache=True)
def bend(c, belt, p, w):
    """w''."""
    return belt - w - (c[GAMMA] + slope_of_curve(c, w)) * rate(c, p, w)


@njit(cache=True)
def step(c, belt, p, w, heat, h, k):
    """A step of DOP853: p, w, heat after h, and the error of p and w in units of their own size and change."""
    mu0 = c[A1] + c[A3]
    for i in range(12):
        dp, dw, dq = 0.0, 0.0, 0.0
        for j in range(i):
            a = A[i, j]
            dp += a * k[j, 0]
            dw += a * k[j, 1]
        pi_, wi = p + h * dp, w + h * dw
        d = weakened(c, wi)
        k[i, 0], k[i, 1], k[i, 2] = belt - wi, pi_ - c[GAMMA] * wi + d, (mu0 - d) * wi
    dp, dw, dq = 0.0, 0.0, 0.0
    for i in range(12):
        b = B_WEIGHTS[i]
        dp, dw, dq = dp + b * k[i, 0], dw + b * k[i, 1], dq + b * k[i, 2]
    p1, w1 = p + h * dp, w + h * dw
    k[12, 0], k[12, 1] = belt - w1, rate(c, p1, w1)
    five, three = 0.0, 0.0
    for component in range(2):
        e5, e3 = 0.0, 0.0
        for i in range(13):
            e5 += E5[i] * k[i, component]
            e3 += E3[i] * k[i, component]
        size = max(abs(p), abs(p1)) if component == 0 else max(abs(w), abs(w1))
        size = max(size, 1e-300)
        five += (e5 / size) ** 2
        three += (e3 / size) ** 2
    if not (five < inf and three < inf):
        return p1, w1, heat + h * dq, inf
    error = 0.0 if five == 0.0 else abs(h) * five / sqrt((five + 0.01 * three) * 2.0)
    return p1, w1, heat + h * dq, error


@njit(cache=True)
def longest(c, belt, p, w, share):
    """The longest step that keeps w inside its room and follows the fastest rate of the curve."""
    allowed = room(c, w, share)
    speeding, bending = abs(rate(c, p, w)), abs(bend(c, belt, p, w))
    h = min(LONGEST_STEP, 2.0 / (1e-300 + abs(c[GAMMA] + slope_of_curve(c, w))))
    if allowed < inf and speeding + bending > 0.0:
        h = min(h, 2.0 * allowed / (speeding + sqrt(speeding**2 + 2.0 * bending * allowed)))
    return h


@njit(cache=True)
def quantity(c, belt, p, w, kind, level):
    """What an event waits for: 0 w - level, 1 w', 2 w''."""
    if kind == 0:
        return w - level
    return rate(c, p, w) if kind == 1 else bend(c, belt, p, w)


@njit(cache=True)
def locate(c, belt, p, w, h, kind, level, k):
    """When within the next h the quantity changes its sign: regula falsi (Illinois) on steps from here, bisection."""
    left, at_left = 0.0, quantity(c, belt, p, w, kind, level)
    end = step(c, belt, p, w, 0.0, h, k)
    right, at_right = h, quantity(c, belt, end[0], end[1], kind, level)
    side = 0
    for n in range(200):
        t = (left * at_right - right * at_left) / (at_right - at_left)
        if n > 20 or not (left < t < right):
            t = 0.5 * (left + right)
        if not (left < t < right) or right - left <= 4e-16 * h:
            break
        there = step(c, belt, p, w, 0.0, t, k)
        value = quantity(c, belt, there[0], there[1], kind, level)
        if value == 0.0:
            return t
        if (value > 0.0) == (at_right > 0.0):
            right, at_right = t, value
            if side == 1:
                at_left *= 0.5
            side = 1
        else:
            left, at_left = t, value
            if side == -1:
                at_right *= 0.5
            side = -1
    return right


# --- linear motion q'' + d q' + q = 0, of q = w - B on a line ---


@njit(cache=True)
def linear(q, v, d, t):
    """(q, q') after t."""
    half = 0.5 * d
    x = half * half - 1.0
    if x < 1e-4:
        if x < -1e-4:
            omega = sqrt(-x)
            co, si = cos(omega * t), sin(omega * t) / omega
        else:  # near the double rate: series of cosh and sinh
            y = x * t * t
            if abs(y) > 1.0:
                root = sqrt(abs(x))
                co = (cos(root * t)) if x < 0.0 else 0.5 * (exp(root * t) + exp(-root * t))
                si = (sin(root * t) / root) if x < 0.0 else 0.5 * (exp(root * t) - exp(-root * t)) / root
            else:
                co, si, term = 1.0, t, 1.0
                for n in range(1, 14):
                    term *= y / (2 * n * (2 * n - 1))
                    co += term
                    si += term * t / (2 * n + 1)
        e = exp(-half * t)
        return e * ((co + half * si) * q + si * v), e * ((co - half * si) * v - si * q)
    root = sqrt(x)
    fast = half + root if half > 0.0 else half - root
    slow = 1.0 / fast
    es, ef = exp(-slow * t), exp(-fast * t)
    gap = fast - slow
    s = es * -expm1(-gap * t) / gap if gap > 0.0 else ef * expm1(gap * t) / gap
    return (fast * es - slow * ef) / gap * q + s * v, (fast * ef - slow * es) / gap * v - s * q


@njit(cache=True)
def turn_of_linear(q, v, d):
    """The first time > 0 at which q' = 0; inf if there is none."""
    half = 0.5 * d
    x = half * half - 1.0
    if x < 0.0:
        omega = sqrt(-x)
        angle = atan2(omega * v, half * v + q)
        return (angle if angle > 0.0 else angle + pi) / omega
    bottom = half * v + q
    root = sqrt(x)
    if x == 0.0:
        t = v / bottom if bottom != 0.0 else inf
        return t if t > 0.0 else inf
    tangent = root * v / bottom if bottom != 0.0 else inf
    return atanh(tangent) / root if 0.0 < tangent < 1.0 else inf


@njit(cache=True)
def time_of_level(q, v, d, level, latest):
    """When q, falling all the while, reaches the level, by bisection."""
    early, late = 0.0, latest
    for _ in range(1100):
        t = 0.5 * (early + late)
        if not early < t < late:
            break
        if linear(q, v, d, t)[0] > level:
            early = t
        else:
            late = t
    return late


@njit(cache=True)
def square_of_linear(q, v, d, t):
    """Integral of q^2 over the next t."""
    if abs(d) > 0.1:
        q1, v1 = linear(q, v, d, t)
        return -(q1 * q1 + v1 * v1 - q * q - v * v) / (2.0 * d) - (q1 * v1 - q * v) - 0.5 * d * (q1 * q1 - q * q)
    n = 4 + int(8 * t)
    total, h = 0.0, t / n
    for i in range(n):  # Gauss-Legendre of order 10 on each piece
        for x, weight in (
            (-0.906179845938664, 0.23692688505618908), (-0.5384693101056831, 0.47862867049936647),
            (0.0, 0.5688888888888889), (0.5384693101056831, 0.47862867049936647),
            (0.906179845938664, 0.23692688505618908),
        ):  # fmt: skip
            total += 0.5 * h * weight * linear(q, v, d, (i + 0.5 + 0.5 * x) * h)[0] ** 2
    return total


# --- books of extrema ---


@njit(cache=True)
def note(c, s, books, p, w, dw):
    """Let a state count towards the extrema."""
    xi = s[SIGMA] * (p + c[A1] + c[A3] - c[GAMMA] * s[SIGMA] * c[BELT])
    for book in range(3):
        books[book, HIGH], books[book, LOW] = max(books[book, HIGH], xi), min(books[book, LOW], xi)
        books[book, FASTEST], books[book, HARDEST] = max(books[book, FASTEST], w), max(books[book, HARDEST], abs(dw))


@njit(cache=True)
def forget(book):
    """Start a book of extrema again."""
    book[HIGH], book[LOW], book[FASTEST], book[HARDEST] = -inf, inf, 0.0, 0.0


@njit(cache=True)
def answer(s, out, regime, book, period, stick_time, heat, loops):
    """Write the verdict."""
    out[REGIME], out[PERIOD], out[STICK_TIME], out[HEAT_PER_CYCLE] = regime, period, stick_time, heat
    out[XI_MAX], out[XI_MIN], out[SPEED_MAX], out[ACCELERATION_MAX] = (
        book[HIGH],
        book[LOW],
        book[FASTEST],
        book[HARDEST],
    )
    out[LOOPS_PER_CYCLE], out[BREAKAWAYS] = loops, s[RELEASES]
    return DONE


# --- steady sliding ---


@njit(cache=True)
def prove_settling(c, s):
    """RADIUS of the disc about steady sliding in (sigma xi, w) from which the motion settles; STIFFEST drag in it.

    V = P^2 + q^2 has V' = -2 q F(q), F(q) = gamma q + mu(b + q) - mu(b): it falls wherever F(q)/q > 0.
    """
    belt = abs(c[BELT])
    edge = belt - s[W_MIN]
    s[RADIUS], s[STIFFEST] = 0.0, 0.0
    if edge <= 0.0:
        return
    for n in range(1, 500):
        r = edge * n / 500
        drag = c[GAMMA] - (weakened(c, belt + r) - weakened(c, belt)) / r
        other = c[GAMMA] - (weakened(c, belt) - weakened(c, belt - r)) / r
        if min(drag, other) <= 0.0:
            break
        s[RADIUS], s[STIFFEST] = r, max(s[STIFFEST], drag, other)
    s[RADIUS] *= 0.99
    drag = c[GAMMA] + slope_of_curve(c, belt)
    if drag <= 0.0:
        s[RADIUS] = 0.0


@njit(cache=True)
def settled(c, s, out, books):
    """Whether the motion on the curve has come to steady sliding for good, its extrema known."""
    belt = s[SIGMA] * c[BELT]
    if belt <= 0.0:
        return False
    q = s[W] - belt
    load = s[P] - c[GAMMA] * belt + weakened(c, belt)
    r = sqrt(load * load + q * q)
    drag = c[GAMMA] + slope_of_curve(c, belt)
    small = 1e-7 * min(c[A4], belt) if c[A3] != 0.0 else inf
    if s[W_MIN] > belt:  # below the minimum of the hysteretic curve: only a creeping approach stays on the curve
        if not (drag > 2.0 and r < 1e-4 * small and s[W] < belt):
            return False
    elif r >= s[RADIUS]:
        return False
    xi = s[SIGMA] * (c[A1] + c[A3] - weakened(c, belt))
    hardest = r * sqrt(1.0 + max(s[STIFFEST], drag) ** 2)
    book = books[WHOLE]
    covered = book[HIGH] >= xi + r and book[LOW] <= xi - r and book[FASTEST] >= belt + r and book[HARDEST] >= hardest
    if not covered:
        if r >= small:
            return False
        ring_down(c, s, books, belt, load, q, drag)
    answer(s, out, SETTLES, book, nan, nan, nan, 0.0)
    return True


@njit(cache=True)
def ring_down(c, s, books, belt, load, q, drag):
    """Extrema still to come of a motion that is linear from here on."""
    at_rest = c[GAMMA] * belt - weakened(c, belt)
    note(c, s, books, at_rest, belt, 0.0)
    v = load - drag * q
    for start, slope, kind in ((load, -q, 0), (q, v, 1), (v, -q - drag * v, 2)):
        for _ in range(3):
            t = turn_of_linear(start, slope, drag)
            if t == inf:
                break
            start, slope = linear(start, slope, drag, t)
            slope = 0.0
            if kind == 0:
                note(c, s, books, at_rest + start, belt, 0.0)
            elif kind == 1:
                note(c, s, books, at_rest, belt + start, 0.0)
            else:
                note(c, s, books, at_rest, belt, start)


@njit(cache=True)
def close_loop(c, s, out, books, tau, heat, amplitude):
    """w passes the belt speed upwards with w' = amplitude: the whole state of a motion that does not stick."""
    before, ratio_before = s[AMPLITUDE], s[RATIO]
    s[AMPLITUDE] = amplitude
    period, work = tau - s[LOOP_TAU], heat - s[LOOP_HEAT]
    s[LOOP_TAU], s[LOOP_HEAT] = tau, heat
    decided = False
    if not isnan(before):
        s[RATIO] = amplitude / before
        out[DECREMENT] = -log(s[RATIO]) if s[RATIO] > 0.0 else nan
        s[QUIET] = s[QUIET] + 1.0 if abs(amplitude - before) <= 2e-11 * amplitude else 0.0
        belt = s[SIGMA] * c[BELT]
        if s[QUIET] >= 3.0:
            answer(s, out, RINGS, books[LOOP], period, 0.0, work, 1.0)
            decided = True
        elif s[W_MIN] > belt > 0.0 and amplitude < 1e-6 * min(c[A4], belt, 1.0):
            # straight pieces, the same at every scale: the peaks shrink by a constant factor from here on
            if s[RATIO] < 0.999 and abs(s[RATIO] - ratio_before) < 1e-3:
                note(c, s, books, c[GAMMA] * belt - weakened(c, belt), belt, 0.0)
                answer(s, out, SETTLES, books[WHOLE], nan, nan, nan, 0.0)
                decided = True
    forget(books[LOOP])
    return decided


# --- phases; each returns what comes next ---


@njit(cache=True)
def slip(c, s, out, books, k, fast, rtol, share, most_steps):
    """On the curve until w or, below the minimum of a hysteretic one, w' falls through zero, or w through W_MIN."""
    belt = s[SIGMA] * c[BELT]
    hysteretic = s[W_MIN] > 0.0
    floor = s[W_MIN] if fast else 0.0
    note(c, s, books, s[P], s[W], rate(c, s[P], s[W]))
    h = 1e-3
    while out[STEPS] < most_steps:
        p, w, heat = s[P], s[W], s[HEAT]
        h = min(h, longest(c, belt, p, w, share))
        p1, w1, heat1, error = step(c, belt, p, w, heat, h, k)
        out[STEPS] += 1.0
        dw, dw1 = rate(c, p, w), rate(c, p1, w1)
        if s[BIRTH] > 0.0:
            dw = 0.0
        bad = not error <= rtol or abs(w1 - w) > 2.0 * room(c, w, share)
        bad |= s[BIRTH] > 0.0 and not dw1 > 0.0  # w' grows from zero, whatever rounding says
        bad |= dw >= 0.0 and w1 < floor  # up and down in one step
        if bad:
            h *= 0.5 if not error < inf else max(0.2, min(0.5, 0.9 * (rtol / (error + 1e-300)) ** 0.125))
            if h < 1e-13 * (1.0 if belt == 0.0 else min(1.0, abs(belt))) * min(1.0, c[A4]):
                return DONE
            continue
        end, what = h, SLIP_AGAIN
        if hysteretic and not fast and dw1 < 0.0 and s[BIRTH] == 0.0:
            end, what = locate(c, belt, p, w, h, 1, 0.0, k), FALL
        if hysteretic and not fast:
            there = step(c, belt, p, w, heat, end, k)
            if there[1] >= s[W_MIN] > w:
                end, what = locate(c, belt, p, w, end, 0, s[W_MIN], k), TO_FAST
        if w1 < floor:
            end, what = locate(c, belt, p, w, h, 0, floor, k), FALL if fast else REST
        elif dw < 0.0 < dw1:  # a trough within the step
            t = locate(c, belt, p, w, h, 1, 0.0, k)
            if step(c, belt, p, w, heat, t, k)[1] < floor:
                end, what = locate(c, belt, p, w, t, 0, floor, k), FALL if fast else REST
        decided = pass_over(c, s, out, books, belt, end, k)
        s[BIRTH] = 0.0
        if decided:
            return DONE
        if what != SLIP_AGAIN:
            s[W] = 0.0 if what == REST else (s[W_MIN] if what == TO_FAST or fast else s[W])
            return what
        if settled(c, s, out, books):
            return DONE
        h *= min(4.0, 0.9 * (rtol / (error + 1e-300)) ** 0.125)
    return DONE


@njit(cache=True)
def pass_over(c, s, out, books, belt, h, k):
    """Go on by h, noting the extrema on the way and the loop that closes."""
    p, w, heat = s[P], s[W], s[HEAT]
    p1, w1, heat1, _ = step(c, belt, p, w, heat, h, k)
    dw, dw1 = rate(c, p, w), rate(c, p1, w1)
    for kind in (1, 2):
        if quantity(c, belt, p, w, kind, 0.0) * quantity(c, belt, p1, w1, kind, 0.0) < 0.0:
            t = locate(c, belt, p, w, h, kind, 0.0, k)
            there = step(c, belt, p, w, heat, t, k)
            note(c, s, books, there[0], there[1], rate(c, there[0], there[1]))
    note(c, s, books, p1, w1, dw1)
    decided = False
    if belt >= 0.0 and (w < belt) != (w1 < belt):
        t = locate(c, belt, p, w, h, 0, belt, k)
        there = step(c, belt, p, w, heat, t, k)
        dw = rate(c, there[0], there[1])
        note(c, s, books, there[0], belt, dw)
        if w < belt:
            decided = close_loop(c, s, out, books, s[TAU] + t, there[2], dw)
    s[TAU] += h
    s[P], s[W], s[HEAT] = p1, w1, heat1
    return decided


@njit(cache=True)
def fall(c, s, out, books):
    """Down the line to (0, mu_stop), Eq. (2a); a hold at its trough."""
    belt, mu0, w, tau = s[SIGMA] * c[BELT], c[A1] + c[A3], s[W], s[TAU]
    mu_line, stop = mu0 - weakened(c, w), c[STOP]
    slope = (mu_line - stop) / w
    d, q, v = c[GAMMA] + slope, w - belt, min(rate(c, s[P], w), 0.0)
    if q > 0.0 and abs(v) < 1e-14 * q:  # a peak: rounding must not tell on which side of it we stand
        v = 0.0
    turn = turn_of_linear(q, v, d)
    stops, duration = False, turn
    if turn == inf:
        if belt > 0.0 and d > 0.0:
            note(c, s, books, c[GAMMA] * belt + stop + slope * belt - mu0, belt, 0.0)
            answer(s, out, SETTLES, books[WHOLE], nan, nan, nan, 0.0)
        elif belt == 0.0 and d > 0.0:
            return DONE
        else:
            latest = 1.0
            while linear(q, v, d, latest)[0] > -belt and latest < 1e8:
                latest *= 2.0
            stops, duration = True, time_of_level(q, v, d, -belt, latest)
    elif linear(q, v, d, turn)[0] < -belt:
        stops, duration = True, time_of_level(q, v, d, -belt, turn)
    hardest = turn_of_linear(v, -q - d * v, d)
    if hardest < duration:
        note(c, s, books, s[P], w, linear(q, v, d, hardest)[1])
    if duration == inf:
        return DONE
    q1, v1 = linear(q, v, d, duration)
    if q > 0.0 > q1:
        t = time_of_level(q, v, d, 0.0, duration)
        v_there = linear(q, v, d, t)[1]
        note(c, s, books, v_there + c[GAMMA] * belt + stop + slope * belt - mu0, belt, v_there)
    w1 = 0.0 if stops else q1 + belt
    p1 = v1 + c[GAMMA] * w1 + stop + slope * w1 - mu0
    note(c, s, books, p1, w1, v1)
    way = belt * duration - (p1 - s[P])  # the integral of w
    s[HEAT] += stop * way + slope * (square_of_linear(q, v, d, duration) + belt * (2.0 * way - belt * duration))
    s[P], s[W], s[TAU] = p1, w1, tau + duration
    out[STEPS] += 1.0
    return REST if stops else leave_line(c, s, out, books, stop + slope * w1)


@njit(cache=True)
def leave_line(c, s, out, books, mu_line):
    """At a trough on the line: hold until the load has climbed to the curve, if that lies above."""
    belt, w = s[SIGMA] * c[BELT], s[W]
    mu_curve = c[A1] + c[A3] - weakened(c, w)
    if mu_curve > mu_line:
        if belt - w <= 1e-13 * belt:
            note(c, s, books, c[GAMMA] * w - weakened(c, w), w, 0.0)
            return answer(s, out, SETTLES, books[WHOLE], nan, nan, nan, 0.0)
        duration = (mu_curve - mu_line) / (belt - w)
        s[TAU] += duration
        s[HEAT] += w * duration * 0.5 * (mu_line + mu_curve)
        s[P] = c[GAMMA] * w - weakened(c, w)
        s[BIRTH] = 1.0
    return TO_RISE


@njit(cache=True)
def turn_round(c, s):
    """See the same motion in the frame of the other sliding direction."""
    s[P], s[SIGMA] = -s[P] - 2.0 * (c[A1] + c[A3]), -s[SIGMA]


@njit(cache=True)
def rest(c, s, out, books, memory, starting):
    """w = 0: slip the other way, or stick and break away."""
    mu0 = c[A1] + c[A3]
    age = c[CONTACT] if starting else 0.0
    load = s[P] + mu0
    static = c[STATIC] + (c[AGEING] * log1p(age / c[AGE_TIME]) if c[AGEING] > 0.0 else 0.0)
    out[STEPS] += 1.0
    if abs(load) > static:
        if load < 0.0:
            turn_round(c, s)
        return TO_RISE
    if not starting and isnan(out[RESTICK_TIME]):
        out[RESTICK_TIME], out[RESTICK_XI] = s[TAU], s[SIGMA] * (load - c[GAMMA] * s[SIGMA] * c[BELT])
    note(c, s, books, s[P], 0.0, 0.0)
    if c[BELT] == 0.0:
        return answer(s, out, STUCK, books[WHOLE], nan, nan, nan, 0.0)
    if s[SIGMA] * c[BELT] < 0.0:
        turn_round(c, s)
    dwell = time_in_contact(c, static - (s[P] + mu0), abs(c[BELT]), age)
    limit = c[STATIC] + (c[AGEING] * log1p((age + dwell) / c[AGE_TIME]) if c[AGEING] > 0.0 else 0.0)
    s[TAU], s[P], s[W] = s[TAU] + dwell, limit - mu0, 0.0
    s[AMPLITUDE], s[RATIO], s[QUIET] = nan, nan, 0.0
    note(c, s, books, s[P], 0.0, 0.0)
    s[BIRTH] = 1.0 if s[P] <= 0.0 else 0.0
    if s[P] <= 0.0:
        s[P] = 0.0
    return release(c, s, out, books, memory, dwell)


@njit(cache=True)
def time_in_contact(c, missing, belt, age):
    """How long until the load, growing at `belt`, passes the static friction it falls short of by `missing` >= 0."""
    if c[AGEING] == 0.0:
        return missing / belt
    later = c[AGE_TIME] + age
    early = max(0.0, c[AGEING] / belt - later)  # where the excess of load is least
    if missing <= 0.0 and early == 0.0:
        return 0.0
    late = max(2.0 * early, missing / belt, later)
    while belt * late - missing - c[AGEING] * log1p(late / later) < 0.0:
        late *= 2.0
    for _ in range(1100):
        t = 0.5 * (early + late)
        if not early < t < late:
            break
        if belt * t - missing - c[AGEING] * log1p(t / later) < 0.0:
            early = t
        else:
            late = t
    return late


@njit(cache=True)
def release(c, s, out, books, memory, dwell):
    """A break-away: with an earlier one at the same load it bounds the limit cycle."""
    n = int(s[RELEASES])
    here = memory[n % MEMORY]
    s[STUCK_FOR] += dwell
    if n == 0:
        out[BREAKAWAY_TIME] = s[TAU]
        forget(books[WHOLE])
        note(c, s, books, s[P], 0.0, 0.0)
    for lag in range(1, min(n, MEMORY - 1) + 1):
        then = memory[(n - lag) % MEMORY]
        if abs(s[P] - then[RELEASED_P]) <= 1e-12 * (c[A1] + c[A3]):
            book = books[CYCLE]
            for back in range(1, lag):
                old = memory[(n - back) % MEMORY, 4:]
                book[HIGH], book[LOW] = max(book[HIGH], old[HIGH]), min(book[LOW], old[LOW])
                book[FASTEST], book[HARDEST] = max(book[FASTEST], old[FASTEST]), max(book[HARDEST], old[HARDEST])
            period, heat = s[TAU] - then[RELEASED_AT], s[HEAT] - then[RELEASED_HEAT]
            return answer(s, out, STICK_SLIP, book, period, s[STUCK_FOR] - then[RELEASED_STICK], heat, float(lag))
    here[RELEASED_AT], here[RELEASED_P], here[RELEASED_STICK], here[RELEASED_HEAT] = s[TAU], s[P], s[STUCK_FOR], s[HEAT]
    here[4:] = books[CYCLE]
    s[RELEASES] += 1.0
    forget(books[CYCLE])
    forget(books[LOOP])
    note(c, s, books, s[P], 0.0, 0.0)
    return TO_RISE


# --- the motion ---


@njit(cache=True)
def begin(c, s, books):
    """The start: whether it is at rest on the belt."""
    mu0 = c[A1] + c[A3]
    s[W_MIN] = 0.0 if isnan(c[STOP]) else speed_of_minimum(c)
    prove_settling(c, s)
    s[AMPLITUDE], s[RATIO] = nan, nan
    for book in range(3):
        forget(books[book])
    relative = 0.0 if isnan(c[ETA0]) else c[BELT] - c[ETA0]
    s[SIGMA] = -1.0 if relative < 0.0 else 1.0
    s[W], s[P] = abs(relative), s[SIGMA] * (c[XI0] + c[GAMMA] * c[BELT]) - mu0
    return relative == 0.0


@njit(cache=True)
def judge_cell(c, out, rtol, share, most_steps):
    """Follow the motion of cell c (CELL_ROWS) until its regime is certain; the answers (ANSWERS) go to out.

    rtol : of a step. share : of a4, by which w may change in a step on the steep part.
    """
    s, books, memory, k = np.zeros(STATES), np.empty((3, 4)), np.zeros((MEMORY, 8)), np.zeros((13, 3))
    out[:] = nan
    out[REGIME], out[STEPS] = UNDECIDED, 0.0
    starting, fast = begin(c, s, books), False
    what = REST if starting else TO_RISE
    if not starting and s[W_MIN] > 0.0:
        dw = rate(c, s[P], s[W])
        fast = s[W] >= s[W_MIN]
        note(c, s, books, s[P], s[W], dw)
        if not fast and (dw < 0.0 or (dw == 0.0 and s[W] > s[SIGMA] * c[BELT])):
            what = FALL
    while what != DONE and out[STEPS] < most_steps:
        if what == REST:
            what, fast = rest(c, s, out, books, memory, starting), False
        elif what == FALL:
            what, fast = fall(c, s, out, books), False
        else:
            fast = fast or what == TO_FAST
            what = slip(c, s, out, books, k, fast, rtol, share, most_steps)
        starting = False


@njit(cache=True, nogil=True)
def judge_cells(cells, out, rtol, share, most_steps):
    """`judge_cell` for every row of cells (n, CELL_ROWS)."""
    for i in range(cells.shape[0]):
        judge_cell(cells[i], out[i], rtol, share, most_steps)
