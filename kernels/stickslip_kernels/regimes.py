"""What a motion means: the book that is kept of a cell, and the verdict once it is certain.

Nothing is guessed: stick-slip is a closed cycle (`rest.py`), settling is proven (`settling.py`), a cycle of slip is a
return of the state (`loops.py`), and a cell whose horizon or budget runs out first is `unresolved`. Functions change
the slow state and `results`.
"""

from math import inf, isnan, nan

from .friction import coefficient, coefficient_slope
from .jit import compiled
from .layout import (
    ACCELERATION_MAX, BAND2, BELT, CELL, CONFIRMING, CREEP, CROSSED, CROSSINGS, CYCLE_CLOSED, CYCLE_HEAT,
    CYCLE_SPEED_RANGE, CYCLE_START, CYCLE_STICK_TIME, CYCLE_XI_MAX, CYCLE_XI_MIN, DAMPED, DECIDED, DECIDED_BY,
    DW_HIGH, ENTERED, ETA_END, GAMMA, HEAT, HEAT_START, HELD, LOOP_CHANGE, LOOP_COUNT, LOOP_MOVED, LOOP_STILL,
    MARK, MU_BREAKAWAY, MU_REVERSAL, MU_STATIC, MU_TURN, PEAK, PEAK_BEFORE, PERIOD, QUIET_GIVEN, RADIUS2,
    REGIME, RELEASE, RELEASE_CHANGE, RETURNED, SETTLING_TIME, SIDE_LAST, SIGMA, SLIP_START, SPEED_MAX, STATUS,
    STEPS, STICKS, STICK_COUNT, STICK_SLIP, STICK_SUM, STICK_TIME, STORED, TRIED, TROUGH_TIME, TURN_BEFORE,
    TURN_LAST, V_HIGH, V_LOW, XI_END, XI_HIGH, XI_LOW, XI_MAX, XI_MIN, XI_SETTLED, XI_STAR,
)  # fmt: skip


FROM_ZERO = (
    CONFIRMING, CROSSED, DECIDED, HELD, LOOP_MOVED, LOOP_STILL, QUIET_GIVEN, RETURNED, SIDE_LAST, STICK_COUNT,
    STICK_SUM, STORED, TURN_BEFORE, TURN_LAST,
)  # fmt: skip


@compiled
def damping_ratio(law, cells, c):
    """Linear damping ratio of steady sliding on the curve, (gamma + mu'(b)) / 2; NaN where the belt stands still."""
    belt = abs(cells[BELT, c])
    if belt == 0.0:
        return nan
    return 0.5 * (cells[GAMMA, c] + coefficient_slope(law, cells, c, belt))


@compiled(inline=True)
def start_book(law, s, i, cells, c):
    """Fresh slow state for cell c in lane i."""
    for row in FROM_ZERO:
        s[row + i] = 0.0
    belt = cells[BELT, c]
    mu_belt = coefficient(law, cells, c, abs(belt))
    s[CELL + i] = c
    s[XI_STAR + i] = mu_belt if belt >= 0.0 else -mu_belt
    s[SLIP_START + i], s[CYCLE_START + i], s[MU_TURN + i] = nan, nan, nan
    s[ENTERED + i], s[TROUGH_TIME + i] = -inf, -inf
    s[PEAK + i], s[PEAK_BEFORE + i], s[LOOP_COUNT + i], s[LOOP_CHANGE + i] = inf, inf, -1.0, inf
    s[RELEASE + i], s[RELEASE_CHANGE + i] = cells[MU_STATIC, c], inf
    reset_extrema(s, i)


# --- extremes -------------------------------------------------------------------------------------------------------


@compiled
def reset_extrema(s, i):
    """Forget the extremes so far."""
    s[XI_HIGH + i], s[XI_LOW + i], s[V_HIGH + i], s[V_LOW + i], s[DW_HIGH + i] = -inf, inf, -inf, inf, 0.0


@compiled(inline=True)
def note_ends(s, i, u, w, dw):
    """Let a state that begins or ends a phase count towards the extremes."""
    note_force(s, i, s[SIGMA + i] * u)
    note_speed(s, i, w)
    s[DW_HIGH + i] = max(s[DW_HIGH + i], abs(dw))


@compiled(inline=True)
def note_force(s, i, xi):
    """Let xi count towards the extremes."""
    s[XI_HIGH + i], s[XI_LOW + i] = max(s[XI_HIGH + i], xi), min(s[XI_LOW + i], xi)


@compiled(inline=True)
def note_speed(s, i, w):
    """Let a slip speed in the present direction count towards the extremes of the relative speed."""
    v = s[SIGMA + i] * w
    s[V_HIGH + i], s[V_LOW + i] = max(s[V_HIGH + i], v), min(s[V_LOW + i], v)


@compiled(inline=True)
def store_extrema(s, i, results):
    """Let the extremes since they were last forgotten count towards those of the whole motion."""
    c, top, steepest = int(s[CELL + i]), max(s[V_HIGH + i], -s[V_LOW + i], 0.0), s[DW_HIGH + i]
    high, low = s[XI_HIGH + i], s[XI_LOW + i]
    if s[STORED + i] > 0.0:
        high, low = max(results[XI_MAX, c], high), min(results[XI_MIN, c], low)
        top, steepest = max(results[SPEED_MAX, c], top), max(results[ACCELERATION_MAX, c], steepest)
    results[XI_MAX, c], results[XI_MIN, c] = high, low
    results[SPEED_MAX, c], results[ACCELERATION_MAX, c] = top, steepest
    s[STORED + i] = 1.0


# --- verdicts -------------------------------------------------------------------------------------------------------


@compiled
def decide(s, i, results, regime, status):
    """Write the verdict and the metrics of the motion; extremes are not recorded from here on.

    The status stays NOT_RUN until the cell is finished, so that an interrupted one counts as not computed.
    """
    c = int(s[CELL + i])
    results[REGIME, c] = regime
    store_extrema(s, i, results)
    results[MU_REVERSAL, c], results[CROSSINGS, c] = s[MU_TURN + i], s[CROSSED + i]
    results[MU_BREAKAWAY, c] = s[RELEASE + i]
    s[DECIDED + i], s[DECIDED_BY + i] = 1.0, status
    s[MARK + i], s[RADIUS2 + i], s[BAND2 + i] = 0.0, 0.0, 0.0


@compiled
def decide_settled(s, i, results, entered, xi, status):
    """The motion comes to rest at xi: damped if it crossed the equilibrium twice, creep if not.

    entered : when it came into the settling band for good; NaN if it is not there yet.
    """
    c = int(s[CELL + i])
    results[SETTLING_TIME, c] = max(entered - s[SLIP_START + i], 0.0) if not isnan(entered) else nan
    come_to_a_point(results, c, xi)
    decide(s, i, results, DAMPED if s[CROSSED + i] >= 2.0 else CREEP, status)


@compiled
def come_to_a_point(results, c, xi):
    """The attractor of cell c is the point xi."""
    results[XI_SETTLED, c], results[CYCLE_SPEED_RANGE, c] = xi, 0.0
    results[CYCLE_XI_MAX, c], results[CYCLE_XI_MIN, c] = xi, xi


@compiled(inline=True)
def decide_cycle(s, i, results, regime, status, period, stick_time, heat):
    """A cycle with the extremes recorded last, with the time it sticks and its friction work."""
    c = int(s[CELL + i])
    results[PERIOD, c], results[CYCLE_STICK_TIME, c], results[CYCLE_HEAT, c] = period, stick_time, heat
    results[CYCLE_XI_MAX, c], results[CYCLE_XI_MIN, c] = s[XI_HIGH + i], s[XI_LOW + i]
    results[CYCLE_SPEED_RANGE, c] = s[V_HIGH + i] - s[V_LOW + i]
    decide(s, i, results, regime, status)


@compiled(inline=True)
def decide_stick_slip(s, i, results, tau, stick_time):
    """Break-away to break-away: stick-slip, with one stick phase in the cycle. The extremes are those of the cycle."""
    s[STORED + i] = 0.0
    heat = s[HEAT + i] - s[HEAT_START + i]
    decide_cycle(s, i, results, STICK_SLIP, CYCLE_CLOSED, tau - s[CYCLE_START + i], stick_time, heat)


@compiled
def finish(s, i, results, regime, status, xi, eta):
    """Close the cell: status, counters and final state; `regime` holds only where none was decided before."""
    c = int(s[CELL + i])
    if s[DECIDED + i] == 0.0:
        results[REGIME, c] = regime
        results[CROSSINGS, c] = s[CROSSED + i]
    results[STATUS, c] = status
    results[STEPS, c] = s[TRIED + i]
    results[STICKS, c], results[STICK_TIME, c] = s[STICK_COUNT + i], s[STICK_SUM + i]
    results[XI_END, c], results[ETA_END, c] = xi, eta
