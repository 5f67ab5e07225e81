"""Records of extrema, verdicts, and how motion without stick is known to settle or to be sustained."""

from math import inf, isnan, log, nan, sqrt

from .band import steady
from .curve import slope_of_curve, weakened
from .jit import compiled
from .layout import (
    A1, A3, A4, ACCELERATION_MAX, AMPLITUDE, BACKWARD, BELT, BREAKAWAYS, CROSSED, CROSSINGS, CYCLE_SPEED_RANGE,
    CYCLE_XI_MAX, CYCLE_XI_MIN, DECIDED_AT, DECREMENT, DONE, ENTERED, FASTEST, FIRST_SLIP, FORWARD, GAMMA, HARDEST,
    HEAT_PER_CYCLE, HIGH, INSIDE, LOOP, LOOPS_PER_CYCLE, LOOP_HEAT, LOOP_TAU, LOW, MU_BREAKAWAY, MU_REVERSAL, PERIOD,
    PROVEN, QUIET, RADIUS, RATIO, REGIME, RELEASES, RELEASE_LOAD, REVERSAL, RINGS, SETTLES, SETTLING_TIME, SIGMA,
    SPEED_MAX, STICK_TIME, STIFFEST, TAU, WHOLE, W_MIN, XI_MAX, XI_MIN, XI_SETTLED, XI_STEADY, P, W,
)  # fmt: skip
from .linear import linear, turn_of_linear

ROUNDING = 1e-11  # distance from steady sliding at which the sign of w' is no longer certain

# --- records of extrema ---


@compiled
def note(c, s, books, p, w, dw):
    """Extend the extrema by a state."""
    xi = s[SIGMA] * (p + c[A1] + c[A3] - c[GAMMA] * s[SIGMA] * c[BELT])
    for book in range(3):
        books[book, HIGH], books[book, LOW] = max(books[book, HIGH], xi), min(books[book, LOW], xi)
        books[book, FASTEST], books[book, HARDEST] = max(books[book, FASTEST], w), max(books[book, HARDEST], abs(dw))
        relative = s[SIGMA] * w
        books[book, FORWARD] = max(books[book, FORWARD], relative)
        books[book, BACKWARD] = min(books[book, BACKWARD], relative)


@compiled
def forget(book):
    """Reset a record of extrema."""
    book[HIGH], book[LOW], book[FASTEST], book[HARDEST] = -inf, inf, 0.0, 0.0
    book[FORWARD], book[BACKWARD] = -inf, inf


@compiled
def join(book, other):
    """Extend this record by the extrema of another one."""
    for row in (HIGH, FASTEST, HARDEST, FORWARD):
        book[row] = max(book[row], other[row])
    for row in (LOW, BACKWARD):
        book[row] = min(book[row], other[row])


@compiled
def answer(c, s, out, regime, book):
    """Write the verdict, and the metrics of every motion. book : record of its extrema."""
    out[REGIME], out[BREAKAWAYS], out[CROSSINGS] = regime, s[RELEASES], s[CROSSED]
    out[XI_MAX], out[XI_MIN] = book[HIGH], book[LOW]
    out[SPEED_MAX], out[ACCELERATION_MAX] = book[FASTEST], book[HARDEST]
    out[MU_BREAKAWAY], out[MU_REVERSAL] = s[RELEASE_LOAD], s[REVERSAL] if s[REVERSAL] < inf else nan
    out[XI_STEADY], out[LOOPS_PER_CYCLE], out[DECIDED_AT] = steady(c), 0.0, s[TAU]
    return DONE


@compiled
def answer_cycle(c, s, out, regime, book, cycle, period, stick_time, heat, loops):
    """A motion that is periodic in the end. cycle : record of its last cycle."""
    answer(c, s, out, regime, book)
    out[PERIOD], out[STICK_TIME], out[HEAT_PER_CYCLE], out[LOOPS_PER_CYCLE] = period, stick_time, heat, loops
    out[CYCLE_XI_MAX], out[CYCLE_XI_MIN] = cycle[HIGH], cycle[LOW]
    out[CYCLE_SPEED_RANGE] = cycle[FORWARD] - cycle[BACKWARD]
    return DONE


@compiled
def answer_point(c, s, out, regime, book, xi):
    """A motion that settles at xi."""
    answer(c, s, out, regime, book)
    out[XI_SETTLED], out[CYCLE_XI_MAX], out[CYCLE_XI_MIN], out[CYCLE_SPEED_RANGE] = xi, xi, xi, 0.0
    if regime == SETTLES:
        out[SETTLING_TIME] = s[ENTERED] - s[FIRST_SLIP] if s[INSIDE] > 0.0 else nan
    return DONE


# --- steady sliding ---


@compiled
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


@compiled
def settled(c, s, out, books):
    """Whether the motion on the curve has come into the settling band for good, its extrema known."""
    belt = s[SIGMA] * c[BELT]
    if belt <= 0.0:
        return False
    q = s[W] - belt
    load = s[P] - c[GAMMA] * belt + weakened(c, belt)
    r = sqrt(load * load + q * q)
    drag = c[GAMMA] + slope_of_curve(c, belt)
    small = 1e-7 * min(c[A4], belt) if c[A3] != 0.0 else inf
    if s[W_MIN] > belt:  # below the minimum of the hysteretic curve: only an overdamped approach stays on the curve
        if not (drag > 2.0 and r < max(1e-4 * small, ROUNDING) and s[W] < belt):
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
    s[PROVEN] = 1.0
    if s[INSIDE] == 0.0:
        return False
    answer_point(c, s, out, SETTLES, book, xi)
    return True


@compiled
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


@compiled
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
            answer_cycle(c, s, out, RINGS, books[LOOP], books[LOOP], period, 0.0, work, 1.0)
            decided = True
        elif s[W_MIN] > belt > 0.0 and amplitude < 1e-6 * min(c[A4], belt, 1.0) and s[INSIDE] > 0.0:
            # straight pieces, the same at every scale: the peaks shrink by a constant factor from here on
            if s[RATIO] < 0.999 and abs(s[RATIO] - ratio_before) < 1e-3:
                note(c, s, books, c[GAMMA] * belt - weakened(c, belt), belt, 0.0)
                answer_point(c, s, out, SETTLES, books[WHOLE], steady(c))
                decided = True
    forget(books[LOOP])
    return decided
