"""Verdicts: extremes of the motion, and the verdict once it is certain.

Nothing is guessed: stick-slip is a closed cycle and a cycle of slip a return of the state (`cycles.py`), settling is
proven (`settling.py`), and a cell whose horizon or budget runs out first is `unresolved`. Functions change the slow
state and the results.
"""

from math import inf, isnan, nan

from .. import layout as at
from ..exponential import exp
from ..jit import compiled
from .margin import margin_of_slip, note_closest_trough, note_trough

# --- extremes -------------------------------------------------------------------------------------------------------


@compiled
def reset_extrema(s, i):
    """Reset the extremes."""
    note_range(s, i)
    s[at.XI_HIGH + i], s[at.XI_LOW + i], s[at.V_HIGH + i], s[at.V_LOW + i], s[at.DW_TOP + i] = (
        -inf,
        inf,
        -inf,
        inf,
        0.0,
    )


@compiled(inline=True)
def note_ends(s, i, u, w, dw):
    """Extend the extremes by a state that begins or ends a phase."""
    note_force(s, i, s[at.SIGMA + i] * u)
    note_speed(s, i, w)
    s[at.DW_TOP + i] = max(s[at.DW_TOP + i], abs(dw))


@compiled(inline=True)
def note_force(s, i, xi):
    """Extend the extremes by xi."""
    s[at.XI_HIGH + i], s[at.XI_LOW + i] = max(s[at.XI_HIGH + i], xi), min(s[at.XI_LOW + i], xi)


@compiled(inline=True)
def note_speed(s, i, w):
    """Extend the extremes of the relative speed by a slip speed in the present direction."""
    v = s[at.SIGMA + i] * w
    s[at.V_HIGH + i], s[at.V_LOW + i] = max(s[at.V_HIGH + i], v), min(s[at.V_LOW + i], v)


@compiled(inline=True)
def note_range(s, i):
    """Extend the slip speeds of the whole motion by those since the last reset."""
    high, low = s[at.V_HIGH + i], s[at.V_LOW + i]
    s[at.FASTEST + i] = max(s[at.FASTEST + i], high, -low)
    s[at.SLOWEST + i] = min(s[at.SLOWEST + i], max(low, -high, 0.0))


@compiled(inline=True)
def store_extrema(m, i):
    """Extend the extremes of the whole motion by those since the last reset."""
    s, results = m.s, m.observer.results
    c, top, steepest = int(s[at.CELL + i]), max(s[at.V_HIGH + i], -s[at.V_LOW + i], 0.0), s[at.DW_TOP + i]
    high, low = s[at.XI_HIGH + i], s[at.XI_LOW + i]
    if s[at.STORED + i] > 0.0:
        high, low = max(results[at.XI_MAX, c], high), min(results[at.XI_MIN, c], low)
        top, steepest = max(results[at.SPEED_MAX, c], top), max(results[at.ACCELERATION_MAX, c], steepest)
    results[at.XI_MAX, c], results[at.XI_MIN, c] = high, low
    results[at.SPEED_MAX, c], results[at.ACCELERATION_MAX, c] = top, steepest
    s[at.STORED + i] = 1.0


@compiled(inline=True)
def forget_extrema(results, c):
    """Those stored on the way say nothing of a motion that is not known to its end."""
    results[at.XI_MAX, c], results[at.XI_MIN, c] = nan, nan
    results[at.SPEED_MAX, c], results[at.ACCELERATION_MAX, c] = nan, nan


# --- verdicts -------------------------------------------------------------------------------------------------------


@compiled(inline=True)
def ends_with_regime(m, i):
    """Return whether lane i is over once its regime is known, its motion having all the time it needs."""
    return m.observer.until == at.UNTIL_REGIME and m.s[at.TAU_END + i] == inf


@compiled
def decide(m, i, regime, status):
    """Write the verdict and the metrics of the motion; extremes are not recorded from here on.

    The status stays NOT_RUN until the cell is finished, so that an interrupted one counts as not computed.
    """
    s, results, c = m.s, m.observer.results, int(m.s[at.CELL + i])
    results[at.REGIME, c] = regime
    store_extrema(m, i)
    results[at.MU_REVERSAL, c], results[at.CROSSINGS, c] = s[at.MU_TURN + i], s[at.CROSSED + i]
    results[at.MU_BREAKAWAY, c] = s[at.RELEASE + i]
    if regime != at.UNRESOLVED:
        results[at.RESTICK_MARGIN, c] = margin_of_slip(s, i)
        results[at.CLOSENESS, c] = min(s[at.CLOSEST + i], exp(-s[at.GAIN_TOP + i]))
    s[at.DECIDED + i], s[at.DECIDED_BY + i] = 1.0, status
    s[at.MARK + i], s[at.RADIUS2 + i], s[at.BAND2 + i] = 0.0, 0.0, 0.0


@compiled
def decide_settled(m, i, entered, xi, status):
    """The motion settles at xi: damped if it crossed the equilibrium twice, creep if not.

    entered : when it came into the settling band for good; NaN if it is not there yet.
    """
    s, results, c = m.s, m.observer.results, int(m.s[at.CELL + i])
    if s[at.LEAPT + i] > 0.0:
        entered, status = nan, at.SETTLING_CERTAIN
    results[at.SETTLING_TIME, c] = max(entered - s[at.SLIP_START + i], 0.0) if not isnan(entered) else nan
    come_to_a_point(results, c, xi)
    note_force(s, i, xi)
    note_speed(s, i, s[at.B + i])
    note_trough(s, i, s[at.B + i])
    decide(m, i, at.DAMPED if s[at.CROSSED + i] >= 2.0 else at.CREEP, status)


@compiled
def come_to_a_point(results, c, xi):
    """The attractor of cell c is the point xi."""
    results[at.XI_SETTLED, c], results[at.CYCLE_SPEED_RANGE, c] = xi, 0.0
    results[at.CYCLE_XI_MAX, c], results[at.CYCLE_XI_MIN, c] = xi, xi


@compiled(inline=True)
def decide_cycle(m, i, regime, status, period, stick_time, heat):
    """A cycle, whose extremes are those recorded last, with the time it sticks and its friction work."""
    s, results, c = m.s, m.observer.results, int(m.s[at.CELL + i])
    note_closest_trough(s, i)
    results[at.PERIOD, c], results[at.CYCLE_STICK_TIME, c], results[at.CYCLE_HEAT, c] = period, stick_time, heat
    results[at.CYCLE_XI_MAX, c], results[at.CYCLE_XI_MIN, c] = s[at.XI_HIGH + i], s[at.XI_LOW + i]
    results[at.CYCLE_SPEED_RANGE, c] = s[at.V_HIGH + i] - s[at.V_LOW + i]
    force = max(abs(s[at.XI_HIGH + i]), abs(s[at.XI_LOW + i]))
    exchanged = force * (s[at.XI_HIGH + i] - s[at.XI_LOW + i]) / abs(heat)
    if not results[at.ERROR_GROWTH, c] > exchanged:
        results[at.ERROR_GROWTH, c] = exchanged
    s[at.STORED + i] = 0.0
    decide(m, i, regime, status)
