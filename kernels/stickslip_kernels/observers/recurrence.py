"""Observer of regimes for any contact: what recurs, or comes to rest, in the motion itself. Hooks of `observers`.

It knows little of friction: a motion that stays within a band about steady sliding has settled, unless the contact says
that this repels; one whose range of u changes so little from maximum to maximum, several times in a row,
that nothing is left of the change, is a cycle. What `regime.py` proves of a friction curve it only sees.
"""

from math import inf, isnan, nan
from typing import Any, NamedTuple

from .. import contacts, observers
from .. import layout as at
from ..intrinsics import select, widest_vectors
from ..jit import compiled
from ..machine import DONE
from ..roots import FOR_A_VALUE, arrival, extreme_speed

BAND = 1e-4  # of the largest distance from steady sliding so far
ALIKE = 10.0  # tolerances, of the range, by which a cycle may differ from its limit ...
TIMES = 2.0  # ... so often in a row
NOISE = 0.01  # tolerances, of the range: smaller changes are those of steps
STICK_BELOW = 1e-3  # least slip speed over that of the belt, below which a cycle counts as stick-slip


class Recurrence(NamedTuple):
    """Tag of this observer, with what it fills; as `regime.Regime`."""

    results: Any
    until: int


def begin_cell(m, i, c):
    s = m.s
    s[at.DECIDED + i], s[at.LOOP_STILL + i], s[at.AMPLITUDE + i] = 0.0, 0.0, 0.0
    s[at.LOOP_XI + i], s[at.LOOP_CHANGE + i], s[at.LOOP_TAU + i], s[at.LOOP_HEAT + i] = nan, nan, nan, 0.0
    s[at.FASTEST + i] = 0.0
    forget(s, i)


@compiled(inline=True)
def forget(s, i):
    """Extremes are counted from here on."""
    s[at.XI_HIGH + i], s[at.XI_LOW + i], s[at.V_HIGH + i], s[at.V_LOW + i] = -inf, inf, -inf, inf
    s[at.DW_TOP + i] = 0.0


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
        b, w, dw, good = s[at.B + i], s[at.W_NEW + i], s[at.DW_NEW + i], s[at.GOOD + i] > 0.0
        turns = (s[at.W + i] > b) != (w > b)
        peaks = (s[at.DW + i] > 0.0) != (dw > 0.0)
        p, q = s[at.Y_NEW + i] - s[at.Y_STAR + i], w - b
        distance = (p * p + q * q) ** 0.5
        farthest = max(s[at.AMPLITUDE + i], distance)
        s[at.AMPLITUDE + i] = select(good, farthest, s[at.AMPLITUDE + i])
        s[at.DW_TOP + i] = select(good, max(s[at.DW_TOP + i], abs(dw)), s[at.DW_TOP + i])
        s[at.FASTEST + i] = select(good, max(s[at.FASTEST + i], abs(w)), s[at.FASTEST + i])
        settled = max(distance, abs(dw)) < BAND * farthest
        s[at.SIDE_LAST_NEW + i], s[at.CROSSED_NEW + i] = s[at.SIDE_LAST + i], s[at.CROSSED + i]
        s[at.LOOK + i], s[at.TURNING + i] = select(turns | peaks | settled, 1.0, 0.0), select(turns, 1.0, 0.0)


def observe_step(m, i, h, y, w, dw, jerk, work):
    s, b, at_end = m.s, m.s[at.B + i], (w, dw, jerk, 0.0)
    note(s, i, y - s[at.G + i] * b, w, dw)
    if s[at.DW + i] * dw < 0.0:
        note(s, i, y - s[at.G + i] * b, extreme_speed(s, i, h, at_end, FOR_A_VALUE)[1], 0.0)
    if (s[at.W + i] > b) != (w > b):
        t, rise, so_far = arrival(s, i, b, 1.0 if w > b else -1.0, h, at_end)
        note(s, i, s[at.Y + i] + rise - s[at.G + i] * b, b, 0.0)
        if abs(s[at.Y + i] + rise - s[at.Y_STAR + i]) > BAND * s[at.AMPLITUDE + i]:
            s[at.CROSSED + i] += 1.0
        if w > b:
            look_back(m, i, s[at.TAU + i] + t, s[at.HEAT + i] + so_far)


@compiled(inline=True)
def note(s, i, u, w, dw):
    """Extend the extremes by a state."""
    s[at.XI_HIGH + i], s[at.XI_LOW + i] = max(s[at.XI_HIGH + i], u), min(s[at.XI_LOW + i], u)
    s[at.V_HIGH + i], s[at.V_LOW + i] = max(s[at.V_HIGH + i], w), min(s[at.V_LOW + i], w)
    s[at.DW_TOP + i], s[at.FASTEST + i] = max(s[at.DW_TOP + i], abs(dw)), max(s[at.FASTEST + i], abs(w))


@compiled
def look_back(m, i, tau, heat):
    """A maximum of u at tau: is the last loop that to which the loops before tend?

    What is left of a geometric sequence of changes (Aitken) must be small; changes within the noise of steps say no
    more than that noise does where small motions hardly grow or shrink.
    """
    s, results, c, span = m.s, m.observer.results, int(m.s[at.CELL + i]), m.s[at.XI_HIGH + i] - m.s[at.XI_LOW + i]
    change, before, noise = span - s[at.LOOP_XI + i], s[at.LOOP_CHANGE + i], NOISE * m.rtol * span
    ratio = abs(change / before)
    left = abs(change) * ratio / (1.0 - ratio) if ratio < 1.0 else inf
    if abs(change) <= noise and abs(before) <= noise:
        left = noise
    is_alike = max(left, noise / s[at.FIRMNESS + i]) <= ALIKE * m.rtol * span
    s[at.LOOP_STILL + i] = s[at.LOOP_STILL + i] + 1.0 if is_alike else 0.0
    if s[at.DECIDED + i] == 0.0 and s[at.LOOP_STILL + i] >= TIMES:
        results[at.PERIOD, c], results[at.CYCLE_HEAT, c] = tau - s[at.LOOP_TAU + i], heat - s[at.LOOP_HEAT + i]
        results[at.CYCLE_XI_MAX, c], results[at.CYCLE_XI_MIN, c] = s[at.XI_HIGH + i], s[at.XI_LOW + i]
        results[at.CYCLE_SPEED_RANGE, c] = s[at.V_HIGH + i] - s[at.V_LOW + i]
        results[at.SLOWEST_SLIP, c] = s[at.V_LOW + i]
        sticks = s[at.V_LOW + i] < STICK_BELOW * abs(s[at.B + i])
        decide(m, i, at.STICK_SLIP if sticks else at.SUSTAINED, at.CYCLE_CLOSED if sticks else at.SLIP_CYCLE)
    s[at.LOOP_XI + i], s[at.LOOP_CHANGE + i], s[at.LOOP_TAU + i], s[at.LOOP_HEAT + i] = span, change, tau, heat
    forget(s, i)


@compiled
def decide(m, i, regime, status):
    """Write the verdict, and the extremes of what was seen last."""
    s, results, c = m.s, m.observer.results, int(m.s[at.CELL + i])
    results[at.REGIME, c], results[at.CROSSINGS, c] = regime, s[at.CROSSED + i]
    results[at.XI_MAX, c], results[at.XI_MIN, c] = s[at.XI_HIGH + i], s[at.XI_LOW + i]
    results[at.SPEED_MAX, c], results[at.ACCELERATION_MAX, c] = s[at.FASTEST + i], s[at.DW_TOP + i]
    s[at.DECIDED + i], s[at.DECIDED_BY + i] = 1.0, status


def observe_no_event(m, i):
    s, results, c = m.s, m.observer.results, int(m.s[at.CELL + i])
    p, q = s[at.Y + i] - s[at.Y_STAR + i], s[at.W + i] - s[at.B + i]
    distance, may_rest = (p * p + q * q) ** 0.5, s[at.DECIDED + i] == 0.0 and s[at.ATTRACTS + i] > 0.0
    s[at.AMPLITUDE + i] = max(s[at.AMPLITUDE + i], distance)
    in_band = max(distance, abs(s[at.DW + i])) < BAND * s[at.AMPLITUDE + i]
    if may_rest and in_band and contacts.is_near_steady(m, i):
        xi = s[at.XI_STAR + i]
        results[at.XI_SETTLED, c], results[at.SETTLING_TIME, c] = xi, s[at.TAU + i]
        results[at.CYCLE_XI_MAX, c], results[at.CYCLE_XI_MIN, c], results[at.CYCLE_SPEED_RANGE, c] = xi, xi, 0.0
        results[at.SLOWEST_SLIP, c] = s[at.B + i]
        if isnan(s[at.LOOP_TAU + i]):
            note(s, i, xi, s[at.B + i], 0.0)
        decide(m, i, at.DAMPED if s[at.CROSSED + i] >= 2.0 else at.CREEP, at.SETTLING_OBSERVED)


observers.register(Recurrence, globals())
