"""The last loops of a motion, from one maximum of u to the next: what is kept of them, and whether they are alike."""

from math import inf, nan

from .. import layout as at
from ..jit import compiled
from .return_map import ALIKE, NOISE, share

MOST_LOOPS = 4  # of a cycle, from one maximum of u to the next
MANY = 32.0  # times in a row a change of less than a tolerance that leads nowhere is none
AS_LONG = 0.01  # by how much, of its duration, one loop may differ from the same one before
DRIFT = 0.01  # and by how much of the range of a cycle its maxima
SPIRAL = 100.0  # tolerances, of the range: as much for a cycle, to which the range alone may seem to have come
DISTINCT = 100.0  # tolerances, of the range, by which loops of one cycle differ, unless by AS_LONG
TIMES = 2.0  # in a row, that loops must be alike

# The last loops of a lane, the newest first: by how much u ranged in 2 MOST_LOOPS + 1 of them; the extremes in each, w'
# among them, its friction work and its duration. How often in a row u has ranged as so many loops before; how often it
# has changed little, and from what on.
_ROWS = MOST_LOOPS + 1
RANGE, *_OTHERS = at.RECURRENCE.take(2 * MOST_LOOPS + 1 + 10 * _ROWS)
HIGH, LOW, FAST, SLOW, HARD, HEAT, TIME, ALIKE_BEFORE, WITHIN, WITHIN_FROM = _OTHERS[2 * MOST_LOOPS :: _ROWS]


@compiled
def forget_loops(s, i):
    """Loops are counted from here on."""
    s[at.LOOP_STILL + i], s[at.LOOP_TAU + i] = 0.0, nan
    for row in range(RANGE, ALIKE_BEFORE, at.WIDTH):
        s[row + i] = nan
    for loops in range(MOST_LOOPS + 1):
        s[ALIKE_BEFORE + loops * at.WIDTH + i], s[WITHIN + loops * at.WIDTH + i] = 0.0, 0.0


@compiled
def keep_loop(s, i, tau, span, heat):
    """Keep the loop that ends now, and the extremes in it, as the newest."""
    for row in range(ALIKE_BEFORE - at.WIDTH, RANGE, -at.WIDTH):  # what falls into the next quantity is replaced there
        s[row + i] = s[row - at.WIDTH + i]
    s[RANGE + i] = span
    s[HIGH + i], s[LOW + i] = s[at.XI_HIGH + i], s[at.XI_LOW + i]
    s[FAST + i], s[SLOW + i] = s[at.V_HIGH + i], s[at.V_LOW + i]
    s[HARD + i], s[TIME + i], s[HEAT + i] = s[at.DW_TOP + i], tau - s[at.LOOP_TAU + i], heat - s[at.LOOP_HEAT + i]
    s[at.LOOP_TAU + i], s[at.LOOP_HEAT + i] = tau, heat


@compiled
def recurs(s, i, rtol, loops):
    """Return whether the last loops, so many, are those to which the motion tends.

    What is left of a geometric sequence of changes (Aitken) must be small; changes within the noise of steps say no
    more than that noise does where small motions hardly grow or shrink, unless the mass came to rest on the belt. Where
    steps leave more noise than that, changes within the tolerance that lead nowhere, in many such loops.
    """
    row = loops * at.WIDTH + i
    last, span, least = s[RANGE + row], 0.0, inf
    change, previous = s[RANGE + i] - last, last - s[RANGE + loops * at.WIDTH + row]
    firmness = s[at.FIRMNESS + i]
    for one in range(0, loops * at.WIDTH, at.WIDTH):
        span, least = max(span, s[RANGE + one + i]), min(least, abs(least_slip(s, i, one)))
        if s[SLOW + one + i] <= 0.0 <= s[FAST + one + i]:
            firmness = 1.0
    tolerance = rtol * span
    noise, ratio = NOISE * tolerance, abs(change / previous)
    left = abs(change) * ratio / (1.0 - ratio) if ratio < 1.0 else inf
    if abs(change) <= noise and abs(previous) <= noise:
        left = noise
    as_long = abs(s[TIME + i] - s[TIME + row]) <= AS_LONG * s[TIME + i]
    top = HIGH if s[at.B + i] > 0.0 else LOW
    moved = abs(s[top + i] - s[top + row])
    as_long = as_long and moved <= DRIFT * span  # else it rings on its way
    left = max(left / share(s, i, least), noise / firmness)
    is_alike = as_long and moved <= SPIRAL * tolerance and left <= ALIKE * tolerance
    s[ALIKE_BEFORE + row] = s[ALIKE_BEFORE + row] + 1.0 if is_alike else 0.0
    if not (as_long and abs(change) <= tolerance):
        s[WITHIN + row] = 0.0
    elif s[WITHIN + row] == 0.0:
        s[WITHIN + row], s[WITHIN_FROM + row] = 1.0, s[RANGE + i]
    else:
        s[WITHIN + row] += 1.0
    times = (s[WITHIN + row] - 1.0) / loops
    leads_nowhere = times >= MANY and times % 1.0 == 0.0 and abs(s[RANGE + i] - s[WITHIN_FROM + row]) <= tolerance
    return s[ALIKE_BEFORE + row] >= TIMES * loops or (leads_nowhere and firmness == 1.0)


@compiled
def is_repeated(s, i, rtol, loops):
    """Return whether the last loops, so many, are fewer of them several times over, and these are not certain yet."""
    for fewer in range(1, loops // 2 + 1):
        off, row = 0.0 if loops % fewer == 0 else inf, fewer * at.WIDTH + i
        for one in range(0, min(loops, MOST_LOOPS + 1 - fewer) * at.WIDTH, at.WIDTH):
            off = max(off, abs(s[RANGE + one + i] - s[RANGE + one + row]) / s[RANGE + one + i] / (DISTINCT * rtol))
            off = max(off, abs(s[TIME + one + i] - s[TIME + one + row]) / s[TIME + one + i] / AS_LONG)
        if off < 1.0:
            return True
    return False


@compiled(inline=True)
def least_slip(s, i, row):
    """Least slip speed, forwards, in a loop."""
    return s[SLOW + row + i] if s[at.B + i] > 0.0 else -s[FAST + row + i]
