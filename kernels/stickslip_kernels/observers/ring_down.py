"""The way down by the amplitude map of `amplitudes.py`: its two power series, iterated.

Half a loop takes an amplitude a to -a R(a) in a time T(a). The further down, the fewer powers of a matter; once they
are few, the map of twice as many half loops takes the place of the map, again and again, as long as it does not lead
too far at once. So the number of maps to go through grows with the logarithm of the number of half loops.
"""

from math import inf, nan

from .. import layout as at
from ..jit import compiled

TRUNCATED = 0.01  # of the tolerance: terms below are left out
NARROWER, MOST_STALLED = 0.7, 4000.0  # maps on the way down until the amplitude is so much smaller
FEW, LEAST = 5, 0.7  # terms of a map that is doubled, and its ratio at least
KEPT_R, KEPT_T, SCRATCH = at.Rows(at.MAP_A, at.MAP_R).take(3 * FEW)[::FEW]  # nodes are not needed on the way down


@compiled
def ring_down(s, i, a, tau, horizon, rtol):
    """Amplitude and time of the last turn but one outside the settling band, or of the last before the horizon.

    Returns (amplitude, time, half loops from (a, tau) to there); their number is negative if the motion grows on the
    way, or may never settle.
    """
    n, half_loops, at_once, before = int(s[at.MAP_NODES + i]), 0.0, 1.0, 0.0
    to_powers(s, i, n)
    first, wide, stalled, descends = s[at.MAP_R + i], inf, 0.0, True
    while True:
        stalled += 1.0
        if abs(a) < wide:
            n, wide, stalled = terms_that_matter(s, i, n, abs(a), TRUNCATED * rtol), NARROWER * abs(a), 0.0
            if descends and n <= FEW and s[at.MAP_R + i] > LEAST:
                if at_once == 1.0:
                    copy_map(s, i, at.MAP_R, at.MAP_T, KEPT_R, KEPT_T)
                double_map(s, i, n, -1.0 if at_once == 1.0 else 1.0)
                at_once *= 2.0
        ratio, time = ratio_and_time(s, i, n, a)
        if ratio * before >= 1.0 or stalled > MOST_STALLED:
            return a, tau, -1.0
        after = ratio if at_once == 1.0 else first * first
        if abs(a) * ratio * after > s[at.BAND + i] and tau + time < horizon:
            a, tau, half_loops, before = (-a if at_once == 1.0 else a) * ratio, tau + time, half_loops + at_once, ratio
        elif at_once == 1.0:
            return a, tau, half_loops
        else:  # too far: the rest by single half loops
            copy_map(s, i, KEPT_R, KEPT_T, at.MAP_R, at.MAP_T)
            n, at_once, before, wide, descends = FEW, 1.0, 0.0, inf, False


@compiled
def to_powers(s, i, nodes):
    """Turn divided differences into coefficients of the powers of a, in place."""
    for k in range(nodes - 2, -1, -1):
        node = s[at.MAP_A + k * at.WIDTH + i]
        for j in range(k * at.WIDTH + i, (nodes - 1) * at.WIDTH + i, at.WIDTH):
            s[at.MAP_R + j] -= node * s[at.MAP_R + at.WIDTH + j]
            s[at.MAP_T + j] -= node * s[at.MAP_T + at.WIDTH + j]
    for j in range(nodes * at.WIDTH + i, max(nodes + 1, FEW) * at.WIDTH + i, at.WIDTH):
        if j < at.MAP_MOST_NODES * at.WIDTH:
            s[at.MAP_R + j], s[at.MAP_T + j] = 0.0, 0.0


@compiled
def terms_that_matter(s, i, most, a, tolerance):
    """How many terms of R and T there are up to the last above the tolerance at a > 0."""
    terms, power = 1, 1.0
    for k in range(1, most):
        power *= a
        if power * max(abs(s[at.MAP_R + k * at.WIDTH + i]), abs(s[at.MAP_T + k * at.WIDTH + i])) > tolerance:
            terms = k + 1
    return terms


@compiled(inline=True)
def ratio_and_time(s, i, terms, a):
    """R and T at a; even and odd powers apart, so that a sum waits for half as many operations."""
    square, even, odd, even_time, odd_time = a * a, 0.0, 0.0, 0.0, 0.0
    for k in range((terms - 1) // 2 * 2 * at.WIDTH + i, -1, -2 * at.WIDTH):
        even, odd = even * square + s[at.MAP_R + k], odd * square + s[at.MAP_R + at.WIDTH + k]
        even_time, odd_time = even_time * square + s[at.MAP_T + k], odd_time * square + s[at.MAP_T + at.WIDTH + k]
    return even + a * odd, even_time + a * odd_time


# --- twice as many half loops -----------------------------------------------------------------------------------------


@compiled
def double_map(s, i, terms, sign):
    """Put the map after itself, in place: R(a) R(x) and T(a) + T(x) with x = sign a R(a)."""
    compose(s, i, at.MAP_T, terms, sign)
    for j in range(0, terms * at.WIDTH, at.WIDTH):
        s[at.MAP_T + j + i] += s[SCRATCH + j + i]
    compose(s, i, at.MAP_R, terms, sign)
    for j in range((terms - 1) * at.WIDTH, -1, -at.WIDTH):
        total = 0.0
        for k in range(0, j + 1, at.WIDTH):
            total += s[at.MAP_R + k + i] * s[SCRATCH + j - k + i]
        s[SCRATCH + j + i] = total
    for j in range(0, terms * at.WIDTH, at.WIDTH):
        s[at.MAP_R + j + i] = s[SCRATCH + j + i]


@compiled
def compose(s, i, row, terms, sign):
    """The series of a row at x = sign a R(a), in rows SCRATCH, by Horner's scheme."""
    for j in range(0, terms * at.WIDTH, at.WIDTH):
        s[SCRATCH + j + i] = 0.0
    for k in range((terms - 1) * at.WIDTH, -1, -at.WIDTH):
        for j in range((terms - 1) * at.WIDTH, 0, -at.WIDTH):
            total = 0.0
            for power in range(at.WIDTH, j + 1, at.WIDTH):
                total += s[at.MAP_R + power - at.WIDTH + i] * s[SCRATCH + j - power + i]
            s[SCRATCH + j + i] = sign * total
        s[SCRATCH + i] = s[row + k + i]


@compiled(inline=True)
def copy_map(s, i, ratio, time, to_ratio, to_time):
    """Copy the first terms of both series from two rows on to two others."""
    for j in range(i, FEW * at.WIDTH + i, at.WIDTH):
        s[to_ratio + j], s[to_time + j] = s[ratio + j], s[time + j]


# --- the slip cycle that a spiral comes to where steady sliding repels ------------------------------------------------
# A loop takes an amplitude a to a L(a), L(a) = R(a) R(-a R(a)). Spirals of a plane do not cross, so a motion that comes
# from outside tends to the outermost a with L = 1. It is looked for inwards, in leaps of at most half of what the
# secant of 1 - L says is left, as long as L < 1. Of a small deviation a loop leaves (a L)', its Floquet multiplier.


HALF, TENTH = 0.5, 0.1  # of the way that is left, and of the amplitude: leaps at most
NEAR = 0.01  # tolerances, over the amplitude: what may be left
MOST_LEAPS = 100
MOST_LEFT = 0.999  # multiplier of a cycle that attracts for certain


@compiled
def loss(s, i, terms, a):
    """What a loop that begins at a > 0 loses of it: 1 - L(a)."""
    ratio = ratio_and_time(s, i, terms, a)[0]
    return 1.0 - ratio * ratio_and_time(s, i, terms, -a * ratio)[0]


@compiled
def cycle_inside(s, i, terms, a, rtol):
    """Amplitude of the cycle to which loops from a > 0 tend, and its multiplier; NaN where the map does not say."""
    before = loss(s, i, terms, a)
    if not 0.0 < before < 1.0:
        return nan, nan
    outer, a = a, a * (1.0 - before)
    for _ in range(MOST_LEAPS):
        here = loss(s, i, terms, a)
        bend = (before - here) / (outer - a)
        way = here / bend if bend > 0.0 else inf
        if abs(way) <= NEAR * rtol * a:
            left = 1.0 - a * bend
            return (a - way, left) if 0.0 <= left <= MOST_LEFT else (nan, nan)
        if not here > 0.0:
            return nan, nan
        outer, before = a, here
        a -= max(here * a, min(HALF * way, TENTH * a))
    return nan, nan
