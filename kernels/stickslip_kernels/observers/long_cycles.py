"""Cycles by the state at a maximum of u: y and w', w being that of the belt, are all there is of a motion, so that one
that comes back to an earlier such state goes through all between once more.

Of one loop, where the state forgets at once what was before; of more loops than `loops.py` compares: R. P. Brent, BIT
20 (1980) 176, compares the state with that at one maximum, which moves on after 8 loops, 16 more, 32 more ...
"""

from math import inf, nan

from .. import layout as at
from ..jit import compiled
from .loops import FAST, HARD, HIGH, LOW, MOST_LOOPS, RANGE, SLOW, SPIRAL
from .return_map import ALIKE, GENERIC

FIRST_LOOPS, MOST = 8.0, 256.0  # loops after which the maximum that others are compared with moves on
NEARLY = 1000.0  # tolerances, of the range: SPIRAL, of a shorter cycle
TIMES = 2.0  # in a row, that a cycle must have come back once it has been seen

# State at the last maximum, and by how much it had changed. State and time at the maximum that others are compared
# with, and friction work until then; loops since, and how many at most; loops of a cycle that was seen (0: none), how
# far off it came back then, and how often in a row it was close enough; extremes since.
(
    LAST_Y, LAST_DW, LAST_CHANGE, FROM_Y, FROM_DW, FROM_TAU, FROM_HEAT, LOOPS, LIMIT, LENGTH, OFF, CLOSED, ALL_HIGH,
    ALL_LOW, ALL_FAST, ALL_SLOW, ALL_HARD,
) = at.RECURRENCE.take(17)  # fmt: skip


@compiled
def forget_cycle(s, i):
    """Nothing has been seen yet."""
    s[LAST_Y + i], s[LAST_DW + i], s[LAST_CHANGE + i] = nan, nan, nan
    s[FROM_Y + i], s[LIMIT + i], s[LENGTH + i], s[CLOSED + i] = nan, FIRST_LOOPS, 0.0, 0.0
    start_from(s, i, nan, nan, nan, nan)


@compiled
def start_from(s, i, y, dw, tau, heat):
    """Later maxima are compared with this one."""
    s[FROM_Y + i], s[FROM_DW + i], s[FROM_TAU + i], s[FROM_HEAT + i], s[LOOPS + i] = y, dw, tau, heat, 0.0
    s[ALL_HIGH + i], s[ALL_LOW + i], s[ALL_FAST + i], s[ALL_SLOW + i] = -inf, inf, -inf, inf
    s[ALL_HARD + i] = 0.0


@compiled
def forgets(s, i, rtol, y, dw):
    """Return whether the state is the same at the last three maxima, though it had changed by far more before.

    At first, as much as the range of the last loop differs from that of the way from the start. The last two loops must
    range alike, too: states may differ by less than is seen and part again.
    """
    change, before = max(abs(y - s[LAST_Y + i]), abs(dw - s[LAST_DW + i])), s[LAST_CHANGE + i]
    if before != before:  # the way from the start; inf: it has fallen to nothing
        before = abs(s[RANGE + i] - s[RANGE + at.WIDTH + i])
    tolerance, moved = rtol * s[RANGE + i], abs(s[RANGE + i] - s[RANGE + at.WIDTH + i])
    fell = change <= tolerance and GENERIC * tolerance <= before < inf
    s[LAST_Y + i], s[LAST_DW + i], s[LAST_CHANGE + i] = y, dw, inf if fell else change
    return before == inf and change <= tolerance and moved <= ALIKE * tolerance


@compiled
def extend(s, i):
    """Extend the extremes by those of the last loop."""
    s[ALL_HIGH + i], s[ALL_LOW + i] = max(s[ALL_HIGH + i], s[HIGH + i]), min(s[ALL_LOW + i], s[LOW + i])
    s[ALL_FAST + i], s[ALL_SLOW + i] = max(s[ALL_FAST + i], s[FAST + i]), min(s[ALL_SLOW + i], s[SLOW + i])
    s[ALL_HARD + i] = max(s[ALL_HARD + i], s[HARD + i])


@compiled
def comes_back(s, i, rtol, y, dw, tau, heat):
    """Return whether the loops up to this maximum of u, since the one that it is compared with, are a cycle.

    It must have come back twice more after it was first seen, closer each time, or as close as steps can tell; and not
    nearly so after a half of them, a third ...: a shorter cycle that closes slowly.
    """
    if s[FROM_Y + i] != s[FROM_Y + i]:
        start_from(s, i, y, dw, tau, heat)
        return False
    extend(s, i)
    s[LOOPS + i] += 1.0
    seen = s[LENGTH + i] > 0.0
    tolerance = rtol * (s[ALL_HIGH + i] - s[ALL_LOW + i])
    off = max(abs(y - s[FROM_Y + i]), abs(dw - s[FROM_DW + i]))
    if not off <= SPIRAL * tolerance:
        if off <= NEARLY * tolerance and s[LENGTH + i] % s[LOOPS + i] == 0.0:
            s[CLOSED + i] = -inf
        if s[LOOPS + i] >= (s[LENGTH + i] if seen else s[LIMIT + i]):
            s[LIMIT + i] = s[LIMIT + i] if seen else min(2.0 * s[LIMIT + i], MOST)
            s[LENGTH + i], s[CLOSED + i] = 0.0, 0.0
            start_from(s, i, y, dw, tau, heat)
        return False
    if s[LOOPS + i] != s[LENGTH + i]:  # a part of what was seen may turn out to be all of the cycle
        s[LENGTH + i] = s[LOOPS + i] if s[LOOPS + i] > MOST_LOOPS else 0.0  # shorter ones are left to `loops.py`
        s[CLOSED + i] = 0.0
    else:
        ratio = off / s[OFF + i] if s[OFF + i] > 0.0 else 0.0
        is_close = off <= tolerance or (ratio < 1.0 and off * ratio <= ALIKE * tolerance * (1.0 - ratio))
        s[CLOSED + i] = s[CLOSED + i] + 1.0 if is_close else 0.0
        if s[CLOSED + i] >= TIMES:
            return True
    s[OFF + i] = off
    start_from(s, i, y, dw, tau, heat)
    return False
