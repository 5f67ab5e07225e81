"""By how much the slip after break-away misses standstill: a number whose zero is where stick-slip ends by grazing.

Row W_LEAST holds it for the slip under way. Above 0 it is the least trough of w so far; a slip that settles has the
belt speed b as its last one. Where w comes to zero at a rate v = -w', and the contact sticks, it is -v^2/(2 b): as w''
is b where w and w' vanish, that is the depth of the trough that w would have had under friction that stays as it is at
standstill, and b t^2/2 if t is the length of the stick phase until the load has risen to that friction. So value and
slope are continuous at zero, on the curve and on the line of a hysteretic one, and whatever static friction adds.

A standstill that does not stick, grazing or in passing to a slip the other way and back, makes it 0: below 0 means a
stick phase. A slip the other way that ends in a stick phase keeps what the standstill before it gave.

A verdict hangs on more than the last slip: on every trough and every standstill on the way, on whether static friction
holds the mass there, and on which side of the settling band an extremum lies. Row CLOSEST has the smallest of these
margins over the amplitude and over what errors have grown by, to be compared with the tolerance.

In the plane an area grows by the divergence of the flow, minus the drag gamma + mu', and what two motions side by side
are apart, over their speed f = (q, w'), q = w - b, as the area over f^2. So the logarithm of that, GAIN, changes by

    -drag (q^2 - w'^2)/(q^2 + w'^2),      drag = -(q + w'')/w',

and is at least 0, since errors are made anew at any time. It is large beside unstable cycles, and where slip rides on
the falling branch.
"""

from math import inf, isnan, nan

from .. import layout as at
from ..arithmetic import exp, select, widest_vectors
from ..jit import compiled

FLAT = 1e-18  # (w'/q)^2 below which rounding hides the drag


@compiled(inline=True)
def begin_margin(s, i, fresh):
    """A slip begins at standstill or, not fresh, goes on from there, forwards (b > 0) or the other way."""
    if fresh:
        s[at.W_LEAST + i], s[at.SLIP_LEAST + i], s[at.GAIN + i], s[at.GAIN_TOP + i] = inf, inf, 0.0, 0.0
    elif s[at.B + i] > 0.0:
        s[at.W_LEAST + i] = 0.0


@compiled(inline=True)
def note_trough(s, i, w):
    """A trough of w, or the value that w settles at; what rounding leaves below zero has been found to be above."""
    s[at.W_LEAST + i] = min(s[at.W_LEAST + i], max(w, 0.0))


@compiled(inline=True)
def note_closeness(s, i, margin):
    """Return what becomes of the motion was decided by this share of its amplitude."""
    s[at.CLOSEST + i] = min(s[at.CLOSEST + i], abs(margin))


@compiled(inline=True)
def note_closest_trough(s, i):
    """The least trough of the slip under way decides, too; half of what errors grow by in a dip comes after it."""
    if s[at.W_LEAST + i] > 0.0:
        note_closeness(s, i, s[at.W_LEAST + i] / s[at.AMPLITUDE + i] * exp(-0.5 * s[at.GAIN_TOP + i]))


@compiled(inline=True)
def note_gain(s, i, h, w, dw, jerk):
    """Return the growth of errors of lane i in a step over h, by the motion at its end; a turning point has none."""
    q, squared = w - s[at.B + i], dw * dw
    square = q * q
    growth = h * (q + jerk) * (square - squared) / (dw * (square + squared))
    gain = max(s[at.GAIN + i] + select(squared > FLAT * square, growth, 0.0), 0.0)
    s[at.GAIN + i] = gain
    s[at.GAIN_TOP + i] = max(s[at.GAIN_TOP + i], gain)


@compiled
def grow_errors(s):
    """The same of all lanes whose steps have been committed."""
    widest_vectors()
    for i in range(at.WIDTH):
        committed = (s[at.FLAG + i] == at.NOTHING_MET) & (s[at.GOOD + i] > 0.0)
        note_gain(s, i, select(committed, s[at.TAKEN + i], 0.0), s[at.W + i], s[at.DW + i], s[at.JERK + i])


@compiled(inline=True)
def note_standstill(s, i, dw):
    """w comes to zero at the rate dw."""
    if s[at.B + i] > 0.0:
        s[at.W_LEAST + i] = -0.5 * dw * dw / s[at.B + i]


@compiled(inline=True)
def margin_of_slip(s, i):
    """The margin of the slip under way, or of the one before the present break-away; NaN if it was not released."""
    least = min(s[at.W_LEAST + i], s[at.SLIP_LEAST + i])
    return nan if isnan(s[at.CYCLE_START + i]) or least == inf else least


# --- extremes ---------------------------------------------------------------------------------------------------------


# --- extremes -------------------------------------------------------------------------------------------------------


@compiled
def reset_extrema(s, i):
    """Reset the extremes."""
    note_range(s, i)
    s[at.XI_HIGH + i], s[at.XI_LOW + i], s[at.V_HIGH + i], s[at.V_LOW + i] = -inf, inf, -inf, inf
    s[at.DW_TOP + i] = 0.0


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


# --- verdicts -------------------------------------------------------------------------------------------------------


def reject_cell(m, c, status):
    """Of both observers of regimes: a hook."""
    m.observer.results[at.REGIME, c], m.observer.results[at.STATUS, c] = at.FAILED, status


def is_over(m, i):
    """The same."""
    return m.s[at.DECIDED + i] > 0.0 and m.observer.until != at.UNTIL_HORIZON


@compiled
def write_end(m, i, status, u, velocity):
    """How the cell of lane i ends, at u; without a verdict it is unresolved, or has failed."""
    s, results, c = m.s, m.observer.results, int(m.s[at.CELL + i])
    if s[at.DECIDED + i] == 0.0:
        unknown = status == at.HORIZON_REACHED or status == at.STEP_LIMIT
        results[at.REGIME, c] = at.UNRESOLVED if unknown else at.FAILED
    results[at.STATUS, c], results[at.STEPS, c] = status, s[at.TRIED + i]
    results[at.XI_END, c], results[at.ETA_END, c] = s[at.SIGMA + i] * u, s[at.SIGMA + i] * velocity


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
