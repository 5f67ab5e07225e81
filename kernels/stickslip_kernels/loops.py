"""Slip that comes back without sticking: the return map from one maximum of u to the next.

At a maximum w = b and friction lies on the curve, so u alone is the whole state: the motion is periodic when u comes
back, after however many loops. Every LOOPS loops u is compared with what it was. Slip that returns within the noise of
the integration, having been seen to approach what it returns to, or that nothing damps at all, is gone through once
more, every extremum being looked at, and is then sustained. One that shows nothing above the noise from the start may
grow or decay too slowly to tell. Not so where it turns round or runs down a hysteretic line: that is no vibration about
steady sliding, whose growth may vanish, and what does not change in hundreds of loops is the cycle.
"""

from math import inf, log, nan

from .jit import compiled
from .layout import (
    BAND, CONFIRMING, FALL_HOLD_CYCLE, HELD, LOOP_CHANGE, LOOP_COUNT, LOOP_HEAT, LOOP_MOVED, LOOP_STEPS,
    LOOP_STILL, LOOP_TAU, LOOP_XI, MAX_STEPS, NEUTRAL_RINGING, RETURNED, RTOL, SETTLING_CERTAIN, SLIP_CYCLE,
    SUSTAINED, TOO_SLOW_TO_TELL, TRIED, TURN_BEFORE, TWO_WAY_SLIP_CYCLE, UNRESOLVED, V_HIGH, V_LOW, XI_STAR,
)  # fmt: skip
from .regimes import decide, decide_cycle, decide_settled, reset_extrema, store_extrema
from .settling import is_neutral, settles_for_certain

LOOPS = 12  # between two looks: a multiple of most lengths a cycle can have in loops
SLOWEST = 1e-5  # what changes by more of its amplitude a loop is not periodic
NOISE = 0.1  # of the tolerance: what the integration itself may add to the amplitude in a loop
RETURNS = 10.0  # tolerances within which a loop is the one it is compared with
ROUNDING = 1e-9  # amplitude below which rounding is seen as a change
MOST_STILL = 20  # looks without a change that are enough to give up


@compiled(inline=True)
def forget_loops(s, i):
    """The next maximum of u is the first."""
    s[LOOP_COUNT + i], s[LOOP_CHANGE + i], s[LOOP_MOVED + i], s[LOOP_STILL + i] = -1.0, inf, 0.0, 0.0
    s[CONFIRMING + i] = 0.0


@compiled
def note_loop(law, s, i, results, control, tau, heat, xi):
    """A maximum of u: xi there, time, and friction work until then."""
    s[LOOP_COUNT + i] += 1.0
    if s[LOOP_COUNT + i] == 0.0:
        set_reference(s, i, tau, heat, xi)
    elif s[CONFIRMING + i] > 0.0:
        confirm_cycle(law, s, i, results, control, tau, heat, xi)
    elif s[LOOP_COUNT + i] >= LOOPS:
        compare_loops(law, s, i, results, control, tau, heat, xi)


@compiled
def set_reference(s, i, tau, heat, xi):
    """Loops are compared with this one from now on."""
    s[LOOP_COUNT + i], s[LOOP_XI + i], s[LOOP_TAU + i], s[LOOP_HEAT + i] = 0.0, xi, tau, heat
    s[LOOP_STEPS + i], s[RETURNED + i], s[HELD + i] = s[TRIED + i], 0.0, 0.0


@compiled
def compare_loops(law, s, i, results, control, tau, heat, xi):
    """Whether the motion comes back; if it seems so, go through it once more."""
    amplitude = 0.5 * abs(xi - s[TURN_BEFORE + i])
    change, before = abs(xi - s[LOOP_XI + i]) / (LOOPS * amplitude), s[LOOP_CHANGE + i]
    noise = min(NOISE * control[RTOL], SLOWEST)
    if change > 10.0 * noise and amplitude > ROUNDING:
        s[LOOP_MOVED + i] = 1.0
    still = change <= noise or amplitude <= ROUNDING
    s[LOOP_STILL + i] = s[LOOP_STILL + i] + 1.0 if still else 0.0
    s[LOOP_CHANGE + i] = change
    steps = s[TRIED + i] - s[LOOP_STEPS + i]
    set_reference(s, i, tau, heat, xi)
    if amplitude > ROUNDING and seems_periodic(law, s, i, control, change, before, still):
        begin_confirming(s, i, results)
    elif given_up(s, i, control, amplitude, change, steps) and settles_for_certain(law, s, i):
        decide_settled(s, i, results, nan, s[XI_STAR + i], SETTLING_CERTAIN)
    elif s[LOOP_STILL + i] >= MOST_STILL:
        begin_confirming(s, i, results)


@compiled(inline=True)
def begin_confirming(s, i, results):
    """Go through the next loops with an eye on every extremum."""
    store_extrema(s, i, results)
    reset_extrema(s, i)
    s[CONFIRMING + i] = 1.0


@compiled
def given_up(s, i, control, amplitude, change, steps):
    """Whether the settling band is out of reach of the steps left, the last loops having taken `steps`."""
    loops = log(max(amplitude / s[BAND + i], 1.0)) / change
    return s[LOOP_STILL + i] >= MOST_STILL or loops * (steps / LOOPS) > control[MAX_STEPS] - s[TRIED + i]


@compiled
def seems_periodic(law, s, i, control, change, before, still):
    """Whether the changes from look to look leave no more to come than the tolerance.

    Near a stable cycle they shrink by a constant factor, and their sum is that of a geometric series.
    """
    if before > SLOWEST or change > SLOWEST:
        return False
    if still and s[LOOP_STILL + i] >= 2.0:
        return s[LOOP_MOVED + i] > 0.0 or is_neutral(law, s, i)
    return change < 0.5 * before and LOOPS * change * change <= control[RTOL] * (before - change)


@compiled
def confirm_cycle(law, s, i, results, control, tau, heat, xi):
    """After how many loops the state returns; after LOOPS of them the verdict, with the extremes on the way."""
    amplitude, turn = 0.5 * abs(xi - s[TURN_BEFORE + i]), s[LOOP_COUNT + i]
    returns = abs(xi - s[LOOP_XI + i]) <= RETURNS * control[RTOL] * amplitude
    if returns and s[RETURNED + i] == 0.0:
        s[RETURNED + i] = turn
    if turn < LOOPS:
        return
    length = s[RETURNED + i]
    if not returns or LOOPS % length != 0.0:
        s[CONFIRMING + i], s[LOOP_CHANGE + i], s[LOOP_STILL + i] = 0.0, inf, 0.0
        set_reference(s, i, tau, heat, xi)
        return
    kind, share = kind_of_cycle(law, s, i), length / LOOPS
    if amplitude <= ROUNDING or (kind == SLIP_CYCLE and s[LOOP_MOVED + i] == 0.0):
        decide(s, i, results, UNRESOLVED, TOO_SLOW_TO_TELL)
        return
    period, work = (tau - s[LOOP_TAU + i]) * share, (heat - s[LOOP_HEAT + i]) * share
    decide_cycle(s, i, results, SUSTAINED, kind, period, 0.0, work)


@compiled
def kind_of_cycle(law, s, i):
    """What a cycle without a stick phase is made of."""
    if s[V_LOW + i] < 0.0 < s[V_HIGH + i]:
        return TWO_WAY_SLIP_CYCLE
    if s[HELD + i] > 0.0:
        return FALL_HOLD_CYCLE
    return NEUTRAL_RINGING if is_neutral(law, s, i) else SLIP_CYCLE
