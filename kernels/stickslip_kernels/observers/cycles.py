"""Motions that recur: return maps of stick-slip, and of slip that does not stick.

**Stick-slip**, from one break-away to the next. Without ageing the state after break-away is always the same, so one
full cycle is the limit cycle, exactly. With it the load at break-away depends on the stick phase before: cycles follow
each other until that map has converged.

**Slip**, from one maximum of u to the next. At a maximum w = b and friction lies on the curve, so u alone is the
whole state: the motion is periodic when u recurs. On a curve without hysteresis that is after one loop, since orbits
of a plane do not cross; on others after as many as return first. Every LOOPS loops u is compared with what it was.
Slip that returns within the noise of the integration, having been seen to approach what it returns to, or that
nothing damps at all, is followed once more, every extremum being looked at, and is then sustained. One that shows
nothing above the noise from the start may grow or decay too slowly to tell, unless it comes back after a push inwards
(return maps of a plane are monotone: the cycle attracts), or grows and touches standstill already. Not so where slip
changes its direction or follows a hysteretic line: that is no vibration about steady sliding, whose growth may
vanish, and what does not change in hundreds of loops is the cycle.
"""

from math import inf, isnan, log, nan

from .. import layout as at
from ..jit import compiled
from . import verdict
from .settling import is_neutral, settles_for_certain
from .spirals import is_damped
from .weak import FROM_OUTSIDE, decays_on_average, feeds_all_loops, is_caught

LOOPS = 12  # between two looks: a multiple of most lengths a cycle can have in loops
SLOWEST = 1e-5  # what changes by more of its amplitude a loop is not periodic
NOISE = 0.1  # of the tolerance: what the integration itself may add to the amplitude in a loop
RETURNS = 10.0  # tolerances within which a loop is the one it is compared with
APART = 100.0  # tolerances by which the loops of one cycle differ
UNSTABLE = 1e-4  # growth of errors in LOOPS loops that shows more than how it is summed up
ROUNDING = 1e-9  # amplitude below which rounding is seen as a change
FAR_OUT_OF_REACH = 3.0  # budgets, by a rate that may grow on the way
PUSH = 1e-3  # of the amplitude: by this much less, a cycle that attracts is come back to
NO_PUSH, TO_BE_PUSHED, PUSHED, NO_RETURN = 0.0, 1.0, 2.0, 3.0  # codes of PUSH_STATE
MOST_STILL = 20  # looks without a change that are enough to give up
REMAINING = 1.0  # tolerances by which the cycles of stick-slip still to come may differ from the last


# --- stick-slip -----------------------------------------------------------------------------------------------------


@compiled(inline=True)
def close_cycle(m, i, stick_time, load):
    """A break-away under `load`, after a stick phase: the first starts the cycle, the second closes it."""
    s, c, tau = m.s, int(m.s[at.CELL + i]), m.s[at.TAU + i]
    if s[at.DECIDED + i] > 0.0:
        return
    if isnan(s[at.CYCLE_START + i]):
        m.observer.results[at.BREAKAWAY_TIME, c] = tau if s[at.LEAPT + i] == 0.0 else nan
        if not isnan(s[at.SLIP_START + i]):  # what slipped before belongs to the whole motion
            verdict.store_extrema(m, i)
    elif m.cells[at.AGEING, c] == 0.0 or has_converged(s, i, tau, load, m.rtol):
        if s[at.LEAPT + i] == FROM_OUTSIDE and m.cells[at.AGEING, c] > 0.0 and not feeds_all_loops(m.law, s, i):
            verdict.decide(m, i, at.UNRESOLVED, at.STEP_LIMIT)
            return
        s[at.RELEASE + i] = load
        heat = s[at.HEAT + i] - s[at.HEAT_START + i]
        verdict.decide_cycle(m, i, at.STICK_SLIP, at.CYCLE_CLOSED, tau - s[at.CYCLE_START + i], stick_time, heat)
        return
    else:
        verdict.store_extrema(m, i)
    s[at.CYCLE_START + i], s[at.HEAT_START + i], s[at.RELEASE + i] = tau, s[at.HEAT + i], load
    s[at.MU_TURN + i], s[at.CROSSED + i], s[at.SIDE_LAST + i] = nan, 0.0, 0.0
    verdict.reset_extrema(s, i)


@compiled
def has_converged(s, i, tau, load, rtol):
    """Return whether the cycles to come differ from the one that ends at tau, under `load`, by less than the tolerance.

    The load at break-away is the whole state, and near the fixed point of its return map changes shrink by a constant
    factor: their sum is that of a geometric series. What the load brings about may be far more sensitive than the load
    itself (the period by 1/b, the slip by one over the drop of friction), so period, slip speed and work are asked.
    """
    period, top = tau - s[at.CYCLE_START + i], max(s[at.V_HIGH + i], -s[at.V_LOW + i])
    heat = s[at.HEAT + i] - s[at.HEAT_START + i]
    change, before = abs(load - s[at.RELEASE + i]), s[at.RELEASE_CHANGE + i]
    largest = abs(period - s[at.PERIOD_BEFORE + i]) / period
    largest = max(largest, abs(top - s[at.SPEED_BEFORE + i]) / top, abs(heat - s[at.HEAT_BEFORE + i]) / abs(heat))
    s[at.RELEASE_CHANGE + i], s[at.PERIOD_BEFORE + i] = change, period
    s[at.SPEED_BEFORE + i], s[at.HEAT_BEFORE + i] = top, heat
    if before == inf:  # one change tells nothing about the next
        return False
    return change == 0.0 or (change < before and largest * change <= REMAINING * rtol * (before - change))


# --- slip -----------------------------------------------------------------------------------------------------------


@compiled(inline=True)
def forget_loops(s, i):
    """The next maximum of u is the first."""
    s[at.LOOP_COUNT + i], s[at.LOOP_CHANGE + i], s[at.LOOP_MOVED + i], s[at.LOOP_STILL + i] = -1.0, inf, 0.0, 0.0
    s[at.CONFIRMING + i] = 0.0


@compiled
def note_loop(m, i, tau, heat, xi):
    """A maximum of u: xi there, time, and friction work until then."""
    s = m.s
    s[at.LOOP_COUNT + i] += 1.0
    if s[at.LOOP_COUNT + i] == 0.0:
        set_reference(s, i, tau, heat, xi)
    elif s[at.CONFIRMING + i] > 0.0:
        confirm_cycle(m, i, tau, heat, xi)
    elif s[at.LOOP_COUNT + i] >= LOOPS:
        compare_loops(m, i, tau, heat, xi)


@compiled
def set_reference(s, i, tau, heat, xi):
    """Loops are compared with this one from now on."""
    s[at.LOOP_COUNT + i], s[at.LOOP_XI + i], s[at.LOOP_TAU + i], s[at.LOOP_HEAT + i] = 0.0, xi, tau, heat
    s[at.LOOP_STEPS + i], s[at.RETURNED + i], s[at.HELD + i] = s[at.TRIED + i], 0.0, 0.0
    s[at.LOOP_GAIN + i] = s[at.GAIN + i]


@compiled
def compare_loops(m, i, tau, heat, xi):
    """Return whether the motion recurs; if it seems so, follow it once more."""
    s = m.s
    amplitude = 0.5 * abs(xi - s[at.TURN_BEFORE + i])
    change, before = abs(xi - s[at.LOOP_XI + i]) / (LOOPS * amplitude), s[at.LOOP_CHANGE + i]
    noise = min(NOISE * m.rtol, SLOWEST)
    if change > 10.0 * noise and amplitude > ROUNDING:
        s[at.LOOP_MOVED + i] = 1.0
    still = change <= noise or amplitude <= ROUNDING
    s[at.LOOP_STILL + i] = s[at.LOOP_STILL + i] + 1.0 if still else 0.0
    s[at.LOOP_CHANGE + i] = change
    steps = s[at.TRIED + i] - s[at.LOOP_STEPS + i]
    set_reference(s, i, tau, heat, xi)
    if amplitude > ROUNDING and seems_periodic(m, i, change, before, still):
        begin_confirming(m, i)
    elif (given_up(m, i, amplitude, change, steps, 1.0) and settles_for_certain(m.law, s, i)) or (
        given_up(m, i, amplitude, change, steps, FAR_OUT_OF_REACH) and decays_on_average(m.law, s, i)
    ):
        verdict.note_closest_trough(s, i)
        verdict.decide_settled(m, i, nan, s[at.XI_STAR + i], at.SETTLING_CERTAIN)
    elif s[at.LOOP_STILL + i] >= MOST_STILL:
        begin_confirming(m, i)


@compiled(inline=True)
def begin_confirming(m, i):
    """Follow the next loops, looking at every extremum."""
    verdict.store_extrema(m, i)
    verdict.reset_extrema(m.s, i)
    m.s[at.CONFIRMING + i] = 1.0


@compiled
def given_up(m, i, amplitude, change, steps, times):
    """Return whether so many times the steps left do not reach the settling band; the last loops took `steps`."""
    s = m.s
    loops = log(max(amplitude / s[at.BAND + i], 1.0)) / change
    return s[at.LOOP_STILL + i] >= MOST_STILL or loops * (steps / LOOPS) > times * (m.max_steps - s[at.TRIED + i])


@compiled
def seems_periodic(m, i, change, before, still):
    """Return whether the changes from look to look leave no more to come than the tolerance.

    Near a stable cycle they shrink by a constant factor, and their sum is that of a geometric series.
    """
    s = m.s
    if before > SLOWEST or change > SLOWEST:
        return False
    if still and s[at.LOOP_STILL + i] >= 2.0:
        return s[at.LOOP_MOVED + i] > 0.0 or is_neutral(m.law, s, i)
    return change < 0.5 * before and LOOPS * change * change <= m.rtol * (before - change)


@compiled
def confirm_cycle(m, i, tau, heat, xi):
    """After how many loops the state returns; after LOOPS of them the verdict, with the extremes on the way."""
    s = m.s
    amplitude, turn = 0.5 * abs(xi - s[at.TURN_BEFORE + i]), s[at.LOOP_COUNT + i]
    off, tolerance = abs(xi - s[at.LOOP_XI + i]), m.rtol * amplitude
    if off <= APART * tolerance and s[at.RETURNED + i] == 0.0:
        s[at.RETURNED + i] = turn
    if turn < LOOPS:
        return
    length, multiplier = s[at.RETURNED + i] if s[at.W_MIN + i] > 0.0 else 1.0, s[at.MULTIPLIER + i]
    s[at.MULTIPLIER + i] = 0.0
    most = RETURNS if multiplier == 0.0 else min(RETURNS, REMAINING * (1.0 - multiplier**LOOPS))
    returns = off <= most * tolerance
    if not returns or LOOPS % length != 0.0:
        s[at.CONFIRMING + i], s[at.LOOP_CHANGE + i], s[at.LOOP_STILL + i] = 0.0, inf, 0.0
        s[at.PUSH_STATE + i] = NO_RETURN if s[at.PUSH_STATE + i] == PUSHED else s[at.PUSH_STATE + i]
        set_reference(s, i, tau, heat, xi)
        return
    regime, kind, share = at.SUSTAINED, kind_of_cycle(m.law, s, i), length / LOOPS
    if kind == at.SLIP_CYCLE and s[at.LOOP_MOVED + i] == 0.0 and amplitude > ROUNDING:
        if is_kept_by_standstill(m, i, xi):
            regime, kind = at.STICK_SLIP, at.CYCLE_CLOSED
        elif s[at.PUSH_STATE + i] == NO_PUSH:
            s[at.PUSH_STATE + i] = TO_BE_PUSHED
            confirm_again(s, i, tau, heat)
            return
        elif s[at.PUSH_STATE + i] == PUSHED:  # and come back
            s[at.LOOP_MOVED + i] = 1.0
            confirm_again(s, i, tau, heat)
            return
    if amplitude <= ROUNDING or (kind == at.SLIP_CYCLE and s[at.LOOP_MOVED + i] == 0.0):
        if is_damped(m, i):
            verdict.decide_settled(m, i, nan, s[at.XI_STAR + i], at.SETTLING_CERTAIN)
        else:
            verdict.decide(m, i, at.UNRESOLVED, at.TOO_SLOW_TO_TELL)
        return
    if s[at.GAIN + i] > s[at.LOOP_GAIN + i] + UNSTABLE:  # errors grow from loop to loop: no cycle that attracts
        verdict.note_closeness(s, i, 0.0)
    period, work = (tau - s[at.LOOP_TAU + i]) * share, (heat - s[at.LOOP_HEAT + i]) * share
    verdict.decide_cycle(m, i, regime, kind, period, 0.0, work)


@compiled(inline=True)
def confirm_again(s, i, tau, heat):
    """Follow the next loops to the same reference; extrema of those before do not count."""
    set_reference(s, i, tau, heat, s[at.LOOP_XI + i])
    verdict.reset_extrema(s, i)


@compiled
def is_kept_by_standstill(m, i, xi):
    """Return whether a motion that turns at xi touches standstill to the tolerance, and every loop of it grows.

    It sticks there, in a phase too short to be resolved, and starts again from break-away: a cycle of stick-slip.
    """
    s = m.s
    touches = abs(xi - s[at.XI_STAR + i]) >= (1.0 - RETURNS * m.rtol) * s[at.B + i]
    return touches and feeds_all_loops(m.law, s, i) and is_caught(m.law, s, i)


@compiled
def kind_of_cycle(law, s, i):
    """Return what a cycle without a stick phase is made of."""
    if s[at.V_LOW + i] < 0.0 < s[at.V_HIGH + i]:
        return at.TWO_WAY_SLIP_CYCLE
    if s[at.HELD + i] > 0.0:
        return at.FALL_HOLD_CYCLE
    return at.NEUTRAL_RINGING if is_neutral(law, s, i) else at.SLIP_CYCLE
