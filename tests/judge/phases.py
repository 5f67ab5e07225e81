"""Phases of the motion; each returns what comes next."""

from math import inf, isnan, log1p, nan, sqrt

from .band import begin_band, displacement, note_entry_in_hold, note_entry_in_step, note_entry_on_line, note_side
from .curve import room, weakened
from .jit import compiled
from .layout import (
    A1, A3, A4, AGEING, AGE_TIME, AMPLITUDE, BAND2, BELT, BIRTH, BREAKAWAY_TIME, CONTACT, CYCLE, DONE, FALL, FIRST_SLIP,
    GAMMA, HEAT, LOOP, MEMORY, QUIET, RATIO, RELEASED_AT, RELEASED_BOOK, RELEASED_HEAT, RELEASED_P, RELEASED_STICK,
    RELEASES, RELEASE_LOAD, REST, RESTICK_TIME, RESTICK_XI, REVERSAL, SETTLES, SIGMA, SLIP_AGAIN, STATIC, STEPS,
    STICK_SLIP, STOP, STUCK, STUCK_FOR, TAU, TO_FAST, TO_RISE, WHOLE, W_MIN, P, W,
)  # fmt: skip
from .linear import linear, square_of_linear, time_of_level, turn_of_linear
from .settling import answer_cycle, answer_point, close_loop, forget, join, note, settled
from .stepping import locate, longest, quantity, rate, step

SAME_LOAD, OTHER_LOAD = 1e-12, 1e-6  # relative differences of loads at break-away: one cycle, another one
NO_TURN = 1e-6  # slip speed below that of the belt, in settling bands: the mass settles rather than reverses


@compiled
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
        bad |= s[BIRTH] > 0.0 and not dw1 > 0.0  # w' grows from zero, whatever its rounded sign
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


@compiled
def pass_over(c, s, out, books, belt, h, k):
    """Advance by h, recording the extrema on the way and the loop that closes."""
    p, w, heat = s[P], s[W], s[HEAT]
    p1, w1, heat1, _ = step(c, belt, p, w, heat, h, k)
    dw, dw1 = rate(c, p, w), rate(c, p1, w1)
    for kind in (1, 2):
        if quantity(c, belt, p, w, kind, 0.0) * quantity(c, belt, p1, w1, kind, 0.0) < 0.0:
            t = locate(c, belt, p, w, h, kind, 0.0, k)
            there = step(c, belt, p, w, heat, t, k)
            note(c, s, books, there[0], there[1], rate(c, there[0], there[1]))
    note(c, s, books, p1, w1, dw1)
    note_entry_in_step(c, s, belt, h, k)
    decided = False
    if belt >= 0.0 and (w < belt) != (w1 < belt):
        t = locate(c, belt, p, w, h, 0, belt, k)
        there = step(c, belt, p, w, heat, t, k)
        dw = rate(c, there[0], there[1])
        note(c, s, books, there[0], belt, dw)
        note_side(c, s, displacement(c, s, there[0]))
        if w < belt:
            decided = close_loop(c, s, out, books, s[TAU] + t, there[2], dw)
    s[TAU] += h
    s[P], s[W], s[HEAT] = p1, w1, heat1
    return decided


@compiled
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
    if s[REVERSAL] == inf:
        s[REVERSAL] = mu_line
    if turn == inf:
        if belt > 0.0 and d > 0.0:
            note(c, s, books, c[GAMMA] * belt + stop + slope * belt - mu0, belt, 0.0)
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
    note_entry_on_line(c, s, q, v, d, slope, duration)
    if duration == inf:
        return answer_point(c, s, out, SETTLES, books[WHOLE], s[SIGMA] * (stop + slope * belt))
    q1, v1 = linear(q, v, d, duration)
    if q > 0.0 > q1:
        t = time_of_level(q, v, d, 0.0, duration)
        v_there = linear(q, v, d, t)[1]
        p_there = v_there + c[GAMMA] * belt + stop + slope * belt - mu0
        note(c, s, books, p_there, belt, v_there)
        if -q1 > NO_TURN * sqrt(s[BAND2]):
            note_side(c, s, displacement(c, s, p_there))
    w1 = 0.0 if stops else q1 + belt
    p1 = v1 + c[GAMMA] * w1 + stop + slope * w1 - mu0
    note(c, s, books, p1, w1, v1)
    way = belt * duration - (p1 - s[P])  # the integral of w
    s[HEAT] += stop * way + slope * (square_of_linear(q, v, d, duration) + belt * (2.0 * way - belt * duration))
    s[P], s[W], s[TAU] = p1, w1, tau + duration
    out[STEPS] += 1.0
    return REST if stops else leave_line(c, s, out, books, stop + slope * w1)


@compiled
def leave_line(c, s, out, books, mu_line):
    """At a trough on the line: hold until the load has risen to the curve, if that lies above."""
    belt, w = s[SIGMA] * c[BELT], s[W]
    mu_curve = c[A1] + c[A3] - weakened(c, w)
    if mu_curve > mu_line:
        if belt - w <= max(NO_TURN * sqrt(s[BAND2]), 1e-13 * belt):
            note(c, s, books, c[GAMMA] * w - weakened(c, w), w, 0.0)
            return answer_point(c, s, out, SETTLES, books[WHOLE], displacement(c, s, s[P]))
        duration = (mu_curve - mu_line) / (belt - w)
        note_entry_in_hold(c, s, duration)
        s[TAU] += duration
        s[HEAT] += w * duration * 0.5 * (mu_line + mu_curve)
        s[P] = c[GAMMA] * w - weakened(c, w)
        s[BIRTH] = 1.0
    return TO_RISE


@compiled
def turn_round(c, s):
    """Express the same motion in the frame of the other sliding direction."""
    s[P], s[SIGMA] = -s[P] - 2.0 * (c[A1] + c[A3]), -s[SIGMA]


@compiled
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
        if starting:
            begin_band(c, s)
        return TO_RISE
    if not starting and isnan(out[RESTICK_TIME]):
        out[RESTICK_TIME], out[RESTICK_XI] = s[TAU], s[SIGMA] * (load - c[GAMMA] * s[SIGMA] * c[BELT])
    note(c, s, books, s[P], 0.0, 0.0)
    if c[BELT] == 0.0:
        return answer_point(c, s, out, STUCK, books[WHOLE], displacement(c, s, s[P]))
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


@compiled
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


@compiled
def release(c, s, out, books, memory, dwell):
    """A break-away: with an earlier one at the same load it bounds the limit cycle, of as many stick phases."""
    n = int(s[RELEASES])
    here = memory[n % MEMORY]
    s[STUCK_FOR] += dwell
    if n == 0:
        out[BREAKAWAY_TIME] = s[TAU]
        if isnan(s[FIRST_SLIP]):  # what slipped before belongs to the whole motion
            forget(books[WHOLE])
        note(c, s, books, s[P], 0.0, 0.0)
    for lag in range(1, min(n, MEMORY - 1) + 1):
        then = memory[(n - lag) % MEMORY]
        change = abs(s[P] - then[RELEASED_P]) / (c[A1] + c[A3])
        if SAME_LOAD < change < OTHER_LOAD:  # converging still
            break
        if change <= SAME_LOAD:
            book = books[CYCLE]
            for back in range(1, lag):
                join(book, memory[(n - back) % MEMORY, RELEASED_BOOK:])
            period, heat = s[TAU] - then[RELEASED_AT], s[HEAT] - then[RELEASED_HEAT]
            stuck = s[STUCK_FOR] - then[RELEASED_STICK]
            return answer_cycle(c, s, out, STICK_SLIP, book, book, period, stuck, heat, float(lag))
    here[RELEASED_AT], here[RELEASED_P], here[RELEASED_STICK], here[RELEASED_HEAT] = s[TAU], s[P], s[STUCK_FOR], s[HEAT]
    here[RELEASED_BOOK:] = books[CYCLE]
    s[RELEASES], s[RELEASE_LOAD] = s[RELEASES] + 1.0, s[P] + c[A1] + c[A3]
    begin_band(c, s)
    forget(books[CYCLE])
    forget(books[LOOP])
    note(c, s, books, s[P], 0.0, 0.0)
    return TO_RISE
