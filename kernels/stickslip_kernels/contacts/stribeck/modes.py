"""The state machine of the contact: stick, rise, fast, fall, hold.

Everything here is scalar and rare: `begin_cell` puts a cell into a lane, `handle_event` looks at a lane whose step met
something. Slip on the curve (`slip.py`: rise, fast) is left to the lanes; stick (`stick.py`), fall and hold
(`hysteresis.py`) are closed forms and pass inside one call. The machine ends modes and segments of the drive; an
observer sees the rest (`observers`). Functions return RUNNING when the lane goes on slipping and DONE when its cell is
finished. `m` is the `Machine`, `i` the lane, `c` the cell; u, w, b are displacement, slip speed and belt speed in the
frame of `layout.py`.
"""

from math import isfinite, isnan, nan
from typing import NamedTuple

from ... import contacts, observers
from ... import layout as at
from ...drive import belt_in_lane, flip, next_segment, open_drive, segment_is_over
from ...jit import compiled
from ...layout import DONE, RUNNING
from ...observers.regime import Regime
from ...observers.settling import has_no_drag, least_drag
from ...observers.spirals import relaxes_from
from ...observers.tops import confirm_slopes, has_exact_derivatives
from ...observers.weak import most_drag
from ...roots import LEVEL_REACHED, NO_EVENT, TURNED, arrival, end_motion, grazes, may_turn, reaches, turn_time
from ..smooth import close
from . import equations, laws, runge_kutta, taylor
from .equations import jerk_in_lane, know_steepness, slope_in_lane, state_at, weakening_in_lane
from .friction import TABLES, coefficient, least_coefficient, speed_of_minimum, stable_speeds
from .hysteresis import fall
from .slip import begin_slip, displacement_in_lane, enter_curve, set_slip
from .stick import stick

# --- starting -------------------------------------------------------------------------------------------------------


@compiled
def begin_cell(m, i, c):
    """Put cell c into lane i and bring it to its first slip."""
    s, cells = m.s, m.cells
    for row in range(at.CELL_ROWS):
        if isnan(cells[row, c]) and row != at.MU_STOP and row != at.ETA_START:
            observers.reject_cell(m, c, at.NOT_FINITE)
            return DONE
    s[at.CELL + i], s[at.SIGMA + i] = c, 1.0
    s[at.W_MIN + i] = 0.0 if isnan(cells[at.MU_STOP, c]) else speed_of_minimum(m.law, cells, c)
    if isnan(s[at.W_MIN + i]):
        observers.reject_cell(m, c, at.HYSTERESIS_UNDEFINED)
        return DONE
    s[at.HEAT + i], s[at.TRIED + i], s[at.PAUSE + i] = 0.0, 0.0, m.max_steps
    s[at.G + i], s[at.RATE + i], s[at.EXPONENT + i] = cells[at.GAMMA, c], 1.0 / cells[at.A4, c], cells[at.DELTA, c]
    know_steepness(m.law, s, i, cells, c)
    open_drive(m, i, c)
    observers.begin_cell(m, i, c)
    xi, eta = cells[at.XI_START, c], cells[at.ETA_START, c]
    relative = 0.0 if isnan(eta) else belt_in_lane(m, i, 0.0) - eta
    if relative == 0.0:
        return stick(m, i, xi, False)
    return start_sliding(m, i, xi, relative)


@compiled
def start_sliding(m, i, xi, relative):
    """Begin in slip: the mode follows from the slip speed and the sign of its derivative on the curve."""
    s, w = m.s, abs(relative)
    if relative < 0.0:
        flip(s, i)
    u = s[at.SIGMA + i] * xi
    begin_slip(m, i, at.FAST if w >= s[at.W_MIN + i] > 0.0 else at.RISE, u, w, False, True)
    if w < s[at.W_MIN + i] and (s[at.DW + i] < 0.0 or (s[at.DW + i] == 0.0 and s[at.JERK + i] < 0.0)):
        return fall(m, i, u, w, s[at.DW + i])
    return RUNNING


# --- attending to a flagged lane ------------------------------------------------------------------------------------


@compiled(inline=True)
def find_event(law, s, i):
    """Return what ends the mode of lane i inside the step it has just tried.

    Returns (kind, time from the step start, y, w, w', friction work up to there); for NO_EVENT the end of the step.
    """
    h, level = s[at.TAKEN + i], s[at.LEVEL + i]
    w1, dw1 = s[at.W_NEW + i], s[at.DW_NEW + i]
    reached = reaches(s, i, w1)
    end, at_end = h, end_motion(s, i)  # the level, if reached, is reached before this
    turns = s[at.TURN + i] > 0.0 and may_turn(s, i, h, dw1)
    if turns or (not reached and grazes(s, i, h, w1, dw1)):
        turn = turn_time(s, i)
        if turn >= 0.0:
            y, w, dw, work = state_at(law, s, i, turn)
            if reaches(s, i, w):
                reached, end, at_end = True, turn, (w, 0.0, 0.0, 0.0)
            elif s[at.TURN + i] > 0.0:
                return TURNED, turn, y, w, 0.0, work
    if not reached:
        return NO_EVENT, h, s[at.Y_NEW + i], w1, dw1, s[at.WORK + i]
    end, rise, work = arrival(s, i, level, end, at_end)
    y = s[at.Y + i] + rise
    return LEVEL_REACHED, end, y, level, slope_in_lane(law, s, i, y, level), work


@compiled(inline=True)
def handle_event(m, i):
    """Look at lane i, whose last step was flagged: observe it, commit it, change the mode, or finish the cell."""
    s = m.s
    if s[at.FLAG + i] == at.HALTED:
        return give_up(m, i)
    kind, h, y, w, dw, work = find_event(m.law, s, i)
    b = s[at.B + i] + h * s[at.ALPHA + i]
    jerk = jerk_in_lane(m.law, s, i, y, w, dw, b)
    observers.observe_step(m, i, h, y, w, dw, jerk, work)
    s[at.TAU + i] += h
    s[at.HEAT + i] += work
    s[at.B + i], s[at.Y + i], s[at.W + i], s[at.DW + i], s[at.JERK + i] = b, y, w, dw, jerk
    s[at.WEAK + i], s[at.ERROR_LOG + i] = s[at.WEAK_NEW + i], s[at.ERROR_LOG_NEW + i]
    if kind == NO_EVENT:
        observers.observe_no_event(m, i)
    else:
        runge_kutta.restart(m.law, s, i, s[at.TAKEN + i])
        if change_mode(m, i, kind) == DONE:
            return DONE
    if observers.is_over(m, i):
        return close(m, i, s[at.DECIDED_BY + i])
    while segment_is_over(s, i):
        if slip_into_next_segment(m, i) == DONE:
            return DONE
    return RUNNING


@compiled
def give_up(m, i):
    """No further step for now: the observer pauses, the budget is spent, or the step size fell below rounding."""
    s = m.s
    finite = isfinite(s[at.Y + i]) and isfinite(s[at.W + i]) and isfinite(s[at.DW + i])
    if finite and s[at.STEP + i] >= at.SMALLEST_STEP:
        if s[at.TRIED + i] < m.max_steps:
            observers.after_pause(m, i)
            return close(m, i, s[at.DECIDED_BY + i]) if observers.is_over(m, i) else RUNNING
        return close(m, i, observers.status_out_of_steps(m, i))
    mu = s[at.OFFSET + i] + s[at.SLOPE + i] * s[at.W + i] + weakening_in_lane(m.law, s, i, s[at.W + i])
    status = at.NEGATIVE_FRICTION if mu < 0.0 else at.STEP_UNDERFLOW if finite else at.NOT_FINITE
    return observers.finish(m, i, status, nan, nan)


@compiled(inline=True)
def change_mode(m, i, kind):
    """The mode of lane i ends at its present state."""
    s, w = m.s, m.s[at.W + i]
    u = displacement_in_lane(m, i, s[at.Y + i], 0.0)
    if observers.observe_mode_end(m, i, u, kind):
        return RUNNING
    if kind == LEVEL_REACHED and s[at.LEVEL + i] == 0.0:
        observers.observe_standstill(m, i, s[at.DW + i])
        return stick(m, i, u, True)
    if kind == LEVEL_REACHED and s[at.MODE + i] == at.RISE:
        enter_curve(m, i, at.FAST, u, w, False)
        return RUNNING
    return fall(m, i, u, w, s[at.DW + i])


@compiled(inline=True)
def slip_into_next_segment(m, i):
    """The acceleration of the belt jumps, and with it w'; the end of the drive ends the cell."""
    s, u, w = m.s, displacement_in_lane(m, i, m.s[at.Y + i], 0.0), m.s[at.W + i]
    if not next_segment(m, i):
        return observers.finish(m, i, at.HORIZON_REACHED, u, belt_in_lane(m, i, 0.0) - w)
    set_slip(m, i, u, w, False)
    runge_kutta.restart(m.law, s, i, s[at.TAKEN + i])
    if s[at.DW + i] < 0.0 and w <= s[at.W_MIN + i]:
        return stick(m, i, u, True) if w == 0.0 else fall(m, i, u, w, s[at.DW + i])
    return RUNNING


# --- the contract of contacts -----------------------------------------------------------------------------------------


class StribeckContact(NamedTuple):
    """Tag of this contact."""

    code: int


TAG, LAWS, REGIMES = StribeckContact(0), laws.LAWS | TABLES, Regime
for _function in (runge_kutta.try_step, runge_kutta.begin_stepping, runge_kutta.restart):
    _function.of(*laws.RECURRENCES)(getattr(taylor, _function.__name__))
LINKED = (
    laws.shape, laws.weakening_slope, laws.last_weakening, laws.hidden_depth, laws.next_station, laws.has_kinks,
    speed_of_minimum, least_coefficient, stable_speeds, has_no_drag, least_drag, most_drag, relaxes_from,
    has_exact_derivatives, confirm_slopes, runge_kutta.try_step, runge_kutta.begin_stepping, runge_kutta.restart,
    equations.extreme_slope,
)  # fmt: skip


def try_step(m):
    runge_kutta.try_step(m.law, m.s, m.rtol)


def steady_friction(contact, law, cells, c, w):
    return coefficient(law, cells, c, w)


def friction(m, i, t, w):
    return m.s[at.OFFSET + i] + m.s[at.SLOPE + i] * w + weakening_in_lane(m.law, m.s, i, w)


def extreme_slope(m, i, h, at_end):
    return equations.extreme_slope(m.law, m.s, i, h, at_end)


contacts.register(StribeckContact, globals())
