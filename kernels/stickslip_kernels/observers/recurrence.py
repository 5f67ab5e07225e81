"""Observer of regimes for any contact: what recurs, or comes to rest, in the motion itself. Hooks of `observers`.

It knows little of friction: a motion that stays within a band about steady sliding has settled, unless the contact says
that this repels; one whose range of u changes so little from maximum to maximum, or from every second, third or fourth
to the next such, several times in a row, that nothing is left of the change, is a cycle; so is one whose state comes
back (`long_cycles.py`). What `regime.py` proves of a
friction curve it only sees.
"""

from math import inf, isnan, nan
from typing import Any, NamedTuple

from .. import contacts, observers
from .. import layout as at
from ..arithmetic import nonzero_bits, select, widest_vectors
from ..dense import friction_work, load_and_speed, speed
from ..jit import compiled
from ..layout import DONE, WIDTH
from ..roots import FOR_A_VALUE, extreme_speed, passage
from . import irregular, long_cycles, loops, return_map, tops, verdict
from .long_cycles import ALL_FAST, ALL_HARD, ALL_HIGH, ALL_LOW, ALL_SLOW, FROM_HEAT, FROM_TAU
from .return_map import BAND, STICK_BELOW

CLOSE = 1e-2  # deviation from steady sliding up to which linear theory holds
STAYS = 0.03  # by what a deviation has fallen, over that at which the motion came into the band, once it stays there
HALVINGS = 40
SMALL, MOST_SMALL = 0.05, 30  # over the largest of the last ranges of u: loops that are none, unless so many in a row

# Extremes before the loop under way; in the settling band, the deviation
# at which it came there, and how often w has passed b since; FASTEST when the lane was first put ahead, NaN before.
WHOLE_HIGH, WHOLE_LOW, WHOLE_HARD, AWAY, TURNED, REAL_FASTEST = at.RECURRENCE.take(6)


class Recurrence(NamedTuple):
    """Tag of this observer, with what it fills; as `regime.Regime`."""

    results: Any
    until: int


def begin_cell(m, i, c):
    s = m.s
    s[at.DECIDED + i], s[at.AMPLITUDE + i] = 0.0, 0.0
    loops.forget_loops(s, i)
    long_cycles.forget_cycle(s, i)
    s[at.FASTEST + i], s[at.LOOP_STEPS + i] = 0.0, 0.0
    return_map.begin(s, i)
    s[at.ENTERED + i], s[AWAY + i], s[TURNED + i], s[REAL_FASTEST + i] = 0.0, nan, 0.0, nan
    forget(s, i)
    s[WHOLE_HIGH + i], s[WHOLE_LOW + i], s[WHOLE_HARD + i] = -inf, inf, 0.0


@compiled(inline=True)
def forget(s, i):
    """Extremes of a loop are counted from here on; those of the whole motion hold none after the lane was put ahead."""
    if isnan(s[REAL_FASTEST + i]):
        s[WHOLE_HIGH + i] = max(s[WHOLE_HIGH + i], s[at.XI_HIGH + i])
        s[WHOLE_LOW + i] = min(s[WHOLE_LOW + i], s[at.XI_LOW + i])
        s[WHOLE_HARD + i] = max(s[WHOLE_HARD + i], s[at.DW_TOP + i])
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


def finish(m, i, status, u, velocity):
    verdict.write_end(m, i, status, u, velocity)
    return DONE


def observe_slip_begin(m, i, u, w, fresh):
    note(m.s, i, u, w, 0.0)


def observe_standstill(m, i, dw):
    m.s[at.DW_TOP + i] = max(m.s[at.DW_TOP + i], abs(dw))


def before_commit(m):
    widest_vectors()
    s = m.s
    for i in range(at.WIDTH):
        b, w, dw = s[at.B + i], s[at.W_NEW + i], s[at.DW_NEW + i]
        way = select(b < 0.0, -1.0, 1.0)  # zeros count alike for belts both ways
        turns = (way * s[at.W + i] > way * b) != (way * w > way * b)
        turning = (way * s[at.DW + i] > 0.0) != (way * dw > 0.0)
        s[at.DW_TOP + i] = max(s[at.DW_TOP + i], abs(s[at.DW + i]))
        steepest = tops.has_top_slope(s, i, s[at.TAKEN + i], dw, s[at.JERK_NEW + i])
        by_series = s[at.BY_SERIES + i] > 0.0
        look = tops.seek(s, i, by_series & turning, by_series & steepest, True)
        s[at.AMPLITUDE + i] = max(s[at.AMPLITUDE + i], distance_from_steady(s, i, s[at.Y + i], s[at.W + i]))
        settled = distance_from_steady(s, i, s[at.Y_NEW + i], w) <= BAND * s[at.AMPLITUDE + i]
        s[at.SIDE_LAST_NEW + i], s[at.CROSSED_NEW + i] = s[at.SIDE_LAST + i], s[at.CROSSED + i]
        look = look | turns | settled | ((turning | steepest) & (not by_series))
        s[at.LOOK + i], s[at.TURNING + i] = select(look, 1.0, 0.0), select(turns, 1.0, 0.0)
    if nonzero_bits(s, at.SOUGHT, WIDTH) == 0:
        return
    tops.search(s)
    for i in range(at.WIDTH):  # w passed the speed of the belt, and back
        sought, b, w = s[at.SOUGHT + i] == at.OF_SPEED, s[at.B + i], s[at.W + i]
        passed = ((s[at.TOP + i] > b) != (w > b)) & ((s[at.W_NEW + i] > b) == (w > b))
        s[at.LOOK + i] = max(s[at.LOOK + i], select(sought & passed, 1.0, 0.0))


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
        w, top = s[at.W + i], s[at.TOP + i]
        committed = (s[at.FLAG + i] == at.NOTHING_MET) & (s[at.GOOD + i] > 0.0)
        found = committed & (s[at.SOUGHT + i] == at.OF_SPEED)
        distance = max(distance_from_steady(s, i, s[at.Y + i], w), select(found, abs(top - s[at.B + i]), 0.0))
        s[at.AMPLITUDE + i] = max(s[at.AMPLITUDE + i], distance)
        s[at.FASTEST + i] = max(s[at.FASTEST + i], max(abs(w), select(found, abs(top), 0.0)))
    tops.record_tops(s)


def observe_step(m, i, h, y, w, dw, jerk, work):
    s, b, at_end = m.s, m.s[at.B + i], (w, dw, jerk, 0.0)
    note(s, i, y - s[at.G + i] * b, w, dw)
    if s[at.DW + i] * dw < 0.0:
        found = tops.is_found(s, i, h, at.OF_SPEED)
        peak = s[at.TOP + i] if found else extreme_speed(s, i, h, at_end, FOR_A_VALUE)[1]
        note(s, i, y - s[at.G + i] * b, peak, 0.0)
        s[at.AMPLITUDE + i] = max(s[at.AMPLITUDE + i], abs(peak - b))
        grazes = is_beyond(b, s[at.W + i]) == is_beyond(b, w) != is_beyond(b, peak)
        if grazes and abs(y - s[at.Y_STAR + i]) > BAND * s[at.AMPLITUDE + i]:
            s[at.CROSSED + i] += 2.0
    if s[at.JERK + i] * jerk < 0.0 and (s[at.BY_SERIES + i] == 0.0 or tops.has_top_slope(s, i, h, dw, jerk)):
        found = tops.is_found(s, i, h, at.OF_SLOPE)
        steepest = s[at.TOP + i] if found else contacts.extreme_slope(m, i, h, at_end)
        s[at.DW_TOP + i] = max(s[at.DW_TOP + i], abs(steepest))
    start, outside = 0.0, is_outside(s, i, s[at.Y + i], s[at.W + i])
    if is_beyond(b, s[at.W + i]) != is_beyond(b, w):
        s[TURNED + i] += 1.0
        t, rise, there, fallen = passage(s, i, b, h, at_end)
        u = s[at.Y + i] + rise - s[at.G + i] * b
        note(s, i, u, b, 0.0)
        off = abs(s[at.Y + i] + rise - s[at.Y_STAR + i])
        s[at.AMPLITUDE + i] = max(s[at.AMPLITUDE + i], off)
        if off > BAND * s[at.AMPLITUDE + i]:
            s[at.CROSSED + i] += 1.0
            start, outside = t, True
        if is_beyond(b, w):
            look_back(m, i, t, u, s[at.HEAT + i] + friction_work(s, i, t, rise, there, fallen))
    if outside and not is_outside(s, i, y, w):
        note_entry(s, i, start, h)


@compiled(inline=True)
def is_beyond(b, w):
    """Return whether slip is faster than the belt, in its direction."""
    return w < b if b < 0.0 else w > b


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
    verdict.note_ends(s, i, u, w, dw)
    s[at.FASTEST + i] = max(s[at.FASTEST + i], abs(w))


@compiled
def look_back(m, i, t, u, heat):
    """A maximum of u, after t of the step: is what came before, in one loop or a few, that to which the motion tends?

    What rings after a slip, in the contact itself, belongs to the loop under way.
    """
    s, tau, span, largest = m.s, m.s[at.TAU + i] + t, m.s[at.XI_HIGH + i] - m.s[at.XI_LOW + i], 0.0
    for row in range(loops.RANGE, loops.RANGE + loops.MOST_LOOPS * at.WIDTH, at.WIDTH):
        largest = max(largest, s[row + i]) if s[row + i] > 0.0 else largest
    s[at.LOOP_STILL + i] = s[at.LOOP_STILL + i] + 1.0 if span < SMALL * largest else 0.0
    if 0.0 < s[at.LOOP_STILL + i] < MOST_SMALL:
        return
    if s[at.LOOP_STILL + i] > 0.0:
        loops.forget_loops(s, i)
    loops.keep_loop(s, i, tau, span, heat)
    for number in range(1, loops.MOST_LOOPS + 1):
        if (
            loops.recurs(s, i, m.rtol, number)
            and s[at.DECIDED + i] == 0.0
            and not loops.is_repeated(s, i, m.rtol, number)
        ):
            tell_cycle(m, i, number * at.WIDTH)
    y = u + s[at.G + i] * s[at.B + i]
    if s[at.DECIDED + i] == 0.0 and m.observer.until != at.UNTIL_HORIZON:
        least, least_before = loops.least_slip(s, i, 0), loops.least_slip(s, i, at.WIDTH)
        outcome = return_map.look_ahead(m, i, t, y, span, s[loops.TIME + i], least, least_before)
        if outcome == return_map.CLOSED:
            tell_cycle(m, i, at.WIDTH)
        elif outcome == return_map.TOO_SLOW:
            decide_by_whole(m, i, at.UNRESOLVED, at.TOO_SLOW_TO_TELL)
    if s[at.DECIDED + i] == 0.0:
        tell_cycle_by_state(m, i, y, speed(s, i, t)[1], tau, heat)
    count_sticking(m, i)
    forget(s, i)
    note(s, i, u, s[at.B + i], 0.0)


@compiled
def tell_cycle(m, i, rows):
    """Write what the last loops, as many as these rows, are as a cycle."""
    s, high, low, fast, slow = m.s, -inf, inf, -inf, inf
    hard, time, heat = 0.0, 0.0, 0.0
    for row in range(0, rows, at.WIDTH):
        high, low = max(high, s[loops.HIGH + row + i]), min(low, s[loops.LOW + row + i])
        fast, slow = max(fast, s[loops.FAST + row + i]), min(slow, s[loops.SLOW + row + i])
        hard, time = max(hard, s[loops.HARD + row + i]), time + s[loops.TIME + row + i]
        heat += s[loops.HEAT + row + i]
    write_cycle(m, i, time, heat, high, low, fast, slow, hard)


@compiled
def tell_cycle_by_state(m, i, y, dw, tau, heat):
    """Is what ends at this maximum of u, in this state, a cycle that sticks: of one loop, or of many?"""
    s, limit = m.s, STICK_BELOW * abs(m.s[at.B + i])
    is_open = (
        s[return_map.TIMES + i] == return_map.MOST_FIRM and s[at.FIRMNESS + i] * return_map.ALIKE >= return_map.NOISE
    )
    if long_cycles.forgets(s, i, m.rtol, y, dw) and is_open and loops.least_slip(s, i, 0) < 0.5 * limit:
        tell_cycle(m, i, at.WIDTH)
    elif long_cycles.comes_back(s, i, m.rtol, y, dw, tau, heat):
        high, low, fast, slow = s[ALL_HIGH + i], s[ALL_LOW + i], s[ALL_FAST + i], s[ALL_SLOW + i]
        if (slow if s[at.B + i] > 0.0 else -fast) < limit:
            write_cycle(m, i, tau - s[FROM_TAU + i], heat - s[FROM_HEAT + i], high, low, fast, slow, s[ALL_HARD + i])


@compiled
def write_cycle(m, i, time, heat, high, low, fast, slow, hard):
    """Write a cycle: its period, friction work and extremes of u, w and |w'|."""
    s, results, c = m.s, m.observer.results, int(m.s[at.CELL + i])
    results[at.PERIOD, c], results[at.CYCLE_HEAT, c] = time, heat
    tell_attractor(m, i, high, low, fast, slow)
    sticks = results[at.SLOWEST_SLIP, c] < STICK_BELOW * abs(s[at.B + i])
    regime, status = (at.STICK_SLIP, at.CYCLE_CLOSED) if sticks else (at.SUSTAINED, at.SLIP_CYCLE)
    decide(m, i, regime, status, high, low, max(fast, -slow), hard)


@compiled
def tell_attractor(m, i, high, low, fast, slow):
    """Write the extremes of an attractor."""
    s, results, c = m.s, m.observer.results, int(m.s[at.CELL + i])
    results[at.CYCLE_XI_MAX, c], results[at.CYCLE_XI_MIN, c] = high, low
    results[at.CYCLE_SPEED_RANGE, c] = fast - slow
    results[at.SLOWEST_SLIP, c] = slow if s[at.B + i] > 0.0 else -fast


@compiled
def count_sticking(m, i):
    """Stick-slip that nothing will end is irregular; motions that may yet settle, or change for good, are given up."""
    s = m.s
    outcome = irregular.count(s, i, m.rtol, STICK_BELOW * abs(s[at.B + i]))
    if s[at.DECIDED + i] > 0.0:
        return
    attracts, many = s[at.ATTRACTS + i] > 0.0, s[at.LOOP_STEPS + i]
    if outcome == irregular.STAYS_SO and not attracts:
        high, low = s[irregular.TOP + i], s[irregular.BOTTOM + i]
        fast, slow = s[irregular.FAST + i], s[irregular.SLOW + i]
        tell_attractor(m, i, high, low, fast, slow)
        decide(m, i, at.STICK_SLIP, at.IRREGULAR, high, low, max(fast, -slow), s[irregular.HARD + i])
    elif outcome != irregular.GO_ON and m.observer.until != at.UNTIL_HORIZON:
        if many >= (irregular.MOST if attracts else irregular.MOST_CHANGING):
            decide_by_whole(m, i, at.UNRESOLVED, at.IRREGULAR if attracts else at.TOO_SLOW_TO_TELL)


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
        loops.forget_loops(m.s, i)
        long_cycles.forget_cycle(m.s, i)
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


observers.register(Recurrence, vars(verdict) | globals())
