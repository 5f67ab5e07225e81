"""The map of a motion from one maximum of u to the next, whose state (y and the inner one, w being that of the belt) is
all there is: where it leads, without all the loops on the way.

Where loops bring motions together fast, a lane goes on from the limit to which they tend (secant method); where each
changes little, it is put many loops ahead, changes being taken as linear in y.
"""

from math import floor, isnan, log, log1p, nan

from .. import contacts
from .. import layout as at
from ..jit import compiled

ALIKE = 10.0  # tolerances, of the range of u, by which a cycle may differ from its limit
NOISE = 0.01  # tolerances, of the range: smaller changes are those of steps
FIRM, MOST_FIRM = 0.3, 4.0  # share of a deviation that a loop leaves, at most, where the limit is foretold; times
NARROW, GENERIC = 0.03, 30.0  # deviations that tell this share: so much of the range, at most; tolerances, at least
CERTAIN = 1e-3  # change, of the range, from which on such a motion has the regime of its limit
FAR = 10.0  # times as far from steady sliding as the lane is put ahead: what settles does so in its time
MOST_STILL = 50.0  # loops that change by less than a tolerance where small motions hardly grow or shrink
RELAXED, STRAIGHT = 3.0, 0.2  # loops after a leap until the next; by what share their changes may differ
CHANGES, ENOUGH = 1.0, 3.0  # tolerances: a change to be followed; the distance from a limit that is near enough
FIRST, LONG, SHORT = 0.1, 0.4, 0.2  # leaps, over the amplitude at the time ...
SHRUNK = 1e-3  # ... and over the largest so far, from where on they are short
CLOSE, MOST_OF_WAY, HALF_WAY, WORTH_IT = 0.01, 0.95, 0.5, 8.0  # of the amplitude: a limit; of the way to it; loops
ROUNDING = 1e-15
BAND = 1e-4  # of settling: of the largest distance from steady sliding so far
BEFORE, SLOWLY = 1.05, 0.01  # bands from steady sliding; share of a deviation that a loop takes: `most_of_settling`
STICK_BELOW = 1e-3  # least slip speed over that of the belt, below which a cycle counts as stick-slip

RESOLVED = 10.0  # times over the speed of the belt, from which on the least slip speed is as exact as the range is

GO_ON, CLOSED, TOO_SLOW = range(3)

# State where the loop under way began, where the one before began and ended; loops since the last leap; how often the
# limit was foretold; loops that changed nothing; where to put the lane, and when (NaN: nowhere).
FROM_Y, FROM_Z, IN_Y, IN_Z, OUT_Y, OUT_Z, SINCE, TIMES, STILL, TO_Y, TO_Z, TO_TAU = at.RECURRENCE.take(12)
# At the last leap: y, its change in a loop, the loop's duration, and how many were passed over.
NODE_Y, NODE_BY, NODE_TIME, NODE_LOOPS = at.RECURRENCE.take(4)


@compiled
def begin(s, i):
    """Nothing is known of the map."""
    s[FROM_Y + i], s[IN_Y + i], s[TO_TAU + i], s[NODE_Y + i] = nan, nan, nan, nan
    s[SINCE + i], s[TIMES + i], s[STILL + i] = 0.0, 0.0, 0.0


@compiled
def look_ahead(m, i, t, y, span, loop, least, least_before):
    """A maximum of u, at t of the step and y: CLOSED where the last loop is the cycle; TOO_SLOW; else GO_ON.

    span, loop, least : range of u, duration and least slip speed of the last loop, and of the one before.
    """
    s, z = m.s, contacts.inner_load(m, i, t, y, m.s[at.B + i])
    by_y, by_z, tolerance = y - s[FROM_Y + i], z - s[FROM_Z + i], m.rtol * span
    in_y, in_z = s[FROM_Y + i] - s[IN_Y + i], s[FROM_Z + i] - s[IN_Z + i]
    out_y, out_z = y - s[OUT_Y + i], z - s[OUT_Z + i]
    s[IN_Y + i], s[IN_Z + i], s[OUT_Y + i], s[OUT_Z + i] = s[FROM_Y + i], s[FROM_Z + i], y, z
    s[FROM_Y + i], s[FROM_Z + i], s[SINCE + i] = y, z, s[SINCE + i] + 1.0
    apart2, change2 = in_y * in_y + in_z * in_z, by_y * by_y + by_z * by_z
    is_still, is_firm = change2 <= tolerance * tolerance, s[at.FIRMNESS + i] * ALIKE >= NOISE
    sticks, slides = least < 0.5 * STICK_BELOW * abs(s[at.B + i]), least > 2.0 * STICK_BELOW * abs(s[at.B + i])
    regime_alone = m.observer.until == at.UNTIL_REGIME and (sticks or slides)
    s[STILL + i] = s[STILL + i] + 1.0 if is_still and not is_firm else 0.0
    if s[STILL + i] > MOST_STILL:
        return TOO_SLOW
    if not (out_y * out_y + out_z * out_z <= FIRM * FIRM * apart2 and apart2 >= tolerance * tolerance):
        turn_y, turn_z = by_y - in_y, by_z - in_z
        if s[SINCE + i] >= RELAXED and turn_y * turn_y + turn_z * turn_z <= (STRAIGHT * by_y) ** 2:
            return leap(m, i, y, z, by_y, tolerance, loop, least, least_before)
        return GO_ON
    is_close = is_still or (regime_alone and change2 <= (CERTAIN * span) ** 2)
    if is_close and apart2 <= (NARROW * span) ** 2:  # a motion that hardly changes may have shown its fast parts only
        is_all = isnan(s[NODE_Y + i]) and is_firm and apart2 >= (GENERIC * tolerance) ** 2
        if is_all or sticks:
            return CLOSED
    if is_still:
        return GO_ON
    if not sticks and apart2 > (NARROW * span) ** 2:  # extremes of all of the motion count, and when it settles
        return GO_ON
    ratio = (out_y * in_y + out_z * in_z) / apart2
    ahead = ratio / (1.0 - ratio)
    s[TO_Y + i], s[TO_Z + i] = y + ahead * by_y, z + ahead * by_z
    if (s[TO_Y + i] - s[at.Y_STAR + i]) ** 2 > (FAR * ahead) ** 2 * change2 and s[TIMES + i] < MOST_FIRM:
        s[TO_TAU + i], s[TIMES + i] = s[at.LOOP_TAU + i], s[TIMES + i] + 1.0
    return GO_ON


@compiled(inline=True)
def share(s, i, least):
    """Of the tolerance, what may be left of a cycle whose least slip speed is told to a share of itself."""
    return min(max(RESOLVED * max(abs(least), s[at.EVEN + i]) / abs(s[at.B + i]), NOISE), 1.0)


@compiled
def leap(m, i, y, z, by, tolerance, loop, least, least_before):
    """Pass over many loops, y having changed `by` in the last; or CLOSED, where the limit is near enough.

    The inner state follows y. A leap that brings the mass to rest would miss how softly it does.
    """
    s, off, bend, reach = m.s, abs(y - m.s[at.Y_STAR + i]), 0.0, FIRST
    if not isnan(s[NODE_Y + i]):
        bend, reach = (by - s[NODE_BY + i]) / (y - s[NODE_Y + i]), LONG if off > SHRUNK * s[at.AMPLITUDE + i] else SHORT
        correct_time(s, i, y, by, loop)
    reach *= off / abs(by)
    is_close = -bend * CLOSE * off > abs(by)
    if bend < 0.0:
        reach = min(reach, (MOST_OF_WAY if is_close else HALF_WAY) / -bend)
    if is_close and abs(y - s[NODE_Y + i]) <= CLOSE * off and -bend * ALIKE >= NOISE:
        if abs(by) <= ENOUGH * share(s, i, least) * tolerance * -bend:
            return CLOSED
    if by * (y - s[at.Y_STAR + i]) < 0.0:
        reach = min(reach, most_of_settling(m, i, off, by) / abs(by))
    if 0.0 < least < least_before:
        reach = min(reach, HALF_WAY * least / (least_before - least))
    loops = log1p(bend * reach) / log1p(bend) if abs(bend * reach) > 1e-6 else reach
    tau = s[at.LOOP_TAU + i] + loops * loop
    if abs(by) >= (NOISE if is_close else CHANGES) * tolerance and loops > WORTH_IT and tau < s[at.TAU_END + i]:
        s[NODE_Y + i], s[NODE_BY + i], s[NODE_TIME + i], s[NODE_LOOPS + i] = y, by, loop, loops
        s[TO_Y + i], s[TO_Z + i], s[TO_TAU + i] = y + reach * by, z * (1.0 + reach * by / (y - s[at.Y_STAR + i])), tau
        s[at.CROSSED + i] += 2.0 * floor(loops)
    return GO_ON


@compiled
def most_of_settling(m, i, off, by):
    """By how much y may change in a leap of lane i, which settles, where it is asked when: not into the settling band.

    Where loops are cheap, not at all, unless there are about a thousand of them.
    """
    s = m.s
    if not contacts.loops_are_cheap(m, i) or s[at.ATTRACTS + i] == 0.0 or m.observer.until == at.UNTIL_REGIME:
        return off
    return 0.0 if abs(by) > SLOWLY * off else max(off - BEFORE * BAND * s[at.AMPLITUDE + i], 0.0)


@compiled
def correct_time(s, i, y, by, loop):
    """Put right, once, how long the last leap took, now that the change in a loop is known beyond it as well."""
    loops, change, before = s[NODE_LOOPS + i], by / s[NODE_BY + i], s[NODE_TIME + i]
    s[NODE_TIME + i] = nan
    if isnan(before) or not 0.5 < change < 2.0:
        return
    mean = log(change) / (change - 1.0) if abs(change - 1.0) > 1e-6 else 1.0
    more = (y - s[NODE_Y + i]) / s[NODE_BY + i] * mean - s[SINCE + i] - loops
    if abs(more) < 0.5 * loops:
        time = more * loop + 0.5 * loops * (loop - before)
        s[at.TAU + i], s[at.LOOP_TAU + i] = s[at.TAU + i] + time, s[at.LOOP_TAU + i] + time


@compiled
def is_ahead(s, i):
    """Return whether lane i is to be put elsewhere."""
    return not isnan(s[TO_TAU + i])


@compiled
def go_ahead(m, i):
    """Put lane i there, at a maximum of u; a little beyond, so that it is not seen again."""
    s = m.s
    contacts.put(m, i, s[TO_Y + i], s[at.B + i] * (1.0 + ROUNDING), s[TO_Z + i])
    s[at.TAU + i], s[at.HEAT + i] = s[TO_TAU + i], s[at.LOOP_HEAT + i]
    s[FROM_Y + i], s[FROM_Z + i], s[TO_TAU + i], s[SINCE + i] = s[TO_Y + i], s[TO_Z + i], nan, 0.0
