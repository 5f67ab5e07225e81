"""Observer of regimes, on a steady belt: what becomes of a motion, and the metrics of its cycle. Hooks of `observers`.

Extrema (`extrema.py`), cycles (`cycles.py`) and settling (`settling.py`, `on_line.py`) are looked for where the machine
says that something happened; the verdict (`verdict.py`) ends the cell, or lets it run to the horizon.
"""

from math import inf, isnan, nan
from typing import Any, NamedTuple

from .. import layout as at
from .. import observers
from ..arithmetic import exp, select, widest_vectors
from ..contacts.stribeck.friction import coefficient_slope, least_coefficient, stable_speeds
from ..contacts.stribeck.hysteresis import along_line
from ..jit import compiled
from ..layout import DONE
from ..roots import NO_EVENT, TURNED
from . import amplitudes, extrema, settling, tops, verdict
from .cycles import PUSH, PUSHED, RETURNS, TO_BE_PUSHED, close_cycle, forget_loops
from .on_line import record_line, settle_on_line
from .slow import comes_to_rest, pass_slowly
from .spirals import is_damped
from .weak import decays_on_average, leaps, put

# A trough this close to the belt speed, in settling bands, is steady sliding on the line: the drift that is left takes
# a million times as long to matter.
STANDSTILL = 1e-6
ROUNDING = 1e-12  # of friction at rest, below which a negative coefficient is zero
FIRST_PAUSE, AFTER_PASSING = 400.0, 64.0  # steps after which stock is taken, in the beginning and after a slow passage
LEAP_SHARE, AFTER_LEAP = 0.25, 2000.0  # of the steps, before motions leap ahead; from one look at these to the next
FROM_ZERO = (
    at.CONFIRMING, at.CROSSED, at.DECIDED, at.HELD, at.INWARD, at.LEAPT, at.LOOP_MOVED, at.LOOP_STILL, at.MAP_STATE,
    at.MAP_TO, at.PUSH_STATE, at.RETURNED, at.SIDE_LAST, at.STICK_COUNT, at.STICK_SUM, at.STORED, at.TURN_BEFORE,
    at.TURN_LAST,
)  # fmt: skip


class Regime(NamedTuple):
    """Tag of this observer, with what it fills.

    results : float64 (RESULT_ROWS, n) from `layout.new_regimes`. until : how far a cell is followed, a code of
        `layout.py`.
    """

    results: Any
    until: int


# --- a cell begins and ends -----------------------------------------------------------------------------------------


def begin_cell(m, i, c):
    s, belt = m.s, abs(m.cells[at.BELT, c])
    for row in FROM_ZERO:
        s[row + i] = 0.0
    s[at.STABLE_FROM + i], s[at.STABLE_TO + i] = stable_speeds(m.law, m.cells, c)
    s[at.SLIP_START + i], s[at.CYCLE_START + i], s[at.MU_TURN + i] = nan, nan, nan
    s[at.ENTERED + i], s[at.TROUGH_TIME + i], s[at.MAP_REST + i] = -inf, -inf, -inf
    s[at.MAP_TAU + i], s[at.MULTIPLIER + i] = -inf, 0.0
    s[at.PEAK + i], s[at.PEAK_BEFORE + i], s[at.LOOP_COUNT + i], s[at.LOOP_CHANGE + i] = inf, inf, -1.0, inf
    s[at.RELEASE + i], s[at.RELEASE_CHANGE + i] = m.cells[at.MU_STATIC, c], inf
    s[at.MARK + i], s[at.PAUSE + i] = 1.0, min(FIRST_PAUSE, m.max_steps)
    verdict.reset_extrema(s, i)
    s[at.FASTEST + i], s[at.SLOWEST + i], s[at.CLOSEST + i] = 0.0, inf, inf
    s[at.W_LEAST + i], s[at.SLIP_LEAST + i] = inf, inf
    s[at.GAIN + i], s[at.GAIN_TOP + i] = 0.0, 0.0
    # Linear damping ratio of steady sliding on the curve, (gamma + mu'(b))/2; NaN where the belt is at rest.
    ratio = 0.5 * (m.cells[at.GAMMA, c] + coefficient_slope(m.law, m.cells, c, belt))
    m.observer.results[at.DAMPING_RATIO, c] = ratio if belt > 0.0 else nan


def after_pause(m, i):
    """Many steps may be stiff ones."""
    s = m.s
    tried = s[at.TRIED + i]
    if s[at.MAP_STATE + i] == amplitudes.MEASURING:
        s[at.PAUSE + i] = min(m.max_steps, tried + AFTER_PASSING)
        return
    if s[at.DECIDED + i] == 0.0 and comes_to_rest(m, i):
        return
    steps = AFTER_PASSING if pass_slowly(m, i) else tried
    if s[at.DECIDED + i] == 0.0 and tried >= LEAP_SHARE * m.max_steps:
        steps = min(steps, AFTER_LEAP)
        if s[at.LEAPT + i] > 0.0 and (settling.settles_for_certain(m.law, s, i) or decays_on_average(m.law, s, i)):
            verdict.decide_settled(m, i, nan, s[at.XI_STAR + i], at.SETTLING_CERTAIN)
        elif leaps(m, i):
            forget_loops(s, i)
    s[at.PAUSE + i] = min(m.max_steps, tried + steps)
    extrema.show_tops(m, i)


def status_out_of_steps(m, i):
    if m.s[at.MAP_STATE + i] == amplitudes.MEASURING:
        amplitudes.refuse_map(m, i)
    law, s = m.law, m.s
    settles = settling.settles_for_certain(law, s, i) or is_damped(m, i) or decays_on_average(law, s, i)
    if s[at.DECIDED + i] == 0.0 and settles:
        verdict.note_closest_trough(s, i)
        verdict.decide_settled(m, i, nan, s[at.XI_STAR + i], at.SETTLING_CERTAIN)
        return at.SETTLING_CERTAIN
    return at.STEP_LIMIT


def finish(m, i, status, u, velocity):
    s, results, c = m.s, m.observer.results, int(m.s[at.CELL + i])
    was_negative = friction_was_negative(m, i, c, abs(m.cells[at.BELT, c] - s[at.SIGMA + i] * velocity))
    verdict.write_end(m, i, at.NEGATIVE_FRICTION if was_negative else status, u, velocity)
    if was_negative:
        results[at.REGIME, c] = at.FAILED
    elif s[at.DECIDED + i] == 0.0:  # extremes stored on the way say nothing of a motion that is not known to its end
        results[at.CROSSINGS, c] = s[at.CROSSED + i]
        for row in (at.XI_MAX, at.XI_MIN, at.SPEED_MAX, at.ACCELERATION_MAX):
            results[row, c] = nan
    results[at.STICKS, c], results[at.STICK_TIME, c] = s[at.STICK_COUNT + i], s[at.STICK_SUM + i]
    return DONE


@compiled(inline=True)
def friction_was_negative(m, i, c, w_end):
    """Return whether the motion, now at slip speed w_end, went through speeds at which friction would drive it."""
    s, cells = m.s, m.cells
    if cells[at.A2, c] >= 0.0 and cells[at.A3, c] >= 0.0:
        return False
    verdict.note_range(s, i)
    slowest = min(s[at.SLOWEST + i], max(min(s[at.W_LEAST + i], s[at.SLIP_LEAST + i]), 0.0))
    fastest = s[at.FASTEST + i]
    if w_end > fastest:  # no extreme yet, or one of a motion that was not followed to its end
        fastest = w_end
    if w_end < slowest:
        slowest = w_end
    least = least_coefficient(m.law, cells, c, min(slowest, fastest), fastest)
    return least < -ROUNDING * (cells[at.A1, c] + abs(cells[at.A3, c]))


# --- slip on the curve ----------------------------------------------------------------------------------------------


def before_commit(m):
    """Look at extrema worth it, at entries into the settling band, and inside the disc of `proven_radius`.

    A quiet turn of u is counted here, as `note_turn` and `note_loop` count the others.
    """
    widest_vectors()
    s, exact = m.s, tops.has_exact_derivatives(m.law)
    for i in range(at.WIDTH):
        h, y, w, dw, jerk = s[at.TAKEN + i], s[at.Y_NEW + i], s[at.W_NEW + i], s[at.DW_NEW + i], s[at.JERK_NEW + i]
        turn, quiet = extrema.turns(s, i, w), extrema.turns_quietly(s, i, h, y, w)
        marked = s[at.MARK + i] > 0.0
        peak, each = extrema.has_top_speed(s, i, h, w, dw) & marked, s[at.W_TOP + i] == -inf
        slope, trough = (
            extrema.has_top_slope(s, i, h, dw, jerk) & marked,
            extrema.has_low_speed(s, i, h, w, dw) & marked,
        )
        loud = turn & (not quiet) & marked
        look = tops.seek(s, i, peak | trough, slope, exact) | (peak & each)
        look = look | loud | settling.comes_into_band(s, i, y, w)
        look = look | (settling.distance2_from_sliding(s, i, y, w) < s[at.RADIUS2 + i])
        s[at.LOOK + i], s[at.TURNING + i] = select(look, 1.0, 0.0), select(loud, 1.0, 0.0)
        counts, maximum = turn & quiet, w > s[at.B + i]
        side = select(maximum, 1.0, -1.0)
        crosses = counts & (side * s[at.SIDE_LAST + i] < 0.0)
        s[at.SIDE_LAST_NEW + i] = select(counts, side, s[at.SIDE_LAST + i])
        s[at.CROSSED_NEW + i] = s[at.CROSSED + i] + select(crosses, 1.0, 0.0)
        s[at.LOOP_COUNT_NEW + i] = s[at.LOOP_COUNT + i] + select(counts & maximum, 1.0, 0.0)
    tops.search(s)
    tops.confirm_slopes(m.law, s)


def after_commit(m):
    tops.record_tops(m.s)
    verdict.grow_errors(m.s)


def observe_slip_begin(m, i, u, w, fresh):
    s = m.s
    if isnan(s[at.SLIP_START + i]):
        s[at.SLIP_START + i] = s[at.TAU + i]
    verdict.begin_margin(s, i, fresh)
    if fresh and s[at.DECIDED + i] == 0.0:
        settling.set_band(s, i, u, w, s[at.B + i])
    if s[at.SIDE_LAST + i] == 0.0:
        extrema.note_side(s, i, s[at.SIGMA + i] * u)


def watch_from(m, i, u):
    s = m.s
    s[at.RADIUS2 + i] = settling.proven_radius(m, i) ** 2
    verdict.note_ends(s, i, u, s[at.W + i], s[at.DW + i])
    extrema.show_tops(m, i)


def observe_step(m, i, h, y, w, dw, jerk, work):
    if m.s[at.MAP_STATE + i] == amplitudes.MEASURING:
        amplitudes.note_half_loop(m, i, h, w, dw, jerk)
        return
    verdict.note_gain(m.s, i, h, w, dw, jerk)
    if m.s[at.MARK + i] > 0.0:
        extrema.record_extrema(m, i, h, w, dw, jerk)
    settling.note_entry(m.s, i, h, y, w)


def observe_no_event(m, i):
    if m.s[at.MAP_STATE + i] == amplitudes.TO_BEGIN:
        amplitudes.begin_map(m, i)
        return
    if m.s[at.MAP_STATE + i] == amplitudes.CORRECTED:
        amplitudes.confirm_corrected(m, i)
    if m.s[at.MAP_STATE + i] == amplitudes.MEASURING:
        amplitudes.follow_map(m, i)
        if m.s[at.MAP_STATE + i] == amplitudes.MEASURING:
            return
        m.s[at.RADIUS2 + i] = settling.proven_radius(m, i) ** 2
    if m.s[at.PUSH_STATE + i] == TO_BE_PUSHED:
        push(m, i)
    if m.s[at.MARK + i] > 0.0:
        extrema.show_tops(m, i)
    settling.check_settling(m, i)


@compiled
def push(m, i):
    """Push the motion of lane i inwards: does it come back?"""
    s = m.s
    share = 1.0 - max(PUSH, 100.0 * RETURNS * m.rtol)
    put(m, i, share * (s[at.Y + i] - s[at.Y_STAR + i]), share * (s[at.W + i] - s[at.B + i]))
    s[at.PUSH_STATE + i] = PUSHED


def observe_mode_end(m, i, u, kind):
    s = m.s
    if s[at.MAP_STATE + i] == amplitudes.MEASURING:
        amplitudes.refuse_map(m, i)
        return True
    if s[at.MAP_STATE + i] == amplitudes.TO_BEGIN or s[at.MAP_STATE + i] >= amplitudes.ON_CYCLE:
        s[at.MAP_STATE + i] = amplitudes.OVER
    verdict.note_ends(s, i, u, s[at.W + i], s[at.DW + i])
    if kind == TURNED:
        extrema.note_peak(s, i, s[at.W + i] - s[at.B + i])
    return False


# --- the other modes ------------------------------------------------------------------------------------------------


def observe_constant_speed(m, i, u, b, w, duration):
    s = m.s
    settling.note_entry_at_constant_speed(s, i, s[at.TAU + i], u, w, b, duration)
    if w > 0.0:
        load = u + s[at.G + i] * (b - w)
        s[at.HEAT + i] += w * duration * (load + 0.5 * (b - w) * duration)


def observe_line(m, i, line, u, w, dw, duration):
    record_line(m, i, line, u, w, dw, duration)


def stays_on_line(m, i, line, u, w, dw, kind, t):
    s, left = m.s, m.s[at.TAU_END + i] - m.s[at.TAU + i]
    if kind == NO_EVENT:
        settle_on_line(m, i, line, u, w, dw, left, at.SETTLED)
        return True
    if kind == TURNED and t < left:
        drift = s[at.B + i] - along_line(m, i, w, dw, line.drag, t)[0]
        if 0.0 <= drift < STANDSTILL * s[at.BAND + i]:
            settle_on_line(m, i, line, u, w, dw, left, at.SETTLING_OBSERVED)
            return True
    return False


def observe_standstill(m, i, dw):
    m.s[at.MAP_REST + i] = m.s[at.TAU + i]
    verdict.note_closest_trough(m.s, i)
    verdict.note_standstill(m.s, i, dw)


def observe_trough(m, i, u, w):
    s, b = m.s, m.s[at.B + i]
    s[at.MAP_REST + i] = s[at.TAU + i]
    verdict.note_trough(s, i, w)
    verdict.note_closest_trough(s, i)
    s[at.HELD + i] = 1.0
    if s[at.DECIDED + i] == 0.0 and settling.is_shrinking(s, i, m.cells, u, w, b):
        verdict.decide_settled(m, i, s[at.ENTERED + i], s[at.XI_STAR + i], at.SETTLING_OBSERVED)


def observe_load_that_stays(m, i, u, b):
    if b == 0.0 and m.s[at.DECIDED + i] == 0.0:
        verdict.note_ends(m.s, i, u, 0.0, 0.0)
        verdict.come_to_a_point(m.observer.results, int(m.s[at.CELL + i]), m.s[at.SIGMA + i] * u)
        verdict.decide(m, i, at.STUCK, at.NEVER_BREAKS_AWAY)


def observe_contact(m, i, room, comes_back):
    s = m.s
    share = exp(-s[at.GAIN + i]) / s[at.AMPLITUDE + i]
    verdict.note_closeness(s, i, share * room)
    if not comes_back:
        verdict.note_closeness(s, i, share * s[at.W_LEAST + i])


def observe_stick(m, i, start, u_start, load, after_slip, thrown):
    s, results, c = m.s, m.observer.results, int(m.s[at.CELL + i])
    if thrown:
        return
    s[at.STICK_COUNT + i] += 1.0
    s[at.STICK_SUM + i] += s[at.TAU + i] - start
    if after_slip and isnan(results[at.RESTICK_TIME, c]) and s[at.LEAPT + i] == 0.0:
        results[at.RESTICK_TIME, c], results[at.RESTICK_XI, c] = start, s[at.SIGMA + i] * u_start
        if isnan(s[at.CYCLE_START + i]) and m.observer.until != at.UNTIL_REGIME:  # it began in slip
            results[at.ERROR_GROWTH, c] = exp(s[at.GAIN + i])
    verdict.note_ends(s, i, u_start, 0.0, 0.0)
    if s[at.DECIDED + i] == 0.0:
        forget_loops(s, i)


def observe_breakaway(m, i, start, load, thrown):
    if not thrown:
        close_cycle(m, i, m.s[at.TAU + i] - start, load)


observers.register(Regime, vars(verdict) | globals())
