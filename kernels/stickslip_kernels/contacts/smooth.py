"""What contacts without modes share: their motion is one flow, through standstill and back, and nothing ends it.

Such a contact begins a cell by `open_cell`, and handles an event by `commit`; then it sets what is its own: rows WEAK,
DW and JERK of the lane. Its frame is the true one, and w may be negative.
"""

from math import inf, isfinite, isnan, nan

from .. import contacts, observers
from .. import layout as at
from ..drive import belt_in_lane, next_segment, open_drive, segment_is_over, steady_load
from ..jit import compiled
from ..layout import DONE, RUNNING
from .stribeck.slip import displacement_in_lane


@compiled
def open_cell(m, i, c):
    """Put cell c into lane i at (y, w) of its start; DONE if it cannot be computed."""
    s, cells = m.s, m.cells
    for row in range(at.CELL_ROWS):
        if isnan(cells[row, c]) and row != at.ETA_START:
            observers.reject_cell(m, c, at.NOT_FINITE)
            return DONE
    for row in range(0, at.STATE_NUMBERS, at.WIDTH):
        s[row + i] = 0.0
    s[at.CELL + i], s[at.SIGMA + i], s[at.MODE + i], s[at.W_MIN + i] = c, 1.0, at.RISE, 0.0
    s[at.TRIED + i], s[at.PAUSE + i], s[at.G + i] = 0.0, m.max_steps, cells[at.GAMMA, c]
    s[at.OFFSET + i], s[at.SLOPE + i], s[at.DROP + i] = 0.0, 0.0, 0.0
    s[at.LEVEL + i], s[at.SIDE + i], s[at.TURN + i] = -inf, -1.0, 0.0
    s[at.ATTRACTS + i], s[at.FIRMNESS + i], s[at.EVEN + i], s[at.LONGEST + i] = 1.0, 1.0, inf, inf
    s[at.BY_SERIES + i] = 0.0
    open_drive(m, i, c)
    observers.begin_cell(m, i, c)
    u, eta = cells[at.XI_START, c], cells[at.ETA_START, c]
    s[at.W + i] = 0.0 if isnan(eta) else belt_in_lane(m, i, 0.0) - eta
    place(m, i, u)
    observers.observe_slip_begin(m, i, u, s[at.W + i], True)
    return RUNNING


@compiled(inline=True)
def place(m, i, u):
    """Put lane i at u under its belt."""
    rise = m.s[at.ALPHA + i] + m.s[at.G + i] * belt_in_lane(m, i, 0.0)
    m.s[at.Y + i], m.s[at.Y_STAR + i] = u + rise, steady_load(m, i) + rise


@compiled
def commit(m, i):
    """Show the flagged step of lane i to the observer, and commit it; DONE where the cell is finished."""
    s = m.s
    if s[at.FLAG + i] == at.HALTED:
        return give_up(m, i)
    h, w, dw, jerk = s[at.TAKEN + i], s[at.W_NEW + i], s[at.DW_NEW + i], s[at.JERK_NEW + i]
    observers.observe_step(m, i, h, s[at.Y_NEW + i], w, dw, jerk, s[at.WORK + i])
    s[at.TAU + i] += h
    s[at.HEAT + i] += s[at.WORK + i]
    s[at.B + i] += h * s[at.ALPHA + i]
    s[at.Y + i], s[at.W + i], s[at.DW + i], s[at.JERK + i] = s[at.Y_NEW + i], w, dw, jerk
    s[at.WEAK + i], s[at.ERROR_LOG + i] = s[at.WEAK_NEW + i], s[at.ERROR_LOG_NEW + i]
    observers.observe_no_event(m, i)
    if observers.is_over(m, i):
        return close(m, i, s[at.DECIDED_BY + i])
    while segment_is_over(s, i):
        u = displacement_in_lane(m, i, s[at.Y + i], 0.0)
        if not next_segment(m, i):
            return close(m, i, at.HORIZON_REACHED)
        place(m, i, u)
    return RUNNING


@compiled
def close(m, i, status):
    """Finish the cell of lane i, which is slipping."""
    u = displacement_in_lane(m, i, m.s[at.Y + i], 0.0)
    return observers.finish(m, i, status, u, belt_in_lane(m, i, 0.0) - m.s[at.W + i])


@compiled
def give_up(m, i):
    """No further step: the budget is spent, or the step size fell below rounding."""
    s = m.s
    if not (isfinite(s[at.Y + i]) and isfinite(s[at.W + i]) and isfinite(s[at.DW + i])):
        return observers.finish(m, i, at.NOT_FINITE, nan, nan)
    if not s[at.STEP + i] >= contacts.smallest_step(m.contact):
        return observers.finish(m, i, at.STEP_UNDERFLOW, nan, nan)
    return close(m, i, observers.status_out_of_steps(m, i))
