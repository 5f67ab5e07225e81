"""Observer of regimes for any contact: what recurs, or comes to rest, in the motion itself. Hooks of `observers`.

It knows little of friction: a motion that stays within a band about steady sliding has settled, unless the contact says
that this repels; one whose range of u changes so little from maximum to maximum, or from every second, third or fourth
to the next such, several times in a row, that nothing is left of the change, is a cycle. What `regime.py` proves of a
friction curve it only sees.
"""

from math import inf, isnan, nan
from typing import Any, NamedTuple

from .. import contacts, observers
from .. import layout as at
from ..dense import load_and_speed
from ..intrinsics import select, widest_vectors
from ..jit import compiled
from ..machine import DONE
from ..roots import FOR_A_VALUE, arrival, extreme_speed
from . import return_map
from .return_map import ALIKE, NOISE, STICK_BELOW

BAND = 1e-4  # of the largest distance from steady sliding so far
TIMES = 2.0  # in a row, that loops must be alike
CLOSE = 1e-2  # deviation from steady sliding up to which linear theory holds
STAYS = 0.03  # by what a deviation has fallen, over that at which the motion came into the band, once it stays there
HALVINGS = 40
MOST_LOOPS = 4  # of a cycle, from one maximum of u to the next
MANY = 32.0  # times in a row a change of less than a tolerance that leads nowhere is none
AS_LONG = 0.01  # by how much, of its duration, one loop may differ from the same one before
DRIFT = 0.01  # and by how much of the range of a cycle its maxima
SPIRAL = 100.0  # tolerances, of the range: as much for a cycle, to which the range alone may seem to have come
DISTINCT = 100.0  # tolerances, of the range, by which loops of one cycle differ, unless by AS_LONG
IRREGULAR = 200.0  # loops that all stick, after which a motion that cannot settle counts as stick-slip in any case
SMALL, MOST_SMALL = 0.05, 30  # over the largest of the last ranges of u: loops that are none, unless so many in a row

# The last loops of a lane, the newest first, in room that the amplitude map has: by how much u ranged in 2 MOST_LOOPS
# + 1 of them; the extremes in each, w' among them, its friction work and its duration. How often in a row u has ranged
# as so many loops before; how often it has changed little, and from what on.
RANGE = at.INWARD
_FIRST = RANGE + (2 * MOST_LOOPS + 1) * at.WIDTH
_ROWS = (MOST_LOOPS + 1) * at.WIDTH
HIGH, LOW, FAST, SLOW, HARD, HEAT, TIME, ALIKE_BEFORE, WITHIN, WITHIN_FROM = range(_FIRST, _FIRST + 10 * _ROWS, _ROWS)
_AFTER = _FIRST + 10 * _ROWS
# Extremes while the motion sticks in every loop; those before the loop under way; in the settling band, the deviation
# at which it came there, and how often w has passed b since; FASTEST when the lane was first put ahead, NaN before.
(
    TOP, BOTTOM, FASTEST, SLOWEST, HARDEST, WHOLE_HIGH, WHOLE_LOW, WHOLE_HARD, AWAY, TURNED, REAL_FASTEST,
) = range(_AFTER, _AFTER + 11 * at.WIDTH, at.WIDTH)  # fmt: skip


class Recurrence(NamedTuple):
    """Tag of this observer, with what it fills; as `regime.Regime`."""

    results: Any
    until: int


def begin_cell(m, i, c):
    s = m.s
    s[at.DECIDED + i], s[at.AMPLITUDE + i] = 0.0, 0.0
    forget_loops(s, i)
    s[at.FASTEST + i], s[at.LOOP_STEPS + i] = 0.0, 0.0
    return_map.begin(s, i)
    s[at.ENTERED + i], s[AWAY + i], s[TURNED + i], s[REAL_FASTEST + i] = 0.0, nan, 0.0, nan
    forget(s, i)
    s[WHOLE_HIGH + i], s[WHOLE_LOW + i], s[WHOLE_HARD + i] = -inf, inf, 0.0


@compiled
def forget_loops(s, i):
    """Loops are counted from here on."""
    s[at.LOOP_STILL + i], s[at.LOOP_TAU + i] = 0.0, nan
    for row in range(RANGE, ALIKE_BEFORE, at.WIDTH):
        s[row + i] = nan
    for loops in range(MOST_LOOPS + 1):
        s[ALIKE_BEFORE + loops * at.WIDTH + i], s[WITHIN + loops * at.WIDTH + i] = 0.0, 0.0


@compiled(inline=True)
def extend_whole(s, i, high, low, hard):
    """Extend the extremes of the whole motion by others."""
    s[WHOLE_HIGH + i], s[WHOLE_LOW + i] = max(s[WHOLE_HIGH + i], high), min(s[WHOLE_LOW + i], low)
    s[WHOLE_HARD + i] = max(s[WHOLE_HARD + i], hard)


@compiled(inline=True)
def forget(s, i):
    """Extremes of a loop are counted from here on; those of the whole motion hold none after the lane was put ahead."""
    if isnan(s[REAL_FASTEST + i]):
        extend_whole(s, i, s[at.XI_HIGH + i], s[at.XI_LOW + i], s[at.DW_TOP + i])
    else:
        s[at.FASTEST + i] = s[REAL_FASTEST + i]
    s[at.XI_HIGH + i], s[at.XI_LOW + i], s[at.V_HIGH + i], s[at.V_LOW + i] = -inf, inf, -inf, inf
    s[at.DW_TOP + i] = 0.0


def is_left(m, c):
    results, status = m.observer.results, m.observer.results[at.STATUS, c]
    if status != at.NOT_RUN and status != at.STEP_UNDERFLOW and status != at.NOT_FINITE:
        return False
    for row in range(at.RESULT_ROWS):
        results[row, c] = nan
    results[at.REGIME, c], results[at.STATUS, c], results[at.STEPS, c] = at.NOT_COMPUTED, at.NOT_RUN, 0.0
    return True


def reject_cell(m, c, status):
    m.observer.results[at.REGIME, c], m.observer.results[at.STATUS, c] = at.FAILED, status


def is_over(m, i):
    return m.s[at.DECIDED + i] > 0.0 and m.observer.until != at.UNTIL_HORIZON


def finish(m, i, status, u, velocity):
    s, results, c = m.s, m.observer.results, int(m.s[at.CELL + i])
    if s[at.DECIDED + i] == 0.0:
        unknown = status == at.HORIZON_REACHED or status == at.STEP_LIMIT
        results[at.REGIME, c] = at.UNRESOLVED if unknown else at.FAILED
    results[at.STATUS, c], results[at.STEPS, c] = status, s[at.TRIED + i]
    results[at.XI_END, c], results[at.ETA_END, c] = u, velocity
    return DONE


def observe_slip_begin(m, i, u, w, fresh):
    note(m.s, i, u, w, 0.0)


def before_commit(m):
    widest_vectors()
    s = m.s
    for i in range(at.WIDTH):
        b, w, dw = s[at.B + i], s[at.W_NEW + i], s[at.DW_NEW + i]
        way = select(b < 0.0, -1.0, 1.0)  # zeros count alike for belts both ways
        dw_0, bend_0, bend = s[at.DW + i], s[at.JERK + i], s[at.JERK_NEW + i]
        turns = (way * s[at.W + i] > way * b) != (way * w > way * b)
        peaks = (way * dw_0 > 0.0) != (way * dw > 0.0)
        s[at.DW_TOP + i] = max(s[at.DW_TOP + i], abs(dw_0))
        beyond = s[at.TAKEN + i] * min(abs(bend_0), abs(bend))
        bends = (way * bend_0 > 0.0) != (way * bend > 0.0)
        peaks = peaks | (bends & (max(abs(dw_0), abs(dw)) + beyond > s[at.DW_TOP + i]))
        settled = distance_from_steady(s, i, s[at.Y_NEW + i], w) <= BAND * s[at.AMPLITUDE + i]
        s[at.SIDE_LAST_NEW + i], s[at.CROSSED_NEW + i] = s[at.SIDE_LAST + i], s[at.CROSSED + i]
        s[at.LOOK + i], s[at.TURNING + i] = select(turns | peaks | settled, 1.0, 0.0), select(turns, 1.0, 0.0)


@compiled(inline=True)
def distance_from_steady(s, i, y, w):
    """The larger of the deviations of y and w from steady sliding, whose extremes are located: of w alone under a belt
    that rests, where the load may be any.
    """
    return max(select(s[at.B + i] != 0.0, abs(y - s[at.Y_STAR + i]), 0.0), abs(w - s[at.B + i]))


def after_commit(m):
    widest_vectors()
    s = m.s
    for i in range(at.WIDTH):
        w = s[at.W + i]
        s[at.AMPLITUDE + i] = max(s[at.AMPLITUDE + i], distance_from_steady(s, i, s[at.Y + i], w))
        s[at.FASTEST + i] = max(s[at.FASTEST + i], abs(w))


def observe_step(m, i, h, y, w, dw, jerk, work):
    s, b, at_end = m.s, m.s[at.B + i], (w, dw, jerk, 0.0)
    note(s, i, y - s[at.G + i] * b, w, dw)
    if s[at.DW + i] * dw < 0.0:
        peak = extreme_speed(s, i, h, at_end, FOR_A_VALUE)[1]
        note(s, i, y - s[at.G + i] * b, peak, 0.0)
        s[at.AMPLITUDE + i] = max(s[at.AMPLITUDE + i], abs(peak - b))
    if s[at.JERK + i] * jerk < 0.0:
        s[at.DW_TOP + i] = max(s[at.DW_TOP + i], abs(contacts.extreme_slope(m, i, h, at_end)))
    start, outside = 0.0, is_outside(s, i, s[at.Y + i], s[at.W + i])
    is_beyond = w < b if b < 0.0 else w > b
    if (s[at.W + i] < b if b < 0.0 else s[at.W + i] > b) != is_beyond:
        s[TURNED + i] += 1.0
        t, rise, so_far = arrival(s, i, b, 1.0 if w > b else -1.0, h, at_end)
        u = s[at.Y + i] + rise - s[at.G + i] * b
        note(s, i, u, b, 0.0)
        off = abs(s[at.Y + i] + rise - s[at.Y_STAR + i])
        s[at.AMPLITUDE + i] = max(s[at.AMPLITUDE + i], off)
        if off > BAND * s[at.AMPLITUDE + i]:
            s[at.CROSSED + i] += 1.0
            start, outside = t, True
        if is_beyond:
            look_back(m, i, t, u, s[at.HEAT + i] + so_far)
    if outside and not is_outside(s, i, y, w):
        note_entry(s, i, start, h)


@compiled(inline=True)
def is_outside(s, i, y, w):
    """Return whether a state is outside the settling band."""
    return distance_from_steady(s, i, y, w) > BAND * s[at.AMPLITUDE + i]


@compiled
def note_entry(s, i, low, high):
    """The step of lane i comes into the settling band between two times, and stays there."""
    for _ in range(HALVINGS):
        t = 0.5 * (low + high)
        y, w = load_and_speed(s, i, t)
        if is_outside(s, i, y, w):
            low = t
        else:
            high = t
    s[at.ENTERED + i], s[AWAY + i], s[TURNED + i] = s[at.TAU + i] + high, nan, 0.0


@compiled(inline=True)
def note(s, i, u, w, dw):
    """Extend the extremes by a state."""
    s[at.XI_HIGH + i], s[at.XI_LOW + i] = max(s[at.XI_HIGH + i], u), min(s[at.XI_LOW + i], u)
    s[at.V_HIGH + i], s[at.V_LOW + i] = max(s[at.V_HIGH + i], w), min(s[at.V_LOW + i], w)
    s[at.DW_TOP + i], s[at.FASTEST + i] = max(s[at.DW_TOP + i], abs(dw)), max(s[at.FASTEST + i], abs(w))


@compiled
def look_back(m, i, t, u, heat):
    """A maximum of u, after t of the step: is what came before, in one loop or a few, that to which the motion tends?

    What rings after a slip, in the contact itself, belongs to the loop under way.
    """
    s, tau, span, largest = m.s, m.s[at.TAU + i] + t, m.s[at.XI_HIGH + i] - m.s[at.XI_LOW + i], 0.0
    for row in range(RANGE, RANGE + MOST_LOOPS * at.WIDTH, at.WIDTH):
        largest = max(largest, s[row + i]) if s[row + i] > 0.0 else largest
    s[at.LOOP_STILL + i] = s[at.LOOP_STILL + i] + 1.0 if span < SMALL * largest else 0.0
    if 0.0 < s[at.LOOP_STILL + i] < MOST_SMALL:
        return
    if s[at.LOOP_STILL + i] > 0.0:
        forget_loops(s, i)
    for row in range(ALIKE_BEFORE - at.WIDTH, RANGE, -at.WIDTH):  # what falls into the next quantity is replaced there
        s[row + i] = s[row - at.WIDTH + i]
    s[RANGE + i] = span
    s[HIGH + i], s[LOW + i] = s[at.XI_HIGH + i], s[at.XI_LOW + i]
    s[FAST + i], s[SLOW + i] = s[at.V_HIGH + i], s[at.V_LOW + i]
    s[HARD + i], s[TIME + i], s[HEAT + i] = s[at.DW_TOP + i], tau - s[at.LOOP_TAU + i], heat - s[at.LOOP_HEAT + i]
    s[at.LOOP_TAU + i], s[at.LOOP_HEAT + i] = tau, heat
    for loops in range(1, MOST_LOOPS + 1):
        if recurs(m, i, loops) and s[at.DECIDED + i] == 0.0 and not is_repeated(m, i, loops):
            tell_cycle(m, i, loops * at.WIDTH)
    if s[at.DECIDED + i] == 0.0 and m.observer.until != at.UNTIL_HORIZON:
        least, least_before = least_slip(s, i, 0), least_slip(s, i, at.WIDTH)
        y = u + s[at.G + i] * s[at.B + i]
        verdict = return_map.look_ahead(m, i, t, y, span, s[TIME + i], least, least_before)
        if verdict == return_map.CLOSED:
            tell_cycle(m, i, at.WIDTH)
        elif verdict == return_map.TOO_SLOW:
            decide_by_whole(m, i, at.UNRESOLVED, at.TOO_SLOW_TO_TELL)
    count_sticking(m, i)
    forget(s, i)
    note(s, i, u, s[at.B + i], 0.0)


@compiled
def recurs(m, i, loops):
    """Return whether the last loops, so many, are those to which the motion tends.

    What is left of a geometric sequence of changes (Aitken) must be small; changes within the noise of steps say no
    more than that noise does where small motions hardly grow or shrink, unless the mass came to rest on the belt. Where
    steps leave more noise than that, changes within the tolerance that lead nowhere, in many such loops.
    """
    s, row = m.s, loops * at.WIDTH + i
    last, span = s[RANGE + row], 0.0
    change, previous = s[RANGE + i] - last, last - s[RANGE + loops * at.WIDTH + row]
    firmness = s[at.FIRMNESS + i]
    for one in range(0, loops * at.WIDTH, at.WIDTH):
        span = max(span, s[RANGE + one + i])
        if s[SLOW + one + i] <= 0.0 <= s[FAST + one + i]:
            firmness = 1.0
    tolerance = m.rtol * span
    noise, ratio = NOISE * tolerance, abs(change / previous)
    left = abs(change) * ratio / (1.0 - ratio) if ratio < 1.0 else inf
    if abs(change) <= noise and abs(previous) <= noise:
        left = noise
    as_long = abs(s[TIME + i] - s[TIME + row]) <= AS_LONG * s[TIME + i]
    top = HIGH if s[at.B + i] > 0.0 else LOW
    moved = abs(s[top + i] - s[top + row])
    as_long = as_long and moved <= DRIFT * span  # else it rings on its way
    is_alike = as_long and moved <= SPIRAL * tolerance and max(left, noise / firmness) <= ALIKE * tolerance
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
def is_repeated(m, i, loops):
    """Return whether the last loops, so many, are fewer of them several times over, and these are not certain yet."""
    s = m.s
    for fewer in range(1, loops // 2 + 1):
        off, row = 0.0 if loops % fewer == 0 else inf, fewer * at.WIDTH + i
        for one in range(0, min(loops, MOST_LOOPS + 1 - fewer) * at.WIDTH, at.WIDTH):
            off = max(off, abs(s[RANGE + one + i] - s[RANGE + one + row]) / s[RANGE + one + i] / (DISTINCT * m.rtol))
            off = max(off, abs(s[TIME + one + i] - s[TIME + one + row]) / s[TIME + one + i] / AS_LONG)
        if off < 1.0:
            return True
    return False


@compiled
def tell_cycle(m, i, loops):
    """Write what the last loops, as many as these rows, are as a cycle."""
    s, results, c, high, low, fast, slow = m.s, m.observer.results, int(m.s[at.CELL + i]), -inf, inf, -inf, inf
    hard, time, heat = 0.0, 0.0, 0.0
    for row in range(0, loops, at.WIDTH):
        high, low = max(high, s[HIGH + row + i]), min(low, s[LOW + row + i])
        fast, slow = max(fast, s[FAST + row + i]), min(slow, s[SLOW + row + i])
        hard, time, heat = max(hard, s[HARD + row + i]), time + s[TIME + row + i], heat + s[HEAT + row + i]
    results[at.PERIOD, c], results[at.CYCLE_HEAT, c] = time, heat
    tell_attractor(m, i, high, low, fast, slow)
    if results[at.SLOWEST_SLIP, c] < STICK_BELOW * abs(s[at.B + i]):
        decide(m, i, at.STICK_SLIP, at.CYCLE_CLOSED, high, low, max(fast, -slow), hard)
    else:
        extend_whole(s, i, high, low, hard)
        s[at.FASTEST + i] = max(s[at.FASTEST + i], fast, -slow)
        decide_by_whole(m, i, at.SUSTAINED, at.SLIP_CYCLE)


@compiled
def tell_attractor(m, i, high, low, fast, slow):
    """Write the extremes of an attractor."""
    s, results, c = m.s, m.observer.results, int(m.s[at.CELL + i])
    results[at.CYCLE_XI_MAX, c], results[at.CYCLE_XI_MIN, c] = high, low
    results[at.CYCLE_SPEED_RANGE, c] = fast - slow
    results[at.SLOWEST_SLIP, c] = slow if s[at.B + i] > 0.0 else -fast


@compiled(inline=True)
def least_slip(s, i, row):
    """Least slip speed, forwards, in a loop."""
    return s[SLOW + row + i] if s[at.B + i] > 0.0 else -s[FAST + row + i]


@compiled
def count_sticking(m, i):
    """Count loops that stick, each or those before it; so many of them are stick-slip where nothing settles."""
    s, least = m.s, inf
    for row in range(0, MOST_LOOPS * at.WIDTH, at.WIDTH):
        slow = least_slip(s, i, row)
        least = min(least, slow) if slow == slow else least
    if not least < STICK_BELOW * abs(s[at.B + i]) or s[at.LOOP_STEPS + i] == 0.0:
        s[at.LOOP_STEPS + i] = 1.0 if least < STICK_BELOW * abs(s[at.B + i]) else 0.0
        s[TOP + i], s[BOTTOM + i], s[FASTEST + i], s[SLOWEST + i], s[HARDEST + i] = -inf, inf, -inf, inf, 0.0
        return
    s[at.LOOP_STEPS + i] += 1.0
    s[TOP + i], s[BOTTOM + i] = max(s[TOP + i], s[HIGH + i]), min(s[BOTTOM + i], s[LOW + i])
    s[FASTEST + i], s[SLOWEST + i] = max(s[FASTEST + i], s[FAST + i]), min(s[SLOWEST + i], s[SLOW + i])
    s[HARDEST + i] = max(s[HARDEST + i], s[HARD + i])
    if s[at.LOOP_STEPS + i] > IRREGULAR and s[at.DECIDED + i] == 0.0 and s[at.ATTRACTS + i] == 0.0:
        high, low, fast, slow = s[TOP + i], s[BOTTOM + i], s[FASTEST + i], s[SLOWEST + i]
        tell_attractor(m, i, high, low, fast, slow)
        decide(m, i, at.STICK_SLIP, at.IRREGULAR, high, low, max(fast, -slow), s[HARDEST + i])


@compiled
def decide(m, i, regime, status, high, low, fastest, hardest):
    """Write the verdict, and extremes: of u, the largest |w| and |w'|."""
    s, results, c = m.s, m.observer.results, int(m.s[at.CELL + i])
    results[at.REGIME, c], results[at.CROSSINGS, c] = regime, s[at.CROSSED + i]
    results[at.XI_MAX, c], results[at.XI_MIN, c] = high, low
    results[at.SPEED_MAX, c], results[at.ACCELERATION_MAX, c] = fastest, hardest
    s[at.DECIDED + i], s[at.DECIDED_BY + i] = 1.0, status


@compiled
def decide_by_whole(m, i, regime, status):
    """`decide`, with the extremes of the whole motion."""
    s = m.s
    high, low = max(s[WHOLE_HIGH + i], s[at.XI_HIGH + i]), min(s[WHOLE_LOW + i], s[at.XI_LOW + i])
    decide(m, i, regime, status, high, low, s[at.FASTEST + i], max(s[WHOLE_HARD + i], s[at.DW_TOP + i]))


def observe_no_event(m, i):
    if return_map.is_ahead(m.s, i):
        return_map.go_ahead(m, i)
        forget_loops(m.s, i)
        m.s[at.LOOP_TAU + i] = m.s[at.TAU + i]
        forget(m.s, i)
        if isnan(m.s[REAL_FASTEST + i]):
            m.s[REAL_FASTEST + i] = m.s[at.FASTEST + i]
        note(m.s, i, m.s[at.Y + i] - m.s[at.G + i] * m.s[at.B + i], m.s[at.B + i], 0.0)
    s = m.s
    distance = distance_from_steady(s, i, s[at.Y + i], s[at.W + i])
    s[at.AMPLITUDE + i] = max(s[at.AMPLITUDE + i], distance)
    band = BAND * s[at.AMPLITUDE + i]
    if s[at.DECIDED + i] > 0.0 or distance > band or s[at.ATTRACTS + i] == 0.0:
        return
    if s[at.B + i] == 0.0:
        if abs(s[at.DW + i]) <= band:
            decide_by_whole(m, i, at.STUCK, at.NEVER_BREAKS_AWAY)
        return
    off = contacts.deviation(m, i)
    if isnan(s[AWAY + i]):
        s[AWAY + i] = off
    stays = s[TURNED + i] >= 2.0 or off <= max(STAYS * s[AWAY + i], m.rtol)
    if stays and off < CLOSE and off * off < CLOSE * s[at.FIRMNESS + i]:
        settle(m, i)


@compiled
def settle(m, i):
    """Steady sliding is what the motion tends to."""
    s, results, c = m.s, m.observer.results, int(m.s[at.CELL + i])
    xi = s[at.XI_STAR + i]
    results[at.XI_SETTLED, c], results[at.SETTLING_TIME, c] = xi, s[at.ENTERED + i]
    results[at.CYCLE_XI_MAX, c], results[at.CYCLE_XI_MIN, c], results[at.CYCLE_SPEED_RANGE, c] = xi, xi, 0.0
    results[at.SLOWEST_SLIP, c] = abs(s[at.B + i])
    note(s, i, xi, s[at.B + i], 0.0)
    decide_by_whole(m, i, at.DAMPED if s[at.CROSSED + i] >= 2.0 else at.CREEP, at.SETTLING_OBSERVED)


observers.register(Recurrence, globals())
