"""Motions that stick again and again, never in the same way: what tells them from those that grow, or close, slowly.

The range of u differs from loop to loop, not steadily, and as much in many loops as in as many before.
"""

from math import inf

from .. import layout as at
from ..jit import compiled
from . import loops
from .loops import MOST_LOOPS, RANGE

MANY = 80.0  # loops that are compared with as many before
MOST, MOST_CHANGING = 960.0, 480.0  # loops after which a motion that may yet settle, or that changes, is given up
STEADY = 0.2  # by what share a change may differ from the one before, in a motion that grows or shrinks slowly
UNSTEADY_LOOPS, MOVED = 5.0, 0.2  # so many of the loops are not; by what share of all ranges their ends may have moved
GO_ON, CHANGES, STAYS_SO = range(3)

# Extremes of the motion since many loops; of the range of u in these loops, and in as many before; loops that were not
# steady. Row LOOP_STEPS counts loops that stick.
(
    TOP, BOTTOM, FAST, SLOW, HARD, WIDEST, NARROWEST, WIDEST_THEN, NARROWEST_THEN, UNSTEADY,
) = at.RECURRENCE.take(10)  # fmt: skip


@compiled
def begin_window(s, i):
    """Loops are counted, and extremes, from here on."""
    s[TOP + i], s[BOTTOM + i], s[FAST + i], s[SLOW + i], s[HARD + i] = -inf, inf, -inf, inf, 0.0
    s[WIDEST_THEN + i], s[NARROWEST_THEN + i], s[UNSTEADY + i] = s[WIDEST + i], s[NARROWEST + i], 0.0
    s[WIDEST + i], s[NARROWEST + i] = -inf, inf


@compiled
def count(s, i, rtol, limit):
    """Count the last loop where it, or one of those before it, sticks: is slower than the limit.

    STAYS_SO or CHANGES after many such loops, and after as many more; else GO_ON.
    """
    least = inf
    for row in range(0, MOST_LOOPS * at.WIDTH, at.WIDTH):
        slow = loops.least_slip(s, i, row)
        least = min(least, slow) if slow == slow else least
    if not least < limit or s[at.LOOP_STEPS + i] == 0.0:
        s[at.LOOP_STEPS + i], s[WIDEST + i], s[NARROWEST + i] = (1.0 if least < limit else 0.0), inf, -inf
        begin_window(s, i)
        return GO_ON
    s[at.LOOP_STEPS + i] += 1.0
    s[TOP + i], s[BOTTOM + i] = max(s[TOP + i], s[loops.HIGH + i]), min(s[BOTTOM + i], s[loops.LOW + i])
    s[FAST + i], s[SLOW + i] = max(s[FAST + i], s[loops.FAST + i]), min(s[SLOW + i], s[loops.SLOW + i])
    s[HARD + i] = max(s[HARD + i], s[loops.HARD + i])
    s[WIDEST + i], s[NARROWEST + i] = max(s[WIDEST + i], s[RANGE + i]), min(s[NARROWEST + i], s[RANGE + i])
    if not is_steady(s, i, rtol):
        s[UNSTEADY + i] += 1.0
    if s[at.LOOP_STEPS + i] % MANY != 0.0:
        return GO_ON
    moved = max(abs(s[WIDEST + i] - s[WIDEST_THEN + i]), abs(s[NARROWEST + i] - s[NARROWEST_THEN + i]))
    if moved <= MOVED * (s[WIDEST + i] - s[NARROWEST + i]) and s[UNSTEADY + i] >= UNSTEADY_LOOPS:
        return STAYS_SO
    begin_window(s, i)
    return CHANGES


@compiled
def is_steady(s, i, rtol):
    """Return whether u ranges over as much more or less than a loop before, or two to four, as it did then."""
    for row in range(at.WIDTH, (MOST_LOOPS + 1) * at.WIDTH, at.WIDTH):
        change, previous = s[RANGE + i] - s[RANGE + row + i], s[RANGE + row + i] - s[RANGE + 2 * row + i]
        if not abs(change - previous) > max(STEADY * abs(previous), rtol * s[RANGE + i]):  # NaN: too few are known
            return True
    return False
