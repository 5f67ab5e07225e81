"""Rest: the mass rides on the belt until the load breaks the contact; between breaks-away lies a cycle."""

from math import inf, isnan, nan

from .ageing import dwell_to_breakaway, static_friction
from .jit import compiled
from .layout import (
    A1, A3, AGEING, BREAKAWAY_TIME, CELL, CONTACT_START, CROSSED, CYCLE_START, DECIDED, DECIDED_BY, EARLY_STOP, G,
    HEAT, HEAT_BEFORE, HEAT_START, HORIZON_REACHED, MU_TURN, NEVER_BREAKS_AWAY, PERIOD_BEFORE, RELEASE,
    RELEASE_CHANGE, RESTICK_TIME, RESTICK_XI, RTOL, SIDE_LAST, SIGMA, SPEED_BEFORE, STICK, STICK_COUNT, STICK_SUM,
    STUCK, TAU, TAU_END, UNRESOLVED, V_HIGH, V_LOW, XI_STAR,
)  # fmt: skip
from .loops import forget_loops
from .regimes import come_to_a_point, decide, decide_stick_slip, finish, note_ends, reset_extrema, store_extrema
from .settling import note_entry_at_constant_speed
from .slip import begin_slip
from .trace import log_closed_form

RUNNING, DONE = False, True
# A re-stick shorter than the integration can resolve is a grazing contact, not a stick phase: without it the slip
# speed would have dipped below zero by b t^2 / 2, t being its length. A dip of this many tolerances is called grazing;
# one turn of an undamped oscillation loses half as much (measured at any tolerance).
GRAZING_ERRORS = 0.1
REMAINING = 1.0  # tolerances by which the cycles still to come may differ from the last


@compiled
def come_to_rest(law, s, i, cells, results, control, log, u, b, starting):
    """The slip speed is zero, at (u, b) in the present frame: stick and break away again, or slip the other way.

    The belt holds the mass while |u + gamma b| is within static friction; the load grows at the rate b, so the stick
    phase is exact.
    """
    c = int(s[CELL + i])
    gamma, tau = s[G + i], s[TAU + i]
    load = u + gamma * b
    age = cells[CONTACT_START, c] if starting else 0.0
    if abs(load) > static_friction(cells, c, age):
        if load < 0.0:
            u, b, s[SIGMA + i] = -u, -b, -s[SIGMA + i]
        begin_slip(law, s, i, cells, log, u, b, False, starting)
        return RUNNING
    if b < 0.0:
        u, b, load, s[SIGMA + i] = -u, -b, -load, -s[SIGMA + i]
    sigma = s[SIGMA + i]
    left = s[TAU_END + i] - tau
    dwell = dwell_to_breakaway(cells, c, load, b, age) if b > 0.0 else left
    amplitude = max(abs(u - sigma * s[XI_STAR + i]), b)
    grazing = not starting and 0.0 < b * dwell * dwell < 2.0 * GRAZING_ERRORS * control[RTOL] * amplitude
    if not grazing:
        s[STICK_COUNT + i] += 1.0
        if not starting and isnan(results[RESTICK_TIME, c]):
            results[RESTICK_TIME, c], results[RESTICK_XI, c] = tau, sigma * u
        note_ends(s, i, u, 0.0, 0.0)
        if s[DECIDED + i] == 0.0:
            forget_loops(s, i)
        log_closed_form(log, tau, STICK, sigma, u, 0.0)
    if b == 0.0 and s[DECIDED + i] == 0.0:
        come_to_a_point(results, c, sigma * u)
        decide(s, i, results, STUCK, NEVER_BREAKS_AWAY)
        if control[EARLY_STOP] > 0.0:
            finish(s, i, results, STUCK, NEVER_BREAKS_AWAY, sigma * u, 0.0)
            return DONE
    if dwell >= left:
        s[STICK_SUM + i] += left
        finish(s, i, results, UNRESOLVED, HORIZON_REACHED, sigma * (u + b * left), sigma * b)
        return DONE
    note_entry_at_constant_speed(s, i, tau, u, 0.0, b, dwell)
    s[TAU + i] = tau + dwell
    limit = static_friction(cells, c, age + dwell)
    u = limit - gamma * b
    if not grazing:
        s[STICK_SUM + i] += dwell
        close_cycle(s, i, cells, results, control, s[TAU + i], dwell, limit)
        if s[DECIDED + i] > 0.0 and control[EARLY_STOP] > 0.0:
            note_ends(s, i, u, 0.0, 0.0)
            finish(s, i, results, UNRESOLVED, s[DECIDED_BY + i], sigma * (u), sigma * b)
            return DONE
    # Where static friction ends on the curve, w and w' vanish together here and w'' = b > 0 lifts the mass off.
    begin_slip(law, s, i, cells, log, u, b, limit <= cells[A1, c] + cells[A3, c], not grazing)
    return RUNNING


@compiled(inline=True)
def close_cycle(s, i, cells, results, control, tau, dwell, load):
    """A break-away at tau under `load`, after a stick phase: the first starts the cycle, the second closes it.

    Without ageing the state after break-away is always the same, so one full cycle is the limit cycle, exactly. With it
    the load at break-away depends on the stick phase before: cycles follow each other until that map has converged.
    """
    c = int(s[CELL + i])
    if s[DECIDED + i] > 0.0:
        return
    if isnan(s[CYCLE_START + i]):
        results[BREAKAWAY_TIME, c] = tau
    elif cells[AGEING, c] == 0.0 or has_converged(s, i, tau, load, control[RTOL]):
        s[RELEASE + i] = load
        decide_stick_slip(s, i, results, tau, dwell)
        return
    else:
        store_extrema(s, i, results)
    s[CYCLE_START + i], s[HEAT_START + i], s[RELEASE + i] = tau, s[HEAT + i], load
    s[MU_TURN + i], s[CROSSED + i], s[SIDE_LAST + i] = nan, 0.0, 0.0
    reset_extrema(s, i)


@compiled
def has_converged(s, i, tau, load, rtol):
    """Whether the cycles still to come differ from the one that ends at tau, under `load`, by less than the tolerance.

    The load at break-away is the whole state, and near the fixed point of its return map changes shrink by a constant
    factor: their sum is that of a geometric series. What the load brings about may be far more sensitive than the load
    itself (the period by 1/b, the slip by one over the drop of friction), so period, slip speed and work are asked.
    """
    period, top = tau - s[CYCLE_START + i], max(s[V_HIGH + i], -s[V_LOW + i])
    heat = s[HEAT + i] - s[HEAT_START + i]
    change, before = abs(load - s[RELEASE + i]), s[RELEASE_CHANGE + i]
    largest = abs(period - s[PERIOD_BEFORE + i]) / period
    largest = max(largest, abs(top - s[SPEED_BEFORE + i]) / top, abs(heat - s[HEAT_BEFORE + i]) / abs(heat))
    s[RELEASE_CHANGE + i], s[PERIOD_BEFORE + i], s[SPEED_BEFORE + i], s[HEAT_BEFORE + i] = change, period, top, heat
    if before == inf:  # one change tells nothing about the next
        return False
    return change == 0.0 or (change < before and largest * change <= REMAINING * rtol * (before - change))
